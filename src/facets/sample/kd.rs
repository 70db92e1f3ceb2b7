//! Splitting points into compact groups of equal size.

use glam::DVec2;

use crate::progress::{Cancelled, Progress};

/// Reorders `items` so that each run of `size` items is a compact group: halves, again and again,
/// across the longer side of their box. `items.len()` must be a multiple of `size`. Abandoned, it leaves
/// them in some order.
pub fn group<T>(
    items: &mut [T],
    size: usize,
    position: &impl Fn(&T) -> DVec2,
    progress: &Progress,
) -> Result<(), Cancelled> {
    let groups = items.len() / size;
    if groups < 2 {
        return Ok(());
    }
    progress.check()?;
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for at in items.iter().map(position) {
        low = low.min(at);
        high = high.max(at);
    }
    let extent = high - low;
    let axis = if extent.x >= extent.y { DVec2::X } else { DVec2::Y };
    let middle = groups / 2 * size;
    items.select_nth_unstable_by(middle, |a, b| position(a).dot(axis).total_cmp(&position(b).dot(axis)));
    let (left, right) = items.split_at_mut(middle);
    group(left, size, position, progress)?;
    group(right, size, position, progress)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_of_a_grid_are_its_blocks() {
        let mut points: Vec<DVec2> = (0..64).map(|k| DVec2::new((k * 5 % 8) as f64, (k / 8) as f64)).collect();
        group(&mut points, 4, &|p| *p, &Progress::silent()).unwrap();
        for block in points.chunks(4) {
            let centre = block.iter().sum::<DVec2>() / 4.0;
            assert!(block.iter().all(|p| p.distance(centre) < 0.75), "{block:?}");
        }
    }
}
