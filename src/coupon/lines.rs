//! The passes of a test piece found in lines across them.

use super::groove::{Groove, Window};
use super::layout::{Coupon, Kind, Place};
use super::scan::Line;

/// How far a scan may be shifted across the passes, mm.
const SHIFT: f64 = 1.5;

/// Places between two passes far apart at which a line is compared with what is meant.
pub(super) const STEPS: f64 = 24.0;

/// Least likeness (correlation) of a line with the grooves that are meant. Scans of other surfaces reach 0.1; of a piece on
/// the worst machine 0.8.
pub(super) const LIKE: f64 = 0.4;

/// Most lines that are read: of a grid a part.
const MOST: usize = 60;

/// A line whose grooves are known.
pub struct Grooves {
    /// Where it lies along the passes, mm.
    pub x: f64,
    /// What lies there.
    pub place: Place,
    /// The grooves of the passes far apart, in their order; none where points are missing.
    pub grooves: Vec<Option<Groove>>,
    /// Standard deviation of a single point, mm.
    pub noise: f64,
    /// Its points, their places as those of the piece.
    pub points: Vec<[f64; 2]>,
}

/// The lines of a scan, found on `coupon`.
///
/// # Errors
/// Its grooves are not there, or look like those in another unit.
pub fn found(coupon: &Coupon, scan: &[Line]) -> Result<Vec<Grooves>, NotFound> {
    let every = scan.len().div_ceil(MOST);
    let placed: Vec<(&Line, Place)> =
        scan.iter().step_by(every).filter_map(|line| Some((line, coupon.place(line.x)?))).collect();
    let template = Template::new(coupon);
    let likeness: Vec<Vec<f64>> = placed.iter().map(|line| template.likeness(&line.0.points)).collect();
    let rough: Vec<usize> = (0..placed.len()).filter(|k| placed[*k].1 != Place::Polished).collect();
    if rough.is_empty() {
        return Err(unplaced(coupon, scan));
    }
    // All lines lie beside their places by about as much.
    let sum = |k: usize| rough.iter().map(|line| likeness[*line][k]).sum::<f64>() / rough.len() as f64;
    let (best, most) = largest((0..likeness[0].len()).map(|k| (k, sum(k))));
    match most {
        most if most < LIKE => Err(unlike(coupon, scan, most)),
        _ => {
            let near = STEPS as usize / 2;
            let read = |((line, place), likeness): (&(&Line, Place), &Vec<f64>)| {
                let own = likeness.iter().copied().enumerate().skip(best.saturating_sub(near)).take(2 * near);
                let (own, likeness) = largest(own);
                // A polished line may have no grooves left to be found by.
                let shift = template.shift(if likeness >= LIKE { own } else { best });
                grooves(coupon, line, *place, shift)
            };
            let lines: Vec<Grooves> = placed.iter().zip(&likeness).map(read).collect();
            match roundness(&lines) {
                round if (0.5..2.0).contains(&round) => Ok(lines),
                round => Err(NotFound(format!(
                    "its grooves are {round:.3} times as round as {} leaves them: see that z is in the unit that it is said \
                     to be in{}",
                    coupon.cutter,
                    unit_of(round)
                ))),
            }
        }
    }
}

/// How round grooves are beside the cutter, by half of them.
fn roundness(lines: &[Grooves]) -> f64 {
    let unpolished = lines.iter().filter(|line| line.place != Place::Polished);
    let mut all: Vec<f64> =
        unpolished.flat_map(|line| line.grooves.iter().flatten().map(|own| own.roundness)).collect();
    all.sort_unstable_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or_default()
}

/// The passes that are read: all that are far apart.
pub fn wide(coupon: &Coupon) -> Vec<super::layout::Track> {
    let is_wide = |band: usize| matches!(coupon.bands[band].kind, Kind::OneWay | Kind::ToAndFro);
    coupon.tracks().into_iter().filter(|track| is_wide(track.band)).collect()
}

/// From one of these to the next, mm.
pub fn apart(coupon: &Coupon) -> f64 {
    coupon.bands.iter().find(|band| band.kind == Kind::OneWay).map_or(coupon.widest(), |band| band.stepover)
}

/// The grooves of a line that lies `shift` mm beside its place.
fn grooves(coupon: &Coupon, line: &Line, place: Place, shift: f64) -> Grooves {
    let window = Window::new(coupon.cutter.profile(), apart(coupon));
    let tracks = wide(coupon);
    let mut points: Vec<[f64; 2]> = line.points.iter().map(|[y, z]| [y - shift, *z]).collect();
    let fitted = |points: &[[f64; 2]]| -> Vec<Option<Groove>> {
        let one = |track: &super::layout::Track| {
            let from = points.partition_point(|point| point[0] < track.y - window.half());
            let to = points.partition_point(|point| point[0] <= track.y + window.half());
            window.fit(points[from..to].iter().map(|[y, z]| [y - track.y, *z]))
        };
        tracks.iter().map(one).collect()
    };
    // Twice: middles of grooves say where the line begins, and by how much its scale is off.
    let mut all = fitted(&points);
    for _ in 0..2 {
        let asides: Vec<[f64; 2]> =
            tracks.iter().zip(&all).filter_map(|(track, own)| Some([track.y, own.as_ref()?.aside])).collect();
        let [at, by] = straight(&asides);
        let limit = 0.2 * window.half();
        points.iter_mut().for_each(|point| point[0] -= (at + by * point[0]).clamp(-limit, limit));
        all = fitted(&points);
    }
    Grooves { x: line.x, place, grooves: all, noise: noise(&line.points), points }
}

