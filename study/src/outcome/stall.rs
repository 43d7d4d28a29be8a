//! Stalls: times of a run in which robots with orders made no progress, as the validator found
//! them. A run with one isn't traffic.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

use super::clock;

/// The largest number of robots that a text names.
const MOST_NAMED: usize = 6;

/// A kind of stall: a kind of finding of the validator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StallKind {
    /// All robots with orders stood.
    Standstill,
    /// Robots with orders drove, some in circles, and none came to a stop.
    Livelock,
    /// A robot with an order stood while others drove.
    Stuck,
}

/// A time in which robots with orders made no progress.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stall {
    /// Its kind.
    pub kind: StallKind,
    /// Its beginning, in simulated seconds.
    pub from_secs: f64,
    /// Its end; `None` if it isn't known, or if it lasted to the end of the run.
    pub until_secs: Option<f64>,
    /// The robots.
    pub robots: Vec<u32>,
    /// The place of the first of them, in metres east and north.
    pub place: Option<[f32; 2]>,
    /// The robots that they waited for at the end of the run, as their manager says.
    pub waits_for: BTreeMap<u32, u32>,
    /// The places at the end of the run, in metres east and north, of the robots and of those that
    /// they waited for; empty if the stall was over by then.
    pub places: BTreeMap<u32, [f32; 2]>,
    /// The robots that were held, broken or faulted at the end of the run; empty if the stall was
    /// over by then.
    pub out_of_service: Vec<u32>,
}

/// The state of a fleet at the end of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LastState {
    /// By robot: the robot that it waits for, as its manager says.
    pub waits_for: BTreeMap<u32, u32>,
    /// By robot: metres east and north.
    pub places: Vec<[f32; 2]>,
    /// The robots that are held, broken or faulted.
    pub out_of_service: Vec<u32>,
}

/// The validator's report, as far as stalls are in it.
#[derive(Deserialize)]
struct ReportEntry {
    kinds: Vec<KindEntry>,
}

#[derive(Deserialize)]
struct KindEntry {
    kind: serde_json::Value,
    examples: Vec<FindingEntry>,
}

#[derive(Deserialize)]
struct FindingEntry {
    time_secs: f64,
    robots: Vec<u32>,
    place: Option<[f32; 2]>,
    value: Option<f64>,
    duration_secs: Option<f64>,
}

/// Returns the stalls that the validator's report names, by kind, in the order of their
/// beginnings. The run took `secs` simulated seconds, and ended in the state `last`.
///
/// # Errors
/// If it isn't a report.
pub fn stalls(
    report: serde_json::Value,
    last: &LastState,
    secs: f64,
) -> Result<Vec<Stall>, serde_json::Error> {
    let report: ReportEntry = serde_json::from_value(report)?;
    let mut stalls = Vec::new();
    for KindEntry { kind, examples } in report.kinds {
        let Ok(kind) = serde_json::from_value::<StallKind>(kind) else { continue };
        stalls.extend(examples.into_iter().map(|finding| finding.stall(kind, last, secs)));
    }
    stalls.sort_by(|a, b| a.kind.cmp(&b.kind).then(a.from_secs.total_cmp(&b.from_secs)));
    Ok(stalls)
}

impl FindingEntry {
    fn stall(self, kind: StallKind, last: &LastState, secs: f64) -> Stall {
        let from_secs = self.time_secs - self.value.unwrap_or(0.0);
        let until_secs = self.duration_secs.map(|duration_secs| from_secs + duration_secs);
        // The validator looks once a second.
        let until_secs = until_secs.filter(|until_secs| *until_secs < secs - 2.0);
        let (mut waits_for, mut places) = (BTreeMap::new(), BTreeMap::new());
        let mut out_of_service = Vec::new();
        if until_secs.is_none() {
            out_of_service.clone_from(&last.out_of_service);
            waits_for.clone_from(&last.waits_for);
            waits_for.retain(|robot, _| self.robots.contains(robot));
            let involved = self.robots.iter().chain(waits_for.values());
            places.extend(
                involved.filter_map(|robot| Some((*robot, *last.places.get(*robot as usize)?))),
            );
        }
        let Self { robots, place, .. } = self;
        Stall { kind, from_secs, until_secs, robots, place, waits_for, places, out_of_service }
    }
}

