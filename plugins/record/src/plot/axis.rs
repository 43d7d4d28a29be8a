//! Scales of axes: map values to pixels and place ticks at round numbers.

use regatta_base::round;

/// A linear map from a range of values to a range of pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Scale {
    pub fn new((low, high): (f64, f64), (from, to): (f64, f64)) -> Self {
        Self { low, high, from, to }
    }

    pub fn at(&self, value: f64) -> f64 {
        self.from + (value - self.low) / (self.high - self.low) * (self.to - self.from)
    }

    /// Returns round numbers in the range, at least `distance` pixels apart.
    pub fn ticks(&self, distance: f64) -> Vec<f64> {
        let least = (self.high - self.low) * distance / (self.to - self.from).abs();
        self.multiples(round::up(least.max(1e-9) * 0.999))
    }

    /// Returns the multiples of `step` in the range.
    pub fn multiples(&self, step: f64) -> Vec<f64> {
        let (first, last) =
            ((self.low / step - 1e-6).ceil() as i64, (self.high / step + 1e-6).floor() as i64);
        (first..=last).map(|i| i as f64 * step).collect()
    }
}

/// Returns a tick's label, with as many decimals as needed to distinguish the ticks.
pub(super) fn label(value: f64, ticks: &[f64]) -> String {
    let step = ticks.windows(2).map(|pair| pair[1] - pair[0]).fold(1.0, f64::min);
    let decimals = (-step.log10() - 1e-9).ceil().max(0.0) as usize;
    // Adding zero turns a negative zero into zero.
    format!("{:.decimals$}", value + 0.0).replace('-', "−")
}

/// Returns the range of the finite values with a margin. Its width without the margin is at least
/// `least`.
pub(super) fn range(values: impl Iterator<Item = f64>, least: f64) -> (f64, f64) {
    let finite = values.filter(|value| value.is_finite());
    let (low, high) =
        finite.fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(value), high.max(value)));
    if low > high {
        return (-least / 2.0, least / 2.0);
    }
    let extent = (high - low).max(least) * 1.12;
    let middle = f64::midpoint(low, high);
    (middle - extent / 2.0, middle + extent / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers_and_far_enough_apart() {
        let scale = Scale::new((-0.3, 10.2), (0.0, 500.0));
        assert_eq!(scale.ticks(80.0), [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        assert_eq!(scale.at(-0.3), 0.0);
        assert_eq!(Scale::new((1.23, 1.27), (100.0, 0.0)).ticks(24.0).len(), 5);
        assert_eq!(Scale::new((0.0, 1e6), (0.0, 100.0)).ticks(30.0), [0.0, 500_000.0, 1_000_000.0]);
    }

    #[test]
    fn labels_have_as_many_decimals_as_needed() {
        assert_eq!(label(-0.5, &[-0.5, 0.0, 0.5]), "−0.5");
        assert_eq!(label(20.0, &[0.0, 20.0]), "20");
        assert_eq!(label(-0.0, &[-0.25, 0.0]), "0.0");
    }

    #[test]
    fn a_range_has_a_margin_even_for_one_value() {
        assert_eq!(range([5.0].into_iter(), 2.0), (5.0 - 1.12, 5.0 + 1.12));
        let (low, high) = range([0.0, 10.0, f64::NAN].into_iter(), 1.0);
        assert!((low + 0.6).abs() < 1e-9 && (high - 10.6).abs() < 1e-9);
    }
}
