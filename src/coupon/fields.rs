//! The fields of a test piece in a photograph, and the bright stripes of their grooves.

use glam::{DMat3, DVec2, DVec3};
use nalgebra::{SMatrix, SVector};

use super::corners::corners;
use super::layout::{Coupon, Place};
use super::least_squares::linear_fit;
use super::lines::{LIKE, NotFound, STEPS, Template, apart, largest, wide};
use crate::raster::Raster;

/// Fewest pixels from one pass to the next.
const PIXELS: f64 = 6.0;

/// How far beside the middle of a field brightness is taken together along the passes, mm, and lines of that.
const ASIDE: f64 = 0.25;
const LINES: usize = 60;

/// Of the way from one pass to the next, what is within a stripe or between two whatever the lens blurs.
const INNER: f64 = 0.1;

/// Passes at either end of those far apart that are not read.
const RIM: usize = 2;

/// From places on the piece (mm) to pixels.
struct Mapping(DMat3);

impl Mapping {
    /// The corners (0, 0), (x, 0), (x, y), (0, y) of a piece of `size` mm at four pixels.
    fn new(size: DVec2, pixels: [DVec2; 4]) -> Option<Self> {
        let places = [DVec2::ZERO, DVec2::new(size.x, 0.0), size, DVec2::new(0.0, size.y)];
        let (mut square, mut right) = (SMatrix::<f64, 8, 8>::zeros(), SVector::<f64, 8>::zeros());
        for (k, (place, pixel)) in places.into_iter().zip(pixels).enumerate() {
            for (row, at) in [(2 * k, pixel.x), (2 * k + 1, pixel.y)] {
                let first = 3 * (row % 2);
                square[(row, first)] = place.x;
                square[(row, first + 1)] = place.y;
                square[(row, first + 2)] = 1.0;
                square[(row, 6)] = -at * place.x;
                square[(row, 7)] = -at * place.y;
                right[row] = at;
            }
        }
        let h = square.lu().solve(&right)?;
        Some(Self(DMat3::from_cols(
            DVec3::new(h[0], h[3], h[6]),
            DVec3::new(h[1], h[4], h[7]),
            DVec3::new(h[2], h[5], 1.0),
        )))
    }

    fn pixel(&self, place: DVec2) -> DVec2 {
        let at = self.0 * place.extend(1.0);
        at.truncate() / at.z
    }
}

/// Stripes of the grooves over one field.
pub(super) struct Field {
    pub(super) place: Place,
    /// Width of the bright stripe of each pass far apart, mm; not a number where it is not seen.
    pub(super) bright: Vec<f64>,
}

/// Fields of one photograph.
pub(super) fn seen(coupon: &Coupon, photograph: &Raster) -> Result<Vec<Field>, NotFound> {
    let size = coupon.size();
    let mapping = corners(photograph).and_then(|corners| Mapping::new(size, corners)).ok_or_else(|| {
        NotFound(
            "the piece is not found in it: a bright piece with four corners on dark ground was looked for, its low y at the \
             bottom, filling a tenth of the photograph and more"
                .into(),
        )
    })?;
    let pixels = (mapping.pixel(0.5 * size) - mapping.pixel(0.5 * size + DVec2::Y * apart(coupon))).length();
    if pixels < PIXELS {
        return Err(NotFound(format!(
            "passes {} mm apart are {pixels:.1} pixels apart in it: {PIXELS} would do; go nearer, or take a finer camera",
            apart(coupon)
        )));
    }
    let step = apart(coupon) / STEPS;
    let template = Template::of_stripes(coupon);
    let fields: Vec<(f64, Place)> =
        coupon.lines().into_iter().filter(|line| !matches!(line.1, Place::Up | Place::Down)).collect();
    let profiles: Vec<Vec<[f64; 2]>> =
        fields.iter().map(|(x, _)| profile(coupon, (photograph, &mapping), *x, step)).collect();
    let bare: Vec<usize> = (0..fields.len()).filter(|k| fields[*k].1 != Place::Polished).collect();
    let likeness: Vec<Vec<f64>> = bare.iter().map(|k| template.likeness(&profiles[*k])).collect();
    let sum = |k: usize| likeness.iter().map(|one| one[k]).sum::<f64>() / likeness.len() as f64;
    let (best, most) = largest((0..likeness[0].len()).map(|k| (k, sum(k))));
    if most < LIKE {
        return Err(NotFound(format!(
            "the piece's grooves are not found in it: bright stripes {} mm apart, then closer ones, were looked for, and the \
             likeness is {most:.2} where {LIKE} would do; see that the lamp's edge lies along the passes, that its low y is at \
             the bottom of the photograph, and that it is sharp",
            apart(coupon)
        )));
    }
    let shift = template.shift(best);
    let middles = middles(coupon, &profiles[bare[bare.len() - 1]], shift, step);
    let field = |((_, place), profile): (&(f64, Place), &Vec<[f64; 2]>)| {
        let polished = *place == Place::Polished;
        let own = if polished { middles.clone() } else { self::middles(coupon, profile, shift, step) };
        let mut bright = bright(profile, &own, (apart(coupon), polished));
        // The passes at the ends have other neighbours: an edge, or closer passes.
        let last = bright.len() - RIM;
        bright[..RIM].iter_mut().for_each(|stripe| *stripe = f64::NAN);
        bright[last..].iter_mut().for_each(|stripe| *stripe = f64::NAN);
        Field { place: *place, bright }
    };
    Ok(fields.iter().zip(&profiles).map(field).collect())
}