impl Stall {
    /// Returns the time in words, such as `from 1:40 min on`.
    pub fn span(&self) -> String {
        let from = clock(self.from_secs);
        match self.until_secs {
            Some(until_secs) => format!("from {from} to {}", clock(until_secs)),
            None => format!("from {from} on"),
        }
    }
}

impl fmt::Display for Stall {
    /// Writes what happened to whom, and when.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kind, robots, waits_for, out_of_service, .. } = self;
        let names: Vec<String> = robots.iter().take(MOST_NAMED).map(u32::to_string).collect();
        let noun = if robots.len() == 1 { "robot" } else { "robots" };
        let more = match robots.len().saturating_sub(MOST_NAMED) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let who = format!("{noun} {}{more}", names.join(", "));
        let span = self.span();
        let at = match (self.place, robots.len()) {
            (None, _) => String::new(),
            (Some([x, y]), 1) => format!(" at ({x:.1}, {y:.1}) m"),
            (Some([x, y]), _) => format!(", the first of them at ({x:.1}, {y:.1}) m"),
        };
        match kind {
            StallKind::Standstill => write!(f, "all robots with orders stand {span}: {who}{at}")?,
            StallKind::Livelock => write!(f, "robots drive {span} without any arrival: {who}{at}")?,
            StallKind::Stuck => {
                write!(f, "{who} stands{at} with an order {span}, while others drive")?;
            }
        }
        let mut notes: Vec<String> = waits_for
            .iter()
            .take(MOST_NAMED)
            .map(|(robot, other)| format!("{robot} waits for {other}"))
            .collect();
        let others = out_of_service.iter().take(MOST_NAMED).map(u32::to_string);
        match out_of_service.len() {
            0 => {}
            1 => notes.push(format!("robot {} is out of service", out_of_service[0])),
            _ => {
                let others = others.collect::<Vec<_>>().join(", ");
                notes.push(format!("robots {others} are out of service"));
            }
        }
        if notes.is_empty() { Ok(()) } else { write!(f, " ({})", notes.join(", ")) }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn report() -> serde_json::Value {
        let finding = |time_secs: f64, robots: &[u32], value: f64, duration_secs: Option<f64>| {
            json!({
                "tick": 0, "time_secs": time_secs, "robots": robots, "place": [1.0, 2.5],
                "value": value, "limit": 1.0, "duration_secs": duration_secs, "note": "",
            })
        };
        json!({"kinds": [
            {"kind": "contact", "count": 0, "examples": []},
            {"kind": "unserved", "count": 1, "examples": [finding(1200.0, &[], 1200.0, None)]},
            {"kind": "stuck", "count": 1, "examples": [finding(700.0, &[3], 600.0, None)]},
            {"kind": "standstill", "count": 2, "examples": [
                finding(400.0, &[0, 1], 300.0, Some(320.0)),
                finding(1500.0, &[0, 1], 300.0, Some(600.0)),
            ]},
        ]})
    }

    #[test]
    fn a_report_has_stalls_with_robots_times_and_reasons() {
        let last = LastState {
            waits_for: BTreeMap::from([(0, 1), (1, 2), (7, 0)]),
            places: vec![[1.0, 2.5], [3.0, 2.5], [5.0, 2.5], [9.0, 0.0]],
            out_of_service: vec![2],
        };
        let stalls = stalls(report(), &last, 1800.0).expect("a report");
        assert_eq!(stalls[0].places, BTreeMap::new(), "it is over");
        let involved: Vec<u32> = stalls[1].places.keys().copied().collect();
        assert_eq!(involved, [0, 1, 2]);
        let said: Vec<String> = stalls.iter().map(ToString::to_string).collect();
        assert_eq!(
            said,
            [
                "all robots with orders stand from 1:40 min to 7:00 min: robots 0, 1, the first \
                 of them at (1.0, 2.5) m",
                "all robots with orders stand from 20:00 min on: robots 0, 1, the first of them \
                 at (1.0, 2.5) m (0 waits for 1, 1 waits for 2, robot 2 is out of service)",
                "robot 3 stands at (1.0, 2.5) m with an order from 1:40 min on, while others \
                 drive (robot 2 is out of service)",
            ]
        );
    }

    #[test]
    fn a_report_without_stalls_has_none() {
        let report = json!({"kinds": [{"kind": "idle", "count": 0, "examples": []}]});
        assert_eq!(stalls(report, &LastState::default(), 60.0).expect("a report"), []);
    }
}
