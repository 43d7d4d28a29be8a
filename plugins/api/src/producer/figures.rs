//! The figures of a producer: the cost of ticks, and the real-time factor.

use std::time::{Duration, Instant};

/// The number of ticks that percentiles cover.
const WINDOW: usize = 1024;
/// The time that the real-time factor covers. It is first known after a fifth of that.
const RATE_WINDOW: Duration = Duration::from_secs(1);

/// The costs of the last ticks, and the real-time factor.
#[derive(Debug)]
pub struct Figures {
    costs: Vec<Duration>,
    next: usize,
    last: Duration,
    rate_from: (Instant, u64),
    real_time_factor: f32,
}

impl Figures {
    /// Creates figures of no tick; the simulated time is `sim_nanos` at `now`.
    pub fn new(sim_nanos: u64, now: Instant) -> Self {
        Self {
            costs: Vec::with_capacity(WINDOW),
            next: 0,
            last: Duration::ZERO,
            rate_from: (now, sim_nanos),
            real_time_factor: 0.0,
        }
    }

    /// Records the cost of a tick.
    pub fn note_cost(&mut self, cost: Duration) {
        self.last = cost;
        if self.costs.len() < WINDOW {
            self.costs.push(cost);
        } else {
            self.costs[self.next] = cost;
        }
        self.next = (self.next + 1) % WINDOW;
    }

    /// Records that the simulated time `sim_nanos` was reached at `now`.
    pub fn note_time(&mut self, sim_nanos: u64, now: Instant) {
        let (from, from_nanos) = self.rate_from;
        let elapsed = now.saturating_duration_since(from);
        if elapsed >= RATE_WINDOW || (self.real_time_factor == 0.0 && elapsed >= RATE_WINDOW / 5) {
            let simulated = sim_nanos.saturating_sub(from_nanos) as f64;
            self.real_time_factor = (simulated / elapsed.as_nanos().max(1) as f64) as f32;
        }
        if elapsed >= RATE_WINDOW {
            self.rate_from = (now, sim_nanos);
        }
    }

    /// Measures the real-time factor afresh, after a pause or a jump in time.
    pub fn restart(&mut self, sim_nanos: u64, now: Instant) {
        self.rate_from = (now, sim_nanos);
        self.real_time_factor = 0.0;
    }

    /// The cost of the last tick.
    pub fn last_cost(&self) -> Duration {
        self.last
    }

    /// Simulated seconds per wall second, over the last second or so; 0 if unknown yet.
    pub fn real_time_factor(&self) -> f32 {
        self.real_time_factor
    }

    /// The median and the 99th percentile of the costs of the last ticks.
    pub fn percentiles(&self) -> (Duration, Duration) {
        let mut sorted = self.costs.clone();
        sorted.sort_unstable();
        (percentile(&sorted, 0.5), percentile(&sorted, 0.99))
    }
}

/// Returns the value that a part of sorted values is below; zero if there are none.
fn percentile(sorted: &[Duration], part: f64) -> Duration {
    let index = (sorted.len() as f64 * part) as usize;
    sorted.get(index.min(sorted.len().saturating_sub(1))).copied().unwrap_or_default()
}

/// The resident memory of this process in bytes, shared memory included; 0 if the system doesn't
/// report it.
pub fn resident_bytes() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kibibytes = line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<u64>().ok());
    kibibytes.unwrap_or(0) * 1024
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_cover_the_last_window() {
        let mut figures = Figures::new(0, Instant::now());
        (0..WINDOW).for_each(|_| figures.note_cost(Duration::from_secs(9)));
        (0..WINDOW as u64).rev().for_each(|cost| figures.note_cost(Duration::from_nanos(cost)));
        assert_eq!(figures.percentiles(), (Duration::from_nanos(512), Duration::from_nanos(1013)));
    }

    #[test]
    fn without_ticks_percentiles_are_zero() {
        assert_eq!(Figures::new(0, Instant::now()).percentiles(), (Duration::ZERO, Duration::ZERO));
    }

    #[test]
    fn the_real_time_factor_is_simulated_over_wall_time() {
        let start = Instant::now();
        let mut figures = Figures::new(0, start);
        figures.note_time(2_000_000_000, start + Duration::from_secs(1));
        assert!((figures.real_time_factor() - 2.0).abs() < 1e-6);
        figures.restart(0, start);
        assert!(figures.real_time_factor() == 0.0);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn the_memory_of_a_process_is_known() {
        assert!(resident_bytes() > 100_000);
    }
}
