//! The events of the pool as records of the contract's order log.

use std::collections::BTreeMap;

use regatta_plugin::order::{NO_ROBOT, Obstacle, OrderKind, OrderRecord, StopAction};

use regatta_orders::{Action, Change, Lack, Order, OrderEvent, Places, State, Stop, Unroutable};

/// Turns events into records.
#[derive(Debug, Default)]
pub struct OrderLog {
    /// By the number of an open order: the record of each of its stops.
    stops: BTreeMap<u64, Vec<OrderRecord>>,
}

impl OrderLog {
    /// Makes the log of a pool whose open orders were announced already: before a restart.
    pub fn new<'pool>(open: impl Iterator<Item = &'pool Order>, places: &Places) -> Self {
        let mut log = Self::default();
        // The stops of orders that wait for a place of a storage are announced when they have one.
        for order in open.filter(|order| order.state != State::Unplaced) {
            let record = OrderRecord::new(order.id.0, OrderKind::Stop);
            let stops = (0..).zip(&order.content.stops);
            let records = stops.map(|(number, stop)| stop_record(record, number, stop, places));
            log.stops.insert(order.id.0, records.collect());
        }
        log
    }

    /// Returns an event as a record.
    pub fn record(&mut self, event: &OrderEvent, places: &Places) -> OrderRecord {
        let id = event.id.0;
        match &event.change {
            Change::Created { stops, due_secs, .. } => OrderRecord {
                detail: *stops,
                due_secs: due_secs.map_or(0.0, seconds_left),
                ..record(id, OrderKind::Created, None)
            },
            Change::Stop { stop, node, action, dwell_secs } => {
                let content = Stop { node: *node, action: *action, dwell_secs: *dwell_secs };
                let record = record(id, OrderKind::Stop, None);
                let record = stop_record(record, *stop, &content, places);
                self.stops.entry(id).or_default().push(record);
                record
            }
            Change::Assigned { robot } => record(id, OrderKind::Assigned, Some(*robot)),
            Change::Withdrawn { robot } => record(id, OrderKind::Withdrawn, Some(*robot)),
            Change::Queued { robot, stop } => {
                self.at_stop(record(id, OrderKind::Queued, Some(*robot)), *stop)
            }
            Change::Arrived { robot, stop, wait_secs } => OrderRecord {
                dwell_secs: *wait_secs as f32,
                ..self.at_stop(record(id, OrderKind::Arrived, Some(*robot)), *stop)
            },
            Change::Handled { robot, stop } => {
                self.at_stop(record(id, OrderKind::Handled, Some(*robot)), *stop)
            }
            Change::Finished { robot } => self.end(record(id, OrderKind::Finished, Some(*robot))),
            Change::Failed { robot, .. } => self.end(record(id, OrderKind::Failed, *robot)),
            Change::Cancelled { robot, .. } => self.end(record(id, OrderKind::Cancelled, *robot)),
            Change::Unroutable { reason, lack } => {
                let record = record(id, OrderKind::Unroutable, None);
                let record = OrderRecord { detail: obstacle(*reason) as u32, ..record };
                lack.map_or(record, |lack| at_storage(record, lack, places))
            }
            Change::Reopened => record(id, OrderKind::Reopened, None),
        }
    }

    fn at_stop(&self, record: OrderRecord, stop: u32) -> OrderRecord {
        let known = self.stops.get(&record.order).and_then(|stops| stops.get(stop as usize));
        let (node, action) = known.map_or((0, 0), |known| (known.node, known.action));
        OrderRecord { stop, node, action, ..record }
    }

    fn end(&mut self, record: OrderRecord) -> OrderRecord {
        self.stops.remove(&record.order);
        record
    }
}

/// Returns the seconds to a deadline as a record has them, where 0 means none.
fn seconds_left(due_secs: f64) -> f32 {
    if due_secs == 0.0 { -f32::MIN_POSITIVE } else { due_secs as f32 }
}

fn obstacle(reason: Unroutable) -> Obstacle {
    match reason {
        Unroutable::ClosedEdges => Obstacle::ClosedEdges,
        Unroutable::NoRobot | Unroutable::NoType => Obstacle::NoRobot,
        Unroutable::Battery => Obstacle::Battery,
        Unroutable::NoPlace => Obstacle::NoPlace,
        Unroutable::NoWay | Unroutable::NoWayOn => Obstacle::NoWay,
    }
}

/// Returns the record of an order for which a storage has no place.
fn at_storage(record: OrderRecord, lack: Lack, places: &Places) -> OrderRecord {
    let action = if lack.is_full { StopAction::Drop } else { StopAction::Pick };
    let node = places.first_place(lack.storage).id;
    OrderRecord { node, action: action as u32, ..record }
}

fn record(order: u64, kind: OrderKind, robot: Option<u32>) -> OrderRecord {
    OrderRecord::new(order, kind).of_robot(robot.unwrap_or(NO_ROBOT))
}

fn stop_record(record: OrderRecord, number: u32, stop: &Stop, places: &Places) -> OrderRecord {
    OrderRecord {
        stop: number,
        node: places.place(stop.node).id,
        action: stop_action(stop.action) as u32,
        dwell_secs: stop.dwell_secs as f32,
        ..record
    }
}

fn stop_action(action: Action) -> StopAction {
    match action {
        Action::None => StopAction::None,
        Action::Pick => StopAction::Pick,
        Action::Drop => StopAction::Drop,
        Action::Charge => StopAction::Charge,
        Action::Park => StopAction::Park,
    }
}
