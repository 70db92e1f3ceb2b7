//! Arcs and helices with their exact centres, and as chords.

use std::f64::consts::TAU;

use glam::DVec3;

/// The plane of an arc.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Plane {
    /// G17.
    #[default]
    Xy,
    /// G18.
    Zx,
    /// G19.
    Yz,
}

impl Plane {
    /// Its two axes and the one along which a helix climbs, right-handed; 0 is x.
    pub fn axes(self) -> [usize; 3] {
        match self {
            Self::Xy => [0, 1, 2],
            Self::Zx => [2, 0, 1],
            Self::Yz => [1, 2, 0],
        }
    }

    /// The G word that chooses it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Xy => "G17",
            Self::Zx => "G18",
            Self::Yz => "G19",
        }
    }
}

/// An arc or helix, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    /// The plane of its circle.
    pub plane: Plane,
    /// Where it begins.
    pub start: DVec3,
    /// Where it ends.
    pub end: DVec3,
    /// Its centre, along the two axes of the plane.
    pub centre: [f64; 2],
    /// How far it turns, radians: counter-clockwise, seen against the third axis, is positive.
    pub turn: f64,
}

/// By how much an arc's radius may differ between its ends, mm.
const RADIUS_SLACK: f64 = 0.005;

/// And as a share of the radius, if that is more. Both are GRBL's bounds.
const RADIUS_SHARE: f64 = 0.001;

/// An angle below which start and end count as one, so that the arc is a whole turn, radians; GRBL's bound.
const ONE_ANGLE: f64 = 5e-7;

impl Arc {
    /// From `start` to `end` about `centre`.
    ///
    /// # Errors
    /// The centre is not as far from one end as from the other, or on both.
    pub fn about(
        plane: Plane,
        (start, end): (DVec3, DVec3),
        centre: [f64; 2],
        clockwise: bool,
        turns: u32,
    ) -> Result<Self, ArcFault> {
        let mut arc = Self { plane, start, end, centre, turn: 0.0 };
        let ((first, from), (last, to)) = (arc.polar(start), arc.polar(end));
        let apart = (first - last).abs();
        if apart > RADIUS_SLACK && apart > RADIUS_SHARE * first {
            return Err(ArcFault::Open { first, last });
        }
        if first == 0.0 || last == 0.0 {
            return Err(ArcFault::NoRadius);
        }
        let forward = if clockwise { from - to } else { to - from };
        let forward = forward.rem_euclid(TAU);
        let forward = if forward <= ONE_ANGLE { forward + TAU } else { forward };
        let whole = forward + TAU * f64::from(turns.saturating_sub(1));
        arc.turn = if clockwise { -whole } else { whole };
        Ok(arc)
    }

    /// From `start` to `end` with a radius; a negative one goes the longer way.
    ///
    /// # Errors
    /// No circle of this radius passes both ends, or any does.
    pub fn of_radius(
        plane: Plane,
        (start, end): (DVec3, DVec3),
        radius: f64,
        clockwise: bool,
        turns: u32,
    ) -> Result<Self, ArcFault> {
        let [a, b, _] = plane.axes();
        let (x, y) = (end[a] - start[a], end[b] - start[b]);
        let distance = x.hypot(y);
        if distance == 0.0 {
            return Err(ArcFault::NoDistance);
        }
        let half = 0.5 * distance;
        if half - radius.abs() > RADIUS_SLACK.min(RADIUS_SHARE * half) {
            return Err(ArcFault::Short { radius: radius.abs(), half });
        }
        let height = (radius * radius - half * half).max(0.0).sqrt();
        let height = if clockwise == (radius > 0.0) { -height } else { height };
        let centre = [start[a] + 0.5 * x - y / distance * height, start[b] + 0.5 * y + x / distance * height];
        Self::about(plane, (start, end), centre, clockwise, turns)
    }

    /// Radius and angle of a point about the centre.
    fn polar(&self, point: DVec3) -> (f64, f64) {
        let [a, b, _] = self.plane.axes();
        let (x, y) = (point[a] - self.centre[0], point[b] - self.centre[1]);
        (x.hypot(y), y.atan2(x))
    }

    /// Radius at its start and at its end, mm.
    pub fn radii(&self) -> [f64; 2] {
        [self.polar(self.start).0, self.polar(self.end).0]
    }

