//! The judge: world, frames, events and tasks in, findings out. It knows no processes and no files.

use std::collections::VecDeque;

use regatta_plugin::event::{BreakdownCause, EventHeader, EventKind, EventRecord};
use regatta_plugin::frame::{NO_EDGE, RobotState};
use regatta_plugin::task::{TaskHeader, TaskRecord};
use regatta_plugin::world::Shape;
use regatta_plugin::{Frame, World};

use crate::contacts::{Body, Contacts};
use crate::findings::{Finding, Findings, Kind};
use crate::motion::Gap;
use crate::report::Report;
use crate::row::{Fault, Row};
use crate::site::Site;
use crate::stands::Stands;
use crate::tasks::{Context, Now, Tasks};
use crate::{graph, motion};

/// How long tasks and robots may wait, and how much the report tells.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Seconds after which a task that isn't finished is a finding.
    pub unserved_after_secs: f64,
    /// Seconds after which a robot that does nothing while tasks wait is a finding.
    pub idle_after_secs: f64,
    /// The number of examples of each kind.
    pub examples: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self { unserved_after_secs: 1200.0, idle_after_secs: 1200.0, examples: 10 }
    }
}

/// In place of a robot's id: any may have joined or left, for events were lost.
const ANY_ROBOT: u32 = u32::MAX;

/// What the judge remembers of a robot.
#[derive(Clone, Copy, Debug, Default)]
struct Track {
    /// `None` if it was absent or invalid, or was spawned since.
    before: Option<Row>,
    /// The kinds that the robot has shown since the last frame in which it didn't: each counts
    /// once.
    active: u32,
    /// Since when it has done nothing while tasks waited, in seconds; infinite if it does
    /// something.
    idle_since: f64,
    reported_idle: bool,
}

/// Judges one fleet. Feed it everything in the order of time: the world, then for each tick its
/// events, tasks and frame.
#[derive(Debug)]
pub struct Judge {
    settings: Settings,
    site: Site,
    types: Vec<u16>,
    tracks: Vec<Track>,
    contacts: Contacts,
    /// Robots that joined or left, with the run and the tick, in the order of time.
    placed: VecDeque<((u64, u64), u32)>,
    stands: Stands,
    tasks: Tasks,
    /// The task log of a run whose first frame hasn't come yet.
    next_tasks: Option<(u64, Tasks)>,
    findings: Findings,
    run: Option<u64>,
    now: Now,
    began_secs: f64,
    report: Report,
    bodies: Vec<Body>,
    faults: Vec<Fault>,
    next_slow_check: f64,
}

impl Judge {
    /// Creates a judge that has seen nothing.
    pub fn new(settings: Settings) -> Self {
        Self {
            settings,
            site: Site::default(),
            types: Vec::new(),
            tracks: Vec::new(),
            contacts: Contacts::default(),
            placed: VecDeque::new(),
            stands: Stands::default(),
            tasks: Tasks::default(),
            next_tasks: None,
            findings: Findings::new(settings.examples),
            run: None,
            now: Now::default(),
            began_secs: 0.0,
            report: Report::default(),
            bodies: Vec::new(),
            faults: Vec::new(),
            next_slow_check: 0.0,
        }
    }

    /// Takes the route graph and the robot types, in place of those before.
    pub fn take_world(&mut self, world: &World<'_>) {
        self.site = Site::new(world);
        // The numbers of edges may mean others now.
        self.tracks.iter_mut().for_each(|track| track.before = None);
    }

    /// Takes the column `type`: the index of each robot's type.
    pub fn take_types(&mut self, types: &[f32]) {
        self.types.clear();
        self.types.extend(types.iter().map(|number| *number as u16));
    }

    /// Takes the events of a tick. Only those matter that tell of robots which join or leave, or
    /// are flat. `is_incomplete` says that events before them, or some of them, were lost.
    pub fn take_events(
        &mut self,
        header: &EventHeader,
        events: &[EventRecord],
        is_incomplete: bool,
    ) {
        let at = (header.run_id, header.tick);
        if is_incomplete || header.dropped > 0 {
            self.placed.push_back((at, ANY_ROBOT));
        }
        events
            .iter()
            .filter(|event| is_flat(event))
            .for_each(|event| self.find_flat(header.tick, event.robot));
        let is_placed = |event: &&EventRecord| {
            matches!(event.kind(), Some(EventKind::Spawned | EventKind::Removed))
        };
        self.placed.extend(events.iter().filter(is_placed).map(|event| (at, event.robot)));
    }

    /// Finds that a robot's battery is flat.
    fn find_flat(&mut self, tick: u64, robot: u32) {
        let before = self.tracks.get(robot as usize).and_then(|track| track.before);
        let seconds = tick as f64 * self.now.period;
        self.findings.add(Kind::FlatBattery, || Finding {
            robots: vec![robot],
            edge: before.and_then(|row| Some(self.site.edge(row.edge)?.record.id)),
            place: before.map(|row| [row.x, row.y]),
            ..Finding::at(tick, seconds)
        });
    }

