//! The surface as a machine makes it: the cutter led over the written triangles pass by pass, with the machine's errors,
//! and polished.
//!
//! A polished surface is a sheet of triangles again, fine enough for its polish, and is proved as any other plate is. One
//! that is not polished has cusps and tooth marks of micrometres: of it the slopes are told, row by row, each as the
//! cutter that passed lowest leaves it.

use glam::DVec2;
use rayon::prelude::*;

use super::machine::Machine;
use super::passes::{Frame, Passes, Ways};
use super::polish::{NODES, Nodes};
use super::sweep::Sweep;
use super::tip::TipHeights;
use crate::cutter::{Cutter, Profile};
use crate::golden::golden;
use crate::progress::{Cancelled, Progress};
use crate::relief::mesh::Mesh;
use crate::relief::open::OpenRelief;

/// Samples before polish, a standard deviation of it: what is finer than those is averaged away by a thousand of them.
const SAMPLES: f64 = 12.0;

/// Rows before polish from one pass to the next: the cusps between passes, sampled four times, keep their mean.
const ROWS_A_PASS: f64 = 4.0;

/// Samples from one cut of a tooth to the next, before polish and where there is none.
const POLISHED_TOOTH: f64 = 2.0;
const BARE_TOOTH: f64 = 8.0;

/// Places of the tip along a pass leave this much between chord and way, mm.
const CHORD: f64 = 2.5e-5;

/// Passes no closer than this are told apart, mm.
pub const LEAST_STEPOVER: f64 = 0.0005;

/// Bytes of a node as its surface is closed and traced.
const NODE: f64 = 120.0;

/// Places of the tip a cutter's radius at the least: pointed cutters have no roundness that would say.
const PLACES_A_RADIUS: f64 = 25.0;

/// How a plate is machined.
#[derive(Clone, Debug, PartialEq)]
pub struct Machining {
    /// By what.
    pub machine: Machine,
    /// With what.
    pub cutter: Cutter,
    /// How it goes over the plate.
    pub passes: Passes,
    /// Standard deviation of the Gaussian by which it is polished afterwards, mm.
    pub polish: Option<f64>,
    /// Seed of the machine's random errors.
    pub seed: u64,
}

impl Machining {
    /// How low the cutter can stand over the triangles of `mesh` that face up.
    pub fn tips(&self, mesh: &Mesh) -> TipHeights {
        TipHeights::new(mesh, self.cutter.profile())
    }

    /// Where the tip should be, over the triangles of `mesh` that face up, for a plate of `plate` mm whose lower left corner
    /// is x = y = 0.
    ///
    /// # Errors
    /// The work is abandoned.
    pub fn ways(&self, mesh: &Mesh, plate: DVec2, progress: &Progress) -> Result<Ways, Cancelled> {
        self.ways_over(&self.tips(mesh), plate, progress)
    }

    /// The same over triangles that are sorted already.
    ///
    /// # Errors
    /// The work is abandoned.
    pub fn ways_over(&self, tips: &TipHeights, plate: DVec2, progress: &Progress) -> Result<Ways, Cancelled> {
        Ways::new(tips, plate, &self.passes, [self.place(), self.machine.quantum()], progress)
    }

    /// From one place of the tip to the next along a pass, mm.
    pub fn place(&self) -> f64 {
        let Profile { arc, reach, .. } = self.cutter.profile();
        if arc > 0.0 { (8.0 * arc * CHORD).sqrt() } else { reach / PLACES_A_RADIUS }
    }

    /// From one sample to the next along a pass that is polished by `sigma` mm, mm, at the most.
    fn polished_sample(&self, sigma: f64) -> f64 {
        (self.machine.feed_per_tooth / POLISHED_TOOTH).max(sigma / SAMPLES)
    }

    /// The same along a pass that is not.
    fn bare_sample(&self) -> f64 {
        let feed = self.machine.feed_per_tooth;
        (if feed > 0.0 { feed } else { self.passes.stepover }) / BARE_TOOTH
    }

