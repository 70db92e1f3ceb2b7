//! What clap makes of a wrong command line, in one sentence.

use std::io::{self, Write};

use clap::CommandFactory;
use clap::error::{ContextKind, ContextValue, ErrorKind};

use crate::args::Cli;
use crate::console::{Failure, report_failure};
use crate::files::OutputError;
use crate::help::has_flag;

/// Prints help where it was asked for, else what is wrong; the exit code.
pub fn answer(error: &clap::Error) -> u8 {
    match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => {
            // What was asked for is the page itself: it must come through. A reader that has gone away has read enough.
            match error.print().and_then(|()| io::stdout().flush()) {
                Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
                    report_failure(&OutputError::StandardOutput(error).into(), false)
                }
                _ => 0,
            }
        }
        // No command at all: the page that names them.
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            let _ = error.print();
            2
        }
        _ => {
            let words: Vec<_> = std::env::args_os().skip(1).collect();
            let known = Cli::command();
            let command = words.iter().find(|word| known.get_subcommands().any(|known| *word == known.get_name()));
            let message = error.render().to_string();
            let name = command.and_then(|command| command.to_str()).unwrap_or_default();
            let message = better_hint(error, name).unwrap_or_else(|| sentence(&message));
            let help = command.map_or(String::new(), |command| format!(" {}", command.display()));
            let sentence = format!("{message}; see 'facetmill{help} --help-all'");
            report_failure(&Failure::Usage(sentence), words.iter().any(|word| word == "--json"))
        }
    }
}

/// Words that people try, and the flag that does it.
const MEANT: [(&str, &str); 13] = [
    ("--shape", "--surface"),
    ("--shape", "--wrap"),
    ("--cutter", "--for-cutter"),
    ("--tool", "--for-cutter"),
    ("--width", "--size"),
    ("--angle", "--half-field"),
    ("--fov", "--half-field"),
    ("--depth", "--max-depth"),
    ("--mirror", "--seen"),
    ("--negative", "--invert"),
    ("--triangles", "--max-triangles"),
    ("--rim", "--border"),
    ("--roughness", "--material"),
];

/// What to say of a flag that `command` does not have, where the parser's own guess is far from it.
fn better_hint(error: &clap::Error, command: &str) -> Option<String> {
    if error.kind() != ErrorKind::UnknownArgument {
        return None;
    }
    let text = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => Some(text.clone()),
        Some(ContextValue::Strings(all)) => all.first().cloned(),
        _ => None,
    };
    let tried = text(ContextKind::InvalidArg)?;
    let fits = |(word, flag): &&(&str, &str)| *word == tried && has_flag(command, flag);
    let meant = MEANT.iter().find(fits).map(|(_, flag)| (*flag).to_owned());
    match (meant, text(ContextKind::SuggestedArg)) {
        (Some(flag), _) => Some(format!("there is no {tried}: did you mean {flag}?")),
        (None, Some(guess)) if edits(&tried, &guess) > MOST_EDITS => Some(format!("there is no {tried}")),
        _ => None,
    }
}

/// Letters put in, left out or changed up to which a guess is believed.
const MOST_EDITS: usize = 2;

/// Letters that have to be put in, left out or changed to make one word of the other (Levenshtein's distance).
pub fn edits(from: &str, to: &str) -> usize {
    let to: Vec<char> = to.chars().collect();
    let mut row: Vec<usize> = (0..=to.len()).collect();
    for (i, a) in from.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, b) in to.iter().enumerate() {
            let changed = diagonal + usize::from(a != *b);
            diagonal = row[j + 1];
            row[j + 1] = changed.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[to.len()]
}

/// The paragraphs of clap's message that say what is wrong and what would do, on one line.
fn sentence(message: &str) -> String {
    let telling = |part: &&str| {
        let noise = ["Usage:", "For more information", "tip: to pass"];
        !part.is_empty() && !noise.iter().any(|start| part.starts_with(start))
    };
    let parts = message.split("\n\n").map(str::trim).filter(telling);
    let lines: Vec<String> = parts.map(|part| part.split_whitespace().collect::<Vec<_>>().join(" ")).collect();
    lines.join("; ").trim_start_matches("error: ").to_owned()
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::args::Cli;

    #[test]
    fn a_wrong_command_line_is_one_sentence_with_flag_and_remedy() {
        let said = |line: &str| {
            let words = std::iter::once("facetmill").chain(line.split_whitespace());
            sentence(&Cli::try_parse_from(words).unwrap_err().render().to_string())
        };
        for (line, parts) in [
            ("design a.png", &["required", "--output"][..]),
            ("design a.png -o b --facts 3x3", &["'--facts'", "similar", "'--facets'"]),
            ("design a.png -o b --facets 30", &["'30'", "--facets", "'x' between them", "30x20"]),
            ("design a.png -o b --facets 99999999999999999999x2", &["--facets", "too large"]),
            ("design a.png -o b --facets -3x3", &["--facets", "whole number"]),
            ("design a.png -o b --thickness five", &["--thickness", "such as 12.5"]),
            ("design a.png -o b --sample foo", &["--sample", "voronoi, random, sobol"]),
            ("design a.png -o b --seed -1", &["--seed", "whole number"]),
            ("design a.png -o b --threads 0", &["--threads", "1 to 1024"]),
            ("design a.png -o b --linear --srgb", &["--linear", "--srgb", "cannot be used with"]),
            ("design a.png -o b --size 100x60mm", &["--size", "leave out the unit 'mm' and write 60"]),
            ("design a.png -o b --thickness 5mm", &["--thickness", "leave out the unit 'mm' and write 5"]),
            ("design a.png -o b --half-field 20°", &["--half-field", "leave out the unit '°' and write 20"]),
            ("drill", &["unrecognized subcommand 'drill'"]),
        ] {
            let sentence = said(line);
            assert!(parts.iter().all(|part| sentence.contains(part)), "{line}: {sentence}");
            assert!(!sentence.contains('\n') && !sentence.contains("Usage") && sentence.len() < 200, "{sentence}");
        }
    }

    #[test]
    fn a_flag_that_is_none_is_told_with_what_was_meant_or_with_nothing() {
        let said = |line: &str| {
            let words = std::iter::once("facetmill").chain(line.split_whitespace());
            better_hint(&Cli::try_parse_from(words).unwrap_err(), line.split(' ').next().unwrap())
        };
        let told = |line: &str| said(line).unwrap();
        assert_eq!(told("design a.png -o b --shape round"), "there is no --shape: did you mean --surface?");
        assert_eq!(told("design a.png -o b --cutter ball:1"), "there is no --cutter: did you mean --for-cutter?");
        assert_eq!(told("measure a -o b --shape ball"), "there is no --shape: did you mean --wrap?");
        assert_eq!(said("design a.png -o b --facts 3x3"), None);
        assert_eq!(said("design a.png -o b --thickness five"), None);
        assert_eq!(
            (edits("shape", "sample"), edits("facts", "facets"), edits("", "ab"), edits("a", "a")),
            (3, 1, 2, 0)
        );
    }
}
