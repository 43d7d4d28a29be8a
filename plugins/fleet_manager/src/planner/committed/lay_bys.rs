//! Lay-bys: nodes of one-way roads where robots may wait if no rest place is left.
//!
//! A robot there is only in the way of robots that follow it. All can go on as long as there is
//! room on the roads.

use super::blocks::{Blocks, Key};
use crate::roads::{Leg, Roads};

/// The least number of lay-bys that stay free: robots on a full ring can't move.
const LEAST_FREE: usize = 2;

/// The lay-bys of some roads.
#[derive(Debug)]
pub struct LayBys {
    nodes: Vec<u32>,
    /// By node.
    is_lay_by: Vec<bool>,
}

impl LayBys {
    /// Finds the nodes where a robot blocks only legs that aren't driven in the other direction,
    /// too.
    pub fn new(roads: &Roads, blocks: &mut Blocks) -> Self {
        let mut is_lay_by = vec![true; roads.nodes() as usize];
        let mut has_arrival = vec![false; roads.nodes() as usize];
        let legs = (0..roads.nodes()).flat_map(|node| roads.exits(node).iter().copied());
        for leg in legs {
            let end = roads.end(leg) as usize;
            has_arrival[end] = true;
            for footprint in 0..roads.footprints().len() {
                let blocked = blocks.at_end(roads, footprint, leg);
                is_lay_by[end] &= blocked.iter().all(|&key| !is_two_way(roads, key));
            }
        }
        for (node, is_lay_by) in (0..).zip(&mut is_lay_by) {
            *is_lay_by &= has_arrival[node as usize] && !roads.exits(node).is_empty();
        }
        let nodes = (0..roads.nodes()).filter(|&node| is_lay_by[node as usize]).collect();
        Self { nodes, is_lay_by }
    }

    /// Whether a node is a lay-by.
    pub fn contains(&self, node: u32) -> bool {
        self.is_lay_by[node as usize]
    }

    /// Whether another robot may wait at a lay-by. `is_taken` says of each node whether a robot
    /// stands there, or is going to.
    pub fn has_room(&self, is_taken: &[bool]) -> bool {
        self.nodes.iter().filter(|&&node| !is_taken[node as usize]).nth(LEAST_FREE).is_some()
    }
}

/// Whether the leg with a key is driven in the other direction, too.
fn is_two_way(roads: &Roads, key: Key) -> bool {
    if key as usize >= 2 * roads.edges().len() {
        return false;
    }
    let leg = Leg::from_index(key);
    if roads.allowed_speed(leg) == 0.0 {
        return false;
    }
    let (start, end) = (roads.start(leg), roads.end(leg));
    roads.exits(end).iter().any(|&other| roads.end(other) == start)
}
