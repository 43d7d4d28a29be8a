//! Examples of the validator's findings: the first one of each kind.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

use super::clock;

/// The largest number of robots that a text names.
const MOST_NAMED: usize = 3;

/// The first finding of a kind in a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Example {
    /// The simulated seconds from the beginning of the run.
    pub time_secs: f64,
    /// The robots.
    pub robots: Vec<u32>,
    /// The place of the first of them, in metres east and north.
    pub place: Option<[f32; 2]>,
    /// More about it, in words; may be empty.
    pub note: String,
}

/// The validator's report, as far as examples are in it.
#[derive(Deserialize)]
struct ReportEntry {
    kinds: Vec<KindEntry>,
}

#[derive(Deserialize)]
struct KindEntry {
    kind: String,
    examples: Vec<Example>,
}

/// Returns the first example of each kind in the validator's report.
///
/// # Errors
/// If it isn't a report.
pub fn examples(
    report: &serde_json::Value,
) -> Result<BTreeMap<String, Example>, serde_json::Error> {
    let report = ReportEntry::deserialize(report)?;
    let mut examples = BTreeMap::new();
    for KindEntry { kind, examples: of_kind } in report.kinds {
        if let Some(first) = of_kind.into_iter().next() {
            examples.insert(kind, first);
        }
    }
    Ok(examples)
}

impl fmt::Display for Example {
    /// Writes robots, time and place: `robots 3, 7 at 1:05 min, at (4.0, 2.5) m`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { time_secs, robots, place, note } = self;
        let names: Vec<String> = robots.iter().take(MOST_NAMED).map(u32::to_string).collect();
        match names.len() {
            0 => {}
            1 => write!(f, "robot {} ", names[0])?,
            _ => write!(f, "robots {} ", names.join(", "))?,
        }
        if let Some(more @ 1..) = robots.len().checked_sub(MOST_NAMED) {
            write!(f, "and {more} more ")?;
        }
        write!(f, "at {}", clock(*time_secs))?;
        if let Some([x, y]) = place {
            write!(f, ", at ({x:.1}, {y:.1}) m")?;
        }
        if note.is_empty() { Ok(()) } else { write!(f, " ({note})") }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_report_has_the_first_finding_of_each_kind() {
        let finding = |time_secs: f64, robots: &[u32], note: &str| {
            json!({"tick": 0, "time_secs": time_secs, "robots": robots, "place": [1.0, 2.5],
                   "value": 1.0, "limit": 1.0, "duration_secs": null, "note": note})
        };
        let report = json!({"kinds": [
            {"kind": "contact", "count": 0, "examples": []},
            {"kind": "zone", "count": 2, "examples": [
                finding(65.0, &[3, 7], "`dock` holds 1"), finding(90.0, &[1], ""),
            ]},
            {"kind": "jump", "count": 1, "examples": [finding(0.0, &[1, 2, 3, 4], "")]},
        ]});
        let examples = examples(&report).expect("a report");
        let said: Vec<String> =
            examples.iter().map(|(kind, example)| format!("{kind}: {example}")).collect();
        assert_eq!(
            said,
            [
                "jump: robots 1, 2, 3 and 1 more at 0:00 min, at (1.0, 2.5) m",
                "zone: robots 3, 7 at 1:05 min, at (1.0, 2.5) m (`dock` holds 1)",
            ]
        );
        assert!(super::examples(&json!([])).is_err());
    }
}
