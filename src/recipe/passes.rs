//! From the settings of making to passes and machine.

use glam::DVec2;

use super::settings::{SETTINGS, Section};
use super::{MachiningSettings, PassAngle, PassOrder, Recipe, RecipeError, SurfaceKind};
use crate::cutter::library::SoldCutter;
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
    /// Values out of range, settings without a machine, a machine without a cutter, or a worn one of unknown wear.
    pub fn machining(
        &self,
        cutter: Option<SoldCutter>,
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
        let SoldCutter { shape: cutter, worn_tip, .. } = cutter.ok_or(RecipeError::NoCutter)?;
        let mut machine = machine.clone();
        if self.worn {
            // One that was measured with a wider flat is worn by more than that.
            machine.tip_flat = machine.tip_flat.max(0.5 * worn_tip.ok_or(RecipeError::NoWear)?);
        }
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
        Ok(Some(Machining { machine, cutter, passes, polish, seed }))
    }
}

impl Recipe {
    /// Plates that are proved as made: as asked, or one.
    pub fn draws(&self) -> u64 {
        self.machining.draws.unwrap_or(1)
    }

    /// Its cutter, with what is known of it.
    pub fn cutter(&self) -> Option<SoldCutter> {
        let shape = self.design.sheet.cutter?;
        Some(SoldCutter { shape, flutes: self.design.flutes, neck: None, worn_tip: self.design.worn_tip })
    }

    /// Takes `cutter` in place of any before it.
    pub fn take_cutter(&mut self, cutter: &SoldCutter) {
        self.design.sheet.cutter = Some(cutter.shape);
        (self.design.flutes, self.design.worn_tip) = (cutter.deepest(), cutter.worn_tip);
    }

    /// Refuses a relief of `depth` mm about its mean plane to whose bottom its cutter does not reach.
    pub fn reaches(&self, depth: f64) -> Result<(), RecipeError> {
        match self.cutter().and_then(|cutter| cutter.deepest()).filter(|flutes| depth > *flutes) {
            Some(flutes) => Err(RecipeError::BeyondFlutes { depth, flutes }),
            None => Ok(()),
        }
    }

    /// How its plate is made, if a machine is named.
    ///
    /// # Errors
    /// It cannot be made so.
    pub fn machining(&self) -> Result<Option<Machining>, RecipeError> {
        let sheet = &self.design.sheet;
        let machining = self.machining.machining(self.cutter(), sheet.polish, self.design.seed)?;
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
    use crate::cutter::Cutter;
    use crate::cutter::library::Library;
    use crate::milling::machine::Machine;

    #[test]
    fn a_worn_cutter_is_a_machine_with_a_flat_at_its_tip() {
        let mut recipe = Recipe::default();
        recipe.machining.worn = true;
        assert_eq!(recipe.machining(), Err(RecipeError::NoMachine { setting: "worn" }));
        recipe.machining.machine = Machine::preset("vmc");
        recipe.take_cutter(&Cutter::ball(0.5).into());
        assert_eq!(recipe.machining(), Err(RecipeError::NoWear));
        recipe.take_cutter(Library::built_in().get("ball-0.5").unwrap());
        assert_eq!((recipe.design.flutes, recipe.design.worn_tip), (Some(1.0), Some(0.05)));
        let flat = |recipe: &Recipe| recipe.machining().unwrap().unwrap().machine.tip_flat;
        // The machine counts it by its radius.
        assert_eq!(flat(&recipe), 0.025);
        let text = recipe.to_toml();
        assert!(text.contains("machine = \"vmc\"") && text.contains("worn = true"), "{text}");
        assert_eq!(Recipe::from_toml(&text).as_ref(), Ok(&recipe));
        recipe.machining.machine = Machine::preset("vmc").map(|vmc| Machine { tip_flat: 0.03, ..vmc });
        assert_eq!(flat(&recipe), 0.03);
        recipe.machining.worn = false;
        recipe.machining.machine = Machine::preset("vmc");
        assert_eq!(flat(&recipe), 0.0);
    }

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
