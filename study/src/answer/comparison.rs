//! Two variants against each other.

use serde::Serialize;

use crate::statistics::Interval;
use crate::sweep::{Fate, Known, Run};

/// A variant against the first one.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// The variant.
    pub name: String,
    /// By number of robots: those that both were run with.
    pub differences: Vec<Difference>,
}

/// The difference at a number of robots.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// The number of robots.
    pub robots: u32,
    /// Orders an hour of the first variant, over the seeds that both were run with.
    pub base: f64,
    /// Orders an hour more than the first variant, seed by seed.
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
        let pairs: Vec<[f64; 2]> = (base.range((robots, 0)..(robots + 1, 0)))
            .filter_map(|(run, _)| Some([orders(base, run)?, orders(other, run)?]))
            .collect();
        let differences: Vec<f64> = pairs.iter().map(|[base, other]| other - base).collect();
        let more_orders_per_hour = Interval::of(&differences)?;
        let base = pairs.iter().map(|[base, _]| base).sum::<f64>() / pairs.len() as f64;
        Some(Self { robots, base, more_orders_per_hour })
    }

    /// Whether the interval leaves out 0: the difference is more than chance.
    pub fn is_clear(&self) -> bool {
        let Interval { mean, half_width, .. } = self.more_orders_per_hour;
        half_width.is_some_and(|half_width| mean.abs() > half_width)
    }
}

fn orders(known: &Known, run: &Run) -> Option<f64> {
    match known.get(run)? {
        Fate::Done(measured) => Some(measured.orders_per_hour),
        Fate::Failed(_) => None,
    }
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
