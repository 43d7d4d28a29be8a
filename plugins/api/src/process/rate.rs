//! The rate at which a plugin gets frames.

use core::str::FromStr;
use std::time::{Duration, Instant};

use crate::records::frame::Frame;

/// The rate at which a plugin gets frames.
///
/// ```
/// use regatta_plugin::Rate;
///
/// assert_eq!("2.5".parse(), Ok(Rate::PerSecond(2.5)));
/// assert_eq!("all".parse(), Ok(Rate::EveryFrame));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rate {
    /// Every frame, as soon as it is there.
    EveryFrame,
    /// This many per second of wall time (of simulated time in lockstep), or fewer if there are
    /// fewer: at least [`MIN`](Self::MIN).
    PerSecond(f64),
}

/// The error of parsing a [`Rate`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("invalid rate {text:?}; give frames per second, 0.000001 to 1000000, or 'all'")]
pub struct RateError {
    /// The text.
    text: String,
}

impl Rate {
    /// The lowest rate: a frame every eleven days.
    pub const MIN: f64 = 1e-6;
    /// The highest rate.
    pub const MAX: f64 = 1e6;

    /// The time between two frames.
    fn period(self) -> Duration {
        match self {
            Self::EveryFrame => Duration::ZERO,
            // A rate can be constructed without parsing: a meaningless one counts as every frame.
            Self::PerSecond(rate) if rate > 0.0 => {
                Duration::from_secs_f64(1.0 / rate.clamp(Self::MIN, Self::MAX))
            }
            Self::PerSecond(_) => Duration::ZERO,
        }
    }
}

impl FromStr for Rate {
    type Err = RateError;

    fn from_str(text: &str) -> Result<Self, RateError> {
        if text == "all" {
            return Ok(Self::EveryFrame);
        }
        match text.parse() {
            Ok(rate) if (Self::MIN..=Self::MAX).contains(&rate) => Ok(Self::PerSecond(rate)),
            _ => Err(RateError { text: text.to_owned() }),
        }
    }
}

/// Limits the rate at which a plugin gets frames: by the wall clock, or in lockstep by simulated
/// time so that runs repeat.
#[derive(Debug)]
pub(super) struct RateLimiter {
    period: Duration,
    /// The time when the next frame is due, unless in lockstep.
    wall: Instant,
    lockstep: bool,
    run_id: u64,
    /// Simulated time at which the next frame is due, in lockstep.
    simulated: Duration,
}

impl RateLimiter {
    pub(super) fn new(rate: Rate) -> Self {
        let (wall, simulated) = (Instant::now(), Duration::ZERO);
        Self { period: rate.period(), wall, lockstep: false, run_id: 0, simulated }
    }

    /// The time until a frame is due; zero in lockstep, where each frame must be received.
    pub(super) fn left(&self) -> Duration {
        if self.lockstep {
            Duration::ZERO
        } else {
            self.wall.saturating_duration_since(Instant::now())
        }
    }

    /// Records a received frame, and returns whether the plugin gets it.
    pub(super) fn admits(&mut self, frame: &Frame<'_>) -> bool {
        self.lockstep = frame.header().lockstep != 0;
        let now = Instant::now();
        // Behind by more than a period: don't hurry to catch up. Frames in lockstep come at any
        // rate, and leave the wall clock where it is: a run may go on without lockstep.
        let next = if self.lockstep { now } else { self.wall + self.period };
        self.wall = next.max(now.checked_sub(self.period).unwrap_or(now));
        if frame.run_id() != self.run_id {
            (self.run_id, self.simulated) = (frame.run_id(), frame.sim_time());
        }
        if self.lockstep && frame.sim_time() < self.simulated {
            return false;
        }
        self.simulated =
            (self.simulated + self.period).max(frame.sim_time().saturating_sub(self.period));
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::records::frame::FrameHeader;

    #[test]
    fn rates_are_parsed() {
        assert_eq!("all".parse(), Ok(Rate::EveryFrame));
        assert_eq!("2.5".parse(), Ok(Rate::PerSecond(2.5)));
        for bad in ["", "0", "-1", "nan", "inf", "1e7", "1e-7", "1e-19", "1e-20", "fast"] {
            assert!(bad.parse::<Rate>().is_err(), "{bad}");
        }
        assert_eq!(Rate::PerSecond(4.0).period(), Duration::from_millis(250));
        for meaningless in [0.0, -1.0, f64::NAN] {
            assert_eq!(Rate::PerSecond(meaningless).period(), Duration::ZERO);
        }
    }

    #[test]
    fn a_run_that_leaves_the_lockstep_keeps_nobody_waiting() {
        let mut limiter = RateLimiter::new(Rate::PerSecond(10.0));
        for tick in 0..1000 {
            let header = FrameHeader { lockstep: 1, tick, ..FrameHeader::default() };
            limiter.admits(&Frame::new(&header, &[]).expect("a frame without robots"));
        }
        let header = FrameHeader { tick: 1000, ..FrameHeader::default() };
        assert!(limiter.admits(&Frame::new(&header, &[]).expect("a frame without robots")));
        assert!(limiter.left() <= Duration::from_millis(100), "{:?}", limiter.left());
    }

    #[test]
    fn a_rate_however_low_has_a_next_frame() {
        for rate in [Rate::MIN, 1e-19, 1e-20, f64::MIN_POSITIVE] {
            let mut limiter = RateLimiter::new(Rate::PerSecond(rate));
            let (header, lines) = (FrameHeader::default(), []);
            let frame = Frame::new(&header, &lines).expect("a frame without robots");
            assert!(
                limiter.admits(&frame) && limiter.left() > Duration::from_secs(900_000),
                "{rate}"
            );
        }
    }
}