/// Brightness across the passes around `x` mm: place (mm) and mean over [`LINES`] lines.
fn profile(coupon: &Coupon, (photograph, mapping): (&Raster, &Mapping), x: f64, step: f64) -> Vec<[f64; 2]> {
    let at = |place: DVec2| {
        let pixel = mapping.pixel(place);
        let (i, j) = (pixel.x.floor(), pixel.y.floor());
        let within = i >= 0.0 && j >= 0.0 && i + 1.0 < photograph.width as f64 && j + 1.0 < photograph.height as f64;
        within.then(|| {
            let [a, b] = [pixel.x - i, pixel.y - j];
            let node = |di: usize, dj: usize| photograph.at(i as usize + di, j as usize + dj);
            (1.0 - b) * ((1.0 - a) * node(0, 0) + a * node(1, 0)) + b * ((1.0 - a) * node(0, 1) + a * node(1, 1))
        })
    };
    let (from, count) = (-1.0, ((coupon.size().y + 2.0) / step) as usize);
    let point = |k: usize| {
        let y = from + step * k as f64;
        let place = |line: usize| DVec2::new(x + ASIDE * (2.0 * (line as f64 + 0.5) / LINES as f64 - 1.0), y);
        let known: Vec<f64> = (0..LINES).filter_map(|line| at(place(line))).collect();
        (known.len() == LINES).then(|| [y, known.iter().sum::<f64>() / LINES as f64])
    };
    (0..count).filter_map(point).collect()
}

/// Middles of the bright stripes of the passes far apart, mm on a profile: from the phase of its waves, which goes smoothly.
fn middles(coupon: &Coupon, profile: &[[f64; 2]], shift: f64, step: f64) -> Vec<f64> {
    let (tracks, apart) = (wide(coupon), apart(coupon));
    let reach = (4.0 * apart / step) as usize;
    let meant = |y: f64| y + shift + 0.25 * apart;
    let mut points = Vec::new();
    for track in tracks.iter().skip(4).step_by(2) {
        let middle = profile.partition_point(|point| point[0] < meant(track.y));
        if middle < reach || middle + reach >= profile.len() {
            continue;
        }
        let (mut re, mut im) = (0.0, 0.0);
        for (k, point) in profile[middle - reach..=middle + reach].iter().enumerate() {
            let turn = std::f64::consts::TAU * (point[0] - meant(track.y)) / apart;
            let weight = 0.5 - 0.5 * (std::f64::consts::PI * k as f64 / reach as f64).cos();
            re += weight * point[1] * turn.cos();
            im += weight * point[1] * turn.sin();
        }
        points.push([track.y, im.atan2(re) / std::f64::consts::TAU * apart]);
    }
    let end = tracks.last().map_or(1.0, |track| track.y);
    let fit = curve(&points, end);
    tracks.iter().map(|track| meant(track.y) + fit(track.y)).collect()
}

