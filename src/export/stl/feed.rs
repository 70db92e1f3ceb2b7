//! STL files as the crate `stl_io` shall see them: what it would misread is put right or refused on the way.

use std::io::{self, BufRead, Cursor, Read, Seek, SeekFrom};

use super::{HEADER_BYTES, PREAMBLE, StlError};

/// Longest line of a text file, bytes.
const LONGEST_LINE: usize = 4096;

/// A binary file whose length has been found to fit its count, under a header that nobody takes for text.
pub(crate) struct Records<'a, R> {
    preamble: Cursor<[u8; PREAMBLE]>,
    file: &'a mut R,
}

impl<'a, R> Records<'a, R> {
    /// `file` stands at its first triangle and holds `count` of them.
    pub(crate) fn new(file: &'a mut R, count: u32) -> Self {
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

/// Whether a file that begins so may be a text STL: "solid" is the first word that is no comment, and all is text.
pub(crate) fn is_text(head: &[u8]) -> bool {
    let head = head.strip_prefix(MARK).unwrap_or(head);
    let mut lines = head.split(|byte| matches!(byte, b'\n' | b'\r')).filter(|line| !is_comment(line));
    let word = lines.next().unwrap_or_default().trim_ascii_start();
    let printable = |&byte: &u8| byte >= b' ' || byte.is_ascii_whitespace();
    // Only the beginning: what comes later may be names in any letters, or rubbish behind the end.
    word.len() >= 5
        && word[..5].eq_ignore_ascii_case(b"solid")
        && head[..head.len().min(PREAMBLE)].iter().all(printable)
}

/// The mark of a text in UTF-8.
const MARK: &[u8] = b"\xef\xbb\xbf";

/// Makes one word of an "end" that stands apart from what it ends, as some programs write it.
fn join_end(line: &mut Vec<u8>) {
    let from = line.len() - line.trim_ascii_start().len();
    let Some(rest) = line[from..].strip_prefix(b"end") else { return };
    let word = rest.trim_ascii_start();
    if word.len() < rest.len() && [&b"solid"[..], b"facet", b"loop"].iter().any(|end| word.starts_with(end)) {
        let gap = rest.len() - word.len();
        line.drain(from + 3..from + 3 + gap);
    }
}

/// Words of a solid, or the beginning of its first: behind a solid they are not rubbish but one more that is damaged.
fn belongs_to_a_solid(word: &[u8]) -> bool {
    let words = [&b"facet"[..], b"outer", b"vertex", b"endloop", b"endfacet"];
    words.contains(&word) || b"solid".starts_with(word)
}

/// A line that is empty or begins as comments do.
fn is_comment(line: &[u8]) -> bool {
    let line = line.trim_ascii();
    line.is_empty() || matches!(line[0], b'#' | b';' | b'!') || line.starts_with(b"//")
}

/// A text file as one solid in lower case with normals of zero, line by line; lines end as on any system.
///
/// Comments, and what stands behind the last solid, are passed over and counted. A read never goes beyond a line, so that a parser that complains has just been given the line that is wrong.
pub(crate) struct Lines<R> {
    file: R,
    /// What the parser is given: the line at hand as rewritten, and how much of it has been read.
    line: Vec<u8>,
    given: usize,
    /// Lines of the file read so far.
    number: u64,
    stage: Stage,
    /// Whether the line before ended with a carriage return.
    after_return: bool,
    /// Solids that have ended.
    solids: u64,
    /// Lines that were passed over: comments, and others behind a solid.
    comments: u64,
    behind: u64,
    /// Whether a mark of the encoding stood first.
    marked: bool,
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
    pub(crate) fn new(file: R) -> Self {
        let (line, given, number, stage) = (Vec::new(), 0, 0, Stage::Start);
        Self { file, line, given, number, stage, after_return: false, solids: 0, comments: 0, behind: 0, marked: false }
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
        if self.read_line()? == 0 {
            // A file that ends within a solid gets no end: it is truncated.
            if self.stage == Stage::Outside {
                self.line.extend(b"endsolid\n");
                self.stage = Stage::End;
            }
            return Ok(());
        }
        if self.line.len() > LONGEST_LINE {
            return wrong();
        }
        if self.number == 1 && self.line.starts_with(MARK) {
            self.line.drain(..MARK.len());
            self.marked = true;
        }
        self.line.make_ascii_lowercase();
        join_end(&mut self.line);
        let word = self.line.trim_ascii_start();
        let word = &word[..word.iter().position(u8::is_ascii_whitespace).unwrap_or(word.len())];
        let (stage, rewritten) = match (word, self.stage) {
            (b"solid", Stage::Outside | Stage::Solid) => (Stage::Solid, Some("\n")),
            (b"endsolid", Stage::Outside | Stage::Solid) => (Stage::Outside, Some("\n")),
            (b"facet", Stage::Solid) => (Stage::Facet, Some("facet normal 0 0 0\n")),
            (b"endfacet", Stage::Facet) => (Stage::Solid, None),
            (b"", stage) => (stage, None),
            (_, stage) if is_comment(&self.line) => {
                self.comments += 1;
                (stage, Some("\n"))
            }
            (_, stage @ Stage::Facet) => (stage, None),
            (word, stage @ Stage::Outside) if self.solids > 0 && !belongs_to_a_solid(word) => {
                self.behind += 1;
                (stage, Some("\n"))
            }
            _ => return wrong(),
        };
        self.solids += u64::from(stage == Stage::Outside && self.stage == Stage::Solid);
        self.stage = stage;
        if let Some(rewritten) = rewritten {
            self.line.clear();
            self.line.extend(rewritten.as_bytes());
        }
        Ok(())
    }

    /// Reads a line and its end into `line`; its end becomes that of Unix. How many bytes that took.
    fn read_line(&mut self) -> io::Result<usize> {
        let mut taken = 0;
        loop {
            let bytes = self.file.fill_buf()?;
            if bytes.is_empty() {
                return Ok(taken);
            }
            // The second half of an end of Windows.
            if taken == 0 && self.after_return && bytes[0] == b'\n' {
                self.after_return = false;
                self.file.consume(1);
                continue;
            }
            let end = bytes.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
            let whole = end.unwrap_or(bytes.len());
            // Of a line that is too long, enough to see that.
            let room = (LONGEST_LINE + 1).saturating_sub(self.line.len());
            self.line.extend(&bytes[..whole.min(room)]);
            self.after_return = end.is_some_and(|end| bytes[end] == b'\r');
            let used = whole + usize::from(end.is_some());
            self.file.consume(used);
            taken += used;
            if end.is_some() {
                self.line.push(b'\n');
                return Ok(taken);
            }
        }
    }

    /// What was passed over, as sentences.
    pub(crate) fn notes(&self) -> Vec<String> {
        let lines = |count: u64| if count == 1 { "line".to_owned() } else { "lines".to_owned() };
        let mut notes = Vec::new();
        if self.comments > 0 {
            notes.push(format!(
                "{} {} of comment in the text STL were passed over.",
                self.comments,
                lines(self.comments)
            ));
        }
        if self.behind > 0 {
            notes.push(format!(
                "{} {} behind the text STL's last solid were left out.",
                self.behind,
                lines(self.behind)
            ));
        }
        if self.marked {
            notes.push("A mark of encoding before the text STL was passed over.".into());
        }
        notes
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
        (self.after_return, self.marked) = (false, false);
        (self.solids, self.comments, self.behind) = (0, 0, 0);
        Ok(0)
    }
}

/// The parser looks at the first line and goes back to the start; nobody goes anywhere else.
fn only_to_start(to: SeekFrom) -> io::Result<()> {
    if to == SeekFrom::Start(0) { Ok(()) } else { Err(io::ErrorKind::Unsupported.into()) }
}
