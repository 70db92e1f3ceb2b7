//! Output folders: written aside, then moved into place whole, or not at all.

mod disk;

mod journal;

mod claim;

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use facetmill::job::png;
use same_file::is_same_file;

use claim::{Claim, Refused, is_leftover};
use disk::Disk;
use journal::{Failed, HIDDEN};

/// What a run has on the disk that must not stay if it ends now: shared by who writes and by who may end it.
#[derive(Default)]
pub struct Gate(Mutex<OnDisk>);

#[derive(Default)]
enum OnDisk {
    /// Nothing is on the disk.
    #[default]
    Closed,
    /// The folder is taken, and files are being written aside.
    Open(Claim),
    /// Everything is in place; it is too late to stop.
    Passed,
}

impl Gate {
    fn lock(&self) -> MutexGuard<'_, OnDisk> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Gives the folder back, with nothing of the run in it, and calls `end`, which does not return; does nothing if all files are in place.
    /// Nothing new can be written meanwhile.
    pub fn abandon(&self, end: impl FnOnce()) {
        let mut on_disk = self.lock();
        if !matches!(*on_disk, OnDisk::Passed) {
            *on_disk = OnDisk::Closed;
            end();
        }
    }
}

/// Where a run writes, and what must not be lost there.
#[derive(Clone, Copy)]
pub struct Place<'a> {
    pub folder: &'a Path,
    /// The folder may hold anything: files named in `own` are replaced, or removed if they are not written again, since
    /// they would tell of an earlier run.
    pub force: bool,
    /// Names of all files that the run may write.
    pub own: &'a [&'static str],
    /// Names of folders within the folder that the run writes into as it goes.
    pub inner: &'static [&'static str],
    /// The run goes on from what an earlier one left in `inner`: that may be there without `force`.
    pub goes_on: bool,
    /// What the run reads.
    pub inputs: &'a [&'a Path],
}

