//! TEA* on the graph of the dissertation, against the model of a fleet.

use super::{Tea, TeaSettings};
use crate::model::{Model, Spent, TICK_SECS, places, worlds};
use crate::planner::Planner;
use crate::roads::Roads;
use crate::steering::{AdmissionSettings, Settings};

/// Steering for planners that decide on their own who drives.
fn settings() -> Settings {
    Settings { admission: AdmissionSettings::unlimited(), ..Settings::default() }
}

fn tea(roads: &Roads) -> Box<dyn Planner> {
    Box::new(Tea::new(roads, TeaSettings::default()))
}

fn drive(robots: usize, seed: u64, secs: u32) -> Model {
    let world = worlds::porto();
    let mut model = Model::new(&world, &places(&world, robots, seed), seed, settings(), tea);
    model.run((secs as f32 / TICK_SECS) as u32);
    let Spent { cycles, sum, longest } = model.spent();
    println!(
        "{robots} robots, {secs} s: {} goals, fewest {:?}, longest {:.0} s; {:.2} ms a cycle, longest {:.1} ms; {:?}",
        model.total(),
        model.arrivals.iter().min(),
        model.longest_secs(),
        1e3 * sum.as_secs_f64() / f64::from(cycles),
        1e3 * longest.as_secs_f64(),
        model.counts()
    );
    model
}

#[test]
fn ten_robots_arrive_again_and_again() {
    for seed in 1..3 {
        let model = drive(10, seed, 600);
        assert!(model.arrivals.iter().all(|&goals| goals >= 3), "{:?}", model.arrivals);
    }
}

#[test]
fn thirty_robots_arrive_again_and_again() {
    for seed in 1..3 {
        let model = drive(30, seed, 900);
        assert!(model.arrivals.iter().all(|&goals| goals >= 2), "{:?}", model.arrivals);
    }
}

#[test]
#[ignore = "figures for the documentation"]
fn limit() {
    for robots in [2, 5, 10, 20, 30, 40] {
        drive(robots, 1, 600);
    }
}
