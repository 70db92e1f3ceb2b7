//! Marks for a measured highlight: how near it is to the wanted one, pixel by pixel.
//!
//! Measured images hold, per pixel, a share of all light that leaves the plate upward; they sum to less than one when
//! some of it misses the image. Wanted images hold flux per pixel and sum to one. Both are first blurred by what an
//! eye or a rough surface cannot resolve: a highlight made of specks is as good as a smooth one if they melt together.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::projection::View;
use crate::raster::Raster;
use crate::verify::blur::{Edge, gaussian};

/// A pixel belongs to the wanted highlight if it should hold more than this share of what the fullest pixel holds.
pub const SUPPORT: f64 = 0.02;

/// Rim that the window of the structural similarity cannot judge, pixels.
const SSIM_RIM: usize = 5;

/// How a measured highlight differs from the wanted one, after the same blur of both.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BlurredScores {
    /// Total variation of the shapes: the share of the light inside the image that falls in the wrong place, however
    /// much light there is. 0: the same shape; 1: no light where it is wanted. Good designs stay below about 0.05.
    pub tv: f64,
    /// The same as a share of all light that leaves upward: light thrown past the image counts as misplaced too.
    /// 0: every ray where it is wanted; 1: none. Never much below the share that misses the image.
    pub tv_up: f64,
    /// The same as a share of all light that falls on the plate: light absorbed, trapped or shadowed counts too.
    /// 0: a perfect plate; 1: none of the light gets where it is wanted.
    pub tv_incident: f64,
    /// Structural similarity (Wang et al. 2004, "Image quality assessment"): how alike the two look, detail by
    /// detail, to an eye that adapts to brightness. 1: the same picture; 0: nothing in common; below 0: like a
    /// negative. It notices a lost face that `tv` forgives. 11 × 11 pixel Gaussian windows of 1.5 px; not a number
    /// if the image is narrower than the 11 pixels of one window.
    pub ssim: f64,
}

/// Scores `image` against `target`.
///
/// `image`: flux per pixel as a share of all light that leaves upward (sum at most 1). `up`: share of the incident
/// light that leaves upward. `target`: wanted flux per pixel, sum 1, of the same size. `view` lays out both. `blur`:
/// standard deviation of the Gaussian, radians at the image centre; light it spreads over the rim is lost.
///
/// `None` if there is no light inside the image or the target, if their sizes differ, or if a value is not finite.
pub fn blurred_scores(image: &Raster, up: f64, target: &Raster, view: &View, blur: f64) -> Option<BlurredScores> {
    if (image.width, image.height) != (target.width, target.height) {
        return None;
    }
    BlurredTarget::new(target, view, blur)?.scores(image, up)
}

/// A wanted image at one blur, for many images to be marked beside it.
pub(super) struct BlurredTarget {
    sigma: (f64, f64),
    wanted: Raster,
    structure: Structure,
}

impl BlurredTarget {
    /// `target` through a blur, radians; `None` if it is dark or no image.
    pub(super) fn new(target: &Raster, view: &View, blur: f64) -> Option<Self> {
        let light = target.sum();
        if !(light > 0.0 && light.is_finite()) {
            return None;
        }
        let sigma = blur_pixels(target, view, blur);
        let wanted = gaussian(target, sigma, 5.0, Edge::Dark);
        let structure = Structure::of(&wanted);
        Some(Self { sigma, wanted, structure })
    }

    /// As [`blurred_scores`], of an image as large.
    pub(super) fn scores(&self, image: &Raster, up: f64) -> Option<BlurredScores> {
        let Self { sigma, wanted, structure } = self;
        let inside = image.sum();
        if !(inside > 0.0 && inside.is_finite() && up.is_finite()) {
            return None;
        }
        let shape = Raster { values: image.values.iter().map(|v| v / inside).collect(), ..*image };
        let seen = gaussian(&shape, *sigma, 5.0, Edge::Dark);
        let of_upward = seen.clone().scaled(inside);
        let of_incident = of_upward.clone().scaled(up);
        Some(BlurredScores {
            tv: 0.5 * distance(&seen, wanted),
            // What is in neither image sits in one more bin, "elsewhere".
            tv_up: 0.5 * (distance(&of_upward, wanted) + (of_upward.sum() - wanted.sum()).abs()),
            tv_incident: 0.5 * (distance(&of_incident, wanted) + (of_incident.sum() - wanted.sum()).abs()),
            ssim: structure.similarity(&seen, wanted),
        })
    }
}

