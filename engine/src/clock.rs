//! The fixed rate: absolute deadlines, late ticks counted.
//!
//! Tick *k* may start at its release time and must end by the release time of tick *k + 1*. Release times
//! are laid out from an anchor, not from the end of the work before, so that errors don't add up. A tick
//! that ends late is counted; the ticks after it start at once until the schedule is met again. When the
//! process falls behind by more than [`MAX_BACKLOG`] (it was stopped, or the machine can't hold the rate)
//! the schedule is moved, and each deadline that passed meanwhile is counted as late: no tick is left out,
//! since simulated time depends on the number of ticks alone.

use std::time::{Duration, Instant};

/// How far behind its schedule the clock may fall before it gives up catching up.
pub const MAX_BACKLOG: Duration = Duration::from_millis(100);

/// Wanted simulated seconds per wall second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Speed {
    /// A finite factor > 0.
    Factor(f32),
    /// As fast as the machine can.
    Max,
}

impl Speed {
    /// The factor, or infinity.
    pub fn as_f32(self) -> f32 {
        match self {
            Self::Factor(factor) => factor,
            Self::Max => f32::INFINITY,
        }
    }

    /// The speed of a factor; `None` unless it is in [0.001, 1000] or infinite.
    pub fn from_f32(factor: f32) -> Option<Self> {
        match factor {
            f32::INFINITY => Some(Self::Max),
            0.001..=1000.0 => Some(Self::Factor(factor)),
            _ => None,
        }
    }
}

/// A text that is no [`Speed`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is no speed: give a factor from 0.001 to 1000, or max")]
pub struct ParseSpeedError(String);

impl std::str::FromStr for Speed {
    type Err = ParseSpeedError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let factor = if text.eq_ignore_ascii_case("max") { Some(f32::INFINITY) } else { text.parse().ok() };
        factor.and_then(Self::from_f32).ok_or_else(|| ParseSpeedError(text.to_owned()))
    }
}

impl std::fmt::Display for Speed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Factor(factor) => write!(f, "{factor}"),
            Self::Max => f.write_str("max"),
        }
    }
}

/// Says when ticks are due and which of them were late.
#[derive(Debug)]
pub struct Clock {
    tick_period: Duration,
    speed: Speed,
    /// Release time of the tick that is due next.
    release: Instant,
    late_ticks: u64,
}

impl Clock {
    /// A clock whose first tick is due at `now`. `tick_period` is in simulated time.
    pub fn new(tick_period: Duration, speed: Speed, now: Instant) -> Self {
        Self { tick_period, speed, release: now, late_ticks: 0 }
    }

    /// When the next tick may start.
    pub fn release(&self) -> Instant {
        self.release
    }

    /// Wanted speed.
    pub fn speed(&self) -> Speed {
        self.speed
    }

    /// Ticks that ended after their deadline.
    pub fn late_ticks(&self) -> u64 {
        self.late_ticks
    }

    /// Lays the schedule out anew from `now`: after a pause, or with another speed.
    pub fn restart(&mut self, speed: Speed, now: Instant) {
        self.speed = speed;
        self.release = now;
    }

    /// Notes that the tick that was due has ended, and schedules the next.
    pub fn tick_done(&mut self, now: Instant) {
        let Speed::Factor(factor) = self.speed else {
            self.release = now;
            return;
        };
        let period = self.tick_period.div_f64(f64::from(factor));
        let deadline = self.release + period;
        self.release = deadline;
        let Some(backlog) = now.checked_duration_since(deadline).filter(|late| !late.is_zero()) else {
            return;
        };
        self.late_ticks += 1;
        if backlog > MAX_BACKLOG {
            self.late_ticks += (backlog.as_nanos() / period.as_nanos().max(1)) as u64;
            self.release = now;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: Duration = Duration::from_millis(10);

    #[test]
    fn deadlines_are_absolute() {
        let start = Instant::now();
        let mut clock = Clock::new(PERIOD, Speed::Factor(1.0), start);
        for tick in 1..=100 {
            clock.tick_done(start + PERIOD * tick - Duration::from_millis(7));
        }
        assert_eq!(clock.release(), start + PERIOD * 100);
        assert_eq!(clock.late_ticks(), 0);
    }

    #[test]
    fn a_late_tick_is_counted_and_made_up_for() {
        let start = Instant::now();
        let mut clock = Clock::new(PERIOD, Speed::Factor(2.0), start);
        clock.tick_done(start + Duration::from_millis(6));
        assert_eq!(clock.late_ticks(), 1);
        assert_eq!(clock.release(), start + Duration::from_millis(5), "the schedule stays");
        clock.tick_done(start + Duration::from_millis(9));
        assert_eq!(clock.late_ticks(), 1);
    }

    #[test]
    fn after_a_long_stop_every_missed_deadline_is_counted_and_the_schedule_moves() {
        let start = Instant::now();
        let mut clock = Clock::new(PERIOD, Speed::Factor(1.0), start);
        let now = start + Duration::from_secs(1) + PERIOD;
        clock.tick_done(now);
        assert_eq!(clock.late_ticks(), 101);
        assert_eq!(clock.release(), now);
    }

    #[test]
    fn at_full_speed_no_tick_is_late() {
        let start = Instant::now();
        let mut clock = Clock::new(PERIOD, Speed::Max, start);
        clock.tick_done(start + Duration::from_secs(5));
        assert_eq!(clock.late_ticks(), 0);
    }

    #[test]
    fn speeds_read_as_they_print() {
        for text in ["max", "1", "0.5", "1000"] {
            assert_eq!(text.parse::<Speed>().unwrap().to_string(), text);
        }
        for text in ["0", "-1", "nan", "inf", "fast", "1001"] {
            assert_eq!(text.parse::<Speed>().is_ok(), text == "inf", "{text}");
        }
    }
}
