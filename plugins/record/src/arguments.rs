//! Values of command-line options: paths, limits, topics, robots.

use std::collections::BTreeSet;
use std::fmt;
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use clap::builder::{PathBufValueParser, TypedValueParser};

use crate::schema::Topic;

/// Parses the path of an option. Recordings, pictures and tables are files that appear when they
/// are complete, so they can't be written to standard output.
pub(crate) fn path_parser() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| match path.as_os_str() == "-" {
        true => Err("this command can't write to standard output; give a path"),
        false => Ok(path),
    })
}

/// The topics of contacts: markers come from the lists.
const CONTACTS: [Topic; 3] = [Topic::Contacts, Topic::ContactUpdates, Topic::ContactMarkers];

/// Parses the rate of poses.
pub(crate) fn parse_poses_rate(text: &str) -> Result<f64, String> {
    let rate = text.parse().ok().filter(|rate| (0.0..=1e6).contains(rate));
    rate.ok_or_else(|| format!("invalid rate '{text}'; give a number per second from 0 to 1000000"))
}

/// A limit of a file or of several: `10min` or `1GB`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// Time on the recording's clock.
    Time(Duration),
    /// Bytes in the file.
    Bytes(u64),
}

/// Units of sizes, in bytes.
const UNITS: [(&str, u64); 9] = [
    ("KB", 1_000),
    ("MB", 1_000_000),
    ("GB", 1_000_000_000),
    ("TB", 1_000_000_000_000),
    ("KIB", 1 << 10),
    ("MIB", 1 << 20),
    ("GIB", 1 << 30),
    ("TIB", 1 << 40),
    ("B", 1),
];

/// The smallest limit of size: a chunk.
const LEAST_BYTES: u64 = 1_000_000;
/// The smallest limit of time: a chunk.
const LEAST_TIME: Duration = Duration::from_secs(1);

impl Limit {
    /// Whether an amount of time and bytes has reached this limit.
    pub(crate) fn is_reached(&self, time: Duration, bytes: u64) -> bool {
        match self {
            Self::Time(limit) => time >= *limit,
            Self::Bytes(limit) => bytes >= *limit,
        }
    }

    /// Returns a fraction of the limit.
    pub(crate) fn divided(&self, by: u32) -> Self {
        match self {
            Self::Time(limit) => Self::Time(*limit / by),
            Self::Bytes(limit) => Self::Bytes(limit / u64::from(by)),
        }
    }
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Time(limit) => humantime::format_duration(*limit).fmt(f),
            Self::Bytes(limit) => write!(f, "{:.1} MB", *limit as f64 * 1e-6),
        }
    }
}

impl FromStr for Limit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match (humantime::parse_duration(text), parse_bytes(text)) {
            (Ok(time), _) if time < LEAST_TIME => {
                Err(format!("'{text}' is too short; give at least 1s"))
            }
            (Ok(time), _) => Ok(Self::Time(time)),
            (_, Some(bytes)) if bytes < LEAST_BYTES => {
                Err(format!("'{text}' is too small; give at least 1MB"))
            }
            (_, Some(bytes)) => Ok(Self::Bytes(bytes)),
            _ => Err(format!(
                "invalid limit '{text}'; give a time or a size, for example 10min, 90s, 500MB \
                 or 1GB"
            )),
        }
    }
}

fn parse_bytes(text: &str) -> Option<u64> {
    let digits = text.find(|character: char| !character.is_ascii_digit() && character != '.')?;
    let (number, unit) = text.split_at(digits);
    let unit = unit.trim().to_ascii_uppercase();
    let (_, factor) = UNITS.iter().find(|(name, _)| *name == unit)?;
    let bytes = number.parse::<f64>().ok()? * *factor as f64;
    bytes.is_finite().then_some(bytes as u64)
}

/// A set of topics: `frames,events,columns` contains frames, events and all columns.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TopicSet {
    topics: BTreeSet<Topic>,
    has_all_columns: bool,
}

/// The names of topics on a command line, besides those of single columns.
const TOPIC_NAMES: [&str; 11] = [
    "frames",
    "events",
    "commands",
    "orders",
    "contacts",
    "contact_events",
    "facilities",
    "columns",
    "poses",
    "robots",
    "graph",
];

impl TopicSet {
    /// Returns the set of all topics.
    pub fn all() -> Self {
        Self { topics: Topic::FIXED.into_iter().collect(), has_all_columns: true }
    }

    /// Whether a topic is in the set. The world always is: nothing can be read without it.
    pub fn includes(&self, topic: &Topic) -> bool {
        let is_column = topic.column().is_some();
        self.topics.contains(topic) || (is_column && self.has_all_columns)
    }
}

impl FromStr for TopicSet {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let mut set = Self { topics: BTreeSet::from([Topic::World]), has_all_columns: false };
        for name in text.split(',').map(|name| name.trim().trim_start_matches('/')) {
            match (name, Topic::from_name(&format!("/{name}"))) {
                ("columns", _) => set.has_all_columns = true,
                ("contacts" | "contact_markers", _) => set.topics.extend(CONTACTS),
                ("graph", _) => set.topics.extend([Topic::Graph, Topic::GraphPoints]),
                (_, Some(topic @ Topic::Column(_))) => drop(set.topics.insert(topic)),
                (name, Some(topic)) if TOPIC_NAMES.contains(&name) => {
                    set.topics.insert(topic);
                }
                _ => {
                    return Err(format!(
                        "unknown topic '{name}'; the topics are {}, and columns/NAME",
                        TOPIC_NAMES.join(", ")
                    ));
                }
            }
        }
        Ok(set)
    }
}