    /// Forgets where robots were that have been placed anew by now. (Events can be there some
    /// frames before their tick's.)
    fn forget_placed(&mut self, run: u64, tick: u64) {
        let is_due = |((of, at), _): &mut ((u64, u64), u32)| *of != run || *at <= tick;
        while let Some((_, robot)) = self.placed.pop_front_if(is_due) {
            let all = robot == ANY_ROBOT;
            let tracks =
                if all { 0..self.tracks.len() } else { robot as usize..robot as usize + 1 };
            self.tracks.get_mut(tracks).into_iter().flatten().for_each(|track| track.before = None);
        }
    }

    /// Takes the task log's records of a tick, before or after the frame of that tick. `missed` is
    /// the number of samples that were lost before it.
    pub fn take_tasks(&mut self, header: &TaskHeader, missed: u64, records: &[TaskRecord]) {
        self.report.task_samples_missed += missed;
        let is_current = self.run == Some(header.run_id);
        let tasks = if is_current { &mut self.tasks } else { self.tasks_before_run(header.run_id) };
        tasks.take(header, records, missed > 0);
        if is_current && header.tick <= self.now.tick {
            self.judge_tasks();
        }
    }

    /// Returns the task log of a run that hasn't begun.
    fn tasks_before_run(&mut self, run: u64) -> &mut Tasks {
        let kept = self.next_tasks.take().filter(|(of, _)| *of == run);
        &mut self.next_tasks.insert(kept.unwrap_or((run, Tasks::default()))).1
    }

    /// Takes a frame.
    pub fn take_frame(&mut self, frame: &Frame<'_>) {
        let header = frame.header();
        let is_new_run = self.run != Some(frame.run_id()) || frame.tick() < self.now.tick;
        if is_new_run {
            self.begin_run(frame);
        } else if frame.tick() == self.now.tick && self.report.frames > 0 {
            return;
        }
        let ticks = frame.tick() - self.now.tick;
        let period = header.tick_period_nanos as f64 * 1e-9;
        let now = Now { tick: frame.tick(), seconds: header.sim_time_nanos as f64 * 1e-9, period };
        let seconds = if is_new_run { 0.0 } else { now.seconds - self.now.seconds };
        self.now = now;
        self.report.take_frame(frame, ticks);
        self.forget_placed(frame.run_id(), now.tick);
        self.judge_robots(frame, Gap { seconds, period }, ticks);
        self.judge_tasks();
        if now.seconds >= self.next_slow_check {
            self.next_slow_check = now.seconds + 1.0;
            self.judge_waiting(frame);
        }
    }

    fn begin_run(&mut self, frame: &Frame<'_>) {
        self.contacts.finish(&mut self.findings);
        self.report.runs += 1;
        self.report.tasks += self.tasks.len();
        let early = self.next_tasks.take_if(|(run, _)| *run == frame.run_id());
        self.tasks = early.map(|(_, tasks)| tasks).unwrap_or_default();
        self.tasks.has_gaps |= frame.tick() > 1;
        self.tracks.clear();
        self.stands = Stands::default();
        self.run = Some(frame.run_id());
        self.now = Now { tick: frame.tick(), ..Now::default() };
        self.began_secs = frame.header().sim_time_nanos as f64 * 1e-9;
        self.next_slow_check = self.began_secs;
    }

    fn judge_robots(&mut self, frame: &Frame<'_>, gap: Gap, ticks: u64) {
        self.tracks.resize(frame.len(), Track { idle_since: f64::INFINITY, ..Track::default() });
        self.stands.begin_frame(frame.len(), frame.tick(), ticks);
        self.bodies.clear();
        let columns = frame.columns();
        for robot in 0..frame.len() {
            let row = Row {
                x: columns.x[robot],
                y: columns.y[robot],
                theta: columns.theta[robot],
                speed: columns.speed[robot],
                s: columns.s[robot],
                edge: columns.edge[robot],
                state: RobotState::from_number(columns.state[robot]),
            };
            self.judge_robot(robot, &row, gap);
        }
        let edges = columns.edge;
        let site = &self.site;
        let edge = |robot: u32| {
            edges.get(robot as usize).and_then(|edge| Some(site.edge(*edge)?.record.id))
        };
        let numbers = [self.report.frames, self.now.tick];
        self.contacts.take(&self.bodies, numbers, [self.now.seconds, gap.seconds], edge);
    }

