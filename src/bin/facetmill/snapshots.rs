//! Pictures of a highlight as it forms, and the state from which a design goes on.

use std::fs;
use std::io::{self, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};

use facetmill::distribution::SlopeDistribution;
use facetmill::export::pixels::{common_white, encode_png, tone_mapped};
use facetmill::highlight::scored_target;
use facetmill::job::pictures::as_seen;
use facetmill::progress::Progress;
use facetmill::raster::Raster;
use facetmill::recipe::Recipe;
use facetmill::relief::periodic::PeriodicRelief;
use facetmill::sculpt::checkpoint::{Checkpoint, Origin, read_state, write_state};
use facetmill::sculpt::plan::plan;
use facetmill::sharpen::seen;
use facetmill::verify::windows::FirstBounce;
use serde_json::Value;

use crate::console::Failure;
use crate::files::OutputError;
use crate::inputs;

/// The folder's name within the output folder.
pub const FOLDER: &str = "snapshots";

/// The state's name within it.
const STATE: &str = "state";

/// A file of them that is being written. The output folder is locked, so nobody else does; what a killed run leaves of it
/// is written over by the next.
const ASIDE: &str = ".facetmill-part";

/// Pixels along a side of a snapshot.
const SIDE: usize = 256;

/// Where snapshots go, and what they belong to.
pub struct Snapshots<'a> {
    folder: PathBuf,
    recipe: &'a Recipe,
    light: &'a Raster,
    /// The first thing that could not be written.
    failed: Option<OutputError>,
}

impl<'a> Snapshots<'a> {
    /// Snapshots of a design of `recipe` for `light` into the folder `output`.
    pub fn new(output: &Path, recipe: &'a Recipe, light: &'a Raster) -> Self {
        Self { folder: output.join(FOLDER), recipe, light, failed: None }
    }

    /// Where they go.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Writes what a step has reached; whether that went well. After a failure nothing more is written.
    pub fn take(&mut self, distribution: &SlopeDistribution, at: &Checkpoint) -> bool {
        if self.failed.is_none() {
            let written = self.write(distribution, at);
            self.failed = written.err().map(|error| OutputError::Cannot(self.folder.clone(), error));
        }
        self.failed.is_none()
    }

    /// The first thing that went wrong, if anything did.
    pub fn finish(self) -> Result<(), OutputError> {
        self.failed.map_or(Ok(()), Err)
    }

    fn write(&self, distribution: &SlopeDistribution, at: &Checkpoint) -> io::Result<()> {
        fs::create_dir_all(&self.folder)?;
        if at.done == 1 {
            clear(&self.folder)?;
        }
        let name = plan(&self.recipe.sculpting()).get(at.done - 1).map_or("step", |step| step.name());
        let picture = encode_png(&self.picture(distribution, at)).map_err(io::Error::other)?;
        self.exchange(&format!("{:02}-{name}.png", at.done), |out| out.write_all(&picture))?;
        self.exchange(STATE, |out| write_state(at, &origin(self.recipe, self.light), out))
    }

    /// Writes a file aside and renames it: what stands in the folder is whole at any time.
    fn exchange(
        &self,
        name: &str,
        content: impl FnOnce(&mut BufWriter<&fs::File>) -> io::Result<()>,
    ) -> io::Result<()> {
        let aside = self.folder.join(ASIDE);
        let written = || {
            let file = fs::File::create(&aside)?;
            let mut out = BufWriter::new(&file);
            content(&mut out)?;
            out.flush()?;
            drop(out);
            file.sync_all()?;
            fs::rename(&aside, self.folder.join(name))
        };
        // In one piece, so that a failure leaves nothing.
        let done = written();
        if done.is_err() {
            let _ = fs::remove_file(&aside);
        }
        done
    }

    /// The highlight of one cell by first bounces, blurred by lamp and metal, seen through the main
    /// blur as in the lower row of `comparison.png`.
    fn picture(&self, distribution: &SlopeDistribution, at: &Checkpoint) -> image::GrayImage {
        let setup = &distribution.setup;
        let cell = self.recipe.sculpting().cell;
        let (nodes, heights) = (at.nodes, at.heights.clone());
        let relief = PeriodicRelief { nodes, heights, cell, cells: [1, 1], tilt: distribution.mean };
        let sent = FirstBounce::new(&relief, setup, (SIDE, SIDE), &Progress::silent());
        let sent = sent.ok().and_then(|sent| sent.window([0, 0], nodes)).unwrap_or_else(|| Raster::zeros(SIDE, SIDE));
        let light = self.recipe.blur(setup).map_or_else(|| sent.clone(), |blur| seen(&sent, &blur));
        let see = |raster: &Raster| as_seen(raster, self.recipe, setup.view());
        let target = see(&scored_target(self.light, self.recipe.highlight.quantity, setup, SIDE));
        tone_mapped(&see(&light), common_white(&target))
    }
}

