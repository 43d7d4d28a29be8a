//! Means with their intervals in words: the one place that decides what a reader is told of a
//! figure.

use crate::statistics::Interval;

/// The text for a figure of which nothing is known.
pub const NOT_KNOWN: &str = "not known";

/// The values that a figure can have, and its use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A time, a rate or an amount, from 0 on, which is an answer itself.
    Estimate,
    /// A figure from 0 on, whose interval tells enough: a count, or a figure against a limit.
    Bounded,
    /// A part, from 0 to 1.
    Share,
}

impl Kind {
    /// The largest value.
    fn most(self) -> f64 {
        match self {
            Self::Estimate | Self::Bounded => f64::INFINITY,
            Self::Share => 1.0,
        }
    }
}

/// Returns a mean with half of its interval, such as `307 ± 30 s`. `write` writes a value, and
/// `unit` follows once, with a space before it if it needs one.
///
/// An interval that leaves the values of its figure is cut there, and written from its lower to
/// its upper end: `54 to 100 %`. If half of it is as wide as its value, the mean is no answer: an
/// estimate is `not known (0 to 12 min)` then. A part that may be any is `not known`.
pub fn in_words(
    interval: &Interval,
    kind: Kind,
    unit: &str,
    write: impl Fn(f64) -> String,
) -> String {
    let Interval { mean, half_width, .. } = *interval;
    let Some(half_width) = half_width else { return format!("{}{unit}", write(mean)) };
    let (low, high) = (mean - half_width, mean + half_width);
    let is_vague = is_vague(interval);
    if !is_vague && high <= kind.most() {
        return format!("{} ± {}{unit}", write(mean), write(half_width));
    }
    if low <= 0.0 && high >= kind.most() {
        return NOT_KNOWN.to_owned();
    }
    let range = format!("{} to {}{unit}", write(low.max(0.0)), write(high.min(kind.most())));
    match kind == Kind::Estimate && is_vague {
        true => format!("{NOT_KNOWN} ({range})"),
        false => range,
    }
}

/// Whether an interval reaches down to 0 or below, though its mean is above: then it doesn't tell
/// how large the figure is.
fn is_vague(interval: &Interval) -> bool {
    interval.half_width.is_some_and(|half_width| half_width > 0.0 && half_width >= interval.mean)
}

/// Returns the ends of an interval that can be drawn: cut at 0 and at the largest value, if there
/// is one.
pub fn ends(mean: f64, half_width: f64, most: Option<f64>) -> [f64; 2] {
    let high = mean + half_width;
    [(mean - half_width).max(0.0), most.map_or(high, |most| high.min(most.max(mean)))]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(mean: f64, half_width: impl Into<Option<f64>>, kind: Kind) -> String {
        let interval = Interval { mean, half_width: half_width.into(), values: 3 };
        match kind {
            Kind::Share => in_words(&interval, kind, " %", |part| format!("{:.0}", part * 100.0)),
            _ => in_words(&interval, kind, " s", |secs| format!("{secs:.0}")),
        }
    }

    #[test]
    fn a_mean_stands_with_half_of_its_interval() {
        assert_eq!(words(307.0, 30.0, Kind::Estimate), "307 ± 30 s");
        assert_eq!(words(307.0, 30.0, Kind::Bounded), "307 ± 30 s");
        assert_eq!(words(0.62, 0.1, Kind::Share), "62 ± 10 %");
        assert_eq!(
            words(307.0, None::<f64>, Kind::Estimate),
            "307 s",
            "a single run has no spread"
        );
    }

    #[test]
    fn nothing_in_every_run_is_nothing() {
        assert_eq!(words(0.0, 0.0, Kind::Estimate), "0 ± 0 s");
        assert_eq!(words(0.0, 0.0, Kind::Share), "0 ± 0 %");
        assert_eq!(words(1.0, 0.0, Kind::Share), "100 ± 0 %");
    }

    #[test]
    fn an_interval_wider_than_its_value_is_no_answer() {
        assert_eq!(words(17.0, 70.0, Kind::Estimate), "not known (0 to 87 s)");
        assert_eq!(words(17.0, 17.0, Kind::Estimate), "not known (0 to 34 s)");
        assert_eq!(words(17.0, 70.0, Kind::Bounded), "0 to 87 s", "enough against a limit");
        assert_eq!(words(0.62, 1.34, Kind::Share), "not known");
    }

    #[test]
    fn parts_end_at_nothing_and_at_all() {
        assert_eq!(words(0.79, 0.3, Kind::Share), "49 to 100 %");
        assert_eq!(words(0.11, 0.2, Kind::Share), "0 to 31 %");
        assert_eq!(words(0.9, 0.1, Kind::Share), "90 ± 10 %");
    }

    #[test]
    fn bars_of_charts_end_at_the_least_and_the_largest_value() {
        assert_eq!(ends(50.0, 20.0, Some(100.0)), [30.0, 70.0]);
        assert_eq!(ends(62.0, 134.0, Some(100.0)), [0.0, 100.0]);
        assert_eq!(ends(17.0, 70.0, None), [0.0, 87.0]);
    }
}
