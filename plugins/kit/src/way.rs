//! The fastest way of a robot to a node, over the edges of a world that are open.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};
use std::time::Duration;

use regatta_plugin::command::RouteLeg;
use regatta_plugin::frame::{Frame, NO_EDGE, RobotState};
use regatta_plugin::{
    ClosureReader, OpenError, Participant, ReadError, RouteClient, RouteError, Subscriber, World,
};

/// The time within which a running fleet publishes a frame.
const TIMEOUT: Duration = Duration::from_secs(5);

/// A producer gives late readers the closures that they missed right after a frame.
const AFTER_FRAME: Duration = Duration::from_millis(5);

/// The error of looking for a way, or for a node.
#[derive(Debug, thiserror::Error)]
pub enum WayError {
    /// A port of the fleet can't be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// A port of the fleet can't be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The engine doesn't say which way the robot drives.
    #[error(transparent)]
    Route(#[from] RouteError),
    /// No frame came.
    #[error("the fleet has published no frame; is it running?")]
    NoFrame,
    /// The fleet has no such robot.
    #[error("there is no robot {0}")]
    UnknownRobot(u32),
    /// No node has this id or name.
    #[error("no node has the id or the name '{0}'")]
    UnknownNode(String),
    /// Several nodes have this name.
    #[error("several nodes are called '{0}'; give the id of one")]
    AmbiguousNode(String),
    /// The robot is at the node already.
    #[error("the robot is at node {node} already, or its edge ends there")]
    AtGoal {
        /// Id of the node.
        node: u32,
    },
    /// The nodes are not connected by edges that may be driven.
    #[error(
        "no way leads from node {from} to node {to}{}{}",
        if *closed > 0 { format!("; {closed} edges are closed") } else { String::new() },
        if *reverse { "" } else { "; reverse gear may help" }
    )]
    NoWay {
        /// Id of the node that the robot's edge leads to.
        from: u32,
        /// Id of the goal.
        to: u32,
        /// Number of closed edges.
        closed: usize,
        /// Whether reverse gear was allowed.
        reverse: bool,
    },
}

/// Returns the fastest way from where a robot's edge ends to a node, given by its index.
///
/// # Errors
/// See [`WayError`].
pub fn way_to(
    participant: &Participant,
    world: &World<'_>,
    robot: u32,
    goal: usize,
    reverse: bool,
) -> Result<Vec<RouteLeg>, WayError> {
    let (mut closures, mut frames) =
        (ClosureReader::open_on(participant)?, Subscriber::open_on(participant)?);
    let frame = frames.wait(TIMEOUT)?.ok_or(WayError::NoFrame)?;
    if robot as usize >= frame.len() || frame.state_of(robot as usize) == RobotState::Absent {
        return Err(WayError::UnknownRobot(robot));
    }
    std::thread::sleep(AFTER_FRAME);
    closures.take()?;
    let closed: BTreeSet<u32> =
        closures.closed(frame.run_id()).iter().map(|closed| closed.edge).collect();
    let start = start_of(participant, world, &frame, robot)?;
    let [from, to] =
        [start, goal].map(|node| world.nodes().get(node).map_or(u32::MAX, |node| node.id));
    if start == goal {
        return Err(WayError::AtGoal { node: to });
    }
    let legs = fastest(start, goal, &exits(world, reverse, &closed));
    legs.ok_or(WayError::NoWay { from, to, closed: closed.len(), reverse })
}

/// Returns the index of a node, by id or else by name; by the name of a station there if no node
/// has it; or else by `n12`, as the search of the window takes it.
///
/// # Errors
/// [`WayError::UnknownNode`] or [`WayError::AmbiguousNode`].
pub fn find_node(world: &World<'_>, node: &str) -> Result<usize, WayError> {
    let mut named: Vec<usize> = (0..)
        .zip(world.nodes())
        .filter(|(_, other)| !node.is_empty() && world.text(other.name) == node)
        .map(|(index, _)| index)
        .collect();
    if named.is_empty() {
        let others = world.other_names().iter();
        let others = others.filter(|other| !node.is_empty() && world.text(other.name) == node);
        named = others.map(|other| other.node as usize).collect();
        named.dedup();
    }
    match (find_id(world, node), &named[..]) {
        (Some(index), _) | (None, &[index]) => Ok(index),
        (None, []) => {
            let lettered = node.strip_prefix('n').and_then(|id| find_id(world, id));
            lettered.ok_or_else(|| WayError::UnknownNode(node.to_owned()))
        }
        (None, _) => Err(WayError::AmbiguousNode(node.to_owned())),
    }
}

fn find_id(world: &World<'_>, id: &str) -> Option<usize> {
    let id = id.parse::<u32>().ok()?;
    world.nodes().iter().position(|node| node.id == id)
}

