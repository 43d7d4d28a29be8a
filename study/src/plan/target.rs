//! Targets: the values that a fleet must reach.

use std::fmt;
use std::str::FromStr;

use serde::Deserialize;

use crate::statistics::Interval;
use crate::words::{self, Kind};

/// A figure of a run that a target is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TargetFigure {
    /// The time from an order's creation to its end.
    Service(Statistic),
    /// The part of the orders that were finished after their deadline.
    Late,
    /// The part of the robots' time in which they wait for room.
    Waiting,
    /// The part of the robots' time with an order.
    Utilisation,
    /// Finished orders an hour.
    Throughput,
}

/// A statistic of the orders of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Statistic {
    /// The mean.
    Mean,
    /// The 50th percentile.
    P50,
    /// The 90th percentile.
    P90,
    /// The 95th percentile.
    P95,
    /// The 99th percentile.
    P99,
    /// The largest value.
    Longest,
}

impl Statistic {
    /// The statistics and their names; the first of several names is the one that is shown.
    const NAMES: [(&str, Self); 8] = [
        ("mean", Self::Mean),
        ("p50", Self::P50),
        ("p90", Self::P90),
        ("p95", Self::P95),
        ("p99", Self::P99),
        ("longest", Self::Longest),
        ("median", Self::P50),
        ("max", Self::Longest),
    ];

    fn with_name(name: &str) -> Option<Self> {
        Self::NAMES.iter().find(|(known, _)| *known == name).map(|(_, statistic)| *statistic)
    }

    fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, known)| *known == self).map_or("", |(name, _)| name)
    }
}

/// The side of a limit on which values meet a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Values below the limit.
    AtMost,
    /// Values from the limit on.
    AtLeast,
}

/// A value that a figure must reach: seconds, a part from 0 to 1, or orders an hour.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(try_from = "String")]
pub struct Target {
    /// The figure.
    pub figure: TargetFigure,
    /// The limit.
    pub limit: f64,
}

/// The error of parsing a [`Target`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "invalid target '{}': {reason}: write 'p99 service < 6min' (or mean, p50, p90, p95, longest), \
     'late < 1%', 'waiting < 20%', 'utilisation < 85%' or '400 orders/h'",
    text.escape_debug()
)]
pub struct ParseTargetError {
    text: String,
    reason: Reason,
}

/// The reason why a text is no target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
enum Reason {
    #[error("it has no `<` or `>`")]
    NoSign,
    #[error("it names no known figure")]
    Figure,
    #[error("it needs a time above 0, such as 6min or 90s")]
    Time,
    #[error("it needs a percentage above 0% and up to 100%, such as 1%")]
    Part,
    #[error("it needs a number of orders above 0, such as 400 or 400/h")]
    Orders,
    #[error("smaller values of this figure are better: write its limit with `<`")]
    Least,
    #[error("more orders are better: write their limit with `>`")]
    Most,
}

impl Target {
    /// The side of the limit on which values meet it.
    pub fn side(&self) -> Side {
        match self.figure {
            TargetFigure::Throughput => Side::AtLeast,
            _ => Side::AtMost,
        }
    }

    /// Whether the figure is one of orders, which changes as long as the backlog grows.
    pub fn is_of_orders(&self) -> bool {
        matches!(self.figure, TargetFigure::Service(_) | TargetFigure::Late)
    }

    /// Returns the distance from a value to the limit as a part of the limit: above 0 if the value
    /// meets it.
    pub fn margin(&self, value: f64) -> f64 {
        match self.side() {
            Side::AtMost => (self.limit - value) / self.limit,
            Side::AtLeast => (value - self.limit) / self.limit,
        }
    }

