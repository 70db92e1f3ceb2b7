//! Lamp and wall at distances in millimetres: the settings of a scene, what they imply, and the scene that they make.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::{Recipe, Seen};
use crate::highlight::Quantity;
use crate::lamp::{DistantLamp, Lamp};
use crate::near::NearField;
use crate::picture::PictureFit;
use crate::projection::Projection;
use crate::scene::room::{Room, RoomFault};
use crate::scene::{Scene, SceneError};
use crate::setup::Setup;
use crate::slope::{Slope, direction};

/// Lamp and wall near the plate; nothing of it is given for a far scene. Lengths mm, from the middle of the optical area at
/// its mean height, in the plate's axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct SceneSettings {
    /// To the lamp, whose direction the light has.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lamp_distance: Option<f64>,
    /// The lamp.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lamp_at: Option<[f64; 3]>,
    /// The lamp's radius.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lamp_radius: Option<f64>,
    /// To the wall along the mirror direction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wall: Option<f64>,
    /// Turn of the wall about its horizontal axis, its upper edge away from the plate, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wall_tilt: Option<f64>,
    /// Width of the drawing on the wall.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub picture_width: Option<f64>,
    /// Focal length of a bowl under a far design.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub focus: Option<f64>,
    /// How the design follows lamp and wall; without it, as far as is needed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub near: Option<NearMethod>,
    /// Columns and rows of the drawing, noted when it was read: they say how wide its padded square is on the wall.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drawing: Option<[usize; 2]>,
    /// Everything in the room's own coordinates, from a scene file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub room: Option<Room>,
}

/// How a design follows lamp and wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum NearMethod {
    /// A far design on a bowl.
    Base,
    /// A far design, warped, on a bowl.
    Warp,
    /// A descent over the whole plate, each triangle's light counted where it lands.
    Exact,
}

impl SceneSettings {
    /// Whether lamp or wall is near.
    pub fn is_near(&self) -> bool {
        self.room.is_some() || self.lamp().is_some() || self.wall.or(self.focus).is_some()
    }

    /// The setting that puts a lamp near the plate, if one does.
    fn lamp(&self) -> Option<&'static str> {
        self.lamp_at.map(|_| "lamp-at").or(self.lamp_distance.map(|_| "lamp-distance"))
    }
}

impl Recipe {
    /// Whether lamp or wall is near the plate.
    pub fn is_near(&self) -> bool {
        self.scene.is_near()
    }

    /// The same recipe with what a scene implies: the picture is on a screen, its pixels are light, and it is drawn as it
    /// shall appear on the wall.
    pub fn with_implied(mut self) -> Self {
        if self.is_near() {
            let highlight = &mut self.highlight;
            (highlight.projection, highlight.quantity, highlight.seen) =
                (Projection::Screen, Quantity::Flux, Seen::OnWall);
        }
        self
    }

    /// Notes the columns and rows of the drawing, which a scene needs to know how wide its square is on the wall.
    pub fn note_drawing(&mut self, (width, height): (usize, usize)) {
        if self.is_near() {
            self.scene.drawing = Some([width, height]);
        }
    }

    /// Lamp, plate and wall, if one of them is near.
    ///
    /// # Errors
    /// Settings that contradict each other, or numbers of a room that make none.
    pub fn scene(&self) -> Result<Option<Scene>, SceneFault> {
        if !self.is_near() {
            return Ok(None);
        }
        self.contradiction().map_or(Ok(()), Err)?;
        let scene = match self.scene.room {
            Some(room) => room.scene(self.square())?,
            None => self.scene_of_flags(),
        };
        Ok(Some(scene))
    }

    fn scene_of_flags(&self) -> Scene {
        let SceneSettings { lamp_distance, lamp_at, lamp_radius, wall, wall_tilt, picture_width, focus, .. } =
            self.scene;
        let toward = direction(self.light.theta.to_radians(), self.light.phi.to_radians());
        let radius = lamp_radius.unwrap_or_default();
        let lamp = match lamp_at.map(DVec3::from).or(lamp_distance.map(|distance| distance * toward)) {
            Some(middle) => Lamp::Ball { middle, radius },
            None => DistantLamp::round(toward, self.light.radius.to_radians()).into(),
        };
        let half_field = self.highlight.half_field.reach().to_radians();
        let Some(distance) = wall.or(focus) else { return Scene::endless(lamp, half_field) };
        let half = picture_width.map_or(distance * half_field.tan(), |width| 0.5 * self.square() * width);
        Scene::across_mirror(lamp, distance, wall_tilt.unwrap_or_default().to_radians(), half)
    }

