//! The plan of a relief of facets: each plane in its own shade, walls between them.

use glam::{DVec2, DVec3};
use image::{Rgb, RgbImage};
use rayon::prelude::*;

use super::super::heightmap::interval;
use super::super::pixels::{byte, srgb_encoded};
use super::{lit, round_exaggeration};
use crate::progress::{Cancelled, Progress};
use crate::relief::faceted::FacetedRelief;

/// Samples along each side of a pixel.
const SAMPLES: usize = 3;
/// A wall is drawn as if it leaned: this many times its (exaggerated) height wide, on its low side.
const WALL_LEAN: f64 = 0.5;
/// How much of the light a hairline between facets takes at most, where facets are many pixels wide.
const HAIRLINE: f64 = 0.16;

/// The factor by which slopes of facets are exaggerated.
pub fn exaggeration(relief: &FacetedRelief) -> f64 {
    let (columns, rows) = &relief.optical;
    let all = rows.clone().flat_map(|j| columns.clone().map(move |i| (i, j)));
    round_exaggeration(all.map(|(i, j)| relief.facet(i, j).slope.to_vec().length()).collect())
}

/// What the colour of a point of the plate is computed from.
pub struct FacetPlan<'a> {
    pub relief: &'a FacetedRelief,
    pub low: DVec3,
    pub high: DVec3,
    pub exaggeration: f64,
    /// Side of a pixel, mm.
    pub pixel: f64,
}

