//! What ticks cost, over the last second or so.

use std::time::{Duration, Instant};

/// Costs that percentiles are taken of.
const WINDOW: usize = 1024;
/// How often the real-time factor is taken; for the first time after a fifth of that.
const RATE_WINDOW: Duration = Duration::from_secs(1);

/// Costs of the last ticks, and how fast simulated time passes.
#[derive(Debug)]
pub struct TickStats {
    costs: Vec<Duration>,
    next: usize,
    last: Duration,
    rate_from: (Instant, u64),
    real_time_factor: f32,
}

impl TickStats {
    pub fn new(now: Instant) -> Self {
        Self {
            costs: Vec::with_capacity(WINDOW),
            next: 0,
            last: Duration::ZERO,
            rate_from: (now, 0),
            real_time_factor: 0.0,
        }
    }

    pub fn tick_done(&mut self, cost: Duration) {
        self.last = cost;
        if self.costs.len() < WINDOW {
            self.costs.push(cost);
        } else {
            self.costs[self.next] = cost;
        }
        self.next = (self.next + 1) % WINDOW;
    }

    /// Notes that `tick` was reached at `now`.
    pub fn note_time(&mut self, tick: u64, tick_period: Duration, now: Instant) {
        let (from, from_tick) = self.rate_from;
        let elapsed = now.saturating_duration_since(from);
        if elapsed >= RATE_WINDOW || (self.real_time_factor == 0.0 && elapsed >= RATE_WINDOW / 5) {
            let simulated = tick_period.as_secs_f64() * (tick - from_tick) as f64;
            self.real_time_factor = (simulated / elapsed.as_secs_f64().max(1e-9)) as f32;
        }
        if elapsed >= RATE_WINDOW {
            self.rate_from = (now, tick);
        }
    }

    /// Starts the real-time factor anew, after a pause.
    pub fn restart(&mut self, tick: u64, now: Instant) {
        self.rate_from = (now, tick);
        self.real_time_factor = 0.0;
    }

    pub fn last_cost(&self) -> Duration {
        self.last
    }

    pub fn real_time_factor(&self) -> f32 {
        self.real_time_factor
    }

    /// Median and 99th percentile.
    pub fn percentiles(&self) -> (Duration, Duration) {
        let mut sorted = self.costs.clone();
        sorted.sort_unstable();
        let at = |part: f64| {
            let index = (sorted.len() as f64 * part) as usize;
            sorted.get(index.min(sorted.len().saturating_sub(1))).copied().unwrap_or_default()
        };
        (at(0.5), at(0.99))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_of_the_last_window() {
        let mut stats = TickStats::new(Instant::now());
        (0..WINDOW).for_each(|_| stats.tick_done(Duration::from_secs(9)));
        (0..WINDOW as u64).rev().for_each(|cost| stats.tick_done(Duration::from_nanos(cost)));
        assert_eq!(stats.percentiles(), (Duration::from_nanos(512), Duration::from_nanos(1013)));
    }

    #[test]
    fn without_ticks_there_are_zeros() {
        assert_eq!(TickStats::new(Instant::now()).percentiles(), (Duration::ZERO, Duration::ZERO));
    }

    #[test]
    fn the_real_time_factor_is_simulated_over_wall_time() {
        let start = Instant::now();
        let mut stats = TickStats::new(start);
        stats.note_time(200, Duration::from_millis(10), start + Duration::from_secs(1));
        assert!((stats.real_time_factor() - 2.0).abs() < 1e-6);
    }
}
