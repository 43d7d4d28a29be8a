//! The fuzz target of scenarios: no text makes the reader panic, hang or exhaust memory, and robots
//! of an accepted one exist.

use std::path::Path;

use regatta_scenario::{Overrides, Scenario, is_scenario};

/// The layout of all scenarios: a road that is driven both ways, and a station.
const LAYOUT: &str = "
Edges:
- {Id: 1, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, VelocityForward: 1.5}
- {Id: 2, Origin_ID: 2, Destination_ID: 3, CurveType: Linear, VelocityForward: 1}
- {Id: 3, Origin_ID: 3, Destination_ID: 1, CurveType: Linear, VelocityForward: 1.5}
Vertices:
- {Id: 1, X: 0.0, Y: 0.0, Theta: 0.0, Name: dock, Role: pick}
- {Id: 2, X: 9.0, Y: 0.0, Theta: 0.0, Name: gate}
- {Id: 3, X: 4.0, Y: 7.0, Theta: 0.0, Role: charger}
";

/// Reads a text as a scenario of the layout.
pub fn read(text: &str) {
    let is_scenario = is_scenario(text);
    let path = Path::new("fuzzed.yaml");
    let Ok(scenario) = Scenario::from_texts(text, LAYOUT, path, &Overrides::default()) else {
        return;
    };
    assert!(is_scenario, "a scenario names its layout");
    assert!(scenario.robots() > 0 && !scenario.robot_types.is_empty());
    assert!(!scenario.tick_period.is_zero() && scenario.ticks_per_frame > 0);
}
