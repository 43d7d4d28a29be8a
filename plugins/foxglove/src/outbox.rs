//! The next messages of a client. The plugin and the desk put messages in, the client's connection
//! takes them out as fast as the client reads; they never wait for each other.
//!
//! Its size is bounded: of a state (frames, time, contacts) only the newest message waits, of a log
//! some of the newest, and a client that asks for more answers than it reads is cut off.

use std::collections::VecDeque;

use bytes::Bytes;
use parking_lot::Mutex;
use tokio::sync::Notify;
use tokio_tungstenite::tungstenite::Message;

use crate::channel::{Channel, ChannelSet};
use crate::parameters::Parameters;
use crate::protocol::response::{self, Level};

/// The most answers that wait.
const MOST_ANSWERS: usize = 256;
/// The most entries of a log that wait; the oldest are dropped for more.
const MOST_ENTRIES: usize = 1_000;
/// The lost frames after which the client is told.
const MANY_LOST: u64 = 100;
/// Lichtblick shows advice beside a status with this text.
const SLOW: &str = "Send buffer limit reached";

/// An encoded message, which all subscribers share.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Sample {
    pub channel: Channel,
    /// Simulated time.
    pub nanos: u64,
    pub data: Bytes,
}

/// The messages that a client is to get.
#[derive(Debug, Default)]
pub(crate) struct Outbox {
    contents: Mutex<Contents>,
    wake: Notify,
}

#[derive(Debug, Default)]
struct Contents {
    /// The client's numbers of channels.
    subscriptions: Vec<(Channel, u32)>,
    /// The channels that have had no message since the client subscribed.
    hungry: ChannelSet,
    /// The names of the parameters whose changes the client wants to know.
    watched: Vec<&'static str>,
    answers: VecDeque<Message>,
    nanos: Option<u64>,
    /// The newest message of each channel, the oldest first.
    newest: VecDeque<Sample>,
    entries: VecDeque<Sample>,
    /// Messages that were replaced before the client was ready for them.
    lost: u64,
    /// Whether there were too many answers.
    is_overrun: bool,
}

/// The next message.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Next {
    Message(Message),
    /// The client asks for more answers than it reads.
    Overrun,
}

impl Outbox {
    /// Waits for what comes next, and takes it.
    pub async fn next(&self) -> Next {
        loop {
            if let Some(next) = self.contents.lock().take() {
                return next;
            }
            self.wake.notified().await;
        }
    }

    /// Puts in an answer.
    pub fn answer(&self, message: Message) {
        let mut contents = self.contents.lock();
        contents.is_overrun |= contents.answers.len() >= MOST_ANSWERS;
        if !contents.is_overrun {
            contents.answers.push_back(message);
        }
        drop(contents);
        self.wake.notify_one();
    }

    /// Puts in a status.
    pub fn status(&self, level: Level, message: &str) {
        self.answer(response::status(level, message));
    }

    /// Subscribes to a channel, with the client's number. Fails if it is subscribed to already.
    pub fn subscribe(&self, channel: Channel, id: u32) -> bool {
        let mut contents = self.contents.lock();
        if contents.subscriptions.iter().any(|(other, number)| *other == channel || *number == id) {
            return false;
        }
        contents.subscriptions.push((channel, id));
        contents.hungry = contents.hungry.with(channel);
        true
    }

    /// Ends a subscription. Fails if there is none with this number.
    pub fn unsubscribe(&self, id: u32) -> bool {
        let mut contents = self.contents.lock();
        let Some(index) = contents.subscriptions.iter().position(|(_, number)| *number == id)
        else {
            return false;
        };
        let (channel, _) = contents.subscriptions.swap_remove(index);
        contents.hungry = contents.hungry.without(channel);
        contents.newest.retain(|sample| sample.channel != channel);
        if channel.is_log() {
            contents.entries.clear();
        }
        true
    }

    /// Watches parameters, all of them if there are no names, or no more.
    pub fn watch(&self, names: &[String], is_watched: bool) {
        let mut contents = self.contents.lock();
        for name in Parameters::NAMES {
            if names.is_empty() || names.iter().any(|of| of == name) {
                contents.watched.retain(|watched| *watched != name);
                contents.watched.extend(is_watched.then_some(name));
            }
        }
    }

    /// The channels that the client reads, and those of them that have had no message yet.
    pub fn wanted(&self) -> (ChannelSet, ChannelSet) {
        let contents = self.contents.lock();
        let channels: Vec<_> = contents.subscriptions.iter().map(|(channel, _)| *channel).collect();
        (ChannelSet::of(&channels), contents.hungry)
    }

    /// Makes channels hungry: what was sent on them is no longer true.
    pub fn renew(&self, channels: &[Channel]) {
        let mut contents = self.contents.lock();
        for (channel, _) in contents.subscriptions.clone() {
            if channels.contains(&channel) {
                contents.hungry = contents.hungry.with(channel);
            }
        }
    }

    /// Puts in the time.
    pub fn set_time(&self, nanos: u64) {
        self.contents.lock().nanos = Some(nanos);
        self.wake.notify_one();
    }

    /// Puts in a message, if the client reads the channel.
    pub fn put(&self, sample: &Sample) {
        let mut contents = self.contents.lock();
        if contents.subscriptions.iter().all(|(channel, _)| *channel != sample.channel) {
            return;
        }
        contents.hungry = contents.hungry.without(sample.channel);
        contents.put(sample.clone());
        drop(contents);
        self.wake.notify_one();
    }

