//! How low a cutter can stand over triangles: its tip's height at a place when it rests on them.
//!
//! Over one triangle the height of its plane less the underside of a (convex) cutter is a concave function of the place. So
//! a cutter that rests on the triangle touches it either where its underside is as steep as the plane, if that place lies
//! in the triangle, or on an edge beyond which it lies. Heights are not rounded to a grid: the answer is that of the
//! triangles as they stand in the file.

mod blocks;

pub(super) mod tree;

use glam::{DVec2, DVec3};

use crate::cutter::Profile;
use crate::relief::mesh::Mesh;
use blocks::Plane;
use tree::{Piece, Tree, Underside};

/// Triangles that face up, sorted for the question how low a cutter can stand at a place.
pub struct TipHeights(Tree<Face>);

/// A triangle that faces up.
struct Face {
    corners: [[f32; 3]; 3],
    /// Where the tip stands that touches its plane.
    tips: Plane,
    /// Where the tip stands, in the plane of the plate, that touches the triangle's middle, mm.
    middle: DVec2,
    /// From its middle to its farthest corner, mm.
    radius: f64,
    /// From the tip to where it touches the plane, mm.
    touch: DVec2,
}

impl Face {
    /// A wall has none: its edges belong to the triangles beside it as well.
    fn new(corners: [[f32; 3]; 3], profile: &Profile) -> Option<Self> {
        let [a, b, c] = corners.map(wide);
        let normal = (b - a).cross(c - a);
        (normal.z > 1e-9 * normal.length()).then(|| {
            let slope = -normal.truncate() / normal.z;
            let touch = profile.touch(slope);
            let tips = Plane::through(a, slope).raised(profile.lift(slope.length()));
            let middle = (a + b + c).truncate() / 3.0;
            let radius = [a, b, c].iter().map(|v| v.truncate().distance(middle)).fold(0.0, f64::max);
            Self { corners, tips, middle: middle - touch, radius, touch }
        })
    }

    /// Its corners, seen from `at`, and beyond which of its edges the place lies where its plane is touched.
    fn seen_from(&self, at: DVec2) -> ([DVec3; 3], [bool; 3]) {
        let corners = self.corners.map(wide);
        let [a, b, c] = corners.map(|c| c.truncate() - at);
        let outside = |a: DVec2, b: DVec2| (b - a).perp_dot(self.touch - a) < 0.0;
        (corners, [outside(a, b), outside(b, c), outside(c, a)])
    }

    /// The tip's height on it, at the place `at`, and from there to where it touches, if it does.
    fn touched(&self, cutter: &Underside, at: DVec2) -> (f64, DVec2) {
        let (corners, outside) = self.seen_from(at);
        if outside == [false; 3] {
            return (self.tips.at(at), self.touch);
        }
        let edges = outside.into_iter().enumerate().filter(|(_, outside)| *outside);
        let on = edges.map(|(from, _)| cutter.on_edge(corners[from], corners[(from + 1) % 3], at));
        on.fold((f64::NEG_INFINITY, DVec2::ZERO), |best, on| if on.0 > best.0 { on } else { best })
    }
}

impl Piece for Face {
    fn centre(&self) -> DVec2 {
        self.middle + self.touch
    }

    fn points(&self) -> impl Iterator<Item = DVec3> + Clone {
        self.corners.map(wide).into_iter()
    }

    fn slope_of(pieces: &[Self]) -> DVec2 {
        pieces.iter().map(|face| face.tips.slope).sum::<DVec2>() / pieces.len().max(1) as f64
    }

    fn carries(&self, cutter: &Underside, at: DVec2, best: f64) -> f64 {
        let over = self.tips.at(at) - best;
        if over <= 0.0 {
            return best;
        }
        // Beside the place that touches its plane the tip stands lower, by the underside's bend at the least.
        let beside = (at.distance(self.middle) - self.radius).max(0.0);
        if beside * beside * cutter.bend >= over {
            return best;
        }
        let (corners, outside) = self.seen_from(at);
        if outside == [false; 3] {
            return self.tips.at(at);
        }
        let [a, b, c] = corners.map(|c| c.truncate() - at);
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let d = low.max(-high).max(DVec2::ZERO).length_squared();
        let top = corners[0].z.max(corners[1].z).max(corners[2].z);
        if d > cutter.reach2 || top - cutter.profile.underside(d.sqrt()) <= best {
            return best;
        }
        let edges = outside.into_iter().enumerate().filter(|(_, outside)| *outside);
        edges.map(|(from, _)| cutter.on_edge(corners[from], corners[(from + 1) % 3], at).0).fold(best, f64::max)
    }
}

fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

impl TipHeights {
    /// The triangles of `mesh` that face up, for a cutter of `profile`.
    pub fn new(mesh: &Mesh, profile: Profile) -> Self {
        let corners = |t: &[u32; 3]| t.map(|v| mesh.vertices[v as usize]);
        Self(Tree::new(mesh.triangles.iter().filter_map(|t| Face::new(corners(t), &profile)).collect(), profile))
    }

    /// The curve of the cutter's underside.
    pub fn profile(&self) -> &Profile {
        &self.0.cutter.profile
    }

    /// Height of the tip at `at` (mm, in the mesh's frame) when the cutter rests on the triangles, mm; -∞ where it meets
    /// none.
    pub fn at(&self, at: DVec2) -> f64 {
        self.0.rest(at).map_or(f64::NEG_INFINITY, |rest| rest.height)
    }

    /// The point of the triangles on which a cutter at `at` rests, mm, if it rests on any.
    pub fn contact(&self, at: DVec2) -> Option<DVec3> {
        let rest = self.0.rest(at)?;
        let (_, touch) = self.0.pieces[rest.piece as usize].touched(&self.0.cutter, at);
        Some((at + touch).extend(rest.height + self.profile().underside(touch.length().min(self.profile().reach))))
    }
}

#[cfg(test)]
mod tests;
