//! Snapshots for tests.

use std::sync::Arc;
use std::time::Duration;

use regatta_plugin::FleetName;
use regatta_plugin::contact::{ContactHeader, ContactRecord};
use regatta_plugin::frame::ClockState;
use regatta_plugin::traffic::EdgeTraffic;

use crate::durations::{DurationRecorder, TimeSummary};
use crate::snapshot::{
    Collisions, Jam, OrderFigures, Process, RobotLevels, Run, Snapshot, Totals, Work,
};
use crate::state_counts::StateCounts;
use crate::work::Effort;

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
            frames: 61_728,
            sim_time: Duration::from_millis(1_234_560),
            wall_time: Duration::from_secs(1_700_000_000),
            clock: ClockState::Running,
            speed: 1.0,
            tick_period: Duration::from_millis(10),
            late_ticks: 3,
            real_time_factor: Some(0.998),
            state_counts: StateCounts {
                by_state: [100, 812, 44, 33, 11, 0, 0, 0],
                speed_sum: 1_234.5,
            },
        }),
        collisions: collisions(12, 30),
        work: Some(work()),
        jams: Some(jams()),
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
        processes: vec![process("metrics", 4_242, 0.01), process("engine", 4_000_000, 0.123)],
        ..Snapshot::of(&FleetName::default())
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

/// Returns edges at which robots wait.
pub fn jams() -> Arc<[Jam]> {
    let figures = EdgeTraffic {
        occupancy: 2.5,
        entered_per_hour: 1_234.0,
        relative_speed: 0.25,
        waiting_secs: 456.0,
        contact_secs: 0.0,
        ..EdgeTraffic::default()
    };
    let jam = |edge, name: &str| Jam { edge, name: name.into(), figures };
    [jam(567, ""), jam(8, "dock 3")].into()
}

/// Returns the work of a fleet manager.
pub fn work() -> Work {
    Work {
        robots: [44, 201, 614, 30, 90, 5, 10, 6, 0, 0, 0, 0, 0],
        orders: OrderFigures {
            created: 4_389,
            finished: 4_321,
            failed: 3,
            cancelled: 7,
            open: Some(58),
            finished_per_second: Some(0.125),
            service: TimeSummary {
                count: 4_000,
                sum: 244_000.0,
                p50: 55.0,
                p99: 120.0,
                longest: 300.0,
            },
            waiting: TimeSummary {
                count: 4_050,
                sum: 34_020.0,
                p50: 6.0,
                p99: 40.0,
                longest: 96.0,
            },
            gaps: 2,
            since_secs: None,
        },
        run: None,
        effort: Effort {
            busy_secs: 900.0,
            robot_secs: 1_000.0,
            loaded_metres: 600.0,
            empty_metres: 400.0,
        },
        cycle: TimeSummary { count: 600, sum: 1.8, p50: 0.0025, p99: 0.012, longest: 0.0314 },
    }
}
