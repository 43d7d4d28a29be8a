//! `regatta top`: a running fleet, live in a terminal.

use std::process::ExitCode;

use crate::control::Target;
use crate::failure::{Failure, plugin_failure};

pub fn run(target: &Target) -> Result<ExitCode, Failure> {
    regatta_metrics::top::run(&target.fleet).map_err(plugin_failure)?;
    Ok(ExitCode::SUCCESS)
}
