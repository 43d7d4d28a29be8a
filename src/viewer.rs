//! `regatta viewer`: a fleet in 3D, in a window or in pictures.

use std::process::ExitCode;

use regatta_viewer::Options;

use crate::failure::{Failure, plugin_failure};

pub fn run(options: &Options) -> Result<ExitCode, Failure> {
    regatta_viewer::run(options).map_err(plugin_failure)?;
    Ok(ExitCode::SUCCESS)
}
