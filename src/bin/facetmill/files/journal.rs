//! How files come into an output folder: wholly or not at all, whenever the run ends.
//!
//! A run keeps what it has not finished in a hidden folder [`HIDDEN`] within the output folder: new files in `new`, and
//! while they are exchanged the earlier ones in `old`. Once everything new is on the disk, a journal with all names is
//! put beside them, under its own name by one renaming. Without a journal the output folder has not been touched; with
//! one, whoever comes next can take the remaining steps ([`complete`]). Which have been taken shows in the folders.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::disk::{Disk, is_real_dir, is_there};

/// The hidden folder's name.
pub const HIDDEN: &str = ".facetmill-run";

const NEW: &str = "new";
const OLD: &str = "old";
const JOURNAL: &str = "journal";

/// The journal before it has its name.
const PART: &str = "journal.part";

/// Largest journal read, bytes.
const LARGEST: u64 = 1 << 16;

/// Where new files of `folder` are written.
pub fn new_files(folder: &Path) -> PathBuf {
    folder.join(HIDDEN).join(NEW)
}

/// Whether an exchange in `folder` has begun and not ended.
pub fn is_begun(folder: &Path) -> bool {
    is_real_dir(&folder.join(HIDDEN)) && is_there(&folder.join(HIDDEN).join(JOURNAL)).unwrap_or(true)
}

/// Names of files in the output folder.
#[derive(Serialize, Deserialize)]
struct Journal {
    /// Come in, in the place of earlier ones if there are any.
    new: Vec<String>,
    /// Go: they would tell of an earlier run.
    removed: Vec<String>,
}

/// How an exchange failed.
#[derive(Debug)]
pub enum Failed {
    /// The folder is as it was.
    Undone(io::Error),
    /// Some files could not be put back; nothing is lost, and [`complete`] goes on.
    Halfway(io::Error),
}

/// Exchanges the files `own` in `folder` for the new ones, those of `written`. If that fails, all are put back.
pub fn exchange(disk: &Disk, folder: &Path, own: &[&str], written: &[&str]) -> Result<(), Failed> {
    let journal = prepare(disk, folder, own, written).map_err(Failed::Undone)?;
    let hidden = folder.join(HIDDEN);
    let begun = disk.rename(&hidden.join(PART), &hidden.join(JOURNAL)).and_then(|()| disk.sync_dir(&hidden));
    let failed = match begun.and_then(|()| forward(disk, folder, &journal)) {
        Ok(()) => {
            // If this fails, the next run finds an exchange that has nothing left to do.
            let _ = end(disk, folder);
            return Ok(());
        }
        Err(error) => error,
    };
    // The journal goes only after everything is back, and without it nothing has been moved.
    let _ = backward(disk, folder, &journal).and_then(|()| end(disk, folder));
    if is_begun(folder) { Err(Failed::Halfway(failed)) } else { Err(Failed::Undone(failed)) }
}

/// Takes the remaining steps of an exchange that has begun in `folder`, if there is one.
pub fn complete(disk: &Disk, folder: &Path) -> io::Result<()> {
    if !is_begun(folder) {
        return Ok(());
    }
    let journal = Journal::read(&folder.join(HIDDEN).join(JOURNAL))?;
    forward(disk, folder, &journal)?;
    end(disk, folder)
}

/// Writes the journal, not under its own name yet.
fn prepare(disk: &Disk, folder: &Path, own: &[&str], written: &[&str]) -> io::Result<Journal> {
    let hidden = folder.join(HIDDEN);
    let mut removed = Vec::new();
    for name in own.iter().filter(|name| !written.contains(name)) {
        if is_there(&folder.join(name))? {
            removed.push((*name).to_owned());
        }
    }
    let journal = Journal { new: written.iter().map(|name| (*name).to_owned()).collect(), removed };
    disk.create_dir(&hidden.join(OLD))?;
    disk.sync_dir(&hidden.join(NEW))?;
    disk.sync_dir(folder)?;
    let mut file = disk.create(&hidden.join(PART))?;
    disk.write(&mut file, &journal.bytes()?)?;
    disk.sync(&file)?;
    Ok(journal)
}