/// Level and rise of the straight line through points; most of them count, not those farthest off.
pub(super) fn straight(points: &[[f64; 2]]) -> [f64; 2] {
    let mut fit = [0.0; 2];
    let mut kept: Vec<[f64; 2]> = points.to_vec();
    for _ in 0..3 {
        let n = kept.len() as f64;
        if n < 3.0 {
            break;
        }
        let mean = |k: usize| kept.iter().map(|point| point[k]).sum::<f64>() / n;
        let (x, y) = (mean(0), mean(1));
        let square: f64 = kept.iter().map(|point| (point[0] - x).powi(2)).sum();
        let product: f64 = kept.iter().map(|point| (point[0] - x) * (point[1] - y)).sum();
        let rise = product / square.max(f64::MIN_POSITIVE);
        fit = [y - rise * x, rise];
        let off = |point: &[f64; 2]| (point[1] - fit[0] - fit[1] * point[0]).abs();
        let mut offs: Vec<f64> = kept.iter().map(off).collect();
        offs.sort_unstable_by(f64::total_cmp);
        let most = 4.0 * offs[offs.len() / 2];
        kept.retain(|point| off(point) <= most);
    }
    fit
}

/// Standard deviation of a single point, from third differences: surfaces are smooth from point to point, noise is not.
fn noise(points: &[[f64; 2]]) -> f64 {
    let mut thirds: Vec<f64> =
        points.windows(4).map(|p| (p[3][1] - 3.0 * p[2][1] + 3.0 * p[1][1] - p[0][1]).abs()).collect();
    thirds.sort_unstable_by(f64::total_cmp);
    // The median of what is normal is 0.6745 standard deviations; a third difference has √20 of a point's.
    thirds.get(thirds.len() / 2).map_or(0.0, |median| median / 0.6745 / 20f64.sqrt())
}

/// What is meant, as it is compared.
pub(super) struct Template {
    step: f64,
    /// Waves of two passes around each place, all as high.
    heights: Vec<f64>,
}

impl Template {
    fn new(coupon: &Coupon) -> Self {
        let profile = coupon.cutter.profile();
        Self::of(coupon, |before, after| profile.underside(before.min(after)))
    }

    /// Of bright stripes in place of grooves: from the middle of each half-way to the next.
    pub(super) fn of_stripes(coupon: &Coupon) -> Self {
        // Closer than half as far apart they are too fine for a camera.
        let mut coarse = coupon.clone();
        let fine = 0.45 * apart(coupon);
        coarse.bands.retain(|band| band.stepover > fine && band.kind != Kind::Domes);
        Self::of(&coarse, |before, after| if before < after { 1.0 } else { 0.0 })
    }

    /// Of what lies so far from the pass before and from the next one, mm, as far as there are no domes.
    fn of(coupon: &Coupon, height: impl Fn(f64, f64) -> f64) -> Self {
        let step = apart(coupon) / STEPS;
        let tracks: Vec<f64> = coupon.tracks().iter().map(|track| track.y).collect();
        let domes = coupon.bands.iter().zip(coupon.begins()).find(|(band, _)| band.kind == Kind::Domes);
        let end = domes.map_or(coupon.size().y, |(_, begin)| begin);
        let at = |k: usize| {
            let y = step * k as f64;
            let after = tracks.partition_point(|track| *track < y);
            let before = after.checked_sub(1).map_or(f64::INFINITY, |k| y - tracks[k]);
            height(before, tracks.get(after).map_or(f64::INFINITY, |track| track - y))
        };
        let heights: Vec<f64> = (0..(end / step) as usize).map(at).collect();
        Self { step, heights: waves(&heights) }
    }

    /// How like it points are at every shift, from [`SHIFT`] mm down to as much up.
    pub(super) fn likeness(&self, points: &[[f64; 2]]) -> Vec<f64> {
        let count = self.heights.len() + (2.0 * SHIFT / self.step) as usize;
        let z = waves(&even(points, -SHIFT, self.step, count));
        let at = |k: usize| {
            let (mut both, mut own, mut meant, mut met) = (0.0, 0.0, 0.0, 0.0);
            for (t, z) in self.heights.iter().zip(&z[k..]).filter(|(_, z)| z.is_finite()) {
                both += t * z;
                own += z * z;
                meant += t * t;
                met += 1.0;
            }
            let enough = met > 0.5 * self.heights.len() as f64;
            if enough { both / (own * meant).sqrt().max(f64::MIN_POSITIVE) } else { 0.0 }
        };
        (0..=count - self.heights.len()).map(at).collect()
    }

