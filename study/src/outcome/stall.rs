//! Stalls: times of a run in which robots with orders made no progress, as the validator found
//! them. A run with one isn't traffic.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

use super::clock;

/// Times closer than this are the same frame's.
const SAME_SECS: f64 = 1e-3;
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
    /// The time of what follows, in simulated seconds: that at which the stall was found, if it was
    /// over at the end of the run; `None` for the end of the run.
    #[serde(default)]
    pub seen_secs: Option<f64>,
    /// The robots that they waited for, as their manager says.
    pub waits_for: BTreeMap<u32, u32>,
    /// The places, in metres east and north, of the robots and of those that they waited for; empty
    /// if they aren't known.
    pub places: BTreeMap<u32, [f32; 2]>,
    /// The ids of the edges on which they were, as far as known.
    #[serde(default)]
    pub edges: BTreeMap<u32, u32>,
    /// The robots that were held, broken or faulted.
    pub out_of_service: Vec<u32>,
}

/// The states of a fleet that tell of its stalls.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SeenStates {
    /// That at the end of the run.
    pub last: FleetState,
    /// Those in which stalls were found, with their simulated times in seconds; at most
    /// [`MOST`](Self::MOST).
    pub found: Vec<(f64, FleetState)>,
}

impl SeenStates {
    /// The most states that are kept.
    pub const MOST: usize = 10;

    /// Returns the state in which a stall was found, if it is known.
    fn at(&self, secs: f64) -> Option<&FleetState> {
        let found = self.found.iter().find(|(seen_secs, _)| (seen_secs - secs).abs() < SAME_SECS);
        found.map(|(_, state)| state)
    }
}

/// The state of a fleet at a time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FleetState {
    /// By robot: the robot that it waits for, as its manager says.
    pub waits_for: BTreeMap<u32, u32>,
    /// By robot: metres east and north.
    pub places: Vec<[f32; 2]>,
    /// By robot: the id of its edge; empty if they aren't known.
    #[serde(default)]
    pub edges: Vec<u32>,
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
/// beginnings. The run took `secs` simulated seconds.
///
/// # Errors
/// If it isn't a report.
pub fn stalls(
    report: serde_json::Value,
    seen: &SeenStates,
    secs: f64,
) -> Result<Vec<Stall>, serde_json::Error> {
    let report: ReportEntry = serde_json::from_value(report)?;
    let mut stalls = Vec::new();
    for KindEntry { kind, examples } in report.kinds {
        let Ok(kind) = serde_json::from_value::<StallKind>(kind) else { continue };
        stalls.extend(examples.into_iter().map(|finding| finding.stall(kind, seen, secs)));
    }
    stalls.sort_by(|a, b| a.kind.cmp(&b.kind).then(a.from_secs.total_cmp(&b.from_secs)));
    Ok(stalls)
}

impl FindingEntry {
    fn stall(self, kind: StallKind, seen: &SeenStates, secs: f64) -> Stall {
        let from_secs = self.time_secs - self.value.unwrap_or(0.0);
        let until_secs = self.duration_secs.map(|duration_secs| from_secs + duration_secs);
        // The validator looks once a second.
        let until_secs = until_secs.filter(|until_secs| *until_secs < secs - 2.0);
        let (seen_secs, state) = match until_secs {
            None => (None, Some(&seen.last)),
            Some(_) => (Some(self.time_secs), seen.at(self.time_secs)),
        };
        let mut waits_for = BTreeMap::new();
        let (mut places, mut edges) = (BTreeMap::new(), BTreeMap::new());
        let mut out_of_service = Vec::new();
        if let Some(state) = state {
            out_of_service.clone_from(&state.out_of_service);
            waits_for.clone_from(&state.waits_for);
            waits_for.retain(|robot, _| self.robots.contains(robot));
            let involved = self.robots.iter().chain(waits_for.values());
            places = of_robots(&state.places, involved.clone());
            edges = of_robots(&state.edges, involved);
        }
        let Self { robots, place, .. } = self;
        Stall {
            kind,
            from_secs,
            until_secs,
            robots,
            place,
            seen_secs,
            waits_for,
            places,
            edges,
            out_of_service,
        }
    }
}

/// Returns the values of some robots, of those that have one.
fn of_robots<'a, T: Copy>(values: &[T], robots: impl Iterator<Item = &'a u32>) -> BTreeMap<u32, T> {
    robots.filter_map(|robot| Some((*robot, *values.get(*robot as usize)?))).collect()
}

impl Stall {
    /// Returns the time of [`places`](Self::places) in words, and whether the stall was over at the
    /// end of the run.
    pub fn seen(&self) -> String {
        match (self.seen_secs, self.until_secs) {
            (Some(seen_secs), Some(until_secs)) => {
                format!("at {}, before it was over at {}", clock(seen_secs), clock(until_secs))
            }
            _ => "at the end of the run".to_owned(),
        }
    }

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
        let at = self.seen_secs.map_or_else(String::new, |secs| format!("at {}: ", clock(secs)));
        if notes.is_empty() { Ok(()) } else { write!(f, " ({at}{})", notes.join(", ")) }
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
        let last = FleetState {
            waits_for: BTreeMap::from([(0, 1), (1, 2), (7, 0)]),
            places: vec![[1.0, 2.5], [3.0, 2.5], [5.0, 2.5], [9.0, 0.0]],
            edges: vec![7, 7, 8, 9],
            out_of_service: vec![2],
        };
        let earlier = FleetState {
            waits_for: BTreeMap::from([(1, 0)]),
            places: vec![[1.0, 2.5], [3.0, 0.5]],
            edges: Vec::new(),
            out_of_service: Vec::new(),
        };
        let seen = SeenStates { last, found: vec![(400.0, earlier)] };
        let unseen = SeenStates { found: Vec::new(), ..seen.clone() };
        let unseen = stalls(report(), &unseen, 1800.0).expect("a report");
        assert_eq!(unseen[0].places, BTreeMap::new(), "it is over");
        let stalls = stalls(report(), &seen, 1800.0).expect("a report");
        assert_eq!(stalls[0].places, BTreeMap::from([(0, [1.0, 2.5]), (1, [3.0, 0.5])]));
        assert_eq!(stalls[0].seen(), "at 6:40 min, before it was over at 7:00 min");
        assert_eq!(stalls[1].seen(), "at the end of the run");
        let involved: Vec<u32> = stalls[1].places.keys().copied().collect();
        assert_eq!(involved, [0, 1, 2]);
        assert_eq!(stalls[1].edges, BTreeMap::from([(0, 7), (1, 7), (2, 8)]));
        let said: Vec<String> = stalls.iter().map(ToString::to_string).collect();
        assert_eq!(
            said,
            [
                "all robots with orders stand from 1:40 min to 7:00 min: robots 0, 1, the first \
                 of them at (1.0, 2.5) m (at 6:40 min: 1 waits for 0)",
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
        assert_eq!(stalls(report, &SeenStates::default(), 60.0).expect("a report"), []);
    }
}
