//! Photographs of a test piece under a lamp with a straight edge.
//!
//! The lamp's edge is mirrored by one slope, which wanders across the piece since lamp and camera are near. Of each groove
//! the part that is steeper is bright, from there to the ridge before the next groove. Where that ridge lies depends on
//! how much higher the next groove is: so the width of the bright stripe tells the difference of heights of two passes, on
//! the mean over a stretch of them. Where the slope of the edge goes through zero, stripes jump by the flat of a worn tip.
//! In the polished half slopes are gentler, and go from bright to dark within a narrower band.

use nalgebra::SVector;

use super::fields::{Field, seen};
use super::findings::{FLATS, Findings};
use super::groove::Teeth;
use super::layout::{Coupon, Kind, Place, Track};
use super::least_squares::linear_fit;
use super::lines::{NotFound, apart, wide};
pub use super::stripes::DISTANCE;
use super::stripes::{SOFT, gentle, odd, per_mm, steeper};
use super::told::{BLOCKS, Told};
use crate::raster::Raster;

/// Polish that is tried, mm, and in how many steps.
const WIDTHS: [f64; 2] = [4e-3, 0.15];
const TRIED: usize = 80;

/// What the photographs of `coupon` say of its machine, all of them together.
///
/// # Errors
/// The piece is not found in one of them.
pub fn findings(coupon: &Coupon, photographs: &[Raster]) -> Result<Findings, NotFound> {
    let mut all = Vec::new();
    for photograph in photographs {
        let fields = seen(coupon, photograph)?;
        let stripes = Stripes::new(coupon, &fields);
        let scatter = stripes.told(|without| stripes.scatter(without));
        let play = stripes.told(|without| stripes.play(without).max(0.0));
        let [scatter, play, polish] = [scatter, play, stripes.polish()].map(|told| with_share(told, SCALE));
        all.push([scatter, play, with_share(stripes.flat(), TEETH), polish]);
    }
    let untold = |what: &str| Told::Untold(format!("{what}: scan the piece for it"));
    let of = |k: usize| together(all.iter().map(|one| &one[k]));
    Ok(Findings {
        track_scatter: of(0),
        tooth_scatter: untold("a photograph does not resolve single cuts"),
        backlash_z: of(1),
        backlash_xy: untold("ramps throw the lamp elsewhere in a photograph"),
        tip_flat: of(2),
        radius_error: untold("a photograph shows slopes, and their scale is taken from the cutter's radius"),
        polish: of(3),
    })
}

/// The same, its error grown by a share of the value.
fn with_share(told: Told, share: f64) -> Told {
    match told {
        Told::Measured { value, error } => Told::Measured { value, error: error.hypot(share * value) },
        untold => untold,
    }
}

/// One figure of several photographs: their mean, those with small errors counting more; of the same passes, so that the error
/// is no smaller than the smallest.
fn together<'a>(all: impl Iterator<Item = &'a Told> + Clone) -> Told {
    let (mut sum, mut weights, mut least) = (0.0, 0.0, f64::INFINITY);
    for told in all.clone() {
        if let Told::Measured { value, error } = told {
            let weight = error.max(1e-9).powi(-2);
            (sum, weights, least) = (sum + weight * value, weights + weight, least.min(*error));
        }
    }
    let first = || all.clone().next().cloned().unwrap_or(Told::Untold("there is no photograph".into()));
    if weights > 0.0 { Told::Measured { value: sum / weights, error: least } } else { first() }
}

/// Stripes of all photographs.
struct Stripes<'a> {
    coupon: &'a Coupon,
    fields: &'a [Field],
    /// Place of each pass, its part, its sign (0 one way), and its band (0 one way, 1 to and fro).
    passes: Vec<(f64, usize, f64, usize)>,
    apart: f64,
    radius: f64,
    /// What the lamp's edge makes of stripes at each pass, mm; not a number where its slope goes through zero, and stripes
    /// jump by the tip's flat.
    edge: Vec<f64>,
    /// The slope that mirrors it in the middle of the passes.
    middle: f64,
}