/// The cubic through points that most of them agree on.
fn curve(points: &[[f64; 2]], end: f64) -> impl Fn(f64) -> f64 + use<> {
    let basis = move |y: f64| {
        let share = 2.0 * y / end - 1.0;
        nalgebra::Vector4::new(1.0, share, share * share, share.powi(3))
    };
    let mut fit = nalgebra::Vector4::zeros();
    let mut kept = points.to_vec();
    for _ in 0..3 {
        fit = linear_fit(kept.iter().map(|[y, value]| (basis(*y), *value)), 1e-9).map_or(fit, |fit| fit.of);
        let off = |point: &[f64; 2]| (point[1] - fit.dot(&basis(point[0]))).abs();
        let mut offs: Vec<f64> = kept.iter().map(off).collect();
        offs.sort_unstable_by(f64::total_cmp);
        let most = 4.0 * offs.get(offs.len() / 2).copied().unwrap_or(f64::INFINITY);
        kept.retain(|point| off(point) <= most);
    }
    move |y| fit.dot(&basis(y))
}

/// Width of the bright stripe around each of `middles`, mm. Where nothing is polished, bright and dark are what lies in the
/// middles of stripes and between them; else what is as bright or as dark as anything there.
fn bright(profile: &[[f64; 2]], middles: &[f64], (apart, polished): (f64, bool)) -> Vec<f64> {
    let [from, to] = [middles[0] - apart, middles[middles.len() - 1] + apart];
    let inner: Vec<[f64; 2]> = profile.iter().copied().filter(|point| point[0] > from && point[0] < to).collect();
    let mut sorted: Vec<f64> = inner.iter().map(|point| point[1]).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    if sorted.len() < 100 {
        return vec![f64::NAN; middles.len()];
    }
    let [low, high] = [0.03, 0.97].map(|share| sorted[(share * (sorted.len() - 1) as f64) as usize]);
    // Bright and dark change slowly over the piece.
    let basis = |y: f64| {
        let share = 2.0 * (y - from) / (to - from) - 1.0;
        nalgebra::Vector3::new(1.0, share, share * share)
    };
    let mut levels = [nalgebra::Vector3::new(low, 0.0, 0.0), nalgebra::Vector3::new(high, 0.0, 0.0)];
    for _ in 0..4 {
        let share = |point: &[f64; 2]| {
            let [dark, light] = levels.map(|level| level.dot(&basis(point[0])));
            (point[1] - dark) / (light - dark)
        };
        let from_middle = |y: f64| {
            let after = middles.partition_point(|middle| *middle < y);
            let near = [after.saturating_sub(1), after.min(middles.len() - 1)].map(|k| (y - middles[k]).abs());
            near[0].min(near[1]) / apart
        };
        let counts = |point: &[f64; 2], least: f64, most: f64, place: f64| match polished {
            true => (least..most).contains(&share(point)),
            false => (from_middle(point[0]) - place).abs() < INNER,
        };
        let fitted = [[-0.3, 0.06, 0.5], [0.94, 1.3, 0.0]].map(|[least, most, place]| {
            let points = inner.iter().filter(|point| counts(point, least, most, place));
            linear_fit(points.map(|point| (basis(point[0]), point[1])), 1e-9).map(|fit| fit.of)
        });
        levels = [fitted[0].unwrap_or(levels[0]), fitted[1].unwrap_or(levels[1])];
    }
    let share = |point: &[f64; 2]| {
        let [dark, light] = levels.map(|level| level.dot(&basis(point[0])));
        (point[1] - dark) / (light - dark)
    };
    let step = inner[1][0] - inner[0][0];
    let stripe = |k: usize| {
        // Passes are as far apart as the photograph has them there, where its scale is not quite what the corners say.
        let (before, after) = (k.saturating_sub(4), (k + 4).min(middles.len() - 1));
        let local = (middles[after] - middles[before]) / (after - before) as f64;
        let middle = middles[k];
        // The points within half a pass on either side, those at its ends in part.
        let sum = |point: &[f64; 2]| {
            let inside = (0.5 * (local + step) - (point[0] - middle).abs()) / step;
            share(point) * inside.clamp(0.0, 1.0) * step
        };
        let near = profile.partition_point(|point| point[0] < middle - apart);
        let wide = profile[near..].iter().take_while(|point| point[0] < middle + apart).map(sum).sum::<f64>();
        wide * apart / local
    };
    (0..middles.len()).map(stripe).collect()
}
