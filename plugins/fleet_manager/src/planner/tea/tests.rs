//! TEA* on the graph of the dissertation, against the model of a fleet.

use super::{Tea, TeaSettings};
use crate::model::{drive, worlds};
use crate::planner::Planner;
use crate::roads::Roads;

fn tea(roads: &Roads) -> Box<dyn Planner> {
    Box::new(Tea::new(roads, TeaSettings::default()))
}

#[test]
fn ten_robots_arrive_again_and_again() {
    for seed in 1..3 {
        let model = drive("porto, tea", &worlds::porto(), (10, seed), 600, tea);
        assert!(model.arrivals.iter().all(|&goals| goals >= 3), "{:?}", model.arrivals);
    }
}

#[test]
fn thirty_robots_arrive_again_and_again() {
    for seed in 1..3 {
        let model = drive("porto, tea", &worlds::porto(), (30, seed), 900, tea);
        assert!(model.arrivals.iter().all(|&goals| goals >= 2), "{:?}", model.arrivals);
    }
}

#[test]
#[ignore = "figures for the documentation"]
fn limit() {
    for robots in [2, 5, 10, 20, 30, 40] {
        drive("porto, tea", &worlds::porto(), (robots, 1), 600, tea);
    }
}
