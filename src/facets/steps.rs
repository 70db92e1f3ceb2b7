//! How far a faceted relief is from continuous: its vertical walls and its valleys, in closed form.

use glam::DVec2;

use crate::facets::SlopeGrid;

/// What the walls and valleys of a faceted relief come to. Each number belongs to the exact planes, not to a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Steps {
    /// Root of the mean squared step along all shared edges, every millimetre of edge counting alike, mm.
    pub rms: f64,
    /// Area of all vertical walls over the area of the plate: A_v of Weyrich et al. 2009.
    pub wall_area_ratio: f64,
    /// Concave neighbour pairs, those across the rim of a cyclic plate always included: V of Weyrich et al. 2009.
    /// x-neighbours form a valley if p(x+1) > p(x), y-neighbours if q(y+1) > q(y).
    pub valleys: usize,
    /// Concave neighbour pairs inside the plate.
    pub inner_valleys: usize,
}

/// Measures the planes of `grid` that stand at `heights` (mm, at the middles of the cells, in the grid's order)
/// over cells of `pitch` mm. Walls across the rim count only if the plate is `periodic`: they stand between the
/// planes themselves, so a plate with a net climb has them. A row or column of one cell has none with itself.
///
/// Along an edge of length L the step is linear, m + s t with t in [-L/2, L/2], so that its mean square is
/// m² + s² L²/12, and its area ∫|m + s t| dt is |m| L where it keeps its sign, else (m² + s² L²/4)/|s|.
pub fn steps(grid: &SlopeGrid, heights: &[f64], pitch: DVec2, periodic: bool) -> Steps {
    let slope = |k: usize| grid.slopes[k].to_vec();
    let mut walls = Walls::default();
    for (a, b) in grid.x_pairs(periodic) {
        let climb = 0.5 * pitch.x * (slope(a).x + slope(b).x);
        walls.add(heights[b] - heights[a] - climb, slope(b).y - slope(a).y, pitch.y);
    }
    for (a, b) in grid.y_pairs(periodic) {
        let climb = 0.5 * pitch.y * (slope(a).y + slope(b).y);
        walls.add(heights[b] - heights[a] - climb, slope(b).x - slope(a).x, pitch.x);
    }
    let valleys = |cyclic| {
        grid.x_pairs(cyclic).filter(|&(a, b)| slope(b).x > slope(a).x).count()
            + grid.y_pairs(cyclic).filter(|&(a, b)| slope(b).y > slope(a).y).count()
    };
    let plate = grid.cells() as f64 * pitch.x * pitch.y;
    Steps {
        rms: if walls.length > 0.0 { (walls.squares / walls.length).sqrt() } else { 0.0 },
        wall_area_ratio: if plate > 0.0 { walls.area / plate } else { 0.0 },
        valleys: valleys(true),
        inner_valleys: valleys(false),
    }
}

/// Sums over edges: length (mm), ∫ step² (mm³), ∫ |step| (mm²).
#[derive(Default)]
struct Walls {
    length: f64,
    squares: f64,
    area: f64,
}