/// Shares of a figure that lens, scale and the cutter's true radius leave uncertain, and of a flat what teeth that are only assumed
/// to scatter do to it: on ten simulated photographs figures were off by so much beyond what passes differ by.
const SCALE: f64 = 0.03;
const TEETH: f64 = 0.07;

/// Slopes of the lamp's edge about zero, as multiples of the lens's own, at which stripes are on their way.
const JUMP: f64 = 0.75;

impl<'a> Stripes<'a> {
    fn new(coupon: &'a Coupon, fields: &'a [Field]) -> Self {
        let tracks = wide(coupon);
        let count = tracks.len();
        let pass = |(k, track): (usize, &Track)| {
            let fro = coupon.bands[track.band].kind == Kind::ToAndFro;
            let side = if !fro {
                0.0
            } else if track.backward {
                -0.5
            } else {
                0.5
            };
            (track.y, BLOCKS * k / count, side, usize::from(fro))
        };
        let passes = tracks.iter().enumerate().map(pass).collect();
        let (apart, radius) = (apart(coupon), coupon.cutter.valley_radius());
        let mut own = Self { coupon, fields, passes, apart, radius, edge: vec![0.0; count], middle: 0.0 };
        let tables = own.tables(coupon.machine.tooth_scatter);
        let (flat, middle) = own.tip(&own.mean(&[Place::AfterHill, Place::AfterValley]), &tables, None);
        let near = (0..FLATS.len()).min_by(|a, b| (FLATS[*a] - flat).abs().total_cmp(&(FLATS[*b] - flat).abs()));
        let table = &tables[near.unwrap_or_default()];
        let edge = |k: usize| {
            let slope = own.slope(k, middle);
            if slope.abs() < JUMP * SOFT { f64::NAN } else { -odd(table, slope) }
        };
        own.edge = (0..count).map(edge).collect();
        own.middle = middle;
        own
    }

    /// A figure with what it is without each part.
    fn told(&self, figure: impl Fn(Option<usize>) -> f64) -> Told {
        let without: Vec<f64> = (0..BLOCKS).map(|block| figure(Some(block))).collect();
        Told::jackknife(figure(None), &without)
    }

    fn of(&self, places: &[Place]) -> Vec<&Field> {
        self.fields.iter().filter(|field| places.contains(&field.place)).collect()
    }

    /// Stripes less what goes smoothly along the piece, and how much wider those of passes to are than those fro, mm.
    fn rest(&self, field: &Field, without: Option<usize>) -> (Vec<f64>, f64) {
        let end = self.passes.last().map_or(1.0, |pass| pass.0);
        let basis = |k: usize| {
            let (y, _, side, _) = self.passes[k];
            let x = 2.0 * y / end - 1.0;
            SVector::<f64, 9>::from([1.0, x, x.powi(2), x.powi(3), x.powi(4), x.powi(5), x.powi(6), x.powi(7), side])
        };
        let stripe = |k: usize| field.bright[k] - self.edge[k];
        let kept = |k: &usize| Some(self.passes[*k].1) != without && stripe(*k).is_finite();
        let points = (0..self.passes.len()).filter(kept).map(|k| (basis(k), stripe(k)));
        let fit = linear_fit(points, 1e-12).map_or_else(SVector::<f64, 9>::zeros, |fit| fit.of);
        let rest = |k: usize| if kept(&k) { stripe(k) - fit.dot(&basis(k)) } else { f64::NAN };
        ((0..self.passes.len()).map(rest).collect(), fit[8])
    }

