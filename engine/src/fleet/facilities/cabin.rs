//! The cabin of a lift, with its doors.
//!
//! A cabin stands at a level, or moves to a neighbouring one while its doors are closed. It leaves
//! a level only when every robot in it rides along: a robot that stays or leaves there keeps it.
//! The edge of a ride is open while the cabin moves along it, and takes as long as the cabin.

use regatta_layout::{EdgeIndex, NodeIndex, RouteGraph};
use regatta_plugin::event::EventKind;
use regatta_plugin::facility::{DoorState, FacilityKind, FacilityState};
use regatta_plugin::order::NO_ROBOT;

use super::leaf::{Leaf, whole_ticks};
use super::scene::{Outcome, Scene};

/// A call of the cabin to a level.
#[derive(Clone, Copy, Debug)]
struct Call {
    /// The robot for which it was called.
    robot: u32,
    level: usize,
    /// The tick up to which it holds.
    until: u64,
}

/// The place of an edge in a lift.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LiftEdge {
    /// It leads into the cabin or out of it, at a level.
    Doorway(usize),
    /// It leads from a level to the next one, or back.
    Ride,
}

/// The way between two neighbouring levels.
#[derive(Clone, Debug, Default)]
struct Gap {
    /// The edges up and down it.
    rides: Vec<EdgeIndex>,
    /// Those up, and those down.
    up: Vec<EdgeIndex>,
    down: Vec<EdgeIndex>,
    /// The ticks from the cabin's departure to the moment at which robots drive off: an edge that
    /// is too short for the whole time is driven at its end.
    delay: u64,
}

/// The cabin of a lift.
#[derive(Debug)]
pub(super) struct Cabin {
    index: u32,
    /// By level: the nodes in the cabin, and the id of the first.
    stops: Vec<Vec<NodeIndex>>,
    stop_ids: Vec<u32>,
    /// By level: the edges that lead into the cabin and out of it.
    doorways: Vec<Vec<EdgeIndex>>,
    /// By its lower level.
    gaps: Vec<Gap>,
    level_ticks: u64,
    request_ticks: u64,
    leaf: Leaf,
    level: usize,
    /// The level that it is coming to; `level` while it stands.
    next: usize,
    /// The tick of its last departure.
    departed: u64,
    are_rides_open: bool,
    is_doorway_barred: bool,
    call: Option<Call>,
}

impl Cabin {
    /// Makes a cabin that stands at its first level with closed doors.
    pub fn new(graph: &RouteGraph, index: u32, tick_secs: f64, request_ticks: u64) -> Self {
        let lift = &graph.lifts()[index as usize];
        let stops: Vec<Vec<NodeIndex>> =
            lift.levels.iter().map(|level| level.nodes.clone()).collect();
        let mut doorways = vec![Vec::new(); stops.len()];
        let mut gaps = vec![Gap::default(); stops.len() - 1];
        let level_ticks = u64::from(whole_ticks(lift.level_secs, tick_secs));
        for (edge_index, edge) in (0..).map(EdgeIndex).zip(graph.edges()) {
            let [from, to] = [edge.origin, edge.destination].map(|node| lift.level_of(node));
            match (from, to) {
                (Some(from), Some(to)) if from != to => {
                    let gap = &mut gaps[from.min(to)];
                    let drive_secs = edge.path.length() / edge.speed;
                    let drive_ticks = u64::from(whole_ticks(drive_secs, tick_secs));
                    gap.add(edge_index, from < to, edge.reverse_speed.is_some());
                    gap.delay = gap.delay.max(level_ticks.saturating_sub(drive_ticks));
                }
                (Some(level), _) | (None, Some(level)) => doorways[level].push(edge_index),
                (None, None) => {}
            }
        }
        let first = |level: &Vec<NodeIndex>| graph.node(level[0]).id;
        Self {
            index,
            stop_ids: stops.iter().map(first).collect(),
            stops,
            doorways,
            gaps,
            level_ticks,
            request_ticks,
            leaf: Leaf::new(lift.door_times, tick_secs),
            level: lift.home,
            next: lift.home,
            departed: 0,
            are_rides_open: false,
            is_doorway_barred: true,
            call: None,
        }
    }

    /// Its nodes, with their levels.
    pub fn nodes(&self) -> impl Iterator<Item = (NodeIndex, usize)> {
        let levels = self.stops.iter().enumerate();
        levels.flat_map(|(level, nodes)| nodes.iter().map(move |node| (*node, level)))
    }

    /// Its edges, with their places.
    pub fn edges(&self) -> impl Iterator<Item = (EdgeIndex, LiftEdge)> {
        let doorways = self.doorways.iter().enumerate().flat_map(|(level, edges)| {
            edges.iter().map(move |edge| (*edge, LiftEdge::Doorway(level)))
        });
        let rides = self.gaps.iter().flat_map(|gap| &gap.rides);
        let rides = rides.map(|edge| (*edge, LiftEdge::Ride));
        doorways.chain(rides)
    }

    /// Whether the cabin stands at a level.
    pub fn is_at(&self, level: usize) -> bool {
        self.level == level && self.next == level
    }

    /// Whether robots may pass its doors at a level.
    pub fn is_open_at(&self, level: usize) -> bool {
        self.is_at(level) && self.leaf.is_open() && !self.is_doorway_barred
    }

    /// Puts the cabin at a level before the first tick, because a robot is there.
    pub fn set_level(&mut self, level: usize) {
        (self.level, self.next) = (level, level);
    }

