//! Durations in the buckets of a Prometheus histogram, and their statistics since the previous
//! query.

/// The upper bounds of the buckets, in seconds: 1, 2.5 and 5 of each power of ten from ten
/// microseconds to ten seconds.
pub const BOUNDS: [f64; 19] = [
    1e-5, 2.5e-5, 5e-5, 1e-4, 2.5e-4, 5e-4, 1e-3, 2.5e-3, 5e-3, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5,
    1.0, 2.5, 5.0, 10.0,
];

/// A histogram of durations since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Histogram {
    /// Number of durations up to each of [`BOUNDS`] and above the bound before it.
    pub buckets: [u64; BOUNDS.len()],
    /// Number of all durations, including those above the last bound.
    pub count: u64,
    /// Sum of all durations, in seconds.
    pub sum: f64,
}

impl Histogram {
    fn observe(&mut self, seconds: f64) {
        if let Some(bucket) = self.buckets.get_mut(BOUNDS.partition_point(|&bound| bound < seconds))
        {
            *bucket += 1;
        }
        self.count += 1;
        self.sum += seconds;
    }
}

/// Statistics of durations since the previous query.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DurationStats {
    /// Number of durations.
    pub count: u64,
    /// Sum, in seconds.
    pub sum: f64,
    /// Maximum, in seconds.
    pub max: f64,
}

impl DurationStats {
    /// Returns the mean and the maximum, in seconds; `None` without durations.
    pub fn mean_and_max(&self) -> Option<(f64, f64)> {
        (self.count > 0).then(|| (self.sum / self.count as f64, self.max))
    }
}

/// A recorder of durations.
#[derive(Clone, Copy, Debug, Default)]
pub struct DurationRecorder {
    /// Histogram since the start.
    pub histogram: Histogram,
    stats: DurationStats,
}

impl DurationRecorder {
    /// Records a duration of 0 seconds or more.
    pub fn observe(&mut self, seconds: f64) {
        self.histogram.observe(seconds);
        self.stats.count += 1;
        self.stats.sum += seconds;
        self.stats.max = self.stats.max.max(seconds);
    }

    /// Returns the statistics since the previous call.
    pub fn take_stats(&mut self) -> DurationStats {
        std::mem::take(&mut self.stats)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn buckets_count_durations_up_to_their_bound(times in prop::collection::vec(0.0_f64..20.0, 0..200)) {
            let mut recorder = DurationRecorder::default();
            times.iter().for_each(|&time| recorder.observe(time));
            let mut cumulative = 0;
            for (bound, bucket) in BOUNDS.iter().zip(recorder.histogram.buckets) {
                cumulative += bucket;
                prop_assert_eq!(cumulative, times.iter().filter(|time| *time <= bound).count() as u64);
            }
            prop_assert_eq!(recorder.histogram.count, times.len() as u64);
            let max = times.iter().copied().fold(0.0, f64::max);
            prop_assert_eq!(recorder.take_stats().max, max);
            prop_assert_eq!(recorder.take_stats().mean_and_max(), None);
        }
    }

    #[test]
    fn a_bound_is_inside_its_bucket() {
        let mut recorder = DurationRecorder::default();
        BOUNDS.iter().for_each(|&bound| recorder.observe(bound));
        assert_eq!(recorder.histogram.buckets, [1; BOUNDS.len()]);
    }
}
