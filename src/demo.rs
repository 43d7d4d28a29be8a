//! The built-in demo: what runs when nothing is named.

use std::path::Path;

use regatta_engine::scenario::{Overrides, Scenario, ScenarioError};

const SCENARIO: &str = include_str!("../graphs/warehouse-1000.yaml");
const GRAPH: &str = include_str!("../graphs/warehouse.yaml");

/// The scenario in a file, or the demo.
pub fn scenario(path: Option<&Path>, overrides: &Overrides) -> Result<Scenario, ScenarioError> {
    match path {
        Some(path) => Scenario::read(path, overrides),
        None => Scenario::from_texts(SCENARIO, GRAPH, Path::new("built-in demo"), overrides),
    }
}
