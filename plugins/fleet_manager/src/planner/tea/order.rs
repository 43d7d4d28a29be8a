//! Keeps robots in the planned order: a robot gets a leg only after all robots that come earlier
//! there have got theirs.

use std::collections::BTreeMap;

use super::Path;
use super::space::Space;
use crate::planner::Plans;
use crate::traffic::Traffic;

/// The number of legs beyond a base that are checked.
const MOST_LEGS: usize = 8;

/// The time that a robot waits for another one in its way before no other robot is held back for it
/// any more, in seconds.
const STUCK_SECS: f64 = 4.0;

/// The planned turn of a robot on a leg: the layer, and its rank among those of the same layer.
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
    for (rank, robot) in ranks.iter().enumerate() {
        let Some(state) = traffic.robot(*robot) else { continue };
        if traffic.now - state.waiting_since >= STUCK_SECS {
            continue;
        }
        for step in paths.get(robot).into_iter().flat_map(|path| &path.steps[path.done + 1..]) {
            turns[step.leg.edge() as usize].push(((step.layer, rank), *robot));
        }
    }
    for (rank, robot) in ranks.iter().enumerate() {
        let Some(path) = paths.get(robot) else { continue };
        let legs = path.steps[path.done + 1..].iter().take(MOST_LEGS).position(|step| {
            let near = space.near(step.leg.edge());
            let mut others = near.iter().flat_map(|&near| &turns[near as usize]);
            others.any(|(other, holder)| holder != robot && *other < (step.layer, rank))
        });
        if let Some(legs) = legs {
            plans.permit(*robot).max_legs = legs;
        }
    }
}