/// Moves earlier files out of `folder` and new ones in, as far as that has not been done.
fn forward(disk: &Disk, folder: &Path, journal: &Journal) -> io::Result<()> {
    let hidden = folder.join(HIDDEN);
    for name in &journal.removed {
        let (place, old) = (folder.join(name), hidden.join(OLD).join(name));
        // Moved already: what stands there now has come in since, and is somebody's.
        if !is_there(&old)? && is_there(&place)? {
            disk.rename(&place, &old)?;
        }
    }
    for name in &journal.new {
        let (place, new, old) = (folder.join(name), hidden.join(NEW).join(name), hidden.join(OLD).join(name));
        if !is_there(&new)? {
            continue;
        }
        if is_there(&place)? {
            if is_there(&old)? {
                return Err(io::Error::other(format!("{} has come in meanwhile: move it away", place.display())));
            }
            disk.rename(&place, &old)?;
        }
        disk.rename(&new, &place)?;
    }
    disk.sync_dir(folder)
}

/// Moves everything back, as far as that can be done; the first error.
fn backward(disk: &Disk, folder: &Path, journal: &Journal) -> io::Result<()> {
    let hidden = folder.join(HIDDEN);
    let back = |name: &String, is_new: bool| {
        let (place, new, old) = (folder.join(name), hidden.join(NEW).join(name), hidden.join(OLD).join(name));
        if is_new && !is_there(&new)? && is_there(&place)? {
            disk.rename(&place, &new)?;
        }
        if is_there(&old)? && !is_there(&place)? {
            disk.rename(&old, &place)?;
        }
        Ok(())
    };
    let all = journal.new.iter().map(|name| back(name, true));
    let done: Vec<io::Result<()>> = all.chain(journal.removed.iter().map(|name| back(name, false))).collect();
    done.into_iter().collect::<io::Result<()>>()?;
    // What is back stays back where folders cannot be synced: whether a power cut undoes that is not known then.
    let _ = disk.sync_dir(folder);
    Ok(())
}

/// Removes the journal: the exchange is over.
fn end(disk: &Disk, folder: &Path) -> io::Result<()> {
    let hidden = folder.join(HIDDEN);
    if is_there(&hidden.join(JOURNAL))? {
        disk.remove_file(&hidden.join(JOURNAL))?;
        disk.sync_dir(&hidden)?;
    }
    Ok(())
}

/// Removes the hidden folder of a run that has ended, unless an exchange has begun: then it may hold the only copy.
pub fn sweep(disk: &Disk, folder: &Path) -> io::Result<()> {
    let hidden = folder.join(HIDDEN);
    if !is_real_dir(&hidden) || is_begun(folder) {
        return Ok(());
    }
    for inner in [hidden.join(NEW), hidden.join(OLD), hidden.clone()] {
        if !is_real_dir(&inner) {
            continue;
        }
        for entry in fs::read_dir(&inner)? {
            let entry = entry?;
            if !entry.file_type()?.is_dir() {
                disk.remove_file(&entry.path())?;
            }
        }
        disk.remove_dir(&inner)?;
    }
    Ok(())
}

impl Journal {
    /// Its checksum in the first line, then its names.
    fn bytes(&self) -> io::Result<Vec<u8>> {
        let names = serde_json::to_string(self)?;
        Ok(format!("{:016x}\n{names}\n", checksum(&names)).into_bytes())
    }

    fn read(path: &Path) -> io::Result<Self> {
        let broken = || io::Error::new(io::ErrorKind::InvalidData, format!("{} is broken", path.display()));
        if !path.symlink_metadata()?.is_file() {
            return Err(broken());
        }
        let mut text = String::new();
        File::open(path)?.take(LARGEST).read_to_string(&mut text)?;
        let (sum, names) = text.split_once('\n').ok_or_else(broken)?;
        let names = names.trim_end_matches('\n');
        if sum != format!("{:016x}", checksum(names)) {
            return Err(broken());
        }
        let journal: Self = serde_json::from_str(names).map_err(|_| broken())?;
        // A folder may come from anybody: no name leads out of it.
        let is_plain = |name: &String| {
            let mut parts = Path::new(name).components();
            matches!((parts.next(), parts.next()), (Some(Component::Normal(part)), None) if part == name.as_str())
        };
        if journal.new.iter().chain(&journal.removed).all(is_plain) { Ok(journal) } else { Err(broken()) }
    }
}

/// FNV-1a: tells a journal that was written whole from any other.
pub fn checksum(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3))
}
