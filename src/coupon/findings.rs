//! What a scan of the test piece says of its machine: scatter, play, tip and polish, each with its standard error.
//!
//! Heights of the grooves' bottoms on level lines are a sum of line, pass and what is left: the spread of passes is the
//! scatter from track to track, what is left comes from single teeth. On level places the slide stands high after it came
//! down and low after it went up, and the other way round on the way back: the difference between passes to and fro is the
//! play. Errors are from leaving out each twentieth of the passes in turn (jackknife), which asks for no model of noise.

use super::groove::{PARTS, Simulated, Teeth, Window, at_place, scatter_of, simulated};
use super::layout::{Coupon, Kind, Place, Track, ramp};
use super::least_squares::linear_fit;
use super::lines::{Grooves, apart, wide};
use super::polished::Polished;
use super::told::{BLOCKS, Told};
use crate::milling::machine::Machine;

/// Flats of a worn tip that are compared with the grooves, mm; between them straight lines.
pub(super) const FLATS: [f64; 15] =
    [0.0, 1e-3, 2e-3, 3e-3, 4e-3, 5e-3, 6e-3, 8e-3, 10e-3, 12e-3, 15e-3, 18e-3, 22e-3, 27e-3, 33e-3];

/// What a test piece says.
#[derive(Clone, Debug, PartialEq)]
pub struct Findings {
    /// Scatter of heights from track to track.
    pub track_scatter: Told,
    /// From tooth to tooth.
    pub tooth_scatter: Told,
    /// Play of z.
    pub backlash_z: Told,
    /// Play of x and y.
    pub backlash_xy: Told,
    /// Radius of the flat at the tip.
    pub tip_flat: Told,
    /// By how much the cutter is larger all around.
    pub radius_error: Told,
    /// Standard deviation of the polish.
    pub polish: Told,
}

impl Findings {
    /// Of the lines of a scan of `coupon`.
    pub fn of(coupon: &Coupon, lines: &[Grooves]) -> Self {
        let passes = Passes::new(coupon, lines);
        let whole = passes.figures(None);
        let without: Vec<Figures> = (0..BLOCKS).map(|block| passes.figures(Some(block))).collect();
        let told = |of: &dyn Fn(&Figures) -> f64| {
            let value = of(&whole);
            let without: Vec<f64> = without.iter().map(of).collect();
            Told::jackknife(value, &without)
        };
        let window = Window::new(coupon.cutter.profile(), apart(coupon));
        let feed = coupon.machine.feed_per_tooth;
        let tip = Tip::new(&window, feed, &whole);
        // What single teeth leave in the mean of several lines is no scatter of passes.
        let track = |f: &Figures| f.between.max(0.0).sqrt();
        let level = passes.level.len();
        let few =
            || Told::Untold(format!("it takes two level lines across the unpolished half, and {level} are there"));
        let track_scatter = if level < 2 { few() } else { root(&told(&|f| f.between), told(&track)) };
        let tooth_scatter = match (level < 2, feed > 0.0, whole.within > 0.0) {
            (true, ..) => few(),
            (_, false, _) => {
                Told::Untold("the machine's file says no feed-per-tooth, without which cuts have no distance".into())
            }
            (.., false) => Told::Untold(
                "heights differ no more along a pass than single points do: finer points would tell".into(),
            ),
            _ => {
                let scatter =
                    |f: &Figures| tip.scatter * (f.within.max(0.01 * whole.within) / whole.within).powf(tip.power);
                told(&scatter)
            }
        };
        let [after, before] = [Place::AfterHill, Place::AfterValley].map(|place| passes.has(place));
        let backlash_z = match after && before {
            true => not_below_nothing(told(&|f| f.play)),
            false => Told::Untold("it takes a level line after a hill and one after a valley".into()),
        };
        let ramps = [Place::Up, Place::Down].map(|place| passes.has(place)) == [true; 2];
        let backlash_xy = match ramps && after && before {
            true => not_below_nothing(told(&|f| (f.slanted - f.play) / ramp())),
            false => Told::Untold("it takes a line over a ramp up and one over a ramp down".into()),
        };
        let radius = coupon.cutter.valley_radius();
        Self {
            track_scatter,
            tooth_scatter,
            backlash_z,
            backlash_xy,
            tip_flat: told(&|f| tip.flat(&f.left)),
            radius_error: told(&|f| radius * (tip.roundness / f.roundness - 1.0)),
            polish: Polished::told(coupon, lines),
        }
    }

