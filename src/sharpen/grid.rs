//! The image laid out for blurring, with dark around it, and blurs as filters of its waves.

use std::f64::consts::PI;

use glam::{DMat2, DVec2};
use rustfft::num_complex::Complex64;

use super::blur::BlurKernel;
use crate::fourier::{WaveTransform, smooth_size};
use crate::raster::Raster;

/// Blocks along a side of the image at the most.
const FINEST: usize = 512;

/// Blocks in the blur's narrower standard deviation at the most: detail below a quarter of it is not seen.
const BLOCKS_PER_BLUR: f64 = 4.0;

/// `picture` with its pixels cut into equal parts, so that the blur's narrower standard deviation is a pixel or more, if
/// [`FINEST`] allows: how light strays within a pixel cannot be told by pixels.
pub fn cut(picture: &Raster, blur: &BlurKernel) -> Raster {
    let longer = picture.width.max(picture.height).max(1);
    let parts = (1.0 / narrower(spread(blur, picture))).min((FINEST / longer) as f64).ceil().max(1.0) as usize;
    picture.resampled(parts * picture.width, parts * picture.height)
}

/// Pixels of `picture` per (u, v), rows downward.
fn pixels(picture: &Raster) -> DMat2 {
    0.5 * DMat2::from_diagonal(DVec2::new(picture.width as f64, -(picture.height as f64)))
}

/// Covariance of the blur, pixels² of `picture`.
fn spread(blur: &BlurKernel, picture: &Raster) -> DMat2 {
    let pixels = pixels(picture);
    // An even disc of radius 1 has variance 1/4 along each axis.
    0.25 * covariance(pixels * blur.disc) + covariance(pixels * blur.lobe)
}

/// The image in blocks of pixels, as fine as its blur needs.
pub(crate) struct Grid {
    /// Pixels along a side of a block.
    block: usize,
    /// Blocks across the grid, and down.
    width: usize,
    height: usize,
    waves: WaveTransform,
    /// The blur's matrices, in blocks.
    disc: DMat2,
    lobe: DMat2,
    degree: DMat2,
}

impl Grid {
    /// A grid for pictures of the size of `picture`.
    pub fn new(blur: &BlurKernel, picture: &Raster) -> Self {
        let longer = picture.width.max(picture.height);
        let fine = (narrower(spread(blur, picture)) / BLOCKS_PER_BLUR) as usize;
        let block = fine.max(longer.div_ceil(FINEST)).clamp(1, longer.max(1));
        let blocks = pixels(picture) * (1.0 / block as f64);
        let (disc, lobe, degree) = (blocks * blur.disc, blocks * blur.lobe, blocks * blur.degree);
        let (columns, rows) = (picture.width.div_ceil(block), picture.height.div_ceil(block));
        // Opposite rims must not meet: light strays by the disc's radius, four deviations of the lobe and of a degree.
        let reach = |m: DMat2| DVec2::new(m.row(0).length(), m.row(1).length());
        let far = reach(disc) + 4.0 * reach(lobe);
        let side = |n: usize, far: f64, degree: f64| {
            // A Gaussian wider than the image shows no detail that could be put right.
            let margin = far + (4.0 * degree).min(n as f64 / 4.0);
            smooth_size(n + 1 + margin.ceil() as usize)
        };
        let (width, height) = (side(columns, far.x, reach(degree).x), side(rows, far.y, reach(degree).y));
        Self { block, width, height, waves: WaveTransform::new(width, height), disc, lobe, degree }
    }

    /// `picture` in blocks, dark around it: rows of the grid, the picture in their first ones.
    pub(crate) fn laid_out(&self, picture: &Raster) -> Vec<f64> {
        let mut grid = vec![0.0; self.width * self.height];
        for (k, value) in picture.values.iter().enumerate() {
            grid[self.place(k, picture.width)] += value;
        }
        grid
    }

    /// Place of pixel `k` of a picture `across` pixels wide.
    fn place(&self, k: usize, across: usize) -> usize {
        k / across / self.block * self.width + k % across / self.block
    }

    /// The light of `grid` on the pixels of a picture like `like`, even within blocks.
    pub fn picture(&self, grid: &[f64], like: &Raster) -> Raster {
        let (across, share) = (like.width, 1.0 / (self.block * self.block) as f64);
        Raster::from_fn(across, like.height, |x, y| share * grid[self.place(y * across + x, across)].max(0.0))
    }

    /// Changes every pixel of `picture` as its block is changed from `old` to `new`; the sum stays.
    pub(crate) fn carry_over(&self, picture: &mut Raster, old: &[f64], new: &[f64]) {
        let (before, across) = (picture.sum(), picture.width);
        for (k, value) in picture.values.iter_mut().enumerate().filter(|(_, value)| **value > 0.0) {
            let at = self.place(k, across);
            *value *= new[at] / old[at];
        }
        let after = picture.sum();
        picture.values.iter_mut().for_each(|value| *value *= before / after);
    }

    /// What an eye that is unsharp by `degrees` (standard deviation) leaves of each wave.
    pub fn gaussian(&self, degrees: f64) -> Vec<f64> {
        self.filter(&points(DMat2::ZERO, degrees * self.degree))
    }

