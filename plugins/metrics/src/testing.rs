//! Snapshots for tests.

use std::time::Duration;

use regatta_plugin::FleetName;
use regatta_plugin::contact::{ContactHeader, ContactRecord};
use regatta_plugin::frame::ClockState;

use crate::histogram::DurationRecorder;
use crate::snapshot::{Collisions, Process, RobotLevels, Run, Snapshot, Totals};
use crate::state_counts::StateCounts;

/// Returns the snapshot of a fleet with all values known.
pub fn snapshot() -> Snapshot {
    let mut recorder = DurationRecorder::default();
    (1..=100).for_each(|k| recorder.observe(f64::from(k) * 1e-5));
    let times = recorder.histogram;
    Snapshot {
        totals: Totals {
            frames_read: 12_345,
            frames_skipped: 6,
            driven_metres: 98_765.4,
            read_errors: 0,
            tick_cost: times,
            jitter: times,
            frame_age: times,
        },
        run: Some(Run {
            run_id: 0xfeed,
            tick: 123_456,
            sim_time: Duration::from_millis(1_234_560),
            wall_time: Duration::from_secs(1_700_000_000),
            clock: ClockState::Running,
            speed: 1.0,
            tick_period: Duration::from_millis(10),
            late_ticks: 3,
            real_time_factor: Some(0.998),
            state_counts: StateCounts { by_state: [100, 812, 44, 33, 11, 0, 0, 0], speed_sum: 1_234.5 },
        }),
        collisions: collisions(12, 30),
        ..without_engine()
    }
}

/// Returns the snapshot of a fleet that has processes but no engine.
pub fn without_engine() -> Snapshot {
    let process = |name: &str, pid, cpu_cores| Process {
        name: name.to_owned(),
        pid,
        stopped: false,
        shared_bytes: 1_600_000,
        resident_bytes: 34_000_000,
        cpu_seconds: 12.5,
        cpu_cores,
    };
    Snapshot {
        fleet: FleetName::default(),
        totals: Totals::default(),
        run: None,
        collisions: Collisions::default(),
        processes: vec![process("metrics", 4_242, 0.01), process("engine", 4_000_000, 0.123)],
    }
}

/// Returns collisions with these numbers of touching and of possible pairs.
pub fn collisions(touching: u32, possible: u32) -> Collisions {
    let pair = |k: u32| ContactRecord {
        since_tick: 123_000,
        since_nanos: 1_230_000_000_000,
        robots: [k, 10_000 + k],
        level: if k < touching { 2 } else { 1 },
        x: k as f32,
        y: -1.5,
        relative_speed: 0.8,
        ..ContactRecord::default()
    };
    Collisions {
        robots: Some(RobotLevels { tick: 123_450, possible: 55, touching: 24 }),
        pairs: Some(ContactHeader {
            run_id: 0xfeed,
            tick: 123_455,
            touching,
            possible,
            touching_ever: 77,
            possible_ever: 99,
            ..ContactHeader::default()
        }),
        list: (0..touching + possible).map(pair).collect(),
    }
}
