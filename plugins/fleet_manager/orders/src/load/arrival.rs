//! The times at which a generator makes orders.

use regatta_base::random::Random;
use regatta_base::yaml::{self, Fields, Node};

use crate::distribution::Distribution;

/// The largest rate, in orders an hour.
const MAX_PER_HOUR: f64 = 1e8;
/// The largest number of orders that come at the same time.
const MAX_BATCH: u64 = 10_000;

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Arrival {
    /// At random, at the mean rates of this profile.
    Poisson(Vec<Shift>),
    /// These seconds apart.
    Gaps(Distribution),
    /// Whenever fewer than this number of orders are open, or fewer than there are robots.
    Endless(Option<usize>),
}

/// A part of a profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shift {
    /// Its end in seconds; infinite for a rate that never changes.
    pub(crate) until_secs: f64,
    pub(crate) per_hour: f64,
}

/// The number of orders that come at the same time: any from `min` to `max`, with the same
/// probability.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Batch {
    min: u64,
    max: u64,
}

impl Default for Batch {
    fn default() -> Self {
        Self { min: 1, max: 1 }
    }
}

impl Batch {
    /// The mean number of orders.
    pub(crate) fn mean(self) -> f64 {
        (self.min + self.max) as f64 / 2.0
    }

    /// Returns a number of orders, at least 1.
    pub(crate) fn orders(self, random: Random, draw: u64) -> u64 {
        self.min + random.below(draw, (self.max - self.min + 1) as usize) as u64
    }
}

impl Arrival {
    pub(super) fn read(value: &Node, fields: &Fields<'_, '_>) -> Result<Self, yaml::Error> {
        let keys = ["per_hour", "shifts", "gaps", "endless"];
        match keys.map(|key| fields.get(key)) {
            [Some(rate), None, None, None] => Ok(Self::Poisson(vec![Shift {
                until_secs: f64::INFINITY,
                per_hour: per_hour(rate)?,
            }])),
            [None, Some(shifts), None, None] => profile(shifts).map(Self::Poisson),
            [None, None, Some(gaps), None] => gaps_of(gaps).map(Self::Gaps),
            [None, None, None, Some(orders)] => endless(orders).map(Self::Endless),
            _ => {
                Err(value
                    .error("give a generator exactly one of per_hour, shifts, gaps and endless"))
            }
        }
    }
}

/// Reads the batches of orders that come at the same time.
pub(super) fn batch(fields: &Fields<'_, '_>, arrival: &Arrival) -> Result<Batch, yaml::Error> {
    let Some(value) = fields.get("batch") else { return Ok(Batch::default()) };
    if matches!(arrival, Arrival::Endless(_)) {
        return Err(
            value.error("an endless load has no batches: it makes each order as another ends")
        );
    }
    if !value.is_map() {
        let orders = batch_size(value)?;
        return Ok(Batch { min: orders, max: orders });
    }
    let sizes = value.fields(&["min", "max"])?;
    let (min, max) = (batch_size(sizes.required("min")?)?, batch_size(sizes.required("max")?)?);
    if min <= max { Ok(Batch { min, max }) } else { Err(value.error("`min` is above `max`")) }
}

fn batch_size(value: &Node) -> Result<u64, yaml::Error> {
    match value.integer(MAX_BATCH)? {
        0 => Err(value.error("a batch has at least one order")),
        orders => Ok(orders),
    }
}

fn gaps_of(value: &Node) -> Result<Distribution, yaml::Error> {
    let gaps = Distribution::read(value)?;
    if gaps.is_zero() {
        return Err(
            value.error("gaps of 0 s: orders would come without an end; give a longer time")
        );
    }
    Ok(gaps)
}

fn endless(orders: &Node) -> Result<Option<usize>, yaml::Error> {
    match orders.text()?.as_ref() {
        "robots" => Ok(None),
        _ => Ok(Some(orders.integer(1_000_000)? as usize)),
    }
}

fn per_hour(value: &Node) -> Result<f64, yaml::Error> {
    match value.non_negative()? {
        rate if rate <= MAX_PER_HOUR => Ok(rate),
        rate => {
            Err(value
                .error(format!("{rate} orders an hour are too many; give at most {MAX_PER_HOUR}")))
        }
    }
}

fn profile(value: &Node) -> Result<Vec<Shift>, yaml::Error> {
    let mut shifts: Vec<Shift> = Vec::new();
    for shift in value.list()? {
        let fields = shift.fields(&["until", "per_hour"])?;
        let until_secs = fields.required("until")?.non_negative()?;
        if until_secs <= shifts.last().map_or(0.0, |last| last.until_secs) {
            return Err(shift.error("`until` must be later than that of the previous shift"));
        }
        shifts.push(Shift { until_secs, per_hour: per_hour(fields.required("per_hour")?)? });
    }
    if shifts.is_empty() { Err(value.error("there are no shifts")) } else { Ok(shifts) }
}
