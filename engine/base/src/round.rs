//! Round numbers, for scales and axes: 1, 2 and 5 times a power of ten.

/// Returns the smallest round number that is at least `least`, which is above 0.
pub fn up(least: impl Into<f64>) -> f64 {
    let least = least.into();
    let unit = power_of_ten_below(least);
    let steps = [1.0, 2.0, 5.0].map(|factor| factor * unit);
    steps.into_iter().find(|round| *round >= least).unwrap_or(10.0 * unit)
}

/// Returns the largest round number that is at most `most`, which is above 0.
pub fn down(most: impl Into<f64>) -> f64 {
    let most = most.into();
    let unit = power_of_ten_below(most);
    let steps = [5.0, 2.0].map(|factor| factor * unit);
    steps.into_iter().find(|round| *round <= most).unwrap_or(unit)
}

fn power_of_ten_below(number: f64) -> f64 {
    10_f64.powf(number.log10().floor())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_to_1_2_or_5() {
        let numbers = [0.3, 0.9, 1.0, 4.9, 5.0, 7.0, 42.0, 99.0];
        assert_eq!(numbers.map(up), [0.5, 1.0, 1.0, 5.0, 5.0, 10.0, 50.0, 100.0]);
        assert_eq!(numbers.map(down), [0.2, 0.5, 1.0, 2.0, 5.0, 5.0, 20.0, 50.0]);
    }
}
