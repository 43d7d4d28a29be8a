//! A door across edges.

use std::collections::BTreeMap;

use regatta_layout::{EdgeIndex, NodeIndex, RouteGraph};
use regatta_plugin::event::EventKind;
use regatta_plugin::facility::{FacilityKind, FacilityState};
use regatta_plugin::order::NO_ROBOT;

use super::leaf::Leaf;
use super::scene::{Outcome, Scene};

/// A door. Robots enter its edges only while it is open, and it closes only while none is on them.
#[derive(Debug)]
pub(super) struct Door {
    index: u32,
    edges: Vec<EdgeIndex>,
    /// Nodes at the ends of its edges, with the metres from there to the door.
    ends: Vec<(NodeIndex, f32)>,
    leaf: Leaf,
    /// The ticks up to which it is requested, by robot.
    requests: BTreeMap<u32, u64>,
    is_barred: bool,
    /// The id of its first edge, for events.
    edge_id: u32,
}

impl Door {
    /// Makes a closed door.
    pub fn new(graph: &RouteGraph, index: u32, tick_secs: f64) -> Self {
        let door = &graph.doors()[index as usize];
        let mut ends = Vec::new();
        for edge in door.edges.iter().map(|edge| graph.edge(*edge)) {
            let place = door.place(&edge.path);
            ends.push((edge.origin, place as f32));
            ends.push((edge.destination, (edge.path.length() - place) as f32));
        }
        Self {
            index,
            edges: door.edges.clone(),
            ends,
            leaf: Leaf::new(door.times, tick_secs),
            requests: BTreeMap::new(),
            is_barred: true,
            edge_id: graph.edge(door.edges[0]).id,
        }
    }

    pub fn edges(&self) -> &[EdgeIndex] {
        &self.edges
    }

    pub fn is_open(&self) -> bool {
        self.leaf.is_open() && !self.is_barred
    }

    /// Opens it before the first tick, because a robot is in it.
    pub fn set_open(&mut self, outcome: &mut Outcome) {
        self.leaf.set_open();
        self.bar(false, outcome);
    }

    /// Keeps it open for a robot up to a tick.
    pub fn request(&mut self, robot: u32, until: u64) {
        self.requests.insert(robot, until);
    }

    /// Ends the request for a robot.
    pub fn release(&mut self, robot: u32) {
        self.requests.remove(&robot);
    }

    /// Whether it closes as soon as no robot is in it.
    pub fn wants_to_close(&self, tick: u64) -> bool {
        self.leaf.is_open() && self.requests.values().all(|until| *until <= tick)
    }

    pub fn step(&mut self, tick: u64, scene: &Scene<'_>, outcome: &mut Outcome) {
        self.requests.retain(|_, until| *until > tick);
        let is_wanted = !self.requests.is_empty();
        if is_wanted {
            self.leaf.open(tick);
        } else if self.leaf.is_open() {
            self.bar(true, outcome);
            if !scene.is_any_on(&self.edges) && !scene.is_any_within(&self.ends) {
                self.leaf.close(tick);
            }
        }
        if self.leaf.step(tick) {
            let is_open = self.leaf.is_open();
            let kind = if is_open { EventKind::DoorOpened } else { EventKind::DoorClosed };
            outcome.events.push((kind, self.edge_id));
        }
        if is_wanted && self.leaf.is_open() {
            self.bar(false, outcome);
        }
    }

    pub fn state(&self) -> FacilityState {
        let robot = self.requests.keys().next().copied();
        self.leaf.describe(FacilityState {
            kind: FacilityKind::Door as u32,
            index: self.index,
            robot: robot.unwrap_or(NO_ROBOT),
            requests: self.requests.len() as u32,
            ..FacilityState::default()
        })
    }

    fn bar(&mut self, is_barred: bool, outcome: &mut Outcome) {
        if std::mem::replace(&mut self.is_barred, is_barred) != is_barred {
            outcome.bar(&self.edges, is_barred);
        }
    }
}
