//! Requests of doors and lifts: ahead of the robots that need them.
//!
//! A robot that waits before a door or for a cabin requests it by itself, in the engine. The
//! manager does so earlier, so that it needn't wait. A cabin is called for one robot at a time: for
//! one that holds the lift by its claim or, if there is none, for the one that comes first.

use std::collections::BTreeMap;

use regatta_plugin::World;
use regatta_plugin::command::REQUEST_SECS;

use crate::roads::{Leg, Roads};
use crate::steering::Steering;

/// The time after which a request is sent again, in seconds: it ends after [`REQUEST_SECS`].
const RENEWAL_SECS: f64 = 0.5 * REQUEST_SECS;

/// The time by which a door is requested before it has to begin to open, in seconds.
const MARGIN_SECS: f32 = 2.0;

/// The place of an edge in a lift.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Part {
    /// It leads into the cabin or out of it, at the level of this node.
    Doorway(u32),
    /// It leads from level to level.
    Ride,
}

/// The request of a command to a facility.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ask {
    /// Open the doors across an edge, by its id, or keep them open.
    Door(u32),
    /// Don't keep them open any more.
    ReleaseDoor(u32),
    /// Call the lift with a node, by its id, to the level of that node.
    Lift(u32),
    /// End the call of that lift.
    ReleaseLift(u32),
}

/// A command to a door or a lift, for a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FacilityCommand {
    /// The robot.
    pub robot: u32,
    /// The request.
    pub ask: Ask,
}

/// The doors and lifts of a world, and the requests that were made.
#[derive(Debug, Default)]
pub struct Facilities {
    /// By edge: the seconds that the slowest of its doors takes to open.
    doors: BTreeMap<u32, f32>,
    /// By edge: its lift and its part in it.
    parts: BTreeMap<u32, (u32, Part)>,
    /// By node in a cabin: its level, counted from the lowest of its lift.
    levels: BTreeMap<u32, usize>,
    /// By lift: the longest time until the cabin is there, in seconds.
    coming_secs: Vec<f32>,
    /// The requests of doors by robot and edge, with the time of the last command.
    open: BTreeMap<(u32, u32), f64>,
    /// By lift.
    called: BTreeMap<u32, Call>,
    commands: Vec<FacilityCommand>,
}

/// A call of a lift for a robot to the level of a node.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Call {
    robot: u32,
    node: u32,
    /// The simulated time of the last command, in seconds.
    at: f64,
}

/// The need of a robot for a lift.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Need {
    robot: u32,
    node: u32,
    /// Whether it doesn't hold the lift yet, and the seconds until it comes to it. The lowest
    /// counts first.
    order: (bool, f32),
}

impl Facilities {
    /// Reads the doors and lifts of a world.
    pub fn new(world: &World<'_>) -> Self {
        let mut facilities = Self::default();
        for door in world.doors() {
            for edge in world.door_edges(door) {
                let secs = facilities.doors.entry(*edge).or_insert(0.0);
                *secs = secs.max(door.opening_secs);
            }
        }
        for (index, lift) in (0..).zip(world.lifts()) {
            let levels = world.lift_levels(lift).iter();
            let nodes = levels.flat_map(|level| world.level_nodes(level));
            let nodes: Vec<u32> = nodes.copied().collect();
            for (number, level) in world.lift_levels(lift).iter().enumerate() {
                let nodes = world.level_nodes(level).iter();
                facilities.levels.extend(nodes.map(|node| (*node, number)));
            }
            facilities.add_parts(world, index, &nodes, world.lift_rides(lift));
            let gaps = lift.levels.saturating_sub(1) as f32;
            let doors_secs = lift.opening_secs + lift.closing_secs;
            facilities.coming_secs.push(gaps * lift.level_secs + doors_secs);
        }
        facilities
    }

    /// Adds the edges of a lift with these nodes.
    fn add_parts(&mut self, world: &World<'_>, lift: u32, nodes: &[u32], rides: &[u32]) {
        for (index, edge) in (0..).zip(world.edges()) {
            let inside = [edge.origin, edge.destination].into_iter();
            let stop = inside.clone().find(|node| nodes.contains(node));
            let part = match stop {
                _ if rides.contains(&index) => Part::Ride,
                Some(node) => Part::Doorway(node),
                None => continue,
            };
            self.parts.insert(index, (lift, part));
        }
    }

    /// Returns the commands of a cycle at a simulated time in seconds: requests that are new, or
    /// are to be renewed, and the ends of those that aren't needed any more.
    pub fn request(&mut self, steering: &Steering, now: f64) -> &[FacilityCommand] {
        self.commands.clear();
        if self.doors.is_empty() && self.parts.is_empty() {
            return &self.commands;
        }
        let mut doors = Vec::new();
        let mut needs: BTreeMap<u32, Need> = BTreeMap::new();
        for robot in steering.robots() {
            self.look_ahead(steering, robot, &mut doors, &mut needs);
        }
        self.request_doors(steering.roads(), &doors, now);
        self.call_lifts(steering.roads(), &needs, now);
        &self.commands
    }

