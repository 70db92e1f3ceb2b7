//! A line of G-code cut into its words: a letter and a number each.
//!
//! Blanks mean nothing, within numbers either, as in LinuxCNC and GRBL; small letters are capitals; what stands in ( ) or
//! behind a ; is a comment, in whatever encoding.

/// A letter and its number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Word {
    /// A capital.
    pub letter: char,
    pub value: f64,
}

/// What a line is besides its words.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Marks {
    /// It is a %, which begins or ends a tape.
    pub tape: bool,
    /// It begins with /, so that a switch of the control leaves it out.
    pub deletable: bool,
}

/// Characters of the longest number that is read: far beyond what a double tells apart.
const LONGEST_NUMBER: usize = 40;

/// Fills `words` with those of `line`.
pub(super) fn cut(line: &[u8], words: &mut Vec<Word>) -> Result<Marks, WordFault> {
    words.clear();
    let mut marks = Marks::default();
    let mut at = 0;
    while let Some(&byte) = line.get(at) {
        at += 1;
        match byte {
            b' ' | b'\t' => {}
            b'(' => at = past_comment(line, at)?,
            b';' => break,
            b'/' if words.is_empty() && !marks.deletable => marks.deletable = true,
            b'%' if words.is_empty() => {
                marks.tape = true;
                return Ok(marks);
            }
            letter if letter.is_ascii_alphabetic() => {
                let letter = char::from(letter.to_ascii_uppercase());
                let (value, end) = number(line, at, letter)?;
                words.push(Word { letter, value });
                at = end;
            }
            other => return Err(unexpected(other)),
        }
    }
    Ok(marks)
}

/// The place behind the comment whose inside begins at `from`.
fn past_comment(line: &[u8], from: usize) -> Result<usize, WordFault> {
    match line[from..].iter().position(|byte| matches!(byte, b'(' | b')')) {
        Some(length) if line[from + length] == b')' => Ok(from + length + 1),
        Some(_) => Err(WordFault::NestedComment),
        None => Err(WordFault::OpenComment),
    }
}

/// The number of a word whose letter ends at `from`, and the place behind it.
fn number(line: &[u8], from: usize, letter: char) -> Result<(f64, usize), WordFault> {
    let mut digits = [0; LONGEST_NUMBER];
    let (mut length, mut at) = (0, from);
    while let Some(&byte) = line.get(at) {
        match byte {
            b' ' | b'\t' => {}
            b'0'..=b'9' | b'.' | b'+' | b'-' => {
                *digits.get_mut(length).ok_or(WordFault::LongNumber(letter))? = byte;
                length += 1;
            }
            // A comment may stand between a letter and its number in no dialect.
            b'#' | b'[' => return Err(unexpected(byte)),
            _ => break,
        }
        at += 1;
    }
    let text = std::str::from_utf8(&digits[..length]).unwrap_or_default();
    if length == 0 {
        // O<name> and such are words of programs that compute.
        return Err(if letter == 'O' { WordFault::Computes('O') } else { WordFault::NoNumber(letter) });
    }
    if letter == 'O' && line[at..].first().is_some_and(u8::is_ascii_alphabetic) {
        return Err(WordFault::Computes('O'));
    }
    let value = text.parse().map_err(|_| WordFault::Number(letter, text.to_owned()))?;
    Ok((value, at))
}

fn unexpected(byte: u8) -> WordFault {
    match byte {
        b'#' | b'[' | b'=' | b'<' => WordFault::Computes(char::from(byte)),
        b'$' | b'!' | b'~' | b'?' => WordFault::Command(char::from(byte)),
        b'%' | b'/' => WordFault::NotFirst(char::from(byte)),
        b')' => WordFault::NoComment,
        _ if byte.is_ascii_graphic() => WordFault::Stray(char::from(byte)),
        _ => WordFault::Byte(byte),
    }
}

