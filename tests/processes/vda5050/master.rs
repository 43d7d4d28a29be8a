//! A small master of one vehicle: it sends messages, and waits for those of the vehicle.

use std::time::{Duration, Instant};

use rumqttc::{Client, Connection, Event, MqttOptions, Packet, PublishOptions, QoS};
use serde_json::{Value, json};

use crate::fleet::TIMEOUT;

/// The master of one vehicle.
pub struct Master {
    client: Client,
    connection: Connection,
    prefix: String,
    header_id: u32,
}

impl Master {
    /// Connects to a broker of this machine. The prefix is that of the vehicle's topics.
    pub fn connect(port: u16, prefix: &str) -> Self {
        Self::connect_with(
            MqttOptions::new(format!("master-{prefix}"), ("127.0.0.1", port)),
            prefix,
        )
    }

    /// Connects with a user and a password.
    pub fn connect_as(port: u16, prefix: &str, user: &str, password: &str) -> Self {
        let mut options = MqttOptions::new(format!("master-{prefix}"), ("127.0.0.1", port));
        options.set_credentials(user, password.to_owned());
        Self::connect_with(options, prefix)
    }

    fn connect_with(mut options: MqttOptions, prefix: &str) -> Self {
        options.set_max_packet_size(1 << 24, 1 << 24);
        let (client, connection) = Client::builder(options).capacity(100).build();
        client.subscribe(format!("{prefix}/+"), QoS::AtLeastOnce).expect("a request");
        Self { client, connection, prefix: prefix.to_owned(), header_id: 0 }
    }

    /// Sends a message, with a header.
    pub fn send(&mut self, topic: &str, mut message: Value) {
        let header = json!({"headerId": self.header_id, "timestamp": "2026-01-01T00:00:00.000Z",
            "version": "2.0.0", "manufacturer": "regatta", "serialNumber": "x"});
        self.header_id += 1;
        for (key, value) in header.as_object().expect("an object") {
            message[key] = value.clone();
        }
        self.send_text(topic, &message.to_string());
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
            let event = self.connection.recv_timeout(Duration::from_millis(200));
            let Ok(Ok(Event::Incoming(Packet::Publish(message)))) = event else { continue };
            if !message.topic.ends_with(format!("/{topic}").as_bytes()) {
                continue;
            }
            last = serde_json::from_slice(&message.payload).expect("JSON");
            if is_wanted(&last) {
                return last;
            }
        }
        panic!("no such message on {topic} within {} s; the last: {last}", TIMEOUT.as_secs());
    }
}
