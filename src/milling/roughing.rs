//! Roughing: levels of straight passes over the whole stock, each as low as the level, or the relief with its allowance,
//! lets a cutter go.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::tip::TipHeights;
use crate::cutter::Cutter;
use crate::gcode::reduce::reduced;
use crate::progress::{Cancelled, Progress};
use crate::relief::mesh::Mesh;

/// Places of the tip along a pass, for each radius of the cutter.
const PLACES_A_RADIUS: f64 = 10.0;

/// How far segments may lie beside those places, mm: a two-hundredth of the usual allowance.
const CHORD: f64 = 5e-4;

/// What is left over a rim, mm. A chord may pass half a micrometre too low, decimals another half, and single precision
/// some: more than the micrometre that a cut may pass below a plate.
const RIM: f64 = 3e-3;

/// Shortest segment where that can be helped, mm: at 3000 mm/min 100 lines a second.
const SHORTEST: f64 = 0.5;

/// How far beside a pass it is asked how low the cutter may stand, mm: decimals may move it as far, and a cutter that just
/// touches a wall would else be let past it or not as numbers round.
const ASIDE: f64 = 1e-3;

/// From the stock to where passes begin, so that the cutter goes down beside it, mm.
const BESIDE: f64 = 0.5;

/// Most levels.
const MOST_LEVELS: f64 = 10_000.0;

/// How stock is taken away before the finishing passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roughing {
    /// With what.
    pub cutter: Cutter,
    /// From one pass to the next, mm.
    pub stepover: f64,
    /// From one level to the next, mm.
    pub step: f64,
    /// What is left standing over the optical area, mm; a rim around it is cut to 3 µm above its height.
    pub allowance: f64,
}

/// What is to be roughed out.
#[derive(Clone, Copy)]
pub struct Block<'a> {
    /// The plate, mm.
    pub mesh: &'a Mesh,
    /// Lower left and upper right corner of the optical area, mm.
    pub optical: [DVec2; 2],
}

impl Roughing {
    /// How low the cutter can stand over the plate with its allowance.
    pub fn tips(&self, block: &Block) -> TipHeights {
        TipHeights::new(&self.raised(block), self.cutter.profile())
    }

    /// The tip's ways, mm, over `tips` of a plate from corner `low` to `high`, in the mesh's own frame and in the order of
    /// cutting: level by level, each as far as it takes something away.
    ///
    /// # Errors
    /// The work is abandoned.
    pub fn tracks(
        &self,
        tips: &TipHeights,
        [low, high]: [DVec2; 2],
        top: f64,
        progress: &Progress,
    ) -> Result<Vec<Vec<DVec3>>, Cancelled> {
        let beyond = self.cutter.reach() + BESIDE;
        let (from, length) = (low.x - beyond, high.x - low.x + 2.0 * beyond);
        let places = (length / (self.cutter.reach() / PLACES_A_RADIUS)).ceil().max(2.0);
        let at = |i: usize| from + length * i as f64 / places;
        let count = ((high.y - low.y) / self.stepover).ceil().max(1.0);
        let rows = (0..=count as usize)
            .into_par_iter()
            .map(|k| {
                let y = low.y + (high.y - low.y) * k as f64 / count;
                progress.check()?;
                let tip = |i: usize| {
                    let beside = |by: f64| tips.at(DVec2::new(at(i), y + by));
                    beside(0.0).max(beside(-ASIDE)).max(beside(ASIDE))
                };
                Ok((y, widened(&(0..=places as usize).map(tip).collect::<Vec<f64>>())))
            })
            .collect::<Result<Vec<(f64, Vec<f64>)>, Cancelled>>()?;
        let lowest = rows.iter().flat_map(|(_, row)| row).copied().filter(|z| z.is_finite()).fold(top, f64::min);
        let levels = ((top - lowest) / self.step).ceil().clamp(1.0, MOST_LEVELS);
        let step = (top - lowest) / levels;
        let mut tracks = Vec::new();
        for level in 0..levels as usize {
            let (above, floor) = (top - step * level as f64, top - step * (level + 1) as f64);
            for (k, (y, row)) in rows.iter().enumerate() {
                for run in runs(row, above) {
                    let way: Vec<[f64; 2]> = run.map(|i| [at(i), row[i].max(floor)]).collect();
                    let kept = reduced(&way, CHORD, SHORTEST);
                    let mut track: Vec<DVec3> = kept.iter().map(|i| DVec3::new(way[*i][0], *y, way[*i][1])).collect();
                    if k % 2 == 1 {
                        track.reverse();
                    }
                    tracks.push(track);
                }
            }
        }
        Ok(tracks)
    }