    fn judge_robot(&mut self, robot: usize, row: &Row, gap: Gap) {
        let track = &mut self.tracks[robot];
        if row.is_absent() {
            self.stands.take_absent(robot);
            *track = Track { idle_since: f64::INFINITY, ..Track::default() };
            return;
        }
        let robot_type =
            self.site.robot_type(self.types.get(robot).map_or(0, |index| usize::from(*index)));
        self.faults.clear();
        let (site, faults) = (&self.site, &mut self.faults);
        let before = track.before.take();
        if row.is_valid() {
            graph::check_place(site, row, faults);
            motion::check_speed(site, &robot_type, row, faults);
            if let Some(before) = before {
                motion::check_acceleration(&robot_type, &before, row, gap, faults);
                motion::check_rotation(&robot_type, &before, row, gap, faults);
                motion::check_teleport(site, &robot_type, &before, row, gap, faults);
                if !faults.iter().any(|fault| fault.kind == Kind::Teleport) {
                    let reach = motion::reach(site, &robot_type, gap);
                    graph::check_way(site, &before, row, reach, faults);
                }
            }
            track.before = Some(*row);
            self.stands.take(robot, self.now.tick, row);
            let is_circle = robot_type.shape() == Shape::Circle;
            let width = if is_circle { robot_type.length } else { robot_type.width };
            let half = [0.5 * robot_type.length, 0.5 * width];
            self.bodies.push(Body::new(robot as u32, [row.x, row.y, row.theta], half, is_circle));
        } else {
            self.stands.take_absent(robot);
            faults.push(Fault { kind: Kind::InvalidPose, value: 0.0, limit: 0.0 });
        }
        self.add_faults(robot, row);
    }

    /// Adds the faults of a robot that it didn't have in the frame before.
    fn add_faults(&mut self, robot: usize, row: &Row) {
        let active = self.faults.iter().fold(0, |bits, fault| bits | fault.kind.bit());
        for fault in &self.faults {
            if self.tracks[robot].active & fault.kind.bit() != 0 {
                continue;
            }
            let has_value = !fault.kind.unit().is_empty();
            self.findings.add(fault.kind, || Finding {
                robots: vec![robot as u32],
                edge: self.site.edge(row.edge).map(|edge| edge.record.id),
                place: row.is_valid().then_some([row.x, row.y]),
                value: has_value.then_some(fault.value),
                limit: has_value.then_some(fault.limit),
                ..Finding::at(self.now.tick, self.now.seconds)
            });
        }
        self.tracks[robot].active = active;
    }

    fn judge_tasks(&mut self) {
        let Self { tasks, stands, findings, site, now, .. } = self;
        let node = |id| site.node(id);
        tasks.judge(*now, &mut Context { stands, node: &node, findings });
    }

    /// Finds tasks that nobody serves, and robots that do nothing while tasks wait.
    fn judge_waiting(&mut self, frame: &Frame<'_>) {
        let (now, limit) = (self.now, self.settings.idle_after_secs);
        self.tasks.judge_waiting(now, self.settings.unserved_after_secs, &mut self.findings);
        let are_waiting = self.tasks.are_waiting();
        for (robot, track) in self.tracks.iter_mut().enumerate() {
            let Some(row) = track.before else { continue };
            let is_free =
                row.speed == 0.0 && matches!(row.state, RobotState::Idle | RobotState::Waiting);
            if !is_free || !are_waiting || self.tasks.has_task(robot as u32) {
                (track.idle_since, track.reported_idle) = (f64::INFINITY, false);
                continue;
            }
            track.idle_since = track.idle_since.min(now.seconds);
            let idle = now.seconds - track.idle_since;
            if idle > limit && !std::mem::replace(&mut track.reported_idle, true) {
                let edge = frame.edge()[robot];
                self.findings.add(Kind::Idle, || Finding {
                    robots: vec![robot as u32],
                    edge: (edge != NO_EDGE)
                        .then(|| self.site.edge(edge))
                        .flatten()
                        .map(|edge| edge.record.id),
                    place: Some([row.x, row.y]),
                    value: Some(idle),
                    limit: Some(limit),
                    ..Finding::at(now.tick, now.seconds)
                });
            }
        }
    }

    /// The number of pairs of robots that have touched in the run so far.
    pub fn contacts(&self) -> u64 {
        self.contacts.len()
    }

    /// Ends the judgement and returns its report.
    pub fn finish(mut self) -> Report {
        self.contacts.finish(&mut self.findings);
        self.report.tasks += self.tasks.len();
        self.report.seconds += self.now.seconds - self.began_secs;
        self.report.set_findings(&self.findings);
        self.report
    }
}

/// Whether an event tells that a robot stops because its battery is flat.
fn is_flat(event: &EventRecord) -> bool {
    event.kind() == Some(EventKind::BrokenDown)
        && event.detail == BreakdownCause::FlatBattery as u32
}

#[cfg(test)]
mod tests;
