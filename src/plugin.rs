//! `regatta plugin NAME`: the built-in plugins.

use std::process::ExitCode;

use clap::Args;

use crate::failure::{Failure, plugin_failure};

/// A function that runs a plugin with its arguments, the first of which is the plugin's name.
type Run = fn(Vec<String>) -> regatta_plugin::Result;

/// The built-in plugins by name. A new one is a crate under `plugins/` and a line here.
const PLUGINS: &[(&str, Run)] = &[
    ("collision", |args| regatta_collision::run_from(args)),
    ("hello", |args| regatta_plugin::run_from(regatta_hello::Centre, args)),
    ("metrics", |args| regatta_metrics::run_from(args, option_env!("REGATTA_COMMIT"))),
    ("record", regatta_record::record_from),
    ("udp", |args| regatta_udp::run(args)),
    ("udp-source", |args| regatta_udp::source::run(args)),
];

#[derive(Args)]
pub struct PluginArgs {
    /// Name of the plugin, and its arguments; `NAME --help` lists them.
    #[arg(value_name = "NAME [ARG]", trailing_var_arg = true, allow_hyphen_values = true)]
    pub name_and_args: Vec<String>,
}

/// Whether a built-in plugin has this name.
pub fn is_built_in(name: &str) -> bool {
    PLUGINS.iter().any(|(built_in, _)| *built_in == name)
}

/// Returns the error message for a name that no built-in plugin has.
pub fn unknown(name: &str) -> String {
    format!("unknown plugin '{name}'; the built-in plugins are: {}", names())
}

fn names() -> String {
    PLUGINS.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
}

pub fn run(args: PluginArgs) -> Result<ExitCode, Failure> {
    let Some(name) = args.name_and_args.first() else {
        return Err(format!("the name of the plugin is missing; the built-in plugins are: {}", names()).into());
    };
    if ["-h", "--help"].contains(&name.as_str()) {
        println!(
            "Usage: regatta plugin NAME [OPTIONS]\n\nPlugins: {}\nFor a plugin's options: regatta plugin NAME --help",
            names()
        );
        return Ok(ExitCode::SUCCESS);
    }
    let (_, run) = PLUGINS.iter().find(|(built_in, _)| built_in == name).ok_or_else(|| unknown(name))?;
    run(args.name_and_args).map_err(plugin_failure)?;
    Ok(ExitCode::SUCCESS)
}
