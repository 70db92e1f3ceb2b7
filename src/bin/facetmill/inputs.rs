//! Input files opened with care: a pipe nobody writes to would wait for ever, a device never end.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use facetmill::cutter::library::Library;
use facetmill::memory::{MemoryLimit, Need};
use facetmill::milling::machine::Machine;
use facetmill::picture::{self, Picture, Reading};
use facetmill::recipe::Recipe;
use facetmill::scene::room::Room;

use crate::console::Failure;
use crate::files;

/// Largest recipe or scene file read, bytes.
const LARGEST_RECIPE: u64 = 1 << 20;

/// The inputs that were given, once what a killed run left half-way in the folders that they are, or lie in, is put right.
pub fn given(inputs: [Option<&Path>; 2]) -> Result<Vec<&Path>, Failure> {
    let given: Vec<&Path> = inputs.into_iter().flatten().collect();
    files::settle(&given).map_err(|error| Failure::Input(error.to_string()))?;
    Ok(given)
}

/// Opens a regular file.
pub fn open(path: &Path) -> Result<File, Failure> {
    let name = path.display();
    let cannot = |error: std::io::Error| match error.kind() {
        std::io::ErrorKind::NotFound => Failure::Input(format!("{name}: there is no such file; check the path")),
        _ => Failure::Input(format!("{name}: the file cannot be read ({error}); check its permissions")),
    };
    let about = path.metadata().map_err(cannot)?;
    if !about.is_file() {
        let found = if about.is_dir() { "a directory" } else { "a device or a pipe" };
        return Err(Failure::Input(format!("{name}: this is {found}, not a file; name a file")));
    }
    File::open(path).map_err(cannot)
}

/// Reads a picture, if it is one that may take so much memory.
pub fn picture(path: &Path, reading: &Reading, limit: MemoryLimit) -> Result<Picture, Failure> {
    if let Some(need) = picture::need(path) {
        limit.admit(need)?;
    }
    Ok(picture::read(path, reading)?)
}

/// Refuses the recipe of a plate of patches, which comes from `name`, where the light of a whole plate is asked for.
pub fn is_no_patches(recipe: &Recipe, name: &dyn std::fmt::Display) -> Result<(), Failure> {
    if !recipe.patches.are_wanted() {
        return Ok(());
    }
    let [theta, phi] = recipe.viewer().0;
    Err(Failure::Input(format!(
        "{name}: the picture of this plate of patches stands on the metal: look at it with measure --look --camera \
         {theta},{phi}"
    )))
}

/// Where a file is that is named in `file`, if it is beside that.
pub fn beside(file: &Path, named: &Path) -> PathBuf {
    file.parent().unwrap_or(Path::new("")).join(named)
}

/// Where a file is that the recipe in `folder` names: in that, as it is named, or beside the folder.
pub fn near_folder(folder: &Path, named: &Path) -> Option<PathBuf> {
    let places = [folder.join(named), named.to_owned(), folder.join("..").join(named)];
    places.into_iter().find(|place| place.exists())
}

/// All of the file at `path`, once the memory that it `needs` for so many bytes may be taken.
pub fn bytes(path: &Path, limit: MemoryLimit, needs: impl Fn(u64) -> Need) -> Result<Vec<u8>, Failure> {
    let name = path.display();
    let opened = open(path)?;
    let length = opened.metadata().map_or(0, |about| about.len());
    limit.admit(needs(length))?;
    let mut bytes = Vec::new();
    let cannot = |error| Failure::Input(format!("{name}: the file cannot be read ({error}); check its permissions"));
    opened.take(length.max(1)).read_to_end(&mut bytes).map_err(cannot)?;
    Ok(bytes)
}

/// The picture that the recipe in `file` names: beside that file, else in the working folder.
pub fn picture_of(recipe: &Recipe, file: &Path) -> Result<PathBuf, Failure> {
    let from = file.display();
    is_no_patches(recipe, &from)?;
    let Some(named) = recipe.picture_path() else {
        return Err(Failure::Input(format!("{from}: the recipe names no picture: give one on the command line")));
    };
    let beside = beside(file, &named);
    if beside.exists() {
        return Ok(beside);
    }
    if named.exists() {
        return Ok(named);
    }
    let (name, folder) = (named.display(), beside.display());
    let looked = if beside == named { "there is none".into() } else { format!("neither {folder} nor {name} is there") };
    Err(Failure::Input(format!(
        "{from}: the recipe names the picture {name}, but {looked}: give it on the command line"
    )))
}

/// Reads a scene file.
pub fn room(path: &Path) -> Result<Room, Failure> {
    let text = text(path, "scene file", "scene.toml")?;
    Room::from_toml(&text).map_err(|error| Failure::Input(format!("{}: {error}", path.display())))
}

/// Reads a machine file.
pub fn machine(path: &Path) -> Result<Machine, Failure> {
    let text = text(path, "machine file", "machine.toml")?;
    Machine::from_toml(&text).map_err(|error| Failure::Input(format!("{}: {error}", path.display())))
}

/// Reads a file of cutters.
pub fn cutters(path: &Path) -> Result<Library, Failure> {
    let text = text(path, "file of cutters", "cutters.toml")?;
    Library::from_toml(&text).map_err(|error| Failure::Input(format!("{}: {error}", path.display())))
}

/// Reads a recipe file; its numbers are not checked yet.
pub fn recipe(path: &Path) -> Result<Recipe, Failure> {
    let text = text(path, "recipe", "recipe.toml")?;
    Recipe::from_toml(&text).map_err(|error| Failure::Input(format!("{}: {error}", path.display())))
}

/// The text of a file that a person wrote, which is to be a `what` such as `example`.
pub fn text(path: &Path, what: &str, example: &str) -> Result<String, Failure> {
    let name = path.display();
    let mut text = String::new();
    let cannot = |what: String| Failure::Input(format!("{name}: {what}"));
    let file = open(path)?;
    if file.metadata().is_ok_and(|about| about.len() > LARGEST_RECIPE) {
        return Err(cannot(format!("this is too large for a {what}; name a {example}")));
    }
    file.take(LARGEST_RECIPE)
        .read_to_string(&mut text)
        .map_err(|error| cannot(format!("this is no {what} ({error}); name a {example}")))?;
    Ok(text)
}
