//! STL files as the crate `stl_io` shall see them: what it would misread is put right or refused on the way.

use std::io::{self, BufRead, Cursor, Read, Seek, SeekFrom};

use super::{HEADER_BYTES, PREAMBLE, StlError};

/// Longest line of a text file, bytes.
const LONGEST_LINE: u64 = 4096;

/// A binary file whose length has been found to fit its count, under a header that nobody takes for text.
pub(crate) struct Records<'a, R> {
    preamble: Cursor<[u8; PREAMBLE]>,
    file: &'a mut R,
}

impl<'a, R> Records<'a, R> {
    /// `file` stands at its first triangle and holds `count` of them.
    pub fn new(file: &'a mut R, count: u32) -> Self {
        let mut preamble = [0; PREAMBLE];
        // An end of line: the search for "solid" looks no farther.
        preamble[0] = b'\n';
        preamble[HEADER_BYTES..].copy_from_slice(&count.to_le_bytes());
        Self { preamble: Cursor::new(preamble), file }
    }
}

impl<R: Read> Read for Records<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self.preamble.read(buffer)? {
            0 => self.file.read(buffer),
            bytes => Ok(bytes),
        }
    }
}

impl<R: Seek> Seek for Records<'_, R> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        only_to_start(to)?;
        self.preamble.set_position(0);
        self.file.seek(SeekFrom::Start(PREAMBLE as u64))?;
        Ok(0)
    }
}

/// A text file as one solid in lower case with normals of zero, line by line.
///
/// A read never goes beyond a line, so that a parser that complains has just been given the line that is wrong.
pub struct Lines<R> {
    file: R,
    /// What the parser is given: the line at hand as rewritten, and how much of it has been read.
    line: Vec<u8>,
    given: usize,
    /// Lines of the file read so far.
    number: u64,
    stage: Stage,
}

/// Where in the file the line at hand stands.
#[derive(Clone, Copy, PartialEq)]
enum Stage {
    /// Before the first line.
    Start,
    /// Not within a solid.
    Outside,
    /// Within a solid.
    Solid,
    /// Within a facet of a solid.
    Facet,
    /// Behind the last line.
    End,
}

impl<R: BufRead + Seek> Lines<R> {
    /// To be rewound before the first line is read.
    pub fn new(file: R) -> Self {
        Self { file, line: Vec::new(), given: 0, number: 0, stage: Stage::Start }
    }

    /// Reads and rewrites the next line; leaves none at the end of the file.
    fn advance(&mut self) -> io::Result<()> {
        self.line.clear();
        self.given = 0;
        if self.stage == Stage::Start {
            self.stage = Stage::Outside;
            self.line.extend(b"solid x\n");
            return Ok(());
        }
        self.number += 1;
        let wrong = || Err(io::ErrorKind::InvalidData.into());
        if self.file.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut self.line)? == 0 {
            // A file that ends within a solid gets no end: it is truncated.
            if self.stage == Stage::Outside {
                self.line.extend(b"endsolid\n");
                self.stage = Stage::End;
            }
            return Ok(());
        }
        if self.line.len() as u64 == LONGEST_LINE && !self.line.ends_with(b"\n") {
            return wrong();
        }
        self.line.make_ascii_lowercase();
        let word = self.line.trim_ascii_start();
        let word = &word[..word.iter().position(u8::is_ascii_whitespace).unwrap_or(word.len())];
        let (stage, rewritten) = match (word, self.stage) {
            (b"solid", Stage::Outside | Stage::Solid) => (Stage::Solid, Some("\n")),
            (b"endsolid", Stage::Outside | Stage::Solid) => (Stage::Outside, Some("\n")),
            (b"facet", Stage::Solid) => (Stage::Facet, Some("facet normal 0 0 0\n")),
            (b"endfacet", Stage::Facet) => (Stage::Solid, None),
            (b"", stage) | (_, stage @ Stage::Facet) => (stage, None),
            _ => return wrong(),
        };
        self.stage = stage;
        if let Some(rewritten) = rewritten {
            self.line.clear();
            self.line.extend(rewritten.as_bytes());
        }
        Ok(())
    }

    /// What `error` is about, which came up after `triangles` whole ones.
    pub(crate) fn located(&self, error: StlError, triangles: usize) -> StlError {
        let kind = match &error {
            StlError::Io(error) => error.kind(),
            _ => return error,
        };
        let infinite = |word: &str| word.parse().is_ok_and(|number: f32| !number.is_finite());
        match kind {
            io::ErrorKind::UnexpectedEof => StlError::Unfinished,
            io::ErrorKind::InvalidData => match str::from_utf8(&self.line) {
                Ok(line) if line.split_whitespace().skip(1).any(infinite) => StlError::NotFinite(triangles + 1),
                _ => StlError::Line(self.number),
            },
            _ => error,
        }
    }
}

impl<R: BufRead + Seek> Read for Lines<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.given == self.line.len() && self.stage != Stage::End {
            self.advance()?;
        }
        let bytes = (&self.line[self.given..]).read(buffer)?;
        self.given += bytes;
        Ok(bytes)
    }
}

impl<R: Seek> Seek for Lines<R> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        only_to_start(to)?;
        self.file.seek(SeekFrom::Start(0))?;
        self.line.clear();
        (self.given, self.number, self.stage) = (0, 0, Stage::Start);
        Ok(0)
    }
}

/// The parser looks at the first line and goes back to the start; nobody goes anywhere else.
fn only_to_start(to: SeekFrom) -> io::Result<()> {
    if to == SeekFrom::Start(0) { Ok(()) } else { Err(io::ErrorKind::Unsupported.into()) }
}
