//! The figure by which reliefs are compared.

use crate::outcome::Measured;
use crate::plan::{Plan, Question, Side, Target, TargetFigure, Variant};
use crate::sweep::Point;
use crate::sweep::least::{interval, value};

/// A figure of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measure {
    /// Finished orders an hour: of a load that is never the limit.
    Throughput,
    /// The mean time of an order: of a load whose orders come at their own times.
    Service,
    /// The figure of a target.
    Target(Target),
}

impl Measure {
    /// Returns the figure for a point: that of the target with the least margin, or else the one
    /// that the load leaves open.
    pub fn of(plan: &Plan, variant: &Variant, point: &Point) -> Self {
        let Question::Least(targets) = &plan.question else {
            return if variant.is_load_endless() { Self::Throughput } else { Self::Service };
        };
        let margin = |target: &Target| {
            interval(target, point).map_or(f64::NEG_INFINITY, |it| target.margin(it.mean))
        };
        let binding = targets.iter().min_by(|a, b| margin(a).total_cmp(&margin(b)));
        binding.map_or(Self::Service, |target| Self::Target(*target))
    }

    /// The figure of a run, and the sign with which more is better.
    pub fn value(&self, run: &Measured) -> Option<f64> {
        match self {
            Self::Throughput => Some(run.orders_per_hour),
            Self::Service => run.service.as_ref().map(|service| service.mean_secs),
            Self::Target(target) => value(target, run),
        }
    }

    /// 1 if more is better, or else −1.
    pub fn sign(&self) -> f64 {
        let is_better = match self {
            Self::Throughput => true,
            Self::Service => false,
            Self::Target(target) => target.side() == Side::AtLeast,
        };
        if is_better { 1.0 } else { -1.0 }
    }

    /// The name of the figure.
    pub fn name(&self) -> String {
        match self {
            Self::Throughput => "orders an hour".to_owned(),
            Self::Service => "mean service".to_owned(),
            Self::Target(target) => target.name(),
        }
    }

    /// The unit, and the factor from the figure's own one.
    pub fn unit(&self) -> (&'static str, f64) {
        match self {
            Self::Throughput => ("orders an hour", 1.0),
            Self::Service => ("s", 1.0),
            Self::Target(target) => match target.figure {
                TargetFigure::Service(_) => ("s", 1.0),
                TargetFigure::Throughput => ("orders an hour", 1.0),
                TargetFigure::Late | TargetFigure::Waiting | TargetFigure::Utilisation => {
                    ("percentage points", 100.0)
                }
            },
        }
    }
}
