//! One path of light over a surface of some material, from its first hit to its end.

use glam::{DMat3, DVec3};
use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;

use super::{Hit, PieceKind, Surface};
use crate::brdf::material::Material;
use crate::projection::carried_axes;
use crate::slope::mirror;

/// How a path ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// It left upward.
    Up,
    /// It left downward past the plate's edge.
    Down,
    /// The material took what was left.
    Taken,
    /// It met the plate's outer sides.
    Outer,
    /// It wanted more bounces than were to be followed.
    Trapped,
    /// It met a face from behind: the mesh leaks or is turned inside out.
    Backface,
}

/// The end of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct End {
    /// How it ended.
    pub fate: Fate,
    /// What is left of its light: 1 less what the material took on the way.
    pub weight: f64,
    /// Reflections on the way.
    pub bounces: u32,
    /// The last point on the surface, mm.
    pub point: DVec3,
    /// The unit direction from there.
    pub direction: DVec3,
}

/// Follows paths over one surface.
///
/// Neighbouring paths often meet the same piece from the same side: what a smooth material makes of it is remembered.
pub struct PathFollower<'a, S: Surface> {
    surface: &'a S,
    material: &'a Material,
    max_bounces: u32,
    last: Option<Reflection<S::Place>>,
}

/// What a piece does to light from one direction.
struct Reflection<Place> {
    place: Place,
    along: DVec3,
    /// The end of the path, if the light goes no further than this.
    end: Option<Fate>,
    normal: DVec3,
    out: DVec3,
    share: f64,
}

impl<'a, S: Surface> PathFollower<'a, S> {
    /// At most `max_bounces` reflections a path.
    pub fn new(surface: &'a S, material: &'a Material, max_bounces: u32) -> Self {
        Self { surface, material, max_bounces, last: None }
    }

    /// Follows light that has met the surface at `hit`, coming along `direction`.
    #[inline]
    pub fn follow(&mut self, mut hit: Hit<S::Place>, mut direction: DVec3, random: &mut Xoshiro256PlusPlus) -> End {
        let (material, most) = (self.material, self.max_bounces);
        let smooth = material.is_smooth();
        let mut weight = 1.0;
        let mut bounces = 0;
        let fate = loop {
            let reflection = self.reflection(hit.place, direction);
            if let Some(end) = reflection.end {
                break end;
            }
            if bounces == most {
                break Fate::Trapped;
            }
            let (out, share) = if smooth {
                (reflection.out, reflection.share)
            } else {
                scatter(material, reflection.normal, direction, random)
            };
            weight *= share;
            if weight <= 0.0 {
                break Fate::Taken;
            }
            bounces += 1;
            direction = out;
            match self.surface.next(&hit, direction) {
                Some(next) => hit = next,
                None if direction.z > 0.0 => break Fate::Up,
                None => break Fate::Down,
            }
        };
        End { fate, weight, bounces, point: hit.point, direction }
    }

    #[inline]
    fn reflection(&mut self, place: S::Place, along: DVec3) -> &Reflection<S::Place> {
        if !self.last.as_ref().is_some_and(|last| last.place == place && last.along == along) {
            self.last = None;
        }
        let (surface, material) = (self.surface, self.material);
        self.last.get_or_insert_with(|| {
            let normal = surface.normal(place);
            let cosine = -along.dot(normal);
            let end = if cosine > 0.0 {
                (surface.kind(place) == PieceKind::Outer).then_some(Fate::Outer)
            } else {
                Some(Fate::Backface)
            };
            let share = material.smooth_share(DVec3::new(0.0, 0.0, cosine));
            Reflection { place, along, end, normal, out: mirror(-along, normal), share }
        })
    }
}

/// Axes in which a material scatters light at a piece with this unit normal, as columns: the lobe's x axis is the
/// plate's, carried along by the smallest rotation that takes +z to the normal.
pub(crate) fn frame(normal: DVec3) -> DMat3 {
    let (e1, e2) = carried_axes(normal);
    DMat3::from_cols(e1, e2, normal)
}

/// Direction and weight of light that comes along `direction` onto a rough piece; weight 0 if none is left.
fn scatter(material: &Material, normal: DVec3, direction: DVec3, random: &mut Xoshiro256PlusPlus) -> (DVec3, f64) {
    let frame = frame(normal);
    let u = [random.random(), random.random(), random.random()];
    match material.scatter(frame.transpose() * -direction, u) {
        Some((out, share)) => ((frame * out).normalize(), share),
        None => (direction, 0.0),
    }
}
