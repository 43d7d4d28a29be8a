//! The end of the warm-up: MSER-5.
//!
//! White, "An effective truncation heuristic for bias reduction in simulation output", Simulation
//! 69 (1997); with batches of five: White, Cobb and Spratt, "A comparison of five steady-state
//! truncation heuristics for simulation", Winter Simulation Conference (2000).

/// The number of values in a batch.
pub const BATCH: usize = 5;

/// Returns how many values at the beginning of a series are warm-up: whole batches of [`BATCH`].
///
/// It is the number that makes the standard error of the mean of the rest smallest: min over d of Σ
/// (zⱼ - z̄)² / (n - d)², with the batch means zⱼ, j > d, and their mean z̄. Only the first half of
/// the series is considered, as is usual: a minimum beyond it says that the series is too short. Of
/// equal minima, the first one is taken.
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