    /// Opens its doors before the first tick, because a robot is in the doorway.
    pub fn set_open(&mut self, outcome: &mut Outcome) {
        self.leaf.set_open();
        self.bar_doorway(false, outcome);
    }

    /// Calls it to a level for a robot, from a tick on. Returns whether it isn't called for another
    /// one.
    pub fn call(&mut self, robot: u32, level: usize, tick: u64) -> bool {
        let is_free = self.call.is_none_or(|call| call.robot == robot);
        if is_free {
            self.call = Some(Call { robot, level, until: tick + self.request_ticks });
        }
        is_free
    }

    /// Ends the call for a robot.
    pub fn release(&mut self, robot: u32) {
        self.call = self.call.filter(|call| call.robot != robot);
    }

    /// Whether it does nothing until it is called.
    pub fn rests(&self) -> bool {
        self.call.is_none() && self.next == self.level && self.leaf.state() == DoorState::Closed
    }

    pub fn step(&mut self, tick: u64, scene: &Scene<'_>, outcome: &mut Outcome) {
        if self.next != self.level {
            return self.travel(tick, scene, outcome);
        }
        if self.leaf.step(tick) && self.leaf.is_open() {
            self.bar_doorway(false, outcome);
            outcome.events.push((EventKind::LiftArrived, self.stop_ids[self.level]));
            if let Some(call) = &mut self.call {
                call.until = tick + self.request_ticks;
            }
        }
        match self.leaf.state() {
            DoorState::Open => {
                self.call = self.call.filter(|call| call.until > tick);
                self.stand_open(tick, scene, outcome);
            }
            DoorState::Closed => self.stand_closed(tick, scene),
            DoorState::Closing if self.is_called_here() => self.leaf.open(tick),
            DoorState::Closing | DoorState::Opening => {}
        }
    }

    pub fn state(&self) -> FacilityState {
        let [level, next_level] = [self.level, self.next].map(|level| level as u32);
        let state = self.leaf.describe(FacilityState {
            kind: FacilityKind::Lift as u32,
            index: self.index,
            level,
            next_level,
            called_level: self.call.map_or(level, |call| call.level as u32),
            robot: self.call.map_or(NO_ROBOT, |call| call.robot),
            requests: u32::from(self.call.is_some()),
            ..FacilityState::default()
        });
        match self.next == self.level {
            true => state,
            false => {
                FacilityState { since_tick: self.departed, ticks: self.level_ticks as u32, ..state }
            }
        }
    }

    /// Closes the doors when the cabin is to leave, or isn't needed there.
    fn stand_open(&mut self, tick: u64, scene: &Scene<'_>, outcome: &mut Outcome) {
        let is_leaving = match self.next_level() {
            Some(next) => scene.all_go_on(&self.stops[self.level], self.rides_to(next)),
            None => !self.is_called_here() && !scene.is_any_at(&self.stops[self.level]),
        };
        self.bar_doorway(is_leaving, outcome);
        if is_leaving && !scene.is_any_on(&self.doorways[self.level]) {
            self.leaf.close(tick);
        }
    }

    /// Departs when the cabin is called to another level; opens the doors for robots that don't
    /// ride there.
    fn stand_closed(&mut self, tick: u64, scene: &Scene<'_>) {
        match self.next_level() {
            Some(next) if scene.all_go_on(&self.stops[self.level], self.rides_to(next)) => {
                self.next = next;
                self.departed = tick;
            }
            None if !self.is_called_here() && !scene.is_any_at(&self.stops[self.level]) => {}
            Some(_) | None => self.leaf.open(tick),
        }
    }

    /// Moves on, and arrives when its time is over and all robots have come along.
    fn travel(&mut self, tick: u64, scene: &Scene<'_>, outcome: &mut Outcome) {
        let gap = &self.gaps[self.level.min(self.next)];
        if !self.are_rides_open && tick >= self.departed + gap.delay {
            outcome.bar(self.rides_to(self.next), false);
            self.are_rides_open = true;
        }
        let is_riding = scene.is_any_on(&gap.rides) || scene.is_any_at(&self.stops[self.level]);
        if tick >= self.departed + self.level_ticks && !is_riding {
            outcome.bar(&gap.rides, true);
            self.are_rides_open = false;
            self.level = self.next;
        }
    }

    /// The neighbouring level on the way to where it is called; `None` if that is here or nowhere.
    fn next_level(&self) -> Option<usize> {
        let called = self.call?.level;
        match called.cmp(&self.level) {
            std::cmp::Ordering::Less => Some(self.level - 1),
            std::cmp::Ordering::Equal => None,
            std::cmp::Ordering::Greater => Some(self.level + 1),
        }
    }

    fn is_called_here(&self) -> bool {
        self.call.is_some_and(|call| call.level == self.level)
    }

    /// The edges from its level to a neighbouring one.
    fn rides_to(&self, next: usize) -> &[EdgeIndex] {
        let gap = &self.gaps[self.level.min(next)];
        if next > self.level { &gap.up } else { &gap.down }
    }

    fn bar_doorway(&mut self, is_barred: bool, outcome: &mut Outcome) {
        if std::mem::replace(&mut self.is_doorway_barred, is_barred) != is_barred {
            outcome.bar(&self.doorways[self.level], is_barred);
        }
    }
}

impl Gap {
    /// Adds an edge, which leads up or down in forward gear.
    fn add(&mut self, edge: EdgeIndex, is_up: bool, is_two_way: bool) {
        self.rides.push(edge);
        if is_up || is_two_way {
            self.up.push(edge);
        }
        if !is_up || is_two_way {
            self.down.push(edge);
        }
    }
}
