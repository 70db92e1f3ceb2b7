//! How a plate is made, from flags and recipe.

use std::path::Path;

use facetmill::glam::DVec2;
use facetmill::job::findings::MadeProof;
use facetmill::job::made::prove_as_made;
use facetmill::memory::{MemoryLimit, Need};
use facetmill::milling::machine::{Machine, PRESETS};
use facetmill::milling::made::Machining;
use facetmill::milling::passes::Passes;
use facetmill::progress::Progress;
use facetmill::raster::Raster;
use facetmill::recipe::Recipe;
use facetmill::setup::Setup;
use facetmill::verify::measure::Mirrored;

use crate::args::MachiningArgs;
use crate::console::Failure;
use crate::inputs;
use crate::plates::Opened;

/// Passes so many standard deviations of the polish apart leave nothing of their cusps.
const CUSPS_GONE: f64 = 2.0;

/// Of a cutter that is not polished after, the passes for each diameter: cusps then cost about as much as a good machine.
const PASSES_A_DIAMETER: f64 = 50.0;

/// What `args` ask for, if they name a machine.
pub fn of(args: &MachiningArgs, recipe: &Recipe) -> Result<Option<Machining>, Failure> {
    let Some(name) = &args.machine else { return Ok(None) };
    if recipe.is_near() {
        return Err(Failure::Usage(
            "--machine: the proof as made is for lamps and walls far away; leave the scene's flags out".into(),
        ));
    }
    let machine = machine(name)?;
    let cutter = args.cutter.or(recipe.design.sheet.cutter).ok_or_else(|| {
        Failure::Usage("--machine: say with --cutter what it cuts with, such as ball:0.5; the recipe names none".into())
    })?;
    let polish = args.polish.or(recipe.design.sheet.polish).filter(|polish| *polish != 0.0);
    let usual = match polish {
        Some(sigma) => (CUSPS_GONE * sigma).min(0.5 * cutter.reach()),
        None => cutter.tip_diameter() / PASSES_A_DIAMETER,
    };
    let angle = args.pass_angle.unwrap_or(0.0);
    if !(-360.0..=360.0).contains(&angle) {
        return Err(Failure::Usage(format!("--pass-angle is {angle}: it must be from -360 to 360")));
    }
    let passes = Passes { angle: angle.to_radians(), stepover: args.stepover.unwrap_or(usual), zigzag: args.zigzag };
    Ok(Some(Machining { machine, cutter, passes, polish, seed: recipe.design.seed }))
}

/// A preset, or what a file says.
fn machine(name: &str) -> Result<Machine, Failure> {
    if let Some(machine) = Machine::preset(name) {
        return Ok(machine);
    }
    let path = Path::new(name);
    if !path.exists() {
        let presets = PRESETS.join(", ");
        return Err(Failure::Usage(format!("--machine: '{name}' is neither a file nor one of {presets}")));
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
    pub fn new(machining: Machining, draws: u64, plate: DVec2, limit: MemoryLimit) -> Result<Self, Failure> {
        machining.check(plate).map_err(|error| Failure::Impossible(error.to_string()))?;
        let remedy = "take a wider --stepover or --polish, or a smaller plate";
        limit.admit(Need::new(machining.bytes(plate), "the surface as made", remedy))?;
        Ok(Self { machining, draws, plate })
    }

    /// Light over the opened plate, whose rim of `margin` mm is no optical area, as it is made.
    pub fn done(
        &self,
        (recipe, opened, margin): (&Recipe, &Opened, f64),
        (target, setup): (&Raster, &Setup),
        progress: &Progress,
    ) -> Result<MadeProof, Failure> {
        let metal = recipe.metal();
        let measuring = recipe.measuring();
        let mirrored = Mirrored { setup, metal: &metal, measuring: &measuring, progress };
        let blur = recipe.blur(setup);
        Ok(prove_as_made(
            &self.machining,
            (&opened.mesh, self.plate, margin),
            (target, blur.as_ref()),
            self.draws,
            mirrored,
        )?)
    }
}
