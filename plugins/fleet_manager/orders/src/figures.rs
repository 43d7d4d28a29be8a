//! Figures of the pool: how many orders are finished, how long they took and how long they waited.

use std::collections::VecDeque;
use std::fmt::Write as _;

use regatta_base::{grouped, thousands};
use serde::Serialize;

use super::order::{Order, State};

/// The distribution of some durations, in seconds; all 0 if there are none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Durations {
    /// The mean.
    pub mean_secs: f64,
    /// The median: of an even number of durations, the mean of the two in the middle.
    pub median_secs: f64,
    /// The shortest duration that half of all don't exceed.
    pub p50_secs: f64,
    /// That which 99 % of all don't exceed.
    pub p99_secs: f64,
    /// The longest.
    pub longest_secs: f64,
}

/// The time of which [`Figures::recent_orders_per_hour`] tells the rate, in seconds.
pub const RECENT_SECS: f64 = 600.0;
/// The least time that has such a rate, in seconds.
const LEAST_RATE_SECS: f64 = 60.0;

/// The numbers of orders by state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[expect(missing_docs, reason = "the states have these names")]
pub struct ByState {
    pub created: usize,
    pub waiting: usize,
    pub travelling: usize,
    pub handling: usize,
    pub finished: usize,
    pub failed: usize,
    pub cancelled: usize,
    pub unroutable: usize,
    pub unplaced: usize,
}

/// The figures of a run so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Figures {
    /// Simulated seconds since the pool was opened.
    pub secs: f64,
    /// Finished orders an hour of this time.
    pub orders_per_hour: f64,
    /// Finished orders an hour of the last [`RECENT_SECS`], or of the time since the pool was opened
    /// or the warm-up of the run ended if that is shorter: the current rate. `None` in its first
    /// minute.
    #[serde(skip)]
    pub recent_orders_per_hour: Option<f64>,
    /// Finished stops a second of this time.
    pub stops_per_sec: f64,
    /// Finished orders that were late for their deadline.
    pub late: usize,
    /// From when robots could have an order to its end.
    pub service: Durations,
    /// From when robots could have an order to the arrival of its robot at the first stop.
    pub waiting: Durations,
    /// Orders that robots could have, and whose robot is not at the first stop yet. Those that are
    /// unroutable or wait for a place of a storage don't count.
    pub unserved: usize,
    /// The longest wait of these, in seconds.
    pub longest_unserved_secs: f64,
    /// All orders by state.
    pub orders: ByState,
}

/// Counts of closed orders and of their events.
#[derive(Clone, Debug, Default)]
pub(super) struct Counts {
    service_secs: Vec<f32>,
    /// The times at which the orders of the last [`RECENT_SECS`] were finished, ascending.
    recent: VecDeque<f64>,
    /// The time before which finished orders don't count for the current rate, in seconds.
    pub(super) rate_since_secs: f64,
    /// The waits of orders whose robot has come to the first stop.
    pub(super) waiting_secs: Vec<f32>,
    late: usize,
    /// Handled stops.
    pub(super) stops: usize,
    closed: ByState,
}

impl ByState {
    fn add(&mut self, state: State) {
        *match state {
            State::Created => &mut self.created,
            State::Waiting => &mut self.waiting,
            State::Travelling(_) => &mut self.travelling,
            State::Handling(_) => &mut self.handling,
            State::Finished(_) => &mut self.finished,
            State::Failed => &mut self.failed,
            State::Cancelled => &mut self.cancelled,
            State::Unroutable => &mut self.unroutable,
            State::Unplaced => &mut self.unplaced,
        } += 1;
    }
}

impl Counts {
    /// Counts an order whose state is final.
    pub(super) fn closed(&mut self, order: &Order, now_secs: f64) {
        self.closed.add(order.state);
        if let State::Finished(_) = order.state {
            self.service_secs.push((now_secs - order.ready_secs()) as f32);
            self.recent.push_back(now_secs);
            while self.recent.front().is_some_and(|secs| *secs <= now_secs - RECENT_SECS) {
                self.recent.pop_front();
            }
            let deadline_secs = order.content.deadline_secs;
            self.late += usize::from(deadline_secs.is_some_and(|deadline| deadline < now_secs));
        }
    }

    /// Returns the figures with the open orders.
    pub(super) fn figures<'pool>(
        &self,
        open: impl Iterator<Item = &'pool Order>,
        secs: f64,
        now_secs: f64,
    ) -> Figures {
        let mut orders = self.closed;
        let (mut unserved, mut longest_unserved_secs) = (0, 0.0_f64);
        for order in open {
            orders.add(order.state);
            if is_unserved(order) {
                unserved += 1;
                longest_unserved_secs = longest_unserved_secs.max(now_secs - order.ready_secs());
            }
        }
        Figures {
            secs,
            orders_per_hour: per_sec(orders.finished, secs) * 3600.0,
            recent_orders_per_hour: self.recent_per_hour(secs, now_secs),
            stops_per_sec: per_sec(self.stops, secs),
            late: self.late,
            service: Durations::of(&self.service_secs),
            waiting: Durations::of(&self.waiting_secs),
            unserved,
            longest_unserved_secs,
            orders,
        }
    }

    /// The rate of the last [`RECENT_SECS`]; `secs` is the time since the pool was opened.
    fn recent_per_hour(&self, secs: f64, now_secs: f64) -> Option<f64> {
        let secs = secs.min(now_secs - self.rate_since_secs).min(RECENT_SECS);
        let before = self.recent.partition_point(|at| *at <= now_secs - secs);
        (secs >= LEAST_RATE_SECS).then(|| per_sec(self.recent.len() - before, secs) * 3600.0)
    }
}

