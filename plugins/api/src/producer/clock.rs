//! The clock of a producer: absolute deadlines, late ticks counted.
//!
//! Moments lie on the axis of simulated time. The clock maps it to the wall clock from an anchor (a
//! point of both), not from the end of the work before, so that errors don't add up. A tick may
//! start when its moment is due and must end before the next moment is due. A tick that ends late
//! is counted; the ticks after it start at once until the schedule is met again. When the process
//! falls behind by more than [`MAX_BACKLOG`] (it was stopped, or the machine can't hold the rate),
//! the schedule is moved, and each deadline that passed meanwhile is counted as late: no tick is
//! left out, because simulated time depends on the number of ticks alone.

use std::time::{Duration, Instant};

use super::speed::Speed;
use crate::records::frame::ClockState;

/// The largest backlog that a clock catches up with. Beyond it, the schedule moves.
pub const MAX_BACKLOG: Duration = Duration::from_millis(100);

/// The farthest moment that can be scheduled: 136 years ahead.
const FARTHEST: Duration = Duration::from_secs(1 << 32);

/// Decides when moments are due, counts the late ones, and pauses and steps.
///
/// ```
/// use std::time::{Duration, Instant};
///
/// use regatta_plugin::producer::{Clock, Speed};
///
/// let start = Instant::now();
/// let clock = Clock::new(Speed::Factor(2.0), 0, start);
/// assert_eq!(clock.due(1_000_000_000), start + Duration::from_millis(500));
/// ```
#[derive(Debug)]
pub struct Clock {
    speed: Speed,
    paused: bool,
    /// Ticks that a paused clock still has to make.
    steps_left: u64,
    /// A point of the wall clock, and the simulated time in nanoseconds that is due then.
    anchor: (Instant, u64),
    late_ticks: u64,
    /// The ticks that were given up because the backlog was too long; they are late, too.
    skipped_ticks: u64,
}

impl Clock {
    /// Creates a running clock at which the simulated time `sim_nanos` is due at `now`.
    pub fn new(speed: Speed, sim_nanos: u64, now: Instant) -> Self {
        Self {
            speed,
            paused: false,
            steps_left: 0,
            anchor: (now, sim_nanos),
            late_ticks: 0,
            skipped_ticks: 0,
        }
    }

    /// The requested speed.
    pub fn speed(&self) -> Speed {
        self.speed
    }

    /// The number of ticks that ended after their deadline.
    pub fn late_ticks(&self) -> u64 {
        self.late_ticks
    }

    /// The number of them that were given up because the backlog was too long.
    pub fn skipped_ticks(&self) -> u64 {
        self.skipped_ticks
    }

    /// Whether the clock is running or paused. A clock that makes single steps is paused.
    pub fn state(&self) -> ClockState {
        if self.paused { ClockState::Paused } else { ClockState::Running }
    }

    /// Whether no tick is due until a resume or a step.
    pub fn stands(&self) -> bool {
        self.paused && self.steps_left == 0
    }

    /// The number of ticks that a paused clock still has to make.
    pub fn steps_left(&self) -> u64 {
        self.steps_left
    }

    /// Returns the time when a moment is due.
    pub fn due(&self, sim_nanos: u64) -> Instant {
        let (at, anchor) = self.anchor;
        let simulated = Duration::from_nanos(sim_nanos.saturating_sub(anchor));
        match self.speed {
            Speed::Max => at,
            Speed::Factor(factor) => at + scaled(simulated, factor),
        }
    }

    /// Schedules `sim_nanos` for `now`, and the moments after it accordingly.
    pub fn restart(&mut self, sim_nanos: u64, now: Instant) {
        self.anchor = (now, sim_nanos);
    }

    /// Changes the speed. Simulated time continues from where it is between the moments `current`
    /// and `next`.
    pub fn set_speed(&mut self, speed: Speed, current: u64, next: u64, now: Instant) {
        let elapsed = now.saturating_duration_since(self.anchor.0).as_nanos() as f64;
        let reached = match self.speed {
            Speed::Factor(factor) if !self.paused => {
                self.anchor.1 as f64 + elapsed * f64::from(factor)
            }
            _ => current as f64,
        };
        self.anchor = (now, (reached as u64).clamp(current, next.max(current)));
        self.speed = speed;
    }

    /// Pauses the clock, and drops the steps that are left.
    pub fn pause(&mut self) {
        self.paused = true;
        self.steps_left = 0;
    }

    /// Lets the clock run from the moment `current`, and drops the steps that are left.
    pub fn resume(&mut self, current: u64, now: Instant) {
        self.paused = false;
        self.steps_left = 0;
        self.restart(current, now);
    }

    /// Pauses the clock and makes it advance by `ticks` at the requested speed, so that readers can
    /// follow; the first of them, the moment `next`, at once.
    pub fn step(&mut self, ticks: u64, next: u64, now: Instant) {
        if !self.paused || self.steps_left == 0 {
            self.restart(next, now);
        }
        self.paused = true;
        self.steps_left = self.steps_left.saturating_add(ticks);
    }