    /// The point at a share `t` of the way. Where the radii differ it is a spiral.
    pub fn at(&self, t: f64) -> DVec3 {
        if t <= 0.0 {
            return self.start;
        }
        if t >= 1.0 {
            return self.end;
        }
        let ((first, from), (last, _)) = (self.polar(self.start), self.polar(self.end));
        let (radius, angle) = (first + t * (last - first), from + t * self.turn);
        let [a, b, c] = self.plane.axes();
        let mut point = DVec3::ZERO;
        point[a] = self.centre[0] + radius * angle.cos();
        point[b] = self.centre[1] + radius * angle.sin();
        point[c] = self.start[c] + t * (self.end[c] - self.start[c]);
        point
    }

    /// Direction of travel at its start and at its end, of length 1.
    pub fn directions(&self) -> [DVec3; 2] {
        let [a, b, c] = self.plane.axes();
        [self.start, self.end].map(|point| {
            let (radius, angle) = self.polar(point);
            let mut along = DVec3::ZERO;
            along[a] = -radius * angle.sin() * self.turn;
            along[b] = radius * angle.cos() * self.turn;
            along[c] = self.end[c] - self.start[c];
            along.normalize_or_zero()
        })
    }

    /// Its length, mm; of a spiral that of its mean circle.
    pub fn length(&self) -> f64 {
        let [first, last] = self.radii();
        let climb = self.end[self.plane.axes()[2]] - self.start[self.plane.axes()[2]];
        (0.5 * (first + last) * self.turn).hypot(climb)
    }

    /// Least and largest coordinates on it, mm.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let (mut low, mut high) = (self.start.min(self.end), self.start.max(self.end));
        let quarter = 0.25 * TAU;
        let from = self.polar(self.start).1;
        // Extremes of a circle are at whole quarters of a turn.
        let [first, last] = [from.min(from + self.turn), from.max(from + self.turn)].map(|angle| angle / quarter);
        let mut mark = first.ceil();
        let end = last.min(mark + 4.0);
        while mark <= end {
            let point = self.at((mark * quarter - from) / self.turn);
            (low, high) = (low.min(point), high.max(point));
            mark += 1.0;
        }
        (low, high)
    }

    /// Into how many chords it is to be cut, so that none is more than `chord` mm off.
    ///
    /// A curve strays from its chord by at most an eighth of its second derivative times the square of the step.
    pub fn chords(&self, chord: f64) -> u32 {
        let [first, last] = self.radii();
        let bend = first.max(last) * self.turn * self.turn + 2.0 * (last - first).abs() * self.turn.abs();
        (bend / (8.0 * chord)).sqrt().ceil().clamp(1.0, 1e6) as u32
    }

    /// The ends of chords that are nowhere more than `chord` mm off, or of a million chords if it would take more.
    pub fn flattened(self, chord: f64) -> impl Iterator<Item = DVec3> {
        let n = self.chords(chord);
        (1..=n).map(move |k| self.at(f64::from(k) / f64::from(n)))
    }
}