    /// Shift number `k`, mm.
    pub(super) fn shift(&self, k: usize) -> f64 {
        self.step * k as f64 - SHIFT
    }
}

/// Where the largest of `likeness` is, and it.
pub(super) fn largest(likeness: impl Iterator<Item = (usize, f64)>) -> (usize, f64) {
    likeness.fold((0, f64::NEG_INFINITY), |best, one| if one.1 > best.1 { one } else { best })
}

/// Heights at even places, mm; not a number beyond the line and within its gaps.
pub fn even(points: &[[f64; 2]], begin: f64, step: f64, count: usize) -> Vec<f64> {
    let at = |k: usize| {
        let y = begin + step * k as f64;
        let after = points.partition_point(|point| point[0] < y);
        let (Some(a), Some(b)) = (after.checked_sub(1).and_then(|k| points.get(k)), points.get(after)) else {
            return f64::NAN;
        };
        let gap = b[0] - a[0];
        if gap > 4.0 * step { f64::NAN } else { a[1] + (b[1] - a[1]) * (y - a[0]) / gap.max(f64::MIN_POSITIVE) }
    };
    (0..count).map(at).collect()
}

/// Heights less their mean over two passes around each, as multiples of their own root mean square there: shallow grooves
/// count as much as deep ones, by which a shift of one pass shows.
fn waves(heights: &[f64]) -> Vec<f64> {
    let mean = around(heights);
    let off: Vec<f64> = heights.iter().zip(mean).map(|(z, mean)| z - mean).collect();
    let squares: Vec<f64> = off.iter().map(|z| z * z).collect();
    off.iter().zip(around(&squares)).map(|(z, square)| z / square.max(f64::MIN_POSITIVE).sqrt()).collect()
}

/// The mean over two passes around each place.
fn around(heights: &[f64]) -> Vec<f64> {
    let reach = STEPS as usize;
    let mut sums = vec![(0.0, 0.0)];
    for z in heights {
        let (sum, count) = sums[sums.len() - 1];
        sums.push(if z.is_finite() { (sum + z, count + 1.0) } else { (sum, count) });
    }
    let about = |k: usize| {
        let (low, high) = (sums[k.saturating_sub(reach)], sums[(k + reach + 1).min(heights.len())]);
        (high.0 - low.0) / f64::max(high.1 - low.1, 1.0)
    };
    (0..heights.len()).map(about).collect()
}

/// What the places of lines say where none of them lies on a field.
fn unplaced(coupon: &Coupon, scan: &[Line]) -> NotFound {
    let size = coupon.size();
    let [low, high] = [scan[0].x, scan[scan.len() - 1].x];
    let lines = coupon.lines();
    let wanted: Vec<String> = lines.iter().take(3).map(|line| line.0.to_string()).collect();
    NotFound(format!(
        "its lines lie at x = {low:.4} to {high:.4}, where nothing unpolished of the piece of {:.1} × {:.1} mm is read: lines \
         at x = {} … mm were looked for, 0.3 mm beside them at the most{}",
        size.x,
        size.y,
        wanted.join(", "),
        unit_of(across(scan) / size.y)
    ))
}

/// How far a scan goes across the passes.
fn across(scan: &[Line]) -> f64 {
    let length = |line: &Line| line.points[line.points.len() - 1][0] - line.points[0][0];
    scan.iter().map(length).fold(0.0, f64::max)
}

/// What a line says that is not like the grooves.
fn unlike(coupon: &Coupon, scan: &[Line], likeness: f64) -> NotFound {
    let size = coupon.size();
    let length = across(scan);
    let said = unit_of(length / size.y);
    if !said.is_empty() {
        return NotFound(format!("a line of it is {length:.3} long, where the piece is {:.2} mm wide{said}", size.y));
    }
    let most = likeness.max(0.0);
    NotFound(format!(
        "the piece is not found in it: {} grooves {} mm apart, then closer ones, were looked for up to {SHIFT} mm beside \
         their places, and the likeness is {most:.2} where {LIKE} would do; see that it is this piece, scanned from low y to \
         high y, its x and y counted as in the program",
        wide(coupon).len(),
        apart(coupon)
    ))
}

/// Which unit lengths may be in that are so many times as long as they should be.
fn unit_of(times: f64) -> &'static str {
    let near = |of: f64| (0.5..2.0).contains(&(times / of));
    if near(1000.0) {
        ": it looks like µm; name the columns with their units, such as x_mm,y_mm,z_um"
    } else if near(1.0 / 25.4) {
        ": it looks like inches; name the columns with their units, such as x_in,y_in,z_in"
    } else if near(1e-3) {
        ": it looks like metres; write mm"
    } else {
        ""
    }
}

/// A scan or a photograph in which the test piece is not found, and what was looked for.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct NotFound(pub String);
