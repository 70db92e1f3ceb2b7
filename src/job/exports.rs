//! Every file of an output folder: its name, what it is, when it is written, and how.
//!
//! A new file of a design is one more line of [`DESIGN`], and one of the README's table. Which files may be replaced, what
//! `.ci/run` expects of its example and what the README lists follow from here; tests hold the latter two to it.

mod others;

#[cfg(test)]
mod tests;

use std::cell::OnceCell;
use std::io::{self, Cursor, Write};

use super::goal::GoalProof;
use super::pictures::{ProofPictures, target_picture};
use super::product::{Content, Product, png};
use crate::export::heightmap::{HeightMap, height_map};
use crate::export::obj::write_obj;
use crate::export::ply::write_ply;
use crate::export::scene_files::LitPlate;
use crate::export::scene_files::mitsuba::{BODY, LAMP, MIRROR, SCREEN};
use crate::export::shading::ReliefPicture;
use crate::export::sheet::sheet_solid;
use crate::export::step::write_step;
use crate::export::stl::write_stl;
#[cfg(feature = "meshes")]
use crate::export::three_mf::write_three_mf;
use crate::highlight::scored_target;
use crate::picture::Picture;
use crate::progress::{Cancelled, Progress, Stage};
use crate::recipe::Format;
use crate::report::text;

pub use others::*;

/// Pixels along the longer side of the height map, at the most.
pub(super) const HEIGHT_MAP_SIDE: usize = 2048;

/// Pixels along the longer side of the relief's picture.
pub(super) const RELIEF_PICTURE_SIDE: usize = 960;

/// Pixels along a side of the target where no proof has one.
const TARGET_SIDE: usize = 256;

/// A file that a design may write.
pub struct Export {
    /// Its name in the folder.
    pub name: &'static str,
    /// When it is written.
    pub when: When,
    write: fn(&Source, &mut dyn Write) -> io::Result<()>,
}

/// When a file is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum When {
    /// With every design.
    Always,
    /// If light was sent over the plate.
    Proved,
    /// If light was sent over the plate as a cutter or polish leaves it.
    Milled,
    /// If light was sent over the plate of a goal.
    Goal,
    /// If light was sent over the plate as a machine makes it.
    AsMade,
    /// If a scene for other renderers was asked for.
    Scene,
    /// If one was asked for and its lamp is far away.
    FarScene,
    /// If this format was asked for.
    Also(Format),
    /// If the surface that a machine and polish leave was asked for.
    Surface,
}

