//! Values between the nodes of a grid, and at the corners of a table's cells.

use crate::verify::goniometer::table::BrdfTable;

/// The value at (u, v) in [0, 1]² of a grid of nodes with `columns` columns.
pub(super) fn bilinear(values: &[f64], columns: usize, u: f64, v: f64) -> f64 {
    let rows = values.len() / columns;
    let place = |t: f64, n: usize| {
        let at = t.clamp(0.0, 1.0) * (n - 1) as f64;
        let low = (at as usize).min(n - 2);
        (low, at - low as f64)
    };
    let ((x, s), (y, t)) = (place(u, columns), place(v, rows));
    let row = |y: usize| values[x + columns * y] * (1.0 - s) + values[x + 1 + columns * y] * s;
    row(y) * (1.0 - t) + row(y + 1) * t
}

/// The weighted sum of tables at the corners of their cells, (columns + 1) × (rows + 1), from the means of the cells:
/// (-1, 7, 7, -1)/12 along either axis, exact for cubics, kept between the least and greatest mean it is drawn from.
/// Cells that hold nothing lend their neighbour's value.
pub(super) fn corner_values(tables: &[&BrdfTable], weights: &[f64], slice: usize) -> Vec<f64> {
    let axes = tables[0].axes();
    let (columns, rows) = (axes.columns(), axes.rows());
    let mut cells = vec![0.0; columns * rows];
    for (table, weight) in tables.iter().zip(weights) {
        for (cell, value) in cells.iter_mut().zip(table.slice(slice)) {
            *cell += weight * f64::from(*value);
        }
    }
    let edge = |four: [f64; 4]| {
        let [b, c] = match [four[1].is_nan(), four[2].is_nan()] {
            [true, true] => return f64::NAN,
            [true, false] => [four[2]; 2],
            [false, true] => [four[1]; 2],
            _ => [four[1], four[2]],
        };
        let a = if four[0].is_nan() { b } else { four[0] };
        let d = if four[3].is_nan() { c } else { four[3] };
        let (least, greatest) =
            [a, b, c, d].iter().fold((f64::INFINITY, f64::NEG_INFINITY), |r, v| (r.0.min(*v), r.1.max(*v)));
        ((7.0 * (b + c) - a - d) / 12.0).clamp(least, greatest)
    };
    // Along u, edges of the table lie half a cell outside the means: the first mean stands for the pole.
    let mut along = vec![0.0; (columns + 1) * rows];
    for row in 0..rows {
        let cell = |k: isize| cells[k.clamp(0, columns as isize - 1) as usize + columns * row];
        for column in 0..=columns {
            let k = column as isize;
            along[column + (columns + 1) * row] = edge([k - 2, k - 1, k, k + 1].map(cell));
        }
    }
    let mut corners = vec![0.0; (columns + 1) * (rows + 1)];
    for (node, corner) in corners.iter_mut().enumerate() {
        let (column, row) = (node % (columns + 1), node / (columns + 1));
        let value = |k: usize| along[column + (columns + 1) * ((row + rows + k - 2) % rows)];
        let value = edge([value(0), value(1), value(2), value(3)]);
        *corner = if value.is_nan() { 0.0 } else { value };
    }
    corners
}