impl<'a> Place<'a> {
    /// A place for a run that writes nothing until it is done.
    pub fn new(folder: &'a Path, force: bool, own: &'a [&'static str], inputs: &'a [&'a Path]) -> Self {
        Self { folder, force, own, inner: &[], goes_on: false, inputs }
    }

    /// Whether there is anything but what this run may find; what runs left unfinished does not count.
    fn holds_others(&self, goes_on: bool) -> io::Result<bool> {
        let entries = match fs::read_dir(self.folder) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(false),
            entries => entries?,
        };
        for entry in entries {
            let name = entry?.file_name();
            if !(is_leftover(&name) || goes_on && self.inner.iter().any(|inner| name == *inner)) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Refuses if a file that is to be written is a folder.
    fn check_own(&self) -> Result<(), OutputError> {
        let place = self.own.iter().map(|name| self.folder.join(name)).find(|place| place.is_dir());
        place.map_or(Ok(()), |place| Err(OutputError::AFolder(place)))
    }

    /// Refuses to replace what the run reads, by whatever name that was given.
    fn spare_inputs(&self) -> Result<(), OutputError> {
        let inner: Vec<PathBuf> =
            self.inner.iter().filter_map(|name| self.folder.join(name).canonicalize().ok()).collect();
        for input in self.inputs {
            let mut places = self.own.iter().map(|name| self.folder.join(name));
            // The folder's name as it was given reads better than a canonical one.
            let lost = places.find(|place| is_same(place, input)).or_else(|| {
                let home = input.canonicalize().ok()?.parent()?.to_owned();
                inner.contains(&home).then_some(home)
            });
            if let Some(place) = lost {
                return Err(OutputError::OwnInput((*input).to_owned(), place));
            }
        }
        Ok(())
    }
}

/// Whether two names are one regular file's. Others are not opened: a pipe would wait for ever.
fn is_same(a: &Path, b: &Path) -> bool {
    a.is_file()
        && b.is_file()
        && (a.canonicalize().ok() == b.canonicalize().ok() || is_same_file(a, b).unwrap_or(false))
}

/// Files on their way into an output folder. Dropped before [`publish`](Staged::publish), nothing stays.
pub struct Staged {
    gate: Arc<Gate>,
    disk: Disk,
    folder: PathBuf,
    force: bool,
    own: Vec<&'static str>,
    inner: &'static [&'static str],
    written: Vec<&'static str>,
}

impl Staged {
    /// Takes a folder for one run. It may exist only if it is empty, or as [`Place`] allows.
    ///
    /// It is locked and, if it was missing, made: what cannot be written costs no minute of work.
    pub fn new(place: &Place, gate: &Arc<Gate>) -> Result<Self, OutputError> {
        Self::on(Disk::default(), place, gate)
    }

    fn on(disk: Disk, place: &Place, gate: &Arc<Gate>) -> Result<Self, OutputError> {
        let Place { folder, force, own, inner, goes_on, .. } = *place;
        if let Some(file) = folder.ancestors().find(|path| path.exists() && !path.is_dir()) {
            return Err(OutputError::NotAFolder(file.to_owned()));
        }
        let check = || {
            if !force && place.holds_others(goes_on).map_err(|error| OutputError::Cannot(folder.to_owned(), error))? {
                return Err(OutputError::Exists(folder.to_owned()));
            }
            place.check_own()?;
            place.spare_inputs()
        };
        // A folder that is none of ours is not touched. What a killed run left half-way is judged when it is put right.
        if !journal::is_begun(folder) {
            check()?;
        }
        // Ctrl-C waits until the folder is taken, and then gives it back.
        let mut on_disk = gate.lock();
        let claim = Claim::take(&disk, folder).map_err(|refused| OutputError::refused(folder, refused))?;
        check()?;
        *on_disk = OnDisk::Open(claim);
        drop(on_disk);
        Ok(Self {
            gate: gate.clone(),
            disk,
            folder: folder.to_owned(),
            force,
            own: own.to_vec(),
            inner,
            written: Vec::new(),
        })
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
        self.disk.sync(out.get_ref()).map_err(cannot)?;
        self.written.push(name);
        Ok(())
    }

    fn create(&self, name: &str) -> io::Result<fs::File> {
        let gate = self.gate.lock();
        if !matches!(*gate, OnDisk::Open(_)) {
            return Err(io::Error::other("the folder was closed"));
        }
        let new = journal::new_files(&self.folder);
        self.disk.create_dir_if_missing(&self.folder.join(HIDDEN))?;
        self.disk.create_dir_if_missing(&new)?;
        self.disk.create(&new.join(name))
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

    /// Moves everything into place. Files of other names in an existing folder are left alone; if any have come in
    /// meanwhile and were not to be there, nothing is written.
    pub fn publish(self) -> Result<(), OutputError> {
        let Self { folder, force, own, inner, .. } = &self;
        let place = Place { inner, ..Place::new(folder, *force, own, &[]) };
        let mut gate = self.gate.lock();
        if let OnDisk::Open(claim) = &mut *gate {
            let cannot = |error| OutputError::Cannot(folder.clone(), error);
            if !force && place.holds_others(true).map_err(cannot)? {
                return Err(OutputError::CameIn(folder.clone()));
            }
            place.check_own()?;
            journal::exchange(&self.disk, folder, own, &self.written).map_err(|failed| match failed {
                Failed::Undone(error) => cannot(error),
                Failed::Halfway(error) => OutputError::Halfway(folder.clone(), folder.join(HIDDEN), error),
            })?;
            claim.keep_folders();
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

/// How long a run that exchanges files in a folder is waited for.
const PATIENCE: Duration = Duration::from_secs(5);

/// Puts right what a killed run left half-way where `inputs` are read from: folders, or files in them.
pub fn settle(inputs: &[&Path]) -> Result<(), OutputError> {
    for input in inputs {
        let parent = || input.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let folder = if input.is_dir() { input } else { parent() };
        let until = Instant::now() + PATIENCE;
        while journal::is_begun(folder) {
            match Claim::take(&Disk::default(), folder) {
                Ok(_) => break,
                // It is alive, and at its last step.
                Err(Refused::Busy) if Instant::now() < until => std::thread::sleep(Duration::from_millis(20)),
                Err(refused) => return Err(OutputError::refused(folder, refused)),
            }
        }
    }
    Ok(())
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
    /// Another run is at work there.
    #[error("{} is being written by another run: wait for its end, or choose another folder", .0.display())]
    Busy(PathBuf),
    /// What is read would be replaced.
    #[error("{} is read, and {} would be replaced: choose another folder for -o", .0.display(), .1.display())]
    OwnInput(PathBuf, PathBuf),
    /// Somebody has put something there during the work.
    #[error("{} was empty and now is not, so nothing was written: choose another folder, or add --force to replace its files", .0.display())]
    CameIn(PathBuf),
    /// Files could be neither exchanged nor put back.
    #[error("{} cannot be written ({}), and is half-way between two results: nothing is lost, the rest is in {}, and the next run or measurement of the folder completes it", .0.display(), .2, .1.display())]
    Halfway(PathBuf, PathBuf, io::Error),
    /// What a killed run left cannot be completed.
    #[error("{} was left half-way between two results by a run that was killed, and cannot be completed ({}): the rest is in {}", .0.display(), .2, .1.display())]
    LeftHalfway(PathBuf, PathBuf, io::Error),
    /// The system refuses.
    #[error("{} cannot be written ({}): check that the folder is writable and the disk has room", .0.display(), .1)]
    Cannot(PathBuf, io::Error),
    /// Nobody can read what is printed.
    #[error("standard output cannot be written ({0}): check where it leads")]
    StandardOutput(io::Error),
}

impl OutputError {
    fn refused(folder: &Path, refused: Refused) -> Self {
        match refused {
            Refused::Busy => Self::Busy(folder.to_owned()),
            Refused::Halfway(error) => Self::LeftHalfway(folder.to_owned(), folder.join(HIDDEN), error),
            Refused::Cannot(error) => Self::Cannot(folder.to_owned(), error),
        }
    }
}

#[cfg(test)]
mod tests;
