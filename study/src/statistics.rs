//! Statistics of simulation output: intervals over replications, the end of the warm-up, and the
//! knee of a curve.

use serde::Serialize;

/// The 97.5 % quantiles of Student's t distribution for 1 to 30 degrees of freedom.
const T_975: [f64; 30] = [
    12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160,
    2.145, 2.131, 2.120, 2.110, 2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056,
    2.052, 2.048, 2.045, 2.042,
];
/// The 97.5 % quantile of the normal distribution.
const Z_975: f64 = 1.959_964;

/// The largest quantile that is computed: that of one degree of freedom and of some thousand
/// intervals.
const MOST_QUANTILE: f64 = 1e6;

/// A mean with its 95 % confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// The mean.
    pub mean: f64,
    /// Half of the interval's width; `None` for a single value, which has no spread.
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
        let half_width = match count {
            0 => return None,
            1 => None,
            _ => Some(t_975(count - 1) * (squares / (count - 1) as f64 / count as f64).sqrt()),
        };
        Some(Self { mean, half_width, values: count })
    }

    /// Returns the mean of independent values with an interval that is one of some: all of them
    /// hold together with 95 % confidence (Bonferroni; Law, section 9.7). `None` if there are no values.
    pub fn joint(values: &[f64], intervals: usize) -> Option<Self> {
        let single = Self::of(values)?;
        let degrees = single.values.saturating_sub(1);
        let wider = quantile(degrees, 0.05 / intervals.max(1) as f64) / t_975(degrees);
        let wider = if intervals > 1 { wider } else { 1.0 };
        Some(Self { half_width: single.half_width.map(|half| half * wider), ..single })
    }

    /// Returns the interval with half of its width at least a value, unless the mean is 0.
    #[must_use]
    pub fn at_least(self, half_width: f64) -> Self {
        let wider = self.half_width.map(|own| own.max(half_width)).filter(|_| self.mean > 0.0);
        Self { half_width: wider.or(self.half_width), ..self }
    }

    /// Returns the interval as that of a single value if half of its width is at most this one: it
    /// would be written as 0.
    #[must_use]
    pub fn without_spread_up_to(self, least: f64) -> Self {
        Self { half_width: self.half_width.filter(|half_width| *half_width > least), ..self }
    }

    /// Whether half of the interval's width is less than its mean, so that the mean is an answer.
    pub fn is_known(&self) -> bool {
        self.half_width.is_some_and(|half_width| half_width < self.mean)
    }

    /// Whether half of the interval's width is at most a part of the mean's absolute value. A single
    /// value has no interval.
    pub fn is_within(&self, part: f64) -> bool {
        self.half_width.is_some_and(|half_width| half_width <= part * self.mean.abs())
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
    if let Some(quantile) = T_975.get(degrees.saturating_sub(1)) {
        return *quantile;
    }
    let (n, z) = (degrees as f64, Z_975);
    let (z3, z5) = (z.powi(3), z.powi(5));
    z + (z3 + z) / (4.0 * n) + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * n * n)
}

/// Returns the value that the absolute value of a variable with Student's t distribution exceeds
/// with a probability, rounded to a thousandth, as those of tables are: the same on any machine.
fn quantile(degrees: usize, probability: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    while beyond(degrees, high) > probability && high < MOST_QUANTILE {
        (low, high) = (high, high * 2.0);
    }
    while high - low > 1e-6 * high {
        let middle = f64::midpoint(low, high);
        let is_beyond = beyond(degrees, middle) > probability;
        (low, high) = if is_beyond { (middle, high) } else { (low, middle) };
    }
    (high * 1e3).round() / 1e3
}

/// Returns the probability that the absolute value of a variable with Student's t distribution is
/// above a value (Abramowitz and Stegun, 26.7.3 and 26.7.4).
fn beyond(degrees: usize, value: f64) -> f64 {
    let angle = (value / (degrees.max(1) as f64).sqrt()).atan();
    let square = angle.cos().powi(2);
    let is_odd = degrees % 2 == 1;
    let mut term = if is_odd { angle.cos() } else { 1.0 };
    let mut sum = if degrees > 1 { term } else { 0.0 };
    let mut factor = if is_odd { 2.0 } else { 1.0 };
    while factor + 2.0 <= degrees as f64 - 1.0 {
        term *= square * factor / (factor + 1.0);
        sum += term;
        factor += 2.0;
    }
    let within = match is_odd {
        true => std::f64::consts::FRAC_2_PI * (angle + angle.sin() * sum),
        false => angle.sin() * sum,
    };
    1.0 - within
}