    /// The plate as draw number `draw` of the machine's errors leaves it and as it is polished; `None` without polish.
    ///
    /// # Errors
    /// The work is abandoned.
    pub fn polished(&self, ways: &Ways, draw: u64, progress: &Progress) -> Result<Option<OpenRelief>, Cancelled> {
        let Some(sigma) = self.polish else { return Ok(None) };
        let nodes = Nodes::new(ways.frame.size, sigma);
        let finer = |apart: f64, wanted: f64| (apart / wanted).ceil().max(1.0) as usize;
        let every = [
            finer(nodes.apart.x, self.polished_sample(sigma)),
            finer(nodes.apart.y, self.passes.stepover / ROWS_A_PASS),
        ];
        let sweep = self.sweep(ways, nodes.apart.x / every[0] as f64, draw);
        let across = nodes.apart.y / every[1] as f64;
        let smooth = nodes.polished(every, |k, row| sweep.row(across * k as f64, row), progress)?;
        Ok(Some(on_plate(&ways.frame, smooth, nodes.count)))
    }

    /// The plate as draw number `draw` of the machine's errors leaves it, without polish.
    pub fn bare(&self, ways: &Ways, draw: u64) -> BareSurface {
        let length = ways.frame.size.x;
        BareSurface { sweep: self.sweep(ways, length / (length / self.bare_sample()).ceil(), draw) }
    }

    /// Height of the cusps between two passes over a level plate, mm.
    pub fn cusp_height(&self) -> f64 {
        self.cutter.underside((0.5 * self.passes.stepover).min(self.cutter.reach()))
    }

    /// Refuses what cannot be machined so.
    pub fn check(&self, plate: DVec2) -> Result<(), MachiningError> {
        let Self { cutter, passes, polish, .. } = self;
        let (widest, size) = (cutter.reach(), plate.min_element());
        if !(cutter.diameter() > 0.0 && cutter.diameter() <= size) {
            return Err(MachiningError::Cutter { cutter: *cutter, size });
        }
        if !(passes.stepover >= LEAST_STEPOVER && passes.stepover <= widest) {
            return Err(MachiningError::Stepover { stepover: passes.stepover, widest });
        }
        match polish.filter(|polish| !(*polish > 0.0 && *polish <= 0.05 * size)) {
            Some(polish) => Err(MachiningError::Polish { polish, most: 0.05 * size }),
            None => Ok(()),
        }
    }

    /// What the surface of a plate of `plate` mm consists of.
    pub fn work(&self, plate: DVec2) -> Work {
        let frame = Frame::new(plate, self.passes.angle).size;
        let passes = frame.y / self.passes.stepover;
        let along = frame.x / self.polish.map_or_else(|| self.bare_sample(), |sigma| self.polished_sample(sigma));
        let columns = self.polish.map_or(0.0, |sigma| frame.x / (NODES * sigma));
        Work {
            places: passes * frame.x / self.place(),
            cuts: passes * along,
            samples: ROWS_A_PASS * passes * along,
            along,
            thinned: ROWS_A_PASS * passes * columns,
            nodes: columns * columns * frame.y / frame.x,
        }
    }

    /// Memory that the surface of a plate of `plate` mm takes, bytes, about.
    pub fn bytes(&self, plate: DVec2) -> f64 {
        let Work { places, cuts, thinned, nodes, .. } = self.work(plate);
        // Heights as they should be and as they are, thinned rows, and a node of the surface as it is closed and traced.
        8.0 * places + 4.0 * cuts + 4.0 * thinned + NODE * nodes
    }

    fn sweep(&self, ways: &Ways, step: f64, draw: u64) -> Sweep {
        let profile = self.cutter.grown(self.machine.radius_error).profile();
        // Seeds of draws are far apart, so that those of a recipe with the next seed are others.
        let seed = self.seed.wrapping_add(draw << 32);
        Sweep::new(ways, (profile, &self.machine), step, seed)
    }
}

/// Numbers of what a surface as made consists of, about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Work {
    /// Places at which the cutter is lowered onto the triangles.
    pub places: f64,
    /// Heights of the tip along all passes as they are cut.
    pub cuts: f64,
    /// Samples of the surface before polish.
    pub samples: f64,
    /// Of those, along one pass.
    pub along: f64,
    /// Of those, what is kept after polish along the passes.
    pub thinned: f64,
    /// Nodes of the polished surface; none without polish.
    pub nodes: f64,
}

/// A surface that was not polished, known row by row.
pub struct BareSurface {
    sweep: Sweep,
}

impl BareSurface {
    /// Height at a place of the plate, mm; infinite where nothing is cut.
    pub fn height(&self, place: DVec2) -> f64 {
        self.sweep.height(self.sweep.frame().of_plate(place))
    }

