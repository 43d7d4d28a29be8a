//! The tally of transport orders, from a fleet manager's order log.

use std::collections::{BTreeMap, VecDeque};

use regatta_plugin::Orders;
use regatta_plugin::order::{OrderKind, OrderRecord};

use crate::aggregator::RunClock;
use crate::durations::TimeRecorder;
use crate::snapshot::OrderFigures;

/// The largest number of open orders that are tracked. Further ones are only counted when they are
/// created and when they end.
const MAX_OPEN: usize = 1 << 20;

/// The length of a minute, in seconds.
const MINUTE: f64 = 60.0;

/// The number of minutes over which finished orders are counted for their rate, the present one
/// included.
const RATE_MINUTES: u64 = 60;

/// The orders of one run since this reader began to read its order log.
#[derive(Clone, Debug, Default)]
pub struct OrderTally {
    run_id: u64,
    first_tick: u64,
    newest_tick: u64,
    /// Whether the first sample was the first of the run.
    is_from_start: bool,
    open: BTreeMap<u64, OpenOrder>,
    /// Counts and gaps; the other figures are computed on request.
    figures: OrderFigures,
    service: TimeRecorder,
    waiting: TimeRecorder,
    /// Minutes of simulated time, and the number of orders that were finished in each.
    finished_by_minute: VecDeque<(u64, u64)>,
}

/// An order that is not over.
#[derive(Clone, Copy, Debug)]
struct OpenOrder {
    /// Simulated time at which it was created, in seconds; `None` if that was before this reader
    /// began.
    created_secs: Option<f64>,
    was_assigned: bool,
}

impl OrderTally {
    /// Adds the records of a tick, which takes `tick_secs` seconds of simulated time.
    ///
    /// The tally restarts with another run, and with a tick before the last one: then a replay was
    /// wound back.
    pub fn add(&mut self, orders: &Orders<'_>, tick_secs: f64) {
        let (run_id, tick) = (orders.header.run_id, orders.header.tick);
        if run_id != self.run_id || tick < self.newest_tick {
            let is_from_start = orders.header.sequence == 1;
            *self = Self { run_id, first_tick: tick, is_from_start, ..Self::default() };
        }
        self.newest_tick = tick;
        self.figures.gaps += orders.missed + u64::from(orders.header.dropped > 0);
        for record in orders.records {
            self.add_record(record, tick as f64 * tick_secs);
        }
    }

    /// Returns the figures at a time; those of no order if the clock belongs to another run.
    pub fn figures(&self, clock: &RunClock) -> OrderFigures {
        if clock.run_id != self.run_id {
            return OrderFigures::default();
        }
        OrderFigures {
            open: (self.is_from_start && self.figures.gaps == 0).then_some(self.open.len() as u64),
            finished_per_second: self.finished_per_second(clock),
            service: self.service.summary(),
            waiting: self.waiting.summary(),
            since_secs: (!self.is_from_start).then_some(self.first_tick as f64 * clock.tick_secs),
            ..self.figures
        }
    }

    fn add_record(&mut self, record: &OrderRecord, now_secs: f64) {
        // Unknown kinds are those of a later contract.
        let Some(kind) = record.kind() else { return };
        match kind {
            OrderKind::Created => {
                self.figures.created += 1;
                self.open_order(record.order, Some(now_secs));
            }
            OrderKind::Assigned => self.assign(record.order, now_secs),
            OrderKind::Finished => self.finish(record.order, now_secs),
            OrderKind::Failed => {
                self.figures.failed += 1;
                self.open.remove(&record.order);
            }
            OrderKind::Cancelled => {
                self.figures.cancelled += 1;
                self.open.remove(&record.order);
            }
            OrderKind::Stop
            | OrderKind::Withdrawn
            | OrderKind::Arrived
            | OrderKind::Handled
            | OrderKind::Unroutable
            | OrderKind::Queued
            | OrderKind::Reopened => {
                self.open_order(record.order, None);
            }
        }
    }

    /// Returns an order that is not over; `None` if there are too many.
    fn open_order(&mut self, order: u64, created_secs: Option<f64>) -> Option<&mut OpenOrder> {
        if self.open.len() >= MAX_OPEN {
            return self.open.get_mut(&order);
        }
        Some(self.open.entry(order).or_insert(OpenOrder { created_secs, was_assigned: false }))
    }

    fn assign(&mut self, order: u64, now_secs: f64) {
        let Some(open) = self.open_order(order, None) else { return };
        let is_first = !std::mem::replace(&mut open.was_assigned, true);
        if let Some(created_secs) = open.created_secs.filter(|_| is_first) {
            self.waiting.observe(now_secs - created_secs);
        }
    }

    fn finish(&mut self, order: u64, now_secs: f64) {
        self.figures.finished += 1;
        if let Some(created_secs) = self.open.remove(&order).and_then(|open| open.created_secs) {
            self.service.observe(now_secs - created_secs);
        }
        let minute = (now_secs / MINUTE) as u64;
        match self.finished_by_minute.back_mut() {
            Some((last, count)) if *last == minute => *count += 1,
            _ => self.finished_by_minute.push_back((minute, 1)),
        }
        self.finished_by_minute.retain(|(first, _)| first + RATE_MINUTES > minute);
    }

    fn finished_per_second(&self, clock: &RunClock) -> Option<f64> {
        // The log may be ahead of the newest frame that was read.
        let now_secs = clock.tick.max(self.newest_tick) as f64 * clock.tick_secs;
        let first_minute = ((now_secs / MINUTE) as u64).saturating_sub(RATE_MINUTES - 1);
        let counted = self.finished_by_minute.iter().filter(|(minute, _)| *minute >= first_minute);
        let begin_secs =
            (self.first_tick as f64 * clock.tick_secs).max(first_minute as f64 * MINUTE);
        let secs = now_secs - begin_secs;
        (secs >= MINUTE).then(|| counted.map(|(_, count)| *count).sum::<u64>() as f64 / secs)
    }
}

#[cfg(test)]
mod tests;
