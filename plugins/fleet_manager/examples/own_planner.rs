//! A planner of your own: always the fewest edges, whoever else is there.
//!
//! `cargo run -p regatta-fleet-manager --example own_planner -- --load load.yaml` manages the fleet
//! that runs.

use std::collections::VecDeque;

use regatta_fleet_manager::planner::{Planner, Plans};
use regatta_fleet_manager::roads::{Leg, Roads};
use regatta_fleet_manager::run_with;
use regatta_fleet_manager::traffic::Traffic;

#[derive(Debug)]
struct FewestEdges;

impl Planner for FewestEdges {
    fn plan(&mut self, traffic: &Traffic<'_>, plans: &mut Plans) {
        for (robot, state) in traffic.robots().filter(|(_, state)| state.needs_route()) {
            let (Some(goal), Some((_, start))) = (state.goal(), traffic.base_end(robot)) else {
                continue;
            };
            match route(traffic, start, goal) {
                Some(legs) => plans.route(robot, legs),
                None => plans.unreachable(robot),
            }
        }
    }
}

/// Returns the legs of a route with the fewest edges, by breadth-first search.
fn route(traffic: &Traffic<'_>, start: u32, goal: u32) -> Option<Vec<Leg>> {
    let roads: &Roads = traffic.roads;
    let mut arrival: Vec<Option<Leg>> = vec![None; roads.nodes() as usize];
    let mut open = VecDeque::from([start]);
    while let Some(node) = open.pop_front() {
        if node == goal {
            let (mut legs, mut node) = (Vec::new(), goal);
            while node != start {
                let leg = arrival[node as usize]?;
                legs.push(leg);
                node = roads.start(leg);
            }
            legs.reverse();
            return Some(legs);
        }
        for &leg in roads.exits(node) {
            let next = roads.end(leg);
            if next != start && arrival[next as usize].is_none() && !traffic.is_closed(leg) {
                arrival[next as usize] = Some(leg);
                open.push_back(next);
            }
        }
    }
    None
}

fn main() -> regatta_plugin::Result {
    run_with(std::env::args_os(), |_| FewestEdges)
}
