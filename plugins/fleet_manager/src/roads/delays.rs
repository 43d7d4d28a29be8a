//! The times that doors and lifts cost besides driving, in the costs of routes.

use regatta_plugin::World;
use regatta_plugin::world::LiftRecord;

use super::Road;

/// Adds the delays of a world's doors and lifts to its edges.
pub(super) fn add(world: &World<'_>, edges: &mut [Road]) {
    for door in world.doors() {
        for edge in world.door_edges(door) {
            if let Some(road) = edges.get_mut(*edge as usize) {
                road.delay_secs += door.opening_secs;
            }
        }
    }
    for lift in world.lifts() {
        add_lift(world, lift, edges);
    }
}

/// Adds the delays of a lift: who enters waits for the cabin, which comes from half of its way on
/// average; who rides, for the cabin; who leaves, for the doors.
fn add_lift(world: &World<'_>, lift: &LiftRecord, edges: &mut [Road]) {
    let levels = world.lift_levels(lift);
    let nodes: Vec<u32> =
        levels.iter().flat_map(|level| world.level_nodes(level)).copied().collect();
    let coming_secs = 0.5 * (levels.len() as f32 - 1.0) * lift.level_secs;
    let rides = world.lift_rides(lift);
    for (index, road) in (0..).zip(edges) {
        if rides.contains(&index) {
            road.delay_secs += (lift.level_secs - road.length / road.speed.max(0.01)).max(0.0);
        } else if nodes.contains(&road.destination) {
            road.delay_secs += coming_secs + lift.opening_secs + lift.closing_secs;
        } else if nodes.contains(&road.origin) {
            road.delay_secs += lift.opening_secs;
        }
    }
}
