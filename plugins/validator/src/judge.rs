//! The judge: world, frames, events and orders in, findings out. It doesn't know processes or
//! files.

use std::collections::VecDeque;

use glam::Vec2;
use regatta_plugin::activity::Activity;
use regatta_plugin::column::ACTIVITY;
use regatta_plugin::event::{BreakdownCause, EventHeader, EventKind, EventRecord};
use regatta_plugin::frame::RobotState;
use regatta_plugin::order::{OrderHeader, OrderRecord};
use regatta_plugin::{Frame, World};

use crate::contacts::{Body, Contacts};
use crate::findings::{Finding, Findings, Kind};
use crate::motion::{Fault, Gap, Move, Row};
use crate::orders::{Now, Orders};
use crate::progress::{Limits, Progress};
use crate::report::Report;
use crate::stands::Stands;
use crate::world_model::WorldModel;
use crate::zones::Zones;
use crate::{graph, motion};

/// The times that orders and robots may wait, and the number of examples in the report.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Seconds after which an order that isn't finished is a finding.
    pub unserved_after_secs: f64,
    /// Seconds after which a robot that is idle while orders wait is a finding.
    pub idle_after_secs: f64,
    /// Seconds after which it is a finding that all robots with orders stand.
    pub standstill_after_secs: f64,
    /// Seconds after which a robot that stands with an order is a finding, or robots that drive
    /// without coming to a stop.
    pub stuck_after_secs: f64,
    /// The number of examples of each kind.
    pub examples: usize,
}

impl Settings {
    fn progress_limits(&self) -> Limits {
        Limits { standstill_secs: self.standstill_after_secs, stuck_secs: self.stuck_after_secs }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            unserved_after_secs: 1200.0,
            idle_after_secs: 1200.0,
            standstill_after_secs: 300.0,
            stuck_after_secs: 600.0,
            examples: 10,
        }
    }
}

/// The robots that joined or left in a tick of a run.
#[derive(Clone, Copy, Debug)]
struct Placed {
    run_id: u64,
    tick: u64,
    /// `None` if events were lost, so that it may be any.
    robot: Option<u32>,
}

/// The state that the judge keeps of a robot.
#[derive(Clone, Copy, Debug)]
struct Track {
    /// `None` if it was absent or invalid, or was spawned since.
    before: Option<Row>,
    /// The kinds of faults in the last frame, as bits: a fault that lasts counts once.
    active: u32,
    /// Time in seconds since which it has been idle while orders waited; infinite if it isn't.
    idle_since: f64,
    reported_idle: bool,
}

impl Track {
    const NEW: Self =
        Self { before: None, active: 0, idle_since: f64::INFINITY, reported_idle: false };
}

