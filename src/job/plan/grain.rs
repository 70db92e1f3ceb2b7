//! How rough a machine leaves a surface: slopes about those that were meant, found on a small tilted plane.
//!
//! The plane is made and polished as any plate is. Polish turns heights that differ from pass to pass and from cut to cut
//! into slopes by known laws, and so one plane tells of every width of polish.

use std::f64::consts::PI;

use glam::DVec2;

use crate::cutter::Cutter;
use crate::job::smeared::Spread;
use crate::milling::machine::Machine;
use crate::milling::made::Machining;
use crate::milling::passes::Passes;
use crate::progress::{Cancelled, Progress};
use crate::relief::mesh::Mesh;
use crate::relief::open::OpenRelief;

/// The plane is polished by so many stepovers, or ways between cuts if these are longer: cusps are gone then.
const POLISH: f64 = 2.0;

/// Size of the plane in standard deviations of that polish, along the passes and across: across them 60 places are told
/// apart, which leaves the root mean square of their slopes known within a tenth.
const PLANE: [f64; 2] = [16.0, 150.0];

/// Waves of a cusp that are added up; the next has a thousandth of the first one's square.
const WAVES: usize = 32;

/// Size of a plane that is not polished, in stepovers or cuts, and rows of slopes over it.
const BARE: [f64; 2] = [40.0, 60.0];
const ROWS: usize = 60;

/// What one machine, cutter and stepover leave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grain {
    /// Passes, mm apart.
    pub stepover: f64,
    /// Variance of heights from pass to pass, times the stepover, mm³.
    passes: f64,
    /// Variance of heights from cut to cut, times the area of a cut, mm⁴.
    cuts: f64,
    /// Slopes without polish.
    bare: Spread,
}

impl Grain {
    /// What `machine` leaves with `cutter` on passes `stepover` mm apart over a plane as steep as `slope`.
    ///
    /// # Errors
    /// The work was abandoned.
    pub fn new(
        machine: &Machine,
        cutter: Cutter,
        stepover: f64,
        slope: DVec2,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let apart = stepover.max(machine.feed_per_tooth);
        let sigma = POLISH * apart;
        let passes = Passes { angle: 0.0, stepover, zigzag: false };
        let made = |size: [f64; 2], polish: Option<f64>| {
            let machining = Machining { machine: machine.clone(), cutter, passes, polish, seed: 1 };
            let plate = DVec2::from(size);
            let ways = machining.ways(&plane(plate, slope, cutter.reach()), plate, progress)?;
            Ok((machining, ways))
        };
        let (machining, ways) = made(PLANE.map(|n| n * sigma), Some(sigma))?;
        let surface = machining.polished(&ways, 0, progress)?;
        let polished = surface.map_or(Spread::default(), |surface| polished(&surface, 3.0 * sigma));
        let between = (polished.across.powi(2) - polished.along.powi(2)).max(0.0);
        let (machining, ways) = made(BARE.map(|n| n * apart), None)?;
        let rows = machining.bare(&ways, 0);
        let (mut sum, mut count) = (DVec2::ZERO, 0.0);
        for k in 0..ROWS {
            progress.check()?;
            let all = rows.slopes(k, ROWS);
            all.iter().filter(|found| found.is_finite()).for_each(|found| {
                sum += (*found - slope) * (*found - slope);
                count += 1.0;
            });
        }
        let bare = (sum / f64::max(count, 1.0)).map(f64::sqrt);
        Ok(Self {
            stepover,
            passes: 4.0 * PI.sqrt() * sigma.powi(3) * between,
            cuts: 8.0 * PI * sigma.powi(4) * polished.along.powi(2),
            bare: Spread { along: bare.x, across: bare.y },
        })
    }

    /// Slopes after a polish of `sigma` mm, none of it being 0, but for cusps.
    pub fn after(&self, sigma: f64) -> Spread {
        if sigma <= 0.0 {
            return self.bare;
        }
        let cuts = self.cuts / (8.0 * PI * sigma.powi(4));
        let passes = self.passes / (4.0 * PI.sqrt() * sigma.powi(3));
        let Spread { along, across } = self.bare;
        Spread { along: cuts.sqrt().min(along), across: (cuts + passes).sqrt().min(across) }
    }

