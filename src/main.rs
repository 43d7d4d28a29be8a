//! The command line of Regatta. `regatta run` starts the engine, the plugins and the viewer as
//! child processes of this same binary. Each subcommand has a file of its own, which only connects
//! the command line to the crate that does the work.

mod activities;
mod cli;
mod command;
mod control;
mod day;
mod doctor;
mod engine;
mod facilities;
mod fleets;
mod graph;
mod log_lines;
mod new;
mod orders;
mod plugin;
mod processes;
mod recording;
mod report;
mod run;
mod scenario;
mod study;
mod trust;
mod user_files;
mod vda5050;
#[cfg(feature = "viewer")]
mod viewer;

use std::process::ExitCode;

use clap::Parser;
use regatta::{
    arguments, experiment, failure, lockstep_run, output, output_error, program, progress,
    supervisor, version,
};
use regatta_plugin::Control;

use cli::{Cli, Command};
use control::Target;
use failure::{Failure, plugin_failure, print_failure};

fn main() -> ExitCode {
    output_error::silence_panics();
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return cli::print_usage(&error),
    };
    let name = cli.command.as_ref().map_or("regatta", Command::speaker);
    log_lines::start(name.to_owned(), cli.verbose);
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
        Command::Run(args) => return run::run(*args),
        Command::Master(args) => return run::master::run(*args),
        Command::Engine(args) => engine::run(args)?,
        Command::Plugin(args) => plugin::run(args)?,
        #[cfg(feature = "viewer")]
        Command::Viewer(options) => viewer::run(&options)?,
        Command::Graph { command } => return graph::run(command),
        Command::New(args) => new::run(&args)?,
        Command::Pause(target) => control::send(&target, Control::pause)?,
        Command::Resume(target) => control::send(&target, Control::resume)?,
        Command::Step { ticks, target } => control::send(&target, |control| control.step(ticks))?,
        Command::Speed { speed, target } => {
            control::send(&target, |control| control.speed(speed.as_f32()))?;
        }
        Command::Seek { time, target } => control::send(&target, |control| control.seek(time.0))?,
        Command::Robots { command: Some(command), .. } => command::run(command.into())?,
        Command::Robots { robots, target, .. } => {
            let robots = robots.map_or(0, |robots| robots.0);
            control::send(&target, |control| control.robots(robots))?;
        }
        Command::Send { command } => command::run(command)?,
        Command::Status { json, target } => control::status(json, &target)?,
        Command::List { json } => fleets::list(json)?,
        Command::Stop(target) => fleets::stop(&target)?,
        Command::Record(args) => regatta_record::record(&args).map_err(plugin_failure)?,
        Command::Replay(args) => regatta_record::replay(&args)?,
        Command::Info(args) => recording::info(&args)?,
        Command::Export(args) => println!("{}", regatta_record::export(&args)?),
        Command::Plot(args) => println!("{}", regatta_record::plot(&args)?),
        Command::Validate(args) => recording::validate(&args)?,
        Command::Vda5050 { command } => return vda5050::run(&command),
        #[cfg(feature = "zenoh")]
        Command::Mirror { command } => regatta_mirror::run(&command).map_err(plugin_failure)?,
        Command::Top(Target { fleet }) => {
            regatta_metrics::top::run(&fleet).map_err(plugin_failure)?;
        }
        Command::Orders { command } => return orders::run(command),
        Command::Report { command } => return report::run(command),
        Command::Study(args) => return study::run(&args),
        Command::StudyRun(args) => return study::run_single(&args),
        Command::StudyObserve(args) => return study::run_observers(&args),
        Command::Doctor(args) => return doctor::run(args),
        Command::Completions { shell } => cli::print_completions(shell),
        Command::Man { folder, force } => cli::write_man_pages(&folder, force)?,
    }
    Ok(ExitCode::SUCCESS)
}
