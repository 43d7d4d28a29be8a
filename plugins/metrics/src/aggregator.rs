//! The aggregator: combines frames, one after the other, into totals and the state of the run.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use regatta_plugin::frame::{ClockState, FrameHeader};
use regatta_plugin::{FleetName, Frame};

use crate::durations::DurationRecorder;
use crate::rhythm::RealTimeFactor;
use crate::snapshot::{IntervalStats, Run, Snapshot, Totals};
use crate::state_counts::StateCounts;

/// Returns the time of day, in nanoseconds since the Unix epoch: the clock of
/// [`FrameHeader::wall_time_nanos`].
pub fn wall_time_nanos() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_nanos() as u64)
}

/// The simulated time of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunClock {
    /// Id of the run.
    pub run_id: u64,
    /// Number of ticks since the start.
    pub tick: u64,
    /// Simulated time of one tick, in seconds.
    pub tick_secs: f64,
}

/// The aggregate of all frames that a reader has read.
#[derive(Debug, Default)]
pub struct Aggregator {
    totals: Totals,
    tick_cost: DurationRecorder,
    jitter: DurationRecorder,
    frame_age: DurationRecorder,
    real_time_factor: RealTimeFactor,
    last: Option<PreviousFrame>,
}

/// The parts of a frame that the next frame is compared with.
#[derive(Clone, Copy, Debug)]
struct PreviousFrame {
    header: FrameHeader,
    state_counts: StateCounts,
    /// Whether it was published on schedule: a frame that shows a pause or a new speed may come at
    /// any time.
    is_regular: bool,
}

impl Aggregator {
    /// Adds a frame that was read at the wall time `now`, in nanoseconds.
    pub fn add_frame(&mut self, frame: &Frame<'_>, now: u64) {
        let header = *frame.header();
        let state_counts = StateCounts::of(frame.state(), frame.speed());
        self.totals.frames_read += 1;
        self.totals.frames_skipped += frame.missed();
        self.frame_age.observe(seconds(now.saturating_sub(header.wall_time_nanos)));
        let last = self
            .last
            .filter(|last| last.header.run_id == header.run_id && last.header.tick <= header.tick);
        let is_regular = match &last {
            Some(last) => self.advance(last, &header, &state_counts, frame.missed() > 0),
            None => self.begin(&header),
        };
        self.last = Some(PreviousFrame { header, state_counts, is_regular });
    }

    /// Records that no frame arrives. Without a producer there is no run any more.
    pub fn note_idle(&mut self, has_producer: bool) {
        if !has_producer {
            self.last = None;
        }
    }

    /// Counts a message that could not be read.
    pub fn count_read_error(&mut self) {
        self.totals.read_errors += 1;
    }

    /// Returns the run id and the wall time in nanoseconds of the newest frame, while there is a
    /// producer.
    pub fn newest(&self) -> Option<(u64, u64)> {
        self.last.as_ref().map(|last| (last.header.run_id, last.header.wall_time_nanos))
    }

    /// Returns the simulated time of the newest frame, while there is a producer.
    pub fn clock(&self) -> Option<RunClock> {
        let header = self.last.as_ref()?.header;
        Some(RunClock {
            run_id: header.run_id,
            tick: header.tick,
            tick_secs: seconds(header.tick_period_nanos),
        })
    }

    /// Returns a snapshot of the frames at the wall time `now`, in nanoseconds.
    pub fn snapshot(&self, fleet: &FleetName, now: u64) -> Snapshot {
        let totals = Totals {
            tick_cost: self.tick_cost.histogram,
            jitter: self.jitter.histogram,
            frame_age: self.frame_age.histogram,
            ..self.totals
        };
        let run = self.last.as_ref().map(|last| run(last, self.real_time_factor.at(now)));
        Snapshot { totals, run, ..Snapshot::of(fleet) }
    }

    /// Returns the statistics of durations since the previous call.
    pub fn take_interval(&mut self) -> IntervalStats {
        let Self { tick_cost, jitter, frame_age, .. } = self;
        IntervalStats {
            tick_cost: tick_cost.take_stats(),
            jitter: jitter.take_stats(),
            frame_age: frame_age.take_stats(),
        }
    }

