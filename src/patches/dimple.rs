//! One dimple: a bowl between walls.
//!
//! The patch is a rectangle around the origin with half sides a and b. Heights are mm, slopes rises per run.
//!
//! ```text
//!     z = max(bowl, walls)                      0 ──┐\             /┌── rim
//!     walls = - S (u^-k + v^-k)^(-1/k)               │ \  bowl    / │
//!             u = a - |x|, v = b - |y|               │  `.______.'  │
//!     bowl  = t·d + ½ d·C d - lift, d = x - x0; straight on where its slope leaves the lobe
//! ```
//!
//! The gradient of the bowl is t + C d: each slope of the lobe comes once, and the area that has it is 1/det C, everywhere
//! the same. So a bowl on a share s of a patch of area A, whose slopes lie within the half widths w₁ and w₂ of t, shows to
//! a viewer in the lobe s A/(π w₁ w₂) of area per unit of slope squared: brightness goes with s, and where the viewer stands
//! within the lobe makes no difference. Walls are about the distance from the nearest rim times S; in the corners, where two
//! of them meet, they are rounded into each other. A pyramid's straight valleys
//! would not do: every square of the grid along a diagonal would have a level triangle, 5 % of the patch with 20 nodes a side,
//! as bright as a twentieth of it polished flat.
//!
//! Every part is convex and so is their maximum: valleys are as round as the bowl, the only sharp edges inward are between
//! bowl and wall, and the rims are ridges, which a cutter leaves sharp. Light for a place out of the way may be asked to go
//! one way instead of four: a third plane, of the slope that mirrors the lamp there, lies under the bowl and over what the
//! walls leave.

use std::f64::consts::PI;

use glam::{DMat2, DVec2};

use crate::slope::Slope;

/// Places along each side of a patch at which shares of its area are counted: a share is right to about 0.002, and
/// brightness is set by what is seen of the written triangles, not by this.
const PLACES: usize = 24;

/// The k of the walls: how sharply two of them meet. Of walls on 20 nodes a side the least slope of a triangle is 0.27 S
/// with 2, 0.24 S with 3 and 0.15 S with 6.
const MEETING: f64 = 2.0;

/// Rounds in which a bowl is moved over the middle of its own area; it moves by less than 0.01 of a patch after four.
const ROUNDS: usize = 6;

/// What is around the bowls, the same in all patches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Walls {
    /// Half sides of a patch, mm.
    pub half: DVec2,
    /// Slope of the walls far from corners.
    pub steep: f64,
    /// Slope to which light that is not in the lobe is sent, if it is to go one way.
    pub spare: Option<Slope>,
}

/// The slopes that a patch shall have, evenly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchLobe {
    /// Half widths along its own two axes, as slopes.
    pub widths: DVec2,
    /// Turn of the first of these from +x, radians, counter-clockwise.
    pub turn: f64,
    /// The slope in its middle.
    pub tilt: Slope,
}

/// A bowl: t·d + ½ d·C d - lift with d from its centre, straight on beyond its reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bowl {
    centre: DVec2,
    tilt: DVec2,
    curvature: DMat2,
    /// Distance from the centre at which its slopes leave the lobe, mm.
    reach: f64,
    lift: f64,
}

/// A patch's relief.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dimple {
    /// What is around the bowl.
    pub walls: Walls,
    /// The bowl, if the patch has one.
    pub bowl: Option<Bowl>,
}

impl Walls {
    /// Height of the walls at `at`, mm, 0 at the rim or below.
    #[inline]
    pub fn height(&self, at: DVec2) -> f64 {
        let from_rim = (self.half - at.abs()).max(DVec2::ZERO);
        let (less, more) = (from_rim.min_element(), from_rim.max_element());
        // (u^-k + v^-k)^(-1/k) without a division by 0.
        let wall =
            if more > 0.0 { -self.steep * less / (1.0 + (less / more).powf(MEETING)).powf(1.0 / MEETING) } else { 0.0 };
        self.spare.map_or(wall, |spare| wall.max(spare.to_vec().dot(at) - spare.to_vec().abs().dot(self.half)))
    }

    /// Area of a patch, mm².
    pub fn area(&self) -> f64 {
        4.0 * self.half.x * self.half.y
    }

    fn places(&self) -> impl Iterator<Item = DVec2> + '_ {
        let step = 2.0 / PLACES as f64;
        let along = move |k: usize| (k as f64 + 0.5) * step - 1.0;
        (0..PLACES * PLACES).map(move |k| self.half * DVec2::new(along(k % PLACES), along(k / PLACES)))
    }
}

