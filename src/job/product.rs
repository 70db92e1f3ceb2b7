//! What comes of a job, and the files that an output folder holds of it.

use std::io::{self, Write};

use image::{EncodableLayout, ImageBuffer, PixelWithColorType};

use super::compare::FacetComparison;
use super::design::Design;
use super::exports::Source;
use super::proof::Proof;
use super::report::report;
use crate::export::pixels::encode_png;
use crate::picture::Picture;
use crate::progress::{Cancelled, Progress, Stage};
use crate::recipe::Recipe;
use crate::report::design::{DesignReport, made_of};

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
        let source = Source::new(self, picture);
        source.due().try_for_each(|export| keep(export.name, &mut |out| export.write(&source, out)))
    }

    /// What the relief is made of, in words.
    pub fn made_of(&self) -> String {
        made_of(&self.recipe, self.design.sheet.as_ref().map(|sheet| sheet.relief.cells))
    }

    /// The plate in one line, for captions.
    pub(super) fn in_one_line(&self) -> String {
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