    /// Begins a run with its first frame. Returns whether the frame is on schedule.
    fn begin(&mut self, header: &FrameHeader) -> bool {
        self.real_time_factor.restart();
        self.note_time(header);
        runs(header)
    }

    /// Adds a further frame of a run. Returns whether the frame is on schedule.
    fn advance(
        &mut self,
        last: &PreviousFrame,
        header: &FrameHeader,
        state_counts: &StateCounts,
        is_after_gap: bool,
    ) -> bool {
        let gap = header.tick - last.header.tick;
        let steady = is_steady(&last.header, header);
        if gap == 0 || clock_rate(&last.header) != clock_rate(header) {
            self.real_time_factor.restart();
        }
        self.note_time(header);
        if gap == 0 {
            return false;
        }
        self.tick_cost.observe(seconds(header.tick_cost_nanos));
        let simulated = gap as f64 * seconds(header.tick_period_nanos);
        self.totals.driven_metres +=
            0.5 * (last.state_counts.speed_sum + state_counts.speed_sum) * simulated;
        if last.is_regular && steady && !is_after_gap {
            self.note_jitter(&last.header, header, simulated);
        }
        steady
    }

    fn note_time(&mut self, header: &FrameHeader) {
        if runs(header) {
            self.real_time_factor.note(header.wall_time_nanos, header.sim_time_nanos);
        }
    }

    /// Records the deviation of the wall time between two frames from the expected one. Full speed
    /// has no expectation.
    fn note_jitter(&mut self, last: &FrameHeader, header: &FrameHeader, simulated: f64) {
        if header.speed.is_finite() && header.speed > 0.0 {
            let wanted = simulated / f64::from(header.speed);
            let passed = header.wall_time_nanos.wrapping_sub(last.wall_time_nanos) as i64;
            self.jitter.observe((passed as f64 * 1e-9 - wanted).abs());
        }
    }
}

/// Returns the fields that determine how fast simulated time should pass.
fn clock_rate(header: &FrameHeader) -> (u32, u32) {
    (header.clock, header.speed.to_bits())
}

/// Whether the clock ran evenly from one frame to the other. A request for more robots is shown by
/// a frame off schedule, as a pause is.
fn is_steady(last: &FrameHeader, header: &FrameHeader) -> bool {
    clock_rate(last) == clock_rate(header) && last.robots == header.robots && runs(header)
}

fn run(last: &PreviousFrame, real_time_factor: Option<f64>) -> Run {
    let header = &last.header;
    Run {
        run_id: header.run_id,
        tick: header.tick,
        frames: header.sequence,
        sim_time: Duration::from_nanos(header.sim_time_nanos),
        wall_time: Duration::from_nanos(header.wall_time_nanos),
        clock: clock(header),
        speed: header.speed,
        tick_period: Duration::from_nanos(header.tick_period_nanos),
        late_ticks: header.late_ticks,
        real_time_factor: match clock(header) {
            ClockState::Running | ClockState::WarmingUp => real_time_factor,
            ClockState::Paused | ClockState::Stopped => Some(0.0),
        },
        state_counts: last.state_counts,
    }
}

/// Whether the clock makes ticks.
fn runs(header: &FrameHeader) -> bool {
    matches!(clock(header), ClockState::Running | ClockState::WarmingUp)
}

/// Returns the state of the clock; unknown states count as stopped.
fn clock(header: &FrameHeader) -> ClockState {
    match header.clock {
        clock if clock == ClockState::Running as u32 => ClockState::Running,
        clock if clock == ClockState::Paused as u32 => ClockState::Paused,
        clock if clock == ClockState::WarmingUp as u32 => ClockState::WarmingUp,
        _ => ClockState::Stopped,
    }
}

fn seconds(nanos: u64) -> f64 {
    nanos as f64 * 1e-9
}

#[cfg(test)]
mod tests;
