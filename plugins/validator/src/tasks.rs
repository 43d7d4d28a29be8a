//! Rules of tasks: what the task log says is checked against itself and against where the robots
//! were.

use std::collections::{BTreeMap, VecDeque};

use regatta_plugin::task::{NO_ROBOT, StopAction, TaskHeader, TaskKind, TaskRecord};

use crate::findings::{Finding, Findings, Kind};
use crate::stands::{Presence, Stands};

/// Metres between a robot and the node of the stop that it handles.
const STOP_TOLERANCE: f64 = 0.05;

/// The clock of a frame.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Now {
    pub tick: u64,
    pub seconds: f64,
    /// Seconds per tick.
    pub period: f64,
}

#[derive(Clone, Copy, Debug)]
struct Stop {
    node: u32,
    action: StopAction,
    dwell_secs: f32,
}

#[derive(Clone, Debug, Default)]
struct Task {
    /// Whether the log was read from the task's beginning.
    is_whole: bool,
    created_secs: f64,
    wanted_stops: u32,
    stops: Vec<Stop>,
    robot: Option<u32>,
    handled: u32,
    loads: u32,
    /// The stop at which its robot is, and the tick of the arrival.
    arrived: Option<(u32, u64)>,
    is_closed: bool,
    reported_unserved: bool,
}

/// All tasks of a run.
#[derive(Debug, Default)]
pub(crate) struct Tasks {
    tasks: BTreeMap<u64, Task>,
    robots: BTreeMap<u32, u64>,
    /// Records that came before the frame of their tick.
    early: VecDeque<(u64, TaskRecord)>,
    /// Whether records are missing: then a task may have begun or gone on without the judge.
    pub has_gaps: bool,
    /// Whether a sample of the log has come.
    has_begun: bool,
    /// Open tasks without a robot.
    waiting: u64,
    pub records: u64,
}

/// What a record is checked against.
pub(crate) struct Context<'a> {
    pub stands: &'a Stands,
    pub node: &'a dyn Fn(u32) -> Option<[f32; 2]>,
    pub findings: &'a mut Findings,
}

impl Tasks {
    /// Takes the records of a tick. `is_incomplete` says that samples before them are missing.
    pub fn take(&mut self, header: &TaskHeader, records: &[TaskRecord], is_incomplete: bool) {
        // What was published before the judge joined the log isn't counted as missing, but isn't
        // known either.
        let joined_late = !std::mem::replace(&mut self.has_begun, true) && header.sequence > 1;
        if is_incomplete || joined_late || header.dropped > 0 {
            self.lose();
        }
        self.early.extend(records.iter().map(|record| (header.tick, *record)));
    }

    /// Records are missing: what is known of open tasks may be wrong from here on.
    fn lose(&mut self) {
        self.has_gaps = true;
        self.tasks.values_mut().for_each(|task| task.is_whole = false);
    }

    /// Judges the records up to a frame.
    pub fn judge(&mut self, now: Now, context: &mut Context<'_>) {
        while let Some((tick, record)) = self.early.pop_front_if(|(tick, _)| *tick <= now.tick) {
            let at = Now { tick, seconds: tick as f64 * now.period, ..now };
            self.records += 1;
            self.judge_record(at, &record, context);
        }
    }

    fn judge_record(&mut self, at: Now, record: &TaskRecord, context: &mut Context<'_>) {
        let Some(kind) = record.kind() else {
            return report(context, at, record, Kind::TaskOrder, "a record of an unknown kind");
        };
        let has_gaps = self.has_gaps;
        if kind == TaskKind::Created {
            return self.create(at, record, context);
        }
        let Some(task) = self.tasks.get(&record.task) else {
            if !has_gaps {
                report(
                    context,
                    at,
                    record,
                    Kind::TaskOrder,
                    "a record of a task that wasn't created",
                );
            }
            let unknown = Task { created_secs: at.seconds, ..Task::default() };
            self.tasks.insert(record.task, unknown);
            self.waiting += 1;
            return self.follow(kind, at, record, context);
        };
        if task.is_closed {
            return report(context, at, record, Kind::DoneTwice, "a record after the task's end");
        }
        self.follow(kind, at, record, context);
    }

    fn create(&mut self, at: Now, record: &TaskRecord, context: &mut Context<'_>) {
        if self.tasks.contains_key(&record.task) {
            return report(context, at, record, Kind::TaskOrder, "created twice");
        }
        let (is_whole, wanted_stops) = (true, record.detail);
        let task = Task { is_whole, wanted_stops, created_secs: at.seconds, ..Task::default() };
        self.tasks.insert(record.task, task);
        self.waiting += 1;
    }

