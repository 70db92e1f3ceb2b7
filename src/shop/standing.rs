//! What still stands while a program runs, on a coarse grid, and the rapids that run into it.

use glam::{DVec2, DVec3};

use crate::cutter::Profile;
use crate::gcode::check::Amiss;
use crate::gcode::program::{Move, Program};

/// Nodes over a cutter's radius, and their least distance, mm: a cut lowers two hundred of them.
const NODES_A_RADIUS: f64 = 8.0;
const LEAST_STEP: f64 = 0.1;

/// Most nodes of the grid.
const MOST_NODES: f64 = 4e6;

/// Chords in place of arcs, mm.
const CHORD: f64 = 1e-3;

/// How far a rapid may pass below what a cut has left, mm: what lies between two nodes and two places of a move.
const HAIR: f64 = 0.01;

/// Heights of the stock, counted from its upper face.
struct Grid {
    step: f64,
    nodes: [usize; 2],
    heights: Vec<f32>,
    profile: Profile,
}

impl Grid {
    fn new(size: DVec2, profile: Profile) -> Self {
        let step = (profile.reach / NODES_A_RADIUS).max(LEAST_STEP).max((size.x * size.y / MOST_NODES).sqrt());
        let nodes = size.to_array().map(|side| (side / step).floor() as usize + 1);
        Self { step, nodes, heights: vec![0.0; nodes[0] * nodes[1]], profile }
    }

    /// Every node beneath a cutter whose tip is at `tip`: its index, and the underside's height over it.
    fn beneath(&self, tip: DVec3) -> impl Iterator<Item = (usize, f64)> + use<> {
        let Self { step, nodes: [nx, ny], profile, .. } = *self;
        let span = move |at: f64, count: usize| {
            let within = |v: f64| v.clamp(0.0, count as f64) as usize;
            within(((at - profile.reach) / step).ceil())..within(((at + profile.reach) / step).floor() + 1.0)
        };
        let columns = span(tip.x, nx);
        span(tip.y, ny).flat_map(move |j| {
            columns.clone().filter_map(move |i| {
                let aside = DVec2::new(i as f64, j as f64) * step - tip.truncate();
                let above = tip.z + profile.underside(aside.length());
                above.is_finite().then_some((j * nx + i, above))
            })
        })
    }

    /// Takes away what a cutter at `tip` meets.
    fn cut(&mut self, tip: DVec3) {
        for (node, above) in self.beneath(tip) {
            let height = &mut self.heights[node];
            *height = height.min(above as f32);
        }
    }

    /// How far a cutter at `tip` is within what stands; none if it is clear of it.
    fn hit(&self, tip: DVec3) -> Option<f64> {
        let into = |(node, above): (usize, f64)| {
            let height = f64::from(self.heights[node]);
            // The uncut face is where it is said to be: no nearer than that.
            let spare = if height == 0.0 { 0.0 } else { HAIR };
            Some(height - above).filter(|by| *by >= spare)
        };
        self.beneath(tip).filter_map(into).max_by(f64::total_cmp)
    }
}

/// Rapids that run into what the program has not cut away yet, of stock of `size` mm whose upper face is at z = 0.
pub fn hit_rapids(program: &Program, size: DVec2, profile: Profile) -> Amiss {
    let mut amiss = Amiss::default();
    let mut grid = Grid::new(size, profile);
    for one in program.moves().filter(Move::is_known) {
        if one.from.z > 0.0 && one.motion.to.z > 0.0 && program.arc(&one.motion).is_none() {
            continue;
        }
        let mut worst: Option<(f64, DVec3)> = None;
        let mut from = one.from;
        for to in program.pieces(&one.motion, CHORD) {
            let spacing = if one.cuts() { 0.5 * grid.step } else { grid.step };
            let places = (from.distance(to) / spacing).ceil().max(1.0);
            // Where it begins it has been.
            for k in 1..=places as usize {
                let tip = from.lerp(to, k as f64 / places);
                if tip.z > 0.0 {
                    continue;
                }
                if one.cuts() {
                    grid.cut(tip);
                } else if let Some(by) = grid.hit(tip)
                    && to.z <= from.z
                    && worst.is_none_or(|(most, _)| by > most)
                {
                    worst = Some((by, tip));
                }
            }
            from = to;
        }
        amiss.take(one.motion.line, worst);
    }
    amiss
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutter::Cutter;
    use crate::gcode::read::read;

    fn hits(text: &str) -> (usize, u32, f64) {
        let read = read(text.as_bytes(), None).unwrap();
        assert_eq!(read.fault_count, 0);
        let amiss = hit_rapids(&read.program, DVec2::new(20.0, 10.0), Cutter::Flat { diameter: 2.0 }.profile());
        (amiss.moves, amiss.line, amiss.worst)
    }

    #[test]
    fn a_rapid_runs_into_what_stands_and_not_through_what_is_cut_away() {
        // Over the stock, through a groove that was cut, up out of it, and beside the stock.
        let clear = "G21G90G0Z1S1M3\nX2Y5\nG1Z-1F100\nX18\nG0X3\nZ2\nX-4\nZ-3\nY9\nM2";
        assert_eq!(hits(clear).0, 0);
        let (count, line, by) = hits("G21G90G0Z1S1M3\nX2Y5\nG1Z-1F100\nX10\nG0X14\nZ2\nM2");
        assert_eq!((count, line), (1, 5));
        assert!((by - 1.0).abs() < 1e-6);
        assert_eq!(hits("G21G90G0Z1\nX2Y5\nZ-0.5\nM2").1, 3, "down into the stock");
        assert_eq!(hits("G21G90G0Z1\nX-3Y5\nZ0\nX9\nZ1\nM2").1, 4, "along its face");
    }
}