impl PatchLobe {
    /// A round lobe of half width `width` about `tilt`.
    pub fn round(width: f64, tilt: Slope) -> Self {
        Self { widths: DVec2::splat(width), turn: 0.0, tilt }
    }

    /// Its area, slope squared.
    pub fn area(&self) -> f64 {
        PI * self.widths.x * self.widths.y
    }

    /// Whether a slope lies in it.
    pub fn holds(&self, slope: Slope) -> bool {
        let off = DMat2::from_angle(-self.turn) * (slope.to_vec() - self.tilt.to_vec());
        (off / self.widths).length_squared() <= 1.0
    }

    /// How much the gradient of a bowl turns for each mm, whose slopes leave the lobe at `reach` mm from its centre.
    fn curvature(&self, reach: f64) -> DMat2 {
        let turned = DMat2::from_angle(self.turn);
        turned * DMat2::from_diagonal(self.widths / reach) * turned.transpose()
    }
}

impl Bowl {
    /// The bowl of `lobe` that covers the share `share` of the patch, or as much of that as leaves the rim level.
    fn new(lobe: &PatchLobe, walls: &Walls, share: f64) -> Self {
        let reach = (share * walls.area() / PI).sqrt();
        let curvature = lobe.curvature(reach);
        let mut bowl = Self { centre: DVec2::ZERO, tilt: lobe.tilt.to_vec(), curvature, reach, lift: 0.0 };
        let mut above = Vec::with_capacity(PLACES * PLACES);
        for _ in 0..ROUNDS {
            bowl.lift = 0.0;
            above.clear();
            above.extend(walls.places().map(|at| bowl.height(at) - walls.height(at)));
            let lift = upper_share(&mut above.clone(), share);
            let least = [DVec2::ONE, DVec2::new(1.0, -1.0), DVec2::new(-1.0, 1.0), DVec2::NEG_ONE];
            bowl.lift = least.into_iter().fold(lift, |lift, corner| lift.max(bowl.height(corner * walls.half)));
            let (mut middle, mut count) = (DVec2::ZERO, 0.0);
            for (at, _) in walls.places().zip(&above).filter(|(_, above)| **above >= lift) {
                middle += at;
                count += 1.0;
            }
            let middle = if count > 0.0 { middle / count } else { bowl.centre };
            if (middle - bowl.centre).abs().cmple(1e-3 * walls.half).all() {
                break;
            }
            bowl.centre = middle;
        }
        bowl
    }

    /// Height at `at`, mm.
    #[inline]
    fn height(&self, at: DVec2) -> f64 {
        let d = at - self.centre;
        let bend = 0.5 * d.dot(self.curvature * d);
        let beyond = self.reach / d.length();
        // In each direction the parabola's tangent where it leaves the lobe.
        let bend = if beyond < 1.0 { bend * beyond * (2.0 - beyond) } else { bend };
        d.dot(self.tilt) + bend - self.lift
    }

    /// The most that it is curved, 1/mm.
    pub fn sharpest(&self) -> f64 {
        // Of a symmetric matrix of two rows.
        let DMat2 { x_axis, y_axis } = self.curvature;
        let (mean, apart) = (0.5 * (x_axis.x + y_axis.y), 0.5 * (x_axis.x - y_axis.y));
        mean + apart.hypot(x_axis.y)
    }
}

/// The value that the share `share` of `values` lies above, between two of them.
fn upper_share(values: &mut [f64], share: f64) -> f64 {
    let n = values.len();
    let rank = ((1.0 - share) * n as f64 - 0.5).clamp(0.0, (n - 1) as f64);
    let below = rank.floor() as usize;
    let (_, low, rest) = values.select_nth_unstable_by(below, f64::total_cmp);
    let low = *low;
    let next = rest.iter().copied().fold(f64::INFINITY, f64::min);
    if next.is_finite() { low + (rank - below as f64) * (next - low) } else { low }
}

impl Dimple {
    /// The dimple whose bowl has `lobe` on the share `share` of the patch; none with a share of 0.
    pub fn new(walls: Walls, lobe: &PatchLobe, share: f64) -> Self {
        let bowl = (share > 0.0).then(|| Bowl::new(lobe, &walls, share));
        Self { walls, bowl }
    }

    /// Height at `at` from the middle of the patch, mm; 0 at its rim.
    #[inline]
    pub fn height(&self, at: DVec2) -> f64 {
        let walls = self.walls.height(at);
        self.bowl.map_or(walls, |bowl| walls.max(bowl.height(at)))
    }

    /// The share of the patch that the bowl covers.
    pub fn share(&self) -> f64 {
        let Some(bowl) = self.bowl else { return 0.0 };
        let covered = self.walls.places().filter(|at| bowl.height(*at) >= self.walls.height(*at)).count();
        covered as f64 / (PLACES * PLACES) as f64
    }