    /// Scatter from track to track, mm: what stripes of two fields have in common, with their own neighbours' share.
    fn scatter(&self, without: Option<usize>) -> f64 {
        let fields = self.of(&[Place::AfterHill, Place::AfterValley]);
        let rests: Vec<Vec<f64>> = fields.iter().map(|field| self.rest(field, without).0).collect();
        let (mut sum, mut count) = (0.0, 0.0);
        for (i, a) in rests.iter().enumerate() {
            for b in &rests[i + 1..] {
                for k in 0..a.len() {
                    if (a[k] * b[k]).is_finite() {
                        sum += a[k] * b[k];
                        count += 1.0;
                    }
                }
            }
        }
        // Nine coefficients are taken from every field.
        let passes = self.passes.len() as f64;
        let common = sum / f64::max(count, 1.0) * passes / (passes - 9.0);
        // A ridge moves by R/w of the difference of two heights.
        (0.5 * common.max(0.0)).sqrt() * self.apart / self.radius
    }

    /// Play of z, mm: after a hill passes to are high and those fro low, after a valley the other way round.
    fn play(&self, without: Option<usize>) -> f64 {
        let mean = |place: Place| {
            let fields = self.of(&[place]);
            fields.iter().map(|field| self.rest(field, without).1).sum::<f64>() / fields.len() as f64
        };
        // A stripe is narrower by what its own pass is higher, and by what the next one is lower.
        0.25 * (mean(Place::AfterValley) - mean(Place::AfterHill)) * self.apart / self.radius
    }

    /// Mean stripes of fields at each pass, mm.
    fn mean(&self, places: &[Place]) -> Vec<f64> {
        let fields = self.of(places);
        (0..self.passes.len())
            .map(|k| fields.iter().map(|field| field.bright[k]).sum::<f64>() / fields.len() as f64)
            .collect()
    }

    /// The slope that mirrors the lamp's edge at each pass, if it is `middle` in the middle of them.
    fn slope(&self, k: usize, middle: f64) -> f64 {
        let [first, last] = [self.passes[0].0, self.passes[self.passes.len() - 1].0];
        middle + per_mm() * (self.passes[k].0 - 0.5 * (first + last))
    }

    /// What stripes of a tip whose grooves are as gentle as `table` says are off, all of them by as much apart, and the slope in
    /// the middle at which they are least.
    fn off(&self, stripes: &[f64], table: &[f64], without: Option<usize>) -> (f64, f64) {
        let kept: Vec<usize> =
            (0..stripes.len()).filter(|k| Some(self.passes[*k].1) != without && stripes[*k].is_finite()).collect();
        let sum = |middle: f64| {
            let off = kept.iter().map(|k| stripes[*k] + odd(table, self.slope(*k, middle)));
            let (sum, squares) = off.fold((0.0, 0.0), |all: (f64, f64), off| (all.0 + off, all.1 + off * off));
            squares - sum * sum / kept.len().max(1) as f64
        };
        let of = |around: f64, step: f64, count: i32| {
            let all = (-count..=count).map(|k| around + step * f64::from(k)).map(|middle| (sum(middle), middle));
            all.fold((f64::INFINITY, 0.0), |best, one| if one.0 < best.0 { one } else { best })
        };
        // Coarsely over all that a hand may miss, then finely.
        let coarse = of(0.0, 1.5e-3, 20);
        of(coarse.1, 1.5e-4, 10)
    }

    /// The flat of the tip, mm, and the slope in the middle.
    fn tip(&self, stripes: &[f64], tables: &[Vec<f64>], without: Option<usize>) -> (f64, f64) {
        let offs: Vec<(f64, f64)> = tables.iter().map(|table| self.off(stripes, table, without)).collect();
        let best = offs.iter().enumerate().min_by(|a, b| a.1.0.total_cmp(&b.1.0)).map_or(0, |best| best.0);
        let last = FLATS.len() - 1;
        let (a, c) = (best.saturating_sub(1), (best + 1).min(last));
        if a == best || c == best {
            return (FLATS[best], offs[best].1);
        }
        // The parabola through three that are not equally far apart.
        let [x0, x1, x2] = [FLATS[a], FLATS[best], FLATS[c]];
        let [d0, d2] = [(offs[a].0 - offs[best].0) / (x0 - x1), (offs[c].0 - offs[best].0) / (x2 - x1)];
        let bend = (d2 - d0) / (x2 - x0);
        let at = x1 - 0.5 * (d0 - bend * (x0 - x1)) / bend;
        (if at.is_finite() { at.clamp(x0, x2) } else { x1 }, offs[best].1)
    }