    /// Between `self` and `other` at `stepover` mm, by powers of it.
    pub fn between(&self, other: &Self, stepover: f64) -> Self {
        let share = (stepover / self.stepover).ln() / (other.stepover / self.stepover).ln();
        let of = |a: f64, b: f64| if a > 0.0 && b > 0.0 { a * (b / a).powf(share) } else { a + share * (b - a) };
        Self {
            stepover,
            passes: of(self.passes, other.passes),
            cuts: of(self.cuts, other.cuts),
            bare: Spread {
                along: of(self.bare.along, other.bare.along),
                across: of(self.bare.across, other.bare.across),
            },
        }
    }
}

/// Root mean square of the slopes across passes `stepover` mm apart that a polish of `sigma` mm leaves of the cusps of an
/// underside of `radius` mm: a saw from -w/2R to w/2R, whose waves fade one by one.
pub fn cusps(stepover: f64, radius: f64, sigma: f64) -> f64 {
    let wave = |k: usize| {
        let k = k as f64;
        let height = stepover / (PI * radius * k);
        0.5 * (height * (-0.5 * (2.0 * PI * k * sigma / stepover).powi(2)).exp()).powi(2)
    };
    (1..=WAVES).map(wave).sum::<f64>().sqrt()
}

/// Two triangles as steep as `slope`, `beyond` mm wider all around than a plate of `plate` mm.
fn plane(plate: DVec2, slope: DVec2, beyond: f64) -> Mesh {
    let at = |x: f64, y: f64| [x, y, slope.dot(DVec2::new(x, y))].map(|v| v as f32);
    let ([x0, y0], [x1, y1]) = ([-beyond; 2], (plate + beyond).to_array());
    Mesh { vertices: vec![at(x0, y0), at(x1, y0), at(x0, y1), at(x1, y1)], triangles: vec![[0, 1, 3], [0, 3, 2]] }
}

/// Root mean square of the slopes of a polished plane about their mean, `rim` mm inside.
fn polished(surface: &OpenRelief, rim: f64) -> Spread {
    let [nx, ny] = surface.nodes;
    let inside = (rim / surface.step).ceil();
    let [i0, j0] = inside.to_array().map(|n| n as usize);
    let (mut sum, mut squares, mut count) = (DVec2::ZERO, DVec2::ZERO, 0.0);
    for j in j0..(ny - 1).saturating_sub(j0) {
        for i in i0..(nx - 1).saturating_sub(i0) {
            let at = |i: usize, j: usize| f64::from(surface.heights[j * nx + i]);
            let rise = DVec2::new(at(i + 1, j) - at(i, j), at(i, j + 1) - at(i, j)) / surface.step;
            (sum, squares, count) = (sum + rise, squares + rise * rise, count + 1.0);
        }
    }
    let count = f64::max(count, 1.0);
    let spread = (squares / count - (sum / count) * (sum / count)).max(DVec2::ZERO).map(f64::sqrt);
    Spread { along: spread.x, across: spread.y }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cusps_are_a_saw_that_polish_takes_away() {
        // Evenly from -w/2R to w/2R: root mean square w/2R√3.
        assert!((cusps(0.02, 0.25, 0.0) / (0.04 / 3f64.sqrt()) - 1.0).abs() < 0.02);
        assert!(cusps(0.02, 0.25, 0.01) < 0.02 * cusps(0.02, 0.25, 0.0));
    }

    #[test]
    fn a_plane_tells_of_every_polish() {
        let machine = Machine { track_scatter: 5e-5, decimals: 9, ..Machine::ideal() };
        let progress = Progress::silent();
        let grain = Grain::new(&machine, Cutter::ball(0.5), 0.02, DVec2::new(0.06, 0.05), &progress).unwrap();
        // White heights of δ leave δ √(w/(4 √π σ³)) across the passes, 4√π = 7.09.
        let law = |sigma: f64| 5e-5 * (0.02 / (7.09 * f64::powi(sigma, 3))).sqrt();
        for sigma in [0.04, 0.1] {
            let found = grain.after(sigma).across;
            assert!((found / law(sigma) - 1.0).abs() < 0.2, "{sigma}: {found} {}", law(sigma));
        }
        // Without polish cusps and scatter are all there.
        assert!(grain.after(0.0).across > 0.02 && grain.after(0.0).across < 0.03, "{grain:?}");
        assert_eq!(grain.between(&grain.clone(), 0.02).after(0.04).along, grain.after(0.04).along);
    }
}
