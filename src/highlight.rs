//! A drawn highlight as light: what its pixel values mean, and how much flux each asks for.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::projection::View;
use crate::raster::Raster;
use crate::setup::Setup;

/// What a pixel's value says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Quantity {
    /// How bright the plate looks from that direction (the slice of its BRDF).
    #[default]
    Radiance,
    /// Flux per steradian.
    Intensity,
    /// Flux per image pixel; with the screen projection, irradiance on the wall.
    Flux,
}

/// The flux that the highlight asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct Highlight {
    /// Flux per pixel that a plate can send, sum 1: nothing below the plate. Shape of the picture, or finer once sharpened.
    pub flux: Raster,
    /// Share of the picture's light painted where no direction above the plate is.
    pub below_plate: f64,
    /// What the picture's values said.
    pub quantity: Quantity,
}

impl Highlight {
    /// Reads `light` (linear, not negative) as `quantity` over the image of `setup`.
    ///
    /// `None` if no light is painted above the plate.
    pub fn new(light: &Raster, quantity: Quantity, setup: &Setup) -> Option<Self> {
        let uv = |k| View::pixel_centre(k % light.width, k / light.width, light.width, light.height);
        let light = relative(light);
        let mut flux = flux_per_pixel(&light, quantity, setup);
        let reachable: Vec<bool> =
            (0..light.values.len()).into_par_iter().map(|k| setup.viewer_at(uv(k)).is_some()).collect();
        let (mut painted, mut lost) = (0.0, 0.0);
        for (k, &above) in reachable.iter().enumerate() {
            painted += light.values[k];
            if !above {
                lost += light.values[k];
                flux.values[k] = 0.0;
            }
        }
        let total = flux.sum();
        let sound = total > 0.0 && total.is_finite();
        sound.then(|| Self { flux: flux.normalised(), below_plate: lost / painted, quantity })
    }

    /// The same picture asked of a plate that lies as in `mounted` instead of as in `flat`, for which this was read.
    ///
    /// A plate's brightness is seen foreshortened, L = I / cos θo: turned toward a viewer it must send more light there
    /// to look as bright. Other quantities do not ask how the plate lies. Light below the plate as mounted stays.
    pub fn remounted(&self, flat: &Setup, mounted: &Setup) -> Self {
        let mut highlight = self.clone();
        if self.quantity == Quantity::Radiance {
            let Raster { width, height, .. } = self.flux;
            highlight.flux.values.par_iter_mut().enumerate().filter(|(_, flux)| **flux > 0.0).for_each(|(k, flux)| {
                let uv = View::pixel_centre(k % width, k / width, width, height);
                if let (Some(before), Some(after)) = (flat.viewer_at(uv), mounted.viewer_at(uv)) {
                    *flux *= after.z / before.z;
                }
            });
            highlight.flux = highlight.flux.normalised();
        }
        highlight
    }
}

/// The target that measured highlights are scored against: `resolution`² pixels of flux, sum 1.
///
/// The same steps in the same order as the independent referee's, so that figures can be laid side by side:
/// weights at the picture's own resolution, then resampling by areas. As there, [`Quantity::Flux`] keeps
/// light painted below the plate as light that must be missed.
pub fn scored_target(light: &Raster, quantity: Quantity, setup: &Setup, resolution: usize) -> Raster {
    let target = flux_per_pixel(&relative(light), quantity, setup).resampled(resolution, resolution);
    let total = target.sum();
    if total > 0.0 { target.normalised() } else { target }
}

/// `light` in units of its brightest pixel, so that no sum overflows and none is too small to divide by.
fn relative(light: &Raster) -> Raster {
    let brightest = light.max();
    let unit = if brightest > 0.0 { brightest } else { 1.0 };
    Raster { values: light.values.iter().map(|v| v / unit).collect(), ..*light }
}

