//! Reservoirs: edges on which robots may queue without being in the way of others.
//!
//! A *lane* is a chain of edges between places where roads part, meet or cross: who is in it can
//! only follow who is ahead. A lane that holds several robots is a *reservoir*.

use super::{Leg, Roads};

/// The fewest robots that a reservoir holds.
const FEWEST_ROBOTS: f32 = 4.0;

/// Returns for each edge whether it belongs to a reservoir.
pub(super) fn reservoirs(roads: &Roads) -> Vec<bool> {
    let mut degrees = vec![[0_u32; 2]; roads.nodes() as usize];
    for edge in roads.edges() {
        degrees[edge.origin as usize][1] += 1;
        degrees[edge.destination as usize][0] += 1;
    }
    let is_through = |node: u32| degrees[node as usize] == [1, 1];
    let mut is_reservoir = vec![false; roads.edges().len()];
    for edge in 0..roads.edges().len() as u32 {
        let mut lane = vec![edge];
        if is_through(roads.edge(edge).origin) || !holds_queue(roads, edge) {
            continue;
        }
        while let Some(&last) = lane.last()
            && is_through(roads.edge(last).destination)
            && let Some(next) = only_exit(roads, roads.edge(last).destination)
            && holds_queue(roads, next)
            && next != edge
        {
            lane.push(next);
        }
        let length: f32 = lane.iter().map(|&edge| roads.edge(edge).length).sum();
        if length >= FEWEST_ROBOTS * separation(roads, edge) {
            lane.into_iter().for_each(|edge| is_reservoir[edge as usize] = true);
        }
    }
    is_reservoir
}

fn only_exit(roads: &Roads, node: u32) -> Option<u32> {
    roads.exits(node).iter().copied().find(|leg| !leg.is_reverse()).map(Leg::edge)
}

/// Whether a robot somewhere on an edge, but near its ends, is in nobody's way but on its lane.
fn holds_queue(roads: &Roads, edge: u32) -> bool {
    let length = roads.edge(edge).length;
    roads.footprints().iter().enumerate().all(|(footprint, _)| {
        let stops = roads.stops(footprint);
        stops.closed_length(edge) < 0.5 * length
    })
}

fn separation(roads: &Roads, edge: u32) -> f32 {
    let footprints = roads.footprints().len();
    (0..footprints)
        .map(|own| roads.conflicts().table(own, own).separation(edge))
        .fold(0.0, f32::max)
}
