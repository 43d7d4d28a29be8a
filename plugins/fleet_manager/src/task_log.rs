//! The book's events as the contract's task log has them.

use std::collections::BTreeMap;

use regatta_plugin::task::{NO_ROBOT, StopAction, TaskKind, TaskRecord};

use regatta_orders::{Action, Change, Order, OrderEvent, Places, Stop};

/// Turns events into records.
#[derive(Debug, Default)]
pub struct TaskLog {
    /// By the number of an open task: the record of each of its stops.
    stops: BTreeMap<u64, Vec<TaskRecord>>,
}

impl TaskLog {
    /// Makes the log of a book whose open orders were announced already: before a restart.
    pub fn new<'book>(open: impl Iterator<Item = &'book Order>, places: &Places) -> Self {
        let stops = |order: &Order| {
            let task = order.id.0;
            let stops = (0..).zip(&order.content.stops);
            let of = record(task, TaskKind::Stop, None);
            (task, stops.map(|(number, stop)| stop_record(of, number, stop, places)).collect())
        };
        Self { stops: open.map(stops).collect() }
    }

    /// Returns an event as a record; `None` for those that the task log doesn't have.
    pub fn record(&mut self, event: &OrderEvent, places: &Places) -> Option<TaskRecord> {
        let task = event.id.0;
        let of = |kind, robot: Option<u32>| record(task, kind, robot);
        Some(match &event.change {
            Change::Created { stops, .. } => {
                TaskRecord { detail: *stops, ..of(TaskKind::Created, None) }
            }
            Change::Stop { stop, node, action, dwell_secs } => {
                let of_stop = Stop { node: *node, action: *action, dwell_secs: *dwell_secs };
                let record = stop_record(of(TaskKind::Stop, None), *stop, &of_stop, places);
                self.stops.entry(task).or_default().push(record);
                record
            }
            Change::Assigned { robot } => of(TaskKind::Assigned, Some(*robot)),
            Change::Withdrawn { robot } => of(TaskKind::Withdrawn, Some(*robot)),
            Change::Arrived { robot, stop } => {
                self.at_stop(of(TaskKind::Arrived, Some(*robot)), *stop)
            }
            Change::Handled { robot, stop } => {
                self.at_stop(of(TaskKind::Handled, Some(*robot)), *stop)
            }
            Change::Finished { robot } => self.end(of(TaskKind::Finished, Some(*robot))),
            Change::Failed { robot, .. } => self.end(of(TaskKind::Failed, *robot)),
            Change::Cancelled { robot, .. } => self.end(of(TaskKind::Cancelled, *robot)),
            Change::Unroutable { .. } | Change::Reopened => return None,
        })
    }

    fn at_stop(&self, record: TaskRecord, stop: u32) -> TaskRecord {
        let known = self.stops.get(&record.task).and_then(|stops| stops.get(stop as usize));
        let (node, action) = known.map_or((0, 0), |known| (known.node, known.action));
        TaskRecord { stop, node, action, ..record }
    }

    fn end(&mut self, record: TaskRecord) -> TaskRecord {
        self.stops.remove(&record.task);
        record
    }
}

fn record(task: u64, kind: TaskKind, robot: Option<u32>) -> TaskRecord {
    TaskRecord {
        task,
        kind: kind as u32,
        robot: robot.unwrap_or(NO_ROBOT),
        stop: 0,
        node: 0,
        action: 0,
        dwell_secs: 0.0,
        detail: 0,
        reserved: 0,
    }
}

fn stop_record(record: TaskRecord, number: u32, stop: &Stop, places: &Places) -> TaskRecord {
    TaskRecord {
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