    /// Each with its key in a machine's file, in the order of that file.
    pub fn by_key(&self) -> [(&'static str, &Told); 7] {
        [
            ("backlash-xy", &self.backlash_xy),
            ("backlash-z", &self.backlash_z),
            ("track-scatter", &self.track_scatter),
            ("tooth-scatter", &self.tooth_scatter),
            ("tip-flat", &self.tip_flat),
            ("radius-error", &self.radius_error),
            ("polish", &self.polish),
        ]
    }

    /// `machine` with what was measured in place of what was assumed.
    pub fn laid_over(&self, machine: &Machine) -> Machine {
        let mut of = machine.clone();
        // A tenth of a nanometre is beyond every instrument.
        let measured = |told: &Told| told.value().map(|value| (value * 1e7).round() / 1e7);
        let set = |field: &mut f64, told: &Told| *field = measured(told).unwrap_or(*field);
        set(&mut of.track_scatter, &self.track_scatter);
        set(&mut of.tooth_scatter, &self.tooth_scatter);
        set(&mut of.backlash_z, &self.backlash_z);
        set(&mut of.backlash_xy, &self.backlash_xy);
        set(&mut of.tip_flat, &self.tip_flat);
        set(&mut of.radius_error, &self.radius_error);
        of.polish = measured(&self.polish).or(of.polish);
        of.name = format!("{}-measured", machine.name.trim_end_matches("-measured"));
        of
    }

    /// The machine's file: `machine` with what was measured laid over it, each such line saying so.
    pub fn file(&self, machine: &Machine, from: &str) -> String {
        let mut text = format!(
            "# Read from a test piece by {from}; what is marked so was measured, all else is as it was thought to be\n"
        );
        for line in self.laid_over(machine).to_toml().lines() {
            let told = self.by_key().into_iter().find(|(key, _)| line.starts_with(&format!("{key} =")));
            let remark = match told {
                Some((_, Told::Measured { error, .. })) => format!(" # measured, standard error {error:.7}"),
                Some((_, Told::Untold(_))) => " # assumed".to_owned(),
                None => String::new(),
            };
            text += &format!("{line}{remark}\n");
        }
        text
    }
}

/// The root of a variance that may be nothing within its error: then what it may be.
fn root(variance: &Told, told: Told) -> Told {
    match (variance, told) {
        (Told::Measured { value, error }, Told::Measured { value: own, .. }) if *value < *error => {
            Told::Measured { value: own, error: (value.max(0.0) + error).sqrt() }
        }
        (_, told) => told,
    }
}

fn not_below_nothing(told: Told) -> Told {
    match told {
        Told::Measured { value, error } => Told::Measured { value: value.max(0.0), error },
        untold => untold,
    }
}

/// Figures of all passes, or of all but a part of them.
struct Figures {
    /// Variance of bottoms within passes, less that of single points, and between passes, mm².
    within: f64,
    between: f64,
    /// Play on level places, and with what a shift along ramps adds, mm.
    play: f64,
    slanted: f64,
    /// Mean roundness, and mean of what fits leave, mm.
    roundness: f64,
    left: [f64; PARTS],
    /// Where the points of each part lie, as a share of the way from a groove's middle to its end.
    places: [f64; PARTS],
}

/// Passes with their lines.
struct Passes<'a> {
    tracks: Vec<Track>,
    /// Band of each: 0 one way, 1 to and fro.
    group: Vec<usize>,
    /// Part that it is left out with.
    block: Vec<usize>,
    lines: &'a [Grooves],
    /// The level lines of the unpolished half.
    level: Vec<&'a Grooves>,
}

impl<'a> Passes<'a> {
    fn new(coupon: &Coupon, lines: &'a [Grooves]) -> Self {
        let tracks = wide(coupon);
        let of_kind = |kind| tracks.iter().filter(|track| coupon.bands[track.band].kind == kind).count();
        let counts = [of_kind(Kind::OneWay), of_kind(Kind::ToAndFro)];
        let (mut group, mut block, mut seen) = (Vec::new(), Vec::new(), [0; 2]);
        for track in &tracks {
            let own = usize::from(coupon.bands[track.band].kind == Kind::ToAndFro);
            group.push(own);
            block.push(BLOCKS * seen[own] / counts[own].max(1));
            seen[own] += 1;
        }
        let is_level = |line: &&Grooves| matches!(line.place, Place::AfterHill | Place::AfterValley);
        Self { tracks, group, block, lines, level: lines.iter().filter(is_level).collect() }
    }