/// Efficiency: the share of the incident light that lands where the highlight is wanted, or within `blur` of it.
/// 1: every ray that falls on the plate is put to use; 0: none.
///
/// Parameters as for [`blurred_scores`], but nothing is blurred: a pixel is wanted if its target exceeds [`SUPPORT`]
/// of the target's peak, and `blur` is how far from such a pixel light is still welcome. Not a number if the sizes
/// differ or a value is not finite.
pub fn efficiency(image: &Raster, up: f64, target: &Raster, view: &View, blur: f64) -> f64 {
    let finite = image.values.iter().chain(&target.values).all(|v| v.is_finite());
    if !finite || (image.width, image.height) != (target.width, target.height) {
        return f64::NAN;
    }
    let least = SUPPORT * target.max();
    let wanted: Vec<bool> = target.values.iter().map(|&v| v > least).collect();
    let reach = blur_pixels(image, view, blur);
    let welcome = dilated(&wanted, image.width, reach);
    let landed: f64 = image.values.iter().zip(&welcome).filter(|(_, welcome)| **welcome).map(|(v, _)| v).sum();
    landed * up
}

/// Share of the contrast of `image` that a blur of `blur` radians at the image centre leaves: the variance of its pixels
/// after, over that before. 1: nothing is lost; 0: all is even. An even image has none to lose: 1.
pub fn contrast_kept(image: &Raster, view: &View, blur: f64) -> f64 {
    let variance = |raster: &Raster| {
        let mean = raster.sum() / raster.values.len().max(1) as f64;
        raster.values.iter().map(|v| (v - mean).powi(2)).sum::<f64>()
    };
    let before = variance(image);
    if before > 0.0 { (variance(&blurred(image, view, blur)) / before).min(1.0) } else { 1.0 }
}

/// `image` seen through a Gaussian blur of `blur` radians at the image centre; light spread over the rim is lost.
pub fn blurred(image: &Raster, view: &View, blur: f64) -> Raster {
    gaussian(image, blur_pixels(image, view, blur), 5.0, Edge::Dark)
}

/// Standard deviation `blur` (radians at the image centre) in pixels along rows and along columns; zero if senseless.
fn blur_pixels(image: &Raster, view: &View, blur: f64) -> (f64, f64) {
    let [x, y] = [image.width, image.height].map(|resolution| view.blur_pixels(blur, resolution));
    // Infinite pixels have no aspect ratio.
    if x > 0.0 && y > 0.0 { (x.min(f64::MAX), y.min(f64::MAX)) } else { (0.0, 0.0) }
}

/// Sum of absolute differences.
pub(crate) fn distance(a: &Raster, b: &Raster) -> f64 {
    a.values.iter().zip(&b.values).map(|(a, b)| (a - b).abs()).sum()
}

/// Mean structural similarity of `a` and `b`, K = (0.01, 0.03), dynamic range = peak of `b`.
pub(super) fn structural_similarity(a: &Raster, b: &Raster) -> f64 {
    Structure::of(b).similarity(a, b)
}

/// Local means of an image, and of its squares.
struct Structure {
    mean: Raster,
    squares: Raster,
}

impl Structure {
    fn of(image: &Raster) -> Self {
        Self { mean: locally(image), squares: locally(&product(image, image)) }
    }

    /// Structural similarity of `a` to the image `b` that this is of.
    fn similarity(&self, a: &Raster, b: &Raster) -> f64 {
        let ours = Self::of(a);
        let both = locally(&product(a, b));
        similarity([&ours, self], &both, b.max())
    }
}

