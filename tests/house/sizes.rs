//! How long a file, a function and a list of parameters may be.

use crate::none;
use crate::source::{identifiers, matched, sources};

const FILE_LINES: usize = 400;
const FUNCTION_LINES: usize = 70;
const PARAMETERS: usize = 5;

/// Functions that are nothing but a table: file and name.
const TABLES: [(&str, &str); 0] = [];

/// A function with a body or without.
struct Function<'a> {
    name: &'a str,
    at: usize,
    public: bool,
    /// `self` not counted.
    parameters: usize,
    /// From `fn` to the closing brace.
    lines: usize,
}

/// Every function in blanked code.
fn functions(code: &str) -> Vec<Function<'_>> {
    let words: Vec<(usize, &str)> = identifiers(code).collect();
    let mut found = Vec::new();
    for pair in words.windows(2).filter(|pair| pair[0].1 == "fn") {
        let ((at, _), (named, name)) = (pair[0], pair[1]);
        // `fn(A) -> B` is a type: its next word does not follow at once.
        if code[at + 2..named].trim() != "" {
            continue;
        }
        let mut open = named + name.len();
        if code[open..].starts_with('<') {
            open += generics(&code[open..]);
        }
        let list = &code[open..open + matched(&code[open..])];
        let after = &code[open + list.len()..];
        // Brackets of a return type or a where clause may come before the body.
        let body = after.find(['{', ';']).filter(|end| after[*end..].starts_with('{'));
        let end = body.map_or(open + list.len(), |body| open + list.len() + body + matched(&after[body..]));
        let before = code[..at].trim_end_matches(['\n', ' ']);
        let line = before.rfind(['\n', ';', '}', '{']).map_or(before, |from| &before[from + 1..]);
        found.push(Function {
            name,
            at,
            public: identifiers(line).any(|(_, word)| word == "pub"),
            parameters: parameters(&list[1..list.len() - 1]),
            lines: code[at..end].matches('\n').count() + 1,
        });
    }
    found
}

/// Length of `<…>` at the start of `code`.
fn generics(code: &str) -> usize {
    let mut depth = 0;
    let mut last = ' ';
    for (at, c) in code.char_indices() {
        match c {
            '<' => depth += 1,
            '>' if last != '-' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return at + 1;
        }
        last = c;
    }
    code.len()
}

/// How many parameters stand in a list, `self` not counted.
fn parameters(list: &str) -> usize {
    let mut depth = 0;
    let mut last = ' ';
    let mut pieces = vec![String::new()];
    for c in list.chars() {
        match c {
            '(' | '[' | '{' | '<' => depth += 1,
            ')' | ']' | '}' => depth -= 1,
            '>' if last != '-' => depth -= 1,
            _ => {}
        }
        if c == ',' && depth == 0 {
            pieces.push(String::new());
        } else {
            pieces.last_mut().unwrap().push(c);
        }
        last = c;
    }
    let is_self =
        |piece: &str| identifiers(piece).find(|(_, word)| *word != "mut").is_some_and(|(_, word)| word == "self");
    pieces.iter().map(|piece| piece.trim()).filter(|piece| !piece.is_empty() && !is_self(piece)).count()
}

#[test]
fn files_functions_and_lists_of_parameters_are_short() {
    let mut offences = Vec::new();
    for file in sources().iter().filter(|file| !file.is_tests()) {
        let lines = file.text.lines().count();
        if lines > FILE_LINES {
            offences.push(format!("{}: {lines} lines", file.path));
        }
        let code = file.shipped();
        for function in functions(&code) {
            let place = format!("{}:{}: {}", file.path, file.line(function.at), function.name);
            let is_table = TABLES.iter().any(|(path, name)| *path == file.path && *name == function.name);
            if function.lines > FUNCTION_LINES && !is_table {
                offences.push(format!("{place} has {} lines", function.lines));
            }
            if function.public && function.parameters > PARAMETERS {
                offences.push(format!("{place} has {} parameters", function.parameters));
            }
        }
    }
    none(offences);
}

#[test]
fn functions_are_measured_as_a_reader_counts() {
    let code = "impl A {\n    pub fn f<F: Fn(u8) -> u8>(&mut self, a: [u8; 3], g: F) -> Vec<(u8, u8)> {\n        g(1)\n    }\n}\n\
                pub(crate) fn h(a: HashMap<u8, u8>, b: fn(u8, u8) -> u8,) where u8: Copy;\nfn last() {}\n";
    let found: Vec<_> = functions(code).iter().map(|f| (f.name, f.public, f.parameters, f.lines)).collect();
    assert_eq!(found, [("f", true, 2, 3), ("h", true, 2, 1), ("last", false, 0, 1)]);
}
