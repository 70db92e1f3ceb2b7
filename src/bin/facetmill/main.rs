//! The command line: arguments to a recipe, the recipe to a plate, the plate to files.

// In reading order: each imports only from those above it.

mod files;

mod wrapping;

mod rows;

mod wall_tables;

mod tables;

mod values;

mod args;

mod console;

mod stages;

mod inputs;

mod ranges;

mod plates;

mod interrupt;

mod snapshots;

mod help;

mod usage;

mod manual;

mod measure;

mod fit;

mod machining;

mod cutters;

mod astray;

mod in_room;

mod dry_run;

mod portrait;

mod against;

mod portrait_proof;

mod verify;

mod mill_tables;

mod drawn;

mod program_check;

mod mill;

mod coupon_reading;

mod coupon;

mod design;

mod plan;

use std::process::ExitCode;
use std::sync::Arc;

use clap::FromArgMatches;
use facetmill::job::clock::on_own_threads;

use args::{Cli, Command, RunningArgs};
use console::{Failure, report_failure};
use interrupt::Run;

fn main() -> ExitCode {
    let all = std::env::args_os().any(|word| word == help::ALL);
    let parsed = help::command(all).try_get_matches().and_then(|matches| Cli::from_arg_matches(&matches));
    let cli = match parsed {
        Ok(cli) => cli,
        Err(error) => return ExitCode::from(usage::answer(&error)),
    };
    let running = match &cli.command {
        Command::Design(args) => &args.running,
        Command::Verify(args) => &args.running,
        Command::Measure(args) => &args.running,
        Command::Plan(args) => &args.running,
        Command::Mill(args) => &args.running,
        Command::Coupon(args) => &args.running,
        Command::Fit(args) => &args.running,
        Command::Cutters(args) => return answered(cutters::run(args), args.json),
        Command::Completions { shell } => return manual::written(manual::completions(*shell)),
        Command::Man => return manual::written(manual::page()),
    };
    work(&cli.command, running)
}

/// The exit code of what was done; why it was not is told first.
fn answered(done: Result<(), Failure>, to_json: bool) -> ExitCode {
    done.map_or_else(|failure| ExitCode::from(report_failure(&failure, to_json)), |()| ExitCode::SUCCESS)
}

/// Does what the command says.
fn work(command: &Command, running: &RunningArgs) -> ExitCode {
    let to_json = running.json;
    let run = Arc::new(Run::default());
    let interrupted = run.clone();
    // Without a handler Ctrl-C still ends the program, only less tidily.
    let _ = ctrlc::set_handler(move || interrupted.interrupted(to_json));
    interrupt::catch_size_limit();
    let work = || {
        console::tell_threads(running);
        match command {
            Command::Design(args) => design::run(args, &run),
            Command::Verify(args) => verify::run(args, &run),
            Command::Measure(args) => measure::run(args, &run),
            Command::Plan(args) => plan::run(args, &run),
            Command::Mill(args) => mill::run(args, &run),
            Command::Coupon(args) => coupon::run(args, &run),
            Command::Fit(args) => fit::run(args, &run),
            Command::Cutters(_) | Command::Completions { .. } | Command::Man => Ok(()),
        }
    };
    let done = match on_own_threads(running.threads, work) {
        Ok((done, _)) => done,
        Err(error) => Err(Failure::Impossible(format!("no thread can be started ({error}): end other programs"))),
    };
    if done.is_err() {
        run.clear_progress();
    }
    answered(done, to_json)
}