impl Walls {
    /// An edge of `length` mm with the step `middle` at its middle and the change `rate` of the step along it.
    fn add(&mut self, middle: f64, rate: f64, length: f64) {
        let swing = 0.5 * rate.abs() * length;
        self.length += length;
        self.squares += length * (middle * middle + swing * swing / 3.0);
        self.area +=
            if middle.abs() >= swing { middle.abs() * length } else { (middle * middle + swing * swing) / rate.abs() };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::slope::Slope;

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-12, "{a} instead of {b}");
    }

    #[test]
    fn a_plane_has_neither_walls_nor_valleys_but_a_net_climb_across_the_rim() {
        let pitch = DVec2::new(0.5, 2.0);
        let grid = SlopeGrid::from_fn(3, 4, |_, _| Slope::new(0.1, -0.3));
        let heights: Vec<f64> = (0..12).map(|k| 0.1 * 0.5 * (k % 3) as f64 - 0.3 * 2.0 * (k / 3) as f64).collect();
        let open = steps(&grid, &heights, pitch, false);
        close(open.rms, 0.0);
        close(open.wall_area_ratio, 0.0);
        assert_eq!((open.valleys, open.inner_valleys), (0, 0));
        // Across the rim in x: 4 edges of 2 mm, 0.15 mm high; in y: 3 edges of 0.5 mm, 2.4 mm high.
        let closed = steps(&grid, &heights, pitch, true);
        close(closed.wall_area_ratio, (4.0 * 2.0 * 0.15 + 3.0 * 0.5 * 2.4) / 12.0);
        let squares = 4.0 * 2.0 * 0.15f64.powi(2) + 3.0 * 0.5 * 2.4f64.powi(2);
        close(closed.rms, (squares / (12.0 * 2.0 + 12.0 * 0.5)).sqrt());
    }

    #[test]
    fn two_facets_twisted_against_each_other_have_the_wall_of_two_triangles() {
        let grid = SlopeGrid { columns: 2, rows: 1, slopes: vec![Slope::new(0.2, -0.1), Slope::new(-0.2, 0.3)] };
        // Meeting at the middle of their edge of 3 mm: two triangles of legs 1.5 and 0.6.
        let level = steps(&grid, &[0.0, 0.0], DVec2::new(1.0, 3.0), false);
        close(level.wall_area_ratio, 2.0 * 0.5 * 1.5 * 0.6 / 6.0);
        close(level.rms, 0.6 / 3f64.sqrt());
        // Lifted by 0.2, the step runs from -0.4 to 0.8: triangles over 1 mm and 2 mm.
        let lifted = steps(&grid, &[0.0, 0.2], DVec2::new(1.0, 3.0), false);
        close(lifted.wall_area_ratio, (0.5 * 1.0 * 0.4 + 0.5 * 2.0 * 0.8) / 6.0);
        // Lifted clear: a trapezium of mean height 0.7.
        let clear = steps(&grid, &[0.0, 0.7], DVec2::new(1.0, 3.0), false);
        close(clear.wall_area_ratio, 3.0 * 0.7 / 6.0);
        close(clear.rms, (0.49f64 + 0.36 / 3.0).sqrt());
    }

    #[test]
    fn areas_agree_with_sums_over_thin_strips() {
        let grid = SlopeGrid::from_fn(3, 2, |i, j| Slope::new((i * 7 + j * 3) as f64 % 1.1, (i * j * 5) as f64 % 0.7));
        let heights = [0.1, -0.2, 0.15, 0.3, 0.0, -0.1];
        let pitch = DVec2::new(1.0, 0.5);
        let plane = |k: usize, x: f64, y: f64| heights[k] + grid.slopes[k].p * x + grid.slopes[k].q * y;
        let strips = 20_000;
        let (mut area, mut squares, mut length) = (0.0, 0.0, 0.0);
        for s in 0..strips {
            let t = (s as f64 + 0.5) / strips as f64 - 0.5;
            for (a, b) in grid.x_pairs(true) {
                let step = plane(b, -0.5, 0.5 * t) - plane(a, 0.5, 0.5 * t);
                (area, squares, length) = (area + 0.5 * step.abs(), squares + 0.5 * step * step, length + 0.5);
            }
            for (a, b) in grid.y_pairs(true) {
                let step = plane(b, t, -0.25) - plane(a, t, 0.25);
                (area, squares, length) = (area + step.abs(), squares + step * step, length + 1.0);
            }
        }
        let exact = steps(&grid, &heights, pitch, true);
        assert!((exact.wall_area_ratio - area / strips as f64 / 3.0).abs() < 1e-7);
        assert!((exact.rms - (squares / length).sqrt()).abs() < 1e-7);
    }

    #[test]
    fn a_bowl_is_all_valleys_inside_and_a_dome_only_at_the_rim() {
        let bowl = |sign: f64| {
            SlopeGrid::from_fn(5, 4, move |i, j| Slope::new(sign * (i as f64 - 2.0), sign * (j as f64 - 1.5)))
        };
        let inner = 4 * 4 + 5 * 3;
        let count = |grid: &SlopeGrid| {
            let s = steps(grid, &[0.0; 20], DVec2::ONE, false);
            (s.valleys, s.inner_valleys)
        };
        assert_eq!(count(&bowl(1.0)), (inner, inner));
        assert_eq!(count(&bowl(-1.0)), (4 + 5, 0));
        assert_eq!(count(&SlopeGrid { columns: 1, rows: 1, slopes: vec![Slope::new(1.0, 1.0)] }), (0, 0));
        assert_eq!(steps(&SlopeGrid { columns: 0, rows: 0, slopes: vec![] }, &[], DVec2::ONE, true), Steps::default());
    }
}
