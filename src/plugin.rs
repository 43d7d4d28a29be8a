//! `regatta plugin NAME`: the plugins that come with Regatta.

use std::process::ExitCode;

use clap::Args;

use crate::Failure;

/// Starts a plugin of this project by name, with its arguments.
type Starter = fn(Vec<String>) -> regatta_plugin::Result;

/// The shelf. A new plugin is a crate under `plugins/` and a line here.
const PLUGINS: &[(&str, Starter)] =
    &[("hello", |args| regatta_plugin::run_from(regatta_hello::Centre, args)), ("record", regatta_record::record_from)];

#[derive(Args)]
pub struct PluginArgs {
    /// Which one.
    pub name: String,
    /// Its arguments; `--help` lists them.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    pub args: Vec<String>,
}

/// Whether a plugin of that name comes with Regatta.
pub fn exists(name: &str) -> bool {
    PLUGINS.iter().any(|(known, _)| *known == name)
}

/// What to say when one doesn't.
pub fn unknown(name: &str) -> String {
    let known: Vec<_> = PLUGINS.iter().map(|(name, _)| *name).collect();
    format!("no plugin is called '{name}'; there are: {}", known.join(", "))
}

pub fn run(args: PluginArgs) -> Result<ExitCode, Failure> {
    let (_, start) = PLUGINS.iter().find(|(name, _)| *name == args.name).ok_or_else(|| unknown(&args.name))?;
    start(std::iter::once(args.name).chain(args.args).collect()).map_err(crate::plugin_failure)?;
    Ok(ExitCode::SUCCESS)
}