    fn has(&self, place: Place) -> bool {
        self.lines.iter().any(|line| line.place == place)
    }

    /// Bottoms of a line without what goes evenly along it, and without the mean of passes one way, to, and fro; not a number
    /// where there is none, or where it is left out.
    fn bottoms(&self, line: &Grooves, without: Option<usize>) -> Vec<f64> {
        let end = self.tracks.last().map_or(1.0, |track| track.y);
        let kept = |k: usize| Some(self.block[k]) != without;
        let known: Vec<(usize, f64)> = line
            .grooves
            .iter()
            .enumerate()
            .filter(|(k, _)| kept(*k))
            .filter_map(|(k, g)| Some((k, g.as_ref()?.bottom)))
            .collect();
        // Level of each group, tilt and bow.
        let basis = |k: usize| {
            let share = self.tracks[k].y / end - 0.5;
            let mut basis = nalgebra::Vector5::zeros();
            basis[self.group[k] + usize::from(self.tracks[k].backward)] = 1.0;
            basis[3] = share;
            basis[4] = share * share - 1.0 / 12.0;
            basis
        };
        let fit = linear_fit(known.iter().map(|(k, z)| (basis(*k), *z)), 0.0);
        let fit = fit.map_or_else(nalgebra::Vector5::zeros, |fit| fit.of);
        let mut bottoms = vec![f64::NAN; self.tracks.len()];
        known.into_iter().for_each(|(k, z)| bottoms[k] = z - fit.dot(&basis(k)));
        bottoms
    }

    fn figures(&self, without: Option<usize>) -> Figures {
        let (within, between) = self.variances(without);
        let play = self.to_and_fro(Place::AfterHill, Place::AfterValley, without);
        let slanted = self.to_and_fro(Place::Down, Place::Up, without);
        let (mut roundness, mut count, mut left) = (0.0, 0.0, [[0.0; 3]; PARTS]);
        for line in &self.level {
            for (groove, _) in line.grooves.iter().zip(&self.block).filter(|(_, block)| Some(**block) != without) {
                let Some(groove) = groove else { continue };
                roundness += groove.roundness;
                count += 1.0;
                for (all, own) in left.iter_mut().zip(&groove.left) {
                    all.iter_mut().zip(own).for_each(|(all, own)| *all += own);
                }
            }
        }
        let places = left.map(|[_, count, squares]| (squares / f64::max(count, 1.0)).sqrt());
        let left = left.map(|[sum, count, _]| sum / f64::max(count, 1.0));
        Figures { within, between, play, slanted, roundness: roundness / f64::max(count, 1.0), left, places }
    }

    /// Variances of the bottoms on level lines within and between passes, mm².
    fn variances(&self, without: Option<usize>) -> (f64, f64) {
        let lines: Vec<Vec<f64>> = self.level.iter().map(|line| self.bottoms(line, without)).collect();
        let mut noise = (0.0, 0.0);
        for line in &self.level {
            for groove in line.grooves.iter().flatten() {
                noise = (noise.0 + groove.noise_share * line.noise * line.noise, noise.1 + 1.0);
            }
        }
        let noise = noise.0 / f64::max(noise.1, 1.0);
        let (mut inside, mut degrees, mut means) = (0.0, 0.0, Vec::new());
        for k in 0..self.tracks.len() {
            let known: Vec<f64> = lines.iter().map(|line| line[k]).filter(|z| z.is_finite()).collect();
            let n = known.len() as f64;
            if n < 2.0 {
                continue;
            }
            let mean = known.iter().sum::<f64>() / n;
            inside += known.iter().map(|z| (z - mean).powi(2)).sum::<f64>();
            degrees += n - 1.0;
            means.push((mean, n));
        }
        // Three levels, tilt and bow are taken from every line.
        let passes = means.len() as f64;
        let taken = (passes - 5.0).max(1.0) / passes.max(1.0);
        let all = inside / f64::max(degrees * taken, 1.0);
        let of_means = means.iter().map(|(mean, _)| mean * mean).sum::<f64>() / (passes - 5.0).max(1.0);
        let a_mean = means.iter().map(|(_, n)| 1.0 / n).sum::<f64>() / passes.max(1.0);
        (all - noise, of_means - all * a_mean)
    }

