//! Legs that are slower than a walk.

use regatta_base::graph::Leg;

use crate::model::route_graph::{RouteGraph, legs};

/// The speed of a slow walk, in metres per second.
pub const WALK: f64 = 0.3;

/// A leg that is slower than a walk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlowLeg {
    /// The leg.
    pub leg: Leg,
    /// Metres per second.
    pub speed: f64,
    /// The time that robots take to drive it, in seconds.
    pub seconds: f64,
}

/// Returns the legs that are slower than [`WALK`], in the order of the edges; without the rides of
/// lifts.
pub fn slow_legs(graph: &RouteGraph) -> Vec<SlowLeg> {
    let driven = legs(graph.edges()).filter(|leg| !graph.is_ride(leg.edge));
    let slow = driven.filter_map(|leg| {
        let speed = graph.leg_speed(leg).filter(|speed| *speed < WALK)?;
        let seconds = graph.edge(leg.edge).path.length() / speed;
        Some(SlowLeg { leg, speed, seconds })
    });
    slow.collect()
}
