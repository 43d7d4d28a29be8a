//! The choice of a planner for some roads and robots.

use super::{PlannerKind, two_way_share};
use crate::model::worlds;
use crate::roads::Roads;
use regatta_plugin::world::WorldData;

/// The name of the planner that is chosen for some robots.
fn chosen(world: &WorldData, robots: usize) -> String {
    let roads = Roads::new(&world.view(1, 1));
    let (planner, _) = PlannerKind::Auto.planner(&roads, robots);
    format!("{planner:?}")
}

#[test]
fn single_tracks_get_committed_ways_while_all_robots_can_rest() {
    let track = worlds::single_track(7);
    assert!(chosen(&track, 6).starts_with("Committed"), "six rest places");
    assert!(!chosen(&track, 7).starts_with("Committed"));
}

#[test]
fn one_way_streets_get_lanes_unless_robots_crowd_short_blocks() {
    let (long, short) = (worlds::streets(6, 8.0, true), worlds::streets(6, 3.0, true));
    assert!(two_way_share(&Roads::new(&long.view(1, 1))) < 0.01);
    assert!(chosen(&long, 20).contains("planner: Lanes"));
    assert!(chosen(&short, 3).contains("planner: Lanes"));
    assert!(chosen(&short, 20).contains("planner: Pibt"));
}
