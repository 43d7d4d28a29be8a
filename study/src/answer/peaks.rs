//! A day by its hours: orders that come and that are carried, their times, and the backlog.

use serde::Serialize;

use crate::outcome::{Backlog, HOUR_SECS, HourOrders, Outcome, Service, hours};
use crate::plan::DayClock;
use crate::statistics::{Interval, percentile};

/// A figure over the seeds: its mean with its interval, and the least and the largest value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// The mean.
    #[serde(flatten)]
    pub interval: Interval,
    /// The least value.
    pub least: f64,
    /// The largest value.
    pub most: f64,
}

impl Spread {
    fn of(values: &[f64]) -> Option<Self> {
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Some(Self { interval: Interval::of(values)?, least, most })
    }
}

/// The orders of an hour.
#[derive(Clone, Debug, Serialize)]
pub struct HourAnswer {
    /// The hour, from the beginning of the run on: 0 is the first.
    pub hour: usize,
    /// The orders that came.
    pub released: Spread,
    /// The orders whose deadline was then.
    pub due: Spread,
    /// The orders that were finished.
    pub carried: Spread,
    /// The 50th percentile of the times of those that came, from creation to end, in seconds.
    pub service_p50_secs: Option<Spread>,
    /// The 99th percentile of them.
    pub service_p99_secs: Option<Spread>,
}

/// The mean hour of a day.
#[derive(Clone, Debug, Serialize)]
pub struct MeanHour {
    /// The hours from that of the first order to that in which the last one came.
    pub hours: Spread,
    /// The orders that came, by hour of these.
    pub released: Spread,
    /// The 50th percentile of the times of all orders of the day, in seconds.
    pub service_p50_secs: Option<Spread>,
    /// The 99th percentile of them.
    pub service_p99_secs: Option<Spread>,
}

/// The backlog over a day.
#[derive(Clone, Debug, Serialize)]
pub struct BacklogAnswer {
    /// The length of a period, in seconds.
    pub period_secs: f64,
    /// The most orders that were open at once in each period, from the beginning of the run on.
    pub open: Vec<Spread>,
    /// The most orders that were open at once in the day.
    pub largest: Spread,
    /// The time at which so many were open first, in seconds.
    pub largest_at_secs: Spread,
    /// The seconds from then on until no more orders than robots were open; `None` if no run came
    /// so far.
    pub cleared_after_largest_secs: Option<Spread>,
    /// The seconds from the arrival of the last order until none was open; `None` likewise.
    pub cleared_after_last_secs: Option<Spread>,
}

/// A day of the first variant with the number of robots of the answer.
#[derive(Clone, Debug, Serialize)]
pub struct PeaksAnswer {
    /// The number of robots.
    pub robots: u32,
    /// The time of day at which runs begin, if the file of orders has times of day.
    pub clock: Option<DayClock>,
    /// The number of runs.
    pub runs: usize,
    /// Orders that were given up or cancelled, in all runs: they are in no other figure.
    pub given_up: u64,
    /// The mean hour.
    pub mean_hour: MeanHour,
    /// The index of the hour whose orders have the longest 99th percentile on average.
    pub worst_hour: Option<usize>,
    /// The hours.
    pub hours: Vec<HourAnswer>,
    /// The backlog.
    pub backlog: BacklogAnswer,
}

/// The lengths of periods of the backlog, in seconds, and the most periods of a day.
const PERIODS_SECS: [f64; 4] = [60.0, 300.0, 900.0, 3600.0];
const MOST_PERIODS: f64 = 300.0;

impl PeaksAnswer {
    /// Returns the peaks of some runs of a day; `None` if no order came in any.
    pub fn new(robots: u32, clock: Option<DayClock>, outcomes: &[Outcome]) -> Option<Self> {
        let figures = outcomes.iter().map(|outcome| &outcome.figures);
        let by_run: Vec<Vec<HourOrders>> = figures.clone().map(hours).collect();
        let last = by_run.iter().map(Vec::len).max()?;
        let mut hours = Vec::new();
        for hour in 0..last {
            hours.push(HourAnswer::new(hour, &by_run)?);
        }
        let backlogs: Vec<Backlog> = figures.clone().filter_map(Backlog::of).collect();
        Some(Self {
            robots,
            clock,
            runs: outcomes.len(),
            given_up: figures.map(|figures| figures.failed + figures.cancelled).sum(),
            mean_hour: MeanHour::new(&by_run)?,
            worst_hour: worst(&hours),
            hours,
            backlog: BacklogAnswer::new(robots, &backlogs)?,
        })
    }
}

