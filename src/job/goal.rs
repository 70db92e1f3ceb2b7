//! The proof of a goal: the whole BRDF of the plate set against the goal's, not only the slice that was designed.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;

use super::design::DesignError;
use crate::export::polar_slices::{PolarCurve, STEPS, polar_diagram};
use crate::goal::{Goal, hemisphere_view, in_plane};
use crate::progress::{Progress, Stage};
use crate::raster::Raster;
use crate::recipe::Recipe;
use crate::report::goal::{GoalFacts, GoalSlice, MilledGoalFacts};
use crate::setup::Setup;
use crate::slope::{direction, polar_angle};
use crate::trace::traced_plate::TracedPlate;
use crate::verify::experiment::Measuring;
use crate::verify::measure::Mirrored;
use crate::verify::score::{blurred, distance};
use crate::verify::tally::Tally;
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
    /// Slices through the plane of incidence at the first azimuth, goal and plate, as cut if it has a cutter, f_r in 1/sr.
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
            as_milled: None,
        };
        Self { facts, curves: Vec::new(), azimuth: 0.0 }
    }

    /// Whether there are slices to be drawn.
    pub fn is_traced(&self) -> bool {
        !self.curves.is_empty()
    }

    /// `goal.png`: slices of goal and plate in one diagram.
    pub fn picture(&self) -> image::RgbImage {
        let how = if self.facts.as_milled.is_some() { " as cut" } else { "" };
        let heading = format!("{}: goal dashed, plate{how} solid, mirror share taken as 1", self.facts.spec);
        polar_diagram(&self.curves, self.azimuth, &heading)
    }
}

/// The surfaces that light is sent over.
#[derive(Clone, Copy)]
pub struct GoalPlates<'a> {
    /// The plate as written.
    pub written: &'a TracedPlate,
    /// As its cutter and polish leave it, if it has them.
    pub milled: Option<&'a TracedPlate>,
}

/// Sends light over the plates of `recipe` from polar angles of 0° to 60°, in the lamp's azimuth and, of a goal that is not
/// the same all round, across it, and sets what leaves against `goal`; `designed` is the setup whose slice was designed.
///
/// # Errors
/// No light meets a plate, or it is cancelled.
pub fn prove_goal(
    recipe: &Recipe,
    goal: &Goal,
    designed: &Setup,
    plates: GoalPlates,
    progress: &Progress,
) -> Result<GoalProof, DesignError> {
    progress.stage(Stage::Tracing);
    let mut proof = GoalProof::untraced(goal);
    let mut milled = Vec::new();
    let azimuth = recipe.light.phi.to_radians();
    let turns: &[f64] = if goal.is_isotropic { &[0.0] } else { &[0.0, FRAC_PI_2] };
    for turn in turns {
        for theta in POLAR {
            let light = Lit::new(goal, designed, direction(theta.to_radians(), azimuth + turn));
            let told = |seen: &Compared| GoalSlice { theta, phi: (azimuth + turn).to_degrees(), ..seen.facts };
            let mut seen = light.compared(recipe, plates.written, progress)?;
            proof.facts.slices.push(told(&seen));
            if let Some(plate) = plates.milled {
                seen = light.compared(recipe, plate, progress)?;
                milled.push(told(&seen));
            }
            if *turn == 0.0 {
                let side = |raster: &Raster, dashed| PolarCurve {
                    theta: theta.to_radians(),
                    values: through(raster, azimuth),
                    dashed,
                };
                proof.curves.extend([side(&seen.plate, false), side(&light.wanted.clone().scaled(light.albedo), true)]);
            }
            progress.check()?;
        }
    }
    proof.azimuth = azimuth;
    proof.facts.verdict = Some(verdict(&proof.facts.slices));
    if plates.milled.is_some() {
        let verdict = milled_verdict(recipe, &milled, &proof.facts.slices);
        proof.facts.as_milled = Some(MilledGoalFacts { slices: milled, verdict });
    }
    Ok(proof)
}

/// A goal under one lamp.
struct Lit {
    light: DVec3,
    albedo: f64,
    /// Share of the goal's light in every pixel of the hemisphere, blurred.
    wanted: Raster,
    /// The same of mirrors that make the goal's slice at the design's lamp.
    mirrors: Raster,
}

/// A plate under one lamp beside its goal.
struct Compared {
    facts: GoalSlice,
    /// f_r cosθ dω of every pixel, blurred.
    plate: Raster,
}

