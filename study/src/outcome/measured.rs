//! The figures that a study takes from an outcome.

use std::collections::BTreeMap;

use regatta_meter::Figures;
use regatta_meter::meter::Effort;
use regatta_meter::orders::{Finished, Unplaced};
use serde::{Deserialize, Serialize};

use super::backlog::Backlog;
use super::survival::Survival;
use super::time_split::{ORDER_PARTS, ROBOT_PARTS, of_orders, of_robots};
use super::{Example, Outcome, Stall};
use crate::job::Ending;
use crate::statistics::{percentile, warm_up};

/// The end of what a run measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RunEnd {
    /// The time of the run: its orders have no end.
    AtTime,
    /// The end of the last order of a day.
    Done,
    /// The limit of a day's time: orders were open, or had been given up.
    Overdue,
}

/// The times from the creation of orders to their ends, in seconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Service {
    /// The mean.
    pub mean_secs: f64,
    /// The 50th percentile.
    pub p50_secs: f64,
    /// The 90th percentile.
    pub p90_secs: f64,
    /// The 95th percentile.
    pub p95_secs: f64,
    /// The 99th percentile.
    pub p99_secs: f64,
    /// The longest.
    pub longest_secs: f64,
}

/// The figures of a run after its warm-up, or of a whole day.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// The engine's digest.
    pub digest: String,
    /// The end of the run.
    pub end: RunEnd,
    /// Simulated seconds that were cut off at the beginning (MSER-5); 0 for a day.
    pub warm_up_secs: f64,
    /// Simulated seconds after that.
    pub secs: f64,
    /// Finished orders an hour.
    pub orders_per_hour: f64,
    /// Finished stops an hour.
    pub stops_per_hour: f64,
    /// The times from the creation of orders to their ends: of those that were finished after the
    /// warm-up, or of all of a day; orders that are open at the end count with their time so far.
    pub service: Option<Service>,
    /// The part of the orders with a deadline that were finished after it, or are open although it
    /// is over; `None` if none has a deadline.
    pub late: Option<f64>,
    /// The part of the robots' time with an order, from 0 to 1.
    pub utilisation: f64,
    /// The part of the robots' time in which they stood and waited for room, from 0 to 1.
    pub waiting: f64,
    /// The part of the way that was driven without a load, from 0 to 1; `None` if no robot had one.
    pub empty: Option<f64>,
    /// The mean parts of an order's time, in seconds
    /// ([`ORDER_PARTS`]); of finished orders.
    pub order_time: Option<[f64; ORDER_PARTS.len()]>,
    /// The parts of the robots' time ([`ROBOT_PARTS`]), each from 0 to 1.
    pub robot_time: Option<[f64; ROBOT_PARTS.len()]>,
    /// Contacts that the validator found.
    pub contacts: u64,
    /// Times in which robots with orders made no progress.
    pub stalls: Vec<Stall>,
    /// Orders that waited for a long time, for a robot or with one.
    pub unserved: u64,
    /// The validator's other findings, by kind.
    pub other_findings: BTreeMap<String, u64>,
    /// The first finding of each kind.
    pub examples: BTreeMap<String, Example>,
    /// Orders that were finished in the whole run, the warm-up included.
    pub finished_orders: u64,
    /// Orders that the manager gave up.
    pub failed_orders: u64,
    /// Orders that weren't over at the end.
    pub open_orders: u64,
    /// Those that wait for a place of a storage, by storage.
    #[serde(default)]
    pub unplaced: Vec<Unplaced>,
    /// Those of them that no robot of the fleet can carry out.
    #[serde(default)]
    pub unroutable_orders: u64,
    /// The growth of the backlog in half of the time after the warm-up, in orders
    /// ([`Backlog::growth`]).
    #[serde(default)]
    pub backlog_growth: f64,
}

/// The validator's name for a contact.
pub(crate) const CONTACT: &str = "contact";
/// Its name for an order that waited for a long time.
const UNSERVED: &str = "unserved";
/// Its names for findings that are counted as stalls.
const STALLS: [&str; 3] = ["standstill", "livelock", "stuck"];

impl Measured {
    /// Whether robots with orders made no progress for a long time, so that the figures aren't
    /// those of traffic.
    pub fn is_stalled(&self) -> bool {
        !self.stalls.is_empty()
    }

