//! `regatta top`: a running fleet, live in a terminal.

use std::process::ExitCode;

use crate::Failure;
use crate::cli::Target;

pub fn run(target: &Target) -> Result<ExitCode, Failure> {
    regatta_metrics::top::run(&target.fleet).map_err(crate::plugin_failure)?;
    Ok(ExitCode::SUCCESS)
}
