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
            return self.rest_on_ball(near, rise).clamp(low, high);
        }
        // The rise of the underside along the line grows with the distance from its nearest point.
        let steep = |t: f64| {
            let r = t.hypot(near);
            if r > 0.0 { self.rise(r) * t / r } else { 0.0 }
        };
        let (from, to) = (low.max(0.0).min(high), high);
        if to <= 0.0 || steep(from) >= rise {
            return from;
        }
        if steep(to) <= rise {
            return to;
        }
        let touched = if self.arc == 0.0 {
            // At the rim of the flat at the least.
            self.rest_on_line(near, rise).max((self.flat * self.flat - near * near).max(0.0).sqrt())
        } else if self.flat == 0.0 {
            let on_ball = self.rest_on_ball(near, rise);
            if on_ball.hypot(near) <= self.arc_end { on_ball } else { self.rest_on_line(near, rise) }
        } else {
            self.rest_on_ring(near, rise, [from, to])
        };
        touched.clamp(from, to)
    }

    /// The same on the arc of a profile without a flat, however far it reaches: along the line it is one of radius √(R² - near²).
    fn rest_on_ball(&self, near: f64, rise: f64) -> f64 {
        let radius = (self.arc * self.arc - near * near).max(0.0).sqrt();
        radius * rise / (rise * rise + 1.0).sqrt()
    }

    /// The same on the cone of the profile's line, which is steeper: s t / √(t² + near²) = rise.
    fn rest_on_line(&self, near: f64, rise: f64) -> f64 {
        near * rise / (self.steepness * self.steepness - rise * rise).max(f64::MIN_POSITIVE).sqrt()
    }

    /// The same on the arc around a flat, where it lies between `from` and `to`. At r = √(t² + near²) from the axis the sine of
    /// the arc's angle is (r - flat) / arc, and m r / √(t² + m² r²) is the one at which the underside rises by m along the line:
    /// their difference grows with t, and its zero is found by Newton's steps, or halvings where one leads astray.
    fn rest_on_ring(&self, near: f64, rise: f64, [mut from, mut to]: [f64; 2]) -> f64 {
        let (near2, rise2) = (near * near, rise * rise);
        let beside = (self.flat * self.flat - near2).max(0.0).sqrt();
        let mut t = (beside + self.arc * rise / (1.0 + rise2).sqrt()).clamp(from, to);
        for _ in 0..MOST_STEPS {
            let r = (t * t + near2).sqrt();
            let q = (t * t + rise2 * r * r).sqrt();
            let off = (r - self.flat) / self.arc - rise * r / q;
            *(if off < 0.0 { &mut from } else { &mut to }) = t;
            let growth = t / r * (self.arc.recip() + rise * near2 / (q * q * q));
            let newton = t - off / growth;
            let next = if newton > from && newton < to { newton } else { 0.5 * (from + to) };
            if (next - t).abs() < NEAR_ENOUGH {
                return next;
            }
            t = next;
        }
        t
    }
}

/// Far below what single precision tells apart, mm.
const NEAR_ENOUGH: f64 = 1e-10;

/// Newton's steps and halvings at the most; four or five are usual.
const MOST_STEPS: usize = 60;

#[cfg(test)]
mod tests {
    use crate::cutter::Cutter;

    #[test]
    fn a_line_rests_where_the_underside_along_it_is_as_steep() {
        for text in ["ball:0.5", "bull:0.6,0.15", "bull:1,0.01", "flat:0.4", "cone:38,0.02,1", "tapered:0.3,20,1"] {
            let profile = text.parse::<Cutter>().unwrap().profile();
            for k in 0..2000 {
                let golden = |by: f64| (f64::from(k) * by).fract();
                let near = profile.reach * golden(0.618_034) * 0.999;
                let rise = 4.0 * golden(0.754_878) - 2.0;
                let most = (profile.reach * profile.reach - near * near).sqrt();
                let [low, high] = [-most * golden(0.569_84), most * golden(0.819_173)];
                let t = profile.rest(near, rise, [low, high]);
                assert!((low..=high).contains(&t), "{text}: {t} of {low} to {high}");
                // How high the line lifts the cutter where it touches: nowhere else more.
                let lift = |t: f64| rise * t - profile.underside(t.hypot(near));
                let best = lift(t);
                for step in [1e-7, 1e-4, 0.01, 0.1] {
                    for other in [t - step, t + step] {
                        let other = other.clamp(low, high);
                        assert!(lift(other) <= best + 1e-13, "{text}, {near} beside, {rise}: {other} beside {t}");
                    }
                }
            }
        }
    }
}
