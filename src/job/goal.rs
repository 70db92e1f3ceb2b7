//! The proof of a goal: the whole BRDF of the plate set against the goal's, not only the slice that was designed.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;

use super::design::{Design, DesignError};
use crate::export::polar_slices::{PolarCurve, STEPS, polar_diagram};
use crate::goal::{Goal, hemisphere_view, in_plane};
use crate::progress::{Progress, Stage};
use crate::raster::Raster;
use crate::recipe::Recipe;
use crate::report::goal::{GoalFacts, GoalSlice};
use crate::setup::Setup;
use crate::slope::{direction, polar_angle};
use crate::trace::grid::GridSurface;
use crate::trace::traced_plate::{Task, TracedPlate};
use crate::verify::experiment::Measuring;
use crate::verify::measure::Mirrored;
use crate::verify::score::{blurred, blurred_scores};
use crate::verify::tally::Measurement;
use crate::verify::verdict::{Figure, MAIN_BLUR};

/// Polar angles of the light at which a plate is set against its goal, degrees from the plate's normal.
const POLAR: [f64; 5] = [0.0, 15.0, 30.0, 45.0, 60.0];

/// Pixels a side of the hemisphere: 0.7° each, as fine as the blur asks for.
const SIDE: usize = 256;

/// A goal, what came of it, and the slices of both.
#[derive(Clone, Debug)]
pub struct GoalProof {
    /// The figures.
    pub facts: GoalFacts,
    /// Slices through the plane of incidence at the first azimuth, goal and plate, f_r in 1/sr.
    curves: Vec<PolarCurve>,
    /// Of that plane, radians.
    azimuth: f64,
}

impl GoalProof {
    /// Without a plate traced: what was asked for, and what mirrors leave out.
    pub fn untraced(goal: &Goal) -> Self {
        let [all, wanted] = goal.albedos(goal.light());
        let facts = GoalFacts {
            spec: goal.spec.to_string(),
            part: goal.part,
            albedo: all,
            left_out: if all > 0.0 { (1.0 - wanted / all).max(0.0) } else { 0.0 },
            slices: Vec::new(),
            verdict: None,
        };
        Self { facts, curves: Vec::new(), azimuth: 0.0 }
    }

    /// Whether there are slices to be drawn.
    pub fn is_traced(&self) -> bool {
        !self.curves.is_empty()
    }

    /// `goal.png`: slices of goal and plate in one diagram.
    pub fn picture(&self) -> image::RgbImage {
        let heading = format!("{}: goal dashed, plate solid, mirror share taken as 1", self.facts.spec);
        polar_diagram(&self.curves, self.azimuth, &heading)
    }
}

/// Sends light over the plate of `recipe` from polar angles of 0° to 60°, in the lamp's azimuth and, of a goal that is not the
/// same all round, across it, and sets what leaves against `goal`.
///
/// # Errors
/// The plate cannot be traced, no light meets it, or it is cancelled.
pub fn prove_goal(
    recipe: &Recipe,
    design: &Design,
    goal: &Goal,
    progress: &Progress,
) -> Result<GoalProof, DesignError> {
    progress.stage(Stage::Tracing);
    let mut proof = GoalProof::untraced(goal);
    let azimuth = recipe.light.phi.to_radians();
    let turns: &[f64] = if goal.is_isotropic { &[0.0] } else { &[0.0, FRAC_PI_2] };
    for turn in turns {
        for theta in POLAR {
            let light = direction(theta.to_radians(), azimuth + turn);
            let slice = compared(recipe, design, goal, light, progress)?;
            let told = GoalSlice { theta, phi: (azimuth + turn).to_degrees(), ..slice.facts };
            if *turn == 0.0 {
                let side = |raster: &Raster, dashed| PolarCurve {
                    theta: theta.to_radians(),
                    values: through(raster, azimuth),
                    dashed,
                };
                proof.curves.extend([side(&slice.plate, false), side(&slice.goal, true)]);
            }
            proof.facts.slices.push(told);
            progress.check()?;
        }
    }
    proof.azimuth = azimuth;
    proof.facts.verdict = Some(verdict(&proof.facts));
    Ok(proof)
}

