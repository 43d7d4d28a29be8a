//! PIBT where opposing traffic shares tracks, against the model of a fleet; and the planner `lanes`
//! on the same roads.

use super::{Pibt, PibtSettings};
use crate::model::{Maker, drive, worlds};
use crate::planner::{Backstop, BackstopSettings, Lanes, LanesSettings, Planner};
use crate::roads::Roads;

fn pibt(roads: &Roads) -> Box<dyn Planner> {
    Box::new(Pibt::new(roads, PibtSettings::default()))
}

fn lanes(roads: &Roads) -> Box<dyn Planner> {
    Box::new(Lanes::new(roads, LanesSettings::default()))
}

fn with_backstop(planner: Box<dyn Planner>) -> Box<dyn Planner> {
    Box::new(Backstop::new(planner, BackstopSettings::default()))
}

#[test]
fn opposing_traffic_shares_a_track() {
    let model = drive("track, pibt", &worlds::single_track(7), (4, 1), 1_200, pibt);
    assert!(model.arrivals.iter().all(|&goals| goals >= 5), "{:?}", model.arrivals);
}

#[test]
fn robots_on_a_grid_push_each_other() {
    let model = drive("grid, pibt", &worlds::cells(8), (20, 1), 600, pibt);
    assert!(model.arrivals.iter().all(|&goals| goals >= 5), "{:?}", model.arrivals);
}

#[test]
#[ignore = "figures for the documentation"]
fn figures() {
    let backed: [Maker; 2] =
        [|roads| with_backstop(pibt(roads)), |roads| with_backstop(lanes(roads))];
    for robots in [1, 2, 4, 6] {
        drive("track, pibt", &worlds::single_track(7), (robots, 1), 600, pibt);
        drive("track, lanes", &worlds::single_track(7), (robots, 1), 600, lanes);
        drive("track, pibt, backstop", &worlds::single_track(7), (robots, 1), 600, backed[0]);
        drive("track, lanes, backstop", &worlds::single_track(7), (robots, 1), 600, backed[1]);
    }
    for robots in [1, 10, 20, 30, 40] {
        drive("grid, pibt", &worlds::cells(8), (robots, 1), 600, pibt);
        drive("grid, lanes", &worlds::cells(8), (robots, 1), 600, lanes);
        drive("grid, pibt, backstop", &worlds::cells(8), (robots, 1), 600, backed[0]);
        drive("grid, lanes, backstop", &worlds::cells(8), (robots, 1), 600, backed[1]);
    }
}
