//! When a recorded moment is due.

use std::time::{Duration, Instant};

/// How far behind its schedule a replay may fall before it gives up catching up.
const MAX_BACKLOG: Duration = Duration::from_millis(100);
/// How often the real-time factor is taken.
const RATE_WINDOW: Duration = Duration::from_secs(1);
/// Costs that percentiles are taken of.
const COSTS: usize = 256;

/// Lays recorded time out on the wall clock.
#[derive(Debug)]
pub(super) struct Pace {
    /// Recorded seconds per wall second; infinite for as fast as possible.
    speed: f32,
    /// A moment, and the time in the recording that belongs to it.
    anchor: (Instant, u64),
    late: u64,
    rate_from: (Instant, u64),
    real_time_factor: f32,
    costs: Vec<Duration>,
    next_cost: usize,
}

impl Pace {
    pub fn new(speed: f32, time: u64) -> Self {
        let now = Instant::now();
        let (anchor, rate_from) = ((now, time), (now, time));
        Self { speed, anchor, late: 0, rate_from, real_time_factor: 0.0, costs: Vec::new(), next_cost: 0 }
    }

    /// Goes on from `time` now, at another speed.
    pub fn restart(&mut self, speed: f32, time: u64) {
        let now = Instant::now();
        (self.speed, self.anchor, self.rate_from, self.real_time_factor) = (speed, (now, time), (now, time), 0.0);
    }

    pub fn speed(&self) -> f32 {
        self.speed
    }

    /// How long until `time` is due.
    pub fn rest(&self, time: u64) -> Duration {
        self.due(time).saturating_duration_since(Instant::now())
    }

    fn due(&self, time: u64) -> Instant {
        let (at, anchor) = self.anchor;
        let recorded = Duration::from_nanos(time.saturating_sub(anchor));
        // As fast as possible: at once. A moment too far away to be told is as good as never.
        let wall = Duration::try_from_secs_f64(recorded.as_secs_f64() / f64::from(self.speed));
        at + wall.unwrap_or_default().min(Duration::from_secs(1 << 32))
    }

    /// Notes that the moment of `time` was played, which took `cost`; the one after it is due at `next`.
    pub fn played(&mut self, time: u64, cost: Duration, next: Option<u64>) {
        match self.costs.len() {
            COSTS => self.costs[self.next_cost] = cost,
            _ => self.costs.push(cost),
        }
        self.next_cost = (self.next_cost + 1) % COSTS;
        self.note_rate(time);
        let now = Instant::now();
        let late = next.map_or(Duration::ZERO, |next| now.saturating_duration_since(self.due(next)));
        if self.speed.is_finite() && !late.is_zero() {
            self.late += 1;
            if late > MAX_BACKLOG {
                self.anchor = (now, time);
            }
        }
    }

    fn note_rate(&mut self, time: u64) {
        let (from, from_time) = self.rate_from;
        let elapsed = from.elapsed();
        if elapsed >= RATE_WINDOW || (self.real_time_factor == 0.0 && elapsed >= RATE_WINDOW / 5) {
            self.real_time_factor = (time.saturating_sub(from_time) as f64 / elapsed.as_nanos() as f64) as f32;
        }
        if elapsed >= RATE_WINDOW {
            self.rate_from = (Instant::now(), time);
        }
    }

    /// Moments that took until after the next was due.
    pub fn late(&self) -> u64 {
        self.late
    }

    /// Recorded seconds per wall second, over the last second or so.
    pub fn real_time_factor(&self) -> f32 {
        self.real_time_factor
    }

    /// Median and 99th percentile of what moments cost.
    pub fn percentiles(&self) -> [Duration; 2] {
        let mut sorted = self.costs.clone();
        sorted.sort_unstable();
        [50, 99].map(|percent| sorted.get(sorted.len() * percent / 100).copied().unwrap_or_default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_runs_at_the_wanted_speed() {
        let pace = Pace::new(10.0, 5_000);
        let second = Duration::from_secs(1);
        assert_eq!(pace.due(5_000 + 1_000_000_000) - pace.anchor.0, second / 10);
        let fastest = Pace::new(f32::INFINITY, 0);
        assert_eq!(fastest.due(u64::MAX), fastest.anchor.0);
        assert!(Pace::new(0.001, 0).rest(u64::MAX) > second);
    }

    #[test]
    fn what_is_late_is_counted_and_made_up_for_unless_it_is_too_much() {
        let mut pace = Pace::new(1.0, 0);
        let anchor = pace.anchor.0 - Duration::from_millis(50);
        pace.anchor.0 = anchor;
        pace.played(0, Duration::ZERO, Some(10_000_000));
        assert_eq!((pace.late(), pace.anchor.0), (1, anchor), "the schedule stays");
        pace.anchor.0 = anchor - Duration::from_secs(1);
        pace.played(10_000_000, Duration::ZERO, Some(20_000_000));
        assert_eq!((pace.late(), pace.anchor.1), (2, 10_000_000), "the schedule moves");
    }
}
