//! The flags of `facetmill design`, and how they become a recipe.

use std::path::PathBuf;

use clap::Args;
use facetmill::goal::spec::GoalSpec;
use facetmill::recipe::{Recipe, SurfaceKind};

use super::settings::{ByDesign, SettingFlags};
use super::{MachineArgs, RunningArgs};
use crate::values::{GoalPartArg, MethodArg, goal};

#[derive(Debug, Args)]
pub struct DesignArgs {
    /// The highlight, bright where light shall be: PNG, JPEG, TIFF, WebP, SVG, GIF, BMP, PGM, HDR, EXR; - for a pipe
    #[arg(required_unless_present_any = ["recipe", "goal", "portrait", "gloss", "normal", "anisotropy", "albedo"])]
    pub picture: Option<PathBuf>,
    /// Reflectance in place of a picture: ward:0.1,0.3, ggx:0.2,0.05,30, merl:FILE, csv:FILE, ndf:PICTURE
    ///
    /// The plate's slice at --light becomes that of a model of reflectance or of a measured material. Models are NAME:NUMBERS,
    /// sums of them joined by +: lambert, oren-nayar, phong, blinn-phong, gaussian, beckmann, cook-torrance, ggx,
    /// shifted-gamma, ward, ward-bounded, ashikhmin-shirley, lafortune. Files: merl:gold.binary (MERL), bsdf:gold.bsdf (RGL), csv:brdf.csv (of
    /// `measure --brdf`), lafortune:lobes.toml, ndf:star.png,30 (a painted density of half vectors, its rim 30° from the
    /// normal). Without --half-field the field holds 99 % of the light. docs/goals.md has formulas, numbers and figures.
    #[arg(long, value_name = "SPEC", help_heading = "Highlight and light", value_parser = goal, conflicts_with_all = ["picture", "scene"])]
    pub goal: Option<GoalSpec>,
    /// Which part of a --goal is wanted  [default: specular]
    ///
    /// No plate of mirrors scatters evenly, as pigment does: `specular` leaves that part of a goal out and the report says how
    /// much it is; `all` keeps it as a highlight all over the field.
    #[arg(long, value_enum, value_name = "PART", help_heading = "Highlight and light")]
    pub goal_part: Option<GoalPartArg>,
    /// A picture that a viewer shall see on the plate itself, in place of PICTURE
    ///
    /// The plate is divided into --patches; each is a dimple whose bowl sends as much light to --viewer as the picture is
    /// bright there, under the lamp that --light says. docs/portraits.md has how, and figures.
    #[arg(long, value_name = "PICTURE", help_heading = "A picture on the plate", conflicts_with_all = ["picture", "goal", "gloss", "normal", "anisotropy", "albedo"])]
    pub portrait: Option<PathBuf>,
    /// Map of how glossy each patch is: white --patch-lobe, black --widest-lobe
    #[arg(long, value_name = "MAP", help_heading = "A picture on the plate", conflicts_with_all = ["picture", "goal"])]
    pub gloss: Option<PathBuf>,
    /// Map of the normals of patches: red to the right, green up, as in glTF
    #[arg(long, value_name = "MAP", help_heading = "A picture on the plate", conflicts_with_all = ["picture", "goal"])]
    pub normal: Option<PathBuf>,
    /// Map of long lobes: red and green in which direction, blue how long, as in glTF
    #[arg(long, value_name = "MAP", help_heading = "A picture on the plate", conflicts_with_all = ["picture", "goal"])]
    pub anisotropy: Option<PathBuf>,
    /// Map of the share of light that patches keep in their lobes
    #[arg(long, value_name = "MAP", help_heading = "A picture on the plate", conflicts_with_all = ["picture", "goal"])]
    pub albedo: Option<PathBuf>,
    /// Folder for the results; made if it does not exist
    #[arg(short = 'o', long = "output", value_name = "DIR", required_unless_present = "dry_run")]
    pub output: Option<PathBuf>,

    #[command(flatten)]
    pub settings: SettingFlags<ByDesign>,

