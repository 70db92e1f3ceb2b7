//! A checksum in a comment, so that a change of any digit behind it shows.
//!
//! It is CRC-32 (that of Ethernet and ZIP) over every line behind that of the comment, each without blanks and line ends
//! at its end, followed by a line feed, and how many lines that are. Blank lines at the end do not count.

use super::program::Seal;

/// What the comment begins with.
const WORDS: &str = "facetmill checksum ";

/// Checksum of lines and their number.
#[derive(Clone, Default)]
pub(super) struct Sum {
    hasher: crc32fast::Hasher,
    lines: u32,
    /// Blank lines that count only if another follows.
    blank: u32,
}

impl Sum {
    /// Adds a line.
    pub fn add(&mut self, line: &[u8]) {
        let line = line.trim_ascii_end();
        if line.is_empty() {
            self.blank = self.blank.saturating_add(1);
            return;
        }
        for _ in 0..std::mem::take(&mut self.blank) {
            self.hasher.update(b"\n");
            self.lines = self.lines.saturating_add(1);
        }
        self.hasher.update(line);
        self.hasher.update(b"\n");
        self.lines = self.lines.saturating_add(1);
    }

    /// The comment that states it.
    pub fn comment(&self) -> String {
        format!("({WORDS}{:08x} of {} lines)", self.hasher.clone().finalize(), self.lines)
    }
}

/// A checksum that was found, and the one that is formed.
pub(super) struct Reading {
    stated: Vec<u8>,
    sum: Sum,
}

impl Reading {
    /// Takes a line; the reading that goes on with the next.
    pub fn line(reading: Option<Self>, line: &[u8]) -> Option<Self> {
        match reading {
            Some(mut reading) => {
                reading.sum.add(line);
                Some(reading)
            }
            None => {
                let line = line.trim_ascii();
                let states = line.strip_prefix(b"(").is_some_and(|inside| inside.starts_with(WORDS.as_bytes()));
                states.then(|| Self { stated: line.to_vec(), sum: Sum::default() })
            }
        }
    }

    /// What it comes to at the end.
    pub fn seal(reading: Option<&Self>) -> Seal {
        match reading {
            None => Seal::None,
            Some(reading) if reading.sum.comment().as_bytes() == reading.stated => Seal::Whole,
            Some(_) => Seal::Broken,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sealed(body: &str) -> String {
        let mut sum = Sum::default();
        body.lines().for_each(|line| sum.add(line.as_bytes()));
        format!("(first)\n{}\n{body}", sum.comment())
    }

    fn seal(text: &str) -> Seal {
        let reading = text.split('\n').fold(None, |reading, line| Reading::line(reading, line.as_bytes()));
        Reading::seal(reading.as_ref())
    }

    #[test]
    fn every_change_of_a_character_shows_and_line_ends_do_not() {
        let text = sealed("G21\n\nG1 X1.25 F100\nX2.5\nM2\n");
        assert_eq!(seal(&text), Seal::Whole);
        assert_eq!(seal(&text.replace('\n', "\r\n")), Seal::Whole);
        assert_eq!(seal(text.trim_end()), Seal::Whole);
        assert_eq!(seal(&format!("{text}\n \n")), Seal::Whole);
        assert_eq!(seal(&text.replace("(first)", "(other)")), Seal::Whole, "what stands before it is not covered");
        let from = text.find("checksum").unwrap() + 9;
        for at in from..text.trim_end().len() {
            let mut changed = text.clone().into_bytes();
            changed[at] = if changed[at] == b'7' { b'8' } else { b'7' };
            assert_eq!(seal(&String::from_utf8(changed).unwrap()), Seal::Broken, "{at}");
        }
        assert_eq!(seal(&text.replace("X2.5\n", "")), Seal::Broken);
        assert_eq!(seal(&text.replace("X2.5\n", "X2.5\n\n")), Seal::Broken);
        assert_eq!(seal("G21\nM2"), Seal::None);
    }
}
