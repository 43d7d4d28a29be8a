//! The orders of robots, put together from the order log.

use std::collections::BTreeMap;

use regatta_plugin::order::{NO_ROBOT, OrderKind, OrderRecord, StopAction};

/// The known open orders.
#[derive(Debug, Default)]
pub struct OpenOrders {
    /// The run that the orders belong to.
    run: u64,
    orders: BTreeMap<u64, Order>,
    /// The order of each robot that has one.
    by_robot: BTreeMap<u32, u64>,
}

/// An order that has not ended.
#[derive(Clone, Debug, Default)]
struct Order {
    stops: Vec<Stop>,
    /// The number of stops that were announced.
    announced: u32,
    /// The index of the stop that comes next, or at which the robot stands.
    next: u32,
    is_handling: bool,
}

/// A stop of an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stop {
    /// Id of its node.
    pub node: u32,
    /// The action of the robot there.
    pub action: StopAction,
}

/// The known facts of a robot's order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RobotOrder {
    /// The number of the order.
    pub number: u64,
    /// The number of the stop that comes next, from 1, and the number of stops; 0 if that is not
    /// known.
    pub stop: [u32; 2],
    /// The stop, if it is known.
    pub next: Option<Stop>,
    /// Whether the robot stands there, and loads or unloads.
    pub is_handling: bool,
}

/// A robot's order as the fleet manager tells it. Unlike those of [`OpenOrders`], it may have begun
/// before this program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedOrder {
    /// The robot, by id.
    pub robot: u32,
    /// The name, as `regatta orders list` prints it.
    pub name: String,
    /// Its facts; the number is 0.
    pub order: RobotOrder,
}

impl OpenOrders {
    /// Takes the records of a tick of a run.
    pub fn take(&mut self, run: u64, records: &[OrderRecord]) {
        if self.run != run {
            *self = Self { run, ..Self::default() };
        }
        for record in records {
            self.record(record);
        }
    }

    fn record(&mut self, record: &OrderRecord) {
        let Some(kind) = record.kind() else { return };
        if matches!(kind, OrderKind::Finished | OrderKind::Failed | OrderKind::Cancelled) {
            self.orders.remove(&record.order);
            return self.by_robot.retain(|_, order| *order != record.order);
        }
        let order = self.orders.entry(record.order).or_default();
        let stop = Stop { node: record.node, action: record.action() };
        match kind {
            OrderKind::Created => *order = Order { announced: record.detail, ..Order::default() },
            // Another index means that records are missing.
            OrderKind::Stop if record.stop as usize == order.stops.len() => order.stops.push(stop),
            OrderKind::Arrived => (order.next, order.is_handling) = (record.stop, true),
            OrderKind::Handled => (order.next, order.is_handling) = (record.stop + 1, false),
            OrderKind::Withdrawn => {
                (order.next, order.is_handling) = (0, false);
                self.by_robot.retain(|_, order| *order != record.order);
                return;
            }
            _ => {}
        }
        if record.robot != NO_ROBOT {
            self.by_robot.insert(record.robot, record.order);
        }
    }

    /// Returns the known facts of a robot's order; `None` if it has none, or the log hasn't named
    /// it since reading began.
    pub fn of_robot(&self, robot: u32) -> Option<RobotOrder> {
        let number = *self.by_robot.get(&robot)?;
        let order = self.orders.get(&number)?;
        let stops = order.announced.max(order.stops.len() as u32);
        Some(RobotOrder {
            number,
            stop: if stops == 0 { [0; 2] } else { [(order.next + 1).min(stops), stops] },
            next: order.stops.get(order.next as usize).copied(),
            is_handling: order.is_handling,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn created() -> [OrderRecord; 3] {
        let stop =
            |index, node, action| OrderRecord::new(7, OrderKind::Stop).at_stop(index, node, action);
        let first = OrderRecord { detail: 2, ..OrderRecord::new(7, OrderKind::Created) };
        [first, stop(0, 30, StopAction::Pick), stop(1, 40, StopAction::Drop)]
    }

    #[test]
    fn an_order_is_followed_from_stop_to_stop() {
        let mut book = OpenOrders::default();
        book.take(1, &created());
        assert_eq!(book.of_robot(3), None, "nobody has the order");
        let of = |kind| OrderRecord::new(7, kind).of_robot(3);
        let order = |stop, node, action, is_handling| {
            Some(RobotOrder {
                number: 7,
                stop: [stop, 2],
                next: Some(Stop { node, action }),
                is_handling,
            })
        };
        book.take(1, &[of(OrderKind::Assigned)]);
        assert_eq!(book.of_robot(3), order(1, 30, StopAction::Pick, false));
        book.take(1, &[of(OrderKind::Arrived).at_stop(0, 30, StopAction::Pick)]);
        assert_eq!(book.of_robot(3), order(1, 30, StopAction::Pick, true));
        book.take(1, &[of(OrderKind::Handled).at_stop(0, 30, StopAction::Pick)]);
        assert_eq!(book.of_robot(3), order(2, 40, StopAction::Drop, false));
        book.take(
            1,
            &[
                of(OrderKind::Handled).at_stop(1, 40, StopAction::Drop),
                OrderRecord::new(7, OrderKind::Finished),
            ],
        );
        assert_eq!(book.of_robot(3), None);
    }

    #[test]
    fn an_order_changes_hands_and_another_run_has_none() {
        let mut book = OpenOrders::default();
        let of = |kind, robot| OrderRecord::new(7, kind).of_robot(robot);
        book.take(1, &created());
        book.take(
            1,
            &[of(OrderKind::Assigned, 3), of(OrderKind::Withdrawn, 3), of(OrderKind::Assigned, 4)],
        );
        assert_eq!(book.of_robot(3), None);
        assert_eq!(book.of_robot(4).map(|order| order.stop), Some([1, 2]));
        book.take(2, &[]);
        assert_eq!(book.of_robot(4), None);
    }

    #[test]
    fn an_order_that_began_before_the_book_has_no_stops() {
        let mut book = OpenOrders::default();
        book.take(
            1,
            &[OrderRecord::new(9, OrderKind::Handled).of_robot(5).at_stop(3, 30, StopAction::Pick)],
        );
        assert_eq!(
            book.of_robot(5),
            Some(RobotOrder { number: 9, stop: [0, 0], next: None, is_handling: false })
        );
        book.take(1, &[OrderRecord { kind: 99, ..OrderRecord::new(9, OrderKind::Stop) }]);
        book.take(1, &[OrderRecord::new(9, OrderKind::Stop).at_stop(5, 1, StopAction::None)]);
        assert_eq!(book.of_robot(5).map(|order| order.stop), Some([0, 0]));
    }
}
