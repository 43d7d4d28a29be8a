//! Robots of a fleet as vehicles of the interface VDA 5050, on an MQTT broker.

pub mod broker;
pub mod judge;
pub mod message;
