//! Hops: the ways from place to place.

use crate::roads::{Leg, Roads};

/// The largest number of legs of a hop.
const MOST_LEGS: usize = 6;
/// The largest number of hops that leave a node.
const MOST_HOPS: usize = 24;

/// A way to a place.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Hop {
    /// From the place before.
    pub legs: Vec<Leg>,
    /// The node where it ends.
    pub place: u32,
    /// Driving time, in seconds.
    pub secs: f64,
}

/// The hops of some roads.
#[derive(Debug)]
pub(super) struct Hops {
    /// By node.
    from: Vec<Vec<Hop>>,
}

impl Hops {
    pub(super) fn new(roads: &Roads) -> Self {
        Self { from: (0..roads.nodes()).map(|node| hops(roads, node)).collect() }
    }

    /// The hops that leave a node.
    pub(super) fn from(&self, node: u32) -> &[Hop] {
        &self.from[node as usize]
    }
}

/// Finds the hops that leave a node: those of fewer legs come first.
fn hops(roads: &Roads, node: u32) -> Vec<Hop> {
    let mut hops: Vec<Hop> = Vec::new();
    let mut open = vec![Hop { legs: Vec::new(), place: node, secs: 0.0 }];
    while let Some(way) = open.pop() {
        for &leg in roads.exits(way.place).iter().filter(|leg| !leg.is_reverse()) {
            let edge = roads.edge(leg.edge());
            let mut legs = way.legs.clone();
            legs.push(leg);
            let secs = way.secs + f64::from(edge.length / edge.speeds[0].max(1e-3));
            let hop = Hop { legs, place: roads.end(leg), secs };
            if hop.place == node || hops.len() >= MOST_HOPS {
                continue;
            }
            match roads.is_place(leg) {
                true => hops.push(hop),
                false if hop.legs.len() < MOST_LEGS => open.push(hop),
                false => {}
            }
        }
    }
    hops.sort_by(|a, b| a.legs.len().cmp(&b.legs.len()).then(a.secs.total_cmp(&b.secs)));
    // A place is reached by one of the ways only.
    let mut places: Vec<u32> = Vec::new();
    hops.retain(|hop| {
        let is_new = !places.contains(&hop.place);
        places.push(hop.place);
        is_new
    });
    hops
}
