//! Times of which some are known only so far.

/// The distribution of times of which some are known only so far: the estimate of Kaplan and Meier
/// (Nonparametric estimation from incomplete observations, JASA 53, 1958).
#[derive(Clone, Debug)]
pub struct Survival {
    /// The times at which some were over, in ascending order, with the part that lasts longer.
    steps: Vec<(f64, f64)>,
    /// The longest time, over or not.
    longest: f64,
}

impl Survival {
    /// Returns the distribution of times that were over, and of some so far; `None` if there are
    /// none.
    pub fn of(over: &[f64], so_far: &[f64]) -> Option<Self> {
        let mut times: Vec<(f64, bool)> = over.iter().map(|time| (*time, true)).collect();
        times.extend(so_far.iter().map(|time| (*time, false)));
        // Of equal times, those that were over come first: the others last longer.
        times.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        let longest = times.last()?.0;
        let (mut steps, mut lasting) = (Vec::new(), 1.0);
        for (index, (time, is_over)) in times.iter().enumerate() {
            if *is_over {
                let at_risk = (times.len() - index) as f64;
                lasting *= 1.0 - 1.0 / at_risk;
                steps.push((*time, lasting));
            }
        }
        Some(Self { steps, longest })
    }

    /// Returns a percentile; the longest time so far if it isn't less.
    pub fn percentile(&self, hundredths: usize) -> f64 {
        let lasting = 1.0 - hundredths as f64 / 100.0 + ROUNDING;
        let step = self.steps.iter().find(|step| step.1 <= lasting);
        step.map_or(self.longest, |(time, _)| *time)
    }

    /// Returns the mean, of times up to the longest one.
    pub fn mean(&self) -> f64 {
        let (mut mean, mut before, mut lasting) = (0.0, 0.0, 1.0);
        for (time, part) in &self.steps {
            mean += lasting * (time - before);
            (before, lasting) = (*time, *part);
        }
        mean + lasting * (self.longest - before)
    }
}

/// The largest error of a part that is a product of fractions.
const ROUNDING: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;

    /// The remission times of 21 patients under 6-MP in weeks (E. Freireich et al., Blood 21,
    /// 1963), with the estimate that textbooks give.
    #[test]
    fn the_estimate_is_that_of_a_published_example() {
        let over = [6.0, 6.0, 6.0, 7.0, 10.0, 13.0, 16.0, 22.0, 23.0];
        let so_far = [6.0, 9.0, 10.0, 11.0, 17.0, 19.0, 20.0, 25.0, 32.0, 32.0, 34.0, 35.0];
        let survival = Survival::of(&over, &so_far).expect("times");
        let parts: Vec<f64> =
            survival.steps.iter().map(|step| (step.1 * 1e3).round() / 1e3).collect();
        assert_eq!(parts[2..], [0.857, 0.807, 0.753, 0.69, 0.627, 0.538, 0.448]);
        assert_eq!((survival.percentile(50), survival.percentile(90)), (23.0, 35.0));
    }

    #[test]
    fn times_that_are_all_over_have_their_own_percentiles_and_mean() {
        let times: Vec<f64> = (1..=100).map(f64::from).collect();
        let survival = Survival::of(&times, &[]).expect("times");
        for hundredths in [50, 90, 95, 99, 100] {
            assert_eq!(survival.percentile(hundredths), hundredths as f64);
        }
        assert!((survival.mean() - 50.5).abs() < 1e-9, "{}", survival.mean());
        assert!(Survival::of(&[], &[]).is_none());
    }

    #[test]
    fn half_of_the_orders_are_never_carried() {
        let survival = Survival::of(&[100.0; 10], &[3000.0; 10]).expect("times");
        assert_eq!((survival.percentile(50), survival.percentile(90)), (100.0, 3000.0));
        assert!((survival.mean() - 1550.0).abs() < 1e-9);
    }
}