    fn tables(&self, scatter: f64) -> Vec<Vec<f64>> {
        let feed = self.coupon.machine.feed_per_tooth;
        let profile = self.coupon.cutter.profile();
        FLATS.iter().map(|flat| gentle(&profile, Teeth { feed, scatter, flat: *flat }, 0.4 * self.apart)).collect()
    }

    fn flat(&self) -> Told {
        let stripes = self.mean(&[Place::AfterHill, Place::AfterValley]);
        let assumed = self.coupon.machine.tooth_scatter;
        let tables = self.tables(assumed);
        // Teeth that scatter leave parts of their flats only; by how much is assumed, half or twice as much be possible.
        let [less, more] = [0.5, 2.0].map(|times| self.tip(&stripes, &self.tables(times * assumed), None).0);
        match self.told(|without| self.tip(&stripes, &tables, without).0) {
            Told::Measured { value, error } => Told::Measured { value, error: error.hypot(0.5 * (more - less)) },
            untold => untold,
        }
    }

    fn polish(&self) -> Told {
        let polished = self.mean(&[Place::Polished]);
        let (scatter, error) = match self.told(|without| self.scatter(without)) {
            Told::Measured { value, error } => (value, error),
            untold => return untold,
        };
        let profile = self.coupon.cutter.profile();
        let width = |k: usize| WIDTHS[0] * (WIDTHS[1] / WIDTHS[0]).powf(k as f64 / (TRIED - 1) as f64);
        let offs = |scatter: f64, middle: f64| -> Vec<Vec<f64>> {
            let slopes: Vec<f64> = (0..polished.len()).map(|k| self.slope(k, middle)).collect();
            let off = |k: usize| {
                let shares = steeper(&profile, self.apart, (width(k), scatter), &slopes);
                shares.iter().zip(&polished).map(|(share, seen)| (share - seen / self.apart).powi(2)).collect()
            };
            (0..TRIED).map(off).collect()
        };
        let best = |offs: &[Vec<f64>], without: Option<usize>| {
            let sum = |off: &Vec<f64>| {
                let kept =
                    off.iter().zip(&self.passes).filter(|(off, pass)| Some(pass.1) != without && off.is_finite());
                kept.map(|(off, _)| off).sum::<f64>()
            };
            let sums: Vec<f64> = offs.iter().map(sum).collect();
            let k = sums.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |best| best.0);
            if k == 0 || k + 1 == TRIED {
                return (width(k), sums[k]);
            }
            let bend = sums[k - 1] - 2.0 * sums[k] + sums[k + 1];
            let aside = 0.5 * (sums[k - 1] - sums[k + 1]) / bend;
            (width(0) * (width(1) / width(0)).powf(k as f64 + aside), sums[k])
        };
        // Where the lamp's edge goes through zero shows in this half as well.
        let middles = (-6..=6).map(|k| self.middle + 2.5e-4 * f64::from(k));
        let all = middles.map(|middle| (middle, best(&offs(scatter, middle), None).1));
        let (middle, _) = all.fold((0.0, f64::INFINITY), |least, one| if one.1 < least.1 { one } else { least });
        let own = offs(scatter, middle);
        let told = self.told(|without| best(&own, without).0);
        // Slopes that are left of scatter are taken from what was found of it.
        let more = best(&offs(scatter + error, middle), None).0;
        let less = best(&offs((scatter - error).max(0.0), middle), None).0;
        match told {
            Told::Measured { value, .. } if value <= width(1) => {
                Told::Untold("the right half is not polished: its stripes are those of the left half".into())
            }
            Told::Measured { value, .. } if value >= width(TRIED - 2) => {
                Told::Untold("nothing is left of the grooves in the polished half".into())
            }
            Told::Measured { value, error } => Told::Measured { value, error: error.hypot(0.5 * (more - less)) },
            untold => untold,
        }
    }
}
