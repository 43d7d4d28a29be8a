//! Frames, one after the other, into what they come to.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use regatta_plugin::frame::{ClockState, FrameHeader};
use regatta_plugin::{FleetName, Frame};

use crate::census::Census;
use crate::histogram::Measure;
use crate::rhythm::{RealTimeFactor, Stride};
use crate::snapshot::{Collisions, Lap, Process, Run, Snapshot, Totals};

/// Time of day, in nanoseconds since the Unix epoch: the clock of [`FrameHeader::wall_time_nanos`].
pub fn wall_time_nanos() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_nanos() as u64)
}

/// All frames that a reader has seen, folded into one.
#[derive(Debug, Default)]
pub struct Fold {
    totals: Totals,
    tick_cost: Measure,
    jitter: Measure,
    frame_age: Measure,
    stride: Stride,
    real_time_factor: RealTimeFactor,
    last: Option<Last>,
}

/// What of a frame the next one is held against.
#[derive(Clone, Copy, Debug)]
struct Last {
    header: FrameHeader,
    census: Census,
    /// It came in the usual rhythm: a frame that shows a pause or a new speed comes at any moment.
    in_step: bool,
}

impl Fold {
    /// Takes in a frame that was read at the wall time `now`, in nanoseconds.
    pub fn frame(&mut self, frame: &Frame<'_>, now: u64) {
        let header = *frame.header();
        let census = Census::of(frame.state(), frame.speed());
        self.totals.frames_read += 1;
        self.frame_age.observe(seconds(now.saturating_sub(header.wall_time_nanos)));
        let last = self.last.filter(|last| last.header.run_id == header.run_id && last.header.tick <= header.tick);
        let in_step = match &last {
            Some(last) => self.advance(last, &header, &census),
            None => self.begin(&header),
        };
        self.last = Some(Last { header, census, in_step });
    }

    /// Takes in that no frame comes. Without a producer there is no run any more.
    pub fn idle(&mut self, has_producer: bool) {
        if !has_producer {
            self.last = None;
        }
    }

    /// Takes in that a message could not be read.
    pub fn read_error(&mut self) {
        self.totals.read_errors += 1;
    }

    /// The run and wall time in nanoseconds of the newest frame, while there is a producer.
    pub fn newest(&self) -> Option<(u64, u64)> {
        self.last.as_ref().map(|last| (last.header.run_id, last.header.wall_time_nanos))
    }

    /// Everything so far, at the wall time `now`, in nanoseconds.
    pub fn snapshot(&self, fleet: FleetName, collisions: Collisions, processes: Vec<Process>, now: u64) -> Snapshot {
        let totals = Totals {
            tick_cost: self.tick_cost.histogram,
            jitter: self.jitter.histogram,
            frame_age: self.frame_age.histogram,
            ..self.totals
        };
        let run = self.last.as_ref().map(|last| run(last, self.real_time_factor.at(now)));
        Snapshot { fleet, totals, run, collisions, processes }
    }

    /// How long things took since the last call.
    pub fn lap(&mut self) -> Lap {
        let Self { tick_cost, jitter, frame_age, .. } = self;
        Lap { tick_cost: tick_cost.take_spread(), jitter: jitter.take_spread(), frame_age: frame_age.take_spread() }
    }

    /// The first frame of a run. Whether it is in step.
    fn begin(&mut self, header: &FrameHeader) -> bool {
        self.stride = Stride::default();
        self.real_time_factor.restart();
        self.note_time(header);
        clock(header) == ClockState::Running
    }

    /// A frame after another of its run. Whether it is in step.
    fn advance(&mut self, last: &Last, header: &FrameHeader, census: &Census) -> bool {
        let gap = header.tick - last.header.tick;
        let steady = is_steady(&last.header, header);
        if gap == 0 || pace(&last.header) != pace(header) {
            self.real_time_factor.restart();
        }
        self.note_time(header);
        if gap == 0 {
            return false;
        }
        self.tick_cost.observe(seconds(header.tick_cost_nanos));
        let simulated = gap as f64 * seconds(header.tick_period_nanos);
        self.totals.driven_metres += 0.5 * (last.census.speed_sum + census.speed_sum) * simulated;
        if last.in_step && steady {
            self.stride.note(gap);
        }
        let stride = self.stride.ticks();
        let skipped = stride.map_or(0, |stride| gap.div_ceil(stride) - 1);
        self.totals.frames_skipped = self.totals.frames_skipped.saturating_add(skipped);
        if last.in_step && steady && stride == Some(gap) {
            self.note_jitter(&last.header, header, simulated);
        }
        steady
    }

    fn note_time(&mut self, header: &FrameHeader) {
        if clock(header) == ClockState::Running {
            self.real_time_factor.note(header.wall_time_nanos, header.sim_time_nanos);
        }
    }

    /// How far the wall time between two frames is off what it should be. At full speed nothing says what it should be.
    fn note_jitter(&mut self, last: &FrameHeader, header: &FrameHeader, simulated: f64) {
        if header.speed.is_finite() && header.speed > 0.0 {
            let wanted = simulated / f64::from(header.speed);
            let passed = header.wall_time_nanos.wrapping_sub(last.wall_time_nanos) as i64;
            self.jitter.observe((passed as f64 * 1e-9 - wanted).abs());
        }
    }
}

/// What decides how fast simulated time should pass.
fn pace(header: &FrameHeader) -> (u32, u32) {
    (header.clock, header.speed.to_bits())
}

/// Whether a running clock went on as before from one frame to the other. A request for more robots is shown by a
/// frame out of step, as a pause is.
fn is_steady(last: &FrameHeader, header: &FrameHeader) -> bool {
    pace(last) == pace(header) && last.robots == header.robots && clock(header) == ClockState::Running
}

fn run(last: &Last, real_time_factor: Option<f64>) -> Run {
    let header = &last.header;
    Run {
        run_id: header.run_id,
        tick: header.tick,
        sim_time: Duration::from_nanos(header.sim_time_nanos),
        wall_time: Duration::from_nanos(header.wall_time_nanos),
        clock: clock(header),
        speed: header.speed,
        tick_period: Duration::from_nanos(header.tick_period_nanos),
        late_ticks: header.late_ticks,
        real_time_factor: if clock(header) == ClockState::Running { real_time_factor } else { Some(0.0) },
        census: last.census,
    }
}

/// A clock that says nothing we know is taken to stand.
fn clock(header: &FrameHeader) -> ClockState {
    let known = [ClockState::Running, ClockState::Paused];
    known.into_iter().find(|state| *state as u32 == header.clock).unwrap_or(ClockState::Stopped)
}

fn seconds(nanos: u64) -> f64 {
    nanos as f64 * 1e-9
}

#[cfg(test)]
#[path = "fold_tests.rs"]
mod tests;
