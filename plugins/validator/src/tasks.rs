//! Rules of tasks: the task log is checked against itself and against the places of the robots.

use std::collections::{BTreeMap, VecDeque};

use regatta_plugin::task::{NO_ROBOT, StopAction, TaskHeader, TaskKind, TaskRecord};

use crate::findings::{Finding, Findings, Kind};
use crate::stands::{Presence, Stands};
use crate::world_model::WorldModel;

/// The largest distance, in metres, between a robot and the node of the stop that it handles.
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
    /// Whether records are missing: then a task may have begun or continued unseen.
    pub has_gaps: bool,
    /// Whether a sample of the log has come.
    has_begun: bool,
    /// Open tasks without a robot.
    waiting: u64,
}

/// A record under judgement, and all that it is checked against.
struct Check<'a> {
    at: Now,
    record: &'a TaskRecord,
    world: &'a WorldModel,
    stands: &'a Stands,
    findings: &'a mut Findings,
}

impl Tasks {
    /// Takes the records of a tick. `is_incomplete` says that samples before them are missing.
    pub fn take(&mut self, header: &TaskHeader, records: &[TaskRecord], is_incomplete: bool) {
        // Samples published before the judge joined the log don't count as missing, but are
        // unknown.
        let joined_late = !std::mem::replace(&mut self.has_begun, true) && header.sequence > 1;
        if is_incomplete || joined_late || header.dropped > 0 {
            self.has_gaps = true;
            for task in self.tasks.values_mut() {
                task.is_whole = false;
            }
        }
        self.early.extend(records.iter().map(|record| (header.tick, *record)));
    }

    /// Judges the records up to a frame.
    pub fn judge(
        &mut self,
        now: Now,
        world: &WorldModel,
        stands: &Stands,
        findings: &mut Findings,
    ) {
        while let Some((tick, record)) = self.early.pop_front_if(|(tick, _)| *tick <= now.tick) {
            let at = Now { tick, seconds: tick as f64 * now.period, ..now };
            self.judge_record(&mut Check { at, record: &record, world, stands, findings });
        }
    }

    fn judge_record(&mut self, check: &mut Check<'_>) {
        let (number, created_secs) = (check.record.task, check.at.seconds);
        let Some(kind) = check.record.kind() else {
            return check.report(Kind::TaskOrder, "a record of an unknown kind");
        };
        if kind == TaskKind::Created {
            return self.create(check);
        }
        match self.tasks.get(&number) {
            Some(task) if task.is_closed => {
                return check.report(Kind::DoneTwice, "a record after the task's end");
            }
            Some(_) => {}
            None => {
                if !self.has_gaps {
                    check.report(Kind::TaskOrder, "a record of a task that wasn't created");
                }
                self.tasks.insert(number, Task { created_secs, ..Task::default() });
                self.waiting += 1;
            }
        }
        match kind {
            TaskKind::Created => {}
            TaskKind::Stop => self.stop(check),
            TaskKind::Assigned => self.assign(check),
            TaskKind::Withdrawn => self.withdraw(check),
            TaskKind::Arrived => self.arrive(check),
            TaskKind::Handled => self.handle(check),
            TaskKind::Finished => self.finish(check),
            TaskKind::Failed | TaskKind::Cancelled => self.close(number),
        }
    }

    fn create(&mut self, check: &mut Check<'_>) {
        let &TaskRecord { task: number, detail: wanted_stops, .. } = check.record;
        if self.tasks.contains_key(&number) {
            return check.report(Kind::TaskOrder, "created twice");
        }
        let (is_whole, created_secs) = (true, check.at.seconds);
        self.tasks.insert(number, Task { is_whole, wanted_stops, created_secs, ..Task::default() });
        self.waiting += 1;
    }

    fn stop(&mut self, check: &mut Check<'_>) {
        let record = check.record;
        let Some(task) = self.tasks.get_mut(&record.task) else { return };
        let is_next = record.stop as usize == task.stops.len() && record.stop < task.wanted_stops;
        if task.is_whole && (!is_next || task.robot.is_some()) {
            check.report(Kind::TaskOrder, "a stop that isn't the next one of a new task");
        }
        let (node, action, dwell_secs) = (record.node, record.action(), record.dwell_secs);
        task.stops.push(Stop { node, action, dwell_secs });
    }

    fn assign(&mut self, check: &mut Check<'_>) {
        let &TaskRecord { task: number, robot, .. } = check.record;
        let Some(task) = self.tasks.get_mut(&number) else { return };
        if task.is_whole && task.stops.len() != task.wanted_stops as usize {
            check.report(Kind::TaskOrder, "assigned before all of its stops were told");
        }
        if task.is_whole && task.robot.is_some() {
            check.report(Kind::TaskOrder, "assigned although it has a robot");
        }
        if robot == NO_ROBOT {
            return check.report(Kind::TaskOrder, "assigned to no robot");
        }
        if let Some(before) = task.robot.replace(robot) {
            self.robots.remove(&before);
        } else {
            self.waiting -= 1;
        }
        let other = self.robots.insert(robot, number).filter(|other| *other != number);
        if other.and_then(|other| self.tasks.get(&other)).is_some_and(|other| other.is_whole) {
            check.report(Kind::TwoTasks, "assigned to a robot that has another task");
        }
    }

    fn withdraw(&mut self, check: &mut Check<'_>) {
        let Some(task) = self.tasks.get_mut(&check.record.task) else { return };
        if task.is_whole && task.robot != Some(check.record.robot) {
            check.report(Kind::TaskOrder, "withdrawn from a robot that doesn't have it");
        } else if task.is_whole && task.loads > 0 {
            check.report(Kind::TaskOrder, "withdrawn after the pick");
        }
        (task.handled, task.arrived) = (0, None);
        if let Some(robot) = task.robot.take() {
            self.waiting += 1;
            self.robots.remove(&robot);
        }
    }

