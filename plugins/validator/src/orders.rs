//! Rules of orders: the order log is checked against itself and against the places of the robots.

use std::collections::{BTreeMap, VecDeque};

use regatta_plugin::order::{NO_ROBOT, Obstacle, OrderHeader, OrderKind, OrderRecord, StopAction};

use crate::findings::{Finding, Findings, Kind};
use crate::numbers::Numbers;
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
struct Order {
    /// Whether the log was read from the order's beginning.
    is_whole: bool,
    created_secs: f64,
    wanted_stops: u32,
    stops: Vec<Stop>,
    robot: Option<u32>,
    /// Whether it is unroutable: no robot can have it, free or not.
    is_unroutable: bool,
    handled: u32,
    loads: u32,
    /// The stop at which its robot is, and the tick of the arrival.
    arrived: Option<(u32, u64)>,
    reported_unserved: bool,
}

/// All orders of a run.
#[derive(Debug, Default)]
pub(crate) struct Orders {
    /// The open orders.
    orders: BTreeMap<u64, Order>,
    /// The orders that are over.
    closed: Numbers,
    /// The number of orders so far.
    count: u64,
    robots: BTreeMap<u32, u64>,
    /// Records that came before the frame of their tick.
    early: VecDeque<(u64, OrderRecord)>,
    /// Whether records are missing: then an order may have begun or continued unseen.
    pub has_gaps: bool,
    /// Whether a sample of the log has come.
    has_begun: bool,
    /// The number of the last sample, which begins anew with each manager.
    sequence: u64,
    /// Open orders without a robot that a robot could have.
    waiting: u64,
    /// Robots that got an order, came to a stop or handled one since they were asked for.
    progress: Vec<u32>,
    /// No order that is open and hasn't been reported as unserved was created before this time, in
    /// seconds.
    oldest_secs: f64,
}

/// A record under judgement, and all that it is checked against.
struct Check<'a> {
    at: Now,
    record: &'a OrderRecord,
    world: &'a WorldModel,
    stands: &'a Stands,
    findings: &'a mut Findings,
}

