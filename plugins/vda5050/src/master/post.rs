//! The post of a vehicle: its topics, the version that it speaks, and the headers of messages to
//! it.

use std::time::SystemTime;

use super::talk::Saying;
use crate::broker::{Broker, Delivery};
use crate::message::{
    Action, Error, Header, InstantActions, Message, OldInstantActions, Order, Topic, Version,
    encode, timestamp,
};

/// The address of a vehicle, and what was sent there.
#[derive(Debug)]
pub struct Post {
    /// The first levels of its topics.
    name: String,
    version: Version,
    /// Whether it wants instant actions as 1.1 spells them.
    wants_old_spelling: bool,
    /// The numbers of the next messages: orders, instant actions.
    header_ids: [u32; 2],
}

impl Post {
    /// Begins to write to a vehicle, by the first four levels of its topics. `None` if the level of
    /// the version is that of none that is known.
    pub fn new(name: &str) -> Option<Self> {
        let level = name.split('/').nth(1)?;
        let version = Version::ALL.into_iter().find(|version| version.level() == level)?;
        Some(Self { name: name.to_owned(), version, wants_old_spelling: false, header_ids: [0; 2] })
    }

    /// The first levels of its topics.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The version that it speaks.
    pub fn version(&self) -> Version {
        self.version
    }

    /// Learns the version from a header of the vehicle. One that isn't known is left out: the level
    /// of its topics has the major version.
    pub fn learn(&mut self, header: &Header) {
        let minor = header.version.rsplit_once('.').map_or("", |(minor, _)| minor);
        let told: Option<Version> = minor.parse().ok();
        if let Some(version) = told.filter(|version| version.level() == self.version.level()) {
            self.version = version;
        }
    }

    /// Learns the spelling that the vehicle wants from its errors: some that speak 2.0 take instant
    /// actions only as 1.1 spells them. Returns whether this is new.
    pub fn learn_spelling(&mut self, errors: &[Error]) -> bool {
        let is_old = self.version == Version::V2_0
            && errors.iter().any(|error| {
                let is_of_topic = error.reference("topic") == Some(Topic::InstantActions.name());
                is_of_topic && error.error_type == "validationError"
            });
        is_old && !std::mem::replace(&mut self.wants_old_spelling, true)
    }

    /// Sends an order or an action.
    pub fn send(&mut self, saying: Saying, broker: &Broker, link: usize) {
        match saying {
            Saying::Order(order) => self.send_order(order, broker, link),
            Saying::Instant(action) => self.send_action(action, broker, link),
        }
    }

    fn send_order(&mut self, order: Order, broker: &Broker, link: usize) {
        let header = self.header(0);
        self.publish(Order { header, ..order }, broker, link);
    }

    fn send_action(&mut self, action: Action, broker: &Broker, link: usize) {
        let header = self.header(1);
        let actions = vec![action];
        if self.wants_old_spelling {
            let message = OldInstantActions { header, instant_actions: actions };
            self.publish(message, broker, link);
        } else {
            self.publish(InstantActions { header, actions }, broker, link);
        }
    }

    fn publish<M: Message>(&self, mut message: M, broker: &Broker, link: usize) {
        message.adapt(self.version);
        let topic = format!("{}/{}", self.name, topic_name::<M>());
        broker.publish(link, &topic, encode(&message, self.version), Delivery::Now);
    }

    fn header(&mut self, kind: usize) -> Header {
        let header_id = self.header_ids[kind];
        self.header_ids[kind] = header_id.wrapping_add(1);
        let mut levels = self.name.split('/').skip(2);
        Header {
            header_id,
            timestamp: timestamp(SystemTime::now()),
            version: self.version.number().to_owned(),
            manufacturer: levels.next().unwrap_or_default().to_owned(),
            serial_number: levels.next().unwrap_or_default().to_owned(),
        }
    }
}

fn topic_name<M: Message>() -> &'static str {
    let topic: Topic = M::TOPIC;
    topic.name()
}
