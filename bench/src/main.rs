//! `regatta-bench`: measures the bars that the project sets itself, on processes of an executable
//! `regatta`. Every command writes Markdown and JSON; `management` and `scaling` also draw
//! an SVG plot.

mod day;
mod foxglove;
mod least;
mod management;
mod plants;
mod reading;
mod runs;
mod scaling;
mod study;
mod udp;
mod vda5050;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use regatta::failure::Failure;
use regatta::output_error;
use regatta::program::Program;
use regatta_plugin::usage_line;

/// Measure the bars that the project sets itself, on processes of the program `regatta`.
#[derive(Parser)]
#[command(name = "regatta-bench", max_term_width = 100)]
struct Cli {
    /// Program to measure [default: `regatta` beside this program]
    #[arg(long, global = true, value_name = "PATH", value_hint = clap::ValueHint::FilePath)]
    regatta: Option<PathBuf>,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Measure a day of 20,000 orders in one run, and the sums of the parts of each order's time.
    Day(day::DayArgs),
    /// Compare the least fleets that studies find on small plants with runs of all numbers.
    Least(least::LeastArgs),
    /// Measure a fleet live to a client of Foxglove's protocol: frames, their age, processor time.
    Foxglove(foxglove::FoxgloveArgs),
    /// Measure the fleet manager: throughput, contacts, effort, with disturbances too.
    Management(management::ManagementArgs),
    /// Measure planners of the fleet manager on many plants: throughput, standstills, contacts.
    Plants(plants::PlantsArgs),
    /// Measure the time to check files of every format, by their size.
    Reading(reading::ReadingArgs),
    /// Measure single runs of studies: in one process, and as processes.
    Runs(runs::RunsArgs),
    /// Measure how costs grow with robots, threads, edges, readers, and runs of a study.
    Scaling(scaling::ScalingArgs),
    /// Measure studies: a hundred runs, the knee of a warehouse, and whether they repeat.
    Study(study::StudyArgs),
    /// Send fleets over UDP into a second fleet: lines per second, losses, processor time.
    Udp(udp::UdpArgs),
    /// Measure a virtual fleet of VDA 5050 on a broker: processor time, states, orders.
    Vda5050(vda5050::Vda5050Args),
}

fn main() -> ExitCode {
    output_error::silence_panics();
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) if error.use_stderr() => {
            regatta_plugin::tell!(
                "regatta-bench: {}; --help lists all commands and options",
                usage_line(&error)
            );
            return ExitCode::from(2);
        }
        Err(help) => {
            // Printing fails if the reader of a pipe is gone, which isn't an error here.
            let _ = help.print();
            return ExitCode::SUCCESS;
        }
    };
    match std::panic::catch_unwind(|| run(&cli)) {
        Ok(Ok(code)) => code,
        Ok(Err(failure)) => {
            regatta_plugin::tell!("regatta-bench: {failure}");
            ExitCode::FAILURE
        }
        Err(panic) if output_error::caused(&*panic) => output_error::exit_code(&*panic),
        Err(panic) => std::panic::resume_unwind(panic),
    }
}

fn run(cli: &Cli) -> Result<ExitCode, Failure> {
    let program = match &cli.regatta {
        Some(path) => Program::at(path)?,
        None => Program::beside_this()?,
    };
    match &cli.command {
        Command::Day(args) => day::run(&program, args),
        Command::Least(args) => least::run(&program, args),
        Command::Foxglove(args) => foxglove::run(&program, args),
        Command::Management(args) => management::run(&program, args),
        Command::Plants(args) => plants::run(&program, args),
        Command::Reading(args) => reading::run(&program, args),
        Command::Runs(args) => runs::run(&program, args),
        Command::Scaling(args) => scaling::run(&program, args),
        Command::Study(args) => study::run(&program, args),
        Command::Udp(args) => udp::run(&program, args),
        Command::Vda5050(args) => vda5050::run(&program, args),
    }
}