/// The state that an earlier run of the same recipe left in `output`.
pub fn resume(output: &Path, recipe: &Recipe, light: &Raster) -> Result<Checkpoint, Failure> {
    let path = output.join(FOLDER).join(STATE);
    let name = path.display();
    let mut file = BufReader::new(inputs::open(&path)?);
    let (at, from) = read_state(&mut file)
        .map_err(|error| Failure::Input(format!("{name}: {error}; start anew with --snapshots and --force")))?;
    let theirs = Recipe::from_toml(&from.recipe)
        .map_err(|error| Failure::Input(format!("{name}: this state is broken: its recipe: {error}")))?;
    if let Some(what) = difference(&theirs, recipe) {
        return Err(Failure::Impossible(format!(
            "{name} belongs to another design, {what}: give the same settings, or start anew without --resume"
        )));
    }
    if from.picture != fingerprint(light) {
        return Err(Failure::Impossible(format!(
            "{name} belongs to another picture: give the same one, or start anew without --resume"
        )));
    }
    if !at.suits(&recipe.sculpting()) {
        return Err(Failure::Input(format!("{name}: this state is broken: no design of this recipe comes by it")));
    }
    Ok(at)
}

fn origin(recipe: &Recipe, light: &Raster) -> Origin {
    Origin { recipe: recipe.to_toml(), picture: fingerprint(light) }
}

/// The first setting that is not the same, of those that a relief depends on.
fn difference(theirs: &Recipe, ours: &Recipe) -> Option<String> {
    let plain = |recipe: &Recipe| {
        let mut recipe = recipe.clone();
        // The picture is told by its light, and rays only by the proof.
        (recipe.picture, recipe.picture_bytes, recipe.verify) = (None, None, Default::default());
        recipe.files = Default::default();
        serde_json::to_value(recipe).unwrap_or_default()
    };
    first_difference("", &plain(theirs), &plain(ours))
}

fn first_difference(name: &str, theirs: &Value, ours: &Value) -> Option<String> {
    let (Some(a), Some(b)) = (theirs.as_object(), ours.as_object()) else {
        let say = |value: &Value| if value.is_null() { "not set".into() } else { value.to_string() };
        return (theirs != ours).then(|| format!("whose {name} is {}; here it is {}", say(theirs), say(ours)));
    };
    let inner = |key: &String| if name.is_empty() { key.clone() } else { format!("{name}.{key}") };
    let keys = a.keys().chain(b.keys().filter(|key| !a.contains_key(*key)));
    keys.into_iter().find_map(|key| {
        first_difference(&inner(key), a.get(key).unwrap_or(&Value::Null), b.get(key).unwrap_or(&Value::Null))
    })
}

/// A number that tells one picture's light from another's (FNV-1a).
fn fingerprint(light: &Raster) -> String {
    let bytes = light.values.iter().flat_map(|value| value.to_bits().to_le_bytes());
    let hash = bytes
        .fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3));
    format!("{}x{} {hash:016x}", light.width, light.height)
}

/// Removes what an earlier run left: it would tell of another design.
fn clear(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name();
        let is_ours = name.to_str().is_some_and(|name| {
            let number = name
                .get(..3)
                .is_some_and(|start| start.ends_with('-') && start[..2].bytes().all(|byte| byte.is_ascii_digit()));
            name == STATE || name == ASIDE || (number && name.ends_with(".png"))
        });
        if is_ours && entry.file_type()?.is_file() {
            fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_differs_between_recipes_is_named() {
        let mine = Recipe::default();
        assert_eq!(difference(&mine, &mine), None);
        let changed = |change: fn(&mut Recipe)| {
            let mut other = mine.clone();
            change(&mut other);
            difference(&other, &mine)
        };
        assert_eq!(changed(|r| r.verify.rays = 5), None);
        assert_eq!(changed(|r| r.picture = Some("other.png".into())), None);
        assert_eq!(changed(|r| r.design.seed = 7).unwrap(), "whose design.seed is 7; here it is 1");
        let only_theirs = changed(|r| r.plate.grid = Some(64)).unwrap();
        assert_eq!(only_theirs, "whose plate.grid is 64; here it is not set");
    }

    #[test]
    fn every_pixel_counts_for_the_fingerprint() {
        let light = Raster::from_fn(3, 2, |x, y| (x + y) as f64);
        let mut other = light.clone();
        other.values[4] += 1e-12;
        assert_ne!(fingerprint(&light), fingerprint(&other));
        assert_ne!(fingerprint(&light), fingerprint(&Raster { width: 2, height: 3, ..light.clone() }));
    }
}
