//! Gaussian blur of a raster: what an eye or a lens of limited sharpness makes of a highlight.

use rayon::prelude::*;

use crate::raster::Raster;

/// Widest standard deviation, pixels. Any image is flat long before, and the kernel must end.
const WIDEST: f64 = 1e5;
/// Standard deviations beyond which the weights of a Gaussian are zero in f64.
const FARTHEST: f64 = 39.0;

/// What lies beyond the rim of the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Edge {
    /// Nothing: light blurred over the rim is lost.
    Dark,
    /// The image again, mirrored so that its outermost pixels are met twice: … b a | a b … y z | z y …
    Mirrored,
}

/// `image` blurred by a Gaussian of standard deviation `sigma` = (along rows, along columns) pixels.
///
/// The kernel is cut `reach` standard deviations (rounded to whole pixels) from its middle, and its weights sum to
/// one. A deviation that is zero, negative or not a number leaves its direction as it is.
/// The result has the size of `image` and does not depend on the number of threads.
pub fn gaussian(image: &Raster, sigma: (f64, f64), reach: f64, edge: Edge) -> Raster {
    let mut out = image.clone();
    if image.values.is_empty() {
        return out;
    }
    let (width, height) = (image.width, image.height);
    if sigma.0 > 0.0 {
        let weights = kernel(sigma.0, reach, width, edge);
        let half = weights.len() / 2;
        out.values.par_chunks_mut(width).for_each(|row| {
            let source = (0..width + 2 * half).map(|x| edge.index(x, half, width).map_or(0.0, |x| row[x]));
            let source: Vec<f64> = source.collect();
            row.fill(0.0);
            for (k, weight) in weights.iter().enumerate() {
                add_scaled(row, &source[k..], *weight);
            }
        });
    }
    if sigma.1 > 0.0 {
        let weights = kernel(sigma.1, reach, height, edge);
        let half = weights.len() / 2;
        let source = out.values.clone();
        out.values.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
            row.fill(0.0);
            for (k, weight) in weights.iter().enumerate() {
                if let Some(from) = edge.index(y + k, half, height) {
                    add_scaled(row, &source[from * width..], *weight);
                }
            }
        });
    }
    out
}

fn add_scaled(row: &mut [f64], source: &[f64], weight: f64) {
    for (out, value) in row.iter_mut().zip(source) {
        *out += weight * value;
    }
}

/// The weights from one end of the kernel to the other, an odd number of them, for lines of `length` pixels.
fn kernel(sigma: f64, reach: f64, length: usize, edge: Edge) -> Vec<f64> {
    let sigma = sigma.min(WIDEST);
    let radius = (reach.min(FARTHEST) * sigma + 0.5) as usize;
    if radius == 0 {
        return vec![1.0];
    }
    let weight = |k: usize| (-0.5 / (sigma * sigma) * (k * k) as f64).exp();
    let whole = 1.0 + 2.0 * (1..=radius).rev().map(weight).sum::<f64>();
    // Weights that only ever meet the dark beyond the rim count in the sum, but need not be walked.
    let half = if edge == Edge::Dark { radius.min(length - 1) } else { radius };
    (0..=2 * half).map(|k| weight(k.abs_diff(half)) / whole).collect()
}

impl Edge {
    /// Which of `length` pixels stands at position `at` of a line that begins `before` pixels ahead of the first.
    fn index(self, at: usize, before: usize, length: usize) -> Option<usize> {
        match self {
            Self::Dark => at.checked_sub(before).filter(|&i| i < length),
            Self::Mirrored => {
                let period = 2 * length;
                let i = (at + period - before % period) % period;
                Some(i.min(period - 1 - i))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pattern(width: usize, height: usize) -> Raster {
        Raster::from_fn(width, height, |x, y| ((7 * x + 13 * y + x * y) % 11) as f64)
    }

    #[test]
    fn agrees_with_an_independent_gaussian_filter() {
        // scipy.ndimage.gaussian_filter(pattern, (sigma_y, sigma_x), mode, truncate) at four pixels, and its sum.
        let cases = [
            (
                1.3,
                0.8,
                5.0,
                Edge::Dark,
                [1.9276638268379127, 4.4387285245440395, 2.5287699740811416, 3.245882934183996],
            ),
            (
                4.0,
                3.0,
                5.0,
                Edge::Dark,
                [1.4380934957033706, 2.8161123947382767, 1.5335086183260886, 1.713694196780627],
            ),
            (1.3, 0.8, 3.5, Edge::Mirrored, [3.45123867320853, 4.44158747215664, 5.233426586515089, 5.271693657944978]),
            (
                4.0,
                3.0,
                3.5,
                Edge::Mirrored,
                [4.851856793802814, 4.98353792522481, 5.2098756033285305, 4.837683326257018],
            ),
        ];
        for (sx, sy, reach, edge, expected) in cases {
            let image = pattern(9, 7);
            let blurred = gaussian(&image, (sx, sy), reach, edge);
            for ((x, y), value) in [(0, 0), (4, 3), (8, 6), (0, 5)].into_iter().zip(expected) {
                assert!(
                    (blurred.at(x, y) - value).abs() < 1e-13 * value,
                    "{sx} {edge:?} {x} {y}: {}",
                    blurred.at(x, y)
                );
            }
            let kept = blurred.sum() / image.sum();
            assert!(if edge == Edge::Dark { kept < 0.9 } else { (kept - 1.0).abs() < 1e-13 });
        }
    }

    #[test]
    fn two_blurs_in_a_row_are_one_wider_blur() {
        let mut point = Raster::zeros(81, 81);
        point.values[40 * 81 + 40] = 1.0;
        let twice = gaussian(&gaussian(&point, (3.0, 3.0), 5.0, Edge::Dark), (4.0, 4.0), 5.0, Edge::Dark);
        let once = gaussian(&point, (5.0, 5.0), 5.0, Edge::Dark);
        for (a, b) in twice.values.iter().zip(&once.values) {
            assert!((a - b).abs() < 1e-5 * once.max());
        }
        let spread: f64 =
            (0..81).map(|x| (x as f64 - 40.0).powi(2) * (0..81).map(|y| once.at(x, y)).sum::<f64>()).sum();
        assert!((spread - 25.0).abs() < 1e-3);
    }

    #[test]
    fn no_blur_is_the_identity_and_senseless_ones_are_survived() {
        let image = pattern(5, 4);
        for sigma in [0.0, -1.0, f64::NAN, 1e-200, 0.05] {
            assert_eq!(gaussian(&image, (sigma, sigma), 5.0, Edge::Dark), image);
        }
        for sigma in [1e9, f64::INFINITY] {
            let dark = gaussian(&image, (sigma, sigma), 5.0, Edge::Dark);
            assert!(dark.max() < 1e-6);
        }
        assert_eq!(gaussian(&Raster::zeros(0, 3), (1.0, 1.0), 5.0, Edge::Dark).sum(), 0.0);
        let one = gaussian(&Raster::from_fn(1, 1, |_, _| 2.0), (3.0, 3.0), 3.5, Edge::Mirrored);
        assert!((one.at(0, 0) - 2.0).abs() < 1e-14);
    }
}
