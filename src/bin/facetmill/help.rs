//! How much the help shows: the flags that most people need, or all.

use clap::{Arg, ArgAction, Command, CommandFactory};

use crate::args::Cli;

/// The flag that asks for all.
pub const ALL: &str = "--help-all";

/// Flags that `--help` shows, for each command; what is not a flag is always shown. A command that is not here has few.
const MOST_NEEDED: [(&str, &[&str]); 5] = [
    (
        "design",
        &[
            "output",
            "goal",
            "portrait",
            "viewer",
            "size",
            "half-field",
            "for-cutter",
            "machine",
            "light",
            "seen",
            "invert",
            "lamp-at",
            "wall",
            "cells",
            "thickness",
            "border",
            "facets",
            "max-triangles",
            "recipe",
            "dry_run",
            "force",
            "verbose",
        ],
    ),
    (
        "verify",
        &[
            "against",
            "output",
            "at_most",
            "half-field",
            "light",
            "seen",
            "flip",
            "up",
            "unit",
            "margin",
            "mount",
            "machine",
            "rays",
            "force",
            "verbose",
        ],
    ),
    (
        "measure",
        &[
            "output",
            "brdf",
            "ndf",
            "wall",
            "look",
            "material",
            "light",
            "light-radius",
            "lamp_distance",
            "wrap",
            "camera",
            "rays",
            "error",
            "resolution",
            "force",
            "verbose",
        ],
    ),
    (
        "mill",
        &[
            "output",
            "machine",
            "dialect",
            "cutter",
            "stepover",
            "polish",
            "material",
            "stock_over",
            "rough_cutter",
            "force",
            "verbose",
        ],
    ),
    (
        "plan",
        &[
            "output",
            "machine",
            "hours",
            "wanted",
            "polish_tolerance",
            "size",
            "cells",
            "for-cutter",
            "polish",
            "half-field",
            "light",
            "seen",
            "invert",
            "force",
            "verbose",
        ],
    ),
];

/// The command line with the help that `--help` shows, or with all of it.
pub fn command(all: bool) -> Command {
    let mut command = Cli::command();
    for (name, shown) in MOST_NEEDED {
        command = command.mut_subcommand(name, |command| {
            let is_short = |arg: &Arg| !all && !arg.is_positional() && !shown.contains(&arg.get_id().as_str());
            let command = command.mut_args(|arg| if is_short(&arg) { arg.hide(true) } else { arg });
            command.arg(help_all(all))
        });
    }
    // Elsewhere it is the same as --help, so that nobody who asks for it is turned away.
    let few = |name: &str| !MOST_NEEDED.iter().any(|(most, _)| *most == name);
    command =
        command.mut_subcommands(
            |command| {
                if few(command.get_name()) { command.arg(help_all(all).hide(true)) } else { command }
            },
        );
    command.arg(help_all(all).hide(true))
}

/// The flag that asks for all; where it is not there, nothing hangs on it.
fn help_all(all: bool) -> Arg {
    let action = if all { ArgAction::HelpLong } else { ArgAction::SetTrue };
    let flag = Arg::new("help_all").long("help-all").action(action);
    flag.help("Print help with every flag, by groups").display_order(1000)
}

/// Whether `command` has this flag.
pub fn has_flag(name: &str, flag: &str) -> bool {
    let command = command(true);
    let flags = command.find_subcommand(name).into_iter().flat_map(Command::get_arguments);
    flags.filter_map(Arg::get_long).any(|long| Some(long) == flag.strip_prefix("--"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_short_help_shows_a_dozen_flags_and_the_long_one_all() {
        for (name, shown) in MOST_NEEDED {
            let help = |all: bool| {
                let mut command = command(all);
                command.find_subcommand_mut(name).unwrap().render_long_help().to_string()
            };
            // Words that a flag takes stand behind a dash and a blank.
            let is_flag = |line: &&str| line.trim_start().starts_with('-') && !line.trim_start().starts_with("- ");
            let flags = |text: &str| text.lines().filter(is_flag).count();
            let (short, long) = (help(false), help(true));
            assert!(flags(&short) <= shown.len() + 3 && flags(&short) >= 10, "{name}: {short}");
            assert!(flags(&long) > flags(&short), "{name}");
            assert!(short.contains("--help-all"), "{short}");
            for flag in shown {
                let flag = format!("--{}", flag.replace('_', "-"));
                assert!(short.contains(&flag) && long.contains(&flag), "{name}: {flag}");
            }
        }
    }
}
