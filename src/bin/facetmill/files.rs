//! Output folders: written aside, then moved into place whole, or not at all.

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use facetmill::job::png;
use tempfile::TempDir;

/// What a run has on the disk that must not stay if it ends now: shared by who writes and by who may end it.
#[derive(Default)]
pub struct Gate(Mutex<OnDisk>);

#[derive(Default)]
enum OnDisk {
    /// Nothing is on the disk.
    #[default]
    Closed,
    /// Files are being written aside.
    Open(Aside),
    /// Everything is in place; it is too late to stop.
    Passed,
}

impl Gate {
    fn lock(&self) -> MutexGuard<'_, OnDisk> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Removes what was written aside and calls `end`, which does not return; does nothing if all files are in place.
    /// Nothing new can be written meanwhile.
    pub fn abandon(&self, end: impl FnOnce()) {
        let mut on_disk = self.lock();
        if !matches!(*on_disk, OnDisk::Passed) {
            *on_disk = OnDisk::Closed;
            end();
        }
    }
}

/// Files on their way into an output folder. Dropped before [`publish`](Staged::publish), nothing stays.
pub struct Staged {
    gate: Arc<Gate>,
    folder: PathBuf,
    own: Vec<&'static str>,
    written: Vec<&'static str>,
}

impl Staged {
    /// Prepares to write `folder`. It may exist only if it is empty, or with `force`, when files named in `own` are
    /// replaced, or removed if they are not written again: they would tell of an earlier run.
    ///
    /// The folder is tried out and left as it was, so that what cannot be written costs no minute of work.
    pub fn new(folder: &Path, force: bool, own: Vec<&'static str>, gate: &Arc<Gate>) -> Result<Self, OutputError> {
        if let Some(file) = folder.ancestors().find(|path| path.exists() && !path.is_dir()) {
            return Err(OutputError::NotAFolder(file.to_owned()));
        }
        let cannot = |error| OutputError::Cannot(folder.to_owned(), error);
        match fs::read_dir(folder).map(|mut entries| entries.next().is_some()) {
            Ok(true) if !force => return Err(OutputError::Exists(folder.to_owned())),
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(cannot(error)),
            _ => {}
        }
        if let Some(name) = own.iter().find(|name| folder.join(name).is_dir()) {
            return Err(OutputError::AFolder(folder.join(name)));
        }
        {
            // Ctrl-C waits until the trial is cleared away.
            let _gate = gate.lock();
            drop(Aside::open(folder).map_err(cannot)?);
        }
        Ok(Self { gate: gate.clone(), folder: folder.to_owned(), own, written: Vec::new() })
    }

    /// Writes one file; its name is one of our own.
    pub fn write(
        &mut self,
        name: &'static str,
        content: impl FnOnce(&mut BufWriter<fs::File>) -> io::Result<()>,
    ) -> Result<(), OutputError> {
        let cannot = |error| OutputError::Cannot(self.folder.join(name), error);
        let file = self.create(name).map_err(cannot)?;
        let mut out = BufWriter::with_capacity(1 << 20, file);
        content(&mut out).map_err(cannot)?;
        out.flush().map_err(cannot)?;
        out.get_ref().sync_all().map_err(cannot)?;
        self.written.push(name);
        Ok(())
    }

    fn create(&self, name: &str) -> io::Result<fs::File> {
        let mut gate = self.gate.lock();
        if !matches!(*gate, OnDisk::Open(_)) {
            *gate = OnDisk::Open(Aside::open(&self.folder)?);
        }
        match &*gate {
            OnDisk::Open(aside) => fs::File::create(aside.path(name)),
            _ => Err(io::Error::other("the folder was closed")),
        }
    }

    /// Writes one file of `bytes`.
    pub fn write_bytes(&mut self, name: &'static str, bytes: &[u8]) -> Result<(), OutputError> {
        self.write(name, |out| out.write_all(bytes))
    }

    /// Writes one picture.
    pub fn write_png<P>(
        &mut self,
        name: &'static str,
        image: &image::ImageBuffer<P, Vec<P::Subpixel>>,
    ) -> Result<(), OutputError>
    where
        P: image::PixelWithColorType,
        [P::Subpixel]: image::EncodableLayout,
    {
        self.write(name, |out| png(image, out))
    }

    /// Moves everything into place. Files of other names in an existing folder are left alone.
    pub fn publish(self) -> Result<(), OutputError> {
        let mut gate = self.gate.lock();
        if let OnDisk::Open(aside) = std::mem::replace(&mut *gate, OnDisk::Closed) {
            aside
                .publish(&self.folder, &self.own, &self.written)
                .map_err(|error| OutputError::Cannot(self.folder.clone(), error))?;
        }
        *gate = OnDisk::Passed;
        // Before `self`, whose own end locks it.
        drop(gate);
        Ok(())
    }
}

impl Drop for Staged {
    fn drop(&mut self) {
        let mut gate = self.gate.lock();
        if matches!(*gate, OnDisk::Open(_)) {
            *gate = OnDisk::Closed;
        }
    }
}

/// A hidden folder within the output folder: renaming from it never crosses file systems. Dropped, it is gone.
struct Aside {
    hidden: TempDir,
    made: NewFolders,
}