    /// Returns a value of the figure in words, with its interval in the same unit if it has a
    /// spread: [`words::in_words`].
    pub fn in_words(&self, value: &Interval) -> String {
        let (factor, decimals, unit) = match self.figure {
            TargetFigure::Service(_) if value.mean >= 600.0 => (1.0 / 60.0, 1, " min"),
            TargetFigure::Service(_) => (1.0, 0, " s"),
            TargetFigure::Late => (100.0, 2, " %"),
            TargetFigure::Waiting | TargetFigure::Utilisation => (100.0, 1, " %"),
            TargetFigure::Throughput => (1.0, 1, " orders an hour"),
        };
        let kind = match self.figure {
            TargetFigure::Service(_) | TargetFigure::Throughput => Kind::Bounded,
            TargetFigure::Late | TargetFigure::Waiting | TargetFigure::Utilisation => Kind::Share,
        };
        let value = value.without_spread_up_to(0.0);
        words::in_words(&value, kind, unit, |value| format!("{:.decimals$}", value * factor))
    }

    /// The name of the figure.
    pub fn name(&self) -> String {
        match self.figure {
            TargetFigure::Service(statistic) => format!("{} service", statistic.name()),
            TargetFigure::Late => "late".to_owned(),
            TargetFigure::Waiting => "waiting".to_owned(),
            TargetFigure::Utilisation => "utilisation".to_owned(),
            TargetFigure::Throughput => "throughput".to_owned(),
        }
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let limit = self.limit;
        match self.figure {
            TargetFigure::Service(_) if limit % 60.0 == 0.0 => {
                write!(f, "{} < {} min", self.name(), limit / 60.0)
            }
            TargetFigure::Service(_) => write!(f, "{} < {limit} s", self.name()),
            TargetFigure::Throughput => write!(f, "{limit} orders/h"),
            _ => write!(f, "{} < {} %", self.name(), rounded(limit * 100.0)),
        }
    }
}

/// Rounds a percentage, so that 1.1 % isn't 1.1000000000000001 %.
fn rounded(percent: f64) -> f64 {
    (percent * 1e9).round() / 1e9
}

impl FromStr for Target {
    type Err = ParseTargetError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        parse(text).map_err(|reason| ParseTargetError { text: text.to_owned(), reason })
    }
}

impl TryFrom<String> for Target {
    type Error = ParseTargetError;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        text.parse()
    }
}

fn parse(text: &str) -> Result<Target, Reason> {
    let text = text.trim().to_lowercase();
    let Some(sign) = text.find(['<', '>']) else {
        // '400 orders/h' alone.
        let count = text.strip_suffix("orders/h").ok_or(Reason::NoSign)?;
        return Ok(Target { figure: TargetFigure::Throughput, limit: orders(count)? });
    };
    let (words, limit) = (&text[..sign], text[sign + 1..].trim_start_matches('='));
    let words: Vec<&str> = words.split_whitespace().collect();
    let (figure, limit) = match words[..] {
        ["late"] => (TargetFigure::Late, part(limit)?),
        ["waiting"] => (TargetFigure::Waiting, part(limit)?),
        ["utilisation"] => (TargetFigure::Utilisation, part(limit)?),
        ["orders/h" | "orders" | "throughput"] => (TargetFigure::Throughput, orders(limit)?),
        ["service"] => (TargetFigure::Service(Statistic::Mean), secs(limit)?),
        [name, "service"] | ["service", name] => {
            let statistic = Statistic::with_name(name).ok_or(Reason::Figure)?;
            (TargetFigure::Service(statistic), secs(limit)?)
        }
        _ => return Err(Reason::Figure),
    };
    let target = Target { figure, limit };
    match (target.side(), text.as_bytes()[sign]) {
        (Side::AtMost, b'>') => Err(Reason::Least),
        (Side::AtLeast, b'<') => Err(Reason::Most),
        _ => Ok(target),
    }
}

fn positive(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|number: &f64| number.is_finite() && *number > 0.0)
}

fn orders(text: &str) -> Result<f64, Reason> {
    let text = text.trim();
    let number = ["orders/h", "/h"].iter().find_map(|unit| text.strip_suffix(unit)).unwrap_or(text);
    positive(number).ok_or(Reason::Orders)
}

