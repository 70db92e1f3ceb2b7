//! The cutter that mills a plate: its profile, from which everything else that is known of it follows.
//!
//! A cutter turns about its axis, so that its shape is one curve, the height of its underside above its tip over the
//! distance from the axis:
//!
//! ```text
//!     height │ \         /        ball of radius R:  R - √(R² - r²)  for r ≤ R
//!            │  \       /
//!            │   `-._.-'
//!            └──────┴──────► r
//! ```
//!
//! Proofs of what is milled ask for this curve alone. The design of a sheet has a model of valleys that follow a
//! paraboloid, z = r²/2R: [`suits_sheets`](Cutter::suits_sheets) refuses a cutter that has no such tip.
//!
//! A cutter is written as on the command line, `ball:0.5`. Another shape is one more variant here; sizes as they are sold,
//! with their names, stand in [`library`].

mod profile;

mod spelling;

pub mod library;

pub use profile::Profile;
pub use spelling::CutterError;

/// A cutter, by its shape.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Cutter {
    /// A ball-nosed cutter.
    Ball {
        /// Diameter of the ball, mm.
        diameter: f64,
    },
    /// A flat end with rounded corners.
    BullNose {
        /// Diameter, mm.
        diameter: f64,
        /// Radius of the corners, mm.
        corner: f64,
    },
    /// A flat end with sharp corners.
    Flat {
        /// Diameter, mm.
        diameter: f64,
    },
    /// A cone that ends in a small flat: an engraving bit.
    Cone {
        /// Angle between its sides, degrees.
        angle: f64,
        /// Diameter of the flat, mm.
        tip: f64,
        /// Largest diameter that cuts, mm.
        diameter: f64,
    },
    /// A small ball on a conical neck.
    TaperedBall {
        /// Diameter of the ball, mm.
        tip: f64,
        /// Angle between the sides of the neck, degrees.
        angle: f64,
        /// Largest diameter that cuts, mm.
        diameter: f64,
    },
}

/// Least rise of a tapered ball's neck with which a sheet's slopes, which stay below 1, are all touched by the ball.
const STEEP_ENOUGH: f64 = 1.0;

impl Cutter {
    /// A ball-nosed cutter of `diameter` mm.
    pub fn ball(diameter: f64) -> Self {
        Self::Ball { diameter }
    }

    /// Largest diameter that cuts, mm.
    pub fn diameter(self) -> f64 {
        match self {
            Self::Ball { diameter }
            | Self::BullNose { diameter, .. }
            | Self::Flat { diameter }
            | Self::Cone { diameter, .. }
            | Self::TaperedBall { diameter, .. } => diameter,
        }
    }

    /// Diameter of the end that shapes a relief, mm: of a tapered ball the ball's, else the largest.
    pub fn tip_diameter(self) -> f64 {
        match self {
            Self::TaperedBall { tip, .. } => tip,
            other => other.diameter(),
        }
    }

    /// The same cutter, larger all around by `by` mm, or smaller.
    pub fn grown(self, by: f64) -> Self {
        let wider = |diameter: f64| (diameter + 2.0 * by).max(0.0);
        match self {
            Self::Ball { diameter } => Self::Ball { diameter: wider(diameter) },
            Self::BullNose { diameter, corner } => {
                Self::BullNose { diameter: wider(diameter), corner: (corner + by).max(0.0) }
            }
            Self::Flat { diameter } => Self::Flat { diameter: wider(diameter) },
            Self::Cone { angle, tip, diameter } => Self::Cone { angle, tip: wider(tip), diameter: wider(diameter) },
            Self::TaperedBall { tip, angle, diameter } => {
                Self::TaperedBall { tip: wider(tip), angle, diameter: wider(diameter) }
            }
        }
    }

    /// Distance from the axis beyond which it touches nothing, mm.
    pub fn reach(self) -> f64 {
        0.5 * self.diameter()
    }

    /// The curve of its underside.
    pub fn profile(self) -> Profile {
        let reach = self.reach();
        let arc = |flat: f64, arc: f64| Profile { flat, arc, arc_end: reach, steepness: f64::INFINITY, reach };
        match self {
            Self::Ball { .. } => arc(0.0, reach),
            Self::BullNose { corner, .. } => arc(reach - corner, corner),
            Self::Flat { .. } => arc(reach, 0.0),
            Self::Cone { angle, tip, .. } => {
                let (flat, steepness) = (0.5 * tip, (0.5 * angle).to_radians().tan().recip());
                Profile { flat, arc: 0.0, arc_end: flat, steepness, reach }
            }
            Self::TaperedBall { tip, angle, .. } => {
                // The neck begins where the ball is as steep.
                let (radius, half) = (0.5 * tip, (0.5 * angle).to_radians());
                let (arc_end, steepness) = ((radius * half.cos()).min(reach), half.tan().recip());
                Profile { flat: 0.0, arc: radius, arc_end, steepness, reach }
            }
        }
    }

    /// Height of the underside above the tip at `r` mm from the axis, mm; infinite beyond the reach.
    pub fn underside(self, r: f64) -> f64 {
        self.profile().underside(r)
    }

