//! The manual page, and what shells need to complete flags.

use std::process::ExitCode;

use clap_complete::Shell;
use clap_mangen::Man;

use crate::console::{Failure, print, report_failure};
use crate::help;

/// The script that completes this program's flags in `shell`.
pub fn completions(shell: Shell) -> Vec<u8> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut help::command(true), "facetmill", &mut script);
    script
}

/// The manual page: the program, then each command with all of its flags, in the language of man.
pub fn page() -> Vec<u8> {
    let mut command = help::command(true);
    command.build();
    let mut page = Vec::new();
    // Writing into memory fails for no reason.
    let _ = Man::new(command.clone()).render(&mut page);
    for inner in command.get_subcommands().filter(|inner| inner.get_name() != "help") {
        let man = Man::new(inner.clone());
        page.extend(format!(".SH FACETMILL {}\n", inner.get_name().to_uppercase()).as_bytes());
        let _ = man.render_synopsis_section(&mut page);
        let _ = man.render_description_section(&mut page);
        let _ = man.render_options_section(&mut page);
        let _ = man.render_extra_section(&mut page);
    }
    page
}

/// To standard output; the exit code.
pub fn written(bytes: Vec<u8>) -> ExitCode {
    match print(&String::from_utf8_lossy(&bytes)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => ExitCode::from(report_failure(&Failure::Output(error), false)),
    }
}