/// A line that cannot be cut into words.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WordFault {
    /// A ( without its ).
    #[error("a comment that begins with ( is not closed: add ) in the same line")]
    OpenComment,
    /// A ( within ( ).
    #[error("a comment holds a second (: controls end it at the first ), so write the inner one otherwise")]
    NestedComment,
    /// A ) without its (.
    #[error("a ) stands there that no ( begins: make the comment whole")]
    NoComment,
    /// A letter without a number.
    #[error("{0} has no number: write one behind it, or leave the letter out")]
    NoNumber(char),
    /// A number that is none.
    #[error("{0}{1} is no number: digits, one point and a sign in front will do")]
    Number(char, String),
    /// A number of too many digits.
    #[error("the number of {0} has more than {LONGEST_NUMBER} characters: ten would do")]
    LongNumber(char),
    /// Variables, expressions, subprograms.
    #[error(
        "'{0}' makes the control compute (variables, expressions, O words), which is not read: post the program with plain numbers"
    )]
    Computes(char),
    /// A command to the control.
    #[error(
        "'{0}' is a command or setting of a control, not of a program: take the line out and set it at the machine"
    )]
    Command(char),
    /// A sign that means something at the start of a line only.
    #[error("'{0}' stands within the line: it belongs to its start, or into a comment")]
    NotFirst(char),
    /// Any other character.
    #[error("'{0}' is no word: put it into a comment, or take it out")]
    Stray(char),
    /// Any other byte.
    #[error("a byte {0:#04x} stands outside comments: save the program as plain text (ASCII)")]
    Byte(u8),
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(line: &str) -> Result<String, WordFault> {
        let mut words = Vec::new();
        let marks = cut(line.as_bytes(), &mut words)?;
        let marked = [(marks.deletable, "/"), (marks.tape, "%")];
        let marked: String = marked.iter().filter(|(is, _)| *is).map(|(_, mark)| *mark).collect();
        Ok(marked + &words.iter().map(|word| format!("{}{}", word.letter, word.value)).collect::<Vec<_>>().join(" "))
    }

    #[test]
    fn words_are_found_however_they_are_spaced() {
        for (line, words) in [
            ("", ""),
            ("  (only ; a comment) ", ""),
            ("N0010g1x-.5y+2.z 1 2.5(up)F 100 ; fast (", "N10 G1 X-0.5 Y2 Z12.5 F100"),
            ("/G90.1", "/G90.1"),
            (" / N5 M3", "/N5 M3"),
            ("% tape", "%"),
            ("G1(a)(b)X1", "G1 X1"),
            ("(gr\u{fc}n \u{b5}m)X1", "X1"),
        ] {
            assert_eq!(read(line).as_deref(), Ok(words), "{line}");
        }
    }

    #[test]
    fn what_is_no_word_is_named() {
        for (line, fault) in [
            ("G1 X", WordFault::NoNumber('X')),
            ("GX1", WordFault::NoNumber('G')),
            ("X1.2.3", WordFault::Number('X', "1.2.3".into())),
            ("X--1", WordFault::Number('X', "--1".into())),
            ("X.", WordFault::Number('X', ".".into())),
            ("X1-2", WordFault::Number('X', "1-2".into())),
            ("X#1", WordFault::Computes('#')),
            ("#1=5", WordFault::Computes('#')),
            ("X[1+2]", WordFault::Computes('[')),
            ("o<drill> call", WordFault::Computes('O')),
            ("$H", WordFault::Command('$')),
            ("G1 /X1", WordFault::NotFirst('/')),
            ("//G1", WordFault::NotFirst('/')),
            ("X1 %", WordFault::NotFirst('%')),
            ("(a", WordFault::OpenComment),
            ("(a (b) c)", WordFault::NestedComment),
            ("a)", WordFault::NoNumber('A')),
            ("X1)", WordFault::NoComment),
            ("X1 * 2", WordFault::Stray('*')),
            ("X1 \u{fc}", WordFault::Byte(0xc3)),
        ] {
            assert_eq!(read(line), Err(fault), "{line}");
        }
        assert_eq!(read(&format!("X{}", "1".repeat(41))), Err(WordFault::LongNumber('X')));
    }
}
