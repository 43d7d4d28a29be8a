//! Recorders of durations: in the buckets of a Prometheus histogram, with their statistics since
//! the previous query, and with their distribution, in bounded memory.

use std::collections::BTreeMap;

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

/// The bits of a number's mantissa that a group of times doesn't distinguish: 9 of 52 are left, so
/// that two times of a group differ by less than 0.2 %.
const IGNORED_BITS: u32 = 43;

/// The distribution of some times, in seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TimeSummary {
    /// Number of times.
    pub count: u64,
    /// Their sum.
    pub sum: f64,
    /// The 50th percentile, to 0.1 %.
    pub p50: f64,
    /// The 99th percentile, to 0.1 %.
    pub p99: f64,
    /// The longest.
    pub longest: f64,
}

impl TimeSummary {
    /// Returns the mean; `None` without times.
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }
}

/// A recorder of times.
#[derive(Clone, Debug, Default)]
pub struct TimeRecorder {
    /// Number of times in each group.
    groups: BTreeMap<u64, u64>,
    count: u64,
    sum: f64,
    longest: f64,
}

impl TimeRecorder {
    /// Records a time of 0 seconds or more.
    pub fn observe(&mut self, secs: f64) {
        // The bits of positive numbers are in the order of the numbers.
        *self.groups.entry(secs.to_bits() >> IGNORED_BITS).or_default() += 1;
        self.count += 1;
        self.sum += secs;
        self.longest = self.longest.max(secs);
    }

    /// Returns the distribution of all times.
    pub fn summary(&self) -> TimeSummary {
        let Self { count, sum, longest, .. } = *self;
        TimeSummary { count, sum, p50: self.percentile(50), p99: self.percentile(99), longest }
    }

    /// Returns the smallest time that so many hundredths of all times don't exceed; 0 without
    /// times.
    fn percentile(&self, hundredths: u64) -> f64 {
        let rank = (self.count * hundredths).div_ceil(100);
        let mut cumulative = 0;
        let group = self.groups.iter().find(|(_, count)| {
            cumulative += **count;
            cumulative >= rank
        });
        group.map_or(0.0, |(group, _)| middle(*group).min(self.longest))
    }
}

/// Returns the middle of a group.
fn middle(group: u64) -> f64 {
    f64::from_bits(group << IGNORED_BITS | 1 << (IGNORED_BITS - 1))
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

    proptest! {
        #[test]
        fn percentiles_equal_those_of_the_sorted_times(times in prop::collection::vec(0.0_f64..1e5, 1..300)) {
            let mut recorder = TimeRecorder::default();
            times.iter().for_each(|time| recorder.observe(*time));
            let mut sorted = times.clone();
            sorted.sort_by(f64::total_cmp);
            let summary = recorder.summary();
            prop_assert_eq!((summary.count, summary.longest), (times.len() as u64, sorted[times.len() - 1]));
            for (found, hundredths) in [(summary.p50, 50), (summary.p99, 99)] {
                let exact = sorted[(times.len() * hundredths).div_ceil(100) - 1];
                prop_assert!((found - exact).abs() <= 1e-3 * exact, "{} instead of {}", found, exact);
            }
        }
    }

    #[test]
    fn without_times_there_is_no_mean() {
        assert_eq!(
            (TimeRecorder::default().summary(), TimeSummary::default().mean()),
            (TimeSummary::default(), None)
        );
        let mut recorder = TimeRecorder::default();
        [0.0, 1.0].into_iter().for_each(|secs| recorder.observe(secs));
        let summary = recorder.summary();
        assert_eq!((summary.mean(), summary.longest), (Some(0.5), 1.0));
        assert!(summary.p50 < 1e-300 && (summary.p99 - 1.0).abs() < 1e-3, "{summary:?}");
    }
}
