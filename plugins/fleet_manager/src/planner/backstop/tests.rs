//! The backstop against the model of a fleet, where `lanes` alone comes to a standstill.

use super::{Backstop, BackstopSettings};
use crate::model::{Maker, Model, drive, places, worlds};
use crate::planner::{
    Committed, Lanes, LanesSettings, Pibt, PibtSettings, Planner, PlannerKind, Tea, TeaSettings,
};
use crate::roads::{Leg, Roads};
use crate::steering::Settings;

fn lanes(roads: &Roads) -> Box<dyn Planner> {
    Box::new(Lanes::new(roads, LanesSettings::default()))
}

fn lanes_with_backstop(roads: &Roads) -> Box<dyn Planner> {
    Box::new(Backstop::new(lanes(roads), BackstopSettings::default()))
}

fn tea(roads: &Roads) -> Box<dyn Planner> {
    Box::new(Tea::new(roads, TeaSettings::default()))
}

fn tea_with_backstop(roads: &Roads) -> Box<dyn Planner> {
    Box::new(Backstop::new(tea(roads), BackstopSettings::default()))
}

#[test]
fn opposing_traffic_on_a_track_goes_on() {
    for robots in [2, 4, 6] {
        let model =
            drive("track", &worlds::single_track(7), (robots, 1), 3_600, lanes_with_backstop);
        assert!(model.arrivals.iter().all(|&goals| goals >= 10), "{:?}", model.arrivals);
        assert!(model.longest_secs() < 1_200.0, "{} s without a goal", model.longest_secs());
    }
}

#[test]
fn it_works_under_another_planner() {
    let model = drive("track, tea", &worlds::single_track(7), (4, 1), 1_800, tea_with_backstop);
    assert!(count(&model, "regions solved") > 0);
    assert!(model.arrivals.iter().all(|&goals| goals >= 5), "{:?}", model.arrivals);
}

/// More robots than committed ways cope with: where all stand, one after the other is helped.
#[test]
fn a_full_track_goes_on() {
    let planners: [Maker; 2] =
        [|roads| Box::new(Committed::new(roads)), |roads| PlannerKind::Committed.plain(roads)];
    let world = worlds::single_track(7);
    for robots in [8, 9] {
        let [without, with] = planners.map(|planner| {
            let settings = PlannerKind::Committed.settings();
            let starts = places(&world, robots, 1);
            let mut model = Model::new(&world, &starts, 1, settings, planner);
            model.run(18_000);
            println!("{robots} robots: {:?}; {:?}", model.arrivals, model.counts());
            model
        });
        assert!(without.arrivals.contains(&0), "{:?}", without.arrivals);
        assert!(with.arrivals.iter().all(|&goals| goals > 0), "{:?}", with.arrivals);
    }
}

/// Robots that push each other to and fro never stand: they are stopped, and led.
#[test]
fn robots_that_drive_without_arriving_are_led() {
    let planners: [Maker; 2] = [
        |roads| Box::new(Pibt::new(roads, PibtSettings::default())),
        |roads| PlannerKind::Pibt.plain(roads),
    ];
    let world = worlds::single_track(7);
    let [without, with] = planners.map(|planner| {
        let settings = PlannerKind::Pibt.settings();
        let mut model = Model::new(&world, &places(&world, 7, 1), 1, settings, planner);
        model.run(36_000);
        println!("{:?}; {:?}", model.arrivals, model.counts());
        model
    });
    assert!(4 * without.total() < with.total(), "{:?}", without.arrivals);
    assert!(with.arrivals.iter().all(|&goals| goals >= 10), "{:?}", with.arrivals);
}

#[test]
fn robots_on_a_grid_go_on() {
    for robots in [20, 30] {
        let model = drive("grid", &worlds::cells(8), (robots, 1), 3_600, lanes_with_backstop);
        assert!(model.arrivals.iter().all(|&goals| goals >= 10), "{:?}", model.arrivals);
        assert!(model.longest_secs() < 1_200.0, "{} s without a goal", model.longest_secs());
    }
}

/// The backstop, which helps so soon that it has much to do.
fn impatient(roads: &Roads) -> Box<dyn Planner> {
    let settings = BackstopSettings { stand_secs: 3.0, ..BackstopSettings::default() };
    Box::new(Backstop::new(lanes(roads), settings))
}

