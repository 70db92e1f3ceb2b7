//! Moves of G-code programs, as several test programs compare them.

use glam::DVec3;

/// Those of `moves` that go anywhere, or along an arc: a place said again is no move.
pub fn going<T>(moves: impl Iterator<Item = T>, place: impl Fn(&T) -> (bool, DVec3)) -> Vec<T> {
    let mut at = DVec3::ZERO;
    let goes = |one: &T| {
        let (is_arc, to) = place(one);
        std::mem::replace(&mut at, to).distance(to) > 1e-7 || is_arc
    };
    moves.filter(goes).collect()
}
