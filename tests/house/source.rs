//! The Rust files of `src` as text, and the little of their grammar that the rules need.

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The folder of the repository.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// One file of `src`.
pub struct Source {
    /// From the folder of the repository, with slashes.
    pub path: String,
    pub text: String,
    /// The text with every comment, string and character literal blanked out, byte for byte in the same places.
    pub code: String,
}

impl Source {
    pub fn read(path: &Path) -> Self {
        let text = fs::read_to_string(path).unwrap();
        let path = path.strip_prefix(root()).unwrap().to_string_lossy().replace('\\', "/");
        let code = blanked(&text);
        Self { path, text, code }
    }

    /// Whether the whole file is tests.
    pub fn is_tests(&self) -> bool {
        let stem = Path::new(&self.path).file_stem().unwrap().to_string_lossy();
        stem == "tests" || stem.ends_with("_tests")
    }

    /// The code without what only tests see.
    pub fn shipped(&self) -> String {
        let mut code = self.code.clone();
        while let Some(at) = code.find("#[cfg(test)]") {
            // Up to the end of the item: its brace or its semicolon, whichever opens first.
            let rest = &code[at..];
            let end = match (rest.find('{'), rest.find(';')) {
                (Some(brace), semicolon) if semicolon.is_none_or(|semicolon| brace < semicolon) => {
                    at + brace + matched(&rest[brace..])
                }
                (_, Some(semicolon)) => at + semicolon + 1,
                _ => code.len(),
            };
            code.replace_range(at..end, &blank(&code[at..end]));
        }
        code
    }

    /// Line number of a place in the text.
    pub fn line(&self, at: usize) -> usize {
        self.text[..at].matches('\n').count() + 1
    }
}

/// Every Rust file below `src`, sorted.
pub fn sources() -> Vec<Source> {
    let mut open = vec![root().join("src")];
    let mut paths: Vec<PathBuf> = Vec::new();
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if entry.is_dir() {
                open.push(entry);
            } else if entry.extension().is_some_and(|extension| extension == "rs") {
                paths.push(entry);
            }
        }
    }
    paths.sort();
    assert!(paths.len() > 100, "only {} files in src", paths.len());
    paths.iter().map(|path| Source::read(path)).collect()
}

/// Length of the bracketed text that begins at the start of `code`, both brackets counted.
pub fn matched(code: &str) -> usize {
    let mut depth = 0;
    for (at, byte) in code.bytes().enumerate() {
        match byte {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return at + 1;
        }
    }
    code.len()
}

/// Identifiers of blanked code with their places.
pub fn identifiers(code: &str) -> impl Iterator<Item = (usize, &str)> {
    let word = |c: char| c.is_alphanumeric() || c == '_';
    let mut at = 0;
    std::iter::from_fn(move || {
        let start = at + code[at..].find(word)?;
        let length = code[start..].find(|c| !word(c)).unwrap_or(code.len() - start);
        at = start + length;
        Some((start, &code[start..at]))
    })
    .filter(|(_, name)| !name.starts_with(|c: char| c.is_ascii_digit()))
}

/// Spaces in place of all but line ends, byte for byte.
fn blank(text: &str) -> String {
    text.bytes().map(|byte| if byte == b'\n' { '\n' } else { ' ' }).collect()
}

/// `text` with comments, strings and character literals blanked out.
fn blanked(text: &str) -> String {
    let bytes = text.as_bytes();
    let mut code = bytes.to_vec();
    let mut at = 0;
    while at < bytes.len() {
        let end = hidden(text, at);
        if end > at {
            let Range { start, end } = at..end;
            for byte in &mut code[start..end] {
                *byte = if *byte == b'\n' { b'\n' } else { b' ' };
            }
            at = end;
        } else {
            at += 1;
        }
    }
    String::from_utf8(code).unwrap()
}

/// Where the comment or literal that begins at `at` ends; `at` itself if none begins there.
fn hidden(text: &str, at: usize) -> usize {
    let rest = &text.as_bytes()[at..];
    let within_word = at > 0 && matches!(text.as_bytes()[at - 1], b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'_');
    let until = |end: &str, from: usize| {
        let tail = &text.as_bytes()[at + from..];
        let found = tail.windows(end.len()).position(|window| window == end.as_bytes());
        found.map_or(text.len(), |found| at + from + found + end.len())
    };
    match rest {
        [b'/', b'/', ..] => until("\n", 0),
        [b'/', b'*', ..] => until("*/", 2),
        [b'"', ..] => at + quoted(rest),
        [b'r', b'"' | b'#', ..] if !within_word => {
            let hashes = rest[1..].iter().take_while(|byte| **byte == b'#').count();
            if rest.get(1 + hashes) == Some(&b'"') {
                until(&format!("\"{}", "#".repeat(hashes)), 2 + hashes)
            } else {
                at
            }
        }
        // A lifetime has no closing quote after its first character.
        [b'\'', b'\\', ..] => until("'", 3),
        [b'\'', ..] => {
            let mut characters = text[at + 1..].char_indices().skip(1);
            match characters.next() {
                Some((length, '\'')) => at + length + 2,
                _ => at,
            }
        }
        _ => at,
    }
}

/// Length of the string literal that `rest` begins with.
fn quoted(rest: &[u8]) -> usize {
    let mut at = 1;
    while at < rest.len() {
        match rest[at] {
            b'\\' => at += 2,
            b'"' => return at + 1,
            _ => at += 1,
        }
    }
    rest.len()
}
