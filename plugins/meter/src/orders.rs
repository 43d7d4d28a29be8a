//! The orders of a run, from the order log.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::RangeInclusive;

use regatta_plugin::order::{Obstacle, OrderKind, OrderRecord, StopAction};
use serde::{Deserialize, Serialize};

use crate::time::{OrderClock, Parts, Phase};

/// A finished order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
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
    /// The parts of its time, in ticks.
    #[serde(default)]
    pub parts: Parts,
    /// The ids of the nodes of its first and its last stop.
    #[serde(default)]
    pub ends: [u32; 2],
}

/// The waiting at a stop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct StopWait {
    /// The id of the stop's node.
    pub node: u32,
    /// Ticks of robots that were there and waited to be served.
    pub station: u64,
    /// Ticks of robots in the queue before it, the way from there included.
    pub queue: u64,
    /// Ticks of robots that were served.
    pub handling: u64,
}

/// The present tick and its simulated time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Now {
    /// The tick.
    pub tick: u64,
    /// The simulated time, in seconds.
    pub secs: f64,
}

impl Now {
    /// Returns the tick after some seconds from now.
    fn tick_after(self, secs: f64) -> u64 {
        let ticks = secs * self.tick as f64 / self.secs;
        self.tick.saturating_add(ticks.round() as u64)
    }
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
    /// Whether no robot of the fleet can carry it out as things are. An order that waits for a
    /// place of a storage isn't counted here.
    #[serde(default)]
    pub is_unroutable: bool,
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
    /// Its robot is at a stop, where it is served from this tick on.
    served_from: Option<u64>,
    /// Whether its robot is in the queue before a stop.
    is_queued: bool,
    /// The tick since which its robot is in the queue, and then at the stop.
    there_since: u64,
    clock: OrderClock,
    /// The ids of the nodes of its first and its last stop.
    ends: Option<[u32; 2]>,
    /// The storage that has no place for it.
    lack: Option<Lack>,
    /// Whether no robot can carry it out as things are.
    is_unroutable: bool,
}

/// A storage that has no place for some orders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Lack {
    /// The id of the node of its first place.
    pub node: u32,
    /// Whether it is full, and the orders have loads for it; otherwise it is empty.
    pub is_full: bool,
}

/// Orders that still wait for a place of a storage at the end of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Unplaced {
    /// The storage.
    pub lack: Lack,
    /// The number of orders.
    pub orders: u64,
    /// The simulated time since which the oldest of them has been open, in seconds.
    pub since_secs: f64,
}

impl Open {
    fn new(record: &OrderRecord, now: Now) -> Self {
        Self {
            created_secs: now.secs,
            due_secs: (record.due_secs != 0.0).then(|| rounded(record.due_secs.into())),
            stops: record.detail,
            robot: None,
            loads: 0,
            served_from: None,
            is_queued: false,
            there_since: now.tick,
            clock: OrderClock::new(now.tick),
            ends: None,
            lack: None,
            is_unroutable: false,
        }
    }

    fn finished(&mut self, now: Now) -> Finished {
        Finished {
            at_secs: rounded(now.secs),
            service_secs: rounded(now.secs - self.created_secs),
            stops: self.stops,
            due_secs: self.due_secs,
            parts: self.clock.stop_at(now.tick),
            ends: self.ends.unwrap_or_default(),
        }
    }

    /// Turns to the phase of a tick.
    fn turn(&mut self, hindrance: Hindrance, tick: u64) {
        self.begin_service(tick);
        let phase = self.phase(hindrance, tick);
        self.clock.turn(phase, tick);
    }

    /// Ends the wait at a stop if the service there has begun up to a tick.
    fn begin_service(&mut self, tick: u64) {
        if let Some(served_from) = self.served_from.filter(|served_from| *served_from <= tick) {
            self.clock.end(Phase::Station, Phase::Handling, served_from);
        }
    }

    /// The phase of an order at a tick, whose robot has a hindrance.
    fn phase(&self, hindrance: Hindrance, tick: u64) -> Phase {
        match (self.robot, self.served_from) {
            (None, _) if self.lack.is_some() => Phase::Storage,
            (None, _) => Phase::Assignment,
            _ if hindrance == Hindrance::Down => Phase::Down,
            (_, Some(served_from)) if tick < served_from => Phase::Station,
            (_, Some(_)) => Phase::Handling,
            _ if hindrance == Hindrance::Traffic && self.is_queued => Phase::Station,
            _ if hindrance == Hindrance::Traffic => Phase::Traffic,
            _ if self.loads > 0 => Phase::Loaded,
            _ => Phase::Empty,
        }
    }
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
    /// The tick from which on it is served at the stop to which it came last.
    pub served_from: u64,
    /// Whether it is in the queue before a stop.
    pub is_queued: bool,
}

