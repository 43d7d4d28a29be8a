//! The manager of a fleet: gives orders to robots, sends them from stop to stop, and steers them
//! there.
//!
//! A cycle is a function of the previous cycles, the frame and the requests. In lockstep a run
//! repeats bit by bit.

mod charge;
mod queues;
mod reach;
mod requests;
#[cfg(test)]
mod tests;
mod vehicles;

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Instant;

use glam::vec2;
use regatta_plugin::closure::ClosedEdge;
use regatta_plugin::frame::{Columns, NO_EDGE, RobotState};

use self::queues::Queues;
use crate::charging::Charging;
use crate::facilities::{Facilities, FacilityCommand};
use crate::planner::{DrivingTimes, Planner};
use crate::roads::Roads;
use crate::steering::{Command, Settings, Steering};
use crate::traffic::Seen;
use regatta_orders::{Candidate, Next, Order, OrderId, OrderPool, Service, State};

/// The progress of a robot with the stop of its order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Progress {
    /// It has no stop.
    #[default]
    Free,
    /// It drives to the stop's node.
    Driving(u32),
    /// It drives to a place in the queue before the stop's node, or waits there; or it waits
    /// anywhere until there is a place.
    Queueing { stop: u32, place: Option<u32> },
    /// It is at the stop, which it handles at these simulated seconds.
    AtStop(Service),
}

/// The manager of a fleet.
pub struct Manager {
    steering: Steering,
    orders: OrderPool,
    times: DrivingTimes,
    charging: Charging,
    facilities: Facilities,
    queues: Queues,
    /// By robot.
    progress: Vec<Progress>,
    present: Vec<u32>,
    /// The type of each robot, as an index of the world's robot types.
    robot_types: Vec<u32>,
    candidates: Vec<Candidate>,
    /// The number of closure changes, and the robots with the part of the roads of each, when
    /// unroutable orders were last checked.
    checked: (u64, Vec<(u32, Option<u32>)>),
    /// The nodes of which a warning says that no way leads back from them.
    traps: BTreeSet<u32>,
    /// The robots for which waiting orders were judged, with the part of the roads of each, and
    /// whether the ways to chargers were known.
    judged_for: (Vec<(u32, Option<u32>)>, bool),
    /// The waiting orders that take more than the charge that robots usually have.
    for_full_batteries: BTreeSet<OrderId>,
    warnings: Vec<String>,
    /// The number of cycles in which vehicles were shown.
    vehicle_cycles: usize,
    /// The time of the last one.
    vehicles_shown: Option<Instant>,
}

impl Manager {
    /// Makes the manager of a fleet on some roads.
    pub fn new(
        roads: Arc<Roads>,
        planner: Box<dyn Planner>,
        settings: Settings,
        orders: OrderPool,
    ) -> Self {
        let mut manager = Self {
            times: DrivingTimes::default(),
            queues: Queues::new(&orders, &roads),
            steering: Steering::new(roads, planner, settings),
            orders,
            charging: Charging::default(),
            facilities: Facilities::default(),
            progress: Vec::new(),
            present: Vec::new(),
            robot_types: Vec::new(),
            candidates: Vec::new(),
            checked: (0, Vec::new()),
            traps: BTreeSet::new(),
            judged_for: (Vec::new(), false),
            for_full_batteries: BTreeSet::new(),
            warnings: Vec::new(),
            vehicle_cycles: 0,
            vehicles_shown: None,
        };
        manager.warn_of_traps();
        manager
    }

    /// Manages the batteries of robots, too.
    #[must_use]
    pub fn with_charging(self, charging: Charging) -> Self {
        Self { charging, ..self }
    }

    /// Requests doors and lifts, too.
    #[must_use]
    pub fn with_facilities(self, facilities: Facilities) -> Self {
        Self { facilities, ..self }
    }

    /// Returns the requests of doors and lifts after a cycle at a simulated time in seconds.
    pub fn request_facilities(&mut self, now_secs: f64) -> &[FacilityCommand] {
        self.facilities.request(&self.steering, now_secs)
    }

    /// The steering.
    pub fn steering(&self) -> &Steering {
        &self.steering
    }

    /// The orders.
    pub fn orders(&self) -> &OrderPool {
        &self.orders
    }

    /// The orders, to drain their events.
    pub fn orders_mut(&mut self) -> &mut OrderPool {
        &mut self.orders
    }

