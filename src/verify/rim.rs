//! Light of the rim around the optical area, counted apart: what it adds to the image, as shares of the light on that area.

use glam::{DVec2, DVec3};

use super::experiment::{Experiment, HighlightImage, Measuring};
use super::follow::follow_to_sensor;
use super::measure::Mirrored;
use super::tally::{Measurement, Tally};
use super::thrown::{Throwing, within_picture};
use super::verdict::Figure;
use crate::progress::Cancelled;
use crate::scene::Scene;
use crate::trace::traced_plate::Task;
use crate::trace::{Hit, PieceKind, Surface};

/// Rays over plate and rim at the most: a rim is a few planes, and its share of the light is known to a thousandth.
const RAYS: u64 = 500_000;

/// Light of the rim, as if it were polished like the rest.
#[derive(Clone, Debug, PartialEq)]
pub struct RimLight {
    parts: Vec<Tally>,
}

/// Sends light over the rim `width` mm wide around the optical area of a plate.
#[derive(Clone, Copy)]
pub struct OverRim<'a> {
    /// What is done with the light of the optical area.
    pub mirrored: Mirrored<'a>,
    /// Width of the rim, mm.
    pub width: f64,
    /// Lamp and wall, if the light is collected on one: then as [`Throwing`] does.
    pub scene: Option<&'a Scene>,
}

impl Task for OverRim<'_> {
    type Output = Result<RimLight, Cancelled>;

    fn on<S: Surface>(self, surface: &S) -> Self::Output {
        let Mirrored { setup, metal, measuring, progress } = self.mirrored;
        let rim = RimOf { surface, width: self.width };
        if let Some(scene) = self.scene {
            let measuring = Measuring { rays: measuring.rays.min(RAYS), ..*measuring };
            let throwing = Throwing { scene, metal, measuring: &measuring, within: None, progress };
            let parts = throwing.on(&rim).map(Measurement::into_parts).unwrap_or_default();
            progress.check()?;
            return Ok(RimLight { parts });
        }
        let experiment = Experiment { material: metal.clone(), ..Experiment::new(&rim, setup) };
        let sensor = HighlightImage { setup, resolution: measuring.resolution };
        let measuring = Measuring { rays: measuring.rays.min(RAYS), ..*measuring };
        Ok(RimLight { parts: follow_to_sensor(&experiment, &sensor, &measuring, |_| true, progress)? })
    }
}

impl RimLight {
    /// The measurement of the optical area with this light over its image.
    pub fn over(&self, measurement: Measurement) -> Measurement {
        measurement.with_rim(&self.parts)
    }

    /// What of it falls within the picture, where it was collected on a wall.
    pub fn within_picture(&self) -> Self {
        let parts = Measurement::of_parts(self.parts.clone()).map(|light| within_picture(&light).into_parts());
        Self { parts: parts.unwrap_or_default() }
    }

    /// Light on the rim, as a share of that on the optical area of `measurement`.
    pub fn lit(&self, measurement: &Measurement) -> f64 {
        self.parts.iter().map(|part| part.incident).sum::<f64>() / measurement.whole.incident
    }

    /// What of it falls into the image, as a share of the light on the optical area of `measurement`.
    pub fn in_image(&self, measurement: &Measurement) -> Figure {
        let whole = self.over(measurement.clone());
        let share = |tally: &Tally| [tally.rim.as_ref().map_or(0.0, |rim| rim.sum()) / tally.incident];
        Figure { value: share(&whole.whole)[0], error: whole.standard_errors(share)[0] }
    }
}

/// A plate of which only the rim is lit.
struct RimOf<'a, S> {
    surface: &'a S,
    width: f64,
}

impl<S: Surface> Surface for RimOf<'_, S> {
    type Place = S::Place;

    fn first(&self, origin: DVec3, direction: DVec3) -> Option<Hit<S::Place>> {
        let (low, high) = self.surface.optical_area();
        let on_rim = |hit: &Hit<S::Place>| {
            let at = hit.point.truncate();
            (at.cmplt(low) | at.cmpgt(high)).any()
        };
        self.surface.first(origin, direction).filter(on_rim)
    }

    fn next(&self, from: &Hit<S::Place>, direction: DVec3) -> Option<Hit<S::Place>> {
        self.surface.next(from, direction)
    }

    fn normal(&self, place: S::Place) -> DVec3 {
        self.surface.normal(place)
    }

    fn kind(&self, place: S::Place) -> PieceKind {
        self.surface.kind(place)
    }

    fn optical_area(&self) -> (DVec2, DVec2) {
        let (low, high) = self.surface.optical_area();
        (low - self.width, high + self.width)
    }

    fn height_range(&self) -> (f64, f64) {
        self.surface.height_range()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::material::Material;
    use crate::progress::Progress;
    use crate::projection::Projection;
    use crate::relief::faceted::{Facet, FacetedRelief};
    use crate::relief::rim::Rim;
    use crate::setup::Setup;
    use crate::slope::Slope;
    use crate::trace::grid::GridSurface;

    #[test]
    fn a_flat_rim_adds_its_area_to_the_middle_and_a_sloped_one_nothing() {
        let setup = Setup::new(0.3, 1.0, 0.0, Projection::Screen, 0.3);
        // A plane that throws its light aside by 10°.
        let facets = vec![Facet { height: 0.0, slope: Slope::new(f64::to_radians(5.0).tan(), 0.0) }];
        let relief = FacetedRelief::uniform(1, 1, DVec2::new(30.0, 20.0), facets);
        let measuring = Measuring { rays: 480_000, ..Measuring::default() };
        let progress = Progress::silent();
        let mirrored = Mirrored { setup: &setup, metal: &Material::MIRROR, measuring: &measuring, progress: &progress };
        let of = |rim: Rim| {
            let surface = GridSurface::new(&relief.with_rim(rim), &progress).unwrap();
            let measurement = mirrored.on(&surface).unwrap();
            let light = OverRim { mirrored, width: 3.0, scene: None }.on(&surface).unwrap();
            let alone = measurement.whole.lit_image().sum();
            (light.in_image(&measurement), light.lit(&measurement), light.over(measurement), alone)
        };
        let (flat, lit, whole, alone) = of(3.0.into());
        // The relief, which rises from its foot to 2.6 mm, shades what of the rim lies behind it.
        let area = 36.0 * 26.0 / 600.0 - 1.0;
        assert!(flat.value < area && flat.value > area - 0.06, "{flat:?} {area}");
        // What of its light meets the relief's foot is thrown elsewhere.
        assert!(flat.error < 0.005 && (0.0..0.05).contains(&(lit - flat.value)), "{flat:?} {lit}");
        let middle = whole.whole.lit_image().at(128, 127) + whole.whole.lit_image().at(127, 128);
        assert!(whole.whole.lit_image().max() > 0.5 && middle < 2.0);
        let added = whole.whole.lit_image().sum() - alone;
        assert!((added - flat.value).abs() < 1e-9, "{added} {flat:?} {alone}");
        let (shares, blocked) = (whole.whole.share_image().sum(), whole.whole.blocked());
        assert!((0.0..0.05).contains(&(1.0 - shares)) && blocked.abs() < 1e-9, "{shares} {blocked}");
        let sloped = of(Rim::past_image(&setup, 3.0, 0.03));
        assert!(sloped.0.value < 0.002 && sloped.1 > 0.3, "{:?} {}", sloped.0, sloped.1);
    }
}