    /// How many times as wide as the drawing its square is.
    fn square(&self) -> f64 {
        let [width, height] = self.scene.drawing.unwrap_or([1, 1]).map(|n| n.max(1) as f64);
        // The field's height over its width, and its width over the drawing's.
        let aspect = self.highlight.half_field.aspect(Projection::Screen).unwrap_or(1.0);
        let field = match self.highlight.fit {
            PictureFit::Pad => width.max(height / aspect) / width,
            PictureFit::Crop => width.min(height / aspect) / width,
            PictureFit::Stretch => 1.0,
        };
        field * aspect.max(1.0)
    }

    /// The first pair of settings that cannot stand together in a scene.
    fn contradiction(&self) -> Option<SceneFault> {
        let scene = &self.scene;
        let both = |a: &'static str, b: &'static str| Some(SceneFault::Both(a, b));
        let given = [
            ("lamp-distance", scene.lamp_distance.is_some()),
            ("lamp-at", scene.lamp_at.is_some()),
            ("lamp-radius", scene.lamp_radius.is_some()),
            ("wall", scene.wall.is_some()),
            ("wall-tilt", scene.wall_tilt.is_some()),
            ("picture-width", scene.picture_width.is_some()),
            ("focus", scene.focus.is_some()),
        ];
        let has = |names: &[&str]| given.iter().find(|(name, given)| *given && names.contains(name)).map(|g| g.0);
        if self.design.distribution.level {
            return both("level", "scene");
        }
        if scene.room.is_some() {
            return has(&given.map(|g| g.0)).and_then(|name| both(name, "scene"));
        }
        if scene.focus.is_some() {
            return has(&["wall", "wall-tilt", "lamp-distance", "lamp-at", "lamp-radius"])
                .and_then(|name| both(name, "focus"))
                .or(scene.near.filter(|near| *near != NearMethod::Base).and_then(|_| both("near", "focus")));
        }
        if scene.lamp_at.is_some() && scene.lamp_distance.is_some() {
            return both("lamp-at", "lamp-distance");
        }
        if let Some(lamp) = scene.lamp().filter(|_| self.light.radius > 0.0) {
            return both("light-radius", lamp);
        }
        let needs = |what, without| Some(SceneFault::Without { what, without });
        match () {
            () if scene.lamp_radius.is_some() && scene.lamp().is_none() => needs("lamp-radius", "lamp-distance"),
            () if scene.wall_tilt.is_some() && scene.wall.is_none() => needs("wall-tilt", "wall"),
            () if scene.picture_width.is_some() && scene.wall.is_none() => needs("picture-width", "wall"),
            () => None,
        }
    }

    /// What is refused of a recipe's scene: contradictions, and lamps and walls where they cannot be.
    pub(super) fn check_scene(&self) -> Result<(), SceneFault> {
        let lone = ["near", "picture-width", "wall-tilt", "lamp-radius"];
        let SceneSettings { near, picture_width, wall_tilt, lamp_radius, .. } = self.scene;
        let given = [near.is_some(), picture_width.is_some(), wall_tilt.is_some(), lamp_radius.is_some()];
        let Some(scene) = self.scene()? else {
            let lone = lone.into_iter().zip(given).find(|(_, given)| *given);
            return lone.map_or(Ok(()), |(what, _)| Err(SceneFault::Without { what, without: "wall" }));
        };
        let highlight = &self.highlight;
        let implied = [
            ("projection", highlight.projection != Projection::default() && highlight.projection != Projection::Screen),
            ("quantity", highlight.quantity != Quantity::default() && highlight.quantity != Quantity::Flux),
        ];
        if let Some((name, _)) = implied.into_iter().find(|(_, contradicts)| *contradicts) {
            return Err(SceneFault::Implied(name));
        }
        scene.check(self.plate.size.into(), 0.0)?;
        let shortest = self.plate.size[0].max(self.plate.size[1]);
        if scene.focal_length() < shortest {
            return Err(SceneFault::ShortFocus { focal_length: scene.focal_length(), side: shortest });
        }
        let field = NearField::new(&scene, self.plate.size.into(), Slope::FLAT);
        let corners = [0, 1, 2, 3].map(|k| {
            let sign = DVec2::new([-0.5, 0.5][k & 1], [-0.5, 0.5][k >> 1]);
            field.as_ref().and_then(|field| field.base_slope(sign * DVec2::from(self.plate.size)))
        });
        let steepest = corners.iter().map(|s| s.map_or(90.0, |s| s.tilt().to_degrees())).fold(0.0, f64::max);
        let cap = self.design.distribution.slope_cap;
        if steepest > cap {
            return Err(SceneFault::SteepBase { steepest, cap });
        }
        Setup::from_middle(&scene).map_or(Err(SceneError::EdgeOn { angle: 0.0 }.into()), |_| Ok(()))
    }
}