/// Judges one fleet. Feed it everything in the order of time: the world, then for each tick its
/// events, orders and frame.
#[derive(Debug)]
pub struct Judge {
    settings: Settings,
    world: WorldModel,
    types: Vec<u16>,
    /// The last sample of the column `activity`; empty before the first one.
    activities: Vec<f32>,
    tracks: Vec<Track>,
    contacts: Contacts,
    zones: Zones,
    /// In the order of time.
    placed: VecDeque<Placed>,
    stands: Stands,
    orders: Orders,
    progress: Progress,
    /// The order log of a run whose first frame hasn't come yet.
    next_orders: Option<(u64, Orders)>,
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
            world: WorldModel::new(&World::default()),
            types: Vec::new(),
            activities: Vec::new(),
            tracks: Vec::new(),
            contacts: Contacts::default(),
            zones: Zones::default(),
            placed: VecDeque::new(),
            stands: Stands::default(),
            orders: Orders::default(),
            progress: Progress::default(),
            next_orders: None,
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
        self.world = WorldModel::new(world);
        self.zones = Zones::default();
        // The indices of edges may have changed.
        self.forget_places();
    }

    /// Takes the column `type`: the index of each robot's type.
    pub fn take_types(&mut self, types: &[f32]) {
        self.types.clear();
        self.types.extend(types.iter().map(|number| *number as u16));
    }

    /// Takes the column `activity`, by which robots that charge are known.
    pub fn take_activities(&mut self, activities: &[f32]) {
        self.activities.clear();
        self.activities.extend_from_slice(activities);
    }

    /// Takes the events of a tick. Only events of robots that join, leave or have a flat battery
    /// matter. `is_incomplete` means that events were lost.
    pub fn take_events(
        &mut self,
        header: &EventHeader,
        events: &[EventRecord],
        is_incomplete: bool,
    ) {
        let &EventHeader { run_id, tick, .. } = header;
        if is_incomplete || header.dropped > 0 {
            self.placed.push_back(Placed { run_id, tick, robot: None });
        }
        for event in events {
            match event.kind() {
                Some(EventKind::Spawned | EventKind::Removed) => {
                    self.placed.push_back(Placed { run_id, tick, robot: Some(event.robot) });
                }
                Some(EventKind::BrokenDown)
                    if event.detail == BreakdownCause::FlatBattery as u32 =>
                {
                    self.find_flat(tick, event.robot);
                }
                _ => {}
            }
        }
    }

    /// Adds the finding of a flat battery.
    fn find_flat(&mut self, tick: u64, robot: u32) {
        let before = self.tracks.get(robot as usize).and_then(|track| track.before);
        let seconds = tick as f64 * self.now.period;
        self.findings.add(Kind::FlatBattery, || Finding {
            robots: vec![robot],
            edge: before.and_then(|row| self.world.edge_id(row.edge)),
            place: before.map(|row| row.position.into()),
            ..Finding::at(tick, seconds)
        });
    }

    /// Forgets the places of robots that have joined or left by now. Events may arrive some frames
    /// before that of their tick.
    fn forget_placed(&mut self, run_id: u64, tick: u64) {
        while let Some(placed) =
            self.placed.pop_front_if(|placed| placed.run_id != run_id || placed.tick <= tick)
        {
            match placed.robot {
                None => self.forget_places(),
                Some(robot) => {
                    if let Some(track) = self.tracks.get_mut(robot as usize) {
                        track.before = None;
                    }
                }
            }
        }
    }

    fn forget_places(&mut self) {
        for track in &mut self.tracks {
            track.before = None;
        }
    }

    /// Takes the order log's records of a tick, before or after the frame of that tick. `missed` is
    /// the number of samples that were lost before it.
    pub fn take_orders(&mut self, header: &OrderHeader, missed: u64, records: &[OrderRecord]) {
        self.report.order_samples_missed += missed;
        let is_current = self.run == Some(header.run_id);
        let orders =
            if is_current { &mut self.orders } else { self.orders_before_run(header.run_id) };
        orders.take(header, records, missed > 0);
        if is_current && header.tick <= self.now.tick {
            self.judge_orders();
        }
    }

    /// Returns the order log of a run that hasn't begun.
    fn orders_before_run(&mut self, run: u64) -> &mut Orders {
        let kept = self.next_orders.take().filter(|(of, _)| *of == run);
        &mut self.next_orders.insert(kept.unwrap_or((run, Orders::default()))).1
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
        self.judge_robots(frame, Gap { seconds, period });
        self.judge_orders();
        if now.seconds >= self.next_slow_check {
            self.next_slow_check = now.seconds + 1.0;
            self.judge_waiting(frame);
            self.judge_progress();
        }
    }

    fn begin_run(&mut self, frame: &Frame<'_>) {
        self.contacts.finish(&mut self.findings);
        self.report.runs += 1;
        self.report.orders += self.orders.len();
        let early = self.next_orders.take_if(|(run, _)| *run == frame.run_id());
        self.orders = early.map(|(_, orders)| orders).unwrap_or_default();
        self.orders.has_gaps |= frame.tick() > 1;
        self.tracks.clear();
        self.stands = Stands::default();
        self.zones = Zones::default();
        self.progress = Progress::default();
        self.run = Some(frame.run_id());
        self.now = Now { tick: frame.tick(), ..Now::default() };
        self.began_secs = frame.header().sim_time_nanos as f64 * 1e-9;
        self.next_slow_check = self.began_secs;
    }

    fn judge_robots(&mut self, frame: &Frame<'_>, gap: Gap) {
        self.tracks.resize(frame.len(), Track::NEW);
        self.stands.begin_frame(frame.len(), frame.tick());
        self.bodies.clear();
        self.zones.begin_frame(&self.world);
        let columns = frame.columns();
        for robot in 0..frame.len() {
            let row = Row {
                position: Vec2::new(columns.x[robot], columns.y[robot]),
                theta: columns.theta[robot],
                speed: columns.speed[robot],
                s: columns.s[robot],
                edge: columns.edge[robot],
                state: RobotState::from_number(columns.state[robot]),
            };
            self.judge_robot(robot, &row, gap);
        }
        self.zones.judge(&self.world, self.now, &mut self.findings);
        let world = &self.world;
        self.contacts.take(&self.bodies, self.report.frames, self.now, gap.seconds, |robot| {
            world.edge_id(*columns.edge.get(robot as usize)?)
        });
    }

    fn judge_robot(&mut self, robot: usize, row: &Row, gap: Gap) {
        let track = &mut self.tracks[robot];
        if row.is_absent() {
            self.stands.take_absent(robot);
            *track = Track::NEW;
            return;
        }
        let robot_type =
            self.world.robot_type(self.types.get(robot).map_or(0, |index| usize::from(*index)));
        let mut lasting = 0;
        self.faults.clear();
        let (world, faults) = (&self.world, &mut self.faults);
        let before = track.before.take();
        if row.is_valid() {
            let is_same = before.as_ref() == Some(row);
            if is_same {
                // It stands where it stood, and has the faults that it had there.
                lasting = track.active & Kind::OF_PLACE;
            } else {
                graph::check_place(world, row, faults);
            }
            // A robot that stands where it stood breaks no rule of motion.
            if !is_same || row.speed != 0.0 {
                motion::check_speed(world, &robot_type.record, row, faults);
                if let Some(before) = &before {
                    let robot_type = &robot_type.record;
                    let moved = Move { world, robot_type, before, now: row, gap };
                    moved.check(faults);
                }
            }
            track.before = Some(*row);
            self.stands.take(robot, row);
            self.zones.take(world, robot as u32, row);
            self.bodies.push(robot_type.body(robot as u32, row, world.level(row)));
        } else {
            self.stands.take_absent(robot);
            faults.push(Fault { kind: Kind::InvalidPose, value: 0.0, limit: 0.0 });
        }
        self.add_faults(robot, row, lasting);
    }

    /// Adds the new faults of a robot. `lasting` has those that are known to last, as bits.
    fn add_faults(&mut self, robot: usize, row: &Row, lasting: u32) {
        let active = self.faults.iter().fold(lasting, |bits, fault| bits | fault.kind.bit());
        for fault in &self.faults {
            if self.tracks[robot].active & fault.kind.bit() != 0 {
                continue;
            }
            let has_value = !fault.kind.unit().is_empty();
            self.findings.add(fault.kind, || Finding {
                robots: vec![robot as u32],
                edge: self.world.edge_id(row.edge),
                place: row.is_valid().then_some(row.position.into()),
                value: has_value.then_some(fault.value),
                limit: has_value.then_some(fault.limit),
                ..Finding::at(self.now.tick, self.now.seconds)
            });
        }
        self.tracks[robot].active = active;
    }

    fn judge_orders(&mut self) {
        self.orders.judge(self.now, &self.world, &self.stands, &mut self.findings);
    }

    /// Finds robots with orders that don't drive, or don't come to their stops.
    fn judge_progress(&mut self) {
        let limits = self.settings.progress_limits();
        self.progress.begin(self.tracks.len());
        for robot in self.orders.take_progress() {
            self.progress.take_progress(robot);
        }
        for (robot, is_at_stop) in self.orders.of_robots() {
            let track = self.tracks.get(robot as usize);
            if let Some(row) = track.and_then(|track| track.before) {
                self.progress.take(robot, &row, is_at_stop, self.now);
            }
        }
        self.progress.judge(self.now, limits, &self.world, &mut self.findings);
    }

    /// Finds unserved orders, and robots that are idle while orders wait. One that charges isn't.
    fn judge_waiting(&mut self, frame: &Frame<'_>) {
        let (now, limit) = (self.now, self.settings.idle_after_secs);
        self.orders.judge_waiting(now, self.settings.unserved_after_secs, &mut self.findings);
        let are_waiting = self.orders.are_waiting();
        for (robot, track) in self.tracks.iter_mut().enumerate() {
            let Some(row) = track.before else { continue };
            let is_free =
                row.speed == 0.0 && matches!(row.state, RobotState::Idle | RobotState::Waiting);
            let activity = self.activities.get(robot).and_then(|value| ACTIVITY.element(*value));
            let is_free = is_free && activity != Some(Activity::Charging);
            if !is_free || !are_waiting || self.orders.has_order(robot as u32) {
                (track.idle_since, track.reported_idle) = (f64::INFINITY, false);
                continue;
            }
            track.idle_since = track.idle_since.min(now.seconds);
            let idle = now.seconds - track.idle_since;
            if idle > limit && !std::mem::replace(&mut track.reported_idle, true) {
                self.findings.add(Kind::Idle, || Finding {
                    robots: vec![robot as u32],
                    edge: self.world.edge_id(frame.edge()[robot]),
                    place: Some(row.position.into()),
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

    /// The number of times so far in which robots with orders made no progress.
    pub fn stalls(&self) -> u64 {
        let kinds = [Kind::Standstill, Kind::Livelock, Kind::Stuck];
        kinds.map(|kind| self.findings.count(kind)).iter().sum()
    }

    /// Ends the judgement and returns its report.
    pub fn finish(mut self) -> Report {
        self.contacts.finish(&mut self.findings);
        let limits = self.settings.progress_limits();
        self.progress.finish(self.now, limits, &self.world, &mut self.findings);
        self.report.orders += self.orders.len();
        self.report.seconds += self.now.seconds - self.began_secs;
        self.report.set_findings(&self.findings);
        self.report
    }
}

#[cfg(test)]
mod tests;
