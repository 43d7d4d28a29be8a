//! Log messages on standard error, as lines with the name of the command, like all its messages.

use std::fmt;

use tracing::{Event, Level, Subscriber};
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::fmt::format::Writer;
use tracing_subscriber::fmt::{FmtContext, FormatEvent, FormatFields};
use tracing_subscriber::prelude::*;
use tracing_subscriber::registry::LookupSpan;

/// Libraries whose warnings aren't for users: zenoh warns of what is an error of ours as well, and
/// of settings that are meant so; winit of displays without settings or without a size.
const QUIET: [&str; 2] = ["zenoh", "winit"];

/// Writes log messages to standard error: warnings, and one more level for each `-v`.
pub fn start(name: String, verbose: u8) {
    let level = match verbose {
        0 => Level::WARN,
        1 => Level::INFO,
        _ => Level::DEBUG,
    };
    let lines = tracing_subscriber::fmt::layer()
        .with_ansi(false)
        .with_writer(std::io::stderr)
        .event_format(Lines { name });
    let mut filter = Targets::new().with_default(level);
    if verbose == 0 {
        filter = filter.with_targets(QUIET.map(|library| (library, LevelFilter::OFF)));
    }
    let subscriber = tracing_subscriber::registry().with(lines).with(filter);
    // With the feature `zenoh`, `init` would also print what other crates log by the crate `log`.
    // This is the only subscriber.
    let _ = tracing::subscriber::set_global_default(subscriber);
}

/// Formats messages as lines: the name of the command, the level of those that a user asked for,
/// and the message.
struct Lines {
    name: String,
}

impl<S, N> FormatEvent<S, N> for Lines
where
    S: Subscriber + for<'a> LookupSpan<'a>,
    N: for<'a> FormatFields<'a> + 'static,
{
    fn format_event(
        &self,
        context: &FmtContext<'_, S, N>,
        mut writer: Writer<'_>,
        event: &Event<'_>,
    ) -> fmt::Result {
        write!(writer, "{}: ", self.name)?;
        let level = *event.metadata().level();
        if level > Level::WARN {
            write!(writer, "{}: ", level.as_str().to_lowercase())?;
        }
        context.format_fields(writer.by_ref(), event)?;
        writeln!(writer)
    }
}
