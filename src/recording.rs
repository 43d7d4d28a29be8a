//! `regatta record`, `replay`, `export`, `plot` and `info`: recordings of fleets.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use regatta_record::{ExportArgs, PlotArgs, RecordArgs, ReplayArgs};

use crate::failure::{Failure, plugin_failure};

pub fn record(args: &RecordArgs) -> Result<ExitCode, Failure> {
    regatta_record::record(args).map_err(plugin_failure)?;
    Ok(ExitCode::SUCCESS)
}

pub fn replay(args: &ReplayArgs) -> Result<ExitCode, Failure> {
    regatta_record::replay(args)?;
    Ok(ExitCode::SUCCESS)
}

pub fn export(args: &ExportArgs) -> Result<ExitCode, Failure> {
    println!("{}", regatta_record::export(args)?);
    Ok(ExitCode::SUCCESS)
}

pub fn plot(args: &PlotArgs) -> Result<ExitCode, Failure> {
    println!("{}", regatta_record::plot(args)?);
    Ok(ExitCode::SUCCESS)
}

/// Options of `regatta info`.
#[derive(Args)]
pub struct InfoArgs {
    /// The recording
    file: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn info(args: &InfoArgs) -> Result<ExitCode, Failure> {
    let info = regatta_record::info(&args.file)?;
    match args.json {
        true => println!("{}", serde_json::to_string_pretty(&info)?),
        false => print!("{info}"),
    }
    Ok(ExitCode::SUCCESS)
}
