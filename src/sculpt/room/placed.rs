//! A far design on the base that lamp and wall ask for, its cells as they are or warped.

use glam::DVec2;

use crate::near::{NearField, Warping};
use crate::relief::height_grid::rises;
use crate::relief::open::OpenRelief;
use crate::relief::periodic::PeriodicRelief;

/// `cells` on the base of `near`; the mean slope of the cells is that of the base.
pub fn placed(cells: &PeriodicRelief, near: &NearField, warping: Warping) -> OpenRelief {
    let (nodes, step) = (cells.plate_nodes(), cells.step());
    let middle = 0.5 * cells.size();
    let height = |at: DVec2| {
        let relief = match warping {
            Warping::Base => height_at(cells, at + middle),
            Warping::Warp => {
                let (asked, gain) = near.warped(at);
                gain * height_at(cells, asked + middle)
            }
        };
        near.base(at) + relief
    };
    OpenRelief::from_fn(nodes, step, height)
}

/// Height of the triangles of `cells` about their mean plane at `at`, mm from the plate's corner, on the plate or beyond.
fn height_at(cells: &PeriodicRelief, at: DVec2) -> f64 {
    let n = cells.nodes;
    let along = at / cells.step();
    let near = along.round();
    // On a node to rounding: its own height, so that cells that are not warped keep theirs to the last bit.
    let along = if (along - near).abs().max_element() < 1e-9 { near } else { along };
    let (square, part) = (along.floor(), along - along.floor());
    let index = |k: f64| (k as i64).rem_euclid(n as i64) as usize;
    let z = |i: f64, j: f64| f64::from(cells.heights[index(square.y + j) * n + index(square.x + i)]);
    let [z00, z10, z01, z11] = [z(0.0, 0.0), z(1.0, 0.0), z(0.0, 1.0), z(1.0, 1.0)];
    let (a, b) = (part.x, part.y);
    match rises([z00, z10, z01, z11]) {
        true if b <= a => z00 + a * (z10 - z00) + b * (z11 - z10),
        true => z00 + a * (z11 - z01) + b * (z01 - z00),
        false if a + b <= 1.0 => z00 + a * (z10 - z00) + b * (z01 - z00),
        false => z11 + (1.0 - a) * (z01 - z11) + (1.0 - b) * (z10 - z11),
    }
}