/// The mean of an image around each pixel.
fn locally(image: &Raster) -> Raster {
    gaussian(image, (1.5, 1.5), 3.5, Edge::Mirrored)
}

fn product(a: &Raster, b: &Raster) -> Raster {
    Raster { values: a.values.iter().zip(&b.values).map(|(a, b)| a * b).collect(), ..*a }
}

/// From the local means of both images, of their squares and of their product, and the peak of the wanted one.
fn similarity([a, b]: [&Structure; 2], both: &Raster, peak: f64) -> f64 {
    let (c1, c2) = ((0.01 * peak).powi(2), (0.03 * peak).powi(2));
    let (mut sum, mut count) = (0.0, 0);
    for row in SSIM_RIM..both.height.saturating_sub(SSIM_RIM) {
        for column in SSIM_RIM..both.width.saturating_sub(SSIM_RIM) {
            let at = |image: &Raster| image.at(column, row);
            let (ma, mb) = (at(&a.mean), at(&b.mean));
            let (va, vb, cab) = (at(&a.squares) - ma * ma, at(&b.squares) - mb * mb, at(both) - ma * mb);
            sum += ((2.0 * ma * mb + c1) * (2.0 * cab + c2)) / ((ma * ma + mb * mb + c1) * (va + vb + c2));
            count += 1;
        }
    }
    sum / f64::from(count)
}

/// Which pixels lie within `reach` = (along rows, along columns) pixels of one of `mask`, `width` pixels a row.
///
/// Exact Euclidean distances in two sweeps: distance along each column, then the lower envelope of the parabolas it
/// raises along each row (Felzenszwalb and Huttenlocher 2012, "Distance transforms of sampled functions").
fn dilated(mask: &[bool], width: usize, reach: (f64, f64)) -> Vec<bool> {
    if mask.is_empty() || reach.0 <= 0.0 || reach.1 <= 0.0 {
        return mask.to_vec();
    }
    let height = mask.len() / width;
    let mut along: Vec<f64> = mask.iter().map(|&m| if m { 0.0 } else { f64::INFINITY }).collect();
    for i in width..mask.len() {
        along[i] = along[i].min(along[i - width] + 1.0);
    }
    for i in (0..(height - 1) * width).rev() {
        along[i] = along[i].min(along[i + width] + 1.0);
    }
    // Rows in units of columns, so that the reach is a circle; exactly 1 on square images.
    let aspect = reach.0 / reach.1;
    let mut out = vec![false; mask.len()];
    out.par_chunks_mut(width).zip(along.par_chunks(width)).for_each(|(out, along)| {
        let feet: Vec<f64> = along.iter().map(|d| (d * aspect) * (d * aspect)).collect();
        squared_distances(&feet, |x, square| out[x] = square.sqrt() <= reach.0);
    });
    out
}

