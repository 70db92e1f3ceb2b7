//! The whole job as one call: from a recipe and its picture to everything that an output folder holds.
//!
//! [`Job::run`] designs a plate, proves it, compares it with flat facets and takes them where they are clearly better. What
//! comes of it, a [`Product`], tells its [report](Product::report) and hands out its [files](Product::write), in memory
//! or into a folder. Each step can be had by itself: [`mod@design`], [`proof`], [`compare`], [`estimate`], [`pictures`].
//!
//! Nothing here is shared between jobs: several may run in one process, each on [threads of its own](clock::on_own_threads)
//! that it is billed for, each heard of and ended through its own [`Progress`].

pub mod clock;

pub mod speed;

pub mod near;
mod sentences;

mod cut_sheet;

pub mod thinning;

pub mod design;

mod scene_facts;

pub mod findings;

pub mod on_wall;

pub mod proof;

pub mod smeared;

pub mod made;

pub mod swept;

pub mod preview;

pub mod compare;

pub mod memory;

pub mod estimate;

mod wall_pictures;

pub mod pictures;

pub mod goal;

mod product;

mod scene_files;

mod lighter;

mod advice;

pub mod report;

pub mod exports;

pub mod patches;

pub mod patch_estimate;

pub mod patch_check;

mod patch_report;

pub mod plan;

pub use product::{Content, Product, png};
pub use sentences::{finer_than_the_blur, in_a_sentence};

use crate::memory::MemoryLimit;
use crate::picture::Picture;
use crate::progress::{Progress, Stage};
use crate::recipe::Recipe;
use crate::sculpt::checkpoint::Checkpoint;
use compare::{beside_facets, of_facets};
use design::{DesignError, OnStep, design, design_with_checkpoints};
use made::made_by_machine;
use preview::previewed;
use proof::prove;
use smeared::pass_angle;

/// What is to be done.
#[derive(Clone, Copy, Debug)]
pub struct Job<'a> {
    /// Every setting.
    pub recipe: &'a Recipe,
    /// The drawing, as read.
    pub picture: &'a Picture,
    /// Whether light is sent over what comes of it; without that nothing is compared either.
    pub proved: bool,
    /// The most memory that it may take: one that needs more is refused before any work, and no result hangs on it.
    pub memory: MemoryLimit,
}

/// How a job ends that meets no error.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// With all that was asked for.
    Finished(Product),
    /// With the best so far, since it was told to finish; the product is proved as any other.
    FinishedEarly(Product),
    /// With nothing, since it was abandoned.
    Abandoned,
}

impl Outcome {
    /// What came of the job, if anything.
    pub fn product(self) -> Option<Product> {
        match self {
            Self::Finished(product) | Self::FinishedEarly(product) => Some(product),
            Self::Abandoned => None,
        }
    }
}

impl Job<'_> {
    /// Does the work: design, proof, comparison with facets and the choice between the two; on the threads of the pool
    /// that it is called in, for which see [`clock::on_own_threads`].
    ///
    /// A sheet goes on `from` where an earlier run of the same recipe had come, and `on_step` is told of every step that
    /// is done.
    pub fn run(
        &self,
        from: Option<Checkpoint>,
        on_step: OnStep<'_>,
        progress: &Progress,
    ) -> Result<Outcome, DesignError> {
        match self.product(from, on_step, progress) {
            Ok(product) if product.design.ended_early => Ok(Outcome::FinishedEarly(product)),
            Ok(product) => Ok(Outcome::Finished(product)),
            Err(DesignError::Cancelled(_)) => Ok(Outcome::Abandoned),
            Err(error) => Err(error),
        }
    }

    fn product(
        &self,
        from: Option<Checkpoint>,
        on_step: OnStep<'_>,
        progress: &Progress,
    ) -> Result<Product, DesignError> {
        let light = &self.picture.light;
        self.recipe.check()?;
        self.memory.admit(memory::need(self.recipe, light.width, self.proved))?;
        let made = design_with_checkpoints(self.recipe, light, from, on_step, progress)?;
        let mut recipe = self.recipe.clone();
        recipe.machining.pass_angle = pass_angle(&recipe, light)?;
        if !self.proved {
            return Ok(Product { recipe, design: made, proof: None, comparison: None, goal: None });
        }
        if recipe.design.sheet.preview {
            let proof = previewed(&recipe, light, &made, progress)?;
            return Ok(Product { recipe, design: made, proof, comparison: None, goal: None });
        }
        let mut proof = prove(&recipe, light, &made, progress)?;
        let comparison = beside_facets(&recipe, light, &made, &proof, progress)?;
        let facets_win = comparison.is_some_and(|c| c.facets_are_better()) && recipe.leaves_the_kind_open();
        if !facets_win {
            proof.made = made_by_machine(&recipe, light, (&made, &proof), progress)?;
            return Ok(Product { recipe, design: made, proof: Some(proof), comparison, goal: None });
        }
        progress.stage(Stage::Facets);
        let recipe = of_facets(&recipe);
        let mut facets = design(&recipe, light, &progress.to_the_end())?;
        facets.ended_early |= made.ended_early;
        let made = facets;
        let mut proof = prove(&recipe, light, &made, progress)?;
        proof.made = made_by_machine(&recipe, light, (&made, &proof), progress)?;
        Ok(Product { recipe, design: made, proof: Some(proof), comparison, goal: None })
    }
}