/// Returns a percentile by the nearest rank, which is a value that occurred; `None` if there are no
/// values.
pub fn percentile(values: &[f64], hundredths: usize) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let rank = (sorted.len() * hundredths).div_ceil(100).max(1) - 1;
    sorted.get(rank).copied()
}

/// Returns the median: of an even number of values, the mean of the two in the middle; `None` if
/// there are no values.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let lower = sorted.get(sorted.len().saturating_sub(1) / 2)?;
    Some(f64::midpoint(*lower, sorted[sorted.len() / 2]))
}

/// The knee of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Knee {
    /// The index of the point.
    pub index: usize,
    /// Whether it is the last point: the knee may be beyond it.
    pub is_last: bool,
}

/// Returns the knee: the first point of a curve from which on each additional robot brings less
/// than a part of what one brings alone; `None` if there are no points, or none has any throughput.
///
/// Points are (robots, throughput), by ascending robots, which are above 0. The curve is replaced
/// by its upper concave hull, with the origin as its first point, because noise makes a measured
/// curve rise and fall. One robot alone brings the steepest slope of the hull, its first one.
pub fn knee(points: &[(f64, f64)], part: f64) -> Option<Knee> {
    let hull = hull(points);
    let corners: Vec<(f64, f64)> =
        std::iter::once((0.0, 0.0)).chain(hull.iter().map(|index| points[*index])).collect();
    let alone = slope(*corners.first()?, *corners.get(1)?);
    if alone <= 0.0 {
        return None;
    }
    // The knee is the beginning of the first flat piece; the piece from the origin is never flat.
    let flat = corners.windows(2).position(|pair| slope(pair[0], pair[1]) < part * alone);
    let corner = flat.unwrap_or(hull.len());
    let index = hull[corner - 1];
    Some(Knee { index, is_last: index + 1 == points.len() })
}

fn slope(from: (f64, f64), to: (f64, f64)) -> f64 {
    (to.1 - from.1) / (to.0 - from.0)
}

/// Returns the indices of the points on the upper concave hull, which begins at the origin
/// (Andrew's monotone chain).
fn hull(points: &[(f64, f64)]) -> Vec<usize> {
    let mut hull: Vec<usize> = Vec::new();
    for (index, point) in points.iter().enumerate() {
        while let Some(&last) = hull.last() {
            let before =
                hull.len().checked_sub(2).map_or((0.0, 0.0), |second| points[hull[second]]);
            let (first, second) = (points[last], *point);
            let cross = (first.0 - before.0) * (second.1 - before.1)
                - (first.1 - before.1) * (second.0 - before.0);
            if cross < 0.0 {
                break;
            }
            hull.pop();
        }
        hull.push(index);
    }
    hull
}

/// The number of values in a batch of MSER-5.
pub const BATCH: usize = 5;

