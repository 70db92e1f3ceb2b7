//! The command line: arguments to a recipe, the recipe to a plate, the plate to files.

mod args;
mod console;
mod design;
mod files;
mod outputs;
mod verify;

use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Parser;

use args::{Cli, Command};

/// Raised by Ctrl-C.
static STOP: AtomicBool = AtomicBool::new(false);

fn main() -> ExitCode {
    let cli = Cli::parse();
    // Without a handler Ctrl-C still ends the program, only less tidily.
    let _ = ctrlc::set_handler(|| {
        if STOP.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    });
    let running = match &cli.command {
        Command::Design(args) => &args.running,
        Command::Verify(args) => &args.running,
    };
    if let Some(threads) = running.threads {
        // Fails only if a pool exists already, and none does yet.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global();
    }
    let done = match &cli.command {
        Command::Design(args) => design::run(args),
        Command::Verify(args) => verify::run(args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => console::report_failure(&failure, running.json),
    }
}