/// A set of robots' ids: `1,5,7..9` contains 1, 5, 7, 8 and 9.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RobotIds {
    /// The ranges in ascending order, without overlaps.
    ranges: Vec<RangeInclusive<u32>>,
}

impl RobotIds {
    /// Returns the set of all ids.
    pub fn all() -> Self {
        Self { ranges: vec![0..=u32::MAX] }
    }

    /// Returns the ids below `robots` in ascending order.
    pub fn below(&self, robots: usize) -> impl Iterator<Item = usize> {
        self.ranges
            .iter()
            .flat_map(move |range| *range.start() as usize..(*range.end() as usize + 1).min(robots))
    }

    /// Whether an id is in the set.
    pub fn contains(&self, robot: u32) -> bool {
        self.ranges.iter().any(|range| range.contains(&robot))
    }

    /// Returns the lowest id, or `None` if the set is empty.
    pub fn first(&self) -> Option<u32> {
        self.ranges.first().map(|range| *range.start())
    }
}

impl FromStr for RobotIds {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let mut ranges =
            text.split(',').map(parse_range).collect::<Option<Vec<_>>>().ok_or_else(|| {
                format!(
                    "invalid list of robots '{text}'; give ids and ranges with both ends, \
                 for example 1,5,7..9"
                )
            })?;
        ranges.sort_by_key(|range| *range.start());
        let mut merged: Vec<RangeInclusive<u32>> = Vec::new();
        for range in ranges {
            match merged.last_mut() {
                Some(last) if *range.start() <= last.end().saturating_add(1) => {
                    *last = *last.start()..=*last.end().max(range.end());
                }
                _ => merged.push(range),
            }
        }
        Ok(Self { ranges: merged })
    }
}

fn parse_range(text: &str) -> Option<RangeInclusive<u32>> {
    let (first, last) = text.split_once("..").unwrap_or((text, text));
    let (first, last) = (first.trim().parse().ok()?, last.trim().parse().ok()?);
    (first <= last).then_some(first..=last)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_sizes_are_parsed() {
        let parse = |text: &str| text.parse::<Limit>();
        assert_eq!(parse("10min"), Ok(Limit::Time(Duration::from_secs(600))));
        assert_eq!(parse("1h 30min"), Ok(Limit::Time(Duration::from_secs(5400))));
        assert_eq!(parse("1GB"), Ok(Limit::Bytes(1_000_000_000)));
        assert_eq!(parse("1.5 GiB"), Ok(Limit::Bytes(3 << 29)));
        assert_eq!(parse("500mb"), Ok(Limit::Bytes(500_000_000)));
        for bad in ["", "10", "GB", "10 parrots", "1.2.3GB", "-1GB", "0s", "10ms", "5KB"] {
            assert!(parse(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_set_has_the_listed_topics_and_the_world() {
        let set: TopicSet = "frames, /contacts,columns/load".parse().unwrap();
        let has = |name: &str| set.includes(&Topic::from_name(name).unwrap());
        for name in ["/frames", "/contacts", "/contact_updates", "/columns/load", "/world"] {
            assert!(has(name), "{name}");
        }
        for name in [
            "/events",
            "/commands",
            "/contact_events",
            "/columns/type",
            "/poses",
            "/robots",
            "/graph_points",
        ] {
            assert!(!has(name), "{name}");
        }
        assert!(
            "columns"
                .parse::<TopicSet>()
                .unwrap()
                .includes(&Topic::Column("type".parse().unwrap()))
        );
        assert!(Topic::FIXED.iter().all(|topic| TopicSet::all().includes(topic)));
    }

    #[test]
    fn unknown_topics_are_refused() {
        for bad in ["", "frame", "frames,", "columns/", "columns/a b", "world"] {
            let error = bad.parse::<TopicSet>().unwrap_err();
            assert!(error.contains("the topics are frames, events"), "{error}");
        }
    }

    fn listed(text: &str, robots: usize) -> Vec<usize> {
        text.parse::<RobotIds>().unwrap().below(robots).collect()
    }

    #[test]
    fn each_id_occurs_once_and_in_order() {
        assert_eq!(listed("1,5,7..9", 100), [1, 5, 7, 8, 9]);
        assert_eq!(listed("9,3..6, 5..7,1", 7), [1, 3, 4, 5, 6]);
        assert_eq!(listed("4294967295,0", 1), [0]);
        let ids: RobotIds = "1,5,7..9".parse().unwrap();
        assert_eq!(
            (0..12).filter(|robot| ids.contains(*robot)).collect::<Vec<_>>(),
            [1, 5, 7, 8, 9]
        );
        assert_eq!(RobotIds::all().below(3).collect::<Vec<_>>(), [0, 1, 2]);
        for bad in ["", "a", "1,", "3..1", "-1", "1..", "..4", "4294967296"] {
            assert!(bad.parse::<RobotIds>().is_err(), "{bad:?}");
        }
    }
}
