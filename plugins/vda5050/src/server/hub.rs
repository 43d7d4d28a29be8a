//! The clients of a broker, what they listen to, and the messages that are kept.

use std::sync::Arc;

use bytes::Bytes;
use rumqttc::{Publish, QoS, matches};
use rustc_hash::{FxHashMap, FxHashSet};
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// The most bytes of all messages that are kept; others are passed on alone.
const MOST_KEPT_BYTES: usize = 256 << 20;
/// The most bytes of messages that wait for a client, and for all clients; others are missed.
const MOST_QUEUED_BYTES: usize = 64 << 20;
const MOST_QUEUED_BYTES_OF_ALL: usize = 512 << 20;
/// The bytes of a message beside its topic and its payload.
const BYTES_BESIDE: usize = 256;
/// The most topics of a client, and filters with wildcards, with which each message is compared.
const MOST_TOPICS: usize = 100_000;
const MOST_FILTERS: usize = 100;

/// The clients of a broker.
#[derive(Debug)]
pub(super) struct Hub {
    clients: FxHashMap<u64, Client>,
    /// The numbers of clients by their names.
    names: FxHashMap<String, u64>,
    kept: FxHashMap<String, Publish>,
    kept_bytes: usize,
    /// The bytes that may wait for all clients.
    room: Arc<Semaphore>,
    /// The clients that listen to a topic without wildcards, and their quality of service.
    exact: FxHashMap<String, Vec<(u64, QoS)>>,
    last_number: u64,
}

impl Default for Hub {
    fn default() -> Self {
        Self {
            clients: FxHashMap::default(),
            names: FxHashMap::default(),
            kept: FxHashMap::default(),
            kept_bytes: 0,
            room: Arc::new(Semaphore::new(MOST_QUEUED_BYTES_OF_ALL)),
            exact: FxHashMap::default(),
            last_number: 0,
        }
    }
}

/// A message that waits for a client, with its part of the room for them.
#[derive(Debug)]
pub(super) struct Queued {
    pub(super) message: Publish,
    _of_client: OwnedSemaphorePermit,
    _of_all: OwnedSemaphorePermit,
}

/// A client.
#[derive(Debug)]
struct Client {
    name: String,
    will: Option<Publish>,
    sender: UnboundedSender<Queued>,
    /// The bytes that may wait for it, and for all clients.
    room: Arc<Semaphore>,
    room_of_all: Arc<Semaphore>,
    /// The filters with wildcards that it listens to.
    filters: Vec<(String, QoS)>,
    /// The topics that it listens to.
    topics: FxHashSet<String>,
    last_packet: u16,
}

impl Hub {
    pub(super) fn len(&self) -> usize {
        self.clients.len()
    }

    /// Adds a client, and returns its number and the messages for it. One with the same name is
    /// dropped, and its last will published before the new one is told that it is there.
    pub(super) fn join(
        &mut self,
        name: &str,
        will: Option<Publish>,
    ) -> (u64, UnboundedReceiver<Queued>) {
        let other = self.names.get(name).filter(|_| !name.is_empty()).copied();
        if let Some(will) = other.and_then(|other| self.leave(other)) {
            self.publish(&will);
        }
        // The room for its messages bounds the channel.
        let (sender, messages) = unbounded_channel();
        self.last_number += 1;
        self.names.insert(name.to_owned(), self.last_number);
        let client = Client {
            name: name.to_owned(),
            will,
            sender,
            room: Arc::new(Semaphore::new(MOST_QUEUED_BYTES)),
            room_of_all: Arc::clone(&self.room),
            filters: Vec::new(),
            topics: FxHashSet::default(),
            last_packet: 0,
        };
        self.clients.insert(self.last_number, client);
        (self.last_number, messages)
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
        if !filter.contains(['+', '#']) {
            if client.topics.len() >= MOST_TOPICS {
                return false;
            }
            if let Some(kept) = self.kept.get(&filter) {
                client.send(kept, quality, Kept::Yes);
            }
            client.topics.insert(filter.clone());
            self.exact.entry(filter).or_default().push((number, quality));
            return true;
        }
        if client.filters.len() >= MOST_FILTERS {
            return false;
        }
        for (_, kept) in self.kept.iter().filter(|(topic, _)| matches(topic, &filter)) {
            client.send(kept, quality, Kept::Yes);
        }
        client.filters.push((filter, quality));
        true
    }

    pub(super) fn unsubscribe(&mut self, number: u64, filters: &[String]) {
        let Some(client) = self.clients.get_mut(&number) else { return };
        let filters: FxHashSet<&String> = filters.iter().collect();
        client.filters.retain(|(filter, _)| !filters.contains(filter));
        let mut gone = filters;
        gone.retain(|topic| client.topics.remove(*topic));
        gone.iter().for_each(|topic| self.forget(number, topic));
    }

    /// Sends a message to those who listen to its topic, and keeps it if it is to be kept.
    pub(super) fn publish(&mut self, message: &Publish) {
        let message = &alone(message);
        let topic = topic_of(message);
        for &(number, quality) in self.exact.get(&topic).into_iter().flatten() {
            if let Some(client) = self.clients.get_mut(&number) {
                client.send(message, quality, Kept::No);
            }
        }
        for client in self.clients.values_mut().filter(|client| !client.filters.is_empty()) {
            let found = client.filters.iter().filter(|(filter, _)| matches(&topic, filter));
            let quality = found.map(|(_, quality)| *quality).reduce(higher);
            if let Some(quality) = quality {
                client.send(message, quality, Kept::No);
            }
        }
        if message.retain {
            self.keep(topic, message);
        }
    }

