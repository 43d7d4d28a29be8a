//! The headers of messages: versions, numbers, times, names.

use std::collections::VecDeque;
use std::hash::{Hash as _, Hasher as _};

use rustc_hash::FxHasher;
use serde_json::Value;

use super::clock;
use super::finding::{Notes, quoted};
use super::rule::Rule;
use super::seen::{Address, Delivery, Protocol, Subject};
use crate::message::{Topic, Version};

/// Seconds by which the time of a message may differ from the time when it came.
const MOST_SKEW: f64 = 10.0;

/// The messages of a topic among which one that comes again is recognised. A broker delivers those
/// again that weren't acknowledged, and has at most 20 of them under way.
const MOST_KNOWN: usize = 20;

/// The last headers of a vehicle's topics.
#[derive(Debug, Default)]
pub(super) struct Headers {
    last: [Option<Last>; Subject::COUNT],
    /// The digests of the last messages.
    known: [VecDeque<u64>; Subject::COUNT],
    version: Option<Version>,
}

#[derive(Clone, Copy, Debug)]
struct Last {
    id: u64,
    time: Option<f64>,
}

/// The version by which a message is judged: that of its header, or else of its topic.
pub(super) fn version(content: &Value, address: &Address<'_>, protocol: Protocol) -> Version {
    if let Protocol::Only(version) = protocol {
        return version;
    }
    match (text(content, "version").and_then(named), address.major) {
        (Some(version), _) => version,
        (None, '3') => Version::V3_0,
        (None, _) => Version::V2_0,
    }
}

fn named(text: &str) -> Option<Version> {
    Version::ALL.into_iter().find(|version| version.number() == text)
}

fn text<'a>(content: &'a Value, field: &str) -> Option<&'a str> {
    content.get(field).and_then(Value::as_str)
}

impl Headers {
    /// Takes a message, and returns whether it came before and was delivered again, as a broker may
    /// do: all of it is the same, with its number and its time. What a broker keeps comes again by
    /// its nature.
    pub fn is_delivered_again(&mut self, payload: &[u8], subject: Subject) -> bool {
        if subject.is_kept() {
            return false;
        }
        let mut hasher = FxHasher::default();
        payload.hash(&mut hasher);
        let digest = hasher.finish();
        let known = &mut self.known[subject.index()];
        if known.contains(&digest) {
            return true;
        }
        if known.len() == MOST_KNOWN {
            known.pop_front();
        }
        known.push_back(digest);
        false
    }

    /// Judges the header of a message.
    pub fn judge(
        &mut self,
        content: &Value,
        address: &Address<'_>,
        protocol: Protocol,
        notes: &mut Notes<'_>,
    ) {
        judge_version(content, address, protocol, notes);
        self.judge_change(notes);
        judge_identity(content, address, notes);
        self.judge_order(content, notes);
    }

    fn judge_change(&mut self, notes: &mut Notes<'_>) {
        let last = self.version.replace(notes.version);
        if let Some(last) = last.filter(|last| *last != notes.version) {
            let text = format!("version {} after messages of version {last}", notes.version);
            notes.add(Rule::VersionChanges, text);
        }
    }

    /// Judges number and time against those of the message before on the topic.
    fn judge_order(&mut self, content: &Value, notes: &mut Notes<'_>) {
        // A last will was written when its connection was made: both are old.
        let state = text(content, "connectionState").unwrap_or_default();
        let is_will = state.starts_with("CONNECTION");
        let stamp = text(content, "timestamp");
        let time = stamp.and_then(clock::seconds);
        if let Some(stamp) = stamp.filter(|_| time.is_none()) {
            notes.add(Rule::TimestampForm, format!("timestamp {} isn't UTC", quoted(stamp)));
        }
        let id = content.get("headerId").and_then(Value::as_u64);
        let (Some(id), false) = (id, is_will) else { return };
        let last = self.last[notes.subject.index()].replace(Last { id, time });
        let Some(last) = last else { return };
        let is_kept_copy = notes.subject.is_kept() && (last.id, last.time) == (id, time);
        // Numbers begin again with their sender, and after the largest one.
        let is_restart = id <= 1;
        if is_kept_copy || is_restart {
            return;
        }
        judge_number(last.id, id, notes);
        if let (Some(last), Some(time)) = (last.time, time)
            && time < last
        {
            let back = last - time;
            notes.add(Rule::TimestampBackwards, format!("timestamp goes back by {back:.3} s"));
        }
    }
}

fn judge_number(last: u64, id: u64, notes: &mut Notes<'_>) {
    if id <= last {
        notes.add(Rule::HeaderIdRepeated, format!("headerId {id} after {last}"));
    } else if id > last + 1 {
        let missing = id - last - 1;
        notes.add(Rule::HeaderIdGap, format!("headerId {id} after {last}: {missing} are missing"));
    }
}

fn judge_version(
    content: &Value,
    address: &Address<'_>,
    protocol: Protocol,
    notes: &mut Notes<'_>,
) {
    let Some(version) = text(content, "version") else { return };
    let is_asked = matches!(protocol, Protocol::Only(asked) if asked.number() != version);
    if named(version).is_none() || is_asked {
        notes.add(Rule::VersionUnknown, format!("version {} in the header", quoted(version)));
    } else if !version.starts_with(address.major) {
        let (version, major) = (quoted(version), address.major);
        notes.add(Rule::VersionOfTopic, format!("version {version} on a topic of v{major}"));
    }
}

fn judge_identity(content: &Value, address: &Address<'_>, notes: &mut Notes<'_>) {
    for (field, level) in
        [("manufacturer", address.manufacturer), ("serialNumber", address.serial_number)]
    {
        if let Some(name) = text(content, field).filter(|name| *name != level) {
            let (name, level) = (quoted(name), quoted(level));
            notes.add(Rule::Identity, format!("{field} is {name}, in the topic {level}"));
        }
    }
}

/// Judges the serial number of a topic.
pub(super) fn judge_serial_number(address: &Address<'_>, notes: &mut Notes<'_>) {
    if address.serial_number.is_empty() || !address.serial_number.bytes().all(is_serial) {
        let name = quoted(address.serial_number);
        notes.add(Rule::SerialNumber, format!("serial number {name}"));
    }
}

/// Whether a character may be in a serial number.
const fn is_serial(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'.' | b':' | b'-')
}

/// Judges how a message was published.
pub(super) fn judge_delivery(delivery: Delivery, notes: &mut Notes<'_>) {
    let wanted = u8::from(notes.subject == Subject::Read(Topic::Connection));
    if delivery.quality != wanted {
        let text = format!("quality of service {}, not {wanted}", delivery.quality);
        notes.add(Rule::QualityOfService, text);
    }
    if delivery.retained {
        return;
    }
    match notes.subject {
        Subject::Read(Topic::Connection) => {
            notes.add(Rule::ConnectionNotRetained, "the message isn't retained".to_owned());
        }
        Subject::Read(Topic::Factsheet) if notes.version != Version::V2_0 => {
            notes.add(Rule::FactsheetNotRetained, "the message isn't retained".to_owned());
        }
        _ => {}
    }
}

/// Judges the time of a message against the time when it came.
pub(super) fn judge_skew(stamp: &str, came: f64, notes: &mut Notes<'_>) {
    // The broker keeps old messages.
    if notes.subject.is_kept() {
        return;
    }
    if let Some(time) = clock::seconds(stamp)
        && (time - came).abs() > MOST_SKEW
    {
        let text = format!("timestamp {} came at {}", quoted(stamp), clock::text(came));
        notes.add(Rule::ClockSkew, text);
    }
}