    /// Takes a record of an open task.
    fn follow(&mut self, kind: TaskKind, at: Now, record: &TaskRecord, context: &mut Context<'_>) {
        match kind {
            TaskKind::Created => {}
            TaskKind::Stop => self.stop(at, record, context),
            TaskKind::Assigned => self.assign(at, record, context),
            TaskKind::Withdrawn => self.withdraw(at, record, context),
            TaskKind::Arrived => self.arrive(at, record, context),
            TaskKind::Handled => self.handle(at, record, context),
            TaskKind::Finished => self.finish(at, record, context),
            TaskKind::Failed | TaskKind::Cancelled => self.close(record.task),
        }
    }

    fn stop(&mut self, at: Now, record: &TaskRecord, context: &mut Context<'_>) {
        let Some(task) = self.tasks.get_mut(&record.task) else { return };
        let is_next = record.stop as usize == task.stops.len() && record.stop < task.wanted_stops;
        if task.is_whole && (!is_next || task.robot.is_some()) {
            report(
                context,
                at,
                record,
                Kind::TaskOrder,
                "a stop that isn't the next one of a new task",
            );
        }
        task.stops.push(Stop {
            node: record.node,
            action: record.action(),
            dwell_secs: record.dwell_secs,
        });
    }

    fn assign(&mut self, at: Now, record: &TaskRecord, context: &mut Context<'_>) {
        let Some(task) = self.tasks.get_mut(&record.task) else { return };
        if task.is_whole && task.stops.len() != task.wanted_stops as usize {
            report(
                context,
                at,
                record,
                Kind::TaskOrder,
                "assigned before all of its stops were told",
            );
        }
        if task.is_whole && task.robot.is_some() {
            report(context, at, record, Kind::TaskOrder, "assigned although it has a robot");
        }
        if record.robot == NO_ROBOT {
            return report(context, at, record, Kind::TaskOrder, "assigned to no robot");
        }
        if let Some(before) = task.robot.replace(record.robot) {
            self.robots.remove(&before);
        } else {
            self.waiting -= 1;
        }
        let other =
            self.robots.insert(record.robot, record.task).filter(|other| *other != record.task);
        if other.and_then(|other| self.tasks.get(&other)).is_some_and(|other| other.is_whole) {
            report(
                context,
                at,
                record,
                Kind::TwoTasks,
                "assigned to a robot that has another task",
            );
        }
    }

    fn withdraw(&mut self, at: Now, record: &TaskRecord, context: &mut Context<'_>) {
        let Some(task) = self.tasks.get_mut(&record.task) else { return };
        if task.is_whole && task.robot != Some(record.robot) {
            report(
                context,
                at,
                record,
                Kind::TaskOrder,
                "withdrawn from a robot that doesn't have it",
            );
        } else if task.is_whole && task.loads > 0 {
            report(context, at, record, Kind::TaskOrder, "withdrawn after the pick");
        }
        (task.handled, task.arrived) = (0, None);
        if let Some(robot) = task.robot.take() {
            self.waiting += 1;
            self.robots.remove(&robot);
        }
    }

    fn arrive(&mut self, at: Now, record: &TaskRecord, context: &mut Context<'_>) {
        let Some(task) = self.tasks.get_mut(&record.task) else { return };
        if task.is_whole {
            check_stop(task, at, record, context);
            check_turn(task, at, record, context);
            if task.arrived.is_some() {
                report(
                    context,
                    at,
                    record,
                    Kind::TaskOrder,
                    "arrived at a stop before the last one was handled",
                );
            }
        }
        check_presence(at, record, context);
        task.arrived = Some((record.stop, at.tick));
    }

    fn handle(&mut self, at: Now, record: &TaskRecord, context: &mut Context<'_>) {
        let Some(task) = self.tasks.get_mut(&record.task) else { return };
        let arrived = task.arrived.take().filter(|(stop, _)| *stop == record.stop);
        if task.is_whole {
            check_stop(task, at, record, context);
            match arrived {
                None => {
                    report(context, at, record, Kind::TaskOrder, "handled without an arrival");
                    check_turn(task, at, record, context);
                }
                Some((_, since)) => check_dwell(task, since, at, record, context),
            }
        }
        check_presence(at, record, context);
        let action =
            task.stops.get(record.stop as usize).map_or(record.action(), |stop| stop.action);
        match action {
            StopAction::Pick => task.loads += 1,
            StopAction::Drop if task.loads == 0 && task.is_whole => {
                report(context, at, record, Kind::DropWithoutPick, "");
            }
            StopAction::Drop => task.loads = task.loads.saturating_sub(1),
            _ => {}
        }
        task.handled = task.handled.max(record.stop + 1);
    }

    fn finish(&mut self, at: Now, record: &TaskRecord, context: &mut Context<'_>) {
        let Some(task) = self.tasks.get(&record.task) else { return };
        if task.is_whole && task.handled < task.wanted_stops {
            report(
                context,
                at,
                record,
                Kind::SkippedStop,
                "finished before all of its stops were handled",
            );
        }
        if task.is_whole && task.robot.is_none() {
            report(context, at, record, Kind::TaskOrder, "finished without a robot");
        }
        self.close(record.task);
    }