/// Why a recipe has no scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneFault {
    /// Two settings that say the same thing in two ways.
    #[error("{0} has no meaning beside --{1}: leave out one of the two")]
    Both(&'static str, &'static str),
    /// A setting that needs another one.
    #[error("{what} has no meaning without --{without}: give both, or a --scene")]
    Without {
        /// What was given.
        what: &'static str,
        /// What is missing.
        without: &'static str,
    },
    /// A setting whose value the scene implies.
    #[error(
        "--{0} contradicts the scene: with a lamp or a wall nearby the picture is light on a screen, so leave it out"
    )]
    Implied(&'static str),
    /// A bowl deeper than it is wide.
    #[error(
        "lamp and wall ask for a focal length of {focal_length:.0} mm, shorter than the plate's side of {side} mm: move \
         lamp or wall away, or take a smaller --size"
    )]
    ShortFocus {
        /// mm.
        focal_length: f64,
        /// mm.
        side: f64,
    },
    /// A bowl steeper than allowed.
    #[error(
        "the bowl that lamp and wall ask for is {steepest:.1}° steep at the plate's rim, beyond the slope cap of {cap}°:          move lamp or wall away, or raise --slope-cap"
    )]
    SteepBase {
        /// Degrees.
        steepest: f64,
        /// Degrees.
        cap: f64,
    },
    /// Numbers of the room.
    #[error(transparent)]
    Room(#[from] RoomFault),
    /// Lamp or wall where they cannot be.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

impl SceneFault {
    /// Whether the settings are sound one by one but no plate can have them together.
    pub fn is_impossible(&self) -> bool {
        matches!(self, Self::ShortFocus { .. } | Self::SteepBase { .. } | Self::Scene(_))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recipe(text: &str) -> Recipe {
        Recipe::from_toml(text).unwrap()
    }

    fn fault(text: &str) -> SceneFault {
        recipe(text).check_scene().unwrap_err()
    }

    #[test]
    fn flags_make_a_scene_and_imply_a_picture_on_a_wall() {
        assert_eq!(Recipe::default().scene(), Ok(None));
        let near = recipe("[light]\ntheta = 45\nphi = 90\n[scene]\nlamp-distance = 500\nwall = 1000\n").with_implied();
        assert_eq!((near.highlight.projection, near.highlight.quantity), (Projection::Screen, Quantity::Flux));
        assert_eq!(near.highlight.seen, Seen::OnWall);
        let scene = near.scene().unwrap().unwrap();
        assert!((scene.lamp_distance() - 500.0).abs() < 1e-9 && (scene.wall_distance() - 1000.0).abs() < 1e-9);
        assert!((scene.wall().unwrap().half / (1000.0 * f64::to_radians(20.0).tan()) - 1.0).abs() < 1e-12);
        assert_eq!(Recipe::from_toml(&near.to_toml()), Ok(near.clone()));
        assert!(!Recipe::default().to_toml().contains("scene"));
        // A drawing twice as high as wide fills half of its square.
        let wide = recipe("[scene]\nwall = 1000\npicture-width = 300\ndrawing = [100, 200]\n");
        assert_eq!(wide.scene().unwrap().unwrap().wall().unwrap().half, 300.0);
        let bowl = recipe("[scene]\nfocus = 500\n").scene().unwrap().unwrap();
        assert!((bowl.focal_length() - 500.0).abs() < 1e-9 && bowl.lamp_distance().is_infinite());
    }

    #[test]
    fn contradictions_are_named() {
        for (text, expected) in [
            ("[scene]\nwall-tilt = 3\n", SceneFault::Without { what: "wall-tilt", without: "wall" }),
            ("[scene]\nnear = 'exact'\n", SceneFault::Without { what: "near", without: "wall" }),
            (
                "[scene]\nwall = 500\nlamp-radius = 3\n",
                SceneFault::Without { what: "lamp-radius", without: "lamp-distance" },
            ),
            ("[scene]\nwall = 500\nfocus = 500\n", SceneFault::Both("wall", "focus")),
            ("[scene]\nfocus = 500\nnear = 'exact'\n", SceneFault::Both("near", "focus")),
            ("[light]\nradius = 1\n[scene]\nlamp-distance = 500\n", SceneFault::Both("light-radius", "lamp-distance")),
            ("[highlight]\nquantity = 'intensity'\n[scene]\nwall = 500\n", SceneFault::Implied("quantity")),
        ] {
            assert_eq!(fault(text), expected, "{text}");
            assert!(!fault(text).is_impossible());
        }
        assert!(fault("[scene]\nwall = 20\n").is_impossible());
        assert!(matches!(fault("[scene]\nlamp-at = [100, 0, 1]\n"), SceneFault::Scene(SceneError::LampBehind { .. })));
    }
}
