//! The judge of VDA 5050 traffic: it finds breaches of the standard by masters and vehicles.
//!
//! ```text
//!   recording ──▶ traffic ──▶ Seen ──▶ Judge ──▶ Finding ──▶ Report ──▶ text, JSON, JUnit
//! ```
//!
//! A [`Judge`] takes messages in the order in which they were seen on a broker, and returns what is
//! wrong with each. It has no connections, files and clocks. [`RULES`] is the table of all rules.
//!
//! ```
//! use regatta_vda5050::judge::{Judge, Protocol, Rule, Seen};
//!
//! let mut judge = Judge::new(Protocol::Auto);
//! let topic = "uagv/v2/KIT/0001/order";
//! let findings = judge.take(&Seen { time: None, topic, payload: b"{", delivery: None });
//! assert_eq!(findings[0].rule, Rule::Json);
//! ```

mod actions;
pub mod clock;
mod curve;
mod finding;
mod fleet;
mod header;
mod master;
mod order;
mod place;
mod progress;
mod range;
mod rejection;
mod report;
mod route;
mod rule;
mod schema;
mod seen;
#[cfg(test)]
mod tests;
pub mod traffic;
mod vehicle;

use rustc_hash::FxHashMap;
use serde_json::Value;

pub use finding::Finding;
pub use report::{Report, Strictness};
pub use rule::{RULES, Rule, RuleRow, Severity, Side};
pub use seen::{Delivery, Protocol, Seen};

use crate::message::{self, DecodeError, Message, Position, Topic, Version};
use finding::{Notes, quoted};
use fleet::Fleet;
use schema::Book;
use seen::{Address, Subject};
use vehicle::Vehicle;

/// The largest message that is judged, in bytes.
const MOST_BYTES: usize = 4 << 20;
/// The most vehicles that are judged; messages of others are counted.
const MOST_VEHICLES: usize = 50_000;
/// Seconds between two looks for what should have come.
const WATCH: f64 = 1.0;
/// Seconds by which times of messages may jump, if only messages tell the time.
const MOST_JUMP: f64 = 3600.0;

/// Finds breaches of the standard in the traffic of a broker.
#[derive(Debug)]
pub struct Judge {
    protocol: Protocol,
    book: &'static Book,
    vehicles: FxHashMap<String, Vehicle>,
    versions: FxHashMap<String, Version>,
    fleet: Fleet,
    tally: Tally,
    /// The time of the traffic.
    now: f64,
    watched: f64,
}

/// The number of messages that a judge has taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Messages of the standard.
    pub judged: u64,
    /// Messages that came again, unchanged. A broker may deliver one twice: that is no breach.
    pub repeated: u64,
    /// Messages of other topics.
    pub others: u64,
    /// Messages of vehicles beyond the most that are judged.
    pub left_out: u64,
}

impl Judge {
    /// Creates a judge that has seen nothing yet.
    pub fn new(protocol: Protocol) -> Self {
        Self {
            protocol,
            book: Book::shared(),
            vehicles: FxHashMap::default(),
            versions: FxHashMap::default(),
            fleet: Fleet::default(),
            tally: Tally::default(),
            now: 0.0,
            watched: f64::NEG_INFINITY,
        }
    }

    /// The number of messages so far.
    pub fn tally(&self) -> Tally {
        self.tally
    }

    /// The number of vehicles so far.
    pub fn vehicles(&self) -> usize {
        self.vehicles.len()
    }

    /// The vehicles whose size isn't known: contacts of these aren't found.
    pub fn vehicles_without_size(&self) -> usize {
        self.vehicles.values().filter(|vehicle| vehicle.footprint.is_none()).count()
    }

