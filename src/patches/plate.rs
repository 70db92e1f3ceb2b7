//! All patches of a plate, as one sheet of triangles.

use glam::DVec2;
use rayon::prelude::*;

use super::dimple::Dimple;
use crate::progress::{Cancelled, Progress};
use crate::relief::open::OpenRelief;

/// How a plate is divided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patches {
    /// Patches along x and y.
    pub count: [usize; 2],
    /// Size of the optical area, mm.
    pub size: DVec2,
    /// Distances of nodes along each side of a patch.
    pub nodes: usize,
}

impl Patches {
    /// Patches in all.
    pub fn len(&self) -> usize {
        self.count[0] * self.count[1]
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Size of a patch, mm.
    pub fn patch(&self) -> DVec2 {
        self.size / DVec2::new(self.count[0] as f64, self.count[1] as f64)
    }

    /// Distance of nodes, mm.
    pub fn step(&self) -> DVec2 {
        self.patch() / self.nodes as f64
    }

    /// The middle of the patch in `column`, counted from the left, and `row`, counted from the top, mm.
    pub fn middle(&self, column: usize, row: usize) -> DVec2 {
        self.patch() * DVec2::new(column as f64 + 0.5, (self.count[1] - 1 - row) as f64 + 0.5)
    }

    /// Column and row of the patch at `at` mm, if there is one.
    pub fn patch_at(&self, at: DVec2) -> Option<[usize; 2]> {
        let place = at / self.patch();
        let inside = place.cmpge(DVec2::ZERO).all() && place.x < self.count[0] as f64 && place.y < self.count[1] as f64;
        inside.then(|| [place.x as usize, self.count[1] - 1 - place.y as usize])
    }

    /// Heights of a patch's own nodes, mm, in rows of constant y, the lowest y first. Those of its rim are 0; its corners
    /// stand up by as much as a wall rises from node to node, or the three nodes of each corner would be a level triangle.
    pub fn heights(&self, dimple: &Dimple) -> Vec<f32> {
        let n = self.nodes;
        let (step, half) = (self.step(), 0.5 * self.patch());
        let corner = (dimple.walls.steep * step.min_element()) as f32;
        (0..(n + 1) * (n + 1))
            .map(|k| {
                let (i, j) = (k % (n + 1), k / (n + 1));
                match (i % n == 0, j % n == 0) {
                    (true, true) => return corner,
                    (true, false) | (false, true) => return 0.0,
                    (false, false) => {}
                }
                dimple.height(DVec2::new(i as f64, j as f64) * step - half) as f32
            })
            .collect()
    }

    /// The plate of these dimples, row by row from the top left.
    pub fn relief(&self, dimples: &[Dimple], progress: &Progress) -> Result<OpenRelief, Cancelled> {
        let [columns, rows] = self.count;
        let n = self.nodes;
        let nodes = [columns * n + 1, rows * n + 1];
        let mut heights = vec![0.0f32; nodes[0] * nodes[1]];
        // A band of patches holds its lower rim; the upper rim of the highest is as all rims are.
        let bands = heights.par_chunks_mut(n * nodes[0]).enumerate().take(rows);
        bands.try_for_each(|(up, band)| {
            progress.check()?;
            for (column, dimple) in dimples[(rows - 1 - up) * columns..][..columns].iter().enumerate() {
                let own = self.heights(dimple);
                for (row, own) in band.chunks_mut(nodes[0]).zip(own.chunks(n + 1)) {
                    row[column * n..=(column + 1) * n].copy_from_slice(own);
                }
            }
            Ok::<_, Cancelled>(())
        })?;
        heights.copy_within(..nodes[0], rows * n * nodes[0]);
        Ok(OpenRelief { nodes, step: self.step(), heights })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patches::dimple::{PatchLobe, Walls};
    use crate::slope::Slope;

    #[test]
    fn patches_stand_as_in_the_picture_and_join_at_their_rims() {
        let patches = Patches { count: [3, 2], size: DVec2::new(6.0, 2.0), nodes: 8 };
        assert_eq!(patches.patch(), DVec2::new(2.0, 1.0));
        assert_eq!((patches.middle(0, 0), patches.middle(2, 1)), (DVec2::new(1.0, 1.5), DVec2::new(5.0, 0.5)));
        assert_eq!(patches.patch_at(DVec2::new(0.1, 1.9)), Some([0, 0]));
        assert_eq!((patches.patch_at(DVec2::new(6.1, 0.5)), patches.patch_at(DVec2::new(-0.1, 0.5))), (None, None));
        let walls = Walls { half: 0.5 * patches.patch(), steep: 0.3, spare: None };
        let lobe = PatchLobe::round(0.05, Slope::FLAT);
        let dimples: Vec<Dimple> = (0..6).map(|k| Dimple::new(walls, &lobe, 0.1 * k as f64)).collect();
        let relief = patches.relief(&dimples, &Progress::silent()).unwrap();
        assert_eq!(relief.nodes, [25, 17]);
        for (k, z) in relief.heights.iter().enumerate() {
            let (i, j) = (k % 25, k / 25);
            if i % 8 == 0 || j % 8 == 0 {
                // Of steps of 0.25 and 0.125 mm the shorter one, at a slope of 0.3.
                assert_eq!(*z, if i % 8 == 0 && j % 8 == 0 { 0.0375 } else { 0.0 });
                continue;
            }
            let at = DVec2::new(i as f64, j as f64) * patches.step();
            let [column, row] = patches.patch_at(at).unwrap();
            let height = dimples[row * 3 + column].height(at - patches.middle(column, row));
            assert!((f64::from(*z) - height).abs() < 1e-6 && *z < 0.0);
        }
    }
}
