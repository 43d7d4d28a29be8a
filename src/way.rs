//! The fastest way of a robot to a node, over the edges of a world.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::time::Duration;

use regatta_plugin::frame::NO_EDGE;
use regatta_plugin::order::RouteLeg;
use regatta_plugin::{Frame, Participant, RouteClient, Subscriber, World};

use crate::failure::Failure;

/// The time within which a running fleet publishes a frame.
const TIMEOUT: Duration = Duration::from_secs(5);

/// A leg: the index of its edge, and whether it is driven in reverse gear.
type Leg = (usize, bool);

/// Returns the fastest way from where a robot's edge ends to a node, by id or name.
pub fn way_to(
    participant: &Participant,
    world: &World<'_>,
    robot: u32,
    node: &str,
    reverse: bool,
) -> Result<Vec<RouteLeg>, Failure> {
    let goal = find_node(world, node)?;
    let mut frames = Subscriber::open_on(participant)?;
    let frame = frames.wait(TIMEOUT)?.ok_or("the fleet has published no frame; is it running?")?;
    if robot as usize >= frame.len() {
        return Err(format!("there is no robot {robot}").into());
    }
    let start = start_of(participant, world, &frame, robot)?;
    if start == goal {
        return Err(format!("the robot is at node {node} already, or its edge ends there").into());
    }
    let legs = fastest(world, start, goal, reverse).ok_or_else(|| {
        let advice = if reverse { "" } else { "; --reverse also allows reverse gear" };
        format!("no way leads from node {} to node {node}{advice}", world.nodes()[start].id)
    })?;
    let route_leg = |(edge, reverse): Leg| {
        let id = world.edges()[edge].id;
        if reverse { RouteLeg::reverse(id) } else { RouteLeg::forward(id) }
    };
    Ok(legs.into_iter().map(route_leg).collect())
}

/// Returns the index of a node, by id or else by name.
pub fn find_node(world: &World<'_>, node: &str) -> Result<usize, Failure> {
    let by_id = node.parse::<u32>().ok().and_then(|id| world.nodes().iter().position(|node| node.id == id));
    let mut named = (0..).zip(world.nodes()).filter(|(_, other)| !node.is_empty() && world.text(other.name) == node);
    match (by_id, named.next(), named.next()) {
        (Some(index), _, _) | (None, Some((index, _)), None) => Ok(index),
        (None, Some(_), Some(_)) => Err(format!("several nodes are called '{node}'; give the id of one").into()),
        (None, None, _) => Err(format!("no node has the id or the name '{node}'").into()),
    }
}

/// Returns the node from which a new route of a robot starts.
fn start_of(participant: &Participant, world: &World<'_>, frame: &Frame<'_>, robot: u32) -> Result<usize, Failure> {
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
    let square = |index: &usize| {
        let node = &world.nodes()[*index];
        (node.x - x).powi(2) + (node.y - y).powi(2)
    };
    (0..world.nodes().len()).min_by(|one, other| square(one).total_cmp(&square(other))).unwrap_or_default()
}

/// Returns the legs of the way with the shortest driving time, by Dijkstra's algorithm.
fn fastest(world: &World<'_>, start: usize, goal: usize, reverse: bool) -> Option<Vec<Leg>> {
    let exits = exits(world, reverse);
    let mut before: Vec<Option<(usize, Leg)>> = vec![None; world.nodes().len()];
    let mut times = vec![u64::MAX; world.nodes().len()];
    times[start] = 0;
    let mut queue = BinaryHeap::from([Reverse((0, start))]);
    while let Some(Reverse((time, node))) = queue.pop() {
        if node == goal {
            break;
        }
        if time > times[node] {
            continue;
        }
        for &(leg, to, nanos) in &exits[node] {
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

/// Returns, for each node, the legs that leave it, with the node that they lead to and their driving time in nanoseconds.
fn exits(world: &World<'_>, reverse: bool) -> Vec<Vec<(Leg, usize, u64)>> {
    let mut exits = vec![Vec::new(); world.nodes().len()];
    for (index, edge) in world.edges().iter().enumerate() {
        let (origin, destination) = (edge.origin as usize, edge.destination as usize);
        let nanos = |speed: f32| (f64::from(edge.length) / f64::from(speed) * 1e9) as u64 + 1;
        exits[origin].push(((index, false), destination, nanos(edge.velocity_forward)));
        if reverse && edge.velocity_backwards > 0.0 {
            exits[destination].push(((index, true), origin, nanos(edge.velocity_backwards)));
        }
    }
    exits
}
