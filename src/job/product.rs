//! What comes of a job, and the files that an output folder holds of it.

use std::io::{self, Write};

use image::{EncodableLayout, ImageBuffer, PixelWithColorType};

use super::compare::FacetComparison;
use super::design::Design;
use super::pictures::{ProofPictures, target_picture};
use super::proof::Proof;
use super::report::report;
use crate::export::heightmap::height_map;
use crate::export::pixels::encode_png;
use crate::export::shading::relief_picture;
use crate::export::stl::write_stl;
use crate::highlight::scored_target;
use crate::picture::Picture;
use crate::progress::{Cancelled, Progress, Stage};
use crate::recipe::Recipe;
use crate::report::design::{DesignReport, made_of};
use crate::report::text;

/// Every file that a design may write.
pub const FILES: &[&str] = &[
    "plate.stl",
    "heightmap.png",
    "heightmap.json",
    "target.png",
    "simulated.png",
    "relief.png",
    "comparison.png",
    "comparison_milled.png",
    "recipe.toml",
    "report.json",
];

/// Pixels along the longer side of the height map, at the most.
const HEIGHT_MAP_SIDE: usize = 2048;

/// Pixels along the longer side of the relief's picture.
const RELIEF_PICTURE_SIDE: usize = 960;

/// What a file holds, written when it is asked for.
pub type Content<'a> = &'a mut dyn FnMut(&mut dyn Write) -> io::Result<()>;

/// A plate, its proof and what is said of both.
#[derive(Clone, Debug)]
pub struct Product {
    /// The recipe by which the plate was made: that of the job, or the same for facets where they were chosen.
    pub recipe: Recipe,
    /// The plate.
    pub design: Design,
    /// Light sent over it, if it was to be proved.
    pub proof: Option<Proof>,
    /// The sheet beside the facets of the same recipe, where both are possible.
    pub comparison: Option<FacetComparison>,
}

impl Product {
    /// Everything that is known of it, as `report.json` holds it.
    pub fn report(&self, picture: &Picture) -> DesignReport {
        report(self, picture)
    }

    /// Hands every file of the output folder to `keep`, by name and content.
    pub fn write<E: From<Cancelled>>(
        &self,
        picture: &Picture,
        keep: &mut impl FnMut(&'static str, Content) -> Result<(), E>,
        progress: &Progress,
    ) -> Result<(), E> {
        progress.stage(Stage::Files);
        let mut keep = |name, content: Content| {
            progress.check()?;
            let kept = keep(name, &mut |out| content(&mut Stoppable { out, progress }));
            // What was cut short is no fault of the writer's.
            progress.check()?;
            kept
        };
        let Self { recipe, design, .. } = self;
        let setup = &design.distribution.setup;
        keep("plate.stl", &mut |mut out| write_stl(&design.mesh, &mut out))?;
        let map = height_map(&design.relief, HEIGHT_MAP_SIDE);
        keep("heightmap.png", &mut |out| png(&map.image, out))?;
        keep("heightmap.json", &mut |out| out.write_all(text(&map.sidecar).as_bytes()))?;
        let plan = relief_picture(&design.relief, &self.made_of(), RELIEF_PICTURE_SIDE);
        keep("relief.png", &mut |out| png(&plan, out))?;
        let target = || scored_target(&picture.light, recipe.highlight.quantity, setup, 256);
        let target = self.proof.as_ref().map_or_else(target, |proof| proof.target.clone());
        keep("target.png", &mut |out| png(&target_picture(&target, recipe), out))?;
        if let Some(proof) = &self.proof {
            let pictures = ProofPictures::new(proof, recipe, setup.view(), &self.in_one_line());
            keep("simulated.png", &mut |out| png(&pictures.simulated, out))?;
            keep("comparison.png", &mut |out| png(&pictures.comparison, out))?;
            if let Some(milled) = &pictures.milled {
                keep("comparison_milled.png", &mut |out| png(milled, out))?;
            }
        }
        keep("recipe.toml", &mut |out| out.write_all(recipe.to_toml().as_bytes()))?;
        keep("report.json", &mut |out| out.write_all(text(&self.report(picture)).as_bytes()))
    }

    /// What the relief is made of, in words.
    pub fn made_of(&self) -> String {
        made_of(&self.recipe, self.design.sheet.as_ref().map(|sheet| sheet.relief.cells))
    }

    /// The plate in one line, for captions.
    fn in_one_line(&self) -> String {
        let Recipe { plate, light, highlight, .. } = &self.recipe;
        let [width, height] = plate.size;
        let (low, high) = self.design.relief.height_range();
        format!(
            "{width} × {height} mm, {}, relief {:.2} mm   ·   light at {}°, {}°   ·   half field {}°",
            self.made_of(),
            high - low,
            light.theta,
            light.phi,
            highlight.half_field
        )
    }
}

/// A writer that fails once the work is abandoned.
struct Stoppable<'a> {
    out: &'a mut dyn Write,
    progress: &'a Progress<'a>,
}

impl Write for Stoppable<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.progress.check().map_err(io::Error::other)?;
        self.out.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// Writes `image` as a PNG file.
pub fn png<P>(image: &ImageBuffer<P, Vec<P::Subpixel>>, out: &mut dyn Write) -> io::Result<()>
where
    P: PixelWithColorType,
    [P::Subpixel]: EncodableLayout,
{
    out.write_all(&encode_png(image).map_err(io::Error::other)?)
}