/// Tells `visit`, for each x, the least over q of (x - q)² + `feet`[q]; nothing if no foot is finite.
fn squared_distances(feet: &[f64], mut visit: impl FnMut(usize, f64)) {
    // Parabolas of the envelope from left to right, and where each begins to be the lowest.
    let mut envelope: Vec<(usize, f64)> = Vec::new();
    for (q, foot) in feet.iter().enumerate().filter(|(_, foot)| foot.is_finite()) {
        let mut begin = f64::NEG_INFINITY;
        while let Some(&(p, p_begin)) = envelope.last() {
            let (rise, run) = (foot - feet[p] + (q * q) as f64 - (p * p) as f64, (q - p) as f64);
            begin = rise / (2.0 * run);
            if begin > p_begin {
                break;
            }
            envelope.pop();
            begin = f64::NEG_INFINITY;
        }
        envelope.push((q, begin));
    }
    let mut k = 0;
    for x in 0..feet.len() {
        while envelope.get(k + 1).is_some_and(|(_, begin)| *begin < x as f64) {
            k += 1;
        }
        if let Some(&(q, _)) = envelope.get(k) {
            visit(x, x.abs_diff(q).pow(2) as f64 + feet[q]);
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::projection::Projection;
    use crate::slope::{direction, flat_mirror};

    fn view() -> View {
        View::new(Projection::Equidistant, f64::to_radians(20.0), DVec3::Z)
    }

    fn square(x: usize, y: usize, w: usize, h: usize) -> f64 {
        (x.abs_diff(w).pow(2) + y.abs_diff(h).pow(2)) as f64
    }

    fn summing_to(image: Raster, sum: f64) -> Raster {
        let whole = image.sum();
        image.scaled(sum / whole)
    }

    fn measured() -> Raster {
        let value = |x, y| ((7 * x + 13 * y + x * y) % 11) as f64 / (1.0 + square(x, y, 12, 20) / 60.0);
        summing_to(Raster::from_fn(32, 32, value), 0.875)
    }

    fn wanted() -> Raster {
        summing_to(Raster::from_fn(32, 32, |x, y| (1.0 - square(x, y, 18, 14) / 90.0).max(0.0)), 1.0)
    }

    #[test]
    fn agrees_with_the_independent_referee() {
        use Projection::{Equidistant, Orthographic, Screen};
        // Projection, half field, light, blur (degrees), up; tv, tv_up, tv_incident, ssim, efficiency.
        let cases = [
            (
                Equidistant,
                20.0,
                (0.0, 0.0),
                1.0,
                0.75,
                [0.6509752987366455, 0.6963822937532781, 0.7625660834063394, 0.05891527540405319, 0.23749757006031144],
            ),
            (
                Orthographic,
                15.0,
                (30.0, 137.0),
                0.5,
                0.9,
                [0.6687381730449853, 0.7086095492304149, 0.7340279419002709, 0.047853530907680485, 0.28499708407237373],
            ),
            (
                Screen,
                25.0,
                (50.0, 250.0),
                3.0,
                0.6,
                [0.5823745246946415, 0.6446152793711267, 0.7631929024751427, 0.10791264217452715, 0.23651759561919128],
            ),
            (
                Orthographic,
                90.0,
                (0.0, 0.0),
                0.0,
                0.9,
                [0.6926785563744203, 0.7247253999911722, 0.7487419939027603, 0.03828539489901233, 0.28499708407237373],
            ),
        ];
        for (projection, field, (theta, phi), blur, up, expected) in cases {
            let centre = flat_mirror(direction(f64::to_radians(theta), f64::to_radians(phi)));
            let view = View::new(projection, f64::to_radians(field), centre);
            let blur = f64::to_radians(blur);
            let s = blurred_scores(&measured(), up, &wanted(), &view, blur).unwrap();
            let efficiency = efficiency(&measured(), up, &wanted(), &view, blur);
            for (got, expected) in [s.tv, s.tv_up, s.tv_incident, s.ssim, efficiency].into_iter().zip(expected) {
                assert!((got - expected).abs() < 1e-12, "{projection:?} {got} {expected}");
            }
        }
    }

    #[test]
    fn a_perfect_highlight_that_lost_light_is_marked_down_by_just_that() {
        let s = blurred_scores(&wanted().scaled(0.8), 0.9, &wanted(), &view(), 0.0).unwrap();
        assert!(s.tv < 1e-12 && (s.ssim - 1.0).abs() < 1e-12);
        assert!((s.tv_up - 0.2).abs() < 1e-12);
        assert!((s.tv_incident - 0.28).abs() < 1e-12);
        assert!((efficiency(&wanted().scaled(0.8), 0.9, &wanted(), &view(), 0.03) - 0.72).abs() < 1e-12);
    }

    #[test]
    fn light_that_is_all_misplaced_scores_one_until_the_blur_bridges_the_way() {
        let spot = |at| Raster::from_fn(40, 40, |x, y| f64::from(x == at && y == 20));
        let (a, b) = (spot(18), spot(22)); // 4 pixels of 1 degree
        let tv = |blur| blurred_scores(&a, 1.0, &b, &view(), f64::to_radians(blur)).unwrap().tv;
        assert_eq!(tv(0.0), 1.0);
        assert!((tv(4.0) - 0.3829).abs() < 0.005); // erf(d / (2 sqrt(2) sigma)) for two Gaussians d apart
        assert_eq!(efficiency(&a, 1.0, &b, &view(), f64::to_radians(3.9)), 0.0);
        assert_eq!(efficiency(&a, 1.0, &b, &view(), f64::to_radians(4.1)), 1.0);
        let board = |odd| Raster::from_fn(40, 40, |x, y| ((x + y + odd) % 2) as f64 / 800.0);
        let negative = blurred_scores(&board(0), 1.0, &board(1), &view(), 0.0).unwrap();
        assert!(negative.ssim < -0.9);
    }

    #[test]
    fn dilation_is_exactly_the_pixels_in_reach() {
        for (width, height, reach) in
            [(23, 23, (4.0, 4.0)), (31, 17, (6.2, 3.4)), (9, 20, (2.5, 5.0)), (5, 1, (2.0, 1.0))]
        {
            let mask: Vec<bool> = (0..width * height).map(|i| (i * i + 3 * i) % 97 == 4).collect();
            let near = |x: usize, y: usize| {
                let hit = |&i: &usize| {
                    let (dx, dy) = (x.abs_diff(i % width) as f64, y.abs_diff(i / width) as f64 * (reach.0 / reach.1));
                    mask[i] && (dx * dx + dy * dy).sqrt() <= reach.0
                };
                (0..mask.len()).filter(hit).count() > 0
            };
            let expected: Vec<bool> = (0..mask.len()).map(|i| near(i % width, i / width)).collect();
            assert!(expected.contains(&true) && expected != mask, "{width}");
            assert_eq!(dilated(&mask, width, reach), expected);
        }
        assert!(!dilated(&[false; 12], 4, (9.0, 9.0)).contains(&true));
    }

    #[test]
    fn images_without_light_or_sense_have_no_score() {
        let (dark, good) = (Raster::zeros(32, 32), wanted());
        let mut broken = wanted();
        broken.values[5] = f64::NAN;
        let other_size = Raster::from_fn(16, 64, |_, _| 1.0);
        for bad in [&dark, &broken, &other_size, &good.clone().scaled(f64::INFINITY)] {
            assert_eq!(blurred_scores(bad, 1.0, &good, &view(), 0.01), None);
            assert_eq!(blurred_scores(&good, 1.0, bad, &view(), 0.01), None);
        }
        assert_eq!(efficiency(&dark, 1.0, &good, &view(), 0.01), 0.0);
        assert_eq!(efficiency(&good, 1.0, &dark, &view(), 0.01), 0.0);
        assert!(efficiency(&broken, 1.0, &good, &view(), 0.01).is_nan());
        for blur in [f64::NAN, -1.0, f64::INFINITY, 1e300] {
            assert!(blurred_scores(&good, 1.0, &good, &view(), blur).is_some());
            assert!(efficiency(&good, 1.0, &good, &view(), blur) > 0.99);
        }
    }

    #[test]
    fn small_images_lack_only_the_structural_similarity() {
        for (width, height) in [(1, 1), (10, 10), (3, 40), (11, 11)] {
            let image = summing_to(Raster::from_fn(width, height, |x, y| (1 + x + y) as f64), 1.0);
            let s = blurred_scores(&image, 1.0, &image, &view(), 0.05).unwrap();
            assert!(s.tv < 1e-12 && s.tv_up < 1e-12 && s.tv_incident < 1e-12);
            assert_eq!(s.ssim.is_nan(), width < 11 || height < 11);
        }
        assert_eq!(blurred_scores(&Raster::zeros(0, 0), 1.0, &Raster::zeros(0, 0), &view(), 0.1), None);
    }
}
