//! Anything with a place in the plane, laid out on a grid: equal shares to equal parts, again and again.

use glam::DVec2;

/// `items` in the order of a grid of `columns` × `rows` cells, as many as there are items: what is left of their median
/// goes to the left half of the cells, what is below it to the lower half, and so on within the halves, the longer side
/// first. `place` says where an item is.
pub(super) fn laid_out<T: Copy>(
    mut items: Vec<T>,
    columns: usize,
    rows: usize,
    place: &impl Fn(&T) -> DVec2,
) -> Vec<T> {
    debug_assert_eq!(items.len(), columns * rows);
    let mut grid = items.clone();
    lay(&mut items, &mut grid, columns, ([0, 0], [columns, rows]), place);
    grid
}

/// Lays `items` out on the cells of `grid` from `low` to `high`, both as column and row, the latter left out.
fn lay<T: Copy>(
    items: &mut [T],
    grid: &mut [T],
    columns: usize,
    (low, high): ([usize; 2], [usize; 2]),
    place: &impl Fn(&T) -> DVec2,
) {
    if let [item] = items {
        grid[low[1] * columns + low[0]] = *item;
    }
    if items.len() <= 1 {
        return;
    }
    let size = [high[0] - low[0], high[1] - low[1]];
    let axis = usize::from(size[1] > size[0]);
    let middle = low[axis] + size[axis] / 2;
    let (mut end, mut start) = (high, low);
    (end[axis], start[axis]) = (middle, middle);
    let at = (middle - low[axis]) * size[1 - axis];
    items.select_nth_unstable_by(at, |a, b| place(a)[axis].total_cmp(&place(b)[axis]));
    let (below, above) = items.split_at_mut(at);
    lay(below, grid, columns, (low, end), place);
    lay(above, grid, columns, (start, high), place);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_of_a_grid_come_back_in_its_order() {
        for (columns, rows) in [(1, 1), (1, 9), (13, 11), (30, 4)] {
            let n = columns * rows;
            let cell = |k: usize| DVec2::new((k % columns) as f64, (k / columns) as f64);
            // A multiplier prime to the numbers shuffles them.
            let shuffled: Vec<usize> = (0..n).map(|k| k * 7919 % n).collect();
            let order = laid_out(shuffled, columns, rows, &|k| cell(*k));
            assert!(order.into_iter().eq(0..n), "{columns} × {rows}");
        }
    }
}
