//! Doors and lifts: they move by their own times, take requests, and keep robots before closed
//! doors and out of shafts without a cabin.
//!
//! Edges behind a closed door, and those into and out of a cabin that isn't there, are barred: the
//! released base of a robot ends before them, whatever its route. So safety depends on no manager.
//! A step costs nothing without facilities, and looks for robots only while a door or a cabin has
//! something to do.

mod cabin;
mod door;
mod leaf;
mod placement;
mod scene;

use std::collections::BTreeMap;
use std::time::Duration;

use regatta_layout::{EdgeIndex, Leg, NodeIndex, RouteGraph};
use regatta_motion::{LegTable, RouteCursor, leg_of};
use regatta_plugin::command::REQUEST_SECS;
use regatta_plugin::event::{EventKind, EventRecord, Refusal};
use regatta_plugin::facility::FacilityState;
use regatta_plugin::frame::RobotState;
use regatta_plugin::order::NO_ROBOT;

use self::cabin::{Cabin, LiftEdge};
use self::door::Door;
use self::leaf::whole_ticks;
use self::scene::{Occupants, Outcome, Scene};
use super::{EventBuffer, Fleet};

/// The time between two looks for robots that wait for a door or a lift nobody has requested for
/// them, in seconds.
const LOOK_SECS: f64 = 1.0;

/// The doors and lifts of a route graph.
#[derive(Debug)]
pub(super) struct Facilities {
    doors: Vec<Door>,
    cabins: Vec<Cabin>,
    /// The doors across an edge, by index.
    doors_of: BTreeMap<EdgeIndex, Vec<usize>>,
    /// The lift in whose cabin a node is, and its level there.
    stop_of: BTreeMap<NodeIndex, (usize, usize)>,
    /// The lift that an edge belongs to.
    lift_of: BTreeMap<EdgeIndex, (usize, LiftEdge)>,
    /// By edge: whether it is one of a facility, or ends at a node of one.
    counts: Vec<bool>,
    request_ticks: u64,
    look_ticks: u64,
    /// The last tick; `None` before the first.
    tick: Option<u64>,
    occupants: Occupants,
    outcome: Outcome,
    /// The states of all doors, then of all lifts.
    states: Vec<FacilityState>,
    /// The number of changes of the states.
    changes: u64,
}

/// A request of a door or a lift, which is possible.
#[derive(Clone, Copy, Debug)]
pub(super) enum Request {
    /// Open the doors across an edge.
    Door(EdgeIndex),
    /// Don't keep them open any more.
    ReleaseDoor(EdgeIndex),
    /// Call a lift, by its index, to a level.
    Lift(usize, usize),
    /// End the call.
    ReleaseLift(usize),
}

impl Facilities {
    /// Returns the facilities of a graph, and bars their edges; `None` if it has none.
    pub fn new(
        graph: &RouteGraph,
        tick_period: Duration,
        legs: &mut LegTable,
    ) -> Option<Box<Self>> {
        if graph.doors().is_empty() && graph.lifts().is_empty() {
            return None;
        }
        let tick_secs = tick_period.as_secs_f64();
        let [request_ticks, look_ticks] =
            [REQUEST_SECS, LOOK_SECS].map(|secs| u64::from(whole_ticks(secs, tick_secs)));
        let doors = (0..graph.doors().len() as u32).map(|index| Door::new(graph, index, tick_secs));
        let doors: Vec<Door> = doors.collect();
        let cabins = (0..graph.lifts().len() as u32)
            .map(|index| Cabin::new(graph, index, tick_secs, request_ticks));
        let cabins: Vec<Cabin> = cabins.collect();
        let mut facilities = Self {
            doors_of: BTreeMap::new(),
            stop_of: BTreeMap::new(),
            lift_of: BTreeMap::new(),
            counts: Vec::new(),
            doors,
            cabins,
            request_ticks,
            look_ticks,
            tick: None,
            occupants: Occupants::default(),
            outcome: Outcome::default(),
            states: Vec::new(),
            changes: 0,
        };
        facilities.index(graph);
        for edge in facilities.doors_of.keys().chain(facilities.lift_of.keys()) {
            legs.bar(*edge, true);
        }
        facilities.note_states();
        Some(Box::new(facilities))
    }

