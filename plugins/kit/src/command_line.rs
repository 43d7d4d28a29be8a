//! The `main` of a plugin that has options of its own.

use std::ffi::OsString;

use clap::Parser;
use regatta_plugin::{Error, Result, usage_line};

/// Parses a command line, whose first argument is the name of the program, and runs a plugin with
/// it. Prints the help instead if the command line asks for it.
///
/// ```
/// use clap::Parser;
/// use regatta_plugin::{Frame, Options, Plugin, Result};
///
/// #[derive(Parser)]
/// struct Cli {
///     /// Distance in metres
///     #[arg(long, default_value_t = 0.2)]
///     margin: f32,
///     #[command(flatten)]
///     options: Options,
/// }
///
/// struct MyPlugin { margin: f32 }
///
/// impl Plugin for MyPlugin {
///     fn on_frame(&mut self, frame: &Frame) -> Result {
///         println!("{} robots, margin {} m", frame.len(), self.margin);
///         Ok(())
///     }
/// }
///
/// fn main() -> Result {
///     # let args = ["my-plugin", "--help"];
///     # #[cfg(false)]
///     let args = std::env::args_os();
///     regatta_kit::run_from(args, |cli: Cli| {
///         cli.options.run(MyPlugin { margin: cli.margin }, "my-plugin")
///     })
/// }
/// ```
///
/// # Errors
/// If an option is invalid, in one line, or as `run` does.
pub fn run_from<Cli: Parser>(
    args: impl IntoIterator<Item: Into<OsString> + Clone>,
    run: impl FnOnce(Cli) -> Result,
) -> Result {
    match parse(args)? {
        Some(cli) => run(cli),
        None => Ok(()),
    }
}

/// Parses a command line, whose first argument is the name of the program. Prints the help and
/// returns `None` if the command line asks for it.
///
/// # Errors
/// If an option is invalid; the error has one line.
pub fn parse<Cli: Parser>(
    args: impl IntoIterator<Item: Into<OsString> + Clone>,
) -> Result<Option<Cli>> {
    match Cli::try_parse_from(args) {
        Ok(cli) => Ok(Some(cli)),
        Err(error) if !error.use_stderr() => {
            error.print()?;
            Ok(None)
        }
        Err(error) => {
            Err(Error::new(format_args!("{}; --help lists the options", usage_line(&error))))
        }
    }
}