    /// What the blur, made narrower by the factor `width`, leaves of each wave, and then the filter `after`; alone if that
    /// is empty.
    pub fn blurred(&self, width: f64, after: &[f64]) -> Vec<f64> {
        let mut filter = self.filter(&points(width * self.disc, width * self.lobe));
        filter.iter_mut().zip(after).for_each(|(gain, after)| *gain *= after);
        filter
    }

    /// In the order of [`WaveTransform::spectrum`]; real, for the kernel is even.
    fn filter(&self, points: &[DVec2]) -> Vec<f64> {
        let kernel = kernel(points, self.width, self.height);
        self.waves.spectrum(&kernel).iter().map(|wave| wave.re).collect()
    }

    /// `light` on the grid, filtered.
    pub fn through(&self, filter: &[f64], light: &[f64]) -> Vec<f64> {
        let mut seen = light.to_vec();
        self.waves.filter(&mut seen, |i, j| Complex64::from(filter[i * self.height + j]));
        seen
    }
}

/// Of points of variance 1 that `m` lays out.
fn covariance(m: DMat2) -> DMat2 {
    m * m.transpose()
}

/// Square root of the smaller eigenvalue of a covariance.
fn narrower(m: DMat2) -> f64 {
    let (mean, half) = (0.5 * (m.x_axis.x + m.y_axis.y), 0.5 * (m.x_axis.x - m.y_axis.y));
    (mean - half.hypot(m.x_axis.y)).max(0.0).sqrt()
}

/// Points that stand for a disc and for a Gaussian together, a square number.
const POINTS: usize = 65_536;

/// Points of equal light that stand for an even disc convolved with a Gaussian, as the matrices lay them out.
fn points(disc: DMat2, gaussian: DMat2) -> Vec<DVec2> {
    let one = [disc, gaussian].contains(&DMat2::ZERO);
    let each = if one { POINTS } else { POINTS.isqrt() };
    // Sunflowers: equal areas, no rows (Vogel 1979); from seed to seed the angle of the golden section.
    let turn = PI * (3.0 - 5f64.sqrt());
    let sunflower = |matrix: DMat2, radius: fn(f64) -> f64| -> Vec<DVec2> {
        let seed = |k: usize| radius((k as f64 + 0.5) / each as f64) * DVec2::from_angle(k as f64 * turn);
        if matrix == DMat2::ZERO { vec![DVec2::ZERO] } else { (0..each).map(|k| matrix * seed(k)).collect() }
    };
    let disc = sunflower(disc, f64::sqrt);
    let gaussian = sunflower(gaussian, |share| (-2.0 * (1.0 - share).ln()).sqrt());
    disc.iter().flat_map(|disc| gaussian.iter().map(move |aside| *disc + *aside)).collect()
}

/// How light that was even over one block is shared among blocks when `points` and their opposites displace it: a grid
/// of sum 1 around index (0, 0), continued into itself. Nothing in it is negative, as waves cut short would be.
fn kernel(points: &[DVec2], width: usize, height: usize) -> Vec<f64> {
    let mut kernel = vec![0.0; width * height];
    let share = 0.5 / points.len() as f64;
    let index = |c: f64, n: usize| (c as isize).rem_euclid(n as isize) as usize;
    for at in points.iter().flat_map(|at| [*at, -*at]) {
        // A square displaced by a part of itself falls on four, by areas.
        let (whole, part) = (at.floor(), at - at.floor());
        for (x, a) in [(whole.x, 1.0 - part.x), (whole.x + 1.0, part.x)] {
            for (y, b) in [(whole.y, 1.0 - part.y), (whole.y + 1.0, part.y)] {
                kernel[index(y, height) * width + index(x, width)] += share * a * b;
            }
        }
    }
    kernel
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kernel_has_the_moments_of_its_disc_and_lobe() {
        let disc = DMat2::from_cols(DVec2::new(6.0, 1.0), DVec2::new(-0.5, 4.0));
        let lobe = DMat2::from_cols(DVec2::new(2.0, -1.0), DVec2::new(0.0, 3.0));
        for (disc, lobe) in [(disc, lobe), (disc, DMat2::ZERO), (DMat2::ZERO, lobe), (DMat2::ZERO, 0.2 * lobe)] {
            let (width, height) = (80, 81);
            let kernel = kernel(&points(disc, lobe), width, height);
            assert!((kernel.iter().sum::<f64>() - 1.0).abs() < 1e-12 && kernel.iter().all(|k| *k >= 0.0));
            let signed = |k: usize, n: usize| if 2 * k < n { k as f64 } else { k as f64 - n as f64 };
            let (mut first, mut second) = (DVec2::ZERO, DMat2::ZERO);
            for (k, share) in kernel.iter().enumerate() {
                let at = DVec2::new(signed(k % width, width), signed(k / width, height));
                first += *share * at;
                second += *share * DMat2::from_cols(at * at.x, at * at.y);
            }
            // Parts f of a square on its neighbour add f (1 - f) to the variance, 1/6 on average.
            let expected = 0.25 * covariance(disc) + covariance(lobe) + DMat2::from_diagonal(DVec2::splat(1.0 / 6.0));
            let (error, size) = (second - expected, expected.x_axis.x + expected.y_axis.y);
            assert!(first.length() < 1e-9, "{first}");
            assert!([error.x_axis, error.y_axis].iter().all(|e| e.abs().max_element() < 0.02 * size), "{error} {size}");
        }
        assert_eq!(kernel(&points(DMat2::ZERO, DMat2::ZERO), 3, 2), [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    }
}
