//! Reservoirs: edges on which robots may queue without being in the way of others.
//!
//! A *lane* is a chain of edges between places where roads part, meet or cross: robots on it can
//! only follow each other. A lane that holds several robots is a *reservoir*.

use super::{Leg, Roads};

/// The fewest robots that a reservoir holds.
const FEWEST_ROBOTS: f32 = 4.0;

/// Returns for each edge whether it belongs to a reservoir.
pub(super) fn reservoirs(roads: &Roads) -> Vec<bool> {
    let mut arrivals = vec![0_u32; roads.nodes() as usize];
    let mut exits = arrivals.clone();
    for edge in roads.edges() {
        exits[edge.origin as usize] += 1;
        arrivals[edge.destination as usize] += 1;
    }
    let is_through: Vec<bool> =
        arrivals.iter().zip(exits).map(|(arrivals, exits)| (*arrivals, exits) == (1, 1)).collect();
    let mut is_reservoir = vec![false; roads.edges().len()];
    for edge in 0..roads.edges().len() as u32 {
        let mut lane = vec![edge];
        if is_through[roads.edge(edge).origin as usize] || !holds_queue(roads, edge) {
            continue;
        }
        while let Some(&last) = lane.last()
            && is_through[roads.edge(last).destination as usize]
            && let Some(next) = only_exit(roads, roads.edge(last).destination)
            && holds_queue(roads, next)
            && next != edge
        {
            lane.push(next);
        }
        let length: f32 = lane.iter().map(|&edge| roads.edge(edge).length).sum();
        if length >= FEWEST_ROBOTS * separation(roads, edge) {
            for edge in lane {
                is_reservoir[edge as usize] = true;
            }
        }
    }
    is_reservoir
}

fn only_exit(roads: &Roads, node: u32) -> Option<u32> {
    roads.exits(node).iter().copied().find(|leg| !leg.is_reverse()).map(Leg::edge)
}

/// Whether a robot on an edge, except near its ends, blocks only robots on its own lane.
fn holds_queue(roads: &Roads, edge: u32) -> bool {
    let length = roads.edge(edge).length;
    (0..roads.footprints().len())
        .all(|footprint| roads.stops(footprint).closed_length(edge) < 0.5 * length)
}

fn separation(roads: &Roads, edge: u32) -> f32 {
    let footprints = roads.footprints().len();
    (0..footprints)
        .map(|own| roads.conflicts().table(own, own).separation(edge))
        .fold(0.0, f32::max)
}
