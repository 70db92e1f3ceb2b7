//! A goal laid out: its slice at the lamp as a picture, over the hemisphere, and what mirrors would make of it elsewhere.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::{Goal, GoalError};
use crate::picture::Picture;
use crate::projection::{Projection, View};
use crate::raster::Raster;
use crate::setup::Setup;
use crate::slope::mirror;

/// Pixels a side of the slice: 0.15° each over a field of 75°.
const SIDE: usize = 512;
/// Samples a side of a pixel.
const WITHIN: usize = 3;
/// Share of the lobe's light that the field holds where none is asked for.
const HELD: f64 = 0.99;
/// Pixels a side of the hemisphere on which fields are chosen.
const COARSE: usize = 360;
/// Widest field that is chosen, degrees; light at grazing directions is hardly seen.
const WIDEST: f64 = 85.0;

impl Goal {
    /// The slice at the setup's lamp, how bright the plate looks from each direction of its image.
    ///
    /// # Errors
    /// No light in it.
    pub fn picture(&self, setup: &Setup) -> Result<Picture, GoalError> {
        let light = setup.light();
        let row = |y: usize| {
            (0..SIDE).map(move |x| within(x, y, SIDE, |uv| setup.viewer_at(uv).map_or(0.0, |o| self.value(light, o))))
        };
        let values: Vec<f64> = (0..SIDE).into_par_iter().flat_map_iter(row).collect();
        let light = Raster { width: SIDE, height: SIDE, values };
        if light.max() <= 0.0 {
            return Err(GoalError::Dark);
        }
        Ok(Picture { light, notes: self.notes.clone(), original_size: (SIDE, SIDE) })
    }

    /// The half field, degrees, in half degrees, that holds 99 % of the slice's light, seen from the plate under `setup`'s lamp.
    ///
    /// # Errors
    /// No light in it.
    pub fn half_field(&self, setup: &Setup) -> Result<f64, GoalError> {
        // Asked of a view of some field: places on its plane scale with it.
        let projection = setup.view().projection();
        let view = View::new(projection, 1.0, setup.view().centre());
        let unit = match projection {
            Projection::Orthographic => 1f64.sin(),
            Projection::Equidistant => 1.0,
            Projection::Screen => 1f64.tan(),
        };
        let flux = self.hemisphere(setup.light(), COARSE);
        let sky = hemisphere_view();
        let mut reached: Vec<(f64, f64)> = flux
            .values
            .iter()
            .enumerate()
            .filter(|(_, flux)| **flux > 0.0)
            .map(|(k, flux)| {
                let o = sky.inverse(View::pixel_centre(k % COARSE, k / COARSE, COARSE, COARSE));
                let at = o.and_then(|o| view.forward(o)).map_or(f64::INFINITY, |uv| uv.abs().max_element() * unit);
                (at, *flux)
            })
            .collect();
        reached.sort_by(|a, b| a.0.total_cmp(&b.0));
        let whole: f64 = reached.iter().map(|(_, flux)| flux).sum();
        if whole <= 0.0 {
            return Err(GoalError::Dark);
        }
        let mut held = 0.0;
        let edge = reached.iter().find(|(_, flux)| {
            held += flux;
            held >= HELD * whole
        });
        let length = edge.map_or(f64::INFINITY, |(length, _)| *length);
        let angle = match projection {
            Projection::Orthographic => length.min(1.0).asin(),
            Projection::Equidistant => length,
            Projection::Screen => length.atan(),
        };
        Ok(((2.0 * angle.to_degrees()).ceil() / 2.0).clamp(0.5, WIDEST))
    }

    /// Flux per pixel for light of irradiance 1 from `light` over the whole hemisphere, `side`² pixels of
    /// [`hemisphere_view`]; its sum is the albedo of the wanted part.
    pub fn hemisphere(&self, light: DVec3, side: usize) -> Raster {
        flux(side, |o| self.value(light, o))
    }

    /// Albedo of all of it at `light`, and of the wanted part.
    pub fn albedos(&self, light: DVec3) -> [f64; 2] {
        let all = flux(COARSE, |o| (self.all)(light, o).max(0.0));
        [all.sum(), self.hemisphere(light, COARSE).sum()]
    }

    /// The same as [`hemisphere`](Self::hemisphere) of mirrors that make exactly the slice in the image of `setup`: facets
    /// as many as it asks for, looked at under another light, none of them hidden.
    pub fn mirrored(&self, setup: &Setup, light: DVec3, side: usize) -> Raster {
        let first = setup.light();
        flux(side, |o| {
            let m = (light + o).normalize_or(DVec3::Z);
            let seen = mirror(first, m);
            let inside = || setup.image_of(seen).is_some_and(|uv| uv.abs().max_element() <= 1.0);
            if seen.z <= 0.0 || first.dot(m) <= 0.0 || !inside() {
                return 0.0;
            }
            // d = 4 f cosθi cosθo of the first light, f = d/(4 cosθi cosθo) of the other; as many facets there as here.
            self.value(first, seen) * first.z * seen.z / (light.z * o.z.max(1e-9))
        })
    }
}

/// All directions above the plate, equal angles from its normal.
pub fn hemisphere_view() -> View {
    View::new(Projection::Equidistant, FRAC_PI_2, DVec3::Z)
}

/// Mean of `f` over a pixel.
fn within(x: usize, y: usize, side: usize, f: impl Fn(DVec2) -> f64) -> f64 {
    let fine = side * WITHIN;
    let cells = (0..WITHIN * WITHIN).map(|k| (x * WITHIN + k % WITHIN, y * WITHIN + k / WITHIN));
    cells.map(|(x, y)| f(View::pixel_centre(x, y, fine, fine))).sum::<f64>() / (WITHIN * WITHIN) as f64
}

/// f cosθo dω of every pixel of the hemisphere.
fn flux(side: usize, f: impl Fn(DVec3) -> f64 + Sync) -> Raster {
    let view = hemisphere_view();
    let pixel = 4.0 / (side * side) as f64;
    let at = |uv: DVec2| match view.inverse(uv) {
        Some(o) if o.z > 0.0 => {
            let value = f(o);
            if value.is_finite() { value * o.z * view.solid_angle_density(uv) * pixel } else { 0.0 }
        }
        _ => 0.0,
    };
    let f = &at;
    let values = (0..side).into_par_iter().flat_map_iter(|y| (0..side).map(move |x| within(x, y, side, f)));
    Raster { width: side, height: side, values: values.collect() }
}

/// f_r at the polar `angle` toward `phi` of flux over the hemisphere, between the middles of pixels.
pub(crate) fn in_plane(flux: &Raster, angle: f64, phi: f64) -> Option<f64> {
    let side = flux.width;
    let view = hemisphere_view();
    let o = crate::slope::direction(angle, phi);
    let uv = view.forward(o)?;
    let share = o.z * view.solid_angle_density(uv) * 4.0 / (side * side) as f64;
    let at = |t: f64| {
        let at = (0.5 * (t + 1.0) * side as f64 - 0.5).clamp(0.0, (side - 1) as f64);
        let low = (at as usize).min(side - 2);
        (low, at - low as f64)
    };
    let ((column, s), (row, t)) = (at(uv.x), at(-uv.y));
    let along = |row: usize| (1.0 - s) * flux.at(column, row) + s * flux.at(column + 1, row);
    let value = (1.0 - t) * along(row) + t * along(row + 1);
    // Toward the horizon a pixel's light is that of its upper part.
    (angle.abs() < 0.5 * PI - 0.03).then(|| value / share)
}
