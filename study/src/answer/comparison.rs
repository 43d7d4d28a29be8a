//! Comparisons of variants with the first one.

use serde::Serialize;

use crate::statistics::Interval;
use crate::sweep::{Known, Run};

/// The comparison of a variant with the first one.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// The variant.
    pub name: String,
    /// The differences by number of robots, for the numbers that both were run with.
    pub differences: Vec<Difference>,
}

/// The difference at a number of robots.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// The number of robots.
    pub robots: u32,
    /// Orders an hour of the first variant, the mean over the seeds that both were run with.
    pub base: f64,
    /// The additional orders an hour, seed by seed.
    pub more_orders_per_hour: Interval,
}

impl Difference {
    /// Returns the difference at a number of robots, of the seeds that both have; `None` if there
    /// are none.
    ///
    /// Runs with the same seed have the same orders and disturbances (common random numbers), so it
    /// is the interval of paired differences (Law, Simulation Modeling and Analysis, 5th edition,
    /// sections 10.2.1 and 11.2).
    pub fn of(base: &Known, other: &Known, robots: u32) -> Option<Self> {
        let (mut sum, mut differences) = (0.0, Vec::new());
        for (run, _) in base.range((robots, 0)..(robots + 1, 0)) {
            if let (Some(base), Some(other)) = (orders(base, run), orders(other, run)) {
                sum += base;
                differences.push(other - base);
            }
        }
        let more_orders_per_hour = Interval::of(&differences)?;
        Some(Self { robots, base: sum / differences.len() as f64, more_orders_per_hour })
    }

    /// Whether the interval excludes 0, so that the difference is more than chance.
    pub fn is_clear(&self) -> bool {
        let Interval { mean, half_width, .. } = self.more_orders_per_hour;
        half_width.is_some_and(|half_width| mean.abs() > half_width)
    }
}

fn orders(known: &Known, run: &Run) -> Option<f64> {
    Some(known.get(run)?.as_ref().ok()?.orders_per_hour)
}

impl Comparison {
    /// Compares a variant with the first one.
    pub fn of(name: &str, base: &Known, other: &Known) -> Self {
        let mut robots: Vec<u32> = base.keys().map(|(robots, _)| *robots).collect();
        robots.dedup();
        let differences =
            robots.into_iter().filter_map(|robots| Difference::of(base, other, robots)).collect();
        Self { name: name.to_owned(), differences }
    }
}
