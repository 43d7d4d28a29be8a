//! Scales: from values to pixels, and where the round numbers are.

/// Maps a range of values to a range of pixels.
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

    /// Round numbers in the range, at least `distance` pixels apart.
    pub fn ticks(&self, distance: f64) -> Vec<f64> {
        self.multiples(step((self.high - self.low) * distance / (self.to - self.from).abs()))
    }

    /// Multiples of `step` in the range.
    pub fn multiples(&self, step: f64) -> Vec<f64> {
        let (first, last) = ((self.low / step - 1e-6).ceil() as i64, (self.high / step + 1e-6).floor() as i64);
        (first..=last).map(|i| i as f64 * step).collect()
    }
}

/// The smallest of 1, 2, 5, 10, 20, 50 … (and their fractions) that is at least `wanted`.
fn step(wanted: f64) -> f64 {
    let magnitude = 10_f64.powf(wanted.max(1e-9).log10().floor());
    [1.0, 2.0, 5.0]
        .iter()
        .map(|factor| factor * magnitude)
        .find(|step| *step >= wanted * 0.999)
        .unwrap_or(10.0 * magnitude)
}

/// A tick's number, with as many decimals as it takes to tell ticks apart.
pub(super) fn label(value: f64, ticks: &[f64]) -> String {
    let step = ticks.windows(2).map(|pair| pair[1] - pair[0]).fold(1.0, f64::min);
    let decimals = (-step.log10() - 1e-9).ceil().max(0.0) as usize;
    // No negative zero.
    format!("{:.decimals$}", value + 0.0).replace('-', "−")
}

/// The range of some values with some room around, not narrower than `least`.
pub(super) fn range(values: impl Iterator<Item = f64>, least: f64) -> (f64, f64) {
    let finite = values.filter(|value| value.is_finite());
    let (low, high) = finite.fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(value), high.max(value)));
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
    fn ticks_are_round_and_far_enough_apart() {
        let scale = Scale::new((-0.3, 10.2), (0.0, 500.0));
        assert_eq!(scale.ticks(80.0), [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        assert_eq!(scale.at(-0.3), 0.0);
        assert_eq!(Scale::new((1.23, 1.27), (100.0, 0.0)).ticks(24.0).len(), 5);
        assert_eq!(Scale::new((0.0, 1e6), (0.0, 100.0)).ticks(30.0), [0.0, 500_000.0, 1_000_000.0]);
    }

    #[test]
    fn labels_have_the_decimals_that_they_need() {
        assert_eq!(label(-0.5, &[-0.5, 0.0, 0.5]), "−0.5");
        assert_eq!(label(20.0, &[0.0, 20.0]), "20");
        assert_eq!(label(-0.0, &[-0.25, 0.0]), "0.0");
    }

    #[test]
    fn a_range_has_room_around_even_for_one_value() {
        assert_eq!(range([5.0].into_iter(), 2.0), (5.0 - 1.12, 5.0 + 1.12));
        let (low, high) = range([0.0, 10.0, f64::NAN].into_iter(), 1.0);
        assert!((low + 0.6).abs() < 1e-9 && (high - 10.6).abs() < 1e-9);
    }
}