/// Pixel values times what turns them into flux: I = L cos θo, flux = I dω.
fn flux_per_pixel(light: &Raster, quantity: Quantity, setup: &Setup) -> Raster {
    let (width, height) = (light.width, light.height);
    let values = light
        .values
        .par_iter()
        .enumerate()
        .map(|(k, &value)| {
            let uv = View::pixel_centre(k % width, k / width, width, height);
            let above = || setup.viewer_at(uv).map_or(0.0, |o| o.z);
            let weight = match quantity {
                Quantity::Flux => 1.0,
                Quantity::Intensity if above() > 0.0 => setup.view().solid_angle_density(uv),
                Quantity::Intensity => 0.0,
                Quantity::Radiance => above() * setup.view().solid_angle_density(uv),
            };
            value * weight
        })
        .collect();
    Raster { width, height, values }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projection::Projection;

    #[test]
    fn orthographic_radiance_at_normal_incidence_weighs_all_pixels_alike() {
        // dω cosθ is the projected solid angle, which the orthographic map preserves (Nusselt).
        let setup = Setup::new(0.0, 0.0, 0.0, Projection::Orthographic, 0.5);
        let light = Raster::from_fn(16, 16, |x, y| (x + 2 * y) as f64);
        let highlight = Highlight::new(&light, Quantity::Radiance, &setup).unwrap();
        for (f, l) in highlight.flux.values.iter().zip(&light.values) {
            assert!((f - l / light.sum()).abs() < 1e-15);
        }
        assert_eq!(highlight.below_plate, 0.0);
    }

    #[test]
    fn light_below_the_plate_is_dropped_and_counted() {
        // At 80° with a half field of 20° the outer part of the image is below the horizon.
        let setup = Setup::new(f64::to_radians(80.0), 0.0, 0.0, Projection::Equidistant, f64::to_radians(20.0));
        let light = Raster::from_fn(64, 64, |_, _| 1.0);
        let highlight = Highlight::new(&light, Quantity::Intensity, &setup).unwrap();
        // Mirror of a lamp at +x: the centre leans to -x, so u = -1 is below, and the horizon runs at u = -1/2.
        assert!((highlight.below_plate - 0.25).abs() < 0.02, "{}", highlight.below_plate);
        assert_eq!(highlight.flux.at(0, 32), 0.0);
        assert!(highlight.flux.at(63, 32) > 0.0);
        assert!((highlight.flux.sum() - 1.0).abs() < 1e-12);
        let dark = Raster::from_fn(64, 64, |x, _| f64::from(u8::from(x == 0)));
        assert_eq!(Highlight::new(&dark, Quantity::Intensity, &setup), None);
    }

    #[test]
    fn only_proportions_count_from_the_faintest_pictures_to_the_brightest() {
        let setup = Setup::new(0.4, 1.0, 0.0, Projection::Equidistant, 0.3);
        let light = Raster::from_fn(8, 8, |x, y| (x * y) as f64);
        for quantity in [Quantity::Radiance, Quantity::Intensity, Quantity::Flux] {
            let plain = Highlight::new(&light, quantity, &setup).unwrap();
            for exponent in [-1070, -1000, 1000] {
                let scaled = light.clone().scaled(2f64.powi(exponent / 2)).scaled(2f64.powi(exponent / 2));
                assert_eq!(Highlight::new(&scaled, quantity, &setup).as_ref(), Some(&plain), "2^{exponent}");
                assert_eq!(scored_target(&scaled, quantity, &setup, 4), scored_target(&light, quantity, &setup, 4));
            }
        }
        assert_eq!(Highlight::new(&Raster::zeros(8, 8), Quantity::Flux, &setup), None);
        assert_eq!(Highlight::new(&Raster::zeros(0, 0), Quantity::Flux, &setup), None);
    }

    #[test]
    fn a_remounted_highlight_is_the_one_read_for_that_mounting() {
        let flat = Setup::new(0.3, 2.0, 0.0, Projection::Orthographic, 0.4);
        let mounted = flat.mounted(crate::slope::direction(0.25, -1.0));
        let light = Raster::from_fn(16, 16, |x, y| (x + y * y) as f64);
        for quantity in [Quantity::Radiance, Quantity::Intensity, Quantity::Flux] {
            let read = Highlight::new(&light, quantity, &mounted).unwrap();
            let turned = Highlight::new(&light, quantity, &flat).unwrap().remounted(&flat, &mounted);
            let error =
                read.flux.values.iter().zip(&turned.flux.values).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(error < 1e-15, "{quantity:?}: {error}");
        }
    }
}
