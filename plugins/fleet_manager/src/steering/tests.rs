//! Steering against a model of robots that are late, slow and stall at random: none may ever touch
//! another.

use proptest::prelude::*;
use regatta_plugin::world::ZoneRecord;

use super::Settings;
use crate::model::{Model, places, worlds};
use crate::planner::{Lanes, LanesSettings, Planner, PlannerKind, Plans};
use crate::roads::Leg;
use crate::traffic::Traffic;

const SIDE: u32 = 4;
const SPACING: f32 = 3.0;

/// Drives robots to random nodes for some ticks; some of them break down. Returns how often one of
/// the others arrived.
fn drive([robots, broken]: [u32; 2], seed: u64, turns: bool, stalls: u32, ticks: u32) -> u32 {
    let world = worlds::streets(SIDE, SPACING, turns);
    let step = 2 * SIDE * (SIDE - 1) / robots;
    let starts: Vec<_> =
        (0..robots).map(|robot| (Leg::new(robot * step, false), 0.5 * SPACING)).collect();
    let lanes = |roads: &_| Box::new(Lanes::new(roads, LanesSettings::default())) as _;
    let mut model = Model::new(&world, &starts, seed, Settings::default(), lanes);
    model.stalls = stalls;
    model.broken = broken as usize;
    model.run(ticks);
    model.arrivals[broken as usize..].iter().sum()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// However late robots are, whether they turn on the spot or not.
    #[test]
    fn robots_never_touch(robots in 2_u32..20, seed: u64, turns: bool, stalls in 0_u32..30) {
        drive([robots, 0], seed, turns, stalls, 600);
    }
}

/// Robots on streets, some of which are a zone.
#[test]
fn a_zone_is_entered_only_while_it_has_room() {
    let mut arrivals = Vec::new();
    for (capacity, seed) in [(1, 1), (1, 2), (1, 3), (2, 4), (3, 5)] {
        let mut world = worlds::streets(SIDE, SPACING, false);
        let zone = ZoneRecord { capacity, ..ZoneRecord::default() };
        world.add_zone(zone, [], [0, 1, 5, 6, 7, 12, 13]);
        let starts = places(&world, 6, seed);
        let lanes = |roads: &_| PlannerKind::Lanes.planner(roads, 6, None).0;
        let mut model = Model::new(&world, &starts, seed, Settings::default(), lanes);
        model.run(3_000);
        arrivals.push(model.total());
    }
    assert!(arrivals.iter().all(|&count| count > 20), "{arrivals:?} arrivals in five minutes");
}

/// A robot that is taken over within an edge, though it drove in reverse gear, has its commands
/// refused: both of a tick at once.
#[test]
fn refusals_of_one_tick_change_the_gear_once() {
    let world = worlds::streets(SIDE, SPACING, true);
    let lanes = |roads: &_| PlannerKind::Lanes.planner(roads, 1, None).0;
    let starts = [(Leg::new(0, false), 1.0)];
    let mut model = Model::new(&world, &starts, 1, Settings::default(), lanes);
    model.run(20);
    let is_backing = |model: &Model| model.steering.robot(0).expect("a robot").is_backing;
    let before = is_backing(&model);
    model.steering.take_back(0);
    model.steering.take_back(0);
    assert_ne!(is_backing(&model), before);
}

/// A planner that sends a robot back along its edge, and permits it no leg.
#[derive(Debug)]
struct NotBack;

impl Planner for NotBack {
    fn plan(&mut self, _traffic: &Traffic<'_>, plans: &mut Plans) {
        plans.route(0, vec![Leg::new(0, true)]);
        plans.permit(0).max_legs_outside = 0;
    }
}

#[test]
fn a_robot_without_a_permit_does_not_turn_back() {
    let mut world = worlds::streets(SIDE, SPACING, false);
    world.edges[0].reverse_speed = 1.0;
    let starts = [(Leg::new(0, false), SPACING)];
    let mut model = Model::new(&world, &starts, 1, Settings::default(), |_| Box::new(NotBack));
    model.run(50);
    let end = model.steering.claims().end(0).copied().expect("a claim");
    assert_eq!((end.leg, end.to), (Some(Leg::new(0, false)), SPACING));
}

#[test]
fn robots_arrive() {
    for turns in [false, true] {
        let arrivals = drive([4, 0], 7, turns, 5, 3_000);
        assert!(
            arrivals > 40,
            "{arrivals} arrivals of four robots in five minutes; turns: {turns}"
        );
    }
}

#[test]
fn robots_drive_round_those_that_broke_down() {
    let arrivals: Vec<u32> = (0..8).map(|seed| drive([4, 1], seed, false, 0, 3_000)).collect();
    // Without closures there are about fifty.
    assert!(
        arrivals.iter().sum::<u32>() > 120,
        "{arrivals:?} arrivals of three robots in five minutes"
    );
}

/// A robot on long streets that drives in the middle of its base after so many ticks; it asks for
/// a longer one, or not. Returns whether its base was extended in the next tick.
fn is_extended(ticks: u32, asks: bool) -> bool {
    let world = worlds::streets(SIDE, 20.0, false);
    let lanes = |roads: &_| PlannerKind::Lanes.planner(roads, 1, None).0;
    let starts = [(Leg::new(0, false), 1.0)];
    let mut model = Model::new(&world, &starts, 1, Settings::default(), lanes);
    model.run(ticks);
    let before = model.steering.counts.grants;
    if asks {
        model.steering.lengthen_base(0);
    }
    model.run(1);
    model.steering.counts.grants > before
}

#[test]
fn the_base_of_a_robot_that_asks_for_it_is_extended_at_once() {
    let resting: Vec<u32> = (20..60).filter(|ticks| !is_extended(*ticks, false)).collect();
    let extended = resting.iter().filter(|ticks| is_extended(**ticks, true)).count();
    // At the end of its route it has no more to get.
    assert!(resting.len() > 20 && extended > resting.len() / 2, "{extended} of {resting:?}");
}
