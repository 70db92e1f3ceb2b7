//! The warp of `.bsdf` files: from the unit square to a density on it, along rows last.

/// A density over the unit square given at nodes, bilinear between them, and the map that makes it of a uniform one:
/// v from the marginal of rows, then u from the row found, both inverted exactly within their interval.
pub(super) struct Warp<'a> {
    values: &'a [f64],
    columns: usize,
    /// Integral along each row up to each node.
    conditional: Vec<f64>,
    /// Integral over the square up to each row.
    marginal: Vec<f64>,
}

impl<'a> Warp<'a> {
    /// `values` are not negative, `columns` to a row; they need not integrate to 1.
    pub(super) fn new(values: &'a [f64], columns: usize) -> Self {
        let mut conditional = Vec::with_capacity(values.len());
        for row in values.chunks_exact(columns) {
            conditional.push(0.0);
            let mut sum = 0.0;
            for pair in row.windows(2) {
                sum += 0.5 * (pair[0] + pair[1]);
                conditional.push(sum);
            }
        }
        let totals: Vec<f64> = conditional.chunks_exact(columns).map(|row| row[columns - 1]).collect();
        let mut marginal = vec![0.0];
        let mut sum = 0.0;
        for pair in totals.windows(2) {
            sum += 0.5 * (pair[0] + pair[1]);
            marginal.push(sum);
        }
        Self { values, columns, conditional, marginal }
    }

    /// The point (s1, s2) of the unit square that goes to (u, v): the inverse of [`sample`](Self::sample).
    pub(super) fn place_of(&self, u: f64, v: f64) -> (f64, f64) {
        let (columns, rows) = (self.columns, self.marginal.len());
        let place = |t: f64, n: usize| {
            let at = t.clamp(0.0, 1.0) * (n - 1) as f64;
            let low = (at as usize).min(n - 2);
            (low, at - low as f64)
        };
        let ((column, s), (row, t)) = (place(u, columns), place(v, rows));
        // What lies below a place of a line from a to b.
        let under = |a: f64, b: f64, t: f64| t * (a + 0.5 * t * (b - a));
        let total = |row: usize| self.conditional[columns * row + columns - 1];
        let below = self.marginal[row] + under(total(row), total(row + 1), t);
        let mix = |list: &[f64], k: usize| list[columns * row + k] * (1.0 - t) + list[columns * (row + 1) + k] * t;
        let left = mix(&self.conditional, column) + under(mix(self.values, column), mix(self.values, column + 1), s);
        let share = |part: f64, whole: f64| if whole > 0.0 { (part / whole).clamp(0.0, 1.0) } else { 0.5 };
        (share(left, mix(&self.conditional, columns - 1)), share(below, self.marginal[rows - 1]))
    }

    /// Where the point (s1, s2) of the unit square goes: (u, v).
    pub(super) fn sample(&self, s1: f64, s2: f64) -> (f64, f64) {
        // Readers keep off the very edge too: where an edge has no density, the limit from inside counts.
        let [s1, s2] = [s1, s2].map(|s| s.clamp(1e-12, 1.0 - 1e-12));
        let columns = self.columns;
        let rows = self.marginal.len();
        let (row, t) = {
            let total = |row: usize| self.conditional[columns * row + columns - 1];
            let wanted = s2 * self.marginal[rows - 1];
            let row = self.marginal[1..rows - 1].partition_point(|c| *c < wanted);
            (row, ramp(total(row), total(row + 1), wanted - self.marginal[row]))
        };
        let mix = |list: &[f64], k: usize| list[columns * row + k] * (1.0 - t) + list[columns * (row + 1) + k] * t;
        let wanted = s1 * mix(&self.conditional, columns - 1);
        let (mut low, mut high) = (0, columns - 1);
        while high - low > 1 {
            let middle = (low + high) / 2;
            if mix(&self.conditional, middle) < wanted { low = middle } else { high = middle }
        }
        let s = ramp(mix(self.values, low), mix(self.values, low + 1), wanted - mix(&self.conditional, low));
        ((low as f64 + s) / (columns - 1) as f64, (row as f64 + t) / (rows - 1) as f64)
    }
}

/// Where in [0, 1] the integral of the line from `a` to `b` reaches `area`; the stable root of the quadratic.
fn ramp(a: f64, b: f64, area: f64) -> f64 {
    let root = (a * a + 2.0 * area * (b - a)).max(0.0).sqrt();
    if a + root > 0.0 { (2.0 * area / (a + root)).clamp(0.0, 1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_warp_follows_closed_forms() {
        // Uniform: the identity.
        let warp = Warp::new(&[2.0; 12], 4);
        for (s, t) in [(0.0, 0.0), (0.3, 0.9), (1.0, 1.0), (0.5, 0.123)] {
            let (u, v) = warp.sample(s, t);
            assert!((u - s).abs() < 1e-11 && (v - t).abs() < 1e-11);
        }
        // Density 2u: u = sqrt(s). Density 4uv: both.
        let ramps: Vec<f64> = (0..30).map(|k| f64::from(k % 6) * f64::from(k / 6)).collect();
        let warp = Warp::new(&ramps, 6);
        for (s, t) in [(0.0f64, 0.0f64), (0.3, 0.9), (1.0, 1.0), (0.5, 0.123)] {
            let (u, v) = warp.sample(s, t);
            let (back, up) = warp.place_of(u, v);
            assert!((back - s).abs() < 1e-6 && (up - t).abs() < 1e-6, "{s} {t} {back} {up}");
            assert!((u - s.sqrt()).abs() < 2e-6 && (v - t.sqrt()).abs() < 2e-6, "{s} {t} {u} {v}");
        }
    }

    #[test]
    fn nothing_lands_where_there_is_no_density() {
        let values: Vec<f64> = (0..100).map(|k| f64::from(u8::from(k % 10 == 6 && k / 10 == 3))).collect();
        let warp = Warp::new(&values, 10);
        for k in 0..=100 {
            let (u, v) = warp.sample(f64::from(k) / 100.0, f64::from(k * 37 % 101) / 100.0);
            assert!((u * 9.0 - 6.0).abs() <= 1.0 && (v * 9.0 - 3.0).abs() <= 1.0, "{u} {v}");
        }
    }
}