/// Returns the node from which a new route of a robot starts.
fn start_of(
    participant: &Participant,
    world: &World<'_>,
    frame: &Frame<'_>,
    robot: u32,
) -> Result<usize, WayError> {
    let row = robot as usize;
    let edge = frame.edge()[row];
    let Some(record) = world.edges().get(edge as usize).filter(|_| edge != NO_EDGE) else {
        return Ok(nearest_node(world, [frame.x()[row], frame.y()[row]]));
    };
    let route = RouteClient::open_on(participant)?.route(robot)?;
    let on = route.legs().next().filter(|leg| leg.edge == edge && leg.released);
    let is_at_origin = frame.s()[row] <= 0.0;
    let is_reverse = on.map_or(is_at_origin, |leg| leg.reverse);
    Ok(if is_reverse { record.origin } else { record.destination } as usize)
}

fn nearest_node(world: &World<'_>, [x, y]: [f32; 2]) -> usize {
    let squares = world.nodes().iter().map(|node| (node.x - x).powi(2) + (node.y - y).powi(2));
    let nearest = squares.enumerate().min_by(|one, other| one.1.total_cmp(&other.1));
    nearest.map_or(0, |(node, _)| node)
}

/// Returns the legs of the way with the shortest driving time, by Dijkstra's algorithm.
fn fastest(start: usize, goal: usize, exits: &[Vec<Exit>]) -> Option<Vec<RouteLeg>> {
    let mut before: Vec<Option<(usize, RouteLeg)>> = vec![None; exits.len()];
    let mut times = vec![u64::MAX; exits.len()];
    times[start] = 0;
    let mut queue = BinaryHeap::from([Reverse((0, start))]);
    while let Some(Reverse((time, node))) = queue.pop() {
        if node == goal {
            break;
        }
        if time > times[node] {
            continue;
        }
        for &Exit { leg, to, nanos } in &exits[node] {
            if time + nanos < times[to] {
                times[to] = time + nanos;
                before[to] = Some((node, leg));
                queue.push(Reverse((time + nanos, to)));
            }
        }
    }
    let mut legs = Vec::new();
    let mut node = goal;
    while node != start {
        let (from, leg) = before[node]?;
        legs.push(leg);
        node = from;
    }
    legs.reverse();
    Some(legs)
}

/// A leg that leaves a node.
#[derive(Clone, Copy)]
struct Exit {
    leg: RouteLeg,
    /// Index of the node that it leads to.
    to: usize,
    /// The driving time, in nanoseconds.
    nanos: u64,
}

impl Exit {
    fn new(leg: RouteLeg, to: u32, length: f32, speed: f32) -> Self {
        let nanos = (f64::from(length) / f64::from(speed) * 1e9) as u64 + 1;
        Self { leg, to: to as usize, nanos }
    }
}

/// Returns the open legs that leave each node. `closed` has ids of edges.
fn exits(world: &World<'_>, reverse: bool, closed: &BTreeSet<u32>) -> Vec<Vec<Exit>> {
    let mut exits = vec![Vec::new(); world.nodes().len()];
    for edge in world.edges().iter().filter(|edge| !closed.contains(&edge.id)) {
        let leg = RouteLeg::forward(edge.id);
        let exit = Exit::new(leg, edge.destination, edge.length, edge.speed);
        exits[edge.origin as usize].push(exit);
        if reverse && edge.reverse_speed > 0.0 {
            let leg = RouteLeg::reverse(edge.id);
            let exit = Exit::new(leg, edge.origin, edge.length, edge.reverse_speed);
            exits[edge.destination as usize].push(exit);
        }
    }
    exits
}

#[cfg(test)]
mod tests {
    use super::*;
    use regatta_plugin::world::{CurveRecord, EdgeRecord, NodeRecord, WorldData};

    #[test]
    fn the_fastest_way_goes_round_closed_edges() {
        let mut world = WorldData::default();
        for id in 0..3 {
            world.nodes.push(NodeRecord { id: 10 + id, x: id as f32, ..NodeRecord::default() });
        }
        for (id, origin, destination, length) in [(0, 0, 2, 1.0), (1, 0, 1, 5.0), (2, 1, 2, 5.0)] {
            let edge = EdgeRecord {
                id: 100 + id,
                origin,
                destination,
                length,
                speed: 1.0,
                ..EdgeRecord::default()
            };
            world.add_edge(edge, [CurveRecord::default()]);
        }
        let view = world.view(1, 1);
        let way = |start, goal, closed: &[u32]| {
            let closed = closed.iter().copied().collect();
            fastest(start, goal, &exits(&view, false, &closed))
        };
        assert_eq!(way(0, 2, &[]), Some(vec![RouteLeg::forward(100)]));
        assert_eq!(way(0, 2, &[100]), Some([101, 102].map(RouteLeg::forward).to_vec()));
        assert_eq!(way(0, 2, &[100, 102]), None);
        assert_eq!(find_node(&view, "12").expect("a node"), 2);
        assert!(matches!(find_node(&view, "x"), Err(WayError::UnknownNode(name)) if name == "x"));
    }
}
