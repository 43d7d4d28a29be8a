//! Keeps robots in the planned order: nobody gets a leg before all have got theirs that come
//! earlier where it leads.

use std::collections::BTreeMap;

use super::Path;
use super::space::Space;
use crate::planner::Plans;
use crate::traffic::Traffic;

/// The legs beyond a base that are looked at.
const MOST_LEGS: usize = 8;

/// The time that a robot waits for another one in its way before nobody is held back for it any
/// more, in seconds.
const STUCK_SECS: f64 = 4.0;

/// When a robot gets a leg, by the plan: the layer, and its rank among those of the same layer.
type Turn = (u16, usize);

/// Holds robots back that would be too early somewhere.
pub(super) fn keep(
    traffic: &Traffic<'_>,
    space: &Space,
    paths: &BTreeMap<u32, Path>,
    ranks: &[u32],
    plans: &mut Plans,
) {
    let mut turns: Vec<Vec<(Turn, u32)>> = vec![Vec::new(); traffic.roads.edges().len()];
    let is_stuck = |robot: u32| {
        traffic.robot(robot).is_none_or(|state| traffic.now - state.waiting_since >= STUCK_SECS)
    };
    for (rank, robot) in ranks.iter().enumerate().filter(|(_, robot)| !is_stuck(**robot)) {
        for step in paths.get(robot).into_iter().flat_map(|path| &path.steps[path.done + 1..]) {
            turns[step.leg.edge() as usize].push(((step.layer, rank), *robot));
        }
    }
    for (rank, robot) in ranks.iter().enumerate() {
        let Some(path) = paths.get(robot) else { continue };
        let ahead = &path.steps[path.done + 1..];
        let is_early = |edge: u32, turn: Turn| {
            let others = space.near(edge).iter().flat_map(|&near| &turns[near as usize]);
            others.into_iter().any(|(other, who)| who != robot && *other < turn)
        };
        let legs = ahead
            .iter()
            .take(MOST_LEGS)
            .position(|step| is_early(step.leg.edge(), (step.layer, rank)));
        if let Some(legs) = legs {
            plans.permit(*robot).max_legs = legs;
        }
    }
}
