//! `regatta plugin NAME`: the plugins that come with Regatta.

use std::process::ExitCode;

use clap::Args;

use crate::Failure;

/// Starts a plugin of this project by name, with its arguments.
type Starter = fn(Vec<String>) -> regatta_plugin::Result;

/// The shelf. A new plugin is a crate under `plugins/` and a line here.
const PLUGINS: &[(&str, Starter)] = &[
    ("collision", |args| regatta_collision::run_from(args)),
    ("hello", |args| regatta_plugin::run_from(regatta_hello::Centre, args)),
    ("metrics", |args| regatta_metrics::run_from(args)),
    ("record", regatta_record::record_from),
    ("udp", |args| regatta_udp::run(args)),
    ("udp-source", |args| regatta_udp::source::run(args)),
];

#[derive(Args)]
pub struct PluginArgs {
    /// Which one, and its arguments; `NAME --help` lists them.
    #[arg(value_name = "NAME [ARG]", trailing_var_arg = true, allow_hyphen_values = true)]
    pub words: Vec<String>,
}

/// Whether a plugin of that name comes with Regatta.
pub fn exists(name: &str) -> bool {
    PLUGINS.iter().any(|(known, _)| *known == name)
}

/// What to say when one doesn't.
pub fn unknown(name: &str) -> String {
    format!("no plugin is called '{name}'; there are: {}", names())
}

fn names() -> String {
    PLUGINS.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
}

pub fn run(args: PluginArgs) -> Result<ExitCode, Failure> {
    let Some(name) = args.words.first() else {
        return Err(format!("which plugin? There are: {}", names()).into());
    };
    if ["-h", "--help"].contains(&name.as_str()) {
        println!("Usage: regatta plugin NAME [OPTIONS]\n\nPlugins: {}\nOptions: regatta plugin NAME --help", names());
        return Ok(ExitCode::SUCCESS);
    }
    let (_, start) = PLUGINS.iter().find(|(known, _)| known == name).ok_or_else(|| unknown(name))?;
    start(args.words).map_err(crate::plugin_failure)?;
    Ok(ExitCode::SUCCESS)
}
