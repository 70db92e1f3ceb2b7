//! A design as other renderers are told of it.

use std::f64::consts::SQRT_2;

use glam::DVec3;

use super::product::Product;
use crate::export::scene_files::{Beam, Facing, LitPlate, MirrorPlate, Shown};
use crate::lamp::Lamp;
use crate::progress::{Cancelled, Progress};
use crate::recipe::{BorderFinish, Seen};
use crate::relief::faceted::FacetedRelief;
use crate::scene::{Scene, Screen};

impl Product {
    /// Plate, lamp, and the screen on which the proof's image appears.
    pub(super) fn lit_plate(&self, progress: &Progress) -> Result<LitPlate, Cancelled> {
        let scene = self.scene();
        let setup = &self.design.distribution.setup;
        let lamp = self.lamp(scene.as_ref());
        let facing = match self.recipe.highlight.seen {
            Seen::FromAbove => Facing::FromAbove,
            Seen::OnWall => Facing::FromPlate,
        };
        let shown = match scene.as_ref().map(Scene::screen) {
            Some(Screen::Wall(wall)) => Shown::Wall(wall),
            Some(Screen::Endless(_)) | None => Shown::Far(setup, facing),
        };
        // Below what counts as smooth it is a mirror.
        let roughness = self.recipe.metal_lobe().map_or(0.0, |_| SQRT_2 * self.recipe.normal_spread());
        let plate = MirrorPlate {
            mesh: &self.design.mesh,
            area: self.design.relief.optical_area(),
            origin: middle(&self.design.relief),
            rim_shines: self.recipe.border_finish() != BorderFinish::Matt,
            roughness,
        };
        LitPlate::new(&plate, &lamp, &shown, progress)
    }

    /// Whether its lamp's light comes from a sheet, which is a file.
    pub(super) fn has_lamp_sheet(&self) -> bool {
        let (low, high) = self.design.relief.optical_area();
        Beam::is_parallel(&self.lamp(self.scene().as_ref()), (high - low).length())
    }

    fn scene(&self) -> Option<Scene> {
        self.recipe.scene().ok().flatten()
    }

    /// In the plate's frame.
    fn lamp(&self, scene: Option<&Scene>) -> Lamp {
        scene.map_or_else(|| self.design.distribution.setup.lamp().into(), |scene| scene.lamp().clone())
    }
}

/// The middle of the optical area at its mean height, mm.
fn middle(relief: &FacetedRelief) -> DVec3 {
    let (low, high) = relief.optical_area();
    let (columns, rows) = &relief.optical;
    let mut volume = 0.0;
    for j in rows.clone() {
        for i in columns.clone() {
            let area = (relief.x[i + 1] - relief.x[i]) * (relief.y[j + 1] - relief.y[j]);
            volume += area * relief.facet(i, j).height;
        }
    }
    let size = high - low;
    (0.5 * (low + high)).extend(volume / (size.x * size.y))
}