impl Orders {
    /// Takes the records of a tick. `is_incomplete` means that samples before them are missing.
    pub fn take(&mut self, header: &OrderHeader, records: &[OrderRecord], is_incomplete: bool) {
        // Samples published before the judge joined the log don't count as missing, but are
        // unknown.
        let joined_late = !std::mem::replace(&mut self.has_begun, true) && header.sequence > 1;
        // A manager that was killed may have done more than it told, which the next one knows from
        // its store.
        let is_of_next_manager = header.sequence > 0 && header.sequence <= self.sequence;
        self.sequence = header.sequence;
        if is_incomplete || joined_late || is_of_next_manager || header.dropped > 0 {
            self.has_gaps = true;
            for order in self.orders.values_mut() {
                order.is_whole = false;
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
        let (number, created_secs) = (check.record.order, check.at.seconds);
        let Some(kind) = check.record.kind() else {
            return check.report(Kind::ContradictoryRecords, "a record of an unknown kind");
        };
        if kind == OrderKind::Created {
            return self.create(check);
        }
        if self.closed.contains(number) {
            return check.report(Kind::DoneTwice, "a record after the order's end");
        }
        if !self.orders.contains_key(&number) {
            if !self.has_gaps {
                check
                    .report(Kind::ContradictoryRecords, "a record of an order that wasn't created");
            }
            self.add(number, Order { created_secs, ..Order::default() });
        }
        if matches!(
            kind,
            OrderKind::Assigned | OrderKind::Queued | OrderKind::Arrived | OrderKind::Handled
        ) {
            self.progress.push(check.record.robot);
        }
        match kind {
            OrderKind::Unroutable => self.set_unroutable(number, true),
            OrderKind::Reopened | OrderKind::Assigned => self.set_unroutable(number, false),
            _ => {}
        }
        match kind {
            OrderKind::Created => {}
            OrderKind::Stop => self.stop(check),
            OrderKind::Assigned => self.assign(check),
            OrderKind::Withdrawn => self.withdraw(check),
            OrderKind::Arrived => self.arrive(check),
            OrderKind::Handled => self.handle(check),
            OrderKind::Finished => self.finish(check),
            OrderKind::Failed | OrderKind::Cancelled => self.close(number),
            OrderKind::Unroutable => match check.record.obstacle() {
                Obstacle::ClosedEdges | Obstacle::NoPlace => {}
                obstacle => check.report(Kind::Unroutable, obstacle.text()),
            },
            OrderKind::Reopened | OrderKind::Queued => {}
        }
    }

    fn create(&mut self, check: &mut Check<'_>) {
        let &OrderRecord { order: number, detail: wanted_stops, .. } = check.record;
        if self.orders.contains_key(&number) || self.closed.contains(number) {
            return check.report(Kind::ContradictoryRecords, "created twice");
        }
        let (is_whole, created_secs) = (true, check.at.seconds);
        self.add(number, Order { is_whole, wanted_stops, created_secs, ..Order::default() });
    }

    /// Adds an order, which waits for a robot.
    fn add(&mut self, number: u64, order: Order) {
        self.oldest_secs = self.oldest_secs.min(order.created_secs);
        self.orders.insert(number, order);
        self.count += 1;
        self.waiting += 1;
    }

    /// Sets whether an order without a robot is unroutable.
    fn set_unroutable(&mut self, number: u64, is_unroutable: bool) {
        let order = self.orders.get_mut(&number).filter(|order| order.robot.is_none());
        let Some(order) = order else { return };
        match (std::mem::replace(&mut order.is_unroutable, is_unroutable), is_unroutable) {
            (false, true) => self.waiting -= 1,
            (true, false) => self.waiting += 1,
            _ => {}
        }
    }

    fn stop(&mut self, check: &mut Check<'_>) {
        let record = check.record;
        let Some(order) = self.orders.get_mut(&record.order) else { return };
        let is_next = record.stop as usize == order.stops.len() && record.stop < order.wanted_stops;
        if order.is_whole && (!is_next || order.robot.is_some()) {
            check.report(
                Kind::ContradictoryRecords,
                "a stop that isn't the next one of a new order",
            );
        }
        let (node, action, dwell_secs) = (record.node, record.action(), record.dwell_secs);
        order.stops.push(Stop { node, action, dwell_secs });
    }

    fn assign(&mut self, check: &mut Check<'_>) {
        let &OrderRecord { order: number, robot, .. } = check.record;
        let Some(order) = self.orders.get_mut(&number) else { return };
        if order.is_whole && order.stops.len() != order.wanted_stops as usize {
            check.report(
                Kind::ContradictoryRecords,
                "assigned before all of its stops were recorded",
            );
        }
        if order.is_whole && order.robot.is_some() {
            check.report(Kind::ContradictoryRecords, "assigned although it has a robot");
        }
        if robot == NO_ROBOT {
            return check.report(Kind::ContradictoryRecords, "assigned to no robot");
        }
        if let Some(before) = order.robot.replace(robot) {
            self.robots.remove(&before);
        } else {
            self.waiting -= 1;
        }
        let other = self.robots.insert(robot, number).filter(|other| *other != number);
        if other.and_then(|other| self.orders.get(&other)).is_some_and(|other| other.is_whole) {
            check.report(Kind::TwoOrders, "assigned to a robot that has another order");
        }
    }

    fn withdraw(&mut self, check: &mut Check<'_>) {
        let Some(order) = self.orders.get_mut(&check.record.order) else { return };
        if order.is_whole && order.robot != Some(check.record.robot) {
            check.report(Kind::ContradictoryRecords, "withdrawn from a robot that doesn't have it");
        } else if order.is_whole && order.loads > 0 {
            check.report(Kind::ContradictoryRecords, "withdrawn after the pick");
        }
        (order.handled, order.arrived) = (0, None);
        if let Some(robot) = order.robot.take() {
            self.waiting += 1;
            self.robots.remove(&robot);
        }
    }

    fn arrive(&mut self, check: &mut Check<'_>) {
        let Some(order) = self.orders.get_mut(&check.record.order) else { return };
        if order.is_whole {
            check.stop(order);
            check.turn(order);
            if order.arrived.is_some() {
                check.report(
                    Kind::ContradictoryRecords,
                    "arrived at a stop before the last one was handled",
                );
            }
        }
        check.presence();
        order.arrived = Some((check.record.stop, check.at.tick));
    }

    fn handle(&mut self, check: &mut Check<'_>) {
        let record = check.record;
        let Some(order) = self.orders.get_mut(&record.order) else { return };
        let arrived = order.arrived.take().filter(|(stop, _)| *stop == record.stop);
        if order.is_whole {
            check.stop(order);
            if let Some((_, since)) = arrived {
                check.dwell(order, since);
            } else {
                check.report(Kind::ContradictoryRecords, "handled without an arrival");
                check.turn(order);
            }
        }
        check.presence();
        match order.stops.get(record.stop as usize).map_or(record.action(), |stop| stop.action) {
            StopAction::Pick => order.loads += 1,
            StopAction::Drop if order.loads == 0 && order.is_whole => {
                check.report(Kind::DropWithoutPick, "");
            }
            StopAction::Drop => order.loads = order.loads.saturating_sub(1),
            _ => {}
        }
        order.handled = order.handled.max(record.stop + 1);
    }

    fn finish(&mut self, check: &mut Check<'_>) {
        let Some(order) = self.orders.get(&check.record.order) else { return };
        if order.is_whole && order.handled < order.wanted_stops {
            check.report(Kind::SkippedStop, "finished before all of its stops were handled");
        }
        if order.is_whole && order.robot.is_none() {
            check.report(Kind::ContradictoryRecords, "finished without a robot");
        }
        self.close(check.record.order);
    }

    fn close(&mut self, number: u64) {
        let Some(order) = self.orders.remove(&number) else { return };
        match order.robot {
            Some(robot) if self.robots.get(&robot) == Some(&number) => {
                self.robots.remove(&robot);
            }
            Some(_) => {}
            None if order.is_unroutable => {}
            None => self.waiting -= 1,
        }
        self.closed.add(number);
    }

    /// Finds orders that have been open for longer than `after_secs`.
    pub fn judge_waiting(&mut self, now: Now, after_secs: f64, findings: &mut Findings) {
        if now.seconds - self.oldest_secs <= after_secs {
            return;
        }
        self.oldest_secs = f64::INFINITY;
        for (number, order) in &mut self.orders {
            if order.reported_unserved {
                continue;
            }
            let age = now.seconds - order.created_secs;
            if age <= after_secs {
                self.oldest_secs = self.oldest_secs.min(order.created_secs);
                continue;
            }
            order.reported_unserved = true;
            findings.add(Kind::Unserved, || Finding {
                order: Some(*number),
                robots: order.robot.into_iter().collect(),
                value: Some(age),
                limit: Some(after_secs),
                note: if order.robot.is_some() { "under way" } else { "no robot has it" }.into(),
                ..Finding::at(now.tick, now.seconds)
            });
        }
    }

    /// Returns the robots that got an order, came to a stop or handled one since the last call.
    pub fn take_progress(&mut self) -> Vec<u32> {
        std::mem::take(&mut self.progress)
    }

    /// Returns the robots with orders, and whether they are at a stop.
    pub fn of_robots(&self) -> impl Iterator<Item = (u32, bool)> + '_ {
        self.robots.iter().map(|(robot, number)| {
            let order = self.orders.get(number);
            (*robot, order.is_some_and(|order| order.arrived.is_some()))
        })
    }

    /// Whether orders wait for a robot.
    pub fn are_waiting(&self) -> bool {
        self.waiting > 0
    }

    pub fn has_order(&self, robot: u32) -> bool {
        self.robots.contains_key(&robot)
    }

    pub fn len(&self) -> u64 {
        self.count
    }
}

impl Check<'_> {
    /// Checks that the record is of its order's robot, and of the node of its stop.
    fn stop(&mut self, order: &Order) {
        if order.robot != Some(self.record.robot) {
            self.report(Kind::ContradictoryRecords, "a robot that doesn't have the order");
        }
        match order.stops.get(self.record.stop as usize) {
            Some(stop) if stop.node != self.record.node => {
                self.report(Kind::WrongPlace, "not the stop's node");
            }
            Some(_) => {}
            None => self.report(Kind::ContradictoryRecords, "a stop that the order doesn't have"),
        }
    }

    /// Checks that the stop is its order's next one.
    fn turn(&mut self, order: &Order) {
        if self.record.stop > order.handled {
            self.report(Kind::SkippedStop, "a later stop than the next one");
        } else if self.record.stop < order.handled {
            self.report(Kind::DoneTwice, "a stop that was handled before");
        }
    }

    /// Checks that the robot stood at the stop for its dwell time.
    fn dwell(&mut self, order: &Order, since: u64) {
        let Now { tick, period, .. } = self.at;
        let stop = order.stops.get(self.record.stop as usize);
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
        self.add(kind, |finding| Finding { note: note.into(), ..finding });
    }

    /// Adds a finding about the record, with the details that `complete` fills in.
    fn add(&mut self, kind: Kind, complete: impl FnOnce(Finding) -> Finding) {
        let (at, record) = (self.at, self.record);
        self.findings.add(kind, || {
            let robots = Some(record.robot).filter(|robot| *robot != NO_ROBOT);
            complete(Finding {
                robots: robots.into_iter().collect(),
                order: Some(record.order),
                ..Finding::at(at.tick, at.seconds)
            })
        });
    }
}

#[cfg(test)]
mod tests;
