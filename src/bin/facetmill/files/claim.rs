//! A folder taken for one run: by a lock that ends with the run, however it ends.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use fs4::{FileExt, TryLockError};
use same_file::Handle;

use super::disk::{Disk, is_real_dir};
use super::journal::{self, HIDDEN};

/// The locked file's name within the folder.
pub const LOCK: &str = ".facetmill-lock";

/// How often a lock is tried for that another run removes at that moment.
const TRIES: usize = 100;

/// Why a folder cannot be taken.
#[derive(Debug)]
pub enum Refused {
    /// Another run that is alive has it.
    Busy,
    /// An earlier run was killed while it exchanged files, and its work cannot be completed.
    Halfway(io::Error),
    /// The system refuses.
    Cannot(io::Error),
}

impl From<io::Error> for Refused {
    fn from(error: io::Error) -> Self {
        Self::Cannot(error)
    }
}

/// A folder that no other run writes into. Dropped, nothing of this run stays but what was published.
pub struct Claim {
    disk: Disk,
    folder: PathBuf,
    /// Open as long as the claim lasts.
    _lock: File,
    made: NewFolders,
}

impl Claim {
    /// Takes `folder`, which is made if it is missing, and puts right what a killed run left in it.
    pub fn take(disk: &Disk, folder: &Path) -> Result<Self, Refused> {
        let mut made = NewFolders { disk: disk.clone(), paths: Vec::new() };
        for _ in 0..TRIES {
            made.make(folder)?;
            let path = folder.join(LOCK);
            let lock = match disk.open_lock(&path) {
                // Another run has ended meanwhile, and removed the folder that it had made.
                Err(error) if error.kind() == io::ErrorKind::NotFound && !folder.exists() => continue,
                opened => opened?,
            };
            match FileExt::try_lock(&lock) {
                Err(TryLockError::WouldBlock) => return Err(Refused::Busy),
                // Where files cannot be locked, nothing tells the living from the dead.
                Err(TryLockError::Error(error)) if error.kind() != io::ErrorKind::Unsupported => {
                    return Err(error.into());
                }
                _ => {}
            }
            // The run that had it may have removed it before it was locked here.
            let is_same = Handle::from_path(&path).ok() == Some(Handle::from_file(lock.try_clone()?)?);
            if is_same {
                let claim = Self { disk: disk.clone(), folder: folder.to_owned(), _lock: lock, made };
                journal::complete(disk, folder).map_err(Refused::Halfway)?;
                journal::sweep(disk, folder)?;
                sweep_nameless(disk, folder);
                return Ok(claim);
            }
        }
        Err(Refused::Busy)
    }

    /// Something was published: the folders that were made for it stay.
    pub fn keep_folders(&mut self) {
        self.made.paths.clear();
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        // What cannot be removed now is swept by the next run.
        let _ = journal::sweep(&self.disk, &self.folder);
        let _ = self.disk.remove_file(&self.folder.join(LOCK));
    }
}

/// Whether a name within an output folder is one under which runs keep what is unfinished.
pub fn is_leftover(name: &std::ffi::OsStr) -> bool {
    name == HIDDEN || name == LOCK || is_nameless(name)
}

/// Earlier versions gave their hidden folders six letters by chance.
fn is_nameless(name: &std::ffi::OsStr) -> bool {
    let letters = name.to_str().and_then(|name| name.strip_prefix(".facetmill-"));
    letters.is_some_and(|letters| letters.len() == 6 && letters.bytes().all(|byte| byte.is_ascii_alphanumeric()))
}

/// Removes hidden folders that killed runs of earlier versions left, except with replaced files in them, which may be
/// the only copies.
fn sweep_nameless(disk: &Disk, folder: &Path) {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    for path in entries.filter(|entry| is_nameless(&entry.file_name())).map(|entry| entry.path()) {
        // Gone if it is empty.
        let _ = disk.remove_dir(&path.join("replaced"));
        let holds_folders = |path: &Path| fs::read_dir(path).into_iter().flatten().flatten().any(|e| e.path().is_dir());
        if !is_real_dir(&path) || holds_folders(&path) {
            continue;
        }
        for entry in fs::read_dir(&path).into_iter().flatten().flatten() {
            let _ = disk.remove_file(&entry.path());
        }
        let _ = disk.remove_dir(&path);
    }
}

/// Folders made on the way, removed again unless something has come into them.
struct NewFolders {
    disk: Disk,
    paths: Vec<PathBuf>,
}

impl NewFolders {
    /// Makes `folder` and what it lies in, as far as they are missing.
    fn make(&mut self, folder: &Path) -> io::Result<()> {
        let missing: Vec<&Path> =
            folder.ancestors().take_while(|path| !path.as_os_str().is_empty() && !path.is_dir()).collect();
        for path in missing.into_iter().rev() {
            match self.disk.create_dir(path) {
                // By another run, at this moment.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists && path.is_dir() => {}
                done => {
                    done?;
                    self.paths.push(path.to_owned());
                }
            }
        }
        Ok(())
    }
}

impl Drop for NewFolders {
    fn drop(&mut self) {
        self.paths.iter().rev().for_each(|folder| {
            let _ = self.disk.remove_dir(folder);
        });
    }
}
