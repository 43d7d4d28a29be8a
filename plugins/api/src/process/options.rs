//! The command line of plugins.

use std::ffi::OsString;
use std::path::Path;

use clap::error::ErrorKind;
use clap::{Args, CommandFactory, FromArgMatches, Parser};

use super::plugin::Plugin;
use super::rate::Rate;
use super::usage::usage_line;
use crate::error::{Error, Result};
use crate::records::name::{FleetName, NameError};

/// The command-line options of every plugin. A plugin with options of its own flattens these into
/// them (`#[command(flatten)]`) and calls `run`.
///
/// ```no_run
/// use clap::Parser;
/// use regatta_plugin::{Frame, Options, Plugin, Result};
///
/// #[derive(Parser)]
/// struct Cli {
///     /// The speed above which a robot is reported, in metres per second
///     #[arg(long, default_value_t = 1.0)]
///     limit: f32,
///     #[command(flatten)]
///     options: Options,
/// }
///
/// struct Watch(f32);
///
/// impl Plugin for Watch {
///     fn on_frame(&mut self, frame: &Frame) -> Result {
///         let fast = frame.speed().iter().filter(|speed| **speed > self.0).count();
///         println!("tick {}: {fast} robots are fast", frame.tick());
///         Ok(())
///     }
/// }
///
/// fn main() -> Result {
///     let cli = Cli::parse();
///     cli.options.run(Watch(cli.limit), "watch")
/// }
/// ```
#[derive(Args, Clone, Debug)]
pub struct Options {
    /// Fleet to read
    #[arg(long, value_name = "NAME", default_value_t)]
    pub fleet: FleetName,
    /// Frames per second to read, or 'all' [default: the plugin's own]
    #[arg(long, value_name = "N")]
    pub rate: Option<Rate>,
    /// Name in lockstep and in `regatta doctor` [default: the program's name]
    #[arg(long, value_name = "NAME")]
    pub name: Option<String>,
    /// In lockstep, handle each tick after this plugin; may be repeated
    #[arg(long, value_name = "NAME", value_parser = parse_plugin_name)]
    pub after: Vec<String>,
    /// Print warnings of the shared-memory library (iceoryx2); -vv for its complete log
    #[arg(short, long, action = clap::ArgAction::Count)]
    pub verbose: u8,
}

/// Checks the name of a plugin: the rules are those for fleets.
fn parse_plugin_name(text: &str) -> Result<String, NameError> {
    text.parse::<FleetName>().map(|name| name.to_string())
}

/// The environment variable with the name that a plugin goes by unless `--name` says otherwise:
/// `regatta run` sets it to the name in the scenario.
pub const NAME_VARIABLE: &str = "REGATTA_PLUGIN_NAME";
/// The environment variable with the names of the plugins that this one comes after in lockstep,
/// separated by commas: `regatta run` sets it to the names in the scenario.
pub const AFTER_VARIABLE: &str = "REGATTA_PLUGIN_AFTER";
/// The environment variable with the path of a scenario that describes a load of transport orders
/// (its key `load`), for a fleet manager: `regatta run` sets it.
pub const LOAD_VARIABLE: &str = "REGATTA_LOAD";

impl Options {
    /// The names of the plugins that a plugin comes after in lockstep.
    pub(crate) fn after(&self, plugin: &(impl Plugin + ?Sized)) -> Vec<String> {
        let given = std::env::var(AFTER_VARIABLE).unwrap_or_default();
        let given =
            given.split(',').map(str::trim).filter(|name| !name.is_empty()).map(str::to_owned);
        self.after.iter().cloned().chain(given).chain(plugin.after()).collect()
    }
}

/// A command line that has these options and no others.
#[derive(Parser)]
struct Cli<T: Args> {
    #[command(flatten)]
    options: T,
}

/// Parses a command line. Returns its options and the name of the program, or `None` if the help
/// was printed.
pub(crate) fn parse<T: Args, A: Into<OsString>>(
    args: impl IntoIterator<Item = A>,
    default_program: &str,
    about: &'static str,
) -> Result<Option<(T, String)>> {
    let args: Vec<OsString> = args.into_iter().map(Into::into).collect();
    let program = args.first().and_then(|path| Path::new(path).file_stem()?.to_str());
    let program = program.unwrap_or(default_program).to_owned();
    let parsed = Cli::<T>::command().bin_name(&program).about(about).try_get_matches_from(args);
    match parsed.and_then(|matches| Cli::from_arg_matches(&matches)) {
        Ok(cli) => Ok(Some((cli.options, program))),
        Err(error) if error.kind() == ErrorKind::DisplayHelp => {
            error.print()?;
            Ok(None)
        }
        Err(error) => {
            Err(Error::new(format_args!("{}; --help lists the options", usage_line(&error))))
        }
    }
}