impl Aside {
    fn open(folder: &Path) -> io::Result<Self> {
        let missing: Vec<&Path> =
            folder.ancestors().take_while(|path| !path.as_os_str().is_empty() && !path.is_dir()).collect();
        let mut made = NewFolders(Vec::new());
        for path in missing.into_iter().rev() {
            fs::create_dir(path)?;
            made.0.push(path.to_owned());
        }
        Ok(Self { hidden: tempfile::Builder::new().prefix(".facetmill-").tempdir_in(folder).map_err(plain)?, made })
    }

    fn path(&self, name: &str) -> PathBuf {
        self.hidden.path().join(name)
    }

    /// Exchanges the files `own` in `folder` for those `written` here; if one cannot be, all are put back.
    fn publish(mut self, folder: &Path, own: &[&str], written: &[&str]) -> io::Result<()> {
        let replaced = self.hidden.path().join("replaced");
        fs::create_dir(&replaced)?;
        for (k, name) in own.iter().enumerate() {
            let place = folder.join(name);
            let done = rename_if_there(&place, &replaced.join(name))
                .and_then(|()| if written.contains(name) { fs::rename(self.path(name), &place) } else { Ok(()) });
            if let Err(error) = done {
                for name in &own[..=k] {
                    let place = folder.join(name);
                    // Best efforts: if this fails too, nothing more can be done.
                    if written.contains(name) && !self.path(name).exists() {
                        let _ = rename_if_there(&place, &self.path(name));
                    }
                    let _ = rename_if_there(&replaced.join(name), &place);
                }
                return Err(error);
            }
        }
        self.made.0.clear();
        Ok(())
    }
}

/// Folders made on the way, removed again unless something has come into them.
struct NewFolders(Vec<PathBuf>);

impl Drop for NewFolders {
    fn drop(&mut self) {
        self.0.iter().rev().for_each(|folder| {
            let _ = fs::remove_dir(folder);
        });
    }
}

fn rename_if_there(from: &Path, to: &Path) -> io::Result<()> {
    match fs::rename(from, to) {
        Err(error) if error.kind() == io::ErrorKind::NotFound && !from.exists() => Ok(()),
        done => done,
    }
}

/// The system's own words, without the name of our hidden folder.
fn plain(error: io::Error) -> io::Error {
    error.raw_os_error().map(io::Error::from_raw_os_error).unwrap_or_else(|| {
        let inner = error.get_ref().and_then(|inner| inner.source()).map(ToString::to_string);
        io::Error::new(error.kind(), inner.unwrap_or_else(|| error.to_string()))
    })
}

/// Why output could not be written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// There already is something.
    #[error("{} exists and is not empty: choose another folder, or add --force to replace its files", .0.display())]
    Exists(PathBuf),
    /// A file where a folder should be.
    #[error("{} is a file, not a folder: choose another folder for -o", .0.display())]
    NotAFolder(PathBuf),
    /// A folder where a file should be.
    #[error("{} is a folder, and a file of that name is to be written: choose another folder for -o", .0.display())]
    AFolder(PathBuf),
    /// The system refuses.
    #[error("{} cannot be written ({}): check that the folder is writable and the disk has room", .0.display(), .1)]
    Cannot(PathBuf, io::Error),
    /// Nobody can read what is printed.
    #[error("standard output cannot be written ({0}): check where it leads")]
    StandardOutput(io::Error),
}

#[cfg(test)]
mod tests {
    use super::*;

    fn listing(folder: &Path) -> Vec<(String, String)> {
        let mut all: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap())
            .map(|e| (e.file_name().into_string().unwrap(), fs::read_to_string(e.path()).unwrap()))
            .collect();
        all.sort();
        all
    }

    #[test]
    fn own_files_are_replaced_or_removed_and_others_stay() {
        let home = tempfile::tempdir().unwrap();
        for name in ["a", "b", "other"] {
            fs::write(home.path().join(name), "old").unwrap();
        }
        let aside = Aside::open(home.path()).unwrap();
        fs::write(aside.path("a"), "new").unwrap();
        aside.publish(home.path(), &["a", "b"], &["a"]).unwrap();
        assert_eq!(listing(home.path()), [("a".into(), "new".into()), ("other".into(), "old".into())]);
    }

    #[test]
    fn a_failure_in_the_middle_puts_everything_back() {
        let home = tempfile::tempdir().unwrap();
        for name in ["a", "b", "c"] {
            fs::write(home.path().join(name), "old").unwrap();
        }
        let before = listing(home.path());
        let aside = Aside::open(home.path()).unwrap();
        fs::write(aside.path("a"), "new").unwrap();
        // b was never written.
        assert!(aside.publish(home.path(), &["a", "c", "b"], &["a", "b"]).is_err());
        assert_eq!(listing(home.path()), before);
    }

    #[test]
    fn made_folders_go_unless_published() {
        let home = tempfile::tempdir().unwrap();
        let deep = home.path().join("one/two/three");
        drop(Aside::open(&deep).unwrap());
        assert!(!home.path().join("one").exists());
        let too_long = home.path().join("one").join("n".repeat(300));
        assert!(Aside::open(&too_long).is_err());
        assert!(!home.path().join("one").exists());
        let aside = Aside::open(&deep).unwrap();
        fs::write(aside.path("a"), "new").unwrap();
        aside.publish(&deep, &["a"], &["a"]).unwrap();
        assert_eq!(listing(&deep), [("a".into(), "new".into())]);
    }
}
