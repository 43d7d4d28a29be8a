//! Errors of command lines, in one line.

use core::num::{ParseFloatError, ParseIntError};
use std::error::Error;

/// Returns clap's error as one line: the fault, and clap's suggestion. The usage that clap appends
/// is left out; `--help` shows it.
pub fn usage_line(error: &clap::Error) -> String {
    let text = error.to_string();
    // The first paragraph has the fault, in several lines if arguments are missing or values are
    // listed.
    let paragraph: Vec<_> =
        text.lines().take_while(|line| !line.is_empty()).map(str::trim).collect();
    let mut line = paragraph.join(" ").trim_start_matches("error: ").to_owned();
    if let Some((cause, advice)) =
        error.source().and_then(|cause| Some((cause.to_string(), advice(cause)?)))
        && let Some(start) = line.strip_suffix(&cause)
    {
        line = format!("{start}{advice}");
    }
    let tips = text.lines().filter_map(|line| line.trim().strip_prefix("tip: "));
    // "to pass '--typo' as a value, use '-- --typo'" is hardly ever meant.
    let tips = tips.filter(|tip| !tip.starts_with("to pass "));
    tips.fold(line, |line, tip| format!("{line}; {tip}"))
}

/// Returns the advice for a number that can't be parsed, in place of the standard library's
/// message.
fn advice(cause: &(dyn Error + 'static)) -> Option<&'static str> {
    use core::num::IntErrorKind::{NegOverflow, PosOverflow};
    if cause.is::<ParseFloatError>() {
        return Some("give a number");
    }
    match cause.downcast_ref::<ParseIntError>()?.kind() {
        PosOverflow | NegOverflow => Some("the number is too large"),
        _ => Some("give a whole number, 0 or more"),
    }
}

#[cfg(test)]
mod tests {
    use clap::{Arg, Command, value_parser};

    use super::usage_line;

    fn line(args: &[&str]) -> String {
        let command = Command::new("test")
            .arg(Arg::new("ticks").long("ticks").value_parser(value_parser!(u64)))
            .arg(Arg::new("rate").long("rate").value_parser(value_parser!(f64)))
            .arg(Arg::new("kind").long("kind").value_parser(["hello", "metrics"]))
            .subcommand(Command::new("run"));
        usage_line(&command.try_get_matches_from(args).expect_err("an invalid command line"))
    }

    #[test]
    fn one_line_says_what_is_wrong_and_what_was_meant() {
        for (args, expected) in [
            (
                ["test", "--ticks=x"],
                "invalid value 'x' for '--ticks <ticks>': give a whole number, 0 or more",
            ),
            (
                ["test", "--ticks=99999999999999999999"],
                "for '--ticks <ticks>': the number is too large",
            ),
            (["test", "--rate=x"], "invalid value 'x' for '--rate <rate>': give a number"),
            (
                ["test", "--rat=5"],
                "unexpected argument '--rat' found; a similar argument exists: '--rate'",
            ),
            (["test", "rum"], "unrecognized subcommand 'rum'; a similar subcommand exists: 'run'"),
            (["test", "--nonsense"], "unexpected argument '--nonsense' found"),
            (
                ["test", "--kind=helo"],
                "[possible values: hello, metrics]; a similar value exists: 'hello'",
            ),
        ] {
            let line = line(&args);
            assert!(line.ends_with(expected) && line.lines().count() == 1, "{args:?}: {line}");
        }
    }
}