fn per_sec(count: usize, secs: f64) -> f64 {
    if secs > 0.0 { count as f64 / secs } else { 0.0 }
}

fn is_unserved(order: &Order) -> bool {
    let has_begun = order.is_bound() || matches!(order.state, State::Handling(_));
    !has_begun && !matches!(order.state, State::Created | State::Unroutable | State::Unplaced)
}

impl Durations {
    fn of(secs: &[f32]) -> Self {
        let mut sorted = secs.to_vec();
        sorted.sort_by(f32::total_cmp);
        let Some(longest) = sorted.last() else { return Self::default() };
        // The smallest value that so many hundredths of all values don't exceed.
        let [p50_secs, p99_secs] = [50, 99].map(|hundredths| {
            f64::from(sorted[(sorted.len() * hundredths).div_ceil(100).max(1) - 1])
        });
        let middle = [(sorted.len() - 1) / 2, sorted.len() / 2].map(|at| f64::from(sorted[at]));
        let median_secs = f64::midpoint(middle[0], middle[1]);
        let mean_secs =
            sorted.iter().map(|secs| f64::from(*secs)).sum::<f64>() / sorted.len() as f64;
        Self { mean_secs, median_secs, p50_secs, p99_secs, longest_secs: f64::from(*longest) }
    }

    /// The times as a line of a table; `None` without any.
    fn line(&self, name: &str) -> Option<String> {
        let Self { mean_secs, median_secs, p99_secs, longest_secs, .. } = self;
        (*longest_secs > 0.0).then(|| {
            format!(
                "{name:<13} median {median_secs:.1} s, 99th percentile {p99_secs:.1} s, longest \
                 {longest_secs:.1} s, mean {mean_secs:.1} s\n"
            )
        })
    }
}

impl Figures {
    /// The figures as JSON.
    pub fn json(&self) -> serde_json::Value {
        serde_json::to_value(self).unwrap_or_default()
    }

    /// The figures as lines of a name and its values, for people.
    pub fn table(&self) -> String {
        let ByState { finished, failed, cancelled, unroutable, unplaced, .. } = self.orders;
        let mut orders = format!(
            "{} finished ({} an hour)",
            thousands(finished as u64),
            grouped(self.orders_per_hour, 0)
        );
        if self.unserved > 0 {
            let (count, secs) = (thousands(self.unserved as u64), self.longest_unserved_secs);
            let _ = write!(orders, ", {count} not begun (for {} s at most)", grouped(secs, 0));
        }
        for (count, word) in [
            (self.late, "late"),
            (failed, "failed"),
            (cancelled, "cancelled"),
            (unroutable, "unroutable"),
            (unplaced, "waiting for a storage place"),
        ] {
            if count > 0 {
                let _ = write!(orders, ", {} {word}", thousands(count as u64));
            }
        }
        let lines = [self.waiting.line("response time"), self.service.line("service time")];
        format!("{:<13} {orders}\n{}", "orders", lines.into_iter().flatten().collect::<String>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_tells_only_what_there_is() {
        let orders = ByState { finished: 12, ..ByState::default() };
        let figures = Figures { orders, orders_per_hour: 24.0, ..Figures::default() };
        assert_eq!(figures.table(), "orders        12 finished (24 an hour)\n");
        let many = Figures { orders_per_hour: 10_900.4, unserved: 2_000, ..figures };
        let line =
            "orders        12 finished (10,900 an hour), 2,000 not begun (for 0 s at most)\n";
        assert_eq!(many.table(), line);
        let late = Figures { late: 2, service: Durations::of(&[4.0, 8.0]), ..figures };
        assert_eq!(
            late.table(),
            "orders        12 finished (24 an hour), 2 late\nservice time  median 6.0 s, 99th \
             percentile 8.0 s, longest 8.0 s, mean 6.0 s\n"
        );
    }

    #[test]
    fn percentiles_are_values_that_occurred() {
        let secs: Vec<_> = (1..=200).rev().map(|secs| secs as f32).collect();
        let durations = Durations::of(&secs);
        let expected = Durations {
            mean_secs: 100.5,
            median_secs: 100.5,
            p50_secs: 100.0,
            p99_secs: 198.0,
            longest_secs: 200.0,
        };
        assert_eq!((durations, Durations::of(&[])), (expected, Durations::default()));
        assert_eq!((Durations::of(&[4.0]).p50_secs, Durations::of(&[4.0]).median_secs), (4.0, 4.0));
        assert_eq!(Durations::of(&[9.0, 1.0, 2.0]).median_secs, 2.0);
    }
}
