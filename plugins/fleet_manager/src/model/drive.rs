//! Drives a model fleet under a planner, and prints figures.

use regatta_plugin::world::WorldData;

use super::{Model, Spent, TICK_SECS, places};
use crate::planner::Planner;
use crate::roads::Roads;
use crate::steering::{AdmissionSettings, Settings};

/// Makes a planner.
pub type Maker = fn(&Roads) -> Box<dyn Planner>;

/// Drives robots from random node to random node for some simulated seconds, all of them admitted.
pub fn drive(
    name: &str,
    world: &WorldData,
    (robots, seed): (usize, u64),
    secs: u32,
    planner: Maker,
) -> Model {
    let settings = Settings { admission: AdmissionSettings::unlimited(), ..Settings::default() };
    let mut model = Model::new(world, &places(world, robots, seed), seed, settings, planner);
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
