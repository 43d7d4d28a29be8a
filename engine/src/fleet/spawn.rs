//! Spawns and removals of robots.

use std::sync::Arc;

use regatta_layout::{EdgeIndex, Gear, Leg, NodeIndex, RouteGraph};
use regatta_motion::{Distance, PieceIndex};
use regatta_plugin::event::{EventKind, EventRecord, Refusal};
use regatta_plugin::frame::RobotState;
use regatta_scenario::Repeat;

use super::{EventBuffer, Fleet, Route};

/// The source of a robot's route.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RouteSource {
    /// The robot stands until a command gives it a route.
    None,
    /// These legs. Robots with the same route share it.
    Listed(Arc<[Leg]>, Repeat),
    /// A random walk along edges in forward gear, which ends only at a dead end. At each node all
    /// edges that start there are equally likely, except for the one that leads straight back: it
    /// is chosen only if there is no other.
    Random,
}

/// The place of a new robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Placement {
    /// On a node, in its pose.
    Node(NodeIndex),
    /// On an edge, facing forward, that many metres from its origin.
    Edge(EdgeIndex, f32),
}

impl Fleet {
    /// Adds a robot of a type (an index into [`Fleet::types`]) and returns its id: the lowest that
    /// is free. It stands still until the next step; on an edge it first drives to that edge's end.
    ///
    /// The event `Spawned` carries `token`; 0 for none.
    ///
    /// # Errors
    /// `UnknownRobotType`, `UnknownNode`, `UnknownEdge`; `DistanceOutOfRange` for a place that is
    /// not on the edge; `MalformedRoute` for a listed route without legs; `NoReverse`,
    /// `NotConnected` for one that can't be driven from there, or a loop that doesn't close;
    /// `EdgeClosed` in a closed door, `NoCabin` in a shaft without its cabin; `FleetFull`. The
    /// fleet is then unchanged.
    pub fn spawn(
        &mut self,
        placement: Placement,
        robot_type: u16,
        source: RouteSource,
        token: u64,
        events: &mut EventBuffer,
    ) -> Result<u32, Refusal> {
        let start = self.check_spawn(placement, robot_type)?;
        if let RouteSource::Listed(legs, repeat) = &source {
            check_list(&self.graph, start.ahead, legs, *repeat)?;
        }
        let robot = self.allocate_row()?;
        self.settle_facilities(placement);
        let row = robot as usize;
        self.columns.set_robot_type(
            row,
            robot_type,
            self.types[usize::from(robot_type)].max_acceleration,
        );
        self.columns.route[row] = self.route(source);
        if let Some(batteries) = &mut self.batteries {
            batteries.begin(robot, robot_type);
        }
        self.motion.place(&mut self.columns.all_rows(), row, start.piece, start.edge, start.w);
        events.push_record(EventRecord {
            token,
            kind: EventKind::Spawned as u32,
            robot,
            ..EventRecord::default()
        });
        if self.columns.route[row] != Route::PARKED {
            self.motion.start_driving(&mut self.columns.all_rows(), row, events);
        }
        Ok(robot)
    }

    /// Removes a robot from the fleet. A later spawn reuses its id.
    ///
    /// # Errors
    /// `UnknownRobot`; the fleet is then unchanged.
    pub fn remove(&mut self, robot: u32, events: &mut EventBuffer) -> Result<(), Refusal> {
        self.row(robot)?;
        self.remove_row(robot, 0, events);
        Ok(())
    }

    /// Removes a robot that is not absent.
    pub(super) fn remove_row(&mut self, robot: u32, token: u64, events: &mut EventBuffer) {
        let row = robot as usize;
        self.motion.plans.discard(self.columns.route[row]);
        self.columns.clear(row);
        self.impairments.remove(&robot);
        self.free.insert(robot);
        while self.robots > 0 && self.free.remove(&(self.robots - 1)) {
            self.robots -= 1;
        }
        events.push_record(EventRecord {
            token,
            kind: EventKind::Removed as u32,
            robot,
            ..EventRecord::default()
        });
    }

    /// Checks whether a robot of a type can be put there. Returns the exact position.
    pub(super) fn check_spawn(
        &self,
        placement: Placement,
        robot_type: u16,
    ) -> Result<SpawnPoint, Refusal> {
        self.types.get(usize::from(robot_type)).ok_or(Refusal::UnknownRobotType)?;
        let point = self.spawn_point(placement)?;
        self.check_facilities(placement)?;
        Ok(point)
    }