    /// Slopes along row `k` of `rows` spread evenly over the plate, each as the cutter leaves it that passed lowest; not a
    /// number beside the plate.
    pub fn slopes(&self, k: usize, rows: usize) -> Vec<DVec2> {
        let frame = self.sweep.frame();
        let [y, shift] = self.row(k, rows);
        let mut slopes = vec![DVec2::NAN; self.sweep.columns() - 1];
        self.sweep.slopes(y, shift, &mut slopes);
        for (i, slope) in slopes.iter_mut().enumerate() {
            let inside = frame.is_on_plate(self.place(i, k, rows));
            *slope = if inside { frame.turned(*slope) } else { DVec2::NAN };
        }
        slopes
    }

    /// Where the plate has slope `i` of row `k` of `rows`, mm.
    pub fn place(&self, i: usize, k: usize, rows: usize) -> DVec2 {
        let [y, shift] = self.row(k, rows);
        self.sweep.frame().on_plate(DVec2::new(self.sweep.step() * i as f64 + shift, y))
    }

    /// Place across the frame of row `k` of `rows`, and of its first slope along it, mm: they keep no step with passes and
    /// teeth.
    fn row(&self, k: usize, rows: usize) -> [f64; 2] {
        [self.sweep.frame().size.y * (k as f64 + golden(7 * k + 3)) / rows as f64, self.sweep.step() * golden(k)]
    }
}

/// What cannot be machined.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MachiningError {
    /// Passes too wide or too close.
    #[error(
        "passes {stepover} mm apart: with this cutter --stepover may be from {LEAST_STEPOVER} to its radius, {widest} mm"
    )]
    Stepover {
        /// What was asked, mm.
        stepover: f64,
        /// The most, mm.
        widest: f64,
    },
    /// A cutter of no size, or wider than the plate.
    #[error(
        "the cutter {cutter} does not fit: name one wider than 0, and no wider than the plate's smaller side, {size:.3} mm"
    )]
    Cutter {
        /// The cutter.
        cutter: Cutter,
        /// The plate's shorter side, mm.
        size: f64,
    },
    /// A polish that leaves nothing of a relief.
    #[error("a polish of {polish} mm: --polish may be up to {most:.3} mm here, a twentieth of the plate")]
    Polish {
        /// What was asked, mm.
        polish: f64,
        /// The most, mm.
        most: f64,
    },
}

/// A grid of the frame at the nodes of the plate, as far apart.
fn on_plate(frame: &Frame, heights: Vec<f32>, [columns, rows]: [usize; 2]) -> OpenRelief {
    let apart = frame.size / DVec2::new((columns - 1) as f64, (rows - 1) as f64);
    if frame.turned(DVec2::X) == DVec2::X {
        return OpenRelief { nodes: [columns, rows], step: apart, heights };
    }
    let plate = frame.plate();
    let squares = [plate.x / apart.min_element(), plate.y / apart.min_element()].map(|n| n.ceil().max(1.0));
    let step = plate / DVec2::from_array(squares);
    let nodes = squares.map(|n| n as usize + 1);
    let at = |place: DVec2| {
        let there =
            (frame.of_plate(place) / apart).clamp(DVec2::ZERO, DVec2::new((columns - 1) as f64, (rows - 1) as f64));
        let [i, j] = [there.x.floor(), there.y.floor()];
        let weights = [cubic(there.x - i), cubic(there.y - j)];
        let node = |a: usize, b: usize| {
            let place =
                |k: f64, a: usize, count: usize| (k as isize + a as isize - 1).clamp(0, count as isize - 1) as usize;
            f64::from(heights[place(j, b, rows) * columns + place(i, a, columns)])
        };
        let sum = (0..16).map(|k| weights[0][k % 4] * weights[1][k / 4] * node(k % 4, k / 4)).sum::<f64>();
        sum as f32
    };
    let mut turned = vec![0.0; nodes[0] * nodes[1]];
    turned.par_chunks_mut(nodes[0]).enumerate().for_each(|(j, row)| {
        row.iter_mut().enumerate().for_each(|(i, z)| *z = at(step * DVec2::new(i as f64, j as f64)));
    });
    OpenRelief { nodes, step, heights: turned }
}

/// Weights of four neighbours at `t` between the second and the third (Catmull and Rom 1974).
fn cubic(t: f64) -> [f64; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [0.5 * (2.0 * t2 - t - t3), 0.5 * (2.0 - 5.0 * t2 + 3.0 * t3), 0.5 * (t + 4.0 * t2 - 3.0 * t3), 0.5 * (t3 - t2)]
}

#[cfg(test)]
mod tests;