    /// Whether a robot has an order, and isn't at its stop.
    pub(crate) fn is_on_its_way(&self, robot: u32) -> bool {
        matches!(self.progress.get(robot as usize), Some(Progress::Driving(_)))
    }

    /// Takes the warnings of the last cycles.
    pub fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }

    /// Takes the edges that no robot may enter, sorted by id.
    pub fn close_edges(&mut self, closed: &[ClosedEdge]) {
        self.steering.close_edges(closed);
    }

    /// Revokes the grants of a robot from a command on, because the command was refused.
    pub fn refuse(&mut self, robot: u32) {
        self.steering.take_back(robot);
    }

    /// Extends the base of a robot as soon as there is room, because it asks for that.
    pub fn lengthen_base(&mut self, robot: u32) {
        self.steering.lengthen_base(robot);
    }

    /// Gives up the order of a robot whose action at a stop has failed.
    pub fn fail_action(&mut self, robot: u32) {
        let progress = self.progress.get(robot as usize).copied().unwrap_or_default();
        let (Progress::AtStop(_), Some(stop)) = (progress, self.orders.current_stop(robot)) else {
            return;
        };
        let place = self.orders.places().label(stop.node);
        let reason = format!("the robot's action at {place} has failed");
        if self.orders.failed(robot, self.steering.now(), &reason).is_some() {
            self.halt(robot);
        }
    }

    /// Takes a frame at a simulated time in seconds; returns the commands to send. `robot_types`
    /// has an index for each robot, or is empty if all are of the first type; `charges` likewise in
    /// per cent, empty if no robot has a battery.
    pub fn cycle(
        &mut self,
        now_secs: f64,
        columns: &Columns<'_>,
        robot_types: &[f32],
        charges: &[f32],
    ) -> &[Command] {
        self.see(columns, robot_types);
        self.charging.see(columns.state.len(), charges, robot_types);
        self.times.begin();
        self.generate(now_secs);
        for robot in self.orders.take_requests(now_secs) {
            self.halt(robot);
        }
        for index in 0..self.present.len() {
            self.serve(self.present[index], now_secs);
        }
        self.move_up();
        self.reopen(now_secs);
        if self.steering.is_ready() {
            self.charge(now_secs, columns.state);
            self.assign(now_secs);
        }
        self.steering.step(now_secs)
    }

    fn see(&mut self, columns: &Columns<'_>, robot_types: &[f32]) {
        self.present.clear();
        // The producer has taken the last rows away.
        for robot in columns.state.len()..self.progress.len() {
            self.lose(robot as u32);
        }
        self.progress.resize(columns.state.len(), Progress::Free);
        self.robot_types.resize(columns.state.len(), 0);
        for robot in 0..columns.state.len() {
            let state = RobotState::from_number(columns.state[robot]);
            if state == RobotState::Absent {
                self.lose(robot as u32);
                continue;
            }
            let robot_type = robot_types.get(robot).map_or(0, |index| *index as u32);
            self.robot_types[robot] = robot_type;
            let seen = Seen {
                robot_type: robot_type as usize,
                edge: (columns.edge[robot] != NO_EDGE).then_some(columns.edge[robot]),
                s: columns.s[robot],
                speed: columns.speed[robot].abs(),
                position: vec2(columns.x[robot], columns.y[robot]),
                state,
            };
            self.steering.see(robot as u32, &seen);
            self.present.push(robot as u32);
        }
    }

    /// A robot has left the fleet: its order is given to another one, or has failed if its load is
    /// gone with it.
    fn lose(&mut self, robot: u32) {
        if self.steering.robot(robot).is_none() {
            return;
        }
        self.steering.lose(robot);
        self.charging.lose(robot);
        self.queues.leave(robot);
        self.progress[robot as usize] = Progress::Free;
        self.orders.recall(robot, self.steering.now());
        if self.orders.order_of(robot).is_some()
            && self.orders.withdraw(robot, self.steering.now()).is_err()
        {
            self.orders.failed(robot, self.steering.now(), "the robot was removed");
        }
    }

    /// Moves a robot's order on, if it has come to a stop or has handled one.
    fn serve(&mut self, robot: u32, now_secs: f64) {
        // The store keeps the orders that robots have begun: they go on after a restart.
        if self.progress[robot as usize] == Progress::Free
            && let Some(stop) = self.orders.current_stop(robot)
        {
            self.send(robot, stop.node);
        }
        if let Progress::Driving(node) = self.progress[robot as usize] {
            if self.steering.has_arrived(robot, node)
                && let Some(service) = self.orders.arrived(robot, now_secs)
            {
                self.progress[robot as usize] = Progress::AtStop(service);
                self.steering.stay(robot);
                self.warn_of_closed_station(robot, node, service);
            } else if self.steering.is_unreachable(robot) {
                self.give_up(robot, now_secs);
            } else if self.steering.robot(robot).is_some_and(|state| state.goal().is_none()) {
                // It was evicted while it waited for roads to be opened.
                self.send(robot, node);
            }
        }
        if let Progress::Queueing { place: Some(place), .. } = self.progress[robot as usize] {
            if self.steering.has_arrived(robot, place) && !self.waits_in_queue(robot) {
                self.steering.stay(robot);
                self.orders.queued(robot, now_secs);
            } else if self.steering.is_unreachable(robot) {
                self.give_up(robot, now_secs);
            }
        }
        // A robot that stalls hasn't finished.
        if let Progress::AtStop(service) = self.progress[robot as usize]
            && now_secs >= service.end_secs
            && self.steering.robot(robot).is_none_or(|robot| robot.state != RobotState::Stalled)
        {
            match self.orders.handled(robot, now_secs) {
                Some(Next::Stop(stop)) => self.send(robot, stop.node),
                Some(Next::Done) | None => self.halt(robot),
            }
        }
    }

    /// Gives the orders of robots that are out of service to others, unless they have begun, and
    /// tries orders again that couldn't be reached.
    fn reopen(&mut self, now_secs: f64) {
        for index in 0..self.present.len() {
            let robot = self.present[index];
            if self.steering.is_out_of_service(robot)
                && self.orders.withdraw(robot, now_secs).is_ok()
            {
                self.halt(robot);
            }
        }
        self.reconsider(now_secs);
    }

    /// Assigns orders. In most cycles no robot is free, and there is nothing to do.
    fn assign(&mut self, now_secs: f64) {
        let roads = self.steering.roads().clone();
        let is_anew = self.orders.is_reassignment_due(now_secs);
        self.find_candidates(is_anew);
        if self.candidates.is_empty() && !is_anew {
            return;
        }
        self.find_impossible(now_secs);
        if is_anew {
            prepare(&mut self.times, &roads, self.orders.open_orders());
        } else {
            prepare(&mut self.times, &roads, self.orders.waiting_orders());
        }
        let after = self.after_first_stops();
        let (steering, times, charging) = (&self.steering, &self.times, &self.charging);
        let changes = self.orders.assign(now_secs, &self.candidates, &|robot, node| {
            let secs = times.between(&roads, steering.base_end_node(robot)?, node)?;
            let rest = after.get(&node);
            rest.is_none_or(|rest| rest.is_affordable(charging, robot, secs)).then_some(secs)
        });
        for (_, robot) in changes.withdrawn {
            self.halt(robot);
        }
        for (_, robot) in changes.assigned {
            if let Some(stop) = self.orders.current_stop(robot) {
                self.send(robot, stop.node);
            }
        }
    }

    /// Finds the robots that may get an order, or another order if orders are reassigned.
    fn find_candidates(&mut self, is_anew: bool) {
        self.candidates.clear();
        for &robot in &self.present {
            let is_free = match is_anew {
                true => !self.orders.is_bound(robot),
                false => self.progress[robot as usize] == Progress::Free,
            };
            if is_free
                && !self.steering.is_out_of_service(robot)
                && self.charging.may_work(robot)
                && let Some(node) = self.steering.base_end_node(robot)
                && !self.steering.is_cut_off(node)
            {
                let position = self.steering.roads().position(node);
                let robot_type = self.robot_types[robot as usize];
                self.candidates.push(Candidate { robot, robot_type, position });
            }
        }
    }

    fn halt(&mut self, robot: u32) {
        self.queues.leave(robot);
        self.progress[robot as usize] = Progress::Free;
        self.steering.halt(robot);
    }
}

/// Computes the driving times to the next stops of orders.
fn prepare<'pool>(
    times: &mut DrivingTimes,
    roads: &Roads,
    orders: impl Iterator<Item = &'pool Order>,
) {
    // Those that wait for a place of a storage are at no node yet.
    let orders = orders.filter(|order| order.state != State::Unplaced);
    for stop in orders.filter_map(|order| order.content.stops.get(order.handled_stops)) {
        times.prepare(roads, stop.node);
    }
}