/// Every pixel's share of all light, seen through the blur; without light as it is.
fn seen(light: &Raster) -> Raster {
    let shares = if light.sum() > 0.0 { light.clone().normalised() } else { light.clone() };
    blurred(&shares, &hemisphere_view(), MAIN_BLUR.to_radians())
}

/// Share of light that lies elsewhere in one image than in the other: all of it if one is dark.
fn apart(one: &Raster, other: &Raster) -> f64 {
    if one.sum() <= 0.0 || other.sum() <= 0.0 {
        return 1.0;
    }
    0.5 * distance(one, other)
}

impl Lit {
    fn new(goal: &Goal, designed: &Setup, light: DVec3) -> Self {
        let wanted = goal.hemisphere(light, SIDE);
        let mirrors = seen(&goal.mirrored(designed, light, SIDE));
        Self { light, albedo: wanted.sum(), wanted: seen(&wanted), mirrors }
    }

    fn compared(&self, recipe: &Recipe, plate: &TracedPlate, progress: &Progress) -> Result<Compared, DesignError> {
        let Self { light, albedo, wanted, mirrors } = self;
        let setup = Setup::watched(polar_angle(*light), light.y.atan2(light.x), hemisphere_view());
        let measuring = Measuring { resolution: SIDE, ..recipe.measuring() };
        let metal = recipe.metal();
        let hushed = progress.hushed();
        let task = Mirrored { setup: &setup, metal: &metal, measuring: &measuring, progress: &hushed };
        let measured = plate.run(task)?;
        progress.check()?;
        let beside = |tally: &Tally| {
            let seen = seen(&tally.share_image());
            [apart(&seen, wanted), apart(&seen, mirrors)]
        };
        let (values, errors) = (beside(&measured.whole), measured.standard_errors(beside));
        let [tv_1deg, rest] = [0, 1].map(|k| Figure { value: values[k], error: errors[k] });
        let up = measured.whole.up();
        let facts = GoalSlice {
            theta: 0.0,
            phi: 0.0,
            tv_1deg,
            mirrors_cannot: apart(mirrors, wanted),
            rest,
            albedo_goal: *albedo,
            albedo_plate: up,
        };
        Ok(Compared { facts, plate: seen(&measured.whole.share_image()).scaled(up) })
    }
}

/// f_r along the plane of incidence toward `azimuth`, -90° to 90°.
fn through(flux: &Raster, azimuth: f64) -> Vec<f64> {
    let value = |k: usize| {
        let angle = (k as f64 / STEPS as f64 - 0.5) * PI;
        in_plane(flux, angle, azimuth).unwrap_or(0.0)
    };
    (0..=STEPS).map(value).collect()
}

/// The most of `part` under the lamps at `theta` degrees, in per cent.
fn worst(slices: &[GoalSlice], theta: f64, part: fn(&GoalSlice) -> f64) -> String {
    let near = slices.iter().filter(|slice| slice.theta == theta);
    format!("{:.1} %", 100.0 * near.map(part).fold(0.0, f64::max))
}

/// The proof in a sentence.
fn verdict(slices: &[GoalSlice]) -> String {
    let [misplaced, cannot]: [fn(&GoalSlice) -> f64; 2] = [|slice| slice.tv_1deg.value, |slice| slice.mirrors_cannot];
    let told = |part| [0.0, 30.0, 60.0].map(|theta| worst(slices, theta, part));
    let ([a, b, c], [x, y, z]) = (told(misplaced), told(cannot));
    format!(
        "Of the goal's light {a} is misplaced under a lamp at 0°, {b} at 30°, {c} at 60° (blur 1°); {x}, {y} and {z} of it no \
         plate of mirrors could place."
    )
}

/// The proof of the plate as cut in a sentence, beside that of the plate as `designed`.
fn milled_verdict(recipe: &Recipe, milled: &[GoalSlice], designed: &[GoalSlice]) -> String {
    let how = recipe.design.sheet.cutter.map_or("Polished".into(), |cutter| format!("Cut by {cutter}"));
    let told = |slices: &[GoalSlice]| [0.0, 30.0, 60.0].map(|theta| worst(slices, theta, |slice| slice.tv_1deg.value));
    let ([a, b, c], [x, y, z]) = (told(milled), told(designed));
    format!(
        "{how}, the plate misplaces {a} of the goal's light under a lamp at 0°, {b} at 30°, {c} at 60° (blur 1°); as designed \
         {x}, {y} and {z}."
    )
}