    /// Puts in changed parameters, if the client watches them.
    pub fn tell_parameters(&self, parameters: &Parameters) {
        let watched = self.contents.lock().watched.clone();
        if !watched.is_empty() {
            self.answer(response::parameter_values(parameters.named(&watched), None));
        }
    }

    /// Forgets the messages of a run, when another begins.
    pub fn forget_run(&self) {
        let mut contents = self.contents.lock();
        contents.newest.clear();
        contents.entries.clear();
        contents.nanos = None;
    }
}

impl Contents {
    fn put(&mut self, sample: Sample) {
        if sample.channel.is_log() {
            if self.entries.len() == MOST_ENTRIES {
                self.entries.pop_front();
            }
            self.entries.push_back(sample);
            return;
        }
        // It takes the place of the one before, so that every channel has its turn.
        match self.newest.iter_mut().find(|waiting| waiting.channel == sample.channel) {
            Some(waiting) => {
                *waiting = sample;
                self.lose();
            }
            None => self.newest.push_back(sample),
        }
    }

    fn lose(&mut self) {
        self.lost += 1;
        if self.lost == MANY_LOST && self.answers.len() < MOST_ANSWERS {
            self.answers.push_back(response::status(Level::Warning, SLOW));
        }
    }

    fn take(&mut self) -> Option<Next> {
        if self.is_overrun {
            return Some(Next::Overrun);
        }
        if let Some(answer) = self.answers.pop_front() {
            return Some(Next::Message(answer));
        }
        if let Some(nanos) = self.nanos.take() {
            return Some(Next::Message(response::time(nanos)));
        }
        let sample = self.entries.pop_front().or_else(|| self.newest.pop_front())?;
        let subscription = self.subscriptions.iter().find(|(of, _)| *of == sample.channel)?;
        Some(Next::Message(response::message_data(subscription.1, sample.nanos, &sample.data)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(channel: Channel, nanos: u64) -> Sample {
        Sample { channel, nanos, data: Bytes::from_static(b"x") }
    }

    fn all(outbox: &Outbox) -> Vec<Next> {
        std::iter::from_fn(|| outbox.contents.lock().take()).collect()
    }

    fn data(subscription: u32, nanos: u64) -> Next {
        Next::Message(response::message_data(subscription, nanos, b"x"))
    }

    #[test]
    fn of_a_state_only_the_newest_message_waits_and_of_a_log_all() {
        let outbox = Outbox::default();
        for (channel, id) in [(Channel::Frames, 5), (Channel::Log, 6), (Channel::Robots, 7)] {
            assert!(outbox.subscribe(channel, id));
        }
        for nanos in 1..4 {
            for channel in [Channel::Robots, Channel::Frames, Channel::Log, Channel::World] {
                outbox.put(&sample(channel, nanos));
            }
        }
        outbox.set_time(3);
        let time = Next::Message(response::time(3));
        let entries = [data(6, 1), data(6, 2), data(6, 3)];
        assert_eq!(all(&outbox)[0], time);
        for nanos in 1..4 {
            outbox.put(&sample(Channel::Log, nanos));
        }
        outbox.put(&sample(Channel::Robots, 4));
        outbox.put(&sample(Channel::Frames, 4));
        outbox.put(&sample(Channel::Robots, 5));
        let expected: Vec<_> = entries.into_iter().chain([data(7, 5), data(5, 4)]).collect();
        assert_eq!(all(&outbox), expected);
    }

    #[test]
    fn channels_are_hungry_until_their_first_message() {
        let outbox = Outbox::default();
        assert!(outbox.subscribe(Channel::World, 1) && !outbox.subscribe(Channel::World, 2));
        assert!(!outbox.subscribe(Channel::Graph, 1), "the number is taken");
        let world = ChannelSet::default().with(Channel::World);
        assert_eq!(outbox.wanted(), (world, world));
        outbox.put(&sample(Channel::World, 1));
        assert_eq!(outbox.wanted(), (world, ChannelSet::default()));
        outbox.renew(&Channel::OF_WORLDS);
        assert_eq!(outbox.wanted(), (world, world), "but not those that aren't subscribed to");
        assert!(outbox.unsubscribe(1) && !outbox.unsubscribe(1));
        assert_eq!(all(&outbox), [], "nothing waits of a subscription that has ended");
    }

    #[test]
    fn answers_that_nobody_reads_are_bounded() {
        let outbox = Outbox::default();
        for _ in 0..MOST_ANSWERS {
            outbox.status(Level::Error, "no");
        }
        assert!(matches!(outbox.contents.lock().take(), Some(Next::Message(_))));
        for _ in 0..2 {
            outbox.status(Level::Error, "no");
        }
        assert_eq!(outbox.contents.lock().take(), Some(Next::Overrun));
    }

    #[test]
    fn a_slow_client_is_told_once() {
        let outbox = Outbox::default();
        assert!(outbox.subscribe(Channel::Robots, 0));
        for nanos in 0..3 * MANY_LOST {
            outbox.put(&sample(Channel::Robots, nanos));
        }
        let warning = Next::Message(response::status(Level::Warning, SLOW));
        assert_eq!(all(&outbox), [warning, data(0, 3 * MANY_LOST - 1)]);
    }
}