impl FacetPlan<'_> {
    /// All of the plan, `width` × `height` pixels.
    pub fn picture(&self, width: u32, height: u32, progress: &Progress) -> Result<RgbImage, Cancelled> {
        let rows: Vec<Vec<Rgb<u8>>> = (0..height)
            .into_par_iter()
            .map(|row| {
                progress.check()?;
                Ok((0..width).map(|column| self.pixel(column, row, width, height)).collect())
            })
            .collect::<Result<_, Cancelled>>()?;
        Ok(RgbImage::from_fn(width, height, |x, y| rows[y as usize][x as usize]))
    }

    fn pixel(&self, column: u32, row: u32, width: u32, height: u32) -> Rgb<u8> {
        let pixels = DVec2::new(f64::from(width), f64::from(height));
        let mut sum = DVec3::ZERO;
        for a in 0..SAMPLES {
            for b in 0..SAMPLES {
                let inside = (DVec2::new(a as f64, b as f64) + 0.5) / SAMPLES as f64;
                let share = (DVec2::new(f64::from(column), f64::from(row)) + inside) / pixels;
                let size = (self.high - self.low).truncate();
                sum += self.colour(DVec2::new(self.low.x + share.x * size.x, self.high.y - share.y * size.y));
            }
        }
        Rgb((sum / (SAMPLES * SAMPLES) as f64).to_array().map(|v| byte(srgb_encoded(v))))
    }

    /// Linear colour of the plate at a point, mm.
    fn colour(&self, at: DVec2) -> DVec3 {
        let relief = self.relief;
        let (i, j) = (interval(&relief.x, at.x), interval(&relief.y, at.y));
        let slope = relief.facet(i, j).slope.to_vec() * self.exaggeration;
        let z = relief.plane_height(i, j, at);
        let normal = self.wall(i, j, at).unwrap_or((-slope).extend(1.0)).normalize();
        let range = self.high.z - self.low.z;
        let rise = if range > 0.0 { ((z - self.low.z) / range).clamp(0.0, 1.0) } else { 1.0 };
        lit(normal, rise) * (1.0 - self.hairline(i, j, at))
    }

    /// Share of light that the line between facets takes at this point of cell (i, j): neighbours that meet
    /// without a step and with nearly the same slope could not be told apart by their shade alone. The rim has none.
    fn hairline(&self, i: usize, j: usize, at: DVec2) -> f64 {
        let (columns, rows) = &self.relief.optical;
        if !columns.contains(&i) || !rows.contains(&j) {
            return 0.0;
        }
        let (x, y) = (&self.relief.x[i..i + 2], &self.relief.y[j..j + 2]);
        let edge = (at.x - x[0]).min(x[1] - at.x).min(at.y - y[0]).min(y[1] - at.y);
        let cell_pixels = (x[1] - x[0]).min(y[1] - y[0]) / self.pixel;
        if edge < 0.5 * self.pixel { HAIRLINE * ((cell_pixels - 5.0) / 15.0).clamp(0.0, 1.0) } else { 0.0 }
    }

    /// The normal of the wall that is drawn over this point of cell (i, j), if a neighbour stands that much higher.
    fn wall(&self, i: usize, j: usize, at: DVec2) -> Option<DVec3> {
        let relief = self.relief;
        let (x0, x1, y0, y1) = (relief.x[i], relief.x[i + 1], relief.y[j], relief.y[j + 1]);
        // Foot of the wall nearest the point, distance to it, the way it faces, and the neighbour behind it.
        let sides = [
            (DVec2::new(x0, at.y), at.x - x0, DVec2::X, (i > 0).then(|| (i - 1, j))),
            (DVec2::new(x1, at.y), x1 - at.x, -DVec2::X, (i + 1 < relief.columns()).then(|| (i + 1, j))),
            (DVec2::new(at.x, y0), at.y - y0, DVec2::Y, (j > 0).then(|| (i, j - 1))),
            (DVec2::new(at.x, y1), y1 - at.y, -DVec2::Y, (j + 1 < relief.rows()).then(|| (i, j + 1))),
        ];
        let widest = 0.25 * (x1 - x0).min(y1 - y0);
        // Steps of rounding errors are none.
        let mut best = (1e-6 * widest, None);
        for (foot, distance, facing, neighbour) in sides {
            let Some((ni, nj)) = neighbour else { continue };
            let step = relief.plane_height(ni, nj, foot) - relief.plane_height(i, j, foot);
            let left_over = (WALL_LEAN * self.exaggeration * step).min(widest) - distance;
            if left_over > best.0 {
                best = (left_over, Some(facing.extend(WALL_LEAN)));
            }
        }
        best.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::relief::faceted::Facet;
    use crate::slope::Slope;

    fn one(slope: Slope, size: DVec2) -> FacetedRelief {
        FacetedRelief::uniform(1, 1, size, vec![Facet { height: 0.0, slope }])
    }

    fn plan(relief: &FacetedRelief) -> FacetPlan<'_> {
        let (low, high) = relief.bounds();
        FacetPlan { relief, low, high, exaggeration: exaggeration(relief), pixel: 0.01 }
    }

    #[test]
    fn slopes_facing_the_upper_left_are_bright() {
        // A plane that climbs to the right faces left; one that climbs down the page faces up.
        let light = |p, q| {
            let relief = one(Slope::new(p, q), DVec2::ONE);
            plan(&relief).colour(DVec2::new(0.5, 0.5)).y
        };
        assert!(light(0.1, -0.1) > 1.5 * light(-0.1, -0.1));
        assert!(light(-0.1, -0.1) > 1.2 * light(-0.1, 0.1));
        assert!((light(0.1, 0.0) - light(0.0, -0.1)).abs() < 1e-12);
    }

    #[test]
    fn a_step_shows_on_its_low_side_only() {
        // The upper row of cells (higher y) stands 0.05 mm higher: its wall faces down the page, away from the lamp.
        let facet = |height| Facet { height, slope: Slope::FLAT };
        let relief = FacetedRelief::uniform(1, 2, DVec2::new(1.0, 2.0), vec![facet(0.0), facet(0.05)]);
        let plan = plan(&relief);
        assert_eq!(plan.exaggeration, 1.0);
        assert_eq!(plan.wall(0, 0, DVec2::new(0.5, 0.98)), Some(DVec3::new(0.0, -1.0, WALL_LEAN)));
        assert_eq!(plan.wall(0, 0, DVec2::new(0.5, 0.97)), None);
        assert_eq!(plan.wall(0, 1, DVec2::new(0.5, 1.01)), None);
    }

    #[test]
    fn the_exaggeration_is_round_and_never_hides_slopes() {
        let of = |p| exaggeration(&one(Slope::new(p, 0.0), DVec2::ONE));
        assert_eq!([0.0, 1e-12, 2.0, 0.75, 0.18, 0.075, 0.01, 1e-6].map(of), [1., 1., 1., 1., 4., 10., 60., 1000.]);
    }
}
