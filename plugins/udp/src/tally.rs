//! Counts, timers and measurements that both plugins report.

use std::fmt;
use std::time::{Duration, Instant};

use crate::line::LineFault;

/// The numbers of ignored lines and datagrams, by cause.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Faults {
    /// Lines that are not an id and three numbers.
    pub malformed: u64,
    /// Lines with a negative id.
    pub negative_id: u64,
    /// Lines with an id that is larger than the fleet allows.
    pub id_too_large: u64,
    /// Lines with a number that is NaN, infinite or too large.
    pub not_finite: u64,
    /// Datagrams that are too long.
    pub oversized: u64,
}

impl Faults {
    /// Counts an ignored line.
    pub fn count(&mut self, fault: LineFault) {
        *match fault {
            LineFault::Malformed => &mut self.malformed,
            LineFault::NegativeId => &mut self.negative_id,
            LineFault::IdTooLarge => &mut self.id_too_large,
            LineFault::NotFinite => &mut self.not_finite,
        } += 1;
    }

    fn causes(&self) -> [(&'static str, u64); 5] {
        [
            ("malformed lines", self.malformed),
            ("negative ids", self.negative_id),
            ("ids too large", self.id_too_large),
            ("lines not finite", self.not_finite),
            ("oversized datagrams", self.oversized),
        ]
    }
}

/// Lists the causes that occurred: `12 malformed lines, 1 oversized datagrams`, or `nothing`.
impl fmt::Display for Faults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let occurred = self.causes().into_iter().filter(|(_, count)| *count > 0);
        let text: Vec<_> = occurred.map(|(cause, count)| format!("{count} {cause}")).collect();
        f.write_str(if text.is_empty() { "nothing" } else { "" })?;
        f.write_str(&text.join(", "))
    }
}

/// A timer that limits reports to one per second.
#[derive(Debug)]
pub struct EverySecond {
    next: Instant,
}

impl EverySecond {
    /// Creates a timer whose first second starts at `now`.
    pub fn new(now: Instant) -> Self {
        Self { next: now + Duration::from_secs(1) }
    }

    /// Whether a second has passed since this was last true.
    pub fn has_passed(&mut self, now: Instant) -> bool {
        let passed = now >= self.next;
        if passed {
            self.next = now + Duration::from_secs(1);
        }
        passed
    }
}

/// A measurement of wall-clock and processor time.
#[derive(Debug)]
pub struct Effort {
    started: Instant,
    cpu: Option<Duration>,
}

impl Effort {
    /// Starts a measurement.
    pub fn start() -> Self {
        Self { started: Instant::now(), cpu: process_time() }
    }

    /// Returns the wall-clock time since the start, in seconds.
    pub fn wall_secs(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Returns the processor time that this process has used since the start, in seconds; `None` on
    /// systems that don't report it.
    pub fn cpu_secs(&self) -> Option<f64> {
        Some(process_time()?.saturating_sub(self.cpu?).as_secs_f64())
    }
}

/// Formats the measurement as `in 10.02 s, 0.031 of a core`.
impl fmt::Display for Effort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let wall = self.wall_secs();
        write!(f, "in {wall:.2} s")?;
        match self.cpu_secs() {
            Some(cpu) => write!(f, ", {:.3} of a core", cpu / wall.max(1e-9)),
            None => Ok(()),
        }
    }
}

#[cfg(unix)]
fn process_time() -> Option<Duration> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    Duration::try_from(time).ok()
}

#[cfg(not(unix))]
fn process_time() -> Option<Duration> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_listed_by_cause() {
        let mut faults = Faults::default();
        assert_eq!(faults.to_string(), "nothing");
        for fault in [
            LineFault::Malformed,
            LineFault::NegativeId,
            LineFault::NegativeId,
            LineFault::IdTooLarge,
            LineFault::NotFinite,
        ] {
            faults.count(fault);
        }
        assert_eq!(
            faults.to_string(),
            "1 malformed lines, 2 negative ids, 1 ids too large, 1 lines not finite"
        );
    }

    #[test]
    fn the_timer_elapses_once_a_second() {
        let start = Instant::now();
        let mut second = EverySecond::new(start);
        let at = |millis| start + Duration::from_millis(millis);
        let passed: Vec<_> =
            [0, 999, 1_000, 1_001, 5_000, 5_500].map(|t| second.has_passed(at(t))).to_vec();
        assert_eq!(passed, [false, false, true, false, true, false]);
    }

    #[test]
    #[cfg(unix)]
    fn processor_time_is_measured() {
        let effort = Effort::start();
        let mut sum = 0_u64;
        while effort.cpu_secs().is_some_and(|secs| secs == 0.0) {
            sum = std::hint::black_box(sum + 1);
        }
        assert!(effort.cpu_secs() > Some(0.0) && effort.wall_secs() > 0.0);
    }
}
