//! Picture files opened with care.

use std::fs::File;
use std::io;
use std::path::Path;

use super::{MAX_FILE, PictureError, pipe};

/// The file at `path`, if it is one and no larger than pictures may be.
pub(super) fn opened(path: &Path) -> Result<File, PictureError> {
    let name = path.display().to_string();
    let about = path.metadata().map_err(|source| unreadable(path, source))?;
    // Checked before opening: a device can do anything.
    if !about.is_file() {
        let found = match about.is_dir() {
            true => "a directory",
            false if pipe::is_pipe(&about) => "a pipe",
            false => "a device",
        };
        return Err(PictureError::NotAFile { name, found });
    }
    if about.len() > MAX_FILE {
        return Err(PictureError::Heavy { name, megabytes: about.len() >> 20 });
    }
    File::open(path).map_err(|source| unreadable(path, source))
}

/// Why the file at `path` cannot be read.
pub(super) fn unreadable(path: &Path, source: io::Error) -> PictureError {
    let name = path.display().to_string();
    match source.kind() {
        io::ErrorKind::NotFound => PictureError::Missing { name },
        _ => PictureError::Unreadable { name, source },
    }
}
