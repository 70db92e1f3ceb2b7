//! Scales along the edges of a picture on its page.

use glam::DVec2;

use super::lettering::{self, Align};
use super::page::{LINE, Page, TEXT, Unit, pixel};
use super::ticks::{self, number, round_below};
use crate::projection::View;

/// Where a picture stands on its page, pixels.
#[derive(Clone, Copy)]
pub(super) struct Place {
    /// Its left edge.
    pub left: i64,
    /// Its upper edge.
    pub top: i64,
    /// Its width.
    pub width: i64,
    /// Its height.
    pub height: i64,
}

/// A mark along an edge.
struct Mark {
    /// From -1 to 1 along the edge, right or up.
    position: f64,
    /// What stands beside it, if anything.
    label: Option<String>,
}

/// Ticks at the lower and the left edge in degrees from the mirror direction, laid out by `view`; the labels of the left edge
/// only if they are wanted.
pub(super) fn degrees(page: &mut Page, unit: Unit, place: Place, view: &View, left_labels: bool) {
    for (along, is_x) in [(DVec2::X, true), (DVec2::Y, false)] {
        let mut ticks = ticks::ticks(view, along);
        // From the centre outward, labelled ones first: where a scale crowds, the middle stays legible.
        ticks.sort_by(|a, b| b.labelled.cmp(&a.labelled).then(a.angle.abs().total_cmp(&b.angle.abs())));
        let label = |angle: f64| format!("{}°", number(angle));
        let marks =
            ticks.iter().map(|tick| Mark { position: tick.position, label: tick.labelled.then(|| label(tick.angle)) });
        draw(page, unit, place, (is_x, is_x || left_labels), marks);
    }
}

/// Ticks at the lower and the left edge of a picture whose rim is `half` away from its middle, where 0 stands; `mirrored`
/// counts from right to left. `label` writes a value.
pub(super) fn linear(
    page: &mut Page,
    unit: Unit,
    place: Place,
    (half, mirrored): (f64, bool),
    label: impl Fn(f64) -> String,
) {
    let Some(step) = round_below(half / 2.0) else { return };
    let lead = step / 10f64.powf(step.log10().floor());
    let minor = if (lead - 2.0).abs() < 0.1 { 4 } else { 5 };
    let most = (half / step * f64::from(minor) + 1e-9) as i64;
    for is_x in [true, false] {
        let marks = (-most..=most).map(|k| {
            let at = k as f64 / f64::from(minor) * step;
            let position = if is_x && mirrored { -at / half } else { at / half };
            Mark { position, label: (k % i64::from(minor) == 0).then(|| label(at)) }
        });
        draw(page, unit, place, (is_x, true), marks);
    }
}

/// Draws marks along the lower or the left edge, their labels if they are wanted and where there is room.
fn draw(page: &mut Page, unit: Unit, place: Place, (is_x, labels): (bool, bool), marks: impl Iterator<Item = Mark>) {
    let Place { left, top, width, height } = place;
    let (bottom, hair, length) = (top + height, unit.hair(), if is_x { width } else { height });
    let (mut drawn, mut taken) = (Vec::<i64>::new(), Vec::<(i64, i64)>::new());
    for Mark { position, label } in marks {
        let position = if is_x { position } else { -position };
        let at = (((position + 1.0) * 0.5 * length as f64).round() as i64).min(length - 1);
        if label.is_none() && drawn.iter().any(|d| (d - at).abs() < unit.px(6.0)) {
            continue;
        }
        drawn.push(at);
        let reach = unit.px(if label.is_some() { 9.0 } else { 5.0 });
        if is_x {
            page.fill([left + at - hair / 2, bottom + hair, hair, reach], LINE);
        } else {
            page.fill([left - hair - reach, top + at - hair / 2, reach, hair], LINE);
        }
        let Some(label) = label.filter(|_| labels) else { continue };
        let wide = if is_x { lettering::width(&label, unit.size(19.0)) as i64 } else { unit.px(18.0) };
        let (from, to) = (at - wide / 2 - unit.px(4.0), at + wide / 2 + unit.px(4.0));
        if taken.iter().any(|&(a, b)| from < b && a < to) {
            continue;
        }
        taken.push((from, to));
        if is_x {
            page.write(&label, pixel(left + at, bottom + unit.px(30.0)), unit.style(19.0, TEXT, Align::Centre));
        } else {
            let place = pixel(left - unit.px(16.0), top + at + unit.px(7.0));
            page.write(&label, place, unit.style(19.0, TEXT, Align::Right));
        }
    }
}