fn part(text: &str) -> Result<f64, Reason> {
    let percent = text.trim().strip_suffix('%').and_then(positive);
    percent.filter(|percent| *percent <= 100.0).map(|percent| percent / 100.0).ok_or(Reason::Part)
}

/// The units of times, in seconds; longer names come before those that they end in.
const UNITS: [(&str, f64); 4] = [("min", 60.0), ("sec", 1.0), ("h", 3600.0), ("s", 1.0)];

fn secs(text: &str) -> Result<f64, Reason> {
    let text = text.trim();
    for (unit, secs) in UNITS {
        if let Some(number) = text.strip_suffix(unit) {
            return positive(number).map(|number| number * secs).ok_or(Reason::Time);
        }
    }
    // A bare number would leave it open whether seconds or minutes are meant.
    Err(Reason::Time)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn target(text: &str) -> Target {
        text.parse().expect(text)
    }

    #[test]
    fn targets_are_read_as_they_are_said() {
        for (text, shown, limit) in [
            ("p99 service < 6min", "p99 service < 6 min", 360.0),
            (" Service P95 <= 90 s ", "p95 service < 90 s", 90.0),
            ("median service<1.5h", "p50 service < 90 min", 5400.0),
            ("service < 2min", "mean service < 2 min", 120.0),
            ("max service < 45sec", "longest service < 45 s", 45.0),
            ("late < 1%", "late < 1 %", 0.01),
            ("waiting < 12.5 %", "waiting < 12.5 %", 0.125),
            ("utilisation < 85%", "utilisation < 85 %", 0.85),
            ("400 orders/h", "400 orders/h", 400.0),
            ("orders/h >= 62.5", "62.5 orders/h", 62.5),
            ("throughput > 80/h", "80 orders/h", 80.0),
        ] {
            let read = target(text);
            assert_eq!((read.to_string(), read.limit), (shown.to_owned(), limit), "{text}");
            assert_eq!(target(&read.to_string()), read, "{shown} is read again");
        }
    }

    #[test]
    fn what_is_no_target_is_refused_with_its_reason() {
        for (text, reason) in [
            ("", "no `<`"),
            ("p99 service", "no `<`"),
            ("p98 service < 6min", "no known figure"),
            ("p99 < 6min", "no known figure"),
            ("p99 service < 6", "needs a time"),
            ("p99 service < -6min", "needs a time"),
            ("p99 service < nanmin", "needs a time"),
            ("late < 1", "needs a percentage"),
            ("late < 101%", "needs a percentage"),
            ("late < 0%", "needs a percentage"),
            ("orders/h > many", "needs a number of orders"),
            ("inf orders/h", "needs a number of orders"),
            ("late > 1%", "limit with `<`"),
            ("orders/h < 400", "limit with `>`"),
        ] {
            let error = text.parse::<Target>().expect_err(text).to_string();
            assert!(error.contains(reason) && !error.contains('\n'), "{text}: {error}");
        }
    }

    #[test]
    fn a_value_and_its_interval_have_one_unit() {
        let words = |text, mean, half_width| {
            target(text).in_words(&Interval { mean, half_width: Some(half_width), values: 3 })
        };
        assert_eq!(words("p99 service < 15min", 654.0, 190.0), "10.9 ± 3.2 min");
        assert_eq!(words("p99 service < 15min", 307.0, 30.0), "307 ± 30 s");
        assert_eq!(words("p99 service < 15min", 654.0, 720.0), "0.0 to 22.9 min");
        assert_eq!(words("late < 1%", 0.0, 0.0), "0.00 %");
        assert_eq!(words("late < 1%", 0.1117, 0.2023), "0.00 to 31.40 %");
        assert_eq!(words("waiting < 20%", 0.62, 1.34), "not known");
    }

    #[test]
    fn a_margin_is_above_0_where_the_target_is_met() {
        assert_eq!(target("p99 service < 100s").margin(75.0), 0.25);
        assert_eq!(target("p99 service < 100s").margin(150.0), -0.5);
        assert_eq!(target("400 orders/h").margin(500.0), 0.25);
    }
}
