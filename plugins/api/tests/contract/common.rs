//! Helpers that several tests share.

use std::sync::atomic::{AtomicU32, Ordering};

use regatta_plugin::FleetName;
use regatta_plugin::ProducerPorts;

/// A fleet name that no other test has.
pub fn fleet() -> FleetName {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    format!("test-{}-{}", std::process::id(), NEXT.fetch_add(1, Ordering::Relaxed)).parse().unwrap()
}

/// Publishes a frame in which `x[i] = tick + i`, and `state` of the last robot is 3.
pub fn publish(producer: &ProducerPorts, tick: u64, robots: usize) {
    let mut frame = producer.loan(robots).unwrap();
    frame.header_mut().tick = tick;
    let columns = frame.columns_mut();
    for (i, x) in columns.x.iter_mut().enumerate() {
        *x = tick as f32 + i as f32;
    }
    columns.state[robots - 1] = 3;
    frame.send().unwrap();
    producer.notify();
}
