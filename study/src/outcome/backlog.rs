//! The orders of a run by hour, and those that are open at each moment: exact, from the order log.

use regatta_meter::Figures;
use regatta_meter::orders::{Finished, Unfinished};

use super::Service;

/// Seconds of an hour.
pub const HOUR_SECS: f64 = 3600.0;

/// The orders of an hour of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HourOrders {
    /// Orders that came.
    pub released: f64,
    /// Orders whose deadline was then.
    pub due: f64,
    /// Orders that were finished.
    pub carried: f64,
    /// The times of those that came, in seconds; of those that weren't finished, so far.
    pub service_secs: Vec<f64>,
}

impl HourOrders {
    /// The statistics of the times of the orders that came.
    pub fn service(&self) -> Option<Service> {
        Service::of(&self.service_secs)
    }
}

/// An order of a run, finished or not.
#[derive(Clone, Copy, Debug)]
struct Timed {
    created_secs: f64,
    /// The end; `None` if it wasn't over at the end of the run.
    end_secs: Option<f64>,
    /// The time from its creation to its end, or to the end of the run.
    service_secs: f64,
    due_secs: Option<f64>,
}

/// The orders of a run without those that were given up or cancelled.
fn orders(figures: &Figures) -> impl Iterator<Item = Timed> {
    let finished = figures.finished.iter().map(|order| Timed {
        created_secs: created_secs(order, figures.tick_secs),
        end_secs: Some(order.at_secs),
        service_secs: order.service_secs,
        due_secs: order.due_secs,
    });
    let unfinished = figures.unfinished.iter().map(|Unfinished { age_secs, due_secs, .. }| Timed {
        created_secs: at_tick(figures.secs - age_secs, figures.tick_secs),
        end_secs: None,
        service_secs: *age_secs,
        due_secs: *due_secs,
    });
    finished.chain(unfinished)
}

/// The time at which a finished order was created.
pub fn created_secs(order: &Finished, tick_secs: f64) -> f64 {
    at_tick(order.at_secs - order.service_secs, tick_secs)
}

/// Rounds a time to its tick, and then to milliseconds, as the meter does: a difference of rounded
/// times may lie just before the tick, and so in another hour.
fn at_tick(secs: f64, tick_secs: f64) -> f64 {
    let secs = if tick_secs > 0.0 { (secs / tick_secs).round() * tick_secs } else { secs };
    (secs * 1e3).round() / 1e3
}

/// Returns the orders of each hour of a run, from its beginning to the end of its last order.
pub fn hours(figures: &Figures) -> Vec<HourOrders> {
    let ends = orders(figures).map(|order| order.end_secs.unwrap_or(figures.secs));
    let Some(last) = ends.map(hour_of).max() else { return Vec::new() };
    let mut hours = vec![HourOrders::default(); last + 1];
    for order in orders(figures) {
        let created = hour_of(order.created_secs).min(last);
        hours[created].released += 1.0;
        hours[created].service_secs.push(order.service_secs);
        if let Some(end_secs) = order.end_secs {
            hours[hour_of(end_secs)].carried += 1.0;
        }
        // A deadline after the end of the last order is in no hour.
        let due = order.due_secs.map(|due_secs| hour_of(order.created_secs + due_secs));
        if let Some(hour) = due.and_then(|due| hours.get_mut(due)) {
            hour.due += 1.0;
        }
    }
    hours
}

fn hour_of(secs: f64) -> usize {
    (secs / HOUR_SECS) as usize
}

/// The number of open orders over a run: released, and not finished.
#[derive(Clone, Debug, PartialEq)]
pub struct Backlog {
    /// The times at which the number changes, in ascending order, with the number from then on.
    steps: Vec<(f64, u64)>,
    /// The time at which the last order came.
    last_release_secs: f64,
}