    /// Finds the facilities of edges and nodes.
    fn index(&mut self, graph: &RouteGraph) {
        for (index, door) in self.doors.iter().enumerate() {
            for edge in door.edges() {
                self.doors_of.entry(*edge).or_default().push(index);
            }
        }
        for (index, cabin) in self.cabins.iter().enumerate() {
            self.stop_of.extend(cabin.nodes().map(|(node, level)| (node, (index, level))));
            self.lift_of.extend(cabin.edges().map(|(edge, place)| (edge, (index, place))));
        }
        let own =
            |edge: &EdgeIndex| self.doors_of.contains_key(edge) || self.lift_of.contains_key(edge);
        let mut nodes = vec![false; graph.nodes().len()];
        let edges = || (0..).map(EdgeIndex).zip(graph.edges());
        for (_, edge) in edges().filter(|(index, _)| own(index)) {
            nodes[edge.origin.0 as usize] = true;
            nodes[edge.destination.0 as usize] = true;
        }
        let ends_there = |node: NodeIndex| nodes[node.0 as usize];
        let counts = edges().map(|(index, edge)| {
            own(&index) || ends_there(edge.origin) || ends_there(edge.destination)
        });
        self.counts = counts.collect();
    }

    /// Carries a possible request out for a robot. Returns whether the lift isn't in use by another
    /// one.
    fn request(&mut self, robot: u32, request: Request) -> bool {
        let tick = self.tick.unwrap_or(0);
        match request {
            Request::Door(edge) => {
                for door in self.doors_of.get(&edge).into_iter().flatten() {
                    self.doors[*door].request(robot, tick + self.request_ticks);
                }
            }
            Request::ReleaseDoor(edge) => {
                for door in self.doors_of.get(&edge).into_iter().flatten() {
                    self.doors[*door].release(robot);
                }
            }
            Request::Lift(lift, level) => return self.cabins[lift].call(robot, level, tick),
            Request::ReleaseLift(lift) => self.cabins[lift].release(robot),
        }
        true
    }

    /// Updates the states that readers get.
    fn note_states(&mut self) {
        let doors = self.doors.iter().map(Door::state);
        let states = doors.chain(self.cabins.iter().map(Cabin::state));
        if !states.clone().eq(self.states.iter().copied()) {
            self.states.clear();
            self.states.extend(states);
            self.changes += 1;
        }
    }

    fn has_to_look(&self, tick: u64) -> bool {
        self.doors.iter().any(|door| door.wants_to_close(tick))
            || self.cabins.iter().any(|cabin| !cabin.rests())
    }
}

/// Methods for requests.
impl Fleet {
    /// The states of all doors, then of all lifts.
    pub fn facility_states(&self) -> &[FacilityState] {
        self.facilities.as_ref().map_or(&[], |facilities| &facilities.states)
    }

    /// The number of changes of the states of doors and lifts.
    pub fn facility_changes(&self) -> u64 {
        self.facilities.as_ref().map_or(0, |facilities| facilities.changes)
    }

    /// Checks a request of the doors across an edge.
    pub(super) fn door_across(&self, edge: EdgeIndex) -> Result<EdgeIndex, Refusal> {
        let facilities = self.facilities.as_ref().ok_or(Refusal::NoDoor)?;
        facilities.doors_of.contains_key(&edge).then_some(edge).ok_or(Refusal::NoDoor)
    }

    /// Checks a request of the lift with a node, given by its id. Returns the lift and the level.
    pub(super) fn lift_with(&self, node: u32) -> Result<(usize, usize), Refusal> {
        let node = self.graph.node_by_id(node).ok_or(Refusal::UnknownNode)?;
        let facilities = self.facilities.as_ref().ok_or(Refusal::NoLift)?;
        facilities.stop_of.get(&node).copied().ok_or(Refusal::NoLift)
    }

    /// Carries a request out for a robot. Returns whether the lift isn't in use by another one.
    pub(super) fn request_facility(&mut self, robot: u32, request: Request) -> bool {
        let Some(facilities) = &mut self.facilities else { return false };
        let is_done = facilities.request(robot, request);
        facilities.note_states();
        is_done
    }
}