    /// The orders that weren't over at the end, without those that can't be carried.
    pub fn carriable_orders(&self) -> f64 {
        let unplaced: u64 = self.unplaced.iter().map(|unplaced| unplaced.orders).sum();
        self.open_orders.saturating_sub(unplaced + self.unroutable_orders) as f64
    }
}

impl Outcome {
    /// Returns the figures of the run: those after the warm-up, whose end the series of finished
    /// orders determines, or those of all of a day.
    pub fn measured(&self) -> Measured {
        let span = match self.ending {
            Ending::AtTime => self.span_after_warm_up(),
            Ending::AfterOrders => self.span_of_day(),
        };
        let orders = self.orders_of(span);
        let hours = (span.to_secs - span.from_secs) / 3600.0;
        let effort = self.effort_of(span);
        let metres = effort.loaded_metres + effort.empty_metres;
        let (contacts, unserved) = (self.count(CONTACT), self.count(UNSERVED));
        let Figures { finished, failed, open, unfinished, .. } = &self.figures;
        let backlog = Backlog::of(&self.figures);
        Measured {
            digest: self.digest.clone(),
            end: self.end(),
            warm_up_secs: span.from_secs,
            secs: span.to_secs - span.from_secs,
            orders_per_hour: ratio(orders.finished, hours),
            stops_per_hour: ratio(orders.stops, hours),
            service: Service::with_open(&orders.service, &orders.service_so_far),
            late: (orders.due > 0.0).then(|| orders.late / orders.due),
            utilisation: ratio(effort.ordered_secs, effort.robot_secs),
            waiting: ratio(effort.waiting_secs, effort.robot_secs),
            empty: (effort.loaded_metres > 0.0).then(|| effort.empty_metres / metres),
            order_time: of_orders(self.finished_in(span), self.figures.tick_secs),
            robot_time: of_robots(&effort),
            contacts,
            stalls: self.stalls.clone(),
            unserved,
            other_findings: self.other_findings(),
            examples: self.examples.clone(),
            finished_orders: finished.len() as u64,
            failed_orders: *failed,
            open_orders: *open,
            unplaced: self.figures.unplaced.clone(),
            unroutable_orders: unfinished.iter().filter(|open| open.is_unroutable).count() as u64,
            backlog_growth: backlog
                .map_or(0.0, |backlog| backlog.growth(span.from_secs, span.to_secs)),
        }
    }

    /// The end of the run.
    fn end(&self) -> RunEnd {
        match self.ending {
            Ending::AtTime => RunEnd::AtTime,
            Ending::AfterOrders if self.figures.open + self.figures.failed == 0 => RunEnd::Done,
            Ending::AfterOrders => RunEnd::Overdue,
        }
    }

    /// The findings that aren't counted otherwise.
    fn other_findings(&self) -> BTreeMap<String, u64> {
        let mut findings = self.findings.clone();
        findings.retain(|kind, _| {
            kind != CONTACT && kind != UNSERVED && !STALLS.contains(&kind.as_str())
        });
        findings
    }

    /// The time after the warm-up, in whole periods: one that isn't over would look like a slow
    /// one.
    fn span_after_warm_up(&self) -> Span {
        let Figures { secs, period_secs, finished, .. } = &self.figures;
        let periods = (secs / period_secs).floor() as usize;
        let mut series = vec![0.0; periods];
        for order in finished {
            // The orders of an instant between two periods belong to the first one, as in the
            // meter.
            let period = ((order.at_secs / period_secs).ceil() as usize).saturating_sub(1);
            if let Some(count) = series.get_mut(period) {
                *count += 1.0;
            }
        }
        let from_secs = warm_up(&series) as f64 * period_secs;
        Span { from_secs, to_secs: periods as f64 * period_secs }
    }

    /// The time from the beginning of a day to the end of its last order, or to the end of the run
    /// if orders are open then.
    fn span_of_day(&self) -> Span {
        let last = self.figures.finished.last().map_or(self.figures.secs, |order| order.at_secs);
        let is_over = self.end() == RunEnd::Done;
        Span { from_secs: 0.0, to_secs: if is_over { last } else { self.figures.secs } }
    }