impl Backlog {
    /// Returns the backlog of a run; `None` if no order came.
    pub fn of(figures: &Figures) -> Option<Self> {
        let mut changes: Vec<(f64, i64)> = Vec::new();
        let mut last_release_secs = f64::NEG_INFINITY;
        for order in orders(figures) {
            changes.push((order.created_secs, 1));
            changes.extend(order.end_secs.map(|secs| (secs, -1)));
            last_release_secs = last_release_secs.max(order.created_secs);
        }
        changes.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        let (mut steps, mut open): (Vec<(f64, u64)>, i64) = (Vec::new(), 0);
        for (secs, change) in changes {
            open += change;
            let number = open.max(0) as u64;
            match steps.last_mut() {
                Some(last) if last.0 == secs => last.1 = number,
                _ => steps.push((secs, number)),
            }
        }
        (!steps.is_empty()).then_some(Self { steps, last_release_secs })
    }

    /// Returns the largest number of open orders, and the first time at which so many are open.
    pub fn largest(&self) -> (u64, f64) {
        let mut largest = (0, 0.0);
        for (secs, open) in &self.steps {
            if *open > largest.0 {
                largest = (*open, *secs);
            }
        }
        largest
    }

    /// Returns the seconds from the largest backlog until at most so many orders are open; `None`
    /// if that doesn't come about.
    pub fn cleared_after_largest(&self, open: u64) -> Option<f64> {
        let (largest, at_secs) = self.largest();
        if largest <= open {
            return Some(0.0);
        }
        self.cleared_after(at_secs, open)
    }

    /// Returns the seconds from the arrival of the last order until none is open; `None` if that
    /// doesn't come about.
    pub fn cleared_after_last(&self) -> Option<f64> {
        self.cleared_after(self.last_release_secs, 0)
    }

    /// Returns by how many orders the backlog has grown in half of a time: the least number of open
    /// orders in its fourth quarter, less that in its second one. Orders that come in batches, and
    /// those that robots have just been given, don't change the least number (that of a standing
    /// queue: K. Nichols, V. Jacobson: Controlling queue delay, ACM Queue 10, 2012).
    pub fn growth(&self, from_secs: f64, to_secs: f64) -> f64 {
        let quarter_secs = (to_secs - from_secs) / 4.0;
        let before = self.least(from_secs + quarter_secs, from_secs + 2.0 * quarter_secs);
        let after = self.least(to_secs - quarter_secs, to_secs);
        after as f64 - before as f64
    }

    /// Returns the least number of open orders in a time.
    fn least(&self, from_secs: f64, to_secs: f64) -> u64 {
        let mut least = None;
        for (secs, open) in self.steps.iter().rev().skip_while(|(secs, _)| *secs > to_secs) {
            least = Some(least.map_or(*open, |least: u64| least.min(*open)));
            if *secs <= from_secs {
                return least.unwrap_or(0);
            }
        }
        0
    }

    fn cleared_after(&self, from_secs: f64, most: u64) -> Option<f64> {
        let mut later = self.steps.iter().filter(|(secs, _)| *secs >= from_secs);
        later.find(|(_, open)| *open <= most).map(|(secs, _)| secs - from_secs)
    }

    /// Returns the largest number of orders that are open at once in each of some periods.
    pub fn by_period(&self, period_secs: f64, periods: usize) -> Vec<u64> {
        let mut largest = vec![0; periods];
        let mut steps = self.steps.iter().peekable();
        let mut open = 0;
        for (most, index) in largest.iter_mut().zip(1..) {
            *most = open;
            let end_secs = f64::from(index) * period_secs;
            while let Some((_, number)) = steps.next_if(|(secs, _)| *secs < end_secs) {
                open = *number;
                *most = open.max(*most);
            }
        }
        largest
    }

