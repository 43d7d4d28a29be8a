//! Times, sorted into buckets as Prometheus wants them, and their spread since the last look.

/// Upper bounds of the buckets, in seconds: 1, 2.5 and 5 of each power of ten from ten microseconds to ten seconds.
pub const BOUNDS: [f64; 19] = [
    1e-5, 2.5e-5, 5e-5, 1e-4, 2.5e-4, 5e-4, 1e-3, 2.5e-3, 5e-3, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0,
];

/// How often a time was how long, since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Histogram {
    /// Times up to each of [`BOUNDS`] and above the bound before it.
    pub buckets: [u64; BOUNDS.len()],
    /// All times, those above the last bound included.
    pub count: u64,
    /// Their sum, in seconds.
    pub sum: f64,
}

impl Histogram {
    fn observe(&mut self, seconds: f64) {
        if let Some(bucket) = self.buckets.get_mut(BOUNDS.partition_point(|&bound| bound < seconds)) {
            *bucket += 1;
        }
        self.count += 1;
        self.sum += seconds;
    }
}

/// Times since the last look.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// How many.
    pub count: u64,
    /// Their sum, in seconds.
    pub sum: f64,
    /// The longest, in seconds.
    pub max: f64,
}

impl Spread {
    /// Mean and longest, in seconds; `None` if there were none.
    pub fn mean_and_max(&self) -> Option<(f64, f64)> {
        (self.count > 0).then(|| (self.sum / self.count as f64, self.max))
    }
}

/// A time that is measured again and again.
#[derive(Clone, Copy, Debug, Default)]
pub struct Measure {
    /// Since the start.
    pub histogram: Histogram,
    spread: Spread,
}

impl Measure {
    /// Notes one measurement of 0 seconds or more.
    pub fn observe(&mut self, seconds: f64) {
        self.histogram.observe(seconds);
        self.spread.count += 1;
        self.spread.sum += seconds;
        self.spread.max = self.spread.max.max(seconds);
    }

    /// The spread since the last call.
    pub fn take_spread(&mut self) -> Spread {
        std::mem::take(&mut self.spread)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn buckets_hold_what_is_up_to_their_bound(times in prop::collection::vec(0.0_f64..20.0, 0..200)) {
            let mut measure = Measure::default();
            times.iter().for_each(|&time| measure.observe(time));
            let mut cumulative = 0;
            for (bound, bucket) in BOUNDS.iter().zip(measure.histogram.buckets) {
                cumulative += bucket;
                prop_assert_eq!(cumulative, times.iter().filter(|time| *time <= bound).count() as u64);
            }
            prop_assert_eq!(measure.histogram.count, times.len() as u64);
            let max = times.iter().copied().fold(0.0, f64::max);
            prop_assert_eq!(measure.take_spread().max, max);
            prop_assert_eq!(measure.take_spread().mean_and_max(), None);
        }
    }

    #[test]
    fn a_bound_belongs_to_its_bucket() {
        let mut measure = Measure::default();
        BOUNDS.iter().for_each(|&bound| measure.observe(bound));
        assert_eq!(measure.histogram.buckets, [1; BOUNDS.len()]);
    }
}