/// Goal and plate under one lamp, as f_r cosθ dω of every pixel, blurred.
struct Compared {
    facts: GoalSlice,
    goal: Raster,
    plate: Raster,
}

fn compared(
    recipe: &Recipe,
    design: &Design,
    goal: &Goal,
    light: DVec3,
    progress: &Progress,
) -> Result<Compared, DesignError> {
    let designed = &design.distribution.setup;
    let theta = polar_angle(light);
    let setup = Setup::watched(theta, light.y.atan2(light.x), hemisphere_view());
    let measuring = Measuring { resolution: SIDE, ..recipe.measuring() };
    let metal = recipe.metal();
    let hushed = progress.hushed();
    let task = Mirrored { setup: &setup, metal: &metal, measuring: &measuring, progress: &hushed };
    let measured = over(recipe, design, task)?;
    progress.check()?;
    let view = hemisphere_view();
    let wanted = goal.hemisphere(light, SIDE);
    let mirrors = goal.mirrored(designed, light, SIDE);
    let apart = |image: &Raster, target: &Raster| {
        let scores = blurred_scores(image, 1.0, &target.clone().normalised(), &view, MAIN_BLUR.to_radians());
        scores.map_or(1.0, |scores| scores.tv)
    };
    let against = |target: &Raster| {
        let error = measured.standard_errors(|tally| [apart(&tally.share_image(), target)]);
        Figure { value: apart(&measured.whole.share_image(), target), error: error[0] }
    };
    let up = measured.whole.up();
    let see = |raster: &Raster| blurred(raster, &view, MAIN_BLUR.to_radians());
    let facts = GoalSlice {
        theta: 0.0,
        phi: 0.0,
        tv_1deg: against(&wanted),
        mirrors_cannot: apart(&mirrors, &wanted),
        rest: against(&mirrors),
        albedo_goal: wanted.sum(),
        albedo_plate: up,
    };
    Ok(Compared { facts, goal: see(&wanted), plate: see(&measured.whole.share_image().scaled(up)) })
}

/// Light over the plate's optical area.
fn over(recipe: &Recipe, design: &Design, task: Mirrored) -> Result<Measurement, DesignError> {
    let progress = task.progress;
    Ok(match &design.sheet {
        None => task.on(&GridSurface::new(&design.relief, progress)?)?,
        Some(_) => TracedPlate::new(&design.mesh, recipe.plate.border, progress)?.run(task)?,
    })
}

/// f_r along the plane of incidence toward `azimuth`, -90° to 90°.
fn through(flux: &Raster, azimuth: f64) -> Vec<f64> {
    let value = |k: usize| {
        let angle = (k as f64 / STEPS as f64 - 0.5) * PI;
        in_plane(flux, angle, azimuth).unwrap_or(0.0)
    };
    (0..=STEPS).map(value).collect()
}

/// The proof in a sentence.
fn verdict(facts: &GoalFacts) -> String {
    let near = |theta: f64| facts.slices.iter().filter(move |slice| slice.theta == theta);
    let worst = |theta: f64, part: fn(&GoalSlice) -> f64| near(theta).map(part).fold(0.0, f64::max);
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    format!(
        "Of the goal's light {} is misplaced under a lamp at 0°, {} at 30°, {} at 60° (blur 1°); {}, {} and {} of it no plate \
         of mirrors could place.",
        percent(worst(0.0, |slice| slice.tv_1deg.value)),
        percent(worst(30.0, |slice| slice.tv_1deg.value)),
        percent(worst(60.0, |slice| slice.tv_1deg.value)),
        percent(worst(0.0, |slice| slice.mirrors_cannot)),
        percent(worst(30.0, |slice| slice.mirrors_cannot)),
        percent(worst(60.0, |slice| slice.mirrors_cannot)),
    )
}
