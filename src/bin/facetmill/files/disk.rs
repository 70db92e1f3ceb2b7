//! The calls that change a folder, in one place: tests make each of them fail, or be the last that a run comes to.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;

/// What is asked before each call, by the call's name; its error is the call's.
type Before = dyn Fn(&'static str) -> io::Result<()> + Send + Sync;

/// The file system.
#[derive(Clone)]
pub struct Disk(Arc<Before>);

impl Default for Disk {
    fn default() -> Self {
        Self(Arc::new(|_| Ok(())))
    }
}

impl Disk {
    /// A file system on which `before` may forbid each call.
    #[cfg(test)]
    pub fn with(before: impl Fn(&'static str) -> io::Result<()> + Send + Sync + 'static) -> Self {
        Self(Arc::new(before))
    }

    pub fn create_dir(&self, path: &Path) -> io::Result<()> {
        (self.0)("mkdir")?;
        fs::create_dir(path)
    }

    /// Makes a folder unless it is there; a link to one does not count.
    pub fn create_dir_if_missing(&self, path: &Path) -> io::Result<()> {
        match self.create_dir(path) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists && is_real_dir(path) => Ok(()),
            done => done,
        }
    }

    /// An empty file for writing.
    pub fn create(&self, path: &Path) -> io::Result<File> {
        (self.0)("create")?;
        File::create(path)
    }

    /// A file of that name, as it is or empty, whose lock says that a run is alive.
    pub fn open_lock(&self, path: &Path) -> io::Result<File> {
        (self.0)("open")?;
        File::options().read(true).write(true).create(true).truncate(false).open(path)
    }

    pub fn write(&self, file: &mut File, bytes: &[u8]) -> io::Result<()> {
        (self.0)("write")?;
        file.write_all(bytes)
    }

    /// Waits until what was written to a file will outlast a power cut.
    pub fn sync(&self, file: &File) -> io::Result<()> {
        (self.0)("fsync")?;
        file.sync_all()
    }

    /// The same for the names in a folder, where the system lets folders be opened.
    pub fn sync_dir(&self, path: &Path) -> io::Result<()> {
        (self.0)("fsync")?;
        if cfg!(unix) {
            match File::open(path)?.sync_all() {
                // Some network and user-space file systems know no such call.
                Err(error) if matches!(error.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported) => {
                    Ok(())
                }
                done => done,
            }
        } else {
            Ok(())
        }
    }

    pub fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        (self.0)("rename")?;
        fs::rename(from, to)
    }

    pub fn remove_file(&self, path: &Path) -> io::Result<()> {
        (self.0)("unlink")?;
        fs::remove_file(path)
    }

    pub fn remove_dir(&self, path: &Path) -> io::Result<()> {
        (self.0)("rmdir")?;
        fs::remove_dir(path)
    }
}

/// Whether something of that name is there; a link that leads nowhere is something.
pub fn is_there(path: &Path) -> io::Result<bool> {
    match path.symlink_metadata() {
        Ok(_) => Ok(true),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}

/// Whether `path` is a folder and no link to one.
pub fn is_real_dir(path: &Path) -> bool {
    path.symlink_metadata().is_ok_and(|about| about.is_dir())
}