    /// Takes the next message, and returns what is wrong with it, or missing by now.
    pub fn take(&mut self, seen: &Seen<'_>) -> Vec<Finding> {
        let mut findings = Vec::new();
        let Some(address) = Address::of(seen.topic) else {
            self.tally.others += 1;
            return findings;
        };
        let is_known = self.vehicles.contains_key(address.vehicle);
        if !is_known && self.vehicles.len() >= MOST_VEHICLES {
            self.tally.left_out += 1;
            return findings;
        }
        self.tally.judged += 1;
        let content = read(seen.payload);
        if let Some(time) = seen.time.or_else(|| self.told_time(&address, content.as_ref().ok())) {
            findings.extend(self.pass(time));
        }
        let mut vehicle = self.vehicles.remove(address.vehicle).unwrap_or_default();
        self.judge(seen, &address, content, &mut vehicle, &mut findings);
        self.vehicles.insert(address.vehicle.to_owned(), vehicle);
        findings
    }

    /// The time that a message tells, if nothing else does.
    fn told_time(&self, address: &Address<'_>, content: Option<&Value>) -> Option<f64> {
        // A connection message may be a last will, or kept: both are old.
        if address.subject.is_none_or(Subject::is_kept) {
            return None;
        }
        let time = clock::seconds(content?.get("timestamp")?.as_str()?)?;
        (self.now == 0.0 || time - self.now <= MOST_JUMP).then_some(time)
    }

    /// Lets time pass, in seconds since 1970, and returns what should have come by now.
    pub fn pass(&mut self, time: f64) -> Vec<Finding> {
        let mut findings = Vec::new();
        if !time.is_finite() {
            return findings;
        }
        self.now = self.now.max(time);
        if self.now - self.watched < WATCH {
            return findings;
        }
        self.watched = self.now;
        for (name, vehicle) in &mut self.vehicles {
            let mut notes = Notes {
                findings: &mut findings,
                vehicle: name,
                subject: Subject::Read(Topic::State),
                version: self.versions.get(name).copied().unwrap_or_default(),
                time: Some(self.now),
                number: self.tally.judged,
            };
            vehicle.watch(self.now, &mut notes);
        }
        // The order of a hash map is of no meaning.
        findings.sort_by(|one, other| one.vehicle.cmp(&other.vehicle));
        findings
    }

    fn judge(
        &mut self,
        seen: &Seen<'_>,
        address: &Address<'_>,
        content: Result<Value, String>,
        vehicle: &mut Vehicle,
        findings: &mut Vec<Finding>,
    ) {
        let version = match &content {
            Ok(content) => header::version(content, address, self.protocol),
            Err(_) => self.version_of_topic(address),
        };
        let mut own = Vec::new();
        let mut notes = Notes {
            findings: &mut own,
            vehicle: address.vehicle,
            subject: address.subject.unwrap_or(Subject::Read(Topic::State)),
            version,
            time: seen.time.or((self.now > 0.0).then_some(self.now)),
            number: self.tally.judged,
        };
        header::judge_serial_number(address, &mut notes);
        let Some(subject) = address.subject else {
            let name = seen.topic.rsplit('/').next().unwrap_or_default();
            notes.add(Rule::Topic, format!("topic {} isn't of the standard", quoted(name)));
            findings.append(&mut own);
            return;
        };
        seen.delivery.into_iter().for_each(|way| header::judge_delivery(way, &mut notes));
        match content {
            Ok(_) if vehicle.headers.is_delivered_again(seen.payload, subject) => {
                self.tally.repeated += 1;
                return findings.append(&mut own);
            }
            Ok(content) => {
                self.judge_content(seen, address, &content, vehicle, &mut notes);
                self.versions.insert(address.vehicle.to_owned(), version);
            }
            Err(reason) => notes.add(Rule::Json, reason),
        }
        if subject == Subject::Read(Topic::State) {
            keep_new(&mut own, &mut vehicle.told);
        }
        findings.append(&mut own);
    }

    /// The version of a message without a header: that of the messages before.
    fn version_of_topic(&self, address: &Address<'_>) -> Version {
        let last = self.versions.get(address.vehicle).copied();
        last.unwrap_or_else(|| header::version(&Value::Null, address, self.protocol))
    }

    fn judge_content(
        &mut self,
        seen: &Seen<'_>,
        address: &Address<'_>,
        content: &Value,
        vehicle: &mut Vehicle,
        notes: &mut Notes<'_>,
    ) {
        vehicle.headers.judge(content, address, self.protocol, notes);
        let stamp = content.get("timestamp").and_then(Value::as_str);
        if let (Some(stamp), Some(came)) = (stamp, seen.time) {
            header::judge_skew(stamp, came, notes);
        }
        self.book.judge(content, notes);
        match notes.subject {
            Subject::Read(topic) => self.judge_topic(topic, seen.payload, vehicle, notes),
            Subject::ZoneSet | Subject::Responses => {}
        }
    }