/// Returns the number of values at the beginning of a series that are warm-up: whole batches of
/// [`BATCH`].
///
/// This is MSER-5 (White, "An effective truncation heuristic for bias reduction in simulation
/// output", Simulation 69, 1997; with batches of five: White, Cobb and Spratt, "A comparison of
/// five steady-state truncation heuristics for simulation", Winter Simulation Conference, 2000):
/// the number makes the standard error of the mean of the rest smallest: min over d of Σ (zⱼ - z̄)²
/// / (n - d)², with the batch means zⱼ, j > d, and their mean z̄. Only the first half of the series
/// is considered, as is usual: a minimum beyond it says that the series is too short. Of equal
/// minima, the first one is taken.
pub fn warm_up(series: &[f64]) -> usize {
    let batches: Vec<f64> =
        series.chunks_exact(BATCH).map(|batch| batch.iter().sum::<f64>() / BATCH as f64).collect();
    // From the end on, so that sums need one pass.
    let (mut sum, mut squares) = (0.0, 0.0);
    let mut best = (f64::INFINITY, 0);
    for (index, mean) in batches.iter().enumerate().rev() {
        sum += mean;
        squares += mean * mean;
        let rest = (batches.len() - index) as f64;
        let score = (squares - sum * sum / rest).max(0.0) / (rest * rest);
        if index <= batches.len() / 2 && score <= best.0 {
            best = (score, index);
        }
    }
    best.1 * BATCH
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
    fn joint_intervals_are_those_of_smaller_probabilities() {
        // Tables: t at 97.5 %, 99 %, 99.5 % and 99.9 %.
        for (degrees, probability, expected) in [
            (2, 0.05, 4.303),
            (9, 0.05, 2.262),
            (1, 0.02, 31.821),
            (2, 0.01, 9.925),
            (5, 0.01, 4.032),
            (10, 0.002, 4.144),
            (60, 0.01, 2.660),
        ] {
            let found = quantile(degrees, probability);
            assert!((found - expected).abs() < 1.1e-3, "{degrees}, {probability}: {found}");
        }
        let values = [1.0, 2.0, 4.0];
        assert_eq!(Interval::joint(&values, 1), Interval::of(&values));
        let [five, one] =
            [5, 1].map(|count| Interval::joint(&values, count).and_then(|it| it.half_width));
        let [five, one] = [five.expect("a width"), one.expect("a width")];
        assert!((five / one - 9.925 / 4.303).abs() < 1e-3, "{five} {one}");
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
    fn the_median_of_an_even_number_is_between_two_values() {
        assert_eq!((median(&[4.0, 1.0]), median(&[3.0, 1.0, 2.0])), (Some(2.5), Some(2.0)));
        assert_eq!((median(&[7.0]), median(&[])), (Some(7.0), None));
    }

    #[test]
    fn percentiles_are_values_that_occurred() {
        let values: Vec<f64> = (1..=200).rev().map(f64::from).collect();
        assert_eq!((percentile(&values, 50), percentile(&values, 99)), (Some(100.0), Some(198.0)));
        assert_eq!((percentile(&[4.0], 1), percentile(&[], 50)), (Some(4.0), None));
    }

    fn robots_at_knee(points: &[(f64, f64)], part: f64) -> Option<f64> {
        knee(points, part).map(|knee| points[knee.index].0)
    }

    #[test]
    fn a_curve_that_saturates_has_its_knee_there() {
        let points: Vec<(f64, f64)> =
            (1..=30).map(|robots| (f64::from(robots), 2.0 * f64::from(robots).min(12.0))).collect();
        assert_eq!(robots_at_knee(&points, 0.01), Some(12.0));
        assert_eq!(
            knee(&points[..8], 0.01),
            Some(Knee { index: 7, is_last: true }),
            "still rising"
        );
    }

    #[test]
    fn a_curve_that_falls_has_its_knee_at_its_top_and_dents_do_not_matter() {
        let points = [(1.0, 1.0), (2.0, 1.9), (4.0, 3.0), (8.0, 6.0), (16.0, 9.0), (32.0, 8.0)];
        assert_eq!(robots_at_knee(&points, 0.01), Some(16.0));
        // From 8 to 16, a robot brings 0.375 of what one brings alone.
        assert_eq!(robots_at_knee(&points, 0.5), Some(8.0));
    }

    #[test]
    fn nothing_has_no_knee() {
        assert_eq!((knee(&[], 0.01), knee(&[(1.0, 0.0), (2.0, 0.0)], 0.01)), (None, None));
        assert_eq!(knee(&[(5.0, 1.0)], 0.01), Some(Knee { index: 0, is_last: true }));
    }

    /// A sequence that looks random (a linear congruential generator), in -1 to 1.
    fn noise(count: usize) -> Vec<f64> {
        let mut state = 7_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 23) - 1.0
        };
        (0..count).map(|_| next()).collect()
    }

    #[test]
    fn a_ramp_at_the_beginning_is_cut_off() {
        let series: Vec<f64> = noise(200)
            .iter()
            .enumerate()
            .map(|(index, noise)| (index as f64 / 40.0).min(1.0) * 20.0 + noise)
            .collect();
        let cut = warm_up(&series);
        assert!((30..=50).contains(&cut), "{cut}");
    }

    #[test]
    fn what_has_no_warm_up_loses_little() {
        let series: Vec<f64> = noise(200).iter().map(|noise| 20.0 + noise).collect();
        assert!(warm_up(&series) <= 60, "{}", warm_up(&series));
        assert_eq!((warm_up(&[5.0; 100]), warm_up(&[]), warm_up(&[1.0, 2.0])), (0, 0, 0));
    }

    #[test]
    fn no_more_than_half_is_cut_off() {
        let series: Vec<f64> = (0..100).map(f64::from).collect();
        assert_eq!(warm_up(&series), 50);
    }

    #[test]
    fn the_score_is_that_of_the_definition() {
        let series = noise(60);
        let batches: Vec<f64> =
            series.chunks(BATCH).map(|batch| batch.iter().sum::<f64>() / 5.0).collect();
        let score = |cut: usize| {
            let rest = &batches[cut..];
            let mean = rest.iter().sum::<f64>() / rest.len() as f64;
            rest.iter().map(|value| (value - mean).powi(2)).sum::<f64>()
                / (rest.len() as f64).powi(2)
        };
        let best = (0..=6).min_by(|a, b| score(*a).total_cmp(&score(*b))).expect("cuts");
        assert_eq!(warm_up(&series), best * BATCH);
    }
}
