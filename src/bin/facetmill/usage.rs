//! What clap makes of a wrong command line, in one sentence.

use std::io::{self, Write};

use clap::error::ErrorKind;

use crate::console::{Failure, report_failure};
use crate::files::OutputError;

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
            let command = words.iter().find(|word| ["design", "verify", "measure"].iter().any(|name| *word == name));
            let help = command.map_or(String::new(), |command| format!(" {}", command.display()));
            let sentence = format!("{}; see 'facetmill{help} --help'", sentence(&error.render().to_string()));
            report_failure(&Failure::Usage(sentence), words.iter().any(|word| word == "--json"))
        }
    }
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
            ("mill", &["unrecognized subcommand 'mill'"]),
        ] {
            let sentence = said(line);
            assert!(parts.iter().all(|part| sentence.contains(part)), "{line}: {sentence}");
            assert!(!sentence.contains('\n') && !sentence.contains("Usage") && sentence.len() < 200, "{sentence}");
        }
    }
}