    /// Set every choice to a published method's; flags beside it override it
    #[arg(long, value_enum, value_name = "NAME", help_heading = "Design", conflicts_with = "recipe")]
    pub method: Option<MethodArg>,
    /// Start from the settings of a recipe.toml; flags beside it override it
    ///
    /// A picture that the recipe names is looked for beside the recipe, then in the folder you are in.
    #[arg(long, value_name = "FILE", help_heading = "Design")]
    pub recipe: Option<PathBuf>,

    /// Plate, lamp or sun, wall and picture in the room's own coordinates, mm, from this TOML file
    ///
    /// Axes are right-handed, z up. [plate] at, facing, top; [lamp] at and radius in mm, or sun = [degrees from z, from
    /// x] and radius in degrees; [wall] through, facing; [picture] centre, width, up. Without a centre the picture is
    /// where a flat plate would throw the lamp's light. The drawing is upright and right way round on the wall.
    #[arg(long, value_name = "FILE", help_heading = "Lamp and wall nearby", conflicts_with_all = ["light", "light-radius", "half-field"])]
    pub scene: Option<PathBuf>,

    #[command(flatten)]
    pub machine: MachineArgs,
    #[command(flatten)]
    pub running: RunningArgs,
    /// Keep a picture of the highlight after each step of a sheet, and the state to go on from
    ///
    /// They come into DIR/snapshots while the design runs and stay there whatever happens. Each picture shows the light
    /// of one cell at its first bounce, blurred by 1° as in the lower row of comparison.png.
    #[arg(long, help_heading = "Running", conflicts_with = "dry_run")]
    pub snapshots: bool,
    /// Go on from DIR/snapshots of an earlier run of the same settings, and keep snapshots
    ///
    /// The result is the same, byte for byte, as without the break. Only --rays and --no-verify may differ.
    #[arg(long, help_heading = "Running", conflicts_with = "dry_run")]
    pub resume: bool,
    /// Do not trace light over the result
    #[arg(long, help_heading = "Running")]
    pub no_verify: bool,
    /// Tell sizes, STL bytes and time without designing; needs no -o
    #[arg(long, help_heading = "Running")]
    pub dry_run: bool,
}

impl DesignArgs {
    /// Lays the flags over `recipe`.
    pub fn apply(&self, recipe: &mut Recipe) {
        if let Some(picture) = &self.picture {
            recipe.name_picture(picture);
            recipe.goal = None;
        }
        if let Some(goal) = &self.goal {
            recipe.name_goal(goal);
        }
        let patches = &mut recipe.patches;
        for (path, name) in [
            (&self.portrait, &mut patches.portrait),
            (&self.gloss, &mut patches.gloss),
            (&self.normal, &mut patches.normal),
            (&self.anisotropy, &mut patches.anisotropy),
            (&self.albedo, &mut patches.albedo),
        ] {
            if let Some(path) = path {
                *name = Some(path.to_string_lossy().into_owned());
            }
        }
        if let Some(part) = self.goal_part {
            recipe.goal_part = part.into();
        }
        self.settings.apply(recipe);
    }

    /// A setting that only a picture has, if one was given.
    pub fn of_picture(&self) -> Option<&'static str> {
        ["quantity", "seen", "invert", "rotate", "fit", "encoding"].into_iter().find(|name| self.settings.has(name))
    }

    /// Whether the field is to be chosen for the goal.
    pub fn chooses_field(&self) -> bool {
        self.goal.is_some() && !self.settings.has("half-field")
    }

    /// `recipe` with what its scene implies, unless a flag contradicts that: then what is wrong with it.
    pub fn implied(&self, recipe: Recipe) -> Result<Recipe, String> {
        self.settings.implied(recipe)
    }

    /// The kind of relief, if the flag was given.
    pub fn surface(&self) -> Option<SurfaceKind> {
        self.settings.alone().plate.surface
    }

    /// The recipe that the other flags are laid over, if it is not one from a file.
    pub fn base(&self) -> Recipe {
        match self.method {
            Some(MethodArg::Weyrich2009) => Recipe::weyrich2009(),
            None => Recipe::default(),
        }
    }
}
