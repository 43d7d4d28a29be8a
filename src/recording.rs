//! `regatta record | replay`: recordings of fleets.

use std::process::ExitCode;

use regatta_record::{RecordArgs, ReplayArgs};

use crate::Failure;

pub fn record(args: &RecordArgs) -> Result<ExitCode, Failure> {
    regatta_record::record(args).map_err(crate::plugin_failure)?;
    Ok(ExitCode::SUCCESS)
}

pub fn replay(args: &ReplayArgs) -> Result<ExitCode, Failure> {
    regatta_record::replay(args)?;
    Ok(ExitCode::SUCCESS)
}
