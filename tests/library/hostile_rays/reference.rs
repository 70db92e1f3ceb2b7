//! Surfaces as functions of the place, beside which a tracer's hits are held.

use facetmill::relief::faceted::FacetedRelief;
use facetmill::relief::height_grid::HeightGrid;
use glam::DVec2;

/// The surface as a function: lowest and highest height at a point, walls included, and whether it is on the plate.
pub trait Reference {
    fn lines(&self) -> (&[f64], &[f64]);

    /// Height of the piece over cell (i, j), continued to `at`; two at a fold.
    fn heights(&self, i: usize, j: usize, at: DVec2) -> [f64; 2];

    fn size(&self) -> f64 {
        let (x, y) = self.lines();
        (x[x.len() - 1] - x[0]).max(y[y.len() - 1] - y[0])
    }

    fn corners(&self) -> (DVec2, DVec2) {
        let (x, y) = self.lines();
        (DVec2::new(x[0], y[0]), DVec2::new(x[x.len() - 1], y[y.len() - 1]))
    }

    /// Lowest and highest height of the cells that touch `at`, or of their copies one period away.
    fn range(&self, at: DVec2, endless: bool) -> (f64, f64) {
        let (x, y) = self.lines();
        let slack = 1e-12 * self.size();
        let touched = |lines: &[f64], at: f64| {
            let n = lines.len() - 1;
            let mut cells: Vec<(usize, f64)> =
                (0..n).filter(|&k| lines[k] - slack <= at && at <= lines[k + 1] + slack).map(|k| (k, at)).collect();
            if endless && at <= lines[0] + slack {
                cells.push((n - 1, lines[n]));
            }
            if endless && at >= lines[n] - slack {
                cells.push((0, lines[0]));
            }
            cells
        };
        let mut range = (f64::INFINITY, f64::NEG_INFINITY);
        for (j, y) in touched(y, at.y) {
            for &(i, x) in &touched(x, at.x) {
                for z in self.heights(i, j, DVec2::new(x, y)) {
                    range = (range.0.min(z), range.1.max(z));
                }
            }
        }
        range
    }
}

impl Reference for FacetedRelief {
    fn lines(&self) -> (&[f64], &[f64]) {
        (&self.x, &self.y)
    }

    fn heights(&self, i: usize, j: usize, at: DVec2) -> [f64; 2] {
        [self.plane_height(i, j, at); 2]
    }
}

impl Reference for HeightGrid {
    fn lines(&self) -> (&[f64], &[f64]) {
        (&self.x, &self.y)
    }

    fn heights(&self, i: usize, j: usize, at: DVec2) -> [f64; 2] {
        let node = |a: usize, b: usize| self.heights[(j + b) * self.x.len() + i + a];
        let u = ((at.x - self.x[i]) / (self.x[i + 1] - self.x[i])).clamp(0.0, 1.0);
        let v = ((at.y - self.y[j]) / (self.y[j + 1] - self.y[j])).clamp(0.0, 1.0);
        // In a mirror where the cut rises, so that it always falls.
        let rises = self.rising[j * (self.x.len() - 1) + i];
        let (u, left, right) = if rises { (1.0 - u, 1, 0) } else { (u, 0, 1) };
        let [z00, z10, z01, z11] = [node(left, 0), node(right, 0), node(left, 1), node(right, 1)];
        let lower = z00 + u * (z10 - z00) + v * (z01 - z00);
        let upper = z11 + (1.0 - u) * (z01 - z11) + (1.0 - v) * (z10 - z11);
        [if u + v <= 1.0 { lower } else { upper }; 2]
    }
}
