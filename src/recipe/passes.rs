//! From the settings of making to passes and machine.

use glam::DVec2;

use super::settings::{SETTINGS, Section};
use super::{MachiningSettings, PassAngle, PassOrder, Recipe, RecipeError, SurfaceKind};
use crate::cutter::Cutter;
use crate::milling::made::Machining;
use crate::milling::passes::Passes;

/// Passes so many standard deviations of the polish apart leave nothing of their cusps.
const CUSPS_GONE: f64 = 2.0;

/// Of a cutter that is not polished after, the passes for each diameter: cusps then cost about as much as a good machine.
const PASSES_A_DIAMETER: f64 = 50.0;

impl MachiningSettings {
    /// How a plate is made with `cutter`, polished by `polish` mm, the machine's errors drawn from `seed`; `None` without a
    /// machine.
    ///
    /// # Errors
    /// Values out of range, settings without a machine, or a machine without a cutter.
    pub fn machining(
        &self,
        cutter: Option<Cutter>,
        polish: Option<f64>,
        seed: u64,
    ) -> Result<Option<Machining>, RecipeError> {
        let mut alone = Recipe { machining: self.clone(), ..Recipe::default() };
        let own = || SETTINGS.iter().filter(|setting| setting.section == Section::Machining);
        own().try_for_each(|setting| setting.check(&mut alone))?;
        let Some(machine) = &self.machine else {
            let given = own().find(|setting| setting.is_given(&alone));
            return given.map_or(Ok(None), |setting| Err(RecipeError::NoMachine { setting: setting.name }));
        };
        machine.check().map_err(|error| RecipeError::Machine(error.to_string()))?;
        let cutter = cutter.ok_or(RecipeError::NoCutter)?;
        let polish = polish.filter(|polish| *polish != 0.0);
        let usual = match polish {
            Some(sigma) => (CUSPS_GONE * sigma).min(0.5 * cutter.reach()),
            None => cutter.tip_diameter() / PASSES_A_DIAMETER,
        };
        let passes = Passes {
            angle: self.pass_angle.map_or(0.0, PassAngle::degrees).to_radians(),
            stepover: self.stepover.unwrap_or(usual),
            zigzag: self.pass_order == Some(PassOrder::Zigzag),
        };
        Ok(Some(Machining { machine: machine.clone(), cutter, passes, polish, seed }))
    }
}

impl Recipe {
    /// Plates that are proved as made: as asked, or one.
    pub fn draws(&self) -> u64 {
        self.machining.draws.unwrap_or(1)
    }

    /// How its plate is made, if a machine is named.
    ///
    /// # Errors
    /// It cannot be made so.
    pub fn machining(&self) -> Result<Option<Machining>, RecipeError> {
        let sheet = &self.design.sheet;
        let machining = self.machining.machining(sheet.cutter, sheet.polish, self.design.seed)?;
        if let Some(machining) = &machining {
            if self.machining.as_made_stl && machining.polish.is_none() && self.surface() == SurfaceKind::Sheet {
                return Err(RecipeError::NoPolish);
            }
            if self.is_near() && machining.polish.is_none() {
                return Err(RecipeError::BareNearby);
            }
            machining.check(DVec2::from(self.plate.size))?;
        }
        Ok(machining)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::milling::machine::Machine;

    #[test]
    fn what_is_not_said_of_passes_follows_from_cutter_and_polish() {
        let mut recipe = Recipe::default();
        assert_eq!(recipe.machining(), Ok(None));
        recipe.machining.stepover = Some(0.02);
        assert_eq!(recipe.machining(), Err(RecipeError::NoMachine { setting: "stepover" }));
        recipe.machining.machine = Machine::preset("vmc");
        assert_eq!(recipe.check(), Err(RecipeError::NoCutter));
        recipe.design.sheet.cutter = Some(Cutter::ball(0.5));
        let stepover = |recipe: &Recipe| recipe.machining().unwrap().unwrap().passes.stepover;
        assert_eq!(stepover(&recipe), 0.02);
        recipe.machining.stepover = None;
        assert_eq!(stepover(&recipe), 0.01);
        recipe.design.sheet.polish = Some(0.04);
        assert_eq!(stepover(&recipe), 0.08);
        (recipe.design.sheet.polish, recipe.machining.as_made_stl) = (None, true);
        assert_eq!(recipe.machining(), Err(RecipeError::NoPolish));
        (recipe.machining.as_made_stl, recipe.machining.stepover) = (false, Some(0.3));
        let wide = recipe.check().unwrap_err();
        assert!(wide.is_impossible() && wide.to_string().contains("0.25"), "{wide}");
        (recipe.machining.stepover, recipe.scene.wall) = (None, Some(500.0));
        assert_eq!(recipe.machining(), Err(RecipeError::BareNearby));
        recipe.design.sheet.polish = Some(0.04);
        assert!(recipe.machining().is_ok());
    }
}