    fn close(&mut self, number: u64) {
        let Some(task) = self.tasks.get_mut(&number) else { return };
        match task.robot.take() {
            Some(robot) if self.robots.get(&robot) == Some(&number) => {
                drop(self.robots.remove(&robot))
            }
            Some(_) => {}
            None => self.waiting -= 1,
        }
        *task = Task { is_closed: true, ..Task::default() };
    }

    /// Finds tasks that are open for longer than this.
    pub fn judge_waiting(&mut self, now: Now, after_secs: f64, findings: &mut Findings) {
        for (number, task) in &mut self.tasks {
            let age = now.seconds - task.created_secs;
            if task.is_closed || task.reported_unserved || age <= after_secs {
                continue;
            }
            task.reported_unserved = true;
            findings.add(Kind::Unserved, || Finding {
                task: Some(*number),
                robots: task.robot.into_iter().collect(),
                value: Some(age),
                limit: Some(after_secs),
                ..Finding::at(now.tick, now.seconds)
            });
        }
    }

    /// Whether tasks wait for a robot.
    pub fn are_waiting(&self) -> bool {
        self.waiting > 0
    }

    pub fn has_task(&self, robot: u32) -> bool {
        self.robots.contains_key(&robot)
    }

    pub fn len(&self) -> u64 {
        self.tasks.len() as u64
    }
}

/// Checks that a record is of its task's robot, and of the node of its stop.
fn check_stop(task: &Task, at: Now, record: &TaskRecord, context: &mut Context<'_>) {
    if task.robot != Some(record.robot) {
        report(context, at, record, Kind::TaskOrder, "a robot that doesn't have the task");
    }
    match task.stops.get(record.stop as usize) {
        Some(stop) if stop.node != record.node => {
            report(context, at, record, Kind::WrongPlace, "not the stop's node")
        }
        None => report(context, at, record, Kind::TaskOrder, "a stop that the task doesn't have"),
        _ => {}
    }
}

/// Checks that a stop is its task's next one.
fn check_turn(task: &Task, at: Now, record: &TaskRecord, context: &mut Context<'_>) {
    if record.stop > task.handled {
        report(context, at, record, Kind::SkippedStop, "a later stop than the next one");
    } else if record.stop < task.handled {
        report(context, at, record, Kind::DoneTwice, "a stop that was handled before");
    }
}

/// Checks that a robot stood at the stop for its dwell time.
fn check_dwell(task: &Task, since: u64, at: Now, record: &TaskRecord, context: &mut Context<'_>) {
    let wanted =
        task.stops.get(record.stop as usize).map_or(0.0, |stop| f64::from(stop.dwell_secs));
    let stayed = at.tick.saturating_sub(since) as f64 * at.period;
    // A dwell is over in the tick that completes it, however the time is rounded to ticks.
    if stayed + 1e-6 + 0.5 * at.period < wanted {
        context.findings.add(Kind::ShortDwell, || Finding {
            value: Some(stayed),
            limit: Some(wanted),
            ..finding(at, record, "")
        });
    }
    if context.stands.moved(record.robot, since, at.tick) {
        report(context, at, record, Kind::MovedInDwell, "");
    }
}

/// Checks that a robot stands at the node of a record.
fn check_presence(at: Now, record: &TaskRecord, context: &mut Context<'_>) {
    let Some(node) = (context.node)(record.node) else {
        return report(context, at, record, Kind::WrongPlace, "a node that the world doesn't have");
    };
    match context.stands.place(record.robot, at.tick) {
        Presence::Unknown => {}
        Presence::Moving => report(
            context,
            at,
            record,
            Kind::WrongPlace,
            "the robot moves, or there is no such robot",
        ),
        Presence::Stands([x, y]) => {
            let away = (f64::from(x) - f64::from(node[0])).hypot(f64::from(y) - f64::from(node[1]));
            if away > STOP_TOLERANCE {
                context.findings.add(Kind::WrongPlace, || Finding {
                    place: Some([x, y]),
                    value: Some(away),
                    limit: Some(STOP_TOLERANCE),
                    ..finding(at, record, "")
                });
            }
        }
    }
}

fn finding(at: Now, record: &TaskRecord, note: &'static str) -> Finding {
    let robots = Some(record.robot).filter(|robot| *robot != NO_ROBOT).into_iter().collect();
    Finding { robots, task: Some(record.task), note, ..Finding::at(at.tick, at.seconds) }
}

fn report(context: &mut Context<'_>, at: Now, record: &TaskRecord, kind: Kind, note: &'static str) {
    context.findings.add(kind, || finding(at, record, note));
}
