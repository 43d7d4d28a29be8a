//! The orders of a run, from the order log.

use std::collections::BTreeMap;

use regatta_plugin::order::{OrderKind, OrderRecord, StopAction};
use serde::{Deserialize, Serialize};

/// A finished order.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finished {
    /// Simulated time at which it was finished, in seconds.
    pub at_secs: f64,
    /// Seconds from its creation to its end.
    pub service_secs: f64,
    /// The number of its stops.
    pub stops: u32,
    /// Seconds from its creation to its deadline, if it has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub due_secs: Option<f64>,
}

impl Finished {
    /// Whether it was finished after its deadline; `None` if it has none.
    pub fn is_late(&self) -> Option<bool> {
        Some(self.service_secs > self.due_secs?)
    }
}

/// An order that isn't over at the end of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Unfinished {
    /// Seconds since its creation.
    pub age_secs: f64,
    /// Seconds from its creation to its deadline, if it has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub due_secs: Option<f64>,
}

impl Unfinished {
    /// Whether its deadline is over; `None` if it has none.
    pub fn is_late(&self) -> Option<bool> {
        Some(self.age_secs > self.due_secs?)
    }
}

/// An order that isn't over.
#[derive(Clone, Copy, Debug)]
struct Open {
    created_secs: f64,
    due_secs: Option<f64>,
    stops: u32,
    robot: Option<u32>,
    /// Loads that were picked and not dropped yet.
    loads: i32,
    /// Whether its robot is at a stop.
    is_at_stop: bool,
}

/// The present work of a robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RobotWork {
    /// The number of its orders.
    pub orders: i32,
    /// The number of loads on it.
    pub loads: i32,
    /// The number of its orders at whose stops it is.
    pub at_stops: i32,
}

/// All orders so far.
#[derive(Clone, Debug, Default)]
pub struct Orders {
    open: BTreeMap<u64, Open>,
    robots: BTreeMap<u32, RobotWork>,
    /// In the order in which they were finished.
    pub finished: Vec<Finished>,
    /// Orders that were given up.
    pub failed: u64,
    /// Orders that were cancelled.
    pub cancelled: u64,
}

impl Orders {
    /// Takes a record of a tick at a simulated time in seconds. Records of unknown orders and kinds
    /// are left out.
    pub fn take(&mut self, record: &OrderRecord, now_secs: f64) {
        let Some(kind) = record.kind() else { return };
        if kind == OrderKind::Created {
            let open = Open {
                created_secs: now_secs,
                due_secs: (record.due_secs != 0.0).then(|| rounded(record.due_secs.into())),
                stops: record.detail,
                robot: None,
                loads: 0,
                is_at_stop: false,
            };
            self.open.insert(record.order, open);
            return;
        }
        let Some(open) = self.open.get_mut(&record.order) else { return };
        match kind {
            OrderKind::Assigned => {
                let (before, loads) = (open.robot.replace(record.robot), open.loads);
                if let Some(before) = before {
                    self.add(before, -1, -loads);
                }
                self.add(record.robot, 1, loads);
            }
            OrderKind::Withdrawn => self.release(record.order),
            OrderKind::Arrived => {
                if !std::mem::replace(&mut open.is_at_stop, true) {
                    self.robots.entry(record.robot).or_default().at_stops += 1;
                }
            }
            OrderKind::Handled => {
                if std::mem::take(&mut open.is_at_stop) {
                    self.robots.entry(record.robot).or_default().at_stops -= 1;
                }
                let change = match record.action() {
                    StopAction::Pick => 1,
                    StopAction::Drop => -1.min(open.loads),
                    _ => 0,
                };
                open.loads += change;
                self.add(record.robot, 0, change);
            }
            OrderKind::Finished => {
                let Open { created_secs, due_secs, stops, .. } = *open;
                let (at_secs, service_secs) = (rounded(now_secs), rounded(now_secs - created_secs));
                self.finished.push(Finished { at_secs, service_secs, stops, due_secs });
                self.close(record.order);
            }
            OrderKind::Failed => {
                self.failed += 1;
                self.close(record.order);
            }
            OrderKind::Cancelled => {
                self.cancelled += 1;
                self.close(record.order);
            }
            OrderKind::Created | OrderKind::Stop | OrderKind::Unroutable | OrderKind::Reopened => {}
        }
    }

    /// Returns the number of orders that aren't over.
    pub fn open(&self) -> usize {
        self.open.len()
    }

    /// Returns the orders that aren't over at a simulated time in seconds.
    pub fn unfinished(&self, now_secs: f64) -> Vec<Unfinished> {
        let open = self.open.values();
        open.map(|open| Unfinished {
            age_secs: rounded(now_secs - open.created_secs),
            due_secs: open.due_secs,
        })
        .collect()
    }

