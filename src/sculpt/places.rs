//! Some places of a grid whose rows and columns continue into themselves.

use std::ops::Range;

/// Columns and rows of a rectangle of places; it may stand across a rim of the grid.
pub(super) type Rectangle = [Range<isize>; 2];

/// Places of a grid.
pub(super) struct Places {
    /// The columns of each row, in ascending order: ranges that do not meet.
    pub rows: Vec<Vec<Range<usize>>>,
}

impl Places {
    /// All of a grid of so many columns and rows.
    pub fn all([columns, rows]: [usize; 2]) -> Self {
        Self { rows: vec![vec![0..columns]; rows] }
    }

    /// Those of a grid of `size` columns and rows that lie in a rectangle, or up to `more` places aside and above or below it.
    pub fn around(rectangles: &[Rectangle], more: [usize; 2], size: [usize; 2]) -> Self {
        let mut rows = vec![Vec::new(); size[1]];
        for rectangle in rectangles {
            let [(column, width), (row, height)] = [0, 1].map(|k| {
                let Range { start, end } = rectangle[k];
                let (start, length) = (start - more[k] as isize, (end - start) as usize + 2 * more[k]);
                if length < size[k] { (start.rem_euclid(size[k] as isize) as usize, length) } else { (0, size[k]) }
            });
            for row in row..row + height {
                let ranges: &mut Vec<Range<usize>> = &mut rows[row % size[1]];
                ranges.push(column..(column + width).min(size[0]));
                if column + width > size[0] {
                    ranges.push(0..column + width - size[0]);
                }
            }
        }
        rows.iter_mut().for_each(merge);
        Self { rows }
    }
}

/// Sorts ranges and joins those that meet.
fn merge(ranges: &mut Vec<Range<usize>>) {
    ranges.sort_unstable_by_key(|range| range.start);
    ranges.dedup_by(|next, kept| {
        let meet = next.start <= kept.end;
        if meet {
            kept.end = kept.end.max(next.end);
        }
        meet
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rectangles_grow_meet_and_go_on_across_rims() {
        let places = Places::around(&[[-2..1, 0..1], [3..4, 1..2], [8..9, 0..1]], [1, 1], [10, 6]);
        // Columns 7 to 9 and 0 to 1, 2 to 4, 7 to 9 of rows -1 to 1, 0 to 2, -1 to 1.
        let across = [0..2, 7..10];
        assert_eq!(places.rows[5], across);
        assert_eq!(places.rows[0], [0..5, 7..10]);
        assert_eq!(places.rows[1], [0..5, 7..10]);
        assert_eq!(places.rows[2].as_slice(), std::slice::from_ref(&(2..5)));
        assert!(places.rows[3].is_empty() && places.rows[4].is_empty());
        let wide = Places::around(&[[4..5, 2..3]], [5, 9], [10, 6]);
        assert_eq!(wide.rows, Places::all([10, 6]).rows);
    }
}
