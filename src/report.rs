//! `regatta report`: measures accuracy and speed on a real engine process with a reader attached.
//! Every report writes Markdown, JSON and an SVG plot.

mod accuracy;
mod published;
mod scaling;

use std::process::ExitCode;

use clap::Subcommand;

use crate::experiment::report::Output;
use crate::experiment::{temporary_folder, write};
use crate::failure::Failure;

/// A subcommand of `regatta report`.
#[derive(Subcommand)]
pub enum ReportCommand {
    /// Drive the routes of tables 5.1 and 5.3 of the dissertation, and compare the end poses.
    Accuracy(Output),
    /// Repeat the dissertation's tables 5.5 to 5.7, and continue to a million robots.
    Scaling(scaling::ScalingArgs),
}

pub fn run(command: ReportCommand) -> Result<ExitCode, Failure> {
    match command {
        ReportCommand::Accuracy(output) => accuracy::run(&output),
        ReportCommand::Scaling(args) => scaling::run(&args),
    }
}

/// Creates a folder for an experiment's scenarios that contains the graph `porto.yaml`; it is
/// removed when dropped.
fn folder_with_porto() -> Result<tempfile::TempDir, Failure> {
    let folder = temporary_folder()?;
    write(&folder.path().join("porto.yaml"), include_str!("../graphs/porto.yaml"))?;
    Ok(folder)
}
