use proptest::prelude::*;
use regatta_plugin::frame::{ColumnsMut, Line, NO_EDGE, frame_lines, stride_lines};

use super::*;

const MILLISECOND: u64 = 1_000_000;
const PERIOD: u64 = 10 * MILLISECOND;

/// A producer of a few robots, with a clock that tests advance.
struct Producer {
    header: FrameHeader,
    speeds: Vec<f32>,
    aggregator: Aggregator,
    /// Frames that the reader misses before the next.
    missed: u64,
}

impl Producer {
    fn new(speeds: &[f32]) -> Self {
        let robots = speeds.len();
        let header = FrameHeader {
            run_id: 7,
            wall_time_nanos: 1_000 * MILLISECOND,
            tick_period_nanos: PERIOD,
            tick_cost_nanos: MILLISECOND,
            speed: 1.0,
            robots: robots as u32,
            stride_lines: stride_lines(robots) as u32,
            ..FrameHeader::default()
        };
        Self { header, speeds: speeds.to_vec(), aggregator: Aggregator::default(), missed: 0 }
    }

    /// Publishes a frame, which is read a millisecond later.
    fn publish(&mut self) {
        let mut lines = vec![Line::default(); frame_lines(self.speeds.len())];
        let columns = ColumnsMut::split(&mut lines, self.speeds.len());
        columns.speed[..self.speeds.len()].copy_from_slice(&self.speeds);
        columns.state.fill(255);
        columns.state[..self.speeds.len()].fill(1);
        columns.edge.fill(NO_EDGE);
        let missed = std::mem::take(&mut self.missed);
        let frame = Frame::new(&self.header, &lines).expect("a frame").after_missing(missed);
        self.aggregator.add_frame(&frame, self.header.wall_time_nanos + MILLISECOND);
    }

    /// Advances the clock by some ticks and by `wall` nanoseconds of wall time, and publishes a
    /// frame.
    fn advance(&mut self, ticks: u64, wall: u64) {
        self.header.tick += ticks;
        self.header.sim_time_nanos += ticks * PERIOD;
        self.header.wall_time_nanos += wall;
        self.publish();
    }

    fn snapshot(&self) -> Snapshot {
        let now = self.header.wall_time_nanos + MILLISECOND;
        self.aggregator.snapshot(&FleetName::default(), now)
    }

    fn totals(&self) -> Totals {
        self.snapshot().totals
    }
}

#[test]
fn a_steady_run_is_measured_exactly() {
    let mut producer = Producer::new(&[1.0, -2.0]);
    producer.publish();
    (0..200).for_each(|_| producer.advance(1, PERIOD));
    let Snapshot { totals, run, .. } = producer.snapshot();
    let run = run.expect("a run");
    assert_eq!((totals.frames_read, totals.frames_skipped), (201, 0));
    assert!((totals.driven_metres - 2.0 * 3.0).abs() < 1e-6, "{}", totals.driven_metres);
    assert_eq!((totals.tick_cost.count, totals.jitter.count), (200, 200));
    assert!(totals.jitter.sum < 1e-6 && (totals.tick_cost.sum - 0.2).abs() < 1e-9, "{totals:?}");
    assert!((totals.frame_age.sum - 0.201).abs() < 1e-9);
    assert_eq!((run.tick, run.state_counts.robots(), run.state_counts.mean_speed()), (200, 2, 1.5));
    assert!((run.real_time_factor.expect("enough frames") - 1.0).abs() < 1e-6);
}

#[test]
fn jitter_is_the_deviation_from_the_period_at_the_wanted_speed() {
    let mut producer = Producer::new(&[1.0]);
    producer.header.speed = 2.0;
    producer.publish();
    producer.advance(1, 5 * MILLISECOND);
    producer.advance(1, 8 * MILLISECOND);
    producer.advance(1, 4 * MILLISECOND);
    let jitter = producer.totals().jitter;
    assert_eq!(jitter.count, 3);
    assert!((jitter.sum - 0.004).abs() < 1e-9, "{jitter:?}");
}

#[test]
fn full_speed_has_no_jitter() {
    let mut producer = Producer::new(&[1.0]);
    producer.header.speed = f32::INFINITY;
    producer.publish();
    (0..5).for_each(|_| producer.advance(1, 1000));
    assert_eq!(producer.totals().jitter.count, 0);
}

#[test]
fn skipped_frames_are_counted_once_and_their_distance_too() {
    let mut producer = Producer::new(&[1.0]);
    producer.publish();
    producer.advance(1, PERIOD);
    producer.missed = 3;
    producer.advance(4, 4 * PERIOD);
    producer.advance(1, PERIOD);
    let totals = producer.totals();
    assert_eq!((totals.frames_read, totals.frames_skipped, totals.jitter.count), (4, 3, 2));
    assert!((totals.driven_metres - 0.06).abs() < 1e-9);
}

#[test]
fn frames_every_ten_ticks_skip_nothing() {
    let mut producer = Producer::new(&[1.0]);
    producer.publish();
    (0..20).for_each(|_| producer.advance(10, 10 * PERIOD));
    let totals = producer.totals();
    assert_eq!((totals.frames_skipped, totals.jitter.count), (0, 20));
    assert!(totals.jitter.sum < 1e-6);
}