/// The reason for which a robot doesn't go on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Hindrance {
    /// Nothing.
    #[default]
    None,
    /// It waits for room, a route, a door or a lift.
    Traffic,
    /// It is held, broken, faulted or stalled.
    Down,
}

/// A robot that has had an order.
#[derive(Clone, Copy, Debug, Default)]
pub struct Robot {
    /// Its present work.
    pub work: RobotWork,
    /// Its hindrance in the last frame.
    pub hindrance: Hindrance,
}

/// All orders so far.
#[derive(Clone, Debug, Default)]
pub struct Orders {
    open: BTreeMap<u64, Open>,
    robots: BTreeMap<u32, Robot>,
    /// The open orders that have a robot, by robot.
    assigned: BTreeSet<(u32, u64)>,
    /// In the order in which they were finished.
    pub finished: Vec<Finished>,
    /// Orders that were given up.
    pub failed: u64,
    /// Orders that were cancelled.
    pub cancelled: u64,
    /// The waiting at stops, by node.
    waits: BTreeMap<u32, StopWait>,
}

impl Orders {
    /// Takes a record of a tick. Records of unknown orders and kinds are left out.
    pub fn take(&mut self, record: &OrderRecord, now: Now) {
        let Some(kind) = record.kind() else { return };
        if kind == OrderKind::Created {
            self.open.insert(record.order, Open::new(record, now));
            return;
        }
        self.take_change(kind, record, now);
        if let Some(open) = self.open.get_mut(&record.order) {
            let robot = open.robot.and_then(|robot| self.robots.get(&robot));
            let phase = open.phase(robot.map_or(Hindrance::None, |it| it.hindrance), now.tick);
            open.clock.begin(phase, now.tick);
        }
    }

    fn take_change(&mut self, kind: OrderKind, record: &OrderRecord, now: Now) {
        let Some(open) = self.open.get_mut(&record.order) else { return };
        match kind {
            OrderKind::Assigned => {
                let (before, loads) = (open.robot.replace(record.robot), open.loads);
                if let Some(before) = before {
                    self.assigned.remove(&(before, record.order));
                    self.add(before, -1, -loads);
                }
                self.assigned.insert((record.robot, record.order));
                self.add(record.robot, 1, loads);
            }
            OrderKind::Withdrawn => self.release(record.order),
            OrderKind::Queued => {
                if !std::mem::replace(&mut open.is_queued, true) {
                    open.there_since = now.tick;
                }
                self.robots.entry(record.robot).or_default().work.is_queued = true;
            }
            OrderKind::Arrived => {
                let wait = wait_at(&mut self.waits, record.node);
                if std::mem::take(&mut open.is_queued) {
                    wait.queue += now.tick.saturating_sub(open.there_since);
                }
                open.there_since = now.tick;
                let served_from = now.tick_after(record.dwell_secs.into());
                let work = &mut self.robots.entry(record.robot).or_default().work;
                work.at_stops += i32::from(open.served_from.replace(served_from).is_none());
                work.served_from = served_from;
                work.is_queued = false;
            }
            OrderKind::Handled => {
                open.begin_service(now.tick);
                if let Some(served_from) = open.served_from.take() {
                    let begin = served_from.clamp(open.there_since, now.tick.max(open.there_since));
                    let wait = wait_at(&mut self.waits, record.node);
                    wait.station += begin - open.there_since;
                    wait.handling += now.tick.saturating_sub(begin);
                    self.robots.entry(record.robot).or_default().work.at_stops -= 1;
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
                self.finished.push(open.finished(now));
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
            OrderKind::Stop => {
                let [first, _] = open.ends.unwrap_or([record.node; 2]);
                open.ends = Some([first, record.node]);
            }
            OrderKind::Unroutable if record.obstacle() == Obstacle::NoPlace => {
                let is_full = record.action() == StopAction::Drop;
                open.lack = Some(Lack { node: record.node, is_full });
            }
            OrderKind::Unroutable => open.is_unroutable = true,
            OrderKind::Reopened => {
                open.lack = None;
                open.is_unroutable = false;
            }
            OrderKind::Created => {}
        }
    }

    /// Returns the waiting at stops, by ascending node: of stops that are over.
    pub fn waits(&self) -> Vec<StopWait> {
        self.waits.values().copied().collect()
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
            is_unroutable: open.is_unroutable,
        })
        .collect()
    }

