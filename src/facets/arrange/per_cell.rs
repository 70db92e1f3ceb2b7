//! The whole highlight in each of several cells, so that the plate looks the same from spot to spot.

use crate::facets::SlopeGrid;
use crate::facets::sample::kd;
use crate::progress::Progress;
use crate::slope::Slope;

/// Deals `slopes` out to `cells` equal cells along x and y and lets `arrange` order each (slopes, columns, rows, cell).
///
/// Facets of like slope are grouped and each group gives one to every cell: together the cells hold every slope once,
/// and each by itself is an even choice of them. Repeating one cell's facets instead would show the highlight with
/// as many times fewer distinct facets.
///
/// `columns` and `rows` are multiples of the `cells` along them.
pub(crate) fn arrange_per_cell(
    mut slopes: Vec<Slope>,
    columns: usize,
    rows: usize,
    [across, up]: [usize; 2],
    mut arrange: impl FnMut(Vec<Slope>, usize, usize, usize) -> SlopeGrid,
) -> SlopeGrid {
    let each = across * up;
    if each <= 1 {
        return arrange(slopes, columns, rows, 0);
    }
    // Nothing can abandon it.
    let _ = kd::group(&mut slopes, each, &|s: &Slope| s.to_vec(), &Progress::silent());
    let (width, height) = (columns / across, rows / up);
    let mut grid = SlopeGrid { columns, rows, slopes: vec![Slope::FLAT; columns * rows] };
    for cell in 0..each {
        // A group's members are in no order of their own; turning the deal keeps any hidden one from one cell.
        let dealt = slopes.chunks(each).enumerate().map(|(k, group)| group[(cell + k) % each]).collect();
        let one = arrange(dealt, width, height, cell);
        for y in 0..height {
            let to = (cell / across * height + y) * columns + cell % across * width;
            grid.slopes[to..to + width].copy_from_slice(&one.slopes[y * width..][..width]);
        }
    }
    grid
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    #[test]
    fn every_cell_has_the_mean_of_the_whole_and_no_facet_is_lost() {
        let slopes: Vec<Slope> =
            (0..144).map(|k| Slope::new((k as f64 * 0.618).fract(), (k as f64 * 0.414).fract())).collect();
        let mean = slopes.iter().map(|s| s.to_vec()).sum::<DVec2>() / 144.0;
        let plain = |slopes, columns, rows, _| SlopeGrid { columns, rows, slopes };
        for [across, up] in [[2, 2], [3, 1], [1, 4]] {
            let grid = arrange_per_cell(slopes.clone(), 12, 12, [across, up], plain);
            let (width, height) = (12 / across, 12 / up);
            for cell in 0..across * up {
                let (x0, y0) = (cell % across * width, cell / across * height);
                let places = (0..width * height).map(|k| (y0 + k / width) * 12 + x0 + k % width);
                let part: DVec2 = places.map(|at| grid.slopes[at].to_vec()).sum();
                assert!((part / (width * height) as f64).distance(mean) < 0.03, "{across} {up}");
            }
            let key = |s: &Slope| (s.p.to_bits(), s.q.to_bits());
            let mut before: Vec<_> = slopes.iter().map(key).collect();
            let mut after: Vec<_> = grid.slopes.iter().map(key).collect();
            before.sort_unstable();
            after.sort_unstable();
            assert_eq!(before, after);
        }
        assert_eq!(arrange_per_cell(slopes.clone(), 16, 9, [1, 1], plain).slopes, slopes);
    }
}