    /// Returns a function of robots in ascending order that returns the present work of each. To
    /// search for each robot would take longer.
    pub fn work_in_turn(&self) -> impl FnMut(u32) -> RobotWork {
        let mut works = self.robots.iter().peekable();
        move |robot| {
            while works.next_if(|(other, _)| **other < robot).is_some() {}
            let found = works.next_if(|(other, _)| **other == robot);
            found.map_or_else(RobotWork::default, |(_, work)| *work)
        }
    }

    fn release(&mut self, order: u64) {
        let Some(open) = self.open.get_mut(&order) else { return };
        let loads = std::mem::take(&mut open.loads);
        let is_at_stop = std::mem::take(&mut open.is_at_stop);
        if let Some(robot) = open.robot.take() {
            self.add(robot, -1, -loads);
            self.robots.entry(robot).or_default().at_stops -= i32::from(is_at_stop);
        }
    }

    fn close(&mut self, order: u64) {
        self.release(order);
        self.open.remove(&order);
    }

    fn add(&mut self, robot: u32, orders: i32, loads: i32) {
        let work = self.robots.entry(robot).or_default();
        work.orders += orders;
        work.loads += loads;
    }
}

/// Rounds a time to milliseconds. Ticks aren't shorter, and files with many times become half as
/// large.
fn rounded(secs: f64) -> f64 {
    (secs * 1e3).round() / 1e3
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(kind: OrderKind) -> OrderRecord {
        OrderRecord::new(7, kind).of_robot(3)
    }

    /// Whether a robot has an order, and whether it has a load.
    fn has(orders: &Orders, robot: u32) -> [bool; 2] {
        let RobotWork { orders, loads, .. } = orders.work_in_turn()(robot);
        [orders > 0, loads > 0]
    }

    #[test]
    fn a_robot_has_an_order_from_its_assignment_to_its_end_and_a_load_between_pick_and_drop() {
        let mut orders = Orders::default();
        orders.take(&OrderRecord { detail: 2, ..record(OrderKind::Created) }, 10.0);
        assert_eq!((orders.open(), has(&orders, 3)), (1, [false, false]));
        orders.take(&record(OrderKind::Assigned), 12.0);
        assert_eq!(has(&orders, 3), [true, false]);
        orders.take(&record(OrderKind::Handled).at_stop(0, 5, StopAction::Pick), 20.0);
        assert_eq!(has(&orders, 3), [true, true]);
        orders.take(&record(OrderKind::Handled).at_stop(1, 6, StopAction::Drop), 30.0);
        assert_eq!(has(&orders, 3), [true, false]);
        orders.take(&record(OrderKind::Finished), 30.0);
        assert_eq!((orders.open(), has(&orders, 3)), (0, [false, false]));
        let finished = Finished { at_secs: 30.0, service_secs: 20.0, stops: 2, due_secs: None };
        assert_eq!(orders.finished, [finished]);
    }

    #[test]
    fn an_order_is_late_after_its_deadline() {
        let mut orders = Orders::default();
        for (order, due_secs) in [(1, 15.0), (2, 25.0), (3, 0.0), (4, -1.0)] {
            let created = OrderRecord::new(order, OrderKind::Created);
            orders.take(&OrderRecord { due_secs, ..created }, 10.0);
        }
        let late: Vec<_> = orders.unfinished(30.0).iter().map(Unfinished::is_late).collect();
        assert_eq!(late, [Some(true), Some(false), None, Some(true)]);
        for order in [1, 2, 3] {
            orders.take(&OrderRecord::new(order, OrderKind::Finished), 30.0);
        }
        let late: Vec<_> = orders.finished.iter().map(Finished::is_late).collect();
        assert_eq!(late, [Some(true), Some(false), None]);
        assert_eq!(orders.unfinished(30.0).len(), 1);
    }

    #[test]
    fn an_order_that_goes_to_another_robot_counts_for_that_one_only() {
        let mut orders = Orders::default();
        orders.take(&record(OrderKind::Created), 0.0);
        orders.take(&record(OrderKind::Assigned), 1.0);
        orders.take(&record(OrderKind::Withdrawn), 2.0);
        assert_eq!(has(&orders, 3), [false, false]);
        orders.take(&OrderRecord { robot: 4, ..record(OrderKind::Assigned) }, 3.0);
        orders.take(&OrderRecord { robot: 5, ..record(OrderKind::Assigned) }, 3.0);
        assert_eq!([3, 4, 5].map(|robot| has(&orders, robot)[0]), [false, false, true]);
        orders.take(&record(OrderKind::Failed), 4.0);
        assert_eq!((orders.failed, orders.open(), has(&orders, 5)), (1, 0, [false, false]));
        orders.take(&record(OrderKind::Finished), 5.0);
        assert!(orders.finished.is_empty(), "an unknown order");
    }
}
