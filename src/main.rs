//! The command line of Regatta. `regatta run` starts the engine, the plugins and the viewer as
//! child processes of this same binary. Each subcommand has a file of its own, which only connects
//! the command line to the crate that does the work.

mod cli;
mod control;
mod doctor;
mod engine;
mod fleets;
mod graph;
mod new;
mod order;
mod orders;
mod plugin;
mod recording;
mod report;
mod run;
mod scenario;
mod study;
mod top;
mod validate;
#[cfg(feature = "viewer")]
mod viewer;

use std::process::ExitCode;

use clap::Parser;
use regatta::{
    arguments, experiment, failure, lockstep_run, output, output_error, program, progress,
    supervisor, version,
};

use cli::{Cli, Command};
use failure::{Failure, print_failure};

fn main() -> ExitCode {
    output_error::silence_panics();
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return cli::print_usage(&error),
    };
    cli::start_logging(cli.verbose);
    let verbose = cli.verbose > 0;
    match std::panic::catch_unwind(|| dispatch(cli)) {
        Ok(Ok(code)) => code,
        Ok(Err(failure)) => {
            print_failure(&*failure, verbose);
            ExitCode::FAILURE
        }
        Err(panic) if output_error::caused(&*panic) => output_error::exit_code(&*panic),
        Err(panic) => std::panic::resume_unwind(panic),
    }
}

fn dispatch(cli: Cli) -> Result<ExitCode, Failure> {
    match cli.command.unwrap_or_default() {
        Command::Run(args) => run::run(args),
        Command::Engine(args) => engine::run(args),
        Command::Plugin(args) => plugin::run(args),
        #[cfg(feature = "viewer")]
        Command::Viewer(options) => viewer::run(&options),
        Command::Graph { command } => graph::run(command),
        Command::New(args) => new::run(&args).map(|()| ExitCode::SUCCESS),
        Command::Pause(target) => control::pause(&target),
        Command::Resume(target) => control::resume(&target),
        Command::Step { ticks, target } => control::step(ticks, &target),
        Command::Speed { speed, target } => control::speed(speed, &target),
        Command::Seek { time, target } => control::seek(time.0, &target),
        Command::Robots { command: Some(command), .. } => order::run(command.into()),
        Command::Robots { robots, target, .. } => {
            control::robots(robots.map_or(0, |robots| robots.0), &target)
        }
        Command::Order { command } => order::run(command),
        Command::Status { json, target } => control::status(json, &target),
        Command::List { json } => fleets::list(json),
        Command::Stop(target) => fleets::stop(&target),
        Command::Record(args) => recording::record(&args),
        Command::Replay(args) => recording::replay(&args),
        Command::Info(args) => recording::info(&args),
        Command::Export(args) => recording::export(&args),
        Command::Plot(args) => recording::plot(&args),
        Command::Validate(args) => validate::run(&args),
        Command::Top(target) => top::run(&target),
        Command::Orders { command } => orders::run(command),
        Command::Report { command } => report::run(command),
        Command::Study(args) => study::run(&args),
        Command::StudyRun(args) => study::run_single(&args),
        Command::StudyObserve(args) => study::run_observers(&args),
        Command::Doctor(args) => doctor::run(args),
        Command::Completions { shell } => {
            cli::print_completions(shell);
            Ok(ExitCode::SUCCESS)
        }
        Command::Man { folder, force } => {
            cli::write_man_pages(&folder, force)?;
            Ok(ExitCode::SUCCESS)
        }
    }
}
