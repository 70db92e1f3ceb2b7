//! Heights of a relief at the corners of a picture's pixels, and what is drawn from them: shade, contour lines, a section.

use glam::{DVec2, DVec3};
use image::{Rgb, RgbImage};
use rayon::prelude::*;

use super::super::heightmap::interval;
use super::super::pixels::{byte, srgb_encoded};
use super::{lit, round_exaggeration};
use crate::progress::{Cancelled, Progress};
use crate::relief::faceted::FacetedRelief;

/// Strength of a contour line.
const CONTOUR: f64 = 0.5;

/// Heights at the corners of `columns` × `rows` pixels, mm, the top row first.
pub struct CornerHeights {
    /// Pixels in a row.
    pub columns: usize,
    /// Pixels in a column.
    pub rows: usize,
    /// Size of a pixel, mm.
    pixel: DVec2,
    values: Vec<f64>,
}

impl CornerHeights {
    /// Of `relief`: of its facets' planes, or if it is `continuous` of the surface through the corners where they meet.
    pub fn new(
        relief: &FacetedRelief,
        continuous: bool,
        [columns, rows]: [usize; 2],
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let (low, high) = relief.bounds();
        let pixel = (high - low).truncate() / DVec2::new(columns as f64, rows as f64);
        progress.check()?;
        let nodes = if continuous { Some(node_heights(relief)) } else { None };
        let row = |r: usize| {
            progress.check()?;
            let y = high.y - r as f64 * pixel.y;
            let j = interval(&relief.y, y);
            let at = |c: usize| {
                let x = low.x + c as f64 * pixel.x;
                let i = interval(&relief.x, x);
                match &nodes {
                    None => relief.plane_height(i, j, DVec2::new(x, y)),
                    Some(nodes) => {
                        let share = |lines: &[f64], k: usize, at: f64| (at - lines[k]) / (lines[k + 1] - lines[k]);
                        let (s, t) = (share(&relief.x, i, x), share(&relief.y, j, y));
                        let n = relief.columns() + 1;
                        let along = |j: usize| nodes[j * n + i] * (1.0 - s) + nodes[j * n + i + 1] * s;
                        along(j) * (1.0 - t) + along(j + 1) * t
                    }
                }
            };
            Ok((0..=columns).map(at).collect::<Vec<f64>>())
        };
        let values = (0..=rows).into_par_iter().map(row).collect::<Result<Vec<_>, Cancelled>>()?.concat();
        Ok(Self { columns, rows, pixel, values })
    }

    fn corner(&self, column: usize, row: usize) -> f64 {
        self.values[row * (self.columns + 1) + column]
    }

    /// Heights along the upper edge of a row of pixels, mm.
    pub fn section(&self, row: usize) -> &[f64] {
        &self.values[row * (self.columns + 1)..][..self.columns + 1]
    }

    /// Mean height and mean slope of a pixel.
    fn plane(&self, column: usize, row: usize) -> (f64, DVec2) {
        let [a, b, c, d] = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| self.corner(column + i, row + j));
        (0.25 * (a + b + c + d), 0.5 * DVec2::new(b - a + d - c, a - c + b - d) / self.pixel)
    }

    /// The mean slope of all.
    fn mean_slope(&self) -> DVec2 {
        let sum = |along: &dyn Fn(usize) -> f64, n: usize| (0..=n).map(along).sum::<f64>() / (n + 1) as f64;
        let across = |row| self.corner(self.columns, row) - self.corner(0, row);
        let up = |column| self.corner(column, 0) - self.corner(column, self.rows);
        let rise = DVec2::new(sum(&across, self.rows), sum(&up, self.columns));
        rise / (self.pixel * DVec2::new(self.columns as f64, self.rows as f64))
    }

    /// The plan: each pixel in the shade of its mean slope about the slope of the whole; and how much slopes are exaggerated.
    pub fn shaded(&self, low: f64, high: f64) -> (RgbImage, f64) {
        let mean = self.mean_slope();
        let all = (0..self.rows).flat_map(|row| (0..self.columns).map(move |column| (column, row)));
        let steepness = all.map(|(column, row)| (self.plane(column, row).1 - mean).length()).collect();
        let exaggeration = round_exaggeration(steepness);
        let plan = RgbImage::from_fn(self.columns as u32, self.rows as u32, |x, y| {
            let (z, slope) = self.plane(x as usize, y as usize);
            let normal = (-exaggeration * (slope - mean)).extend(1.0).normalize();
            let rise = if high > low { ((z - low) / (high - low)).clamp(0.0, 1.0) } else { 1.0 };
            let colour: DVec3 = lit(normal, rise);
            Rgb(colour.to_array().map(|v| byte(srgb_encoded(v))))
        });
        (plan, exaggeration)
    }

    /// Draws lines of equal height every `step` mm over the plan. Walls, where lines would lie upon each other, have none.
    pub fn contours(&self, plan: &mut RgbImage, step: f64) {
        for (x, y, pixel) in plan.enumerate_pixels_mut() {
            let (z, slope) = self.plane(x as usize, y as usize);
            // Steps of height from pixel to pixel.
            let steep = (slope * self.pixel).length() / step;
            if !(1e-6..0.34).contains(&steep) {
                continue;
            }
            let level = z / step;
            let away = (level - level.round()).abs() / steep;
            let ink = CONTOUR * (1.1 - away).clamp(0.0, 1.0);
            pixel.0 = pixel.0.map(|v| (f64::from(v) * (1.0 - ink)) as u8);
        }
    }
}

