//! Light, viewer and plate: which slope lights which point of the highlight image.
//!
//! The drawing lives in a frame whose z is the plate's normal as first thought of. A plate that is mounted tilted
//! (`level`: the mean slope turned into a mounting angle) has a frame of its own; everything the plate does (slopes,
//! footprints, traced rays) is said in the plate's frame, everything that is drawn or looked at in the drawing's.

use glam::{DMat3, DVec2, DVec3};

use crate::lamp::{DistantLamp, Extent};
use crate::projection::{Projection, View, carried_axes};
use crate::scene::Scene;
use crate::slope::{Slope, direction, flat_mirror, mirror};

/// One distant lamp and the highlight image around its mirror direction: the far scene, its viewers endlessly far away.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// In the drawing's frame.
    lamp: DistantLamp,
    view: View,
    /// Plate axes as columns, in the drawing's frame.
    mount: DMat3,
}

impl Setup {
    /// Light at polar angle `theta`, azimuth `phi`, with angular radius `light_radius` (0: ideal); all radians.
    /// The image has half field `half_field` around the mirror direction of the flat plate.
    pub fn new(theta: f64, phi: f64, light_radius: f64, projection: Projection, half_field: f64) -> Self {
        Self::under(DistantLamp::round(direction(theta, phi), light_radius), projection, half_field)
    }

    /// The image of half field `half_field` (radians) around the direction in which the flat plate mirrors the middle of
    /// `lamp`.
    pub fn under(lamp: DistantLamp, projection: Projection, half_field: f64) -> Self {
        let view = View::new(projection, half_field, flat_mirror(lamp.direction));
        Self { lamp, view, mount: DMat3::IDENTITY }
    }

    /// Light as in [`new`](Self::new), a point, watched over `view`, wherever the flat plate would mirror it.
    pub fn watched(theta: f64, phi: f64, view: View) -> Self {
        Self { lamp: DistantLamp::round(direction(theta, phi), 0.0), view, mount: DMat3::IDENTITY }
    }

    /// The far scene that `scene` is to the plate's middle: its lamp and its picture, as they are seen from there. `None`
    /// if the picture is seen from the side.
    pub fn from_middle(scene: &Scene) -> Option<Self> {
        Some(Self { lamp: scene.lamp_from_middle(), view: scene.view()?, mount: DMat3::IDENTITY })
    }

    /// The same light and image, the plate's normal turned toward `normal` (unit, in the drawing's frame)
    /// by the smallest rotation.
    pub fn mounted(&self, normal: DVec3) -> Self {
        let (e1, e2) = carried_axes(normal);
        Self { mount: DMat3::from_cols(e1, e2, normal), ..self.clone() }
    }

    /// The plate's normal in the drawing's frame: +z unless the plate is mounted tilted.
    pub fn plate_normal(&self) -> DVec3 {
        self.mount.z_axis
    }

    /// The image's projection; its directions are in the drawing's frame.
    pub const fn view(&self) -> &View {
        &self.view
    }

    /// Unit vector to the middle of the light, in the plate's frame.
    pub fn light(&self) -> DVec3 {
        self.mount.transpose() * self.lamp.direction
    }

    /// The lamp in the plate's frame. A picture stays upright along the axes carried from there to its middle.
    pub fn lamp(&self) -> DistantLamp {
        DistantLamp { direction: self.light(), extent: self.lamp.extent.clone() }
    }

    /// Right, up and toward the looked-at directions of an image whose u and v are lengths across one axis (plate's frame): z
    /// of the drawing's frame for the orthographic projection, the image's middle for the others.
    pub fn image_axes(&self) -> [DVec3; 3] {
        let axis = match self.view.projection() {
            Projection::Orthographic => DVec3::Z,
            Projection::Equidistant | Projection::Screen => self.view.centre(),
        };
        let (e1, e2) = carried_axes(axis);
        [e1, e2, axis].map(|axis| self.mount.transpose() * axis)
    }

    /// Angular radius of a round lamp, radians; 0 of a picture.
    pub const fn light_radius(&self) -> f64 {
        match self.lamp.extent {
            Extent::Disc { radius } => radius,
            Extent::Point | Extent::Picture(_) => 0.0,
        }
    }

    /// Direction (plate's frame) seen at image position `uv`, if there is one and it lies above the plate.
    pub fn viewer_at(&self, uv: DVec2) -> Option<DVec3> {
        let o = self.mount.transpose() * self.view.inverse(uv)?;
        (o.z > 0.0).then_some(o)
    }

    /// Image position of direction `o` (plate's frame), inside [-1, 1]² or not.
    pub fn image_of(&self, o: DVec3) -> Option<DVec2> {
        self.view.forward(self.mount * o)
    }

    /// The slope that lights image position `uv`.
    pub fn slope_at(&self, uv: DVec2) -> Option<Slope> {
        Slope::reflecting(self.light(), self.viewer_at(uv)?)
    }

    /// The image position that `slope` lights.
    pub fn image_of_slope(&self, slope: Slope) -> Option<DVec2> {
        self.image_of(mirror(self.light(), slope.normal()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_and_image_positions_are_inverse_in_any_mounting() {
        for projection in [Projection::Orthographic, Projection::Equidistant, Projection::Screen] {
            let flat = Setup::new(0.5, 2.0, 0.0, projection, 0.3);
            for setup in [flat.clone(), flat.mounted(direction(0.2, -1.0))] {
                for uv in [DVec2::ZERO, DVec2::new(0.7, -0.2), DVec2::new(-0.9, 0.9)] {
                    let slope = setup.slope_at(uv).unwrap();
                    assert!((setup.image_of_slope(slope).unwrap() - uv).length() < 1e-9);
                }
            }
            assert!(flat.slope_at(DVec2::ZERO).unwrap().to_vec().length() < 1e-12);
        }
    }

    #[test]
    fn a_plate_mounted_toward_the_halfway_normal_needs_no_slope() {
        let setup = Setup::new(0.0, 0.0, 0.0, Projection::Equidistant, 0.3);
        let uv = DVec2::new(0.5, 0.25);
        let normal = setup.slope_at(uv).unwrap().normal();
        assert!(setup.mounted(normal).slope_at(uv).unwrap().to_vec().length() < 1e-12);
    }
}