/// Returns the index of the hour with the longest 99th percentile: the first of equal ones.
fn worst(hours: &[HourAnswer]) -> Option<usize> {
    let mut worst: Option<(usize, f64)> = None;
    for (hour, index) in hours.iter().zip(0..) {
        let Some(p99) = hour.service_p99_secs.map(|spread| spread.interval.mean) else { continue };
        if worst.is_none_or(|(_, longest)| p99 > longest) {
            worst = Some((index, p99));
        }
    }
    worst.map(|(index, _)| index)
}

/// Returns a figure over the runs that have it.
fn spread<T>(runs: &[T], figure: impl Fn(&T) -> Option<f64>) -> Option<Spread> {
    Spread::of(&runs.iter().filter_map(figure).collect::<Vec<_>>())
}

impl HourAnswer {
    fn new(hour: usize, by_run: &[Vec<HourOrders>]) -> Option<Self> {
        // A run that is over has no orders.
        let none = HourOrders::default();
        let runs: Vec<&HourOrders> =
            by_run.iter().map(|hours| hours.get(hour).unwrap_or(&none)).collect();
        let services: Vec<Option<Service>> = runs.iter().map(|orders| orders.service()).collect();
        Some(Self {
            hour,
            released: spread(&runs, |orders| Some(orders.released))?,
            due: spread(&runs, |orders| Some(orders.due))?,
            carried: spread(&runs, |orders| Some(orders.carried))?,
            service_p50_secs: spread(&services, |service| Some(service.as_ref()?.p50_secs)),
            service_p99_secs: spread(&services, |service| Some(service.as_ref()?.p99_secs)),
        })
    }
}

impl MeanHour {
    fn new(by_run: &[Vec<HourOrders>]) -> Option<Self> {
        let all: Vec<Vec<f64>> = by_run.iter().map(|hours| service_secs(hours)).collect();
        Some(Self {
            hours: spread(by_run, |hours| busy_hours(hours))?,
            released: spread(by_run, |hours| {
                let released: f64 = hours.iter().map(|hour| hour.released).sum();
                Some(released / busy_hours(hours)?)
            })?,
            service_p50_secs: spread(&all, |secs| percentile(secs, 50)),
            service_p99_secs: spread(&all, |secs| percentile(secs, 99)),
        })
    }
}

fn service_secs(hours: &[HourOrders]) -> Vec<f64> {
    hours.iter().flat_map(|hour| hour.service_secs.iter().copied()).collect()
}

/// The number of hours from the first to the last one in which an order came.
fn busy_hours(hours: &[HourOrders]) -> Option<f64> {
    let first = hours.iter().position(|hour| hour.released > 0.0)?;
    let last = hours.iter().rposition(|hour| hour.released > 0.0)?;
    Some((last + 1 - first) as f64)
}

impl BacklogAnswer {
    fn new(robots: u32, runs: &[Backlog]) -> Option<Self> {
        let end_secs = runs.iter().map(Backlog::end_secs).fold(0.0, f64::max);
        let fits = |period_secs: &f64| end_secs / period_secs <= MOST_PERIODS;
        let period_secs = PERIODS_SECS.into_iter().find(fits).unwrap_or(HOUR_SECS);
        let periods = (end_secs / period_secs) as usize + 1;
        let by_run: Vec<Vec<u64>> =
            runs.iter().map(|run| run.by_period(period_secs, periods)).collect();
        let mut open = Vec::new();
        for period in 0..periods {
            open.push(spread(&by_run, |run| Some(run[period] as f64))?);
        }
        Some(Self {
            period_secs,
            open,
            largest: spread(runs, |run| Some(run.largest().0 as f64))?,
            largest_at_secs: spread(runs, |run| Some(run.largest().1))?,
            cleared_after_largest_secs: spread(runs, |run| {
                run.cleared_after_largest(robots.into())
            }),
            cleared_after_last_secs: spread(runs, Backlog::cleared_after_last),
        })
    }
}