/// Heights where facets meet, mm: the mean of the planes around each corner of the grid.
fn node_heights(relief: &FacetedRelief) -> Vec<f64> {
    let (columns, rows) = (relief.columns(), relief.rows());
    let node = |k: usize| {
        let (i, j) = (k % (columns + 1), k / (columns + 1));
        let at = DVec2::new(relief.x[i], relief.y[j]);
        let around = [(0, 0), (1, 0), (0, 1), (1, 1)].into_iter().filter_map(|(a, b)| {
            let (i, j) = ((i + a).checked_sub(1)?, (j + b).checked_sub(1)?);
            (i < columns && j < rows).then(|| relief.plane_height(i, j, at))
        });
        let (sum, count) = around.fold((0.0, 0.0), |(sum, count), z| (sum + z, count + 1.0));
        sum / count
    };
    (0..(columns + 1) * (rows + 1)).into_par_iter().map(node).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::relief::faceted::Facet;
    use crate::slope::Slope;

    /// A wave along x of 4 mm, on `n` × `n` squares over 8 mm.
    fn wave(n: usize) -> FacetedRelief {
        let lines: Vec<f64> = (0..=n).map(|k| 8.0 * k as f64 / n as f64).collect();
        let z = |x: f64| 0.2 * (x * std::f64::consts::TAU / 4.0).sin();
        let facets = (0..n * n).map(|k| {
            let (a, b) = (lines[k % n], lines[k % n + 1]);
            Facet { height: 0.5 * (z(a) + z(b)), slope: Slope::new((z(b) - z(a)) / (b - a), 0.0) }
        });
        FacetedRelief::uniform(n, n, DVec2::splat(8.0), facets.collect())
    }

    #[test]
    fn a_continuous_relief_shows_no_grid_of_its_own() {
        // Nodes a little finer or coarser than pixels would beat with them: rows of one wave must look alike.
        for nodes in [90, 110, 300] {
            let heights = CornerHeights::new(&wave(nodes), true, [100, 100], &Progress::silent()).unwrap();
            let (plan, exaggeration) = heights.shaded(-0.2, 0.2);
            assert!(exaggeration > 1.0);
            for y in 1..100 {
                for x in 0..100 {
                    assert_eq!(plan.get_pixel(x, y), plan.get_pixel(x, 0), "{nodes}");
                }
            }
            // From pixel to pixel along the wave the shade changes little: no line stands out.
            let grey = |x: u32| i32::from(plan.get_pixel(x, 50).0[1]);
            let bends: Vec<i32> = (1..99).map(|x| (grey(x + 1) - 2 * grey(x) + grey(x - 1)).abs()).collect();
            assert!(bends.iter().all(|bend| *bend <= 14), "{nodes}: {bends:?}");
            assert!((0..100).map(grey).max() > (0..100).map(grey).min().map(|least| least + 90));
        }
    }

    #[test]
    fn contours_stand_where_the_height_is_a_multiple_of_the_step() {
        let slope = Slope::new(0.1, 0.0);
        let plane = FacetedRelief::uniform(1, 1, DVec2::splat(10.0), vec![Facet { height: 0.5, slope }]);
        let heights = CornerHeights::new(&plane, false, [100, 100], &Progress::silent()).unwrap();
        let mut plan = RgbImage::from_pixel(100, 100, Rgb([200; 3]));
        heights.contours(&mut plan, 0.2);
        // Heights 0 to 1 over 100 pixels: lines at 0, 0.2, 0.4 … are 20 pixels apart.
        let dark: Vec<u32> = (0..100).filter(|x| plan.get_pixel(*x, 40).0[0] < 180).collect();
        assert!(dark.iter().all(|x| (x + 1) % 20 < 3) && dark.len() >= 8, "{dark:?}");
        assert_eq!(heights.section(7).len(), 101);
        assert!((heights.section(7)[30] - 0.3).abs() < 1e-12);
    }
}
