//! How a plate is made, from flags and recipe.

use std::path::Path;

use facetmill::cutter::Cutter;
use facetmill::cutter::library::{Library, SoldCutter};
use facetmill::glam::DVec2;
use facetmill::job::findings::{MadeProof, Proof};
use facetmill::job::made::{Lighting, prove_as_made, prove_as_made_in_room};
use facetmill::job::on_wall::RoomProof;
use facetmill::job::smeared::pass_angle;
use facetmill::memory::{MemoryLimit, Need};
use facetmill::milling::machine::{Machine, PRESETS};
use facetmill::milling::made::Machining;
use facetmill::progress::Progress;
use facetmill::raster::Raster;
use facetmill::recipe::{MachiningSettings, PassAngle, Recipe, RecipeError};
use facetmill::setup::Setup;

use crate::args::{MachineArgs, MachiningArgs};
use crate::console::Failure;
use crate::inputs;
use crate::plates::Opened;
use crate::usage::edits;

/// What a machine is named that is none.
const NONE: &str = "none";

/// Lays the machine that `args` name over `recipe`.
pub fn named(args: &MachineArgs, recipe: &mut Recipe) -> Result<(), Failure> {
    match args.machine.as_deref() {
        None => {}
        Some(NONE) => recipe.machining = MachiningSettings::default(),
        Some(name) => {
            let machine = machine(name)?;
            let sheet = &mut recipe.design.sheet;
            sheet.polish = sheet.polish.or(machine.polish);
            recipe.machining.machine = Some(machine);
        }
    }
    Ok(())
}

/// What `args` and the `settings` of making ask for, for the plate of `recipe`, if a machine is named.
pub fn of(args: &MachiningArgs, settings: &MachiningSettings, recipe: &Recipe) -> Result<Option<Machining>, Failure> {
    let named = cutter("cutter", args.cutter.as_deref(), args.by.cutters.as_deref())?;
    let (cutter, polish) = (named.or(recipe.cutter()), args.polish.or(recipe.design.sheet.polish));
    let usage = |error| Failure::Usage(format!("--{error}"));
    let machining = settings.machining(cutter, polish, recipe.design.seed).map_err(usage)?;
    let alone = if args.cutter.is_some() { "--cutter" } else { "--polish" };
    if machining.is_none() && (args.cutter.is_some() || args.polish.is_some()) {
        return Err(Failure::Usage(format!(
            "{alone} is for a plate that a machine makes: name one with --machine too"
        )));
    }
    Ok(machining)
}

/// The same, if the light of what it makes can be proved.
pub fn proved(
    args: &MachiningArgs,
    settings: &MachiningSettings,
    recipe: &Recipe,
) -> Result<Option<Machining>, Failure> {
    let machining = of(args, settings, recipe)?;
    if recipe.is_near() && machining.as_ref().is_some_and(|machining| machining.polish.is_none()) {
        return Err(Failure::Usage(format!("--{}", RecipeError::BareNearby)));
    }
    Ok(machining)
}

/// The cutters that are known by name: those that are sold, and over them those of a file.
pub fn library(file: Option<&Path>) -> Result<Library, Failure> {
    let sold = Library::built_in();
    Ok(match file {
        Some(file) => sold.with(inputs::cutters(file)?),
        None => sold,
    })
}

/// What `--flag` gives, if it is given: a cutter by its shape, or by its name in the library with those of a file.
pub fn cutter(flag: &str, text: Option<&str>, file: Option<&Path>) -> Result<Option<SoldCutter>, Failure> {
    match (text, file) {
        (Some(text), file) => by_name(flag, text, file).map(Some),
        (None, Some(_)) => Err(Failure::Usage(format!("--cutters: say with --{flag} which of them is meant"))),
        (None, None) => Ok(None),
    }
}

