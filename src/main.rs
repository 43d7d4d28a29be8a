//! The command line of Regatta: one binary, many processes.

mod cli;
mod control;
mod demo;
mod doctor;
mod engine;
mod graph;
mod pipe;
mod plugin;
mod recording;
mod report;
mod run;
mod supervisor;
mod top;
mod viewer;

use std::process::ExitCode;

use clap::Parser;

use cli::{Cli, Command};

/// What went wrong, for a person: one line that says what to do, and its causes for `-v`.
type Failure = Box<dyn std::error::Error + Send + Sync>;

/// The contract's catch-all error is one line already.
fn plugin_failure(error: regatta_plugin::Error) -> Failure {
    error.to_string().into()
}

fn main() -> ExitCode {
    pipe::hush_broken();
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return cli::explain(&error),
    };
    cli::start_logging(cli.verbose);
    let verbose = cli.verbose > 0;
    match std::panic::catch_unwind(|| dispatch(cli)) {
        Ok(Ok(code)) => code,
        Ok(Err(failure)) => {
            cli::print_failure(&*failure, verbose);
            ExitCode::FAILURE
        }
        Err(panic) if pipe::is_broken(&*panic) => pipe::exit_code(&*panic),
        Err(panic) => std::panic::resume_unwind(panic),
    }
}

fn dispatch(cli: Cli) -> Result<ExitCode, Failure> {
    match cli.command.unwrap_or_default() {
        Command::Run(args) => run::run(args),
        Command::Engine(args) => engine::run(args),
        Command::Plugin(args) => plugin::run(args),
        Command::Viewer(options) => viewer::run(&options),
        Command::Graph { command } => graph::run(command),
        Command::Pause(target) => control::pause(&target),
        Command::Resume(target) => control::resume(&target),
        Command::Step { ticks, target } => control::step(ticks, &target),
        Command::Speed { speed, target } => control::speed(speed, &target),
        Command::Seek { time, target } => control::seek(*time, &target),
        Command::Robots { robots, target } => control::robots(robots, &target),
        Command::Status { json, target } => control::status(json, &target),
        Command::Record(args) => recording::record(&args),
        Command::Replay(args) => recording::replay(&args),
        Command::Export(args) => recording::export(&args),
        Command::Plot(args) => recording::plot(&args),
        Command::Top(target) => top::run(&target),
        Command::Report { command } => report::run(command),
        Command::Doctor(args) => doctor::run(args),
        Command::Completions { shell } => {
            cli::print_completions(shell);
            Ok(ExitCode::SUCCESS)
        }
    }
}