/// Words that make no arc.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ArcFault {
    /// The centre is not as far from both ends.
    #[error(
        "the arc does not close: its centre is {first:.4} mm from its start and {last:.4} mm from its end; write I, J, K with more digits, or relative to the start (G91.1)"
    )]
    Open {
        /// Radius at the start, mm.
        first: f64,
        /// Radius at the end, mm.
        last: f64,
    },
    /// The centre is on an end.
    #[error("the arc's centre is on its end: write I, J, K of its plane, from the start to the centre")]
    NoRadius,
    /// A radius too short.
    #[error("no arc of radius {radius:.4} mm reaches its end, which is {:.4} mm away: write I, J, K in place of R", 2.0 * half)]
    Short {
        /// Its radius, mm.
        radius: f64,
        /// Half the way between the ends, mm.
        half: f64,
    },
    /// A whole turn by its radius.
    #[error("an arc with R ends where it begins, and any centre would do: write I, J, K for a whole turn")]
    NoDistance,
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn v(x: f64, y: f64, z: f64) -> DVec3 {
        DVec3::new(x, y, z)
    }

    #[test]
    fn quarters_in_every_plane_turn_as_seen_against_the_third_axis() {
        // G17 G3 from +x to +y; G18 G3 from +z to +x; G19 G3 from +y to +z.
        for (plane, start, end) in
            [(Plane::Xy, DVec3::X, DVec3::Y), (Plane::Zx, DVec3::Z, DVec3::X), (Plane::Yz, DVec3::Y, DVec3::Z)]
        {
            let arc = Arc::about(plane, (start, end), [0.0; 2], false, 1).unwrap();
            assert!((arc.turn - PI / 2.0).abs() < 1e-15 && (arc.length() - PI / 2.0).abs() < 1e-15);
            assert!((arc.at(0.5) - (start + end) / 2f64.sqrt()).length() < 1e-15);
            let other = Arc::about(plane, (start, end), [0.0; 2], true, 1).unwrap();
            assert!((other.turn + 1.5 * PI).abs() < 1e-15);
            assert_eq!(
                other.bounds(),
                (v(0.0, 0.0, 0.0).min(other.at(1.0 / 3.0)).min(other.at(2.0 / 3.0)), start + end)
            );
            let [from, to] = arc.directions();
            assert!((from - end).length() < 1e-15 && (to + start).length() < 1e-15);
            // By its radius: the short way, and with a minus the long one.
            let short = Arc::of_radius(plane, (start, end), 1.0, false, 1).unwrap();
            assert!((short.turn - arc.turn).abs() < 1e-12 && short.centre.iter().all(|c| c.abs() < 1e-12));
            let long = Arc::of_radius(plane, (start, end), -1.0, true, 1).unwrap();
            assert!((long.turn - other.turn).abs() < 1e-12 && long.centre.iter().all(|c| c.abs() < 1e-12));
        }
    }

    #[test]
    fn a_helix_of_three_turns_climbs_evenly() {
        let arc = Arc::about(Plane::Xy, (v(2.0, 0.0, 0.0), v(2.0, 0.0, -6.0)), [0.0; 2], false, 3).unwrap();
        assert!((arc.turn - 3.0 * TAU).abs() < 1e-12);
        assert!((arc.at(0.25) - v(0.0, -2.0, -1.5)).length() < 1e-12, "three quarters of a turn");
        let (low, high) = arc.bounds();
        assert!((low - v(-2.0, -2.0, -6.0)).length() < 1e-12 && (high - v(2.0, 2.0, 0.0)).length() < 1e-12);
    }

    #[test]
    fn chords_are_as_near_as_said_and_no_more_than_needed() {
        for (radius, turn, chord) in [(0.25, 1.0, 1e-4), (10.0, TAU, 2e-3), (300.0, 0.1, 1e-5), (1.0, 6.0, 0.5)] {
            let end = v(radius * f64::cos(turn), radius * f64::sin(turn), 1.0);
            let arc = Arc::about(Plane::Xy, (v(radius, 0.0, 0.0), end), [0.0; 2], false, 1).unwrap();
            let points: Vec<DVec3> = [arc.start].into_iter().chain(arc.flattened(chord)).collect();
            assert_eq!(points[points.len() - 1], end);
            // Middles of chords are where a circle is farthest.
            let off = |pair: &[DVec3]| radius - (0.5 * (pair[0] + pair[1])).truncate().length();
            let most = points.windows(2).map(off).fold(0.0, f64::max);
            assert!(most <= chord * (1.0 + 1e-9), "{most} {chord}");
            let fewer = f64::from(arc.chords(chord)) - 1.0;
            assert!(fewer < 1.0 || radius * (1.0 - f64::cos(turn.min(TAU) / fewer / 2.0)) > 0.9 * chord);
        }
    }

    #[test]
    fn what_makes_no_arc_is_refused() {
        let ends = (v(0.0, 0.0, 0.0), v(10.0, 0.0, 0.0));
        let fault = |fault: Result<Arc, ArcFault>| fault.unwrap_err();
        // 0.1 % of 5 mm is 0.005 mm: 0.0049 passes, 0.0061 does not.
        assert!(Arc::about(Plane::Xy, ends, [5.002_45, 0.0], true, 1).is_ok());
        assert!(matches!(fault(Arc::about(Plane::Xy, ends, [5.003_05, 0.0], true, 1)), ArcFault::Open { .. }));
        assert_eq!(fault(Arc::about(Plane::Xy, (ends.0, ends.0), [0.0; 2], true, 1)), ArcFault::NoRadius);
        assert_eq!(fault(Arc::of_radius(Plane::Xy, (ends.0, ends.0), 1.0, true, 1)), ArcFault::NoDistance);
        assert!(matches!(fault(Arc::of_radius(Plane::Xy, ends, 4.99, true, 1)), ArcFault::Short { .. }));
        assert!(Arc::of_radius(Plane::Xy, ends, 4.9999, true, 1).is_ok(), "a half circle whose radius was rounded");
    }
}