    /// Half of how much more passes to lie above those fro on lines over `high` than on those over `low`, mm.
    fn to_and_fro(&self, high: Place, low: Place, without: Option<usize>) -> f64 {
        let difference = |place: Place| {
            let (mut sum, mut lines) = (0.0, 0.0);
            for line in self.lines.iter().filter(|line| line.place == place) {
                sum += self.difference(line, without);
                lines += 1.0;
            }
            sum / lines
        };
        0.5 * (difference(high) - difference(low))
    }

    /// How much passes to lie above those fro, mm: each against the mean of its neighbours, so that what goes evenly along the
    /// line drops out.
    fn difference(&self, line: &Grooves, without: Option<usize>) -> f64 {
        let bottom = |k: usize| {
            let kept = self.group[k] == 1 && Some(self.block[k]) != without;
            line.grooves[k].as_ref().filter(|_| kept).map(|groove| groove.bottom)
        };
        let end = self.tracks.last().map_or(1.0, |track| track.y);
        let (mut square, mut product) = (nalgebra::Matrix4::zeros(), nalgebra::Vector4::zeros());
        for k in 0..self.tracks.len() {
            let Some(z) = bottom(k) else { continue };
            let share = self.tracks[k].y / end - 0.5;
            let side = if self.tracks[k].backward { -0.5 } else { 0.5 };
            let basis = nalgebra::Vector4::new(1.0, share, share * share, side);
            square += basis * basis.transpose();
            product += basis * z;
        }
        square.try_inverse().map_or(0.0, |inverse: nalgebra::Matrix4<f64>| (inverse * product)[3])
    }
}

/// The cutter's tip, as grooves show it.
struct Tip {
    /// Scatter of its teeth, mm, and the power of the variance with which it goes.
    scatter: f64,
    power: f64,
    /// What fits leave of grooves of each of [`FLATS`], mm.
    shapes: Vec<[f64; PARTS]>,
    /// Roundness of simulated grooves of the cutter as it is said to be.
    roundness: f64,
}

impl Tip {
    fn new(window: &Window, feed: f64, whole: &Figures) -> Self {
        let mut teeth = Teeth { feed, scatter: 0.0, flat: 0.0 };
        let mut tip = Self { scatter: 0.0, power: 0.5, shapes: Vec::new(), roundness: 1.0 };
        // Scatter and flat hang together weakly.
        for _ in 0..2 {
            if feed > 0.0 && whole.within > 0.0 {
                (tip.scatter, tip.power) = scatter_of(whole.within, window, teeth);
            }
            teeth.scatter = tip.scatter;
            let of = |flat: &f64| simulated(window, Teeth { flat: flat.min(0.5 * window.half()), ..teeth });
            let all: Vec<Simulated> = FLATS.iter().map(of).collect();
            // Where the points are, not in the middles of the parts.
            tip.shapes = all.iter().map(|one| whole.places.map(|place| at_place(&one.left, place))).collect();
            teeth.flat = tip.flat(&whole.left);
            tip.roundness = simulated(window, teeth).roundness;
        }
        tip
    }

    /// The flat whose grooves leave most nearly what `left` says, mm.
    fn flat(&self, left: &[f64; PARTS]) -> f64 {
        let mut best = (f64::INFINITY, 0.0);
        for (pair, flats) in self.shapes.windows(2).zip(FLATS.windows(2)) {
            let (mut square, mut product) = (0.0, 0.0);
            for ((a, b), left) in pair[0].iter().zip(&pair[1]).zip(left) {
                square += (b - a) * (b - a);
                product += (b - a) * (left - a);
            }
            let share = (product / square.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            let off = |((a, b), left): ((&f64, &f64), &f64)| (left - a - share * (b - a)).powi(2);
            let off: f64 = pair[0].iter().zip(&pair[1]).zip(left).map(off).sum();
            if off < best.0 {
                best = (off, flats[0] + share * (flats[1] - flats[0]));
            }
        }
        best.1
    }
}