    /// Distance from the axis, mm, of the point that touches a plane of the given slope: on the side to which it climbs.
    pub fn contact(self, slope: f64) -> f64 {
        self.profile().contact(slope)
    }

    /// Radius of the paraboloid that the tip follows, mm: no valley that it leaves is rounder than this. 0 of a tip that is
    /// flat or pointed.
    pub fn valley_radius(self) -> f64 {
        match self {
            Self::Ball { diameter } => 0.5 * diameter,
            Self::TaperedBall { tip, .. } => 0.5 * tip,
            Self::BullNose { .. } | Self::Flat { .. } | Self::Cone { .. } => 0.0,
        }
    }

    /// Refuses, by name, a cutter of whose valleys the design of a sheet has no model.
    pub fn suits_sheets(self) -> Result<(), UnmodelledCutter> {
        // A tip without a radius, or with one that ends before its flank begins, would be taken for a ball.
        let suits = self.valley_radius() > 0.0 && self.profile().steepness >= STEEP_ENOUGH;
        if suits { Ok(()) } else { Err(UnmodelledCutter(self)) }
    }
}

/// A cutter that sheets cannot be designed for.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("no sheet can be designed for the cutter {0} yet: name a ball, such as ball:0.5, or take facets")]
pub struct UnmodelledCutter(pub Cutter);

#[cfg(test)]
mod tests {
    use super::*;

    /// One of each shape.
    const SHAPES: [&str; 5] = ["ball:0.5", "bull:0.6,0.15", "flat:0.4", "cone:38,0.02,1", "tapered:0.3,20,1"];

    #[test]
    fn undersides_rise_from_their_tip_and_are_as_steep_as_they_say() {
        for text in SHAPES {
            let profile = text.parse::<Cutter>().unwrap().profile();
            assert_eq!(profile.underside(0.0), 0.0, "{text}");
            let d = 1e-7;
            for k in 1..50 {
                let r = profile.reach * f64::from(k) / 50.3;
                let there = (profile.underside(r + d) - profile.underside(r - d)) / (2.0 * d);
                assert!((there - profile.rise(r)).abs() < 1e-4 * there.max(1.0), "{text} at {r}: {there}");
                assert!((profile.radius_at(profile.underside(r)) - r.max(profile.flat)).abs() < 1e-9, "{text} at {r}");
            }
            assert_eq!(profile.underside(1.01 * profile.reach), f64::INFINITY);
        }
    }

    #[test]
    fn the_paper_s_bit_rises_by_the_tangent_of_its_sides() {
        // 38° between the sides: 19° from the axis, a rise of cot 19° = 2.904.
        let cone = "cone:38,0.02,1".parse::<Cutter>().unwrap().profile();
        assert!((cone.underside(0.11) - 0.1 * 2.904_210_877_675_822).abs() < 1e-12);
        // A plane less steep is touched by the rim of the flat, a steeper one by the widest rim.
        assert_eq!((cone.contact(2.9), cone.contact(-2.9), cone.contact(3.0)), (0.01, -0.01, 0.5));
    }

    #[test]
    fn a_tapered_ball_goes_over_into_its_neck_without_a_corner() {
        let tapered = "tapered:0.3,20,1".parse::<Cutter>().unwrap().profile();
        let there = tapered.arc_end;
        assert!((tapered.rise(there - 1e-9) / tapered.steepness - 1.0).abs() < 1e-4);
        assert!((tapered.underside(there + 0.01) - tapered.underside(there) - 0.01 * tapered.steepness).abs() < 1e-12);
    }

    #[test]
    fn sheets_are_designed_for_tips_that_are_round() {
        let suits = |text: &str| text.parse::<Cutter>().unwrap().suits_sheets().is_ok();
        assert_eq!(SHAPES.map(suits), [true, false, false, false, true]);
        assert!(!suits("tapered:0.3,120,1"), "a neck flatter than the relief's slopes");
    }

    #[test]
    fn a_balls_underside_is_its_sphere_and_near_the_tip_its_paraboloid() {
        let ball = Cutter::ball(0.5);
        // 0.25² = 0.15² + 0.2².
        assert!((ball.underside(0.15) - 0.05).abs() < 1e-15 && ball.underside(-0.15) == ball.underside(0.15));
        assert_eq!((ball.underside(0.0), ball.underside(ball.reach())), (0.0, 0.25));
        assert_eq!(ball.underside(0.26), f64::INFINITY);
        let paraboloid = 0.01 * 0.01 / (2.0 * ball.valley_radius());
        assert!((ball.underside(0.01) / paraboloid - 1.0).abs() < 1e-3);
    }

    #[test]
    fn a_slope_is_touched_where_the_underside_has_it() {
        let ball = Cutter::ball(0.5);
        for slope in [-1.2, -0.3, 0.0, 0.1, 0.75] {
            let (r, d) = (ball.contact(slope), 1e-6);
            let there = (ball.underside(r + d) - ball.underside(r - d)) / (2.0 * d);
            assert!((there - slope).abs() < 1e-6, "{slope}: {there}");
        }
    }
}