/// The files of a design, in the order in which they are written.
pub const DESIGN: &[Export] = &[
    Export {
        name: "plate.stl",
        when: When::Always,
        write: |from, mut out| write_stl(&from.product.design.mesh, &mut out),
    },
    Export {
        name: "plate.obj",
        when: When::Also(Format::Obj),
        write: |from, mut out| write_obj(&from.product.design.mesh, &mut out),
    },
    Export {
        name: "plate.ply",
        when: When::Also(Format::Ply),
        write: |from, mut out| write_ply(&from.product.design.mesh, &mut out),
    },
    Export { name: "plate.3mf", when: When::Also(Format::ThreeMf), write: |from, out| from.three_mf(out) },
    Export { name: "plate.step", when: When::Also(Format::Step), write: |from, out| from.step(out) },
    Export { name: "heightmap.png", when: When::Always, write: |from, out| png(&from.map()?.image, out) },
    Export {
        name: "heightmap.json",
        when: When::Always,
        write: |from, out| out.write_all(text(&from.map()?.sidecar).as_bytes()),
    },
    Export { name: "heightmap.tiff", when: When::Also(Format::Tiff), write: |from, out| from.map_in_tiff(out) },
    Export { name: "relief.png", when: When::Always, write: |from, out| from.relief(out) },
    Export { name: "target.png", when: When::Always, write: |from, out| from.target(out) },
    Export {
        name: "simulated.png",
        when: When::Proved,
        write: |from, out| from.proof(|p, out| png(&p.simulated, out), out),
    },
    Export {
        name: "comparison.png",
        when: When::Proved,
        write: |from, out| from.proof(|p, out| png(&p.comparison, out), out),
    },
    Export {
        name: "comparison_milled.png",
        when: When::Milled,
        write: |from, out| from.proof(|p, out| p.milled.as_ref().map_or(Ok(()), |page| png(page, out)), out),
    },
    Export {
        name: "comparison_made.png",
        when: When::AsMade,
        write: |from, out| from.proof(|p, out| p.made.as_ref().map_or(Ok(()), |page| png(page, out)), out),
    },
    Export {
        name: "scene.xml",
        when: When::Scene,
        write: |from, out| from.lit()?.write_mitsuba(&from.product.described(), out),
    },
    Export { name: MIRROR, when: When::Scene, write: |from, mut out| write_ply(&from.lit()?.mirror, &mut out) },
    Export { name: BODY, when: When::Scene, write: |from, mut out| write_ply(&from.lit()?.body, &mut out) },
    Export { name: SCREEN, when: When::Scene, write: |from, out| from.lit()?.screen.write(out) },
    Export { name: LAMP, when: When::FarScene, write: |from, out| from.lit()?.beam.write(out) },
    Export {
        name: "scene.glb",
        when: When::Scene,
        write: |from, out| from.lit()?.write_gltf(&from.product.described(), out),
    },
    Export { name: "as-made.stl", when: When::Surface, write: |from, out| from.surface(out) },
    Export {
        name: "goal.png",
        when: When::Goal,
        write: |from, out| from.product.goal.as_ref().map_or(Ok(()), |goal| png(&goal.picture(), out)),
    },
    Export {
        name: "recipe.toml",
        when: When::Always,
        write: |from, out| out.write_all(from.product.recipe.to_toml().as_bytes()),
    },
    Export {
        name: "report.json",
        when: When::Always,
        write: |from, out| out.write_all(text(&from.product.report(from.picture)).as_bytes()),
    },
];

/// The names of all files that a design may write.
pub fn names() -> Vec<&'static str> {
    DESIGN.iter().map(|export| export.name).collect()
}

impl Product {
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
        let source = Source::new(self, picture, progress);
        source.due().try_for_each(|export| keep(export.name, &mut |out| export.write(&source, out)))
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

/// What the files are made from; what several need is made once, when the first asks.
struct Source<'a> {
    product: &'a Product,
    picture: &'a Picture,
    progress: &'a Progress<'a>,
    map: OnceCell<HeightMap>,
    pictures: OnceCell<ProofPictures>,
    lit: OnceCell<LitPlate>,
}

impl<'a> Source<'a> {
    fn new(product: &'a Product, picture: &'a Picture, progress: &'a Progress<'a>) -> Self {
        let (map, pictures, lit) = Default::default();
        Self { product, picture, progress, map, pictures, lit }
    }

