//! Output folders: written aside, then moved into place whole.

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::TempDir;

/// Files on their way into an output folder. Dropped before [`publish`](Staged::publish), nothing stays.
pub struct Staged {
    folder: PathBuf,
    aside: TempDir,
    names: Vec<String>,
}

impl Staged {
    /// Prepares to write `folder`. It may exist only if it is empty, or with `force`.
    pub fn new(folder: &Path, force: bool) -> Result<Self, OutputError> {
        if !force && fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some()) {
            return Err(OutputError::Exists(folder.to_owned()));
        }
        if folder.exists() && !folder.is_dir() {
            return Err(OutputError::NotAFolder(folder.to_owned()));
        }
        // Near the target, since a rename must not cross file systems; in a folder that exists, so that none is left behind.
        let near = folder.ancestors().skip(1).find(|p| p.is_dir()).unwrap_or(Path::new("."));
        let cannot = |error| OutputError::Cannot(folder.to_owned(), error);
        let aside = tempfile::Builder::new().prefix(".facetmill-").tempdir_in(near).map_err(cannot)?;
        Ok(Self { folder: folder.to_owned(), aside, names: Vec::new() })
    }

    /// Writes one file.
    pub fn write(
        &mut self,
        name: &str,
        content: impl FnOnce(&mut BufWriter<fs::File>) -> io::Result<()>,
    ) -> Result<(), OutputError> {
        let cannot = |error| OutputError::Cannot(self.folder.join(name), error);
        let file = fs::File::create(self.aside.path().join(name)).map_err(cannot)?;
        let mut out = BufWriter::with_capacity(1 << 20, file);
        content(&mut out).map_err(cannot)?;
        out.flush().map_err(cannot)?;
        out.get_ref().sync_all().map_err(cannot)?;
        self.names.push(name.to_owned());
        Ok(())
    }

    /// Writes one file of `bytes`.
    pub fn write_bytes(&mut self, name: &str, bytes: &[u8]) -> Result<(), OutputError> {
        self.write(name, |out| out.write_all(bytes))
    }

    /// Moves everything into place. Files of other names in an existing folder are left alone.
    pub fn publish(self) -> Result<(), OutputError> {
        let cannot = |error| OutputError::Cannot(self.folder.clone(), error);
        fs::create_dir_all(&self.folder).map_err(cannot)?;
        for name in &self.names {
            fs::rename(self.aside.path().join(name), self.folder.join(name)).map_err(cannot)?;
        }
        Ok(())
    }
}

/// Why output could not be written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// There already is something.
    #[error("{} exists and is not empty: choose another folder, or add --force to replace its files", .0.display())]
    Exists(PathBuf),
    /// A file where a folder should be.
    #[error("{} is a file, not a folder: choose another name for -o", .0.display())]
    NotAFolder(PathBuf),
    /// The system refuses.
    #[error("{} cannot be written: {}; check that the folder is writable and the disk has room", .0.display(), .1)]
    Cannot(PathBuf, io::Error),
}