    fn judge_topic(
        &mut self,
        topic: Topic,
        payload: &[u8],
        vehicle: &mut Vehicle,
        notes: &mut Notes<'_>,
    ) {
        let now = self.now;
        match topic {
            Topic::Order => {
                if let Some(order) = decode::<message::Order>(payload, notes) {
                    master::take_order(vehicle, &order, now, notes);
                    self.judge_base(vehicle, notes);
                }
            }
            Topic::InstantActions => {
                if let Some(actions) = decode(payload, notes) {
                    master::take_actions(vehicle, &actions, now, notes);
                }
            }
            Topic::State => {
                if let Some(state) = decode::<message::State>(payload, notes) {
                    let position = state.mobile_robot_position.clone();
                    vehicle.take_state(state, now, notes);
                    self.judge_base(vehicle, notes);
                    self.judge_position(position.as_ref(), vehicle, notes);
                }
            }
            Topic::Visualization => {
                if let Some(seen) = decode::<message::Visualization>(payload, notes) {
                    vehicle.take_visualization(&seen, notes);
                    self.judge_position(seen.mobile_robot_position.as_ref(), vehicle, notes);
                }
            }
            Topic::Connection => {
                if let Some(connection) = decode(payload, notes) {
                    vehicle.take_connection(&connection, now);
                }
            }
            Topic::Factsheet => {
                if let Some(factsheet) = decode(payload, notes) {
                    vehicle.take_factsheet(&factsheet);
                }
            }
        }
    }

    fn judge_position(
        &mut self,
        position: Option<&Position>,
        vehicle: &Vehicle,
        notes: &mut Notes<'_>,
    ) {
        if let Some(position) = position {
            self.fleet.take_place(position, vehicle.footprint, self.now, notes);
        }
    }

    /// The base of the vehicle from its last node on, against the bases of others.
    fn judge_base(&mut self, vehicle: &Vehicle, notes: &mut Notes<'_>) {
        let Some(route) = vehicle.orders.latest() else {
            return self.fleet.forget_base(notes.vehicle);
        };
        let shown = vehicle.state.as_ref().filter(|state| state.order_id == route.order_id);
        let is_over = shown.is_some_and(|_| !vehicle.has_order());
        match shown {
            Some(_) if is_over => self.fleet.forget_base(notes.vehicle),
            Some(state) => self.fleet.take_base(route, state.last_node_sequence_id, notes),
            None => self.fleet.take_base(route, 0, notes),
        }
    }
}

fn read(payload: &[u8]) -> Result<Value, String> {
    if payload.len() > MOST_BYTES {
        return Err(format!("{} bytes are too many to be judged", payload.len()));
    }
    serde_json::from_slice(payload).map_err(|error| format!("the message isn't JSON: {error}"))
}

/// Reads a message. If it can't be read, the schema has said so, or this does.
fn decode<M: Message>(payload: &[u8], notes: &mut Notes<'_>) -> Option<M> {
    match message::decode(payload) {
        Ok(message) => Some(message),
        Err(error) => {
            add_unread(&error, notes);
            None
        }
    }
}

fn add_unread(error: &DecodeError, notes: &mut Notes<'_>) {
    let by_schema =
        [Rule::MissingField, Rule::FieldType, Rule::UnknownValue, Rule::ValueRange, Rule::Schema];
    if !notes.findings.iter().any(|finding| by_schema.contains(&finding.rule)) {
        notes.add(Rule::Schema, format!("the message can't be read: {}", error.reason()));
    }
}

/// Leaves out the findings that the state before had, too.
fn keep_new(findings: &mut Vec<Finding>, told: &mut Vec<Finding>) {
    let all = findings.clone();
    findings.retain(|finding| {
        !told.iter().any(|old| old.rule == finding.rule && old.message == finding.message)
    });
    *told = all;
}
