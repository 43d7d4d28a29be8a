//! The backstop against the model of a fleet, where `lanes` alone comes to a standstill.

use regatta_plugin::world::WorldData;

use super::{Backstop, BackstopSettings};
use crate::model::{Model, Spent, TICK_SECS, places, worlds};
use crate::planner::{Lanes, LanesSettings, Planner};
use crate::roads::Roads;
use crate::steering::{AdmissionSettings, Settings};

fn lanes(roads: &Roads) -> Box<dyn Planner> {
    Box::new(Lanes::new(roads, LanesSettings::default()))
}

fn lanes_with_backstop(roads: &Roads) -> Box<dyn Planner> {
    Box::new(Backstop::new(lanes(roads), BackstopSettings::default()))
}

fn drive(name: &str, world: &WorldData, robots: usize, secs: u32, planner: fn(&Roads) -> Box<dyn Planner>) -> Model {
    let settings = Settings {
        admission: AdmissionSettings { waiting_share: 1.0, ..AdmissionSettings::default() },
        ..Settings::default()
    };
    let mut model = Model::new(world, &places(world, robots, 1), 1, settings, planner);
    model.run((secs as f32 / TICK_SECS) as u32);
    let Spent { cycles, sum, longest } = model.spent();
    println!(
        "{name}, {robots} robots, {secs} s: {} goals, fewest {:?}, longest {:.0} s; {:.2} ms a cycle, longest {:.1} ms; {:?}",
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
fn opposing_traffic_on_a_track_goes_on() {
    for robots in [2, 4, 6] {
        let model = drive("track", &worlds::single_track(7), robots, 3_600, lanes_with_backstop);
        assert!(model.arrivals.iter().all(|&goals| goals >= 3), "{:?}", model.arrivals);
    }
}

#[test]
fn robots_on_a_grid_go_on() {
    for robots in [20, 30] {
        let model = drive("grid", &worlds::cells(8), robots, 3_600, lanes_with_backstop);
        assert!(model.arrivals.iter().all(|&goals| goals >= 5), "{:?}", model.arrivals);
    }
}
