//! The fixed rate of the source's frames.

use std::time::{Duration, Instant};

/// Behind by more than this, the schedule is moved.
const MAX_BACKLOG: Duration = Duration::from_millis(100);
/// Costs of ticks that are remembered.
const WINDOW: usize = 256;

/// Says when ticks are due, and keeps their costs.
#[derive(Debug)]
pub struct Ticker {
    period: Duration,
    due: Instant,
    pub tick: u64,
    pub late_ticks: u64,
    costs: Vec<Duration>,
    /// Where the real-time factor is taken from.
    from: (Instant, u64),
    pub real_time_factor: f32,
}

impl Ticker {
    /// A ticker whose first tick is due at `now`.
    pub fn new(period: Duration, now: Instant) -> Self {
        let costs = Vec::with_capacity(WINDOW);
        Self { period, due: now, tick: 0, late_ticks: 0, costs, from: (now, 0), real_time_factor: 0.0 }
    }

    /// Time between ticks.
    pub fn period(&self) -> Duration {
        self.period
    }

    /// Simulated time: the ticks so far times the period.
    pub fn sim_time_nanos(&self) -> u64 {
        self.period.as_nanos() as u64 * self.tick
    }

    /// How long until the next tick is due.
    pub fn rest(&self, now: Instant) -> Duration {
        self.due.saturating_duration_since(now)
    }

    /// What the last tick cost.
    pub fn last_cost(&self) -> Duration {
        self.costs.last().copied().unwrap_or_default()
    }

    /// Goes on after a pause.
    pub fn restart(&mut self, now: Instant) {
        self.due = now;
        (self.from, self.real_time_factor) = ((now, self.tick), 0.0);
    }

    /// The tick that was due took from `start` to `now`.
    pub fn tick_done(&mut self, start: Instant, now: Instant) {
        if self.costs.len() == WINDOW {
            self.costs.remove(0);
        }
        self.costs.push(now.saturating_duration_since(start));
        self.due += self.period;
        let backlog = now.saturating_duration_since(self.due);
        self.late_ticks += u64::from(!backlog.is_zero());
        if backlog > MAX_BACKLOG {
            self.late_ticks += (backlog.as_nanos() / self.period.as_nanos().max(1)) as u64;
            self.due = now;
        }
        let elapsed = now.saturating_duration_since(self.from.0);
        if elapsed >= Duration::from_secs(1) {
            let simulated = self.period.as_secs_f64() * (self.tick - self.from.1) as f64;
            self.real_time_factor = (simulated / elapsed.as_secs_f64()) as f32;
            self.from = (now, self.tick);
        }
    }

    /// Median and 99th percentile of the costs.
    pub fn cost_percentiles(&self) -> [Duration; 2] {
        let mut sorted = self.costs.clone();
        sorted.sort_unstable();
        [50, 99].map(|part| sorted.get(sorted.len() * part / 100).copied().unwrap_or_default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: Duration = Duration::from_millis(20);

    #[test]
    fn ticks_are_due_by_a_schedule_that_does_not_drift() {
        let start = Instant::now();
        let mut ticker = Ticker::new(PERIOD, start);
        for tick in 1..=100 {
            ticker.tick = tick;
            let at = start + PERIOD * (tick as u32 - 1);
            ticker.tick_done(at, at + PERIOD / 4);
        }
        assert_eq!(ticker.rest(start + PERIOD * 99), PERIOD);
        assert_eq!((ticker.late_ticks, ticker.sim_time_nanos()), (0, 2_000_000_000));
        assert_eq!(ticker.cost_percentiles(), [PERIOD / 4; 2]);
        assert!((ticker.real_time_factor - 1.0).abs() < 0.05, "{}", ticker.real_time_factor);
    }

    #[test]
    fn late_ticks_are_counted_and_after_a_stop_the_schedule_moves() {
        let start = Instant::now();
        let mut ticker = Ticker::new(PERIOD, start);
        ticker.tick_done(start, start + PERIOD * 2);
        assert_eq!((ticker.late_ticks, ticker.rest(start)), (1, PERIOD), "made up for");
        let late = start + Duration::from_secs(2);
        ticker.tick_done(late, late);
        assert_eq!(ticker.late_ticks, 1 + 1 + 98);
        assert_eq!(ticker.rest(late), Duration::ZERO);
        ticker.tick_done(late, late);
        assert_eq!(ticker.rest(late), PERIOD);
    }
}