    /// Keeps a message in place of the one before; none if it is empty or there is no room.
    fn keep(&mut self, topic: String, message: &Publish) {
        if let Some(before) = self.kept.remove(&topic) {
            self.kept_bytes -= bytes_of(&before);
        }
        let bytes = bytes_of(message);
        if !message.payload.is_empty() && self.kept_bytes + bytes <= MOST_KEPT_BYTES {
            self.kept_bytes += bytes;
            self.kept.insert(topic, message.clone());
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
    /// Puts a message into the client's queue. A client without room for it misses it.
    fn send(&mut self, message: &Publish, quality: QoS, kept: Kept) {
        let bytes = u32::try_from(bytes_of(message)).unwrap_or(u32::MAX);
        let shares = [&self.room, &self.room_of_all]
            .map(|room| Arc::clone(room).try_acquire_many_owned(bytes));
        let [Ok(of_client), Ok(of_all)] = shares else { return };
        let mut message = message.clone();
        message.qos = lower(message.qos, quality);
        (message.retain, message.dup, message.pkid) = (kept == Kept::Yes, false, 0);
        if message.qos != QoS::AtMostOnce {
            self.last_packet = self.last_packet.checked_add(1).unwrap_or(1);
            message.pkid = self.last_packet;
        }
        // An error means that the client is about to leave.
        let queued = Queued { message, _of_client: of_client, _of_all: of_all };
        let _ = self.sender.send(queued);
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

/// The bytes that a message takes while it waits or is kept.
fn bytes_of(message: &Publish) -> usize {
    BYTES_BESIDE + 2 * message.topic.len() + message.payload.len()
}

/// Copies a message out of the bytes that came with it, which would stay in memory with it.
fn alone(message: &Publish) -> Publish {
    let (topic, payload) = (&message.topic, &message.payload);
    Publish {
        topic: Bytes::copy_from_slice(topic),
        payload: Bytes::copy_from_slice(payload),
        ..message.clone()
    }
}

fn topic_of(message: &Publish) -> String {
    String::from_utf8_lossy(&message.topic).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    const LARGE: usize = 16 << 20;

    fn message(topic: usize, bytes: usize) -> Publish {
        let mut message = Publish::new(format!("robot/{topic}"), QoS::AtMostOnce, vec![7; bytes]);
        message.retain = true;
        message
    }

    fn drain(messages: &mut UnboundedReceiver<Queued>) -> usize {
        std::iter::from_fn(|| messages.try_recv().ok()).count()
    }

    #[test]
    fn a_client_that_reads_nothing_misses_messages_and_takes_none_from_others() {
        let mut hub = Hub::default();
        let mut clients: Vec<_> = (0..2).map(|it| hub.join(&format!("{it}"), None)).collect();
        for (number, _) in &clients {
            assert!(hub.subscribe(*number, "#".to_owned(), QoS::AtMostOnce));
        }
        let mut received = 0;
        for _ in 0..8 {
            hub.publish(&message(0, LARGE));
            received += drain(&mut clients[1].1);
        }
        assert_eq!((drain(&mut clients[0].1), received), (MOST_QUEUED_BYTES / LARGE - 1, 8));
        // All have room again.
        hub.publish(&message(0, LARGE));
        assert_eq!(clients.iter_mut().map(|client| drain(&mut client.1)).sum::<usize>(), 2);
    }

    #[test]
    fn messages_that_are_kept_have_a_budget() {
        let mut hub = Hub::default();
        let most = MOST_KEPT_BYTES / LARGE - 1;
        for topic in 0..most + 3 {
            hub.publish(&message(topic, LARGE));
        }
        assert_eq!(hub.kept.len(), most);
        assert!(hub.kept_bytes <= MOST_KEPT_BYTES);
        // Another message of a topic, and an empty one, give back what the one before took.
        hub.publish(&message(0, 1));
        hub.publish(&message(1, 0));
        hub.publish(&message(most, LARGE));
        hub.publish(&message(most + 1, LARGE));
        assert_eq!(hub.kept.len(), most + 1);
        let bytes: usize = hub.kept.values().map(bytes_of).sum();
        assert_eq!(hub.kept_bytes, bytes);
    }

    /// A master that joins a large fleet.
    #[test]
    fn all_that_is_kept_comes_to_a_late_client() {
        let (mut hub, count) = (Hub::default(), 20_000);
        for topic in 0..count {
            hub.publish(&message(topic, 200));
        }
        let (number, mut messages) = hub.join("master", None);
        assert!(hub.subscribe(number, "robot/+".to_owned(), QoS::AtLeastOnce));
        assert_eq!(drain(&mut messages), count);
    }

    #[test]
    fn filters_end_where_they_are_said_to() {
        let mut hub = Hub::default();
        let (number, mut messages) = hub.join("master", None);
        for filter in ["robot/1", "robot/2", "+/3"] {
            assert!(hub.subscribe(number, filter.to_owned(), QoS::AtMostOnce));
        }
        hub.unsubscribe(number, &["robot/2".to_owned(), "+/3".to_owned(), "other".to_owned()]);
        for topic in 1..=3 {
            hub.publish(&message(topic, 1));
        }
        assert_eq!(drain(&mut messages), 1);
        for filter in 0..=MOST_FILTERS {
            let is_taken = hub.subscribe(number, format!("+/{filter}"), QoS::AtMostOnce);
            assert_eq!(is_taken, filter < MOST_FILTERS);
        }
    }
}
