//! The time that a study is expected to need yet.

use std::collections::BTreeMap;
use std::time::Duration;

/// The wall-clock times of finished runs, by their number of robots.
#[derive(Clone, Debug, Default)]
pub struct RunTimes {
    sums: BTreeMap<u32, Sum>,
}

/// The times of some runs.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    secs: f64,
    runs: u32,
}

impl Sum {
    fn mean(&self) -> f64 {
        self.secs / f64::from(self.runs.max(1))
    }
}

impl RunTimes {
    /// Notes the time of a finished run.
    pub fn note(&mut self, robots: u32, secs: f64) {
        let sum = self.sums.entry(robots).or_default();
        *sum = Sum { secs: sum.secs + secs, runs: sum.runs + 1 };
    }

    /// Returns the time that runs need, `side_by_side` at once; `None` if no run has finished.
    pub fn to_go(
        &self,
        runs: impl IntoIterator<Item = u32>,
        side_by_side: usize,
    ) -> Option<Duration> {
        let mut secs = 0.0;
        for robots in runs {
            secs += self.secs(robots)?;
        }
        Some(Duration::from_secs_f64(secs / side_by_side.max(1) as f64))
    }

    /// Returns the expected time of a run: on the line between the neighbours; beyond the most
    /// robots it grows with their number.
    fn secs(&self, robots: u32) -> Option<f64> {
        let below = self.sums.range(..=robots).next_back();
        let above = self.sums.range(robots..).next();
        match (below, above) {
            (Some((low, from)), Some((high, to))) if low < high => {
                let part = f64::from(robots - low) / f64::from(high - low);
                Some(from.mean() + (to.mean() - from.mean()) * part)
            }
            (Some((_, sum)), Some(_)) | (None, Some((_, sum))) => Some(sum.mean()),
            (Some((most, sum)), None) => {
                Some(sum.mean() * f64::from(robots) / f64::from((*most).max(1)))
            }
            (None, None) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_follow_the_number_of_robots() {
        let mut times = RunTimes::default();
        assert_eq!(times.to_go([5], 1), None);
        assert_eq!(times.to_go([], 1), Some(Duration::ZERO));
        for (robots, secs) in [(10, 1.0), (10, 3.0), (20, 4.0)] {
            times.note(robots, secs);
        }
        let secs = |runs: &[u32], side_by_side| {
            times.to_go(runs.iter().copied(), side_by_side).map(|time| time.as_secs_f64())
        };
        assert_eq!(secs(&[1, 10, 15, 20, 40], 1), Some(2.0 + 2.0 + 3.0 + 4.0 + 8.0));
        assert_eq!(secs(&[20, 20, 20], 2), Some(6.0));
    }
}
