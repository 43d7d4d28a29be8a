//! `regatta report`: measures accuracy and speed on a real engine process with a reader attached.
//! Every report writes Markdown and JSON; most also draw an SVG plot.

mod accuracy;
mod experiment;
mod management;
mod output;
mod plot;
mod published;
mod scaling;
mod study;
mod udp;

use std::process::ExitCode;

use clap::Subcommand;

use crate::failure::Failure;
use output::Output;

/// Returns the parser of the time that each load is measured for, in seconds.
fn seconds_parser() -> clap::builder::RangedU64ValueParser {
    clap::value_parser!(u64).range(1..=86_400)
}

/// A subcommand of `regatta report`.
#[derive(Subcommand)]
pub enum ReportCommand {
    /// Drive the routes of the dissertation's tables 5.1 and 5.3, and compare the end poses.
    Accuracy(Output),
    /// Measure the fleet manager: throughput, contacts, effort, with disturbances too.
    Management(management::ManagementArgs),
    /// Repeat the dissertation's tables 5.5 to 5.7, and continue to a million robots.
    Scaling(scaling::ScalingArgs),
    /// Measure studies: a hundred runs, the knee of a warehouse, and whether they repeat.
    Study(study::StudyReportArgs),
    /// Send fleets over UDP into a second fleet: lines per second, losses, processor time.
    Udp(udp::UdpArgs),
}

pub fn run(command: ReportCommand) -> Result<ExitCode, Failure> {
    match command {
        ReportCommand::Accuracy(output) => accuracy::run(&output),
        ReportCommand::Management(args) => management::run(&args),
        ReportCommand::Scaling(args) => scaling::run(&args),
        ReportCommand::Study(args) => study::run(&args),
        ReportCommand::Udp(args) => udp::run(&args),
    }
}
