//! One side of the topics of a vehicle: it sends messages, and waits for those of the other side.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use rumqttc::{
    Client, Connection, Event, LastWill, MqttOptions, Packet, Publish, PublishOptions, QoS,
};
use serde_json::{Value, json};

use crate::fleet::TIMEOUT;

/// The master of one vehicle, or the vehicle of a master.
pub struct Master {
    client: Client,
    messages: Receiver<Publish>,
    prefix: String,
    header_id: u32,
}

impl Master {
    /// Connects to a broker of this machine. The prefix is that of the vehicle's topics.
    pub fn connect(port: u16, prefix: &str) -> Self {
        Self::connect_with(MqttOptions::new(client_id(), ("127.0.0.1", port)), prefix)
    }

    /// Connects with a user and a password.
    pub fn connect_as(port: u16, prefix: &str, user: &str, password: &str) -> Self {
        let mut options = MqttOptions::new(client_id(), ("127.0.0.1", port));
        options.set_credentials(user, password.to_owned());
        Self::connect_with(options, prefix)
    }

    /// Connects as a vehicle whose connection the broker tells to be broken when it is lost.
    pub fn connect_with_will(port: u16, prefix: &str) -> Self {
        let will = Self::with_header_of(0, json!({"connectionState": "CONNECTIONBROKEN"}));
        let topic = format!("{prefix}/connection");
        let mut options = MqttOptions::new(client_id(), ("127.0.0.1", port));
        options.set_last_will(LastWill::new(topic, will.to_string(), QoS::AtLeastOnce, true));
        Self::connect_with(options, prefix)
    }

    fn connect_with(mut options: MqttOptions, prefix: &str) -> Self {
        options.set_max_packet_size(1 << 24, 1 << 24);
        let (client, connection) = Client::builder(options).capacity(100).build();
        client.subscribe(format!("{prefix}/+"), QoS::AtLeastOnce).expect("a request");
        Self { client, messages: follow(connection), prefix: prefix.to_owned(), header_id: 0 }
    }

    /// Sends a message, with a header.
    pub fn send(&mut self, topic: &str, message: Value) {
        let text = self.with_header(message).to_string();
        self.send_text(topic, &text);
    }

    /// Sends a message, with a header, that the broker keeps.
    pub fn send_kept(&mut self, topic: &str, message: Value) {
        let topic = format!("{}/{topic}", self.prefix);
        let options = PublishOptions::new(QoS::AtLeastOnce).retained();
        let text = self.with_header(message).to_string();
        self.client.publish(topic, text, options).expect("a request");
    }

    fn with_header(&mut self, message: Value) -> Value {
        self.header_id += 1;
        Self::with_header_of(self.header_id - 1, message)
    }

    fn with_header_of(header_id: u32, mut message: Value) -> Value {
        let header = json!({"headerId": header_id, "timestamp": "2026-01-01T00:00:00.000Z",
            "version": "2.0.0", "manufacturer": "regatta", "serialNumber": "x"});
        for (key, value) in header.as_object().expect("an object") {
            message[key] = value.clone();
        }
        message
    }

    /// Sends any text.
    pub fn send_text(&mut self, topic: &str, text: &str) {
        let topic = format!("{}/{topic}", self.prefix);
        let options = PublishOptions::new(QoS::AtMostOnce);
        self.client.publish(topic, text, options).expect("a request");
    }

    /// Waits for a message of the vehicle on a topic.
    pub fn wait(&mut self, topic: &str, is_wanted: impl Fn(&Value) -> bool) -> Value {
        let start = Instant::now();
        let mut last = Value::Null;
        while start.elapsed() < TIMEOUT {
            let Some(message) = self.next(topic) else { continue };
            last = message;
            if is_wanted(&last) {
                return last;
            }
        }
        panic!("no such message on {topic} within {} s; the last: {last}", TIMEOUT.as_secs());
    }

    /// Returns the message on a topic that comes within a time, or `None`.
    pub fn wait_at_most(&mut self, topic: &str, time: Duration) -> Option<Value> {
        let start = Instant::now();
        while start.elapsed() < time {
            let message = self.next(topic);
            if message.is_some() {
                return message;
            }
        }
        None
    }

    /// Returns the next message, if it comes soon and is on a topic.
    fn next(&mut self, topic: &str) -> Option<Value> {
        let message = self.messages.recv_timeout(Duration::from_millis(200)).ok()?;
        let is_on_topic = message.topic.ends_with(format!("/{topic}").as_bytes());
        is_on_topic.then(|| serde_json::from_slice(&message.payload).expect("JSON"))
    }
}

/// A name that no other client of a broker has.
fn client_id() -> String {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    format!("peer-{}", COUNT.fetch_add(1, Ordering::Relaxed))
}

/// Keeps a connection going on a thread of its own, until its client is gone: what is sent goes out
/// while nobody waits for an answer.
fn follow(mut connection: Connection) -> Receiver<Publish> {
    /// The time from a failure until the next connection.
    const RETRY: Duration = Duration::from_millis(100);
    let (sender, messages) = channel();
    std::thread::spawn(move || {
        for event in connection.iter() {
            match event {
                Ok(Event::Incoming(Packet::Publish(message))) => drop(sender.send(message)),
                Ok(_) => {}
                Err(_) => std::thread::sleep(RETRY),
            }
        }
    });
    messages
}
