//! Committed ways where opposing traffic shares tracks, against the model of a fleet.

use super::Committed;
use crate::model::{Model, TICK_SECS, places, worlds};
use crate::planner::{Planner, PlannerKind};
use crate::roads::Roads;
use regatta_plugin::world::WorldData;

fn committed(roads: &Roads) -> Box<dyn Planner> {
    Box::new(Committed::new(roads))
}

/// Drives robots from random node to random node; returns the model.
fn drive(name: &str, world: &WorldData, (robots, seed): (usize, u64), secs: u32) -> Model {
    let settings = PlannerKind::Committed.settings();
    let mut model = Model::new(world, &places(world, robots, seed), seed, settings, committed);
    model.run((secs as f32 / TICK_SECS) as u32);
    println!(
        "{name}, {robots} robots, {secs} s: {} goals, fewest {:?}, longest {:.0} s; {:?}",
        model.total(),
        model.arrivals.iter().min(),
        model.longest_secs(),
        model.counts()
    );
    model
}

#[test]
fn opposing_traffic_shares_a_track() {
    for robots in 1..=5 {
        let model = drive("track", &worlds::single_track(7), (robots, 1), 1_200);
        assert!(model.arrivals.iter().all(|&goals| goals >= 10), "{:?}", model.arrivals);
    }
}

#[test]
fn a_dead_end_is_left_before_it_is_entered() {
    for robots in 1..=3 {
        let model = drive("stub", &worlds::ring_with_stub(3), (robots, 3), 1_200);
        assert!(model.arrivals.iter().all(|&goals| goals >= 4), "{:?}", model.arrivals);
    }
}

#[test]
fn robots_cross_a_grid() {
    let model = drive("grid", &worlds::cells(8), (12, 1), 600);
    assert!(model.arrivals.iter().all(|&goals| goals >= 4), "{:?}", model.arrivals);
}