    /// The time of the last change.
    pub fn end_secs(&self) -> f64 {
        self.steps.last().map_or(0.0, |(secs, _)| *secs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finished(created_secs: f64, at_secs: f64, due_secs: Option<f64>) -> Finished {
        let service_secs = ((at_secs - created_secs) * 1e3).round() / 1e3;
        Finished { at_secs, service_secs, due_secs, ..Finished::default() }
    }

    /// Four orders at once, of which two are finished in the first hour; one an hour later; and one
    /// that isn't finished at the end of the run, after 2 h 30 min.
    fn figures() -> Figures {
        Figures {
            secs: 9000.0,
            tick_secs: 0.1,
            finished: vec![
                finished(600.0, 900.0, Some(600.0)),
                finished(600.0, 1200.0, Some(3000.0)),
                finished(600.0, 3600.0, None),
                finished(600.0, 4000.0, None),
                finished(3600.0, 3700.123, Some(8000.0)),
            ],
            unfinished: vec![Unfinished {
                age_secs: 5400.0,
                due_secs: Some(1.0),
                is_unroutable: false,
            }],
            ..Figures::default()
        }
    }

    #[test]
    fn the_orders_by_hour_are_those_of_the_case_by_hand() {
        let hours = hours(&figures());
        let rows: Vec<[f64; 3]> =
            hours.iter().map(|hour| [hour.released, hour.due, hour.carried]).collect();
        // The deadlines are at 1200, 3600, 11,600 and 3601 s; the last but one is after the end.
        assert_eq!(rows, [[4.0, 1.0, 2.0], [2.0, 2.0, 3.0], [0.0; 3]]);
        let service = hours[0].service().expect("orders");
        assert_eq!((service.p50_secs, service.p99_secs), (600.0, 3400.0));
        let service = hours[1].service().expect("orders");
        assert_eq!((service.p50_secs, service.longest_secs), (100.123, 5400.0));
        assert_eq!(hours[2].service(), None);
    }

    #[test]
    fn the_backlog_is_that_of_the_case_by_hand() {
        let mut figures = figures();
        let backlog = Backlog::of(&figures).expect("orders");
        // At 3600 s, one is finished and two come.
        let steps = [(600.0, 4), (900.0, 3), (1200.0, 2), (3600.0, 3), (3700.123, 2), (4000.0, 1)];
        assert_eq!(backlog.steps, steps);
        assert_eq!(backlog.largest(), (4, 600.0));
        assert_eq!(backlog.cleared_after_largest(4), Some(0.0));
        assert_eq!(backlog.cleared_after_largest(2), Some(600.0));
        assert_eq!(backlog.cleared_after_largest(0), None);
        assert_eq!(backlog.cleared_after_last(), None, "one isn't finished");
        assert_eq!(backlog.by_period(1800.0, 4), [4, 2, 3, 1]);
        figures.unfinished.clear();
        let backlog = Backlog::of(&figures).expect("orders");
        assert_eq!(backlog.cleared_after_last(), Some(400.0));
        assert_eq!(Backlog::of(&Figures::default()), None);
    }

    #[test]
    fn the_growth_is_that_of_the_least_number_of_open_orders() {
        let growth = |from, to| Backlog::of(&figures()).expect("orders").growth(from, to);
        // Second quarter: 600 to 1200 s, 4 to 2 orders; fourth: 1800 to 2400 s, 2.
        assert_eq!(growth(0.0, 2400.0), 0.0);
        // 900 to 1000 s: 3; 1100 to 1200 s: 2.
        assert_eq!(growth(800.0, 1200.0), -1.0);
        // 1800 to 2700 s: 2; 3550 to 3650 s would be 2, too, although 3 are open at the end.
        assert_eq!(growth(900.0, 3650.0), 0.0);
        assert_eq!(growth(0.0, 1000.0), 3.0);
    }

    #[test]
    fn an_order_that_comes_at_the_full_hour_is_in_it() {
        let order = finished(3600.0, 4099.726, None);
        assert!(order.at_secs - order.service_secs < 3600.0, "the case that was wrong");
        assert_eq!(created_secs(&order, 0.1), 3600.0);
    }
}
