//! Findings, and the list to which the parts of the judge add them.

use core::fmt;

use serde::Serialize;

use super::rule::{Rule, Severity, Side};
use super::seen::Subject;
use crate::message::Version;

/// The findings that one message can have; more are left out.
const MOST_PER_MESSAGE: usize = 20;
/// The longest name in a message, in characters.
const LONGEST_NAME: usize = 80;

/// A breach of a rule.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Finding {
    /// The id of the rule.
    #[serde(serialize_with = "id")]
    pub rule: Rule,
    /// The severity.
    #[serde(serialize_with = "name")]
    pub severity: Severity,
    /// The side that broke it.
    #[serde(serialize_with = "name")]
    pub side: Side,
    /// The version by which it is judged.
    #[serde(serialize_with = "number")]
    pub version: Version,
    /// The clause of that version.
    pub clause: &'static str,
    /// The first levels of the topics of the vehicle.
    pub vehicle: String,
    /// The last level of the topic.
    pub topic: &'static str,
    /// Seconds since 1970; `None` if it isn't known.
    pub time: Option<f64>,
    /// The number of the message in the traffic, from 1.
    pub number: u64,
    /// One sentence.
    pub message: String,
}

fn id<S: serde::Serializer>(rule: &Rule, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(rule.id())
}

fn name<T, S>(value: &T, serializer: S) -> Result<S::Ok, S::Error>
where
    T: Copy + Into<&'static str>,
    S: serde::Serializer,
{
    serializer.serialize_str((*value).into())
}

fn number<S: serde::Serializer>(version: &Version, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(version.number())
}

impl Finding {
    /// The name of the side.
    pub fn side_name(&self) -> &'static str {
        self.side.into()
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let severity: &str = self.severity.into();
        match self.time {
            Some(time) => write!(f, "{} ", super::clock::text(time))?,
            None => write!(f, "message {} ", self.number)?,
        }
        write!(f, "{severity} {}: {}/{}: ", self.rule.id(), self.vehicle, self.topic)?;
        let (side, version) = (self.side_name(), self.version.number());
        write!(f, "{} ({side}; VDA 5050 {version}, {})", self.message, self.clause)
    }
}

/// The place of findings: the message and the vehicle that are judged.
#[derive(Debug)]
pub(super) struct Notes<'a> {
    pub findings: &'a mut Vec<Finding>,
    pub vehicle: &'a str,
    pub subject: Subject,
    pub version: Version,
    pub time: Option<f64>,
    pub number: u64,
}

impl Notes<'_> {
    /// Adds a finding.
    pub fn add(&mut self, rule: Rule, message: String) {
        if self.findings.len() >= MOST_PER_MESSAGE {
            return;
        }
        let row = rule.row();
        let side = match (row.side, self.subject.is_of_master()) {
            (Side::Sender, true) => Side::Master,
            (Side::Sender, false) => Side::Vehicle,
            (side, _) => side,
        };
        self.findings.push(Finding {
            rule,
            severity: row.severity,
            side,
            version: self.version,
            clause: row.clause(self.version),
            vehicle: self.vehicle.to_owned(),
            topic: self.subject.name(),
            time: self.time,
            number: self.number,
            message,
        });
    }

    /// Whether the version is 3.0.
    pub fn is_3(&self) -> bool {
        self.version == Version::V3_0
    }
}

/// A name of a stranger in quotes, shortened.
pub(super) fn quoted(name: &str) -> String {
    match name.char_indices().nth(LONGEST_NAME) {
        Some((end, _)) => format!("'{}…'", &name[..end]),
        None => format!("'{name}'"),
    }
}
