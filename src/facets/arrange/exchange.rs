//! Cells that change places because the plate is more of a dome then.

use glam::DVec2;

use crate::facets::SlopeGrid;

/// Every cell of `pitch` mm and the one `offset` cells away change places if the slope rises from the one to the other;
/// whether any did.
pub(super) fn exchange(grid: &mut SlopeGrid, offset: [isize; 2], pitch: DVec2) -> bool {
    let [x, y] = offset;
    let way = DVec2::new(x as f64, y as f64) * pitch;
    let inside = |n: usize, d: isize| 0.max(-d) as usize..(n as isize).min(n as isize - d).max(0) as usize;
    let between = y * grid.columns as isize + x;
    let mut any = false;
    for row in inside(grid.rows, y) {
        for column in inside(grid.columns, x) {
            let here = row * grid.columns + column;
            let there = here.wrapping_add_signed(between);
            if (grid.slopes[there].to_vec() - grid.slopes[here].to_vec()).dot(way) > 0.0 {
                grid.slopes.swap(here, there);
                any = true;
            }
        }
    }
    any
}