    /// Returns the row of a robot that is not absent.
    pub(super) fn row(&self, robot: u32) -> Result<usize, Refusal> {
        match self.columns.state.get(robot as usize) {
            Some(&state) if state != RobotState::Absent as u8 => Ok(robot as usize),
            _ => Err(Refusal::UnknownRobot),
        }
    }

    fn allocate_row(&mut self) -> Result<u32, Refusal> {
        if let Some(row) = self.free.pop_first() {
            return Ok(row);
        }
        if self.robots >= self.most_robots {
            return Err(Refusal::FleetFull);
        }
        self.robots += 1;
        if self.robots as usize > self.columns.capacity() {
            self.columns.resize(self.robots as usize);
        }
        Ok(self.robots - 1)
    }

    fn route(&mut self, source: RouteSource) -> Route {
        match source {
            RouteSource::None => Route::PARKED,
            RouteSource::Listed(legs, repeat) => {
                self.motion.plans.list(legs, repeat == Repeat::Loop)
            }
            RouteSource::Random => Route::WALK,
        }
    }

    fn spawn_point(&self, placement: Placement) -> Result<SpawnPoint, Refusal> {
        let graph = &self.graph;
        match placement {
            Placement::Node(node) => {
                graph.nodes().get(node.0 as usize).ok_or(Refusal::UnknownNode)?;
                Ok(SpawnPoint {
                    piece: self.motion.legs.node_piece(node),
                    edge: None,
                    w: 0,
                    ahead: node,
                })
            }
            Placement::Edge(edge, s) => {
                let ahead =
                    graph.edges().get(edge.0 as usize).ok_or(Refusal::UnknownEdge)?.destination;
                let (piece, w) =
                    self.piece_at(edge, f64::from(s)).ok_or(Refusal::DistanceOutOfRange)?;
                Ok(SpawnPoint { piece, edge: Some(edge.0), w, ahead })
            }
        }
    }

    /// Returns the piece of an edge at `s` metres from its origin, and the distance from the
    /// piece's end; `None` if that is not on the edge.
    fn piece_at(&self, edge: EdgeIndex, s: f64) -> Option<(PieceIndex, i32)> {
        let track = self.motion.legs.tracks().track(Leg { edge, gear: Gear::Forward })?;
        // The published length is an f32, so that much beyond the end is still on the edge.
        if !(0.0..=track.length.max(f64::from(track.length as f32))).contains(&s) {
            return None;
        }
        let mut from_end = track.length - s;
        let mut row = track.last_piece();
        loop {
            let length = self.motion.legs.tracks().infos()[row as usize].length;
            if from_end <= length.to_metres() || row == track.first_piece {
                let w = Distance::from_metres(from_end.max(0.0)).0;
                return Some((self.motion.legs.piece(row, Gear::Forward), -w.min(length.0)));
            }
            from_end -= length.to_metres();
            row -= 1;
        }
    }
}

/// The place of a new robot, as the columns hold it.
pub(super) struct SpawnPoint {
    piece: PieceIndex,
    edge: Option<u32>,
    w: i32,
    /// The node from which its route continues.
    ahead: NodeIndex,
}

/// Checks that a listed route can be driven from a node.
fn check_list(
    graph: &RouteGraph,
    start: NodeIndex,
    legs: &[Leg],
    repeat: Repeat,
) -> Result<(), Refusal> {
    let (first, last) = legs.first().zip(legs.last()).ok_or(Refusal::MalformedRoute)?;
    if legs.iter().any(|leg| leg.edge.0 as usize >= graph.edges().len()) {
        return Err(Refusal::UnknownEdge);
    }
    check_connected(graph, start, legs)?;
    if repeat == Repeat::Loop && graph.leg_end(*last) != graph.leg_start(*first) {
        return Err(Refusal::NotConnected);
    }
    Ok(())
}

/// Checks that legs of the graph start at a node and each continues where the one before it ends.
pub(super) fn check_connected(
    graph: &RouteGraph,
    start: NodeIndex,
    legs: &[Leg],
) -> Result<(), Refusal> {
    let mut node = start;
    for &leg in legs {
        graph.leg_speed(leg).ok_or(Refusal::NoReverse)?;
        if graph.leg_start(leg) != node {
            return Err(Refusal::NotConnected);
        }
        node = graph.leg_end(leg);
    }
    Ok(())
}
