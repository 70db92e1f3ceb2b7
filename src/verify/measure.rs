//! Light over a surface, collected as a highlight image: rays, bounces, and where they end.
//!
//! The accounting is that of the independent referee. Rays come in on a jittered grid above the plate; a ray is
//! incident if the first thing that it meets is relief or an inner wall inside the optical area. Every share is a
//! share of incident flux. Where a smooth facet under a point of light sends its beam is known without rays: then rays
//! only find what shadows and further bounces change.

use super::experiment::{Experiment, HighlightImage, Measuring, Sensor};
use super::first_bounce;
use super::follow::follow_to_sensor;
use super::tally::{MeasureError, Measurement};
use crate::brdf::material::Material;
use crate::progress::Progress;
use crate::setup::Setup;
use crate::trace::Surface;
use crate::trace::traced_plate::Task;

/// Rounds of a measurement that is to reach an error, each as long as all before it.
const MOST_ROUNDS: u32 = 12;

/// Sends light over the surface and collects it in the highlight image of its setup.
///
/// Fails if no ray met the optical area.
pub fn measure<S: Surface>(
    experiment: &Experiment<'_, S>,
    measuring: &Measuring,
    progress: &Progress,
) -> Result<Measurement, MeasureError> {
    let sensor = HighlightImage { setup: experiment.setup, resolution: measuring.resolution };
    collect(experiment, &sensor, measuring, progress)
}

/// Any plate of some metal under the setup's own round lamp: [`measure`] for [`TracedPlate::run`](crate::trace::traced_plate::TracedPlate::run).
#[derive(Clone, Copy)]
pub struct Mirrored<'a> {
    /// Light and image.
    pub setup: &'a Setup,
    /// What the plate is made of.
    pub metal: &'a Material,
    /// How finely.
    pub measuring: &'a Measuring,
    /// Who listens.
    pub progress: &'a Progress<'a>,
}

impl Task for Mirrored<'_> {
    type Output = Result<Measurement, MeasureError>;

    fn on<S: Surface>(self, surface: &S) -> Self::Output {
        let experiment = Experiment { material: self.metal.clone(), ..Experiment::new(surface, self.setup) };
        measure(&experiment, self.measuring, self.progress)
    }
}

/// Sends light over the surface and collects it on `sensor`; the same for any number of threads.
///
/// Fails if no ray met the optical area.
pub fn collect<S: Surface, C: Sensor>(
    experiment: &Experiment<'_, S>,
    sensor: &C,
    measuring: &Measuring,
    progress: &Progress,
) -> Result<Measurement, MeasureError> {
    until_error(measuring, |measuring| round(experiment, sensor, measuring, progress))
}

/// One round, and if an error is asked for, more of them with other random numbers until it is reached.
pub(super) fn until_error(
    measuring: &Measuring,
    round: impl Fn(&Measuring) -> Result<Measurement, MeasureError>,
) -> Result<Measurement, MeasureError> {
    let mut measurement = round(measuring)?;
    let Some(error) = measuring.error else { return Ok(measurement) };
    for k in 0..MOST_ROUNDS {
        if measurement.image_noise() <= error {
            break;
        }
        let seed = measuring.seed.wrapping_add(u64::from(k + 1) << 32);
        measurement.merge(&round(&Measuring { rays: measuring.rays << k, seed, ..*measuring })?);
    }
    Ok(measurement)
}

fn round<S: Surface, C: Sensor>(
    experiment: &Experiment<'_, S>,
    sensor: &C,
    measuring: &Measuring,
    progress: &Progress,
) -> Result<Measurement, MeasureError> {
    let one_direction = experiment.lamp.only_direction();
    let parts = match one_direction.filter(|_| experiment.material.is_smooth() && experiment.surface.facets() > 0) {
        Some(light) => first_bounce::parts(experiment, light, sensor, measuring, progress)?,
        None => follow_to_sensor(experiment, sensor, measuring, |_| true, progress)?,
    };
    Measurement::of_parts(parts)
}
