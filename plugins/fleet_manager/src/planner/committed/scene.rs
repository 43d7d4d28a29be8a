//! The constraints of a search for a way.

use super::Committed;
use super::blocks::key_count;
use crate::roads::{Leg, Roads};
use crate::traffic::Traffic;

/// The cost of a leg that a robot blocks which is going to drive on, in seconds.
const STANDING_SECS: f32 = 5.0;
/// The cost of a leg for each robot that is committed to drive it in the other direction, in
/// seconds.
const OPPOSING_SECS: f32 = 3.0;

/// The constraints of a search for a robot's way, made by the other robots and by closures.
pub struct Scene {
    /// By key: whether it is closed, or a robot without a way blocks it.
    pub is_blocked: Vec<bool>,
    /// By key: whether a robot that drives on blocks it, or a way ends there.
    pub is_slow: Vec<bool>,
    /// By leg: how many ways lead over it in the other direction.
    pub opposing: Vec<u16>,
    /// The cost of each of them.
    pub opposing_secs: f32,
    /// By node: whether a way ends there, or a robot stands there that stays.
    pub is_taken: Vec<bool>,
    /// By node: whether it is another robot's goal.
    pub is_wanted: Vec<bool>,
}

impl Scene {
    pub(super) fn cost(&self, leg: Leg) -> Option<f32> {
        let index = leg.index();
        let slow = if self.is_slow[index] { STANDING_SECS } else { 0.0 };
        let opposing = self.opposing_secs * f32::from(self.opposing[index]);
        (!self.is_blocked[index]).then_some(slow + opposing)
    }
}

impl Committed {
    /// Collects the constraints of a robot's way.
    ///
    /// Robots without a way block it for good, but not those that are `released`: they are going to
    /// get one, too.
    pub(super) fn scene(&mut self, traffic: &Traffic<'_>, own: u32, released: &[u32]) -> Scene {
        let roads = traffic.roads;
        let mut scene = Scene {
            is_blocked: vec![false; key_count(roads)],
            is_slow: vec![false; key_count(roads)],
            opposing: vec![0; 2 * roads.edges().len()],
            opposing_secs: OPPOSING_SECS,
            is_taken: vec![false; roads.nodes() as usize],
            is_wanted: vec![false; roads.nodes() as usize],
        };
        scene.is_blocked[..traffic.closed.len()].copy_from_slice(traffic.closed);
        for (robot, state) in traffic.robots().filter(|(robot, _)| *robot != own) {
            if let Some(goal) = state.goal() {
                scene.is_wanted[goal as usize] = true;
            }
            let Some(&end) = traffic.claims.end(robot) else { continue };
            let goes_on = released.contains(&robot) || self.goes_on(traffic, robot);
            for key in self.blocks.of(roads, state.class.footprint, &end) {
                let blocks = if goes_on { &mut scene.is_slow } else { &mut scene.is_blocked };
                blocks[key as usize] = true;
            }
            if !goes_on && let Some((_, node)) = traffic.base_end(robot) {
                scene.is_taken[node as usize] = true;
            }
            let Some(commitment) = self.commitments[robot as usize].as_ref() else { continue };
            scene.is_taken[commitment.end as usize] = true;
            if let Some(&last) = commitment.way.last() {
                for &key in self.blocks.at_end(roads, state.class.footprint, last) {
                    scene.is_slow[key as usize] = true;
                }
            }
            for &leg in &commitment.way {
                oppose(roads, leg, &mut scene.opposing);
            }
        }
        scene
    }
}

/// Counts a leg against all that lead the other way between the same nodes.
fn oppose(roads: &Roads, leg: Leg, counts: &mut [u16]) {
    let (start, end) = (roads.start(leg), roads.end(leg));
    for &other in roads.exits(end).iter().filter(|&&other| roads.end(other) == start) {
        counts[other.index()] += 1;
    }
}