    /// The files that are to be written.
    fn due(&self) -> impl Iterator<Item = &'static Export> {
        let proof = self.product.proof.as_ref();
        let (proved, milled) = (proof.is_some(), proof.is_some_and(|proof| proof.milled.is_some()));
        let made = proof.and_then(|proof| proof.made.as_ref());
        let surface = self.product.recipe.machining.as_made_stl && made.is_some_and(|made| made.surface.is_some());
        DESIGN.iter().filter(move |export| match export.when {
            When::Always => true,
            When::Proved => proved,
            When::Milled => milled,
            When::Goal => self.product.goal.as_ref().is_some_and(GoalProof::is_traced),
            When::AsMade => made.is_some(),
            When::Scene => self.product.recipe.files.scene_files,
            When::FarScene => self.product.recipe.files.scene_files && self.product.has_lamp_sheet(),
            When::Also(format) => self.product.recipe.writes(format),
            When::Surface => surface,
        })
    }

    fn map(&self) -> io::Result<&HeightMap> {
        made_once(&self.map, || {
            let mut map = height_map(&self.product.design.relief, HEIGHT_MAP_SIDE, self.progress)?;
            map.sidecar.rim = self.product.about_rim();
            Ok(map)
        })
    }

    fn lit(&self) -> io::Result<&LitPlate> {
        made_once(&self.lit, || self.product.lit_plate(self.progress))
    }

    fn step(&self, out: &mut dyn Write) -> io::Result<()> {
        let Product { design, recipe, .. } = self.product;
        let about = self.product.described();
        write_step(&design.relief, recipe.plate.thickness, &about, out, self.progress).map_err(io::Error::other)
    }

    /// The encoder of TIFF goes back in what it writes.
    fn map_in_tiff(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut file = Cursor::new(Vec::new());
        self.map()?.write_tiff(&mut file)?;
        out.write_all(file.get_ref())
    }

    #[cfg(feature = "meshes")]
    fn three_mf(&self, mut out: &mut dyn Write) -> io::Result<()> {
        let about = [("Title", "Relief plate".to_owned()), ("Description", self.product.described())];
        write_three_mf(&self.product.design.mesh, &about, &mut out)
    }

    /// No recipe that asks for it passes its check.
    #[cfg(not(feature = "meshes"))]
    fn three_mf(&self, _: &mut dyn Write) -> io::Result<()> {
        Err(io::ErrorKind::Unsupported.into())
    }

    fn surface(&self, mut out: &mut dyn Write) -> io::Result<()> {
        let Product { recipe, proof, .. } = self.product;
        let Some(surface) = proof.as_ref().and_then(|proof| proof.made.as_ref()?.surface.as_ref()) else {
            return Ok(());
        };
        let solid = sheet_solid(surface, recipe.plate.thickness, 0.0, self.progress).map_err(io::Error::other)?;
        write_stl(&solid, &mut out)
    }

    fn relief(&self, out: &mut dyn Write) -> io::Result<()> {
        let Product { design, .. } = self.product;
        let made_of: Vec<String> = [self.product.made_of()].into_iter().chain(self.product.about_rim()).collect();
        let (relief, made_of) = (&design.relief, &made_of.join(", "));
        let page = ReliefPicture { relief, continuous: design.sheet.is_some(), made_of };
        let picture = page.picture(RELIEF_PICTURE_SIDE, self.progress);
        png(&picture.map_err(io::Error::other)?, out)
    }

    fn target(&self, out: &mut dyn Write) -> io::Result<()> {
        let Product { recipe, design, proof, .. } = self.product;
        let setup = &design.distribution.setup;
        let unproved = || scored_target(&self.picture.light, recipe.highlight.quantity, setup, TARGET_SIDE);
        let target = proof.as_ref().map_or_else(unproved, |proof| proof.target.clone());
        png(&target_picture(&target, recipe), out)
    }

    /// Writes one of the pictures of the proof.
    fn proof(
        &self,
        write: fn(&ProofPictures, &mut dyn Write) -> io::Result<()>,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        let Product { recipe, design, proof: Some(proof), .. } = self.product else { return Ok(()) };
        let view = design.distribution.setup.view();
        let make = || ProofPictures::new(proof, recipe, view, &self.product.in_one_line(), self.progress);
        write(made_once(&self.pictures, make)?, out)
    }
}

/// What `cell` holds, made now if it is empty yet.
fn made_once<T>(cell: &OnceCell<T>, make: impl FnOnce() -> Result<T, Cancelled>) -> io::Result<&T> {
    let new = if cell.get().is_none() { Some(make().map_err(io::Error::other)?) } else { None };
    match (cell.get(), new) {
        (None, Some(new)) => Ok(cell.get_or_init(|| new)),
        (Some(made), _) => Ok(made),
        (None, None) => Err(io::Error::other(Cancelled)),
    }
}

impl Export {
    /// Writes the file.
    fn write(&self, from: &Source, out: &mut dyn Write) -> io::Result<()> {
        (self.write)(from, out)
    }
}
