//! `regatta record`, `replay`, `export` and `plot`: recordings of fleets.

use std::process::ExitCode;

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
