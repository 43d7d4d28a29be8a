//! The clients of a broker, what they listen to, and the messages that are kept.

use rumqttc::{Publish, QoS, matches};
use rustc_hash::FxHashMap;
use tokio::sync::mpsc::Sender;

/// The most messages that are kept.
const MOST_KEPT: usize = 200_000;
/// The most filters of a client.
const MOST_FILTERS: usize = 100_000;

/// The clients of a broker.
#[derive(Debug, Default)]
pub(super) struct Hub {
    clients: FxHashMap<u64, Client>,
    /// The numbers of clients by their names.
    names: FxHashMap<String, u64>,
    kept: FxHashMap<String, Publish>,
    /// The clients that listen to a topic without wildcards, and their quality of service.
    exact: FxHashMap<String, Vec<(u64, QoS)>>,
    last_number: u64,
}

/// A client.
#[derive(Debug)]
struct Client {
    name: String,
    will: Option<Publish>,
    sender: Sender<Publish>,
    /// The filters with wildcards that it listens to.
    filters: Vec<(String, QoS)>,
    /// The topics that it listens to.
    topics: Vec<String>,
    last_packet: u16,
}

impl Hub {
    pub(super) fn len(&self) -> usize {
        self.clients.len()
    }

    /// Adds a client. One with the same name is dropped, and its last will published before the
    /// new one is told that it is there.
    pub(super) fn join(
        &mut self,
        name: &str,
        will: Option<Publish>,
        sender: Sender<Publish>,
    ) -> u64 {
        let other = self.names.get(name).filter(|_| !name.is_empty()).copied();
        if let Some(will) = other.and_then(|other| self.leave(other)) {
            self.publish(will);
        }
        self.last_number += 1;
        self.names.insert(name.to_owned(), self.last_number);
        let client = Client {
            name: name.to_owned(),
            will,
            sender,
            filters: Vec::new(),
            topics: Vec::new(),
            last_packet: 0,
        };
        self.clients.insert(self.last_number, client);
        self.last_number
    }

    /// Removes a client. Returns its last will, unless it was removed before.
    pub(super) fn leave(&mut self, number: u64) -> Option<Publish> {
        let client = self.clients.remove(&number)?;
        if self.names.get(&client.name) == Some(&number) {
            self.names.remove(&client.name);
        }
        for topic in &client.topics {
            self.forget(number, topic);
        }
        client.will
    }

    fn forget(&mut self, number: u64, topic: &str) {
        let Some(listeners) = self.exact.get_mut(topic) else { return };
        listeners.retain(|listener| listener.0 != number);
        if listeners.is_empty() {
            self.exact.remove(topic);
        }
    }

    /// Lets a client listen, and sends it what is kept. Returns whether it may.
    pub(super) fn subscribe(&mut self, number: u64, filter: String, quality: QoS) -> bool {
        self.unsubscribe(number, std::slice::from_ref(&filter));
        let Some(client) = self.clients.get_mut(&number) else { return false };
        if client.filters.len() + client.topics.len() >= MOST_FILTERS {
            return false;
        }
        let kept = self.kept.values().filter(|kept| matches(&topic_of(kept), &filter));
        kept.for_each(|kept| client.send(kept, quality, Kept::Yes));
        if filter.contains(['+', '#']) {
            client.filters.push((filter, quality));
        } else {
            client.topics.push(filter.clone());
            self.exact.entry(filter).or_default().push((number, quality));
        }
        true
    }

    pub(super) fn unsubscribe(&mut self, number: u64, filters: &[String]) {
        let Some(client) = self.clients.get_mut(&number) else { return };
        client.filters.retain(|(filter, _)| !filters.contains(filter));
        let gone: Vec<_> = client.topics.extract_if(.., |it| filters.contains(it)).collect();
        gone.iter().for_each(|topic| self.forget(number, topic));
    }

    /// Sends a message to those who listen to its topic, and keeps it if it is to be kept.
    pub(super) fn publish(&mut self, message: Publish) {
        let topic = topic_of(&message);
        for &(number, quality) in self.exact.get(&topic).into_iter().flatten() {
            if let Some(client) = self.clients.get_mut(&number) {
                client.send(&message, quality, Kept::No);
            }
        }
        for client in self.clients.values_mut().filter(|client| !client.filters.is_empty()) {
            let found = client.filters.iter().filter(|(filter, _)| matches(&topic, filter));
            let quality = found.map(|(_, quality)| *quality).reduce(higher);
            if let Some(quality) = quality {
                client.send(&message, quality, Kept::No);
            }
        }
        if !message.retain {
            return;
        }
        if message.payload.is_empty() {
            self.kept.remove(&topic);
        } else if self.kept.len() < MOST_KEPT || self.kept.contains_key(&topic) {
            self.kept.insert(topic, message);
        }
    }
}

/// Whether a message was kept when it is sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kept {
    Yes,
    No,
}

impl Client {
    /// Puts a message into the client's queue. One that is full misses it.
    fn send(&mut self, message: &Publish, quality: QoS, kept: Kept) {
        let mut message = message.clone();
        message.qos = lower(message.qos, quality);
        (message.retain, message.dup, message.pkid) = (kept == Kept::Yes, false, 0);
        if message.qos != QoS::AtMostOnce {
            self.last_packet = self.last_packet.checked_add(1).unwrap_or(1);
            message.pkid = self.last_packet;
        }
        let _ = self.sender.try_send(message);
    }
}

/// The lower of two qualities of service; 2 counts as 1.
pub(super) fn lower(one: QoS, other: QoS) -> QoS {
    match [one, other].contains(&QoS::AtMostOnce) {
        true => QoS::AtMostOnce,
        false => QoS::AtLeastOnce,
    }
}

/// The higher of two qualities of service; 2 counts as 1.
fn higher(one: QoS, other: QoS) -> QoS {
    if one == QoS::AtMostOnce { other } else { lower(one, one) }
}

fn topic_of(message: &Publish) -> String {
    String::from_utf8_lossy(&message.topic).into_owned()
}