    /// Returns the orders that wait for a place of a storage, by storage.
    pub fn unplaced(&self) -> Vec<Unplaced> {
        let mut by_lack: BTreeMap<Lack, Unplaced> = BTreeMap::new();
        for open in self.open.values() {
            let Some(lack) = open.lack else { continue };
            let since_secs = rounded(open.created_secs);
            let found = by_lack.entry(lack).or_insert(Unplaced { lack, orders: 0, since_secs });
            found.orders += 1;
            found.since_secs = found.since_secs.min(since_secs);
        }
        by_lack.into_values().collect()
    }

    /// Sets the hindrance of a robot in a frame, which stands for the time since the tick of the
    /// frame before. The time of its orders is counted only where that changes.
    pub fn hinder(&mut self, robot: u32, hindrance: Hindrance, since_tick: u64) {
        self.robots.entry(robot).or_default().hindrance = hindrance;
        for (_, order) in self.assigned.range(orders_of(robot)) {
            if let Some(open) = self.open.get_mut(order) {
                open.turn(hindrance, since_tick);
            }
        }
    }

    /// Returns a function of robots in ascending order that returns each. To search for each robot
    /// would take longer.
    pub fn robots_in_turn(&self) -> impl FnMut(u32) -> Robot {
        let mut robots = self.robots.iter().peekable();
        move |robot| {
            while robots.next_if(|(other, _)| **other < robot).is_some() {}
            let found = robots.next_if(|(other, _)| **other == robot);
            found.map_or_else(Robot::default, |(_, robot)| *robot)
        }
    }

    fn work_mut(&mut self, robot: u32) -> &mut RobotWork {
        &mut self.robots.entry(robot).or_default().work
    }

    fn release(&mut self, order: u64) {
        let Some(open) = self.open.get_mut(&order) else { return };
        let loads = std::mem::take(&mut open.loads);
        let is_at_stop = open.served_from.take().is_some();
        open.is_queued = false;
        if let Some(robot) = open.robot.take() {
            self.assigned.remove(&(robot, order));
            self.add(robot, -1, -loads);
            let work = self.work_mut(robot);
            work.at_stops -= i32::from(is_at_stop);
            work.is_queued = false;
        }
    }

    fn close(&mut self, order: u64) {
        self.release(order);
        self.open.remove(&order);
    }

    fn add(&mut self, robot: u32, orders: i32, loads: i32) {
        let work = self.work_mut(robot);
        work.orders += orders;
        work.loads += loads;
    }
}

fn wait_at(waits: &mut BTreeMap<u32, StopWait>, node: u32) -> &mut StopWait {
    waits.entry(node).or_insert(StopWait { node, ..StopWait::default() })
}