/// Methods for a tick.
impl Fleet {
    /// Moves the doors and the cabins by one tick, before the robots.
    pub fn step_facilities(&mut self, tick: u64, events: &mut EventBuffer) {
        let Some(mut facilities) = self.facilities.take() else { return };
        facilities.tick = Some(tick);
        if tick.is_multiple_of(facilities.look_ticks) {
            self.ask_for_waiting(&mut facilities);
        }
        if facilities.has_to_look(tick) {
            facilities.occupants.find(self, &facilities.counts);
        }
        let Facilities { doors, cabins, occupants, outcome, .. } = &mut *facilities;
        let scene = Scene { fleet: self, occupants };
        for door in doors {
            door.step(tick, &scene, outcome);
        }
        for cabin in cabins {
            cabin.step(tick, &scene, outcome);
        }
        facilities.note_states();
        self.set_gates(&mut facilities.outcome, events);
        self.facilities = Some(facilities);
    }

    /// Bars edges or lets robots pass, and reports what has happened.
    fn set_gates(&mut self, outcome: &mut Outcome, events: &mut EventBuffer) {
        for (kind, id) in outcome.events.drain(..) {
            note(kind, id, events);
        }
        if outcome.gates.is_empty() {
            return;
        }
        let is_any_open = outcome.gates.iter().any(|(_, is_barred)| !is_barred);
        for (edge, is_barred) in outcome.gates.drain(..) {
            self.motion.legs.bar(edge, is_barred);
        }
        self.look_ahead_again();
        if is_any_open {
            self.start_waiting(events);
        }
    }

    /// Requests doors and lifts for robots that wait for them, in their own names: nobody may have
    /// done it ahead.
    fn ask_for_waiting(&self, facilities: &mut Facilities) {
        for row in 0..self.robots() {
            let counts = facilities.counts.get(self.columns.edge[row] as usize);
            if !self.is(row, RobotState::Waiting) || counts == Some(&false) {
                continue;
            }
            let robot = row as u32;
            let Some(leg) = self.wanted_leg(robot) else { continue };
            if !self.motion.legs.is_barred(leg.edge) {
                continue;
            }
            facilities.request(robot, Request::Door(leg.edge));
            if let Some((lift, level)) = self.lift_for(facilities, row, leg) {
                facilities.request(robot, Request::Lift(lift, level));
            }
        }
    }

    /// Returns the lift that a robot needs for its next leg, and the level to which it wants it.
    fn lift_for(&self, facilities: &Facilities, row: usize, leg: Leg) -> Option<(usize, usize)> {
        let (lift, place) = *facilities.lift_of.get(&leg.edge)?;
        if let LiftEdge::Doorway(level) = place {
            return Some((lift, level));
        }
        // The end of all rides up, or down, in a row.
        let level = |node| facilities.stop_of.get(&node).map(|(_, level)| *level);
        let (from, mut to) = (level(self.graph.leg_start(leg))?, level(self.graph.leg_end(leg))?);
        let is_up = to > from;
        for next in self.motion.plans.base(self.columns.route[row]).iter().skip(1) {
            match level(self.graph.leg_end(*next)) {
                Some(level) if level != to && (level > to) == is_up => to = level,
                _ => break,
            }
        }
        Some((lift, to))
    }

    /// Returns the node at which a robot stands: at the end of its leg, or without an edge.
    pub(super) fn standing_at(&self, robot: u32) -> Option<NodeIndex> {
        let row = robot as usize;
        let piece = self.columns.piece.get(row);
        let is_there = !self.is(row, RobotState::Absent);
        let is_at_end = self.motion.legs.is_leg_end(piece, self.columns.w[row]);
        (is_there && is_at_end).then(|| self.node_ahead(row))
    }

    /// Returns the leg that a robot drives next as soon as it may.
    fn wanted_leg(&self, robot: u32) -> Option<Leg> {
        let row = robot as usize;
        self.motion.wanted_leg(&RouteCursor {
            robot,
            route: self.columns.route[row],
            node: self.node_ahead(row),
            leg: leg_of(self.columns.piece.get(row), self.columns.edge[row]),
        })
    }

    /// Whether a robot is held or impaired, so that it doesn't drive off.
    fn may_not_drive(&self, robot: u32) -> bool {
        self.is_stopped(robot as usize)
    }

    /// The metres from the pose of a robot to the farthest part of its body.
    fn reach(&self, robot: u32) -> f32 {
        let robot_type = &self.types[usize::from(self.columns.robot_type[robot as usize])];
        0.5 * robot_type.length.hypot(robot_type.width)
    }
}

fn note(kind: EventKind, id: u32, events: &mut EventBuffer) {
    let record = EventRecord { kind: kind as u32, robot: NO_ROBOT, id, ..EventRecord::default() };
    events.push_record(record);
}