    /// The triangles that face up, those of the optical area higher by the allowance.
    fn raised(&self, block: &Block) -> Mesh {
        let Block { mesh, optical: [low, high] } = *block;
        let mut raised = Mesh::default();
        for k in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(k);
            if (b - a).cross(c - a).z <= 0.0 {
                continue;
            }
            let middle = (a + b + c).truncate() / 3.0;
            let within = (middle.cmpge(low) & middle.cmple(high)).all();
            let by = DVec3::Z * if within { self.allowance } else { RIM };
            let first = raised.vertices.len() as u32;
            raised.vertices.extend([a, b, c].map(|corner| (corner + by).to_array().map(|v| v as f32)));
            raised.triangles.push([first, first + 1, first + 2]);
        }
        raised
    }
}

/// Each height as high as its neighbours: between two places a wall may stand anywhere, and a straight line from one to the
/// other must not pass through it.
fn widened(row: &[f64]) -> Vec<f64> {
    let last = row.len() - 1;
    (0..=last).map(|i| row[i.saturating_sub(1)].max(row[i]).max(row[(i + 1).min(last)])).collect()
}

/// Runs of places at which a cut below `above` takes something away, each with one more place on either side.
fn runs(row: &[f64], above: f64) -> Vec<std::ops::RangeInclusive<usize>> {
    let mut runs: Vec<std::ops::RangeInclusive<usize>> = Vec::new();
    for (i, _) in row.iter().enumerate().filter(|(_, z)| **z < above - 1e-9) {
        let (from, to) = (i.saturating_sub(1), (i + 1).min(row.len() - 1));
        match runs.last_mut() {
            Some(run) if *run.end() >= from => *run = *run.start()..=to,
            _ => runs.push(from..=to),
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Up-facing triangles of a plate of 10 × 6 mm, a block of 4 × 6 mm and 2 mm height on it from x = 3 to 7.
    fn step() -> Mesh {
        let mut mesh = Mesh::default();
        for (x0, x1, z) in [(0.0, 3.0, 0.0), (3.0, 7.0, 2.0), (7.0, 10.0, 0.0)] {
            let first = mesh.vertices.len() as u32;
            mesh.vertices.extend([[x0, 0.0, z], [x1, 0.0, z], [x0, 6.0, z], [x1, 6.0, z]]);
            mesh.triangles.extend([[first, first + 1, first + 3], [first, first + 3, first + 2]]);
        }
        mesh
    }

    #[test]
    fn levels_go_down_in_steps_and_leave_the_allowance_over_the_optical_area_alone() {
        let mesh = step();
        let cutter: Cutter = "flat:2".parse().unwrap();
        let roughing = Roughing { cutter, stepover: 0.8, step: 0.5, allowance: 0.1 };
        let optical = [DVec2::new(3.0, 0.0), DVec2::new(7.0, 6.0)];
        let block = Block { mesh: &mesh, optical };
        let tips = roughing.tips(&block);
        let box_of = [DVec2::ZERO, DVec2::new(10.0, 6.0)];
        let tracks = roughing.tracks(&tips, box_of, 2.3, &Progress::silent()).unwrap();
        let lowest = |x: f64| {
            let pieces = tracks.iter().flat_map(|track| track.windows(2));
            let over = pieces.filter(|ends| (ends[0].x - x) * (ends[1].x - x) <= 0.0);
            let height = |ends: &[DVec3]| ends[0].lerp(ends[1], (x - ends[0].x) / (ends[1].x - ends[0].x)).z;
            over.map(height).fold(f64::INFINITY, f64::min)
        };
        assert!((lowest(5.0) - 2.1).abs() < 1e-6);
        assert!((lowest(1.0) - RIM).abs() < 1e-6 && (lowest(9.0) - RIM).abs() < 1e-6);
        // No segment passes lower than the cutter may stand over the plate, wherever the wall is between its ends.
        let mut before = 2.3;
        for track in &tracks {
            for pair in track.windows(2) {
                for k in 0..=200 {
                    let place = pair[0].lerp(pair[1], f64::from(k) / 200.0);
                    assert!(place.z > tips.at(place.truncate()) - CHORD - 1e-9, "{place}");
                }
            }
            let low = track.iter().map(|point| point.z).fold(f64::INFINITY, f64::min);
            assert!(low > before - 0.5, "no more than a step at once");
            before = before.min(low);
        }
        // Rows begin and end beside the stock, where nothing is in the way of going down.
        assert!(tracks[0][0].x < -1.4 && tracks[0][tracks[0].len() - 1].x > 11.4);
    }
}
