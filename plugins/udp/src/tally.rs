//! What is counted on either side, and how it is told.

use std::fmt;
use std::time::{Duration, Instant};

use crate::line::LineFault;

/// Input that was ignored, by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Faults {
    /// Lines that are not an id and three numbers.
    pub malformed: u64,
    /// Lines with a negative id.
    pub negative_id: u64,
    /// Lines with an id that the fleet has no room for.
    pub id_too_large: u64,
    /// Lines with a number that is NaN, infinite or too large.
    pub not_finite: u64,
    /// Datagrams over the limit of their length.
    pub oversized: u64,
}

impl Faults {
    /// Counts a line that is not used.
    pub fn count(&mut self, fault: LineFault) {
        *match fault {
            LineFault::Malformed => &mut self.malformed,
            LineFault::NegativeId => &mut self.negative_id,
            LineFault::IdTooLarge => &mut self.id_too_large,
            LineFault::NotFinite => &mut self.not_finite,
        } += 1;
    }

    fn kinds(&self) -> [(&'static str, u64); 5] {
        [
            ("malformed lines", self.malformed),
            ("negative ids", self.negative_id),
            ("ids too large", self.id_too_large),
            ("lines not finite", self.not_finite),
            ("oversized datagrams", self.oversized),
        ]
    }
}

/// The kinds that occurred: `12 malformed lines, 1 oversized datagrams`, or `nothing`.
impl fmt::Display for Faults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let occurred = self.kinds().into_iter().filter(|(_, count)| *count > 0);
        let text: Vec<_> = occurred.map(|(kind, count)| format!("{count} {kind}")).collect();
        f.write_str(if text.is_empty() { "nothing" } else { "" })?;
        f.write_str(&text.join(", "))
    }
}

/// Says when a second has passed, so that nothing is told more often.
#[derive(Debug)]
pub struct EverySecond {
    next: Instant,
}

impl EverySecond {
    /// The first second starts at `now`.
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

/// Wall and processor time since the start.
#[derive(Debug)]
pub struct Effort {
    started: Instant,
    cpu: Option<Duration>,
}

impl Effort {
    /// Starts counting.
    pub fn start() -> Self {
        Self { started: Instant::now(), cpu: process_time() }
    }

    /// Seconds since the start.
    pub fn wall_secs(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Processor seconds that this process has used since the start; `None` where the system doesn't say.
    pub fn cpu_secs(&self) -> Option<f64> {
        Some(process_time()?.saturating_sub(self.cpu?).as_secs_f64())
    }
}

/// `… in 10.02 s, 0.031 of a core`.
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
    fn faults_are_told_by_kind() {
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
        assert_eq!(faults.to_string(), "1 malformed lines, 2 negative ids, 1 ids too large, 1 lines not finite");
    }

    #[test]
    fn a_second_passes_once_a_second() {
        let start = Instant::now();
        let mut second = EverySecond::new(start);
        let at = |millis| start + Duration::from_millis(millis);
        let passed: Vec<_> = [0, 999, 1_000, 1_001, 5_000, 5_500].map(|t| second.has_passed(at(t))).to_vec();
        assert_eq!(passed, [false, false, true, false, true, false]);
    }

    #[test]
    #[cfg(unix)]
    fn work_takes_processor_time() {
        let effort = Effort::start();
        let mut sum = 0_u64;
        while effort.cpu_secs().is_some_and(|secs| secs == 0.0) {
            sum = std::hint::black_box(sum + 1);
        }
        assert!(effort.cpu_secs() > Some(0.0) && effort.wall_secs() > 0.0);
    }
}