/// Robots that turn on the spot or drive in reverse gear, stall at random, and of which some break
/// down.
#[test]
fn robots_that_are_led_never_touch_however_late_they_are() {
    let [turns, jumps] = [true, false].map(|turns| worlds::streets(4, 3.0, turns));
    let runs =
        [(&worlds::cells(6), 16, 2), (&turns, 6, 0), (&jumps, 6, 0), (&worlds::porto(), 25, 0)];
    for (world, robots, broken) in runs {
        let solved: Vec<u64> = (1..4)
            .map(|seed| {
                let starts = places(world, robots, seed);
                let mut model = Model::new(world, &starts, seed, Settings::default(), impatient);
                (model.stalls, model.broken) = (10, broken);
                model.run(6_000);
                println!("{robots} robots: {:?}; {:?}", model.arrivals, model.counts());
                count(&model, "regions solved")
            })
            .collect();
        assert!(solved.iter().sum::<u64>() > 0, "nobody was led");
    }
}

#[test]
fn robots_go_on_beside_broken_ones() {
    let world = worlds::cells(6);
    let mut model =
        Model::new(&world, &places(&world, 14, 1), 1, Settings::default(), lanes_with_backstop);
    model.broken = 2;
    model.run(18_000);
    println!("{:?}; {:?}", model.arrivals, model.counts());
    assert!(model.arrivals[2..].iter().all(|&goals| goals >= 3), "{:?}", model.arrivals);
}

#[test]
fn a_run_repeats() {
    let [a, b] =
        [1, 2].map(|_| drive("grid", &worlds::cells(8), (24, 1), 900, lanes_with_backstop));
    assert!(count(&a, "regions solved") > 0);
    let ends = |model: &Model| {
        (0..24).map(|robot| model.steering.claims().end(robot).copied()).collect::<Vec<_>>()
    };
    assert_eq!(
        (a.arrivals.clone(), a.counts(), ends(&a)),
        (b.arrivals.clone(), b.counts(), ends(&b))
    );
}

#[test]
fn plans_stay_as_they_are_while_nothing_stands() {
    let world = worlds::streets(4, 3.0, false);
    let planners: [Maker; 2] = [lanes, lanes_with_backstop];
    let starts = places(&world, 6, 1);
    let [mut without, mut with] =
        planners.map(|planner| Model::new(&world, &starts, 1, Settings::default(), planner));
    for tick in 0..6_000 {
        without.run(1);
        with.run(1);
        for robot in 0..6 {
            assert_eq!(
                without.steering.claims().of(robot),
                with.steering.claims().of(robot),
                "tick {tick}"
            );
        }
    }
    assert_eq!((without.arrivals.clone(), 0), (with.arrivals.clone(), count(&with, "regions")));
    assert!(with.total() > 100, "{} goals", with.total());
}

fn count(model: &Model, name: &str) -> u64 {
    model.counts().iter().find(|(known, _)| *known == name).map_or(0, |(_, count)| *count)
}

/// A robot at a node of a track, and one that wants to drive to its other end: its goal, and the
/// model.
fn in_the_way(planner: Maker, node: u32) -> (u32, Model) {
    let world = worlds::single_track(7);
    // To the node, and from node 1 to 2.
    let starts = [2 * node - 2, 2].map(|edge| (Leg::new(edge, false), 4.0));
    let mut model = Model::new(&world, &starts, 1, Settings::default(), planner);
    let goal = 6;
    model.goals = vec![Some(0), Some(goal)];
    model.run(2);
    model.steering.send(1, goal);
    (goal, model)
}

#[test]
fn an_idle_robot_is_sent_out_of_the_way_before_the_backstop_is_needed() {
    for (planner, node) in [(lanes as Maker, 3), (lanes_with_backstop, 3), (lanes, 6)] {
        let (goal, mut model) = in_the_way(planner, node);
        model.run(1_500);
        let has_arrived = model.arrivals[1] > 0 || model.steering.has_arrived(1, goal);
        assert!(has_arrived, "{:?}", model.steering.claims());
        assert_eq!(count(&model, "regions"), 0);
    }
}

#[test]
fn who_waits_for_a_robot_at_a_stop_is_not_stuck() {
    let (goal, mut model) = in_the_way(lanes_with_backstop, 3);
    model.steering.stay(0);
    model.run(3_000);
    assert_eq!(count(&model, "regions"), 0);
    assert!(!model.steering.has_arrived(1, goal) && model.arrivals[1] == 0);
    model.steering.halt(0);
    model.run(1_500);
    assert!(model.arrivals[1] > 0, "it was idle for more than a minute");
}

#[test]
#[ignore = "figures for the documentation"]
fn figures() {
    for robots in [2, 4, 6] {
        drive("track, lanes", &worlds::single_track(7), (robots, 1), 3_600, lanes);
        drive("track, tea", &worlds::single_track(7), (robots, 1), 3_600, tea);
        drive(
            "track, tea, backstop",
            &worlds::single_track(7),
            (robots, 1),
            3_600,
            tea_with_backstop,
        );
    }
    for robots in [20, 30] {
        drive("grid, lanes", &worlds::cells(8), (robots, 1), 3_600, lanes);
    }
}
