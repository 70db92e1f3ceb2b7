//! What the light of a plate is scored against: a picture, or the goal that a folder's recipe has in place of one.

use std::path::{Path, PathBuf};

use facetmill::goal::spec::GoalSpec;
use facetmill::goal::{Goal, GoalError};
use facetmill::job::exports;
use facetmill::job::goal::{GoalPlates, GoalProof, prove_goal};
use facetmill::job::proof::milled_plate;
use facetmill::memory::MemoryLimit;
use facetmill::picture::Picture;
use facetmill::progress::Progress;
use facetmill::recipe::Recipe;
use facetmill::setup::Setup;

use crate::args::VerifyArgs;
use crate::console::Failure;
use crate::files::{Place, Staged};
use crate::interrupt::Run;
use crate::plates::Opened;
use crate::{inputs, plates};

/// What is wanted of the light.
pub enum Against {
    /// A picture's file.
    Picture(PathBuf),
    /// A goal, its file in place.
    Goal(GoalSpec),
    /// The same, and the field that it needs is to be chosen.
    GoalAndField(GoalSpec),
}

impl Against {
    /// As given, else the picture or the goal of the folder's recipe.
    pub fn new(args: &VerifyArgs, recipe: &Recipe) -> Result<Self, Failure> {
        if let Some(path) = &args.against {
            return Ok(Self::Picture(path.clone()));
        }
        if let Some(goal) = &args.goal {
            // The field of a folder is that of its design.
            let chosen = args.plate.is_dir() || args.settings.has("half-field");
            return Ok(if chosen { Self::Goal(goal.clone()) } else { Self::GoalAndField(goal.clone()) });
        }
        let name = args.plate.display();
        if !args.plate.is_dir() {
            return Err(Failure::Usage(format!(
                "{name}: say with --against which picture its light is to be scored against, or with --goal which reflectance"
            )));
        }
        let found = |named: &Path, what: &str| {
            inputs::near_folder(&args.plate, named).ok_or_else(|| {
                Failure::Input(format!(
                    "{name}: the {what} {} that its recipe names is neither in the folder nor beside it nor here: \
                     say with --against where it is",
                    named.display()
                ))
            })
        };
        if let Some(goal) = &recipe.goal {
            let file = goal.path().map(|path| found(path, "goal's file")).transpose()?;
            return Ok(Self::Goal(file.map_or_else(|| goal.clone(), |file| goal.with_path(file))));
        }
        let Some(named) = recipe.picture_path() else {
            return Err(Failure::Input(format!("{name}: its recipe names no picture: say with --against which it is")));
        };
        Ok(Self::Picture(found(&named, "picture")?))
    }

    /// The file that is to be read, if it is one.
    pub fn path(&self) -> Option<&Path> {
        match self {
            Self::Picture(path) => Some(path),
            Self::Goal(spec) | Self::GoalAndField(spec) => spec.path(),
        }
    }

    /// The picture, or the slice of the goal under the lamp of the setup that `posed` makes of the recipe, and the goal.
    pub fn picture(
        &self,
        recipe: &mut Recipe,
        posed: &dyn Fn(&Recipe) -> Result<Setup, Failure>,
        limit: MemoryLimit,
    ) -> Result<(Picture, Option<Goal>), Failure> {
        let spec = match self {
            Self::Picture(path) => return Ok((inputs::picture(path, &recipe.reading(), limit)?, None)),
            Self::Goal(spec) | Self::GoalAndField(spec) => spec,
        };
        let setup = posed(recipe)?;
        let goal = Goal::read(spec, recipe.goal_part, setup.light())?;
        if matches!(self, Self::GoalAndField(_)) {
            recipe.highlight.half_field = goal.half_field(&setup)?.into();
        }
        Ok((goal.picture(&posed(recipe)?)?, Some(goal)))
    }
}

/// The goal is a recipe's: it, or the file that it names, is to blame.
impl From<GoalError> for Failure {
    fn from(error: GoalError) -> Self {
        Self::Input(error.to_string())
    }
}

/// The whole BRDF of a plate, as it stands in its file and as it is cut, beside the goal; `designed` is the setup for which it
/// was designed.
pub fn goal_proof(
    recipe: &Recipe,
    designed: &Setup,
    goal: &Goal,
    (opened, margin): (&Opened, f64),
    progress: &Progress,
) -> Result<GoalProof, Failure> {
    let milled = milled_plate(recipe, &opened.mesh, margin, progress)?;
    let plates = GoalPlates { written: &opened.plate, milled: milled.as_ref() };
    Ok(prove_goal(recipe, goal, designed, plates, progress)?)
}

/// The folder for the proof's files, if one is named; `read` is not to be replaced.
pub fn folder(args: &VerifyArgs, read: &[&Path], run: &Run) -> Result<Option<Staged>, Failure> {
    let Some(output) = &args.output else { return Ok(None) };
    plates::spare_design(&args.plate, output)?;
    Ok(Some(Staged::new(&Place::new(output, args.running.force, exports::VERIFY, read), &run.gate)?))
}
