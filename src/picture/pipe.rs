//! Pipes as files: read to their end, but not waited for where nobody writes.

use std::fs::{File, Metadata};
use std::io::{self, Read};
use std::path::Path;
use std::time::{Duration, Instant};

/// How long somebody may take to begin writing.
const PATIENCE: Duration = Duration::from_secs(5);

/// Whether this is a pipe that [`open`] can open.
pub(crate) fn is_pipe(about: &Metadata) -> bool {
    #[cfg(unix)]
    return std::os::unix::fs::FileTypeExt::is_fifo(&about.file_type());
    #[cfg(not(unix))]
    return false;
}

/// A pipe, to be read to its end. An ordinary opening would wait for ever for somebody who writes.
pub(crate) fn open(path: &Path) -> io::Result<impl Read> {
    let mut options = File::options();
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, libc::O_NONBLOCK);
    Ok(Pipe { file: options.read(true).open(path)?, opened: Instant::now(), begun: false })
}

struct Pipe {
    file: File,
    opened: Instant,
    /// Whether somebody has written, or holds the other end.
    begun: bool,
}

impl Read for Pipe {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            match self.file.read(buffer) {
                // Without a writer a pipe looks as if it had ended.
                Ok(0) if !self.begun && !buffer.is_empty() => {
                    if self.opened.elapsed() > PATIENCE {
                        let words = format!("nobody has written into the pipe for {} s", PATIENCE.as_secs());
                        return Err(io::Error::new(io::ErrorKind::TimedOut, words));
                    }
                }
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => self.begun = true,
                done => {
                    self.begun = true;
                    return done;
                }
            }
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_pipe_is_read_to_its_end_however_slowly_it_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
        assert!(is_pipe(&path.metadata().unwrap()));
        let to = path.clone();
        let writer = std::thread::spawn(move || {
            std::thread::sleep(Duration::from_millis(100));
            let mut file = File::options().write(true).open(to).unwrap();
            for piece in [b"one ", b"two "] {
                std::io::Write::write_all(&mut file, piece).unwrap();
                std::thread::sleep(Duration::from_millis(100));
            }
        });
        let mut text = String::new();
        open(&path).unwrap().read_to_string(&mut text).unwrap();
        assert_eq!(text, "one two ");
        writer.join().unwrap();
    }
}