    /// Drops the steps that are left.
    pub fn drop_steps(&mut self) {
        self.steps_left = 0;
    }

    /// Records that the moment `sim_nanos` has ended, which was `ticks` ticks after the one before;
    /// the moment after it is `next`.
    pub fn finish(&mut self, ticks: u64, sim_nanos: u64, next: Option<u64>, now: Instant) {
        self.steps_left = self.steps_left.saturating_sub(ticks);
        let (Speed::Factor(factor), Some(next)) = (self.speed, next) else {
            return;
        };
        let backlog = now.saturating_duration_since(self.due(next));
        if backlog.is_zero() {
            return;
        }
        self.late_ticks += 1;
        if backlog > MAX_BACKLOG {
            let period = scaled(Duration::from_nanos(next.saturating_sub(sim_nanos)), factor);
            let skipped = (backlog.as_nanos() / period.as_nanos().max(1)) as u64;
            self.late_ticks += skipped;
            self.skipped_ticks += skipped;
            self.restart(next, now);
        }
    }
}

/// Returns the wall time of a simulated duration.
fn scaled(simulated: Duration, factor: f32) -> Duration {
    let wall = Duration::try_from_secs_f64(simulated.as_secs_f64() / f64::from(factor));
    wall.unwrap_or(FARTHEST).min(FARTHEST)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: Duration = Duration::from_millis(10);
    const NANOS: u64 = PERIOD.as_nanos() as u64;

    /// A clock whose first tick is due at `start`.
    fn clock(factor: f32, start: Instant) -> Clock {
        Clock::new(Speed::Factor(factor), NANOS, start)
    }

    /// Ends a tick at `now`.
    fn finish(clock: &mut Clock, tick: u64, now: Instant) {
        clock.finish(1, NANOS * tick, Some(NANOS * (tick + 1)), now);
    }

    #[test]
    fn deadlines_are_absolute() {
        let start = Instant::now();
        let mut clock = clock(1.0, start);
        for tick in 1..=100 {
            finish(&mut clock, tick, start + PERIOD * tick as u32 - Duration::from_millis(7));
        }
        assert_eq!(clock.due(NANOS * 101), start + PERIOD * 100);
        assert_eq!(clock.late_ticks(), 0);
    }

    #[test]
    fn a_late_tick_is_counted_and_made_up_for() {
        let start = Instant::now();
        let mut clock = clock(2.0, start);
        finish(&mut clock, 1, start + Duration::from_millis(6));
        assert_eq!(clock.late_ticks(), 1);
        assert_eq!(clock.due(NANOS * 2), start + Duration::from_millis(5), "the schedule stays");
        finish(&mut clock, 2, start + Duration::from_millis(9));
        assert_eq!(clock.late_ticks(), 1);
    }

    #[test]
    fn after_a_long_stop_every_missed_deadline_is_counted_and_the_schedule_moves() {
        let start = Instant::now();
        let mut clock = clock(1.0, start);
        let now = start + Duration::from_secs(1) + PERIOD;
        finish(&mut clock, 1, now);
        assert_eq!(clock.late_ticks(), 101);
        assert_eq!(clock.due(NANOS * 2), now);
    }

    #[test]
    fn at_full_speed_every_moment_is_due_and_no_tick_is_late() {
        let start = Instant::now();
        let mut clock = Clock::new(Speed::Max, NANOS, start);
        finish(&mut clock, 1, start + Duration::from_secs(5));
        assert_eq!((clock.late_ticks(), clock.due(u64::MAX)), (0, start));
    }

    #[test]
    fn the_slowest_clock_and_the_farthest_moment_are_no_overflow() {
        let start = Instant::now();
        assert!(Clock::new(Speed::Factor(0.001), 0, start).due(u64::MAX) > start + PERIOD);
    }

    #[test]
    fn another_speed_continues_from_where_time_is() {
        let start = Instant::now();
        let mut clock = clock(1.0, start);
        clock.set_speed(Speed::Factor(0.5), NANOS, NANOS * 2, start + PERIOD / 2);
        assert_eq!(
            clock.due(NANOS * 2),
            start + PERIOD / 2 + PERIOD,
            "half a period is left, at half the speed"
        );
        clock.pause();
        clock.set_speed(Speed::Factor(1.0), NANOS, NANOS * 2, start + PERIOD * 50);
        assert_eq!(
            clock.due(NANOS * 2),
            start + PERIOD * 51,
            "no time passes while the clock is paused"
        );
    }

    #[test]
    fn steps_are_counted_down_and_dropped() {
        let start = Instant::now();
        let mut clock = clock(1.0, start);
        clock.step(2, NANOS, start);
        clock.step(1, NANOS, start);
        assert_eq!(
            (clock.steps_left(), clock.stands(), clock.state()),
            (3, false, ClockState::Paused)
        );
        finish(&mut clock, 1, start);
        assert_eq!(clock.steps_left(), 2);
        clock.pause();
        assert!(clock.stands());
        clock.step(1, NANOS * 2, start);
        clock.resume(NANOS, start);
        assert_eq!((clock.steps_left(), clock.state()), (0, ClockState::Running));
    }
}
