//! A vehicle on a broker: its topics, its headers, and when it publishes what.

use std::time::SystemTime;

use crate::broker::{Broker, Delivery, Session};
use crate::disturb::Fate;
use crate::message::{
    Connection, ConnectionState, Factsheet, Header, Message, Topic, Version, encode, timestamp,
};
use crate::vehicle::{Site, Vehicle};

/// A vehicle and its connection.
#[derive(Debug)]
pub struct Client {
    /// The vehicle.
    pub vehicle: Vehicle,
    /// The names of a vehicle.
    identity: Identity,
    /// The disturbances that it meets in a run.
    fate: Fate,
    /// The number of its connection.
    link: usize,
    /// The numbers of the next messages, by topic.
    header_ids: [u32; Topic::ALL.len()],
    /// The times in seconds when the next messages are due.
    state_due: f64,
    visualization_due: f64,
}

/// The names of a vehicle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Identity {
    /// The first levels of its topics.
    pub prefix: String,
    /// The manufacturer.
    pub manufacturer: String,
    /// The serial number.
    pub serial_number: String,
    /// The version that it speaks.
    pub version: Version,
}

/// The times between two messages of a vehicle, in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intervals {
    /// Between two states without an event.
    pub state: f64,
    /// Between two positions; 0 for none.
    pub visualization: f64,
}

/// The time of a message.
#[derive(Clone, Debug)]
pub struct Now {
    /// The time of the day, as messages have it.
    pub text: String,
    /// Seconds since the start of the plugin.
    pub seconds: f64,
}

impl Now {
    /// The present. `seconds` are those since the start of the plugin.
    pub fn at(seconds: f64) -> Self {
        Self { text: timestamp(SystemTime::now()), seconds }
    }
}

impl Identity {
    /// The name of one of its topics.
    pub fn topic(&self, topic: Topic) -> String {
        format!("{}/{}/{}", self.prefix, self.serial_number, topic.name())
    }

    /// The topics that it listens to.
    pub fn inputs(&self) -> [(String, Topic); 2] {
        [Topic::Order, Topic::InstantActions].map(|topic| (self.topic(topic), topic))
    }

    fn header(&self, header_id: u32, now: &Now) -> Header {
        Header {
            header_id,
            timestamp: now.text.clone(),
            version: self.version.number().to_owned(),
            manufacturer: self.manufacturer.clone(),
            serial_number: self.serial_number.clone(),
        }
    }

    /// The connection of its own, with the last will.
    pub fn session(&self, now: &Now) -> Session {
        let header = self.header(0, now);
        let mut will = Connection { header, connection_state: ConnectionState::ConnectionBroken };
        will.adapt(self.version);
        let will = (self.topic(Topic::Connection), encode(&will, self.version));
        Session {
            client_id: format!("{}-{}", self.manufacturer, self.serial_number),
            will: Some(will),
            topics: self.inputs().map(|(topic, _)| topic).to_vec(),
        }
    }
}

impl Client {
    /// Creates a vehicle on a connection.
    pub fn new(
        identity: Identity,
        fate: Fate,
        link: usize,
        phase: f64,
        intervals: Intervals,
    ) -> Self {
        Self {
            vehicle: Vehicle::with_fate(identity.version, fate.clone()),
            identity,
            fate,
            link,
            header_ids: [0; Topic::ALL.len()],
            state_due: phase * intervals.state,
            visualization_due: phase * intervals.visualization,
        }
    }

    /// Its names.
    pub fn identity(&self) -> &Identity {
        &self.identity
    }

    /// The number of its connection.
    pub fn link(&self) -> usize {
        self.link
    }

    /// Forgets its order: its fleet begins anew.
    pub fn restart(&mut self) {
        self.vehicle = Vehicle::with_fate(self.identity.version, self.fate.clone());
    }

    fn next_header(&mut self, topic: Topic, now: &Now) -> Header {
        let place = Topic::ALL.iter().position(|other| *other == topic).unwrap_or_default();
        let header_id = self.header_ids[place];
        self.header_ids[place] = header_id.wrapping_add(1);
        self.identity.header(header_id, now)
    }

    fn send<M: Message>(&self, mut message: M, delivery: Delivery, broker: &Broker) {
        let version = self.identity.version;
        message.adapt(version);
        broker.publish(
            self.link,
            &self.identity.topic(M::TOPIC),
            encode(&message, version),
            delivery,
        );
    }

    /// Publishes that it is there, or no longer.
    pub fn publish_connection(&mut self, state: ConnectionState, now: &Now, broker: &Broker) {
        if !broker.is_up(self.link) {
            return;
        }
        let header = self.next_header(Topic::Connection, now);
        let message = Connection { header, connection_state: state };
        self.send(message, Delivery::Kept, broker);
    }

    /// Publishes its state. Numbers count the messages that are sent.
    pub fn publish_state(&mut self, every: f64, now: &Now, site: &Site, broker: &Broker) {
        self.state_due = now.seconds + every;
        if !broker.is_up(self.link) {
            return;
        }
        let header = self.next_header(Topic::State, now);
        self.send(self.vehicle.state(header, site), Delivery::Now, broker);
    }

    /// Publishes its properties. 3.0 keeps them.
    pub fn publish_factsheet(&mut self, factsheet: Factsheet, now: &Now, broker: &Broker) {
        if !broker.is_up(self.link) {
            return;
        }
        let header = self.next_header(Topic::Factsheet, now);
        let delivery = match self.identity.version {
            Version::V2_0 | Version::V2_1 => Delivery::Now,
            Version::V3_0 => Delivery::NowAndKept,
        };
        self.send(Factsheet { header, ..factsheet }, delivery, broker);
    }

    /// Whether a state is due, although nothing has happened.
    pub fn is_state_due(&self, now: &Now) -> bool {
        now.seconds >= self.state_due
    }

    /// Publishes its position, if that is due.
    pub fn publish_position_if_due(
        &mut self,
        intervals: Intervals,
        now: &Now,
        site: &Site,
        broker: &Broker,
    ) {
        let is_due = intervals.visualization > 0.0 && now.seconds >= self.visualization_due;
        if !is_due || !broker.is_up(self.link) {
            return;
        }
        let next = self.visualization_due + intervals.visualization;
        self.visualization_due = if next > now.seconds { next } else { now.seconds };
        let state_id = self.header_ids[2].wrapping_sub(1);
        let header = self.next_header(Topic::Visualization, now);
        let message = self.vehicle.visualization(header, state_id, site);
        self.send(message, Delivery::Now, broker);
    }
}
