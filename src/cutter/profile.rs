//! The curve that a cutter's underside turns out of: a flat, an arc, a line, each of which may be of no length.
//!
//! ```text
//!   ball              bull nose         flat       cone             tapered ball
//!   R - √(R² - r²)    0, then an arc    0          0, then a line   an arc, then a line
//! ```
//!
//! All of them are convex, so that over a plane, an edge or a grid of points the place of contact moves one way as the
//! slope grows.

use glam::DVec2;

/// Height of a cutter's underside above its tip over the distance from its axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    /// Radius of the flat in the middle, mm.
    pub flat: f64,
    /// Radius of the arc that follows, mm; its centre stands over the rim of the flat.
    pub arc: f64,
    /// Where the arc ends, mm from the axis.
    pub arc_end: f64,
    /// Rise of the line that follows.
    pub steepness: f64,
    /// Largest radius that cuts, mm.
    pub reach: f64,
}

impl Profile {
    /// Height of the underside above the tip at `r` mm from the axis, mm; infinite beyond the reach.
    pub fn underside(&self, r: f64) -> f64 {
        let r = r.abs();
        // What rounding puts a hair beyond the reach belongs to its rim.
        if r > self.reach * (1.0 + 1e-12) {
            f64::INFINITY
        } else if r <= self.flat {
            0.0
        } else if r <= self.arc_end {
            self.on_arc(r)
        } else {
            self.on_arc(self.arc_end) + (r - self.arc_end) * self.steepness.min(f64::MAX)
        }
    }

    fn on_arc(&self, r: f64) -> f64 {
        let aside = (r - self.flat).clamp(0.0, self.arc);
        self.arc - (self.arc * self.arc - aside * aside).sqrt()
    }

    /// Rise of the underside outward at `r` ≥ 0 mm from the axis; at a corner that of its outer side.
    pub fn rise(&self, r: f64) -> f64 {
        if r < self.flat {
            0.0
        } else if r < self.arc_end {
            let aside = r - self.flat;
            aside / (self.arc * self.arc - aside * aside).max(f64::MIN_POSITIVE).sqrt()
        } else {
            self.steepness
        }
    }

    /// Distance from the axis, mm, of the point that touches a plane of the given slope: on the side to which it climbs.
    pub fn contact(&self, slope: f64) -> f64 {
        let steep = slope.abs();
        let r = if steep > self.steepness {
            self.reach
        } else if steep > 0.0 {
            (self.flat + self.arc * steep / steep.hypot(1.0)).min(self.arc_end)
        } else {
            0.0
        };
        r.copysign(slope)
    }

    /// From the axis to the point that touches a plane whose gradient is `slope`, mm.
    pub fn touch(&self, slope: DVec2) -> DVec2 {
        let steep = slope.length();
        if steep > 0.0 { slope * (self.contact(steep) / steep) } else { slope }
    }

    /// How high the tip stands over a plane of the given slope that the cutter rests on, mm, at the tip's own place.
    pub fn lift(&self, slope: f64) -> f64 {
        let r = self.contact(slope);
        slope * r - self.underside(r)
    }

    /// Least curvature of the underside, 1/mm: over a plane the tip's height falls at least so fast beside the contact.
    pub fn least_curvature(&self) -> f64 {
        let is_ball = self.flat == 0.0 && self.arc_end >= self.reach && self.arc > 0.0;
        if is_ball { self.arc.recip() } else { 0.0 }
    }

    /// Largest distance from the axis, mm, at which the underside stands no higher than `height` mm above the tip.
    pub fn radius_at(&self, height: f64) -> f64 {
        let arc_top = self.on_arc(self.arc_end);
        if height <= arc_top {
            let below = (self.arc - height.max(0.0)).max(0.0);
            (self.flat + (self.arc * self.arc - below * below).max(0.0).sqrt()).min(self.arc_end)
        } else {
            (self.arc_end + (height - arc_top) / self.steepness).min(self.reach)
        }
    }

    /// Where, `near` mm beside the axis, a straight line that rises by `rise` touches the underside, as a place along the
    /// line from its point nearest to the axis, between `low` and `high` mm.
    pub fn rest(&self, near: f64, rise: f64, [low, high]: [f64; 2]) -> f64 {
        if rise < 0.0 {
            return -self.rest(near, -rise, [-high, -low]);
        }
        if self.least_curvature() > 0.0 {
            // The underside along the line is an arc of radius √(R² - near²).
            let radius = (self.arc * self.arc - near * near).max(0.0).sqrt();
            return (radius * rise / (rise * rise + 1.0).sqrt()).clamp(low, high);
        }
        // The rise of the underside along the line grows with the distance from its nearest point.
        let steep = |t: f64| {
            let r = t.hypot(near);
            if r > 0.0 { self.rise(r) * t / r } else { 0.0 }
        };
        let (mut from, mut to) = (low.max(0.0).min(high), high);
        if to <= 0.0 || steep(from) >= rise {
            return from;
        }
        if steep(to) <= rise {
            return to;
        }
        // Halved until single precision would not tell the ends apart.
        while to - from > 1e-10 {
            let middle = 0.5 * (from + to);
            if steep(middle) < rise { from = middle } else { to = middle }
        }
        from
    }
}