/// Publishes the frames of `pause`, `step 2` and `resume`: each at once, at any time.
fn pause_step_and_resume(producer: &mut Producer, ticks_to_next_frame: u64) {
    producer.header.clock = ClockState::Paused as u32;
    producer.advance(0, MILLISECOND);
    (0..2).for_each(|_| producer.advance(1, MILLISECOND));
    producer.header.clock = ClockState::Running as u32;
    producer.advance(0, 5_000 * MILLISECOND);
    producer.advance(ticks_to_next_frame, ticks_to_next_frame * PERIOD);
}

#[test]
fn a_pause_adds_no_jitter_and_skips_nothing() {
    let mut producer = Producer::new(&[1.0]);
    producer.publish();
    (0..5).for_each(|_| producer.advance(1, PERIOD));
    let before = producer.totals();
    pause_step_and_resume(&mut producer, 1);
    let after = producer.totals();
    assert_eq!((after.jitter, after.frames_skipped), (before.jitter, 0));
    assert_eq!(after.tick_cost.count, before.tick_cost.count + 3, "a repeated frame is not a tick");
    producer.advance(1, PERIOD);
    assert_eq!(producer.totals().jitter.count, before.jitter.count + 1);
}

#[test]
fn a_pause_between_frames_every_ten_ticks_skips_nothing() {
    let mut producer = Producer::new(&[1.0]);
    producer.publish();
    (0..5).for_each(|_| producer.advance(10, 10 * PERIOD));
    pause_step_and_resume(&mut producer, 8);
    (0..5).for_each(|_| producer.advance(10, 10 * PERIOD));
    let totals = producer.totals();
    assert_eq!((totals.frames_skipped, totals.jitter.count), (0, 10));
    assert!(totals.jitter.sum < 1e-6);
}

#[test]
fn a_paused_clock_has_a_real_time_factor_of_zero() {
    let mut producer = Producer::new(&[1.0]);
    producer.publish();
    (0..50).for_each(|_| producer.advance(1, PERIOD));
    producer.header.clock = ClockState::Paused as u32;
    producer.advance(0, MILLISECOND);
    assert_eq!(producer.snapshot().run.expect("a run").real_time_factor, Some(0.0));
}

#[test]
fn another_run_restarts_the_run_but_not_the_totals() {
    let mut producer = Producer::new(&[1.0]);
    producer.publish();
    (0..10).for_each(|_| producer.advance(1, PERIOD));
    producer.header = FrameHeader { run_id: 8, tick: 0, sim_time_nanos: 0, ..producer.header };
    producer.publish();
    producer.advance(1, PERIOD);
    let Snapshot { totals, run, .. } = producer.snapshot();
    assert_eq!((totals.frames_read, totals.frames_skipped, run.expect("a run").tick), (13, 0, 1));
    assert!((totals.driven_metres - 0.11).abs() < 1e-9, "{}", totals.driven_metres);
}

#[test]
fn without_a_producer_there_is_no_run() {
    let mut producer = Producer::new(&[1.0]);
    producer.publish();
    producer.aggregator.note_idle(true);
    assert!(producer.snapshot().run.is_some(), "the clock is paused");
    producer.aggregator.note_idle(false);
    assert!(producer.snapshot().run.is_none());
}

proptest! {
    /// Robots that accelerate evenly drive exactly the mean of two speeds.
    #[test]
    fn distance_is_exact_at_even_acceleration(start in 0.0_f32..3.0, change in -0.02_f32..0.05, gaps in prop::collection::vec(1_u64..4, 1..50)) {
        let mut producer = Producer::new(&[start]);
        producer.publish();
        let mut distance = 0.0;
        for gap in gaps {
            for _ in 0..gap {
                let before = producer.speeds[0];
                producer.speeds[0] = (before + change).max(0.0);
                distance += 0.5 * f64::from(before + producer.speeds[0]) * 0.01;
            }
            if producer.speeds[0] <= 0.0 {
                break;
            }
            producer.advance(gap, gap * PERIOD);
            let driven = producer.totals().driven_metres;
            prop_assert!((driven - distance).abs() <= 1e-4 * distance.max(1.0), "{driven} of {distance}");
        }
    }

    /// No header makes it panic, however invalid.
    #[test]
    fn no_header_panics(headers in prop::collection::vec((any::<u64>(), any::<u64>(), any::<u64>(), any::<u64>(), any::<u32>(), any::<f32>()), 1..20)) {
        let mut producer = Producer::new(&[1.0]);
        for (tick, simulated, wall, cost, clock, speed) in headers {
            let wall_time_nanos = wall;
            producer.header = FrameHeader { tick, sim_time_nanos: simulated, wall_time_nanos, tick_cost_nanos: cost, clock: clock % 4, speed, ..producer.header };
            let lines = vec![Line::default(); frame_lines(1)];
            let frame = Frame::new(&producer.header, &lines).expect("a frame");
            producer.aggregator.add_frame(&frame, wall / 2);
            producer.aggregator.snapshot(&FleetName::default(), wall / 3);
            producer.aggregator.take_interval();
        }
    }
}
