//! The cost of a fleet, by the scheme of VDI 2710-4: the annuity of what is bought, and the running
//! cost of a year.

mod fleet;

use serde::Serialize;

use self::fleet::Fleet;
use super::{LeastAnswer, PartAnswer};
use crate::outcome::RunEnd;
use crate::plan::{Prices, Target, Variant};
use crate::statistics::Interval;
use crate::sweep::least::{Standing, standing};
use crate::sweep::{Curve, Point};

/// A figure of cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CostFigure {
    /// The price of all that is bought.
    Investment,
    /// The annuity of the investment.
    Capital,
    /// The maintenance of a year.
    Maintenance,
    /// The energy of a year.
    Energy,
    /// The cost of a year that doesn't depend on the number of robots.
    Operation,
    /// The cost of a year.
    Year,
    /// The cost of an order.
    Order,
}

impl CostFigure {
    /// All figures; each comes after those that it needs.
    pub const ALL: [Self; 7] = [
        Self::Investment,
        Self::Capital,
        Self::Maintenance,
        Self::Energy,
        Self::Operation,
        Self::Year,
        Self::Order,
    ];
    /// The parts of the cost of a year.
    pub const PARTS: [Self; 4] = [Self::Capital, Self::Maintenance, Self::Energy, Self::Operation];

    /// The name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Investment => "investment",
            Self::Capital => "capital a year",
            Self::Maintenance => "maintenance a year",
            Self::Energy => "energy a year",
            Self::Operation => "operation a year",
            Self::Year => "cost a year",
            Self::Order => "cost an order",
        }
    }
}

/// The cost of the fleets of a variant.
#[derive(Clone, Debug, Serialize)]
pub struct CostAnswer {
    /// The numbers of robots that were tried.
    pub points: Vec<PointCost>,
    /// The cheapest of them, if its cost is known.
    pub cheapest: Option<Cheapest>,
    /// The figures that aren't known, with the keys of the prices that are missing.
    pub missing: Vec<Missing>,
}

/// The cost of a number of robots; `None` where prices are missing.
#[derive(Clone, Debug, Serialize)]
pub struct PointCost {
    /// The number of robots.
    pub robots: u32,
    /// The number of chargers.
    pub chargers: Option<f64>,
    /// The price of robots, chargers and project.
    pub investment: Option<f64>,
    /// The hours of operation of a year.
    pub hours_per_year: Option<Interval>,
    /// The parts of the cost of a year.
    pub year_parts: Vec<PartAnswer>,
    /// The cost of a year: the sum of the parts.
    pub per_year: Option<Interval>,
    /// The cost of a finished order.
    pub per_order: Option<Interval>,
}

/// The cheapest of the numbers of robots that were tried.
#[derive(Clone, Debug, Serialize)]
pub struct Cheapest {
    /// The number of robots.
    pub robots: u32,
    /// The figure by which it is the cheapest: that of a year if there are targets, or else that of
    /// an order.
    pub by: CostFigure,
    /// That figure.
    pub cost: Interval,
    /// Whether it is the largest number that counts, so that more may be cheaper.
    pub is_open: bool,
}

/// A figure that isn't known.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Missing {
    /// The figure.
    pub figure: CostFigure,
    /// The keys of the missing prices.
    pub keys: Vec<&'static str>,
}

impl CostAnswer {
    /// Computes the cost of all points of a curve.
    pub(super) fn new(
        prices: &Prices,
        variant: &Variant,
        targets: &[Target],
        curve: &Curve,
        least: Option<&LeastAnswer>,
    ) -> Self {
        let mut points = Vec::new();
        for point in &curve.points {
            points.push(PointCost::new(&Fleet::new(prices, variant, point.robots), point));
        }
        let fleet = Fleet::new(prices, variant, 0);
        let missing = CostFigure::ALL.map(|figure| Missing { figure, keys: fleet.missing(figure) });
        let missing = missing.into_iter().filter(|missing| !missing.keys.is_empty()).collect();
        let counts: Vec<bool> = match least {
            Some(_) => curve.points.iter().map(|point| meets(targets, point)).collect(),
            None => counts(curve),
        };
        let by = if least.is_some() { CostFigure::Year } else { CostFigure::Order };
        let cheapest = cheapest(&points, &counts, by);
        Self { points, cheapest, missing }
    }
}

fn meets(targets: &[Target], point: &Point) -> bool {
    targets.iter().all(|target| standing(target, point) == Standing::Met)
}

/// Whether each point counts without targets: none does from the first one on with robots that made
/// no progress, and none of a day with open orders.
fn counts(curve: &Curve) -> Vec<bool> {
    let stalled = curve.points.iter().position(Point::is_stalled).unwrap_or(usize::MAX);
    let mut counts = Vec::new();
    for (point, index) in curve.points.iter().zip(0..) {
        let is_done = point.runs.iter().all(|run| run.end != RunEnd::Overdue);
        let orders = point.counted_throughput();
        let is_known = orders.is_some_and(|orders| orders.is_known());
        counts.push(index < stalled && is_done && is_known);
    }
    counts
}

fn cheapest(points: &[PointCost], counts: &[bool], by: CostFigure) -> Option<Cheapest> {
    let mut costs = Vec::new();
    for (point, _) in points.iter().zip(counts).filter(|(_, counts)| **counts) {
        let cost = if by == CostFigure::Year { point.per_year } else { point.per_order };
        costs.push((point.robots, cost?));
    }
    let last = costs.last()?.0;
    let least = costs.into_iter().min_by(|(_, a), (_, b)| a.mean.total_cmp(&b.mean))?;
    Some(Cheapest { robots: least.0, by, cost: least.1, is_open: least.0 == last })
}

impl PointCost {
    fn new(fleet: &Fleet<'_>, point: &Point) -> Self {
        let parts = CostFigure::PARTS.into_iter().filter_map(|part| {
            let value = point.interval(|run| fleet.part(part, run))?;
            Some(PartAnswer { name: part.name(), value })
        });
        Self {
            robots: point.robots,
            chargers: fleet.chargers(),
            investment: fleet.investment(),
            hours_per_year: point.interval(|run| fleet.hours(run)),
            year_parts: parts.collect(),
            per_year: point.interval(|run| fleet.year(run)),
            per_order: per_order(fleet, point),
        }
    }
}

/// The cost of an order. Its interval is at least that of one order a run, as the throughput's, but
/// for days: their runs end with the last order, so that its time doesn't matter.
fn per_order(fleet: &Fleet<'_>, point: &Point) -> Option<Interval> {
    let cost = point.interval(|run| fleet.order(run))?;
    if fleet.works_by_days() {
        return Some(cost);
    }
    let counted = point.counted_throughput()?;
    let least = counted.half_width.map(|half_width| cost.mean * half_width / counted.mean);
    let half_width = cost.half_width.zip(least).map(|(spread, least)| spread.max(least));
    Some(Interval { half_width, ..cost })
}

#[cfg(test)]
mod tests;