/// The cutter that `text`, which `--flag` gives, is the shape or the name of.
pub fn by_name(flag: &str, text: &str, file: Option<&Path>) -> Result<SoldCutter, Failure> {
    let library = library(file)?;
    if let Some(cutter) = library.get(text) {
        return Ok(*cutter);
    }
    if text.contains(':') {
        let shape = text.parse::<Cutter>().map_err(|error| Failure::Usage(format!("--{flag}: {error}")))?;
        return Ok(shape.into());
    }
    let near = |name: &&str| 2 * edits(text, name) <= name.chars().count();
    let nearest = library.iter().map(|(name, _)| name).filter(near).min_by_key(|name| edits(text, name));
    let meant = nearest.map(|name| format!(": did you mean {name}?")).unwrap_or_default();
    Err(Failure::Usage(format!(
        "--{flag}: '{text}' is neither a shape, such as ball:0.5, nor a cutter that is known by name{meant} (facetmill cutters \
         lists them)"
    )))
}

/// Lays the cutter that `--for-cutter` gives over `recipe`, with what is known of it.
pub fn cut_for(text: Option<&str>, args: &MachineArgs, recipe: &mut Recipe) -> Result<(), Failure> {
    if let Some(cutter) = cutter("for-cutter", text, args.cutters.as_deref())? {
        recipe.take_cutter(&cutter);
    }
    Ok(())
}

/// A preset, or what a file says.
pub fn machine(name: &str) -> Result<Machine, Failure> {
    if let Some(machine) = Machine::preset(name) {
        return Ok(machine);
    }
    let path = Path::new(name);
    if !path.exists() {
        let presets = PRESETS.join(", ");
        return Err(Failure::Usage(format!("--machine: '{name}' is neither a file nor one of {presets}, {NONE}")));
    }
    inputs::machine(path)
}

/// A plate to be made and proved.
pub struct Task {
    /// How.
    machining: Machining,
    /// In how many draws of the machine's errors.
    draws: u64,
    /// Its optical area, mm.
    plate: DVec2,
}

impl Task {
    /// Refuses, before any work, a plate of `plate` mm that cannot be made so.
    pub fn new(machining: Machining, draws: Option<u64>, plate: DVec2, limit: MemoryLimit) -> Result<Self, Failure> {
        machining.check(plate).map_err(|error| Failure::Impossible(error.to_string()))?;
        let remedy = "take a wider --stepover or --polish, or a smaller plate";
        limit.admit(Need::new(machining.bytes(plate), "the surface as made", remedy))?;
        Ok(Self { machining, draws: draws.unwrap_or(1), plate })
    }

    /// The same along the direction that `recipe`, made as `settings` say, is found to be best made for the drawing's `light`, if
    /// that is asked for.
    pub fn along_best(
        mut self,
        recipe: &Recipe,
        settings: &MachiningSettings,
        light: &Raster,
    ) -> Result<Self, Failure> {
        let recipe = Recipe { machining: settings.clone(), ..recipe.clone() };
        let found = pass_angle(&recipe, light)?.map_or(0.0, PassAngle::degrees);
        self.machining.passes.angle = found.to_radians();
        Ok(self)
    }

    /// Light over the opened plate, whose rim of `margin` mm is no optical area, as it is made, for the drawing's `light`;
    /// `proof` has its target and the light of that rim.
    pub fn done(
        &self,
        (recipe, opened, margin): (&Recipe, &Opened, f64),
        (light, proof, setup): (&Raster, &Proof, &Setup),
        progress: &Progress,
    ) -> Result<MadeProof, Failure> {
        let lighting = Lighting::new(recipe, setup);
        let plate = (&opened.mesh, self.plate, margin);
        let (rim, mirrored) = (proof.rim.as_ref(), lighting.mirrored(progress));
        if let Some(wall) = &proof.wall {
            let room = RoomProof { recipe, light, scene: &wall.scene, mirrored };
            return Ok(prove_as_made_in_room(&self.machining, plate, &room, rim, self.draws)?);
        }
        Ok(prove_as_made(&self.machining, plate, lighting.seen(&proof.target, rim), self.draws, mirrored)?)
    }
}