    /// The effort of the periods that begin in a span.
    fn effort_of(&self, span: Span) -> Effort {
        let Figures { period_secs, effort, .. } = &self.figures;
        let [from, to] = [span.from_secs, span.to_secs].map(|secs| (secs / period_secs).ceil());
        sum(effort.get(from as usize..(to as usize).min(effort.len())).unwrap_or_default())
    }

    fn finished_in(&self, span: Span) -> impl Iterator<Item = &Finished> {
        let finished = self.figures.finished.iter();
        finished
            .filter(move |order| order.at_secs > span.from_secs && order.at_secs <= span.to_secs)
    }

    /// The orders that were finished in a span. Those that aren't over at the end count, too, with
    /// their time so far. A deadline that isn't over then counts only at the end of a day.
    fn orders_of(&self, span: Span) -> OrdersOfSpan {
        let mut orders = OrdersOfSpan::default();
        for order in self.finished_in(span) {
            orders.service.push(order.service_secs);
            orders.finished += 1.0;
            orders.stops += f64::from(order.stops);
            orders.count_deadline(order.is_late());
        }
        for order in &self.figures.unfinished {
            orders.service_so_far.push(order.age_secs);
            let is_late = order.is_late();
            if is_late == Some(true) || self.ending == Ending::AfterOrders {
                orders.count_deadline(is_late);
            }
        }
        // No figure of a day is less than what was seen.
        if self.ending == Ending::AfterOrders {
            orders.service.append(&mut orders.service_so_far);
        }
        orders
    }
}

/// A part of a run, in simulated seconds.
#[derive(Clone, Copy, Debug)]
struct Span {
    from_secs: f64,
    to_secs: f64,
}

/// The orders of a part of a run.
#[derive(Default)]
struct OrdersOfSpan {
    /// From creation to end, in seconds.
    service: Vec<f64>,
    /// From the creation of those that aren't over to the end of the run, in seconds.
    service_so_far: Vec<f64>,
    finished: f64,
    stops: f64,
    /// Orders with a deadline, and those of them that were late.
    due: f64,
    late: f64,
}

impl OrdersOfSpan {
    fn count_deadline(&mut self, is_late: Option<bool>) {
        self.due += if is_late.is_some() { 1.0 } else { 0.0 };
        self.late += if is_late == Some(true) { 1.0 } else { 0.0 };
    }
}

impl Service {
    /// Returns the statistics of some times.
    pub(crate) fn of(secs: &[f64]) -> Option<Self> {
        Some(Self {
            mean_secs: secs.iter().sum::<f64>() / secs.len() as f64,
            p50_secs: percentile(secs, 50)?,
            p90_secs: percentile(secs, 90)?,
            p95_secs: percentile(secs, 95)?,
            p99_secs: percentile(secs, 99)?,
            longest_secs: percentile(secs, 100)?,
        })
    }

    /// Returns the statistics of some times, and of others that aren't over.
    fn with_open(secs: &[f64], so_far: &[f64]) -> Option<Self> {
        if so_far.is_empty() || secs.is_empty() {
            return Self::of(secs);
        }
        let survival = Survival::of(secs, so_far)?;
        Some(Self {
            mean_secs: survival.mean(),
            p50_secs: survival.percentile(50),
            p90_secs: survival.percentile(90),
            p95_secs: survival.percentile(95),
            p99_secs: survival.percentile(99),
            longest_secs: survival.percentile(100),
        })
    }
}

fn ratio(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole } else { 0.0 }
}

fn sum(periods: &[Effort]) -> Effort {
    let mut sum = Effort::default();
    for effort in periods {
        sum.add(effort);
    }
    sum
}

#[cfg(test)]
mod tests {
    use regatta_meter::orders::Unfinished;
    use regatta_meter::time::Parts;

    use super::*;

