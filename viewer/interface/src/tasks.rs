//! The tasks of robots, put together from the task log.

use std::collections::BTreeMap;

use regatta_plugin::task::{NO_ROBOT, StopAction, TaskKind, TaskRecord};

/// What is known of all open tasks.
#[derive(Debug, Default)]
pub struct TaskBook {
    /// The run that the tasks belong to.
    run: u64,
    tasks: BTreeMap<u64, Task>,
    /// The task of each robot that has one.
    by_robot: BTreeMap<u32, u64>,
}

/// A task that has not ended.
#[derive(Clone, Debug, Default)]
struct Task {
    stops: Vec<Stop>,
    /// The number of stops that were announced.
    announced: u32,
    /// The index of the stop that comes next, or at which the robot stands.
    next: u32,
    is_handling: bool,
}

/// A stop of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stop {
    /// Id of its node.
    pub node: u32,
    /// What the robot does there.
    pub action: StopAction,
}

/// What is known of a robot's task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RobotTask {
    /// The number of the task.
    pub task: u64,
    /// The number of the stop that comes next, from 1, and the number of stops; 0 if that is not
    /// known.
    pub stop: [u32; 2],
    /// The stop, if it is known.
    pub next: Option<Stop>,
    /// Whether the robot stands there, and loads or unloads.
    pub is_handling: bool,
}

impl TaskBook {
    /// Takes the records of a tick of a run.
    pub fn take(&mut self, run: u64, records: &[TaskRecord]) {
        if self.run != run {
            *self = Self { run, ..Self::default() };
        }
        records.iter().for_each(|record| self.record(record));
    }

    fn record(&mut self, record: &TaskRecord) {
        let Some(kind) = record.kind() else { return };
        if matches!(kind, TaskKind::Finished | TaskKind::Failed | TaskKind::Cancelled) {
            self.tasks.remove(&record.task);
            return self.by_robot.retain(|_, task| *task != record.task);
        }
        let task = self.tasks.entry(record.task).or_default();
        let stop = Stop { node: record.node, action: record.action() };
        match kind {
            TaskKind::Created => *task = Task { announced: record.detail, ..Task::default() },
            // Another index means that records are missing.
            TaskKind::Stop if record.stop as usize == task.stops.len() => task.stops.push(stop),
            TaskKind::Arrived => (task.next, task.is_handling) = (record.stop, true),
            TaskKind::Handled => (task.next, task.is_handling) = (record.stop + 1, false),
            TaskKind::Withdrawn => {
                (task.next, task.is_handling) = (0, false);
                self.by_robot.retain(|_, task| *task != record.task);
                return;
            }
            _ => {}
        }
        if record.robot != NO_ROBOT {
            self.by_robot.insert(record.robot, record.task);
        }
    }

    /// Returns what is known of a robot's task; `None` if it has none, or the log has not named it
    /// since this book began.
    pub fn of_robot(&self, robot: u32) -> Option<RobotTask> {
        let number = *self.by_robot.get(&robot)?;
        let task = self.tasks.get(&number)?;
        let stops = task.announced.max(task.stops.len() as u32);
        Some(RobotTask {
            task: number,
            stop: if stops == 0 { [0; 2] } else { [(task.next + 1).min(stops), stops] },
            next: task.stops.get(task.next as usize).copied(),
            is_handling: task.is_handling,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn created() -> [TaskRecord; 3] {
        let stop =
            |index, node, action| TaskRecord::new(7, TaskKind::Stop).at_stop(index, node, action);
        let first = TaskRecord { detail: 2, ..TaskRecord::new(7, TaskKind::Created) };
        [first, stop(0, 30, StopAction::Pick), stop(1, 40, StopAction::Drop)]
    }

    #[test]
    fn a_task_is_followed_from_stop_to_stop() {
        let mut book = TaskBook::default();
        book.take(1, &created());
        assert_eq!(book.of_robot(3), None, "nobody has the task");
        let of = |kind| TaskRecord::new(7, kind).of_robot(3);
        let task = |stop, node, action, is_handling| {
            Some(RobotTask {
                task: 7,
                stop: [stop, 2],
                next: Some(Stop { node, action }),
                is_handling,
            })
        };
        book.take(1, &[of(TaskKind::Assigned)]);
        assert_eq!(book.of_robot(3), task(1, 30, StopAction::Pick, false));
        book.take(1, &[of(TaskKind::Arrived).at_stop(0, 30, StopAction::Pick)]);
        assert_eq!(book.of_robot(3), task(1, 30, StopAction::Pick, true));
        book.take(1, &[of(TaskKind::Handled).at_stop(0, 30, StopAction::Pick)]);
        assert_eq!(book.of_robot(3), task(2, 40, StopAction::Drop, false));
        book.take(
            1,
            &[
                of(TaskKind::Handled).at_stop(1, 40, StopAction::Drop),
                TaskRecord::new(7, TaskKind::Finished),
            ],
        );
        assert_eq!(book.of_robot(3), None);
    }

    #[test]
    fn a_task_changes_hands_and_another_run_has_none() {
        let mut book = TaskBook::default();
        let of = |kind, robot| TaskRecord::new(7, kind).of_robot(robot);
        book.take(1, &created());
        book.take(
            1,
            &[of(TaskKind::Assigned, 3), of(TaskKind::Withdrawn, 3), of(TaskKind::Assigned, 4)],
        );
        assert_eq!(book.of_robot(3), None);
        assert_eq!(book.of_robot(4).map(|task| task.stop), Some([1, 2]));
        book.take(2, &[]);
        assert_eq!(book.of_robot(4), None);
    }

    #[test]
    fn a_task_that_began_before_the_book_has_no_stops() {
        let mut book = TaskBook::default();
        book.take(
            1,
            &[TaskRecord::new(9, TaskKind::Handled).of_robot(5).at_stop(3, 30, StopAction::Pick)],
        );
        assert_eq!(
            book.of_robot(5),
            Some(RobotTask { task: 9, stop: [0, 0], next: None, is_handling: false })
        );
        book.take(1, &[TaskRecord { kind: 99, ..TaskRecord::new(9, TaskKind::Stop) }]);
        book.take(1, &[TaskRecord::new(9, TaskKind::Stop).at_stop(5, 1, StopAction::None)]);
        assert_eq!(book.of_robot(5).map(|task| task.stop), Some([0, 0]));
    }
}