/// The range of a robot's orders among those of all robots.
fn orders_of(robot: u32) -> RangeInclusive<(u32, u64)> {
    (robot, 0)..=(robot, u64::MAX)
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

    fn now(secs: f64) -> Now {
        Now { tick: (secs * 10.0) as u64, secs }
    }

    /// Whether a robot has an order, and whether it has a load.
    fn has(orders: &Orders, robot: u32) -> [bool; 2] {
        let RobotWork { orders, loads, .. } = orders.robots_in_turn()(robot).work;
        [orders > 0, loads > 0]
    }

    #[test]
    fn a_robot_has_an_order_from_its_assignment_to_its_end_and_a_load_between_pick_and_drop() {
        let mut orders = Orders::default();
        orders.take(&OrderRecord { detail: 2, ..record(OrderKind::Created) }, now(10.0));
        assert_eq!((orders.open(), has(&orders, 3)), (1, [false, false]));
        orders.take(&record(OrderKind::Assigned), now(12.0));
        assert_eq!(has(&orders, 3), [true, false]);
        orders.take(&record(OrderKind::Handled).at_stop(0, 5, StopAction::Pick), now(20.0));
        assert_eq!(has(&orders, 3), [true, true]);
        orders.take(&record(OrderKind::Handled).at_stop(1, 6, StopAction::Drop), now(30.0));
        assert_eq!(has(&orders, 3), [true, false]);
        orders.take(&record(OrderKind::Finished), now(30.0));
        assert_eq!((orders.open(), has(&orders, 3)), (0, [false, false]));
        let finished = Finished {
            at_secs: 30.0,
            service_secs: 20.0,
            stops: 2,
            due_secs: None,
            parts: Parts { assignment: 20, empty: 80, loaded: 100, ..Parts::default() },
            ends: [0; 2],
        };
        assert_eq!(orders.finished, [finished]);
    }

    #[test]
    fn an_order_is_late_after_its_deadline() {
        let mut orders = Orders::default();
        for (order, due_secs) in [(1, 15.0), (2, 25.0), (3, 0.0), (4, -1.0)] {
            let created = OrderRecord::new(order, OrderKind::Created);
            orders.take(&OrderRecord { due_secs, ..created }, now(10.0));
        }
        let late: Vec<_> = orders.unfinished(30.0).iter().map(Unfinished::is_late).collect();
        assert_eq!(late, [Some(true), Some(false), None, Some(true)]);
        for order in [1, 2, 3] {
            orders.take(&OrderRecord::new(order, OrderKind::Finished), now(30.0));
        }
        let late: Vec<_> = orders.finished.iter().map(Finished::is_late).collect();
        assert_eq!(late, [Some(true), Some(false), None]);
        assert_eq!(orders.unfinished(30.0).len(), 1);
    }

    #[test]
    fn an_order_that_goes_to_another_robot_counts_for_that_one_only() {
        let mut orders = Orders::default();
        orders.take(&record(OrderKind::Created), now(0.0));
        orders.take(&record(OrderKind::Assigned), now(1.0));
        orders.take(&record(OrderKind::Withdrawn), now(2.0));
        assert_eq!(has(&orders, 3), [false, false]);
        orders.take(&OrderRecord { robot: 4, ..record(OrderKind::Assigned) }, now(3.0));
        orders.take(&OrderRecord { robot: 5, ..record(OrderKind::Assigned) }, now(3.0));
        assert_eq!([3, 4, 5].map(|robot| has(&orders, robot)[0]), [false, false, true]);
        orders.take(&record(OrderKind::Failed), now(4.0));
        assert_eq!((orders.failed, orders.open(), has(&orders, 5)), (1, 0, [false, false]));
        orders.take(&record(OrderKind::Finished), now(5.0));
        assert!(orders.finished.is_empty(), "an unknown order");
    }

    /// Random numbers below a limit (a linear congruential generator).
    fn random(state: &mut u64, below: u64) -> u64 {
        *state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 33) % below
    }

    /// Something that happens to an order at random, in the order log.
    fn change(order: u64, number: u64, robot: u32) -> OrderRecord {
        let record = OrderRecord::new(order, OrderKind::Created).of_robot(robot);
        let of = |kind| OrderRecord { kind: kind as u32, ..record };
        match number {
            0 => of(OrderKind::Assigned),
            1 => of(OrderKind::Withdrawn),
            2 => OrderRecord { dwell_secs: robot as f32, ..of(OrderKind::Arrived) },
            3 => of(OrderKind::Handled).at_stop(0, 1, StopAction::Pick),
            4 => of(OrderKind::Handled).at_stop(1, 2, StopAction::Drop),
            5 => of(OrderKind::Unroutable),
            6 => of(OrderKind::Reopened),
            _ => of(OrderKind::Finished),
        }
    }

    #[test]
    fn the_parts_of_each_order_of_random_runs_add_up_to_its_time() {
        const TICK_SECS: f64 = 0.1;
        let mut finished = 0;
        for seed in 0..20 {
            let (mut state, mut orders) = (seed, Orders::default());
            for tick in 0_u64..3000 {
                let hindrance = match random(&mut state, 6) {
                    0 | 1 => Hindrance::Traffic,
                    2 => Hindrance::Down,
                    _ => Hindrance::None,
                };
                for robot in (0..5).filter(|robot| robot % 2 == 0) {
                    orders.hinder(robot, hindrance, tick.saturating_sub(1));
                }
                let now = Now { tick, secs: tick as f64 * TICK_SECS };
                // In lockstep, the records of a tick come after its frame.
                for _ in 0..random(&mut state, 4) {
                    let [order, number] = [30, 9].map(|below| random(&mut state, below));
                    let is_new = !orders.open.contains_key(&order);
                    let record = match is_new {
                        true => OrderRecord::new(order, OrderKind::Created),
                        false => change(order, number, random(&mut state, 5) as u32),
                    };
                    orders.take(&record, now);
                }
            }
            for order in &orders.finished {
                let secs = rounded(order.parts.total() as f64 * TICK_SECS);
                assert_eq!(secs, order.service_secs, "{order:?}");
            }
            finished += orders.finished.len();
        }
        assert!(finished > 1000, "{finished} orders");
    }

    /// 10 ticks a second: the robot comes at 20 s, waits for 4 s, and is handled until 30 s.
    #[test]
    fn a_wait_at_a_station_is_a_part_of_its_own() {
        let mut orders = Orders::default();
        orders.take(&OrderRecord { detail: 1, ..record(OrderKind::Created) }, now(10.0));
        orders.take(&record(OrderKind::Assigned), now(12.0));
        let arrived = OrderRecord { dwell_secs: 4.0, ..record(OrderKind::Arrived) };
        orders.take(&arrived, now(20.0));
        assert_eq!(orders.robots_in_turn()(3).work.served_from, 240);
        // A frame that was late turns to the phase of its tick, and takes nothing from the wait.
        orders.hinder(3, Hindrance::None, 250);
        orders.take(&record(OrderKind::Handled).at_stop(0, 5, StopAction::Pick), now(30.0));
        orders.take(&record(OrderKind::Finished), now(30.0));
        let expected =
            Parts { assignment: 20, empty: 80, station: 40, handling: 60, ..Parts::default() };
        assert_eq!(orders.finished[0].parts, expected);
        assert_eq!(orders.waits().iter().map(|it| it.handling).sum::<u64>(), 60);
        assert_eq!(orders.waits().iter().map(|it| it.station).sum::<u64>(), 40);
        // A station that never opens.
        orders.take(&record(OrderKind::Created), now(40.0));
        orders.take(&record(OrderKind::Assigned), now(41.0));
        let never = OrderRecord { dwell_secs: f32::INFINITY, ..record(OrderKind::Arrived) };
        orders.take(&never, now(42.0));
        assert_eq!(orders.robots_in_turn()(3).work.served_from, u64::MAX);
    }

    /// 10 ticks a second: a full storage from 10 s to 16 s, a robot at 18 s, and the end at 20 s.
    #[test]
    fn the_wait_for_a_place_of_a_storage_is_a_part_of_its_own() {
        let mut orders = Orders::default();
        orders.take(&OrderRecord { detail: 1, ..record(OrderKind::Created) }, now(10.0));
        let lack =
            OrderRecord { detail: Obstacle::NoPlace as u32, ..record(OrderKind::Unroutable) };
        orders.take(&lack.at_stop(0, 5, StopAction::Drop), now(10.0));
        let lack = Lack { node: 5, is_full: true };
        assert_eq!(orders.unplaced(), [Unplaced { lack, orders: 1, since_secs: 10.0 }]);
        orders.take(&record(OrderKind::Reopened), now(16.0));
        orders.take(&record(OrderKind::Stop).at_stop(0, 6, StopAction::Drop), now(16.0));
        orders.take(&record(OrderKind::Assigned), now(18.0));
        orders.take(&record(OrderKind::Finished), now(20.0));
        let parts = Parts { storage: 60, assignment: 20, empty: 20, ..Parts::default() };
        assert_eq!((orders.finished[0].parts, orders.finished[0].ends), (parts, [6, 6]));
        assert_eq!(orders.unplaced(), []);
    }

    #[test]
    fn the_time_of_a_broken_robot_is_no_way() {
        let mut orders = Orders::default();
        orders.take(&OrderRecord { detail: 1, ..record(OrderKind::Created) }, now(10.0));
        orders.take(&record(OrderKind::Assigned), now(10.0));
        orders.hinder(3, Hindrance::Down, 150);
        orders.hinder(3, Hindrance::None, 250);
        orders.take(&record(OrderKind::Arrived), now(30.0));
        orders.hinder(3, Hindrance::Down, 320);
        orders.hinder(3, Hindrance::None, 330);
        orders.take(&record(OrderKind::Handled).at_stop(0, 5, StopAction::Pick), now(40.0));
        orders.take(&record(OrderKind::Finished), now(40.0));
        let expected = Parts { empty: 100, handling: 90, down: 110, ..Parts::default() };
        assert_eq!(orders.finished[0].parts, expected);
    }
}