    /// An outcome whose first 200 s carry nothing and whose other 800 s finish an order every 2 s.
    fn outcome() -> Outcome {
        let finished = (101..=500).map(|index| Finished {
            at_secs: f64::from(index) * 2.0,
            service_secs: f64::from(index % 100),
            stops: 2,
            due_secs: Some(49.5),
            parts: Parts { empty: 30, handling: 10, ..Parts::default() },
            ends: [1, 2],
        });
        let effort = Effort {
            robot_secs: 40.0,
            ordered_secs: 30.0,
            waiting_secs: 10.0,
            empty_secs: 20.0,
            idle_secs: 10.0,
            loaded_metres: 6.0,
            empty_metres: 2.0,
            ..Effort::default()
        };
        let figures = Figures {
            secs: 1000.0,
            period_secs: 10.0,
            tick_secs: 0.5,
            effort: vec![effort; 100],
            finished: finished.collect(),
            ..Figures::default()
        };
        let findings = BTreeMap::from([("contact".to_owned(), 2), ("idle".to_owned(), 1)]);
        let job = serde_json::from_str("\"00\"").expect("an id");
        Outcome {
            job,
            digest: "d".to_owned(),
            figures,
            findings,
            examples: BTreeMap::new(),
            stalls: Vec::new(),
            edges: Vec::new(),
            ending: Ending::AtTime,
        }
    }

    #[test]
    fn figures_begin_after_the_warm_up() {
        let measured = outcome().measured();
        assert_eq!((measured.warm_up_secs, measured.secs), (200.0, 800.0));
        assert_eq!((measured.orders_per_hour, measured.stops_per_hour), (1800.0, 3600.0));
        let service = measured.service.expect("orders");
        assert_eq!((service.p50_secs, service.p99_secs, service.longest_secs), (49.0, 98.0, 99.0));
        assert_eq!(measured.order_time, Some([0.0, 15.0, 0.0, 0.0, 0.0, 5.0, 0.0, 0.0]));
        let robots = measured.robot_time.expect("robots");
        assert_eq!((robots[0], robots[2], robots[8]), (0.5, 0.25, 0.25));
        assert_eq!((measured.late, measured.end), (Some(0.5), RunEnd::AtTime));
        assert_eq!(
            (measured.utilisation, measured.waiting, measured.empty),
            (0.75, 0.25, Some(0.25))
        );
        assert_eq!(measured.contacts, 2);
        assert_eq!(measured.other_findings, BTreeMap::from([("idle".to_owned(), 1)]));
    }

    /// Half of the orders are never carried: their deadlines are over, and their times so far are
    /// the longest.
    #[test]
    fn open_orders_count_in_a_run_that_ends_at_its_time() {
        let open = Unfinished { age_secs: 900.0, due_secs: Some(60.0), is_unroutable: true };
        let young = Unfinished { age_secs: 50.0, ..open };
        let unfinished = [[open; 400], [young; 400]].concat();
        let figures = Figures { unfinished, ..outcome().figures };
        let measured = Outcome { figures, ..outcome() }.measured();
        assert_eq!(measured.late, Some(600.0 / 800.0), "young ones have some time left");
        let service = measured.service.expect("orders");
        // Four in nine are known to take less than 100 s.
        assert_eq!((service.p50_secs, service.p90_secs), (900.0, 900.0));
        assert_eq!((measured.unroutable_orders, measured.backlog_growth), (800, 0.0));
    }

    #[test]
    fn a_run_without_orders_has_figures() {
        let figures = Figures { secs: 4.0, period_secs: 10.0, ..Figures::default() };
        let measured = Outcome { figures, ..outcome() }.measured();
        assert_eq!((measured.orders_per_hour, measured.service, measured.empty), (0.0, None, None));
    }

    #[test]
    fn a_day_has_no_warm_up_and_ends_with_its_last_order() {
        let day = |open: u64| {
            let outcome = outcome();
            let finished = outcome.figures.finished[..50].to_vec();
            let unfinished =
                vec![Unfinished { age_secs: 700.0, due_secs: Some(60.0), is_unroutable: false }];
            let unfinished = unfinished.into_iter().take(open as usize).collect();
            let figures = Figures { finished, open, unfinished, ..outcome.figures };
            Outcome { figures, ending: Ending::AfterOrders, ..outcome }.measured()
        };
        let done = day(0);
        assert_eq!((done.end, done.warm_up_secs, done.secs), (RunEnd::Done, 0.0, 300.0));
        assert_eq!((done.orders_per_hour, done.utilisation), (600.0, 0.75));
        let overdue = day(1);
        assert_eq!((overdue.end, overdue.secs), (RunEnd::Overdue, 1000.0));
        assert_eq!(overdue.service.map(|service| service.longest_secs), Some(700.0));
        assert_eq!((done.late, overdue.late), (Some(0.02), Some(2.0 / 51.0)));
    }
}