    /// Finds the doors and the first lift that a robot comes to soon.
    fn look_ahead(
        &self,
        steering: &Steering,
        robot: u32,
        doors: &mut Vec<(u32, u32)>,
        needs: &mut BTreeMap<u32, Need>,
    ) {
        let Some(state) = steering.robot(robot).filter(|state| !state.is_adopted()) else { return };
        let roads = steering.roads();
        let (way, held) = way_of(steering, robot);
        let (mut secs, mut has_lift) = (0.0, false);
        for (number, step) in way.iter().enumerate() {
            let edge = step.leg.edge();
            let is_held = number < held;
            if let Some(opening_secs) = self.doors.get(&edge)
                && secs <= opening_secs + MARGIN_SECS
            {
                doors.push((robot, edge));
            }
            if let Some((lift, part)) = self.parts.get(&edge).filter(|_| !has_lift) {
                has_lift = true;
                let is_soon = is_held || secs <= self.coming_secs[*lift as usize];
                if let Some(node) = self.stop(roads, *part, &way[number..]).filter(|_| is_soon) {
                    let need = Need { robot, node, order: (!is_held, secs) };
                    let first = needs.entry(*lift).or_insert(need);
                    if need.order < first.order {
                        *first = need;
                    }
                }
            }
            secs += step.metres / roads.speed(&state.class, step.leg).max(0.01);
            if secs > LONGEST_LOOK_SECS {
                break;
            }
        }
    }

    /// Returns the node at whose level a robot needs the cabin for a way that begins with a part of
    /// its lift: the end of all rides up, or down, in a row, or that of the doorway.
    fn stop(&self, roads: &Roads, part: Part, way: &[Step]) -> Option<u32> {
        match part {
            Part::Doorway(node) => Some(node),
            Part::Ride => {
                let level = |node: u32| self.levels.get(&node).copied();
                let first = way.first()?.leg;
                let (from, mut node) = (level(roads.start(first))?, roads.end(first));
                let is_up = level(node)? > from;
                for step in &way[1..] {
                    let (here, next) = (level(node)?, roads.end(step.leg));
                    match level(next) {
                        Some(there) if there != here && (there > here) == is_up => node = next,
                        _ => break,
                    }
                }
                Some(node)
            }
        }
    }

    fn request_doors(&mut self, roads: &Roads, wanted: &[(u32, u32)], now: f64) {
        let ended: Vec<_> = self.open.keys().filter(|key| !wanted.contains(key)).copied().collect();
        for key @ (robot, edge) in ended {
            self.open.remove(&key);
            let ask = Ask::ReleaseDoor(roads.edge(edge).id);
            self.commands.push(FacilityCommand { robot, ask });
        }
        for &(robot, edge) in wanted {
            let is_fresh = self.open.get(&(robot, edge)).is_some_and(|at| now - at < RENEWAL_SECS);
            if !is_fresh {
                self.open.insert((robot, edge), now);
                let ask = Ask::Door(roads.edge(edge).id);
                self.commands.push(FacilityCommand { robot, ask });
            }
        }
    }

    fn call_lifts(&mut self, roads: &Roads, needs: &BTreeMap<u32, Need>, now: f64) {
        let is_over = |(lift, call): &(&u32, &Call)| {
            needs.get(lift).is_none_or(|need| need.robot != call.robot)
        };
        let ended: Vec<(u32, Call)> =
            self.called.iter().filter(is_over).map(|(lift, call)| (*lift, *call)).collect();
        for (lift, call) in ended {
            self.called.remove(&lift);
            let ask = Ask::ReleaseLift(roads.node_id(call.node));
            self.commands.push(FacilityCommand { robot: call.robot, ask });
        }
        for (lift, need) in needs {
            let call = Call { robot: need.robot, node: need.node, at: now };
            let is_fresh = self
                .called
                .get(lift)
                .is_some_and(|last| last.node == call.node && now - last.at < RENEWAL_SECS);
            if !is_fresh {
                self.called.insert(*lift, call);
                let ask = Ask::Lift(roads.node_id(call.node));
                self.commands.push(FacilityCommand { robot: call.robot, ask });
            }
        }
    }
}

/// The longest time ahead for which robots' ways are looked at, in seconds.
const LONGEST_LOOK_SECS: f32 = 120.0;

/// The metres to the end of an edge within which a robot counts as being there.
const AT_END: f32 = 2e-3;

/// A leg that is ahead of a robot, with the metres of it that are.
#[derive(Clone, Copy, Debug)]
struct Step {
    leg: Leg,
    metres: f32,
}

/// Returns the legs ahead of a robot, and how many of them it claims.
fn way_of(steering: &Steering, robot: u32) -> (Vec<Step>, usize) {
    let roads = steering.roads();
    let mut way: Vec<Step> = Vec::new();
    for (number, stretch) in steering.claims().of(robot).iter().enumerate() {
        let Some(leg) = stretch.leg else { continue };
        let length = roads.edge(leg.edge()).length;
        let metres = length - stretch.from;
        // Rides may be as short as that.
        let is_driven = number == 0 && metres <= AT_END.min(0.5 * length);
        if !is_driven {
            way.push(Step { leg, metres });
        }
    }
    let held = way.len();
    let horizon = steering.robot(robot).into_iter().flat_map(|state| state.horizon.iter());
    way.extend(horizon.map(|&leg| Step { leg, metres: roads.edge(leg.edge()).length }));
    (way, held)
}

#[cfg(test)]
mod tests;