    /// The share of the patch whose slope is the one for spare light.
    pub fn spare_share(&self) -> f64 {
        let without = Walls { spare: None, ..self.walls };
        let is_spare = |at: &DVec2| {
            let bowl = self.bowl.map_or(f64::NEG_INFINITY, |bowl| bowl.height(*at));
            self.walls.height(*at) > without.height(*at).max(bowl)
        };
        self.walls.places().filter(is_spare).count() as f64 / (PLACES * PLACES) as f64
    }

    /// The largest share that a bowl of `lobe` can take: a larger one would rise over the rim.
    pub fn most_share(walls: Walls, lobe: &PatchLobe) -> f64 {
        // Bisected to less than the error of a share.
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..10 {
            let share = 0.5 * (low + high);
            let reached = Self::new(walls, lobe, share).share();
            if reached >= share - 1.5 / (PLACES * PLACES) as f64 { low = share } else { high = share }
        }
        low
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn walls() -> Walls {
        Walls { half: DVec2::splat(0.5), steep: 0.3, spare: None }
    }

    #[test]
    fn a_dimple_is_level_at_its_rim_and_convex() {
        let spare = Walls { steep: 0.8, spare: Some(Slope::new(0.3, 0.1)), ..walls() };
        for walls in [walls(), spare] {
            for (tilt, share) in [(Slope::FLAT, 0.01), (Slope::new(0.04, -0.02), 0.3), (Slope::FLAT, 0.95)] {
                let dimple = Dimple::new(walls, &PatchLobe::round(0.05, tilt), share);
                for k in 0..=20 {
                    let along = f64::from(k) / 20.0 - 0.5;
                    for rim in [DVec2::new(0.5, along), DVec2::new(along, -0.5)] {
                        assert!(dimple.height(rim).abs() < 1e-12, "{rim} {}", dimple.height(rim));
                    }
                    let (a, b) = (DVec2::new(-0.4, along), DVec2::new(along, 0.3));
                    let chord = 0.5 * (dimple.height(a) + dimple.height(b));
                    assert!(dimple.height(0.5 * (a + b)) <= chord + 1e-12);
                }
            }
        }
    }

    #[test]
    fn a_bowl_has_its_share_and_the_slopes_of_its_lobe_evenly() {
        let lobe = PatchLobe { widths: DVec2::new(0.06, 0.03), turn: 0.5, tilt: Slope::new(0.03, 0.02) };
        let dimple = Dimple::new(walls(), &lobe, 0.4);
        assert!((dimple.share() - 0.4).abs() < 0.005, "{}", dimple.share());
        let bowl = dimple.bowl.unwrap();
        // Each slope comes once: the area per slope squared is 1/det C, which is the share over the lobe's area.
        let density = 1.0 / bowl.curvature.determinant();
        assert!((density / (0.4 / lobe.area()) - 1.0).abs() < 1e-12, "{density}");
        let (n, d) = (400, 1e-6);
        let (mut inside, mut all, mut mean) = (0, 0, DVec2::ZERO);
        for k in 0..n * n {
            let at = DVec2::new((k % n) as f64 + 0.5, (k / n) as f64 + 0.5) / n as f64 - 0.5;
            if bowl.height(at) > walls().height(at) {
                let rise = |d: DVec2| bowl.height(at + d) - bowl.height(at - d);
                let slope = DVec2::new(rise(DVec2::X * d), rise(DVec2::Y * d)) / (2.0 * d);
                inside += usize::from(lobe.holds(Slope::from_vec(slope)));
                mean += slope;
                all += 1;
            }
        }
        assert!(inside as f64 > 0.9 * all as f64, "{inside} of {all}");
        assert!((mean / all as f64 - lobe.tilt.to_vec()).length() < 0.003, "{}", mean / all as f64);
    }

    #[test]
    fn the_largest_bowl_ends_at_the_rim() {
        let lobe = PatchLobe::round(0.05, Slope::FLAT);
        let most = Dimple::most_share(walls(), &lobe);
        assert!((0.75..0.95).contains(&most), "{most}");
        assert!((Dimple::new(walls(), &lobe, most).share() - most).abs() < 0.01);
        let tilted = Dimple::most_share(walls(), &PatchLobe::round(0.05, Slope::new(0.1, 0.0)));
        assert!(tilted < 0.9 * most, "{tilted}");
        let bowl = Dimple::new(walls(), &lobe, 0.5).bowl.unwrap();
        assert!((bowl.sharpest() - 0.05 * (PI / 0.5).sqrt()).abs() < 1e-12);
    }
}
