//! What comes of a job.

use std::io::{self, Write};

use image::{EncodableLayout, ImageBuffer, PixelWithColorType};

use super::compare::FacetComparison;
use super::design::{Design, DesignError};
use super::findings::Proof;
use super::goal::{GoalPlates, GoalProof, prove_goal};
use super::proof::milled_plate;
use crate::export::pixels::encode_png;
use crate::goal::Goal;
use crate::progress::Progress;
use crate::recipe::{BorderFinish, Recipe};
use crate::report::design::made_of;
use crate::trace::grid::GridSurface;
use crate::trace::traced_plate::TracedPlate;

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
    /// Its goal, if it was asked for in place of a picture.
    pub goal: Option<GoalProof>,
}

impl Product {
    /// Keeps `goal`, and if light was sent over the plate, proves it over lamps from 0° to 60°, as designed and as cut; see
    /// [`prove_goal`].
    ///
    /// # Errors
    /// The plate cannot be traced, no light meets it, or it is cancelled.
    pub fn prove_goal(&mut self, goal: &Goal, progress: &Progress) -> Result<(), DesignError> {
        let Self { recipe, design, .. } = self;
        if self.proof.is_none() {
            self.goal = Some(GoalProof::untraced(goal));
            return Ok(());
        }
        let border = recipe.plate.border;
        let written = match &design.sheet {
            None => TracedPlate::Facets(GridSurface::new(&design.relief, progress)?),
            // The triangles themselves, as they stand in the file.
            Some(_) => TracedPlate::new(&design.mesh, border, progress)?,
        };
        let milled = milled_plate(recipe, &design.mesh, border, progress)?;
        let plates = GoalPlates { written: &written, milled: milled.as_ref() };
        self.goal = Some(prove_goal(recipe, goal, &design.distribution.setup, plates, progress)?);
        Ok(())
    }

    /// What the relief is made of, in words.
    pub fn made_of(&self) -> String {
        made_of(&self.recipe, self.design.sheet.as_ref().map(|sheet| sheet.relief.cells))
    }

    /// What the shop has to know of the rim, in words, if there is one.
    pub fn about_rim(&self) -> Option<String> {
        let Recipe { plate, .. } = &self.recipe;
        let fall = self.recipe.rim(&self.design.distribution.setup).fall.atan().to_degrees();
        let finish = match self.recipe.border_finish() {
            BorderFinish::Matt => "flat, to be left dull (blasted, sanded or blackened)".to_owned(),
            BorderFinish::Polished => "flat, polished with the rest".to_owned(),
            BorderFinish::Sloped(_) => format!("polished, falling outward by {fall:.2}°"),
        };
        (plate.border > 0.0).then(|| format!("rim of {} mm: {finish}", plate.border))
    }

    /// The plate as a file tells of it, which goes to a shop without the report.
    pub(super) fn described(&self) -> String {
        let rim = self.about_rim().map(|rim| format!("; {rim}")).unwrap_or_default();
        format!(
            "{}{rim}. Unit mm; x = y = 0 is the lower-left corner of the optical area, z points out of the plate.",
            self.in_one_line()
        )
    }

    /// The plate in one line, for captions.
    pub(super) fn in_one_line(&self) -> String {
        let Recipe { plate, light, highlight, .. } = &self.recipe;
        let [width, height] = plate.size;
        let (low, high) = self.design.relief.optical_heights();
        let plate = format!("{width} × {height} mm, {}, relief {:.2} mm", self.made_of(), high - low);
        // Of lamp and wall nearby the pictures say themselves where they stand and how wide the picture is.
        if self.recipe.is_near() {
            return plate;
        }
        format!("{plate}   ·   light at {}°, {}°   ·   half field {}°", light.theta, light.phi, highlight.half_field)
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