    fn arrive(&mut self, check: &mut Check<'_>) {
        let Some(task) = self.tasks.get_mut(&check.record.task) else { return };
        if task.is_whole {
            check.stop(task);
            check.turn(task);
            if task.arrived.is_some() {
                check.report(Kind::TaskOrder, "arrived at a stop before the last one was handled");
            }
        }
        check.presence();
        task.arrived = Some((check.record.stop, check.at.tick));
    }

    fn handle(&mut self, check: &mut Check<'_>) {
        let record = check.record;
        let Some(task) = self.tasks.get_mut(&record.task) else { return };
        let arrived = task.arrived.take().filter(|(stop, _)| *stop == record.stop);
        if task.is_whole {
            check.stop(task);
            if let Some((_, since)) = arrived {
                check.dwell(task, since);
            } else {
                check.report(Kind::TaskOrder, "handled without an arrival");
                check.turn(task);
            }
        }
        check.presence();
        match task.stops.get(record.stop as usize).map_or(record.action(), |stop| stop.action) {
            StopAction::Pick => task.loads += 1,
            StopAction::Drop if task.loads == 0 && task.is_whole => {
                check.report(Kind::DropWithoutPick, "");
            }
            StopAction::Drop => task.loads = task.loads.saturating_sub(1),
            _ => {}
        }
        task.handled = task.handled.max(record.stop + 1);
    }

    fn finish(&mut self, check: &mut Check<'_>) {
        let Some(task) = self.tasks.get(&check.record.task) else { return };
        if task.is_whole && task.handled < task.wanted_stops {
            check.report(Kind::SkippedStop, "finished before all of its stops were handled");
        }
        if task.is_whole && task.robot.is_none() {
            check.report(Kind::TaskOrder, "finished without a robot");
        }
        self.close(check.record.task);
    }

    fn close(&mut self, number: u64) {
        let Some(task) = self.tasks.get_mut(&number) else { return };
        match task.robot.take() {
            Some(robot) if self.robots.get(&robot) == Some(&number) => {
                self.robots.remove(&robot);
            }
            Some(_) => {}
            None => self.waiting -= 1,
        }
        *task = Task { is_closed: true, ..Task::default() };
    }

    /// Finds tasks that have been open for longer than `after_secs`.
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

impl Check<'_> {
    /// Checks that the record is of its task's robot, and of the node of its stop.
    fn stop(&mut self, task: &Task) {
        if task.robot != Some(self.record.robot) {
            self.report(Kind::TaskOrder, "a robot that doesn't have the task");
        }
        match task.stops.get(self.record.stop as usize) {
            Some(stop) if stop.node != self.record.node => {
                self.report(Kind::WrongPlace, "not the stop's node");
            }
            Some(_) => {}
            None => self.report(Kind::TaskOrder, "a stop that the task doesn't have"),
        }
    }

    /// Checks that the stop is its task's next one.
    fn turn(&mut self, task: &Task) {
        if self.record.stop > task.handled {
            self.report(Kind::SkippedStop, "a later stop than the next one");
        } else if self.record.stop < task.handled {
            self.report(Kind::DoneTwice, "a stop that was handled before");
        }
    }

    /// Checks that the robot stood at the stop for its dwell time.
    fn dwell(&mut self, task: &Task, since: u64) {
        let Now { tick, period, .. } = self.at;
        let stop = task.stops.get(self.record.stop as usize);
        let wanted = stop.map_or(0.0, |stop| f64::from(stop.dwell_secs));
        let stayed = tick.saturating_sub(since) as f64 * period;
        // A dwell is over in the tick that completes it, however the time is rounded to ticks.
        if stayed + 1e-6 + 0.5 * period < wanted {
            let (value, limit) = (Some(stayed), Some(wanted));
            self.add(Kind::ShortDwell, |finding| Finding { value, limit, ..finding });
        }
        if self.stands.moved(self.record.robot, since, tick) {
            self.report(Kind::MovedInDwell, "");
        }
    }

    /// Checks that the robot stands at the record's node.
    fn presence(&mut self) {
        let Some(node) = self.world.node_position(self.record.node) else {
            return self.report(Kind::WrongPlace, "a node that the world doesn't have");
        };
        match self.stands.place(self.record.robot, self.at.tick) {
            Presence::Unknown => {}
            Presence::Moving => {
                self.report(Kind::WrongPlace, "the robot moves, or there is no such robot");
            }
            Presence::Stands(place) => {
                let away = (place.as_dvec2() - node.as_dvec2()).length();
                if away > STOP_TOLERANCE {
                    self.add(Kind::WrongPlace, |finding| Finding {
                        place: Some(place.into()),
                        value: Some(away),
                        limit: Some(STOP_TOLERANCE),
                        ..finding
                    });
                }
            }
        }
    }

    fn report(&mut self, kind: Kind, note: &'static str) {
        self.add(kind, |finding| Finding { note, ..finding });
    }

    /// Adds a finding about the record, with the details that `complete` fills in.
    fn add(&mut self, kind: Kind, complete: impl FnOnce(Finding) -> Finding) {
        let (at, record) = (self.at, self.record);
        self.findings.add(kind, || {
            let robots = Some(record.robot).filter(|robot| *robot != NO_ROBOT);
            complete(Finding {
                robots: robots.into_iter().collect(),
                task: Some(record.task),
                ..Finding::at(at.tick, at.seconds)
            })
        });
    }
}
