//! The figures of a fleet over time.

use regatta_plugin::history::FleetSample;

/// The largest number of samples: beyond it, every second one is dropped, and fewer are taken from
/// then on.
const MAX_SAMPLES: usize = 1_200;
/// The least simulated time between two samples at first, in seconds.
const FIRST_GAP: f64 = 0.5;

/// Samples of a run.
#[derive(Clone, Debug)]
pub struct Series {
    run: u64,
    gap: f64,
    /// The samples, the oldest first.
    pub samples: Vec<FleetSample>,
}

impl Default for Series {
    fn default() -> Self {
        Self { run: 0, gap: FIRST_GAP, samples: Vec::new() }
    }
}

impl Series {
    /// Whether a sample of a run at a time is wanted: there is none near it. A recording may jump
    /// back and forth.
    pub fn wants(&self, run: u64, secs: f64) -> bool {
        let next = self.number_at(secs);
        let (before, after) = (self.samples[..next].last(), self.samples.get(next));
        self.run != run
            || (before.is_none_or(|before| secs >= before.secs + self.gap)
                && after.is_none_or(|after| secs + self.gap <= after.secs))
    }

    /// Adds a sample. Another run resets the series.
    pub fn add(&mut self, run: u64, sample: FleetSample) {
        if self.run != run {
            *self = Self { run, ..Self::default() };
        }
        self.samples.insert(self.number_at(sample.secs), sample);
        if self.samples.len() > MAX_SAMPLES {
            let mut number = 0;
            self.samples.retain(|_| {
                number += 1;
                number % 2 == 1
            });
            self.gap *= 2.0;
        }
    }

    /// The number of the samples up to a time.
    fn number_at(&self, secs: f64) -> usize {
        // Time seldom goes back.
        if self.samples.last().is_none_or(|newest| newest.secs <= secs) {
            return self.samples.len();
        }
        self.samples.partition_point(|sample| sample.secs <= secs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_run_keeps_its_beginning_and_a_bounded_number_of_samples() {
        let mut series = Series::default();
        let mut secs = 0.0;
        while secs < 20_000.0 {
            if series.wants(1, secs) {
                series.add(1, FleetSample { secs, ..FleetSample::default() });
            }
            secs += 0.25;
        }
        let samples = &series.samples;
        assert!((MAX_SAMPLES / 2 - 1..=MAX_SAMPLES).contains(&samples.len()), "{}", samples.len());
        assert!(samples[0].secs == 0.0 && samples[samples.len() - 1].secs > 19_900.0);
        let gaps = samples.windows(2).map(|pair| pair[1].secs - pair[0].secs);
        assert!(gaps.fold(0.0, f64::max) < 70.0, "even over the run");
        assert!(series.wants(2, 0.0), "another run");
        series.add(2, FleetSample { secs: 5.0, ..FleetSample::default() });
        assert_eq!(series.samples.len(), 1);
    }

    #[test]
    fn a_jump_back_in_a_recording_keeps_the_samples() {
        let mut series = Series::default();
        for secs in [100.0, 101.0, 102.0, 0.0, 1.0, 100.2, 101.5] {
            if series.wants(1, secs) {
                series.add(1, FleetSample { secs, ..FleetSample::default() });
            }
        }
        let times: Vec<f64> = series.samples.iter().map(|sample| sample.secs).collect();
        assert_eq!(times, [0.0, 1.0, 100.0, 101.0, 101.5, 102.0]);
    }
}
