//! Confidence intervals of means.

use serde::Serialize;

/// The 97.5 % quantiles of Student's t distribution for 1 to 30 degrees of freedom.
const T_975: [f64; 30] = [
    12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160,
    2.145, 2.131, 2.120, 2.110, 2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056,
    2.052, 2.048, 2.045, 2.042,
];
/// The 97.5 % quantile of the normal distribution.
const Z_975: f64 = 1.959_964;

/// A mean with its 95 % confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// The mean.
    pub mean: f64,
    /// Half of the interval's width; `None` for a single value, which tells nothing of it.
    pub half_width: Option<f64>,
    /// The number of values.
    pub values: usize,
}

impl Interval {
    /// Returns the mean of independent values with Student's interval (Law, Simulation Modeling and
    /// Analysis, 5th edition, section 4.5); `None` if there are none.
    pub fn of(values: &[f64]) -> Option<Self> {
        let count = values.len();
        let mean = values.iter().sum::<f64>() / count as f64;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        let half_width =
            |count: usize| t_975(count - 1) * (squares / (count - 1) as f64 / count as f64).sqrt();
        (count > 0).then(|| Self {
            mean,
            half_width: (count > 1).then(|| half_width(count)),
            values: count,
        })
    }

    /// Half of the interval's width over the mean's absolute value; `None` for a single value or a
    /// mean of 0 with a spread.
    pub fn relative(&self) -> Option<f64> {
        match self.half_width? {
            0.0 => Some(0.0),
            half_width => {
                Some(half_width / self.mean.abs()).filter(|relative| relative.is_finite())
            }
        }
    }
}

/// Returns the 97.5 % quantile of Student's t distribution. Beyond the table it is expanded about
/// the normal one to 1/n² (Abramowitz and Stegun, 26.7.5), which is exact to three decimals there.
fn t_975(degrees: usize) -> f64 {
    let n = degrees as f64;
    let expanded = || {
        let [z, z3, z5] = [Z_975, Z_975.powi(3), Z_975.powi(5)];
        z + (z3 + z) / (4.0 * n) + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * n * n)
    };
    T_975.get(degrees.saturating_sub(1)).copied().unwrap_or_else(expanded)
}

/// Returns the smallest value that so many hundredths of all values don't exceed; `None` if there
/// are none.
pub fn percentile(values: &[f64], hundredths: usize) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let rank = (sorted.len() * hundredths).div_ceil(100).max(1) - 1;
    sorted.get(rank).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_of_a_textbook_is_met() {
        // Law, example 4.27: ten values with mean 1.34 and variance 0.17, whose 90 % interval is
        // 1.34 ± 0.24 with t = 1.833; with t = 2.262, it is ± 0.29.
        let values = [1.20, 1.50, 1.68, 1.89, 0.95, 1.49, 1.58, 1.55, 0.50, 1.09];
        let interval = Interval::of(&values).expect("values");
        let half_width = interval.half_width.expect("ten values");
        assert!(
            (interval.mean - 1.343).abs() < 1e-9 && (half_width - 0.293).abs() < 5e-3,
            "{interval:?}"
        );
    }

    #[test]
    fn one_value_has_no_interval_and_equal_ones_have_none_to_speak_of() {
        assert_eq!(Interval::of(&[]), None);
        assert_eq!(Interval::of(&[3.0]), Some(Interval { mean: 3.0, half_width: None, values: 1 }));
        assert_eq!(Interval::of(&[3.0, 3.0]).and_then(|interval| interval.relative()), Some(0.0));
        assert_eq!(Interval::of(&[-1.0, 1.0]).and_then(|interval| interval.relative()), None);
    }

    #[test]
    fn quantiles_go_on_beyond_the_table() {
        for (degrees, expected) in
            [(1, 12.706), (30, 2.042), (31, 2.040), (60, 2.000), (120, 1.980)]
        {
            assert!((t_975(degrees) - expected).abs() < 6e-4, "{degrees}: {}", t_975(degrees));
        }
    }

    #[test]
    fn percentiles_are_values_that_occurred() {
        let values: Vec<f64> = (1..=200).rev().map(f64::from).collect();
        assert_eq!((percentile(&values, 50), percentile(&values, 99)), (Some(100.0), Some(198.0)));
        assert_eq!((percentile(&[4.0], 1), percentile(&[], 50)), (Some(4.0), None));
    }
}
