//! Loads the scenario of `regatta run` and `regatta engine`: a file, or the built-in demo if no file is named.

use std::path::Path;

use regatta_engine::scenario::{Overrides, Scenario, ScenarioError};

/// The scenario of the built-in demo: a thousand robots in a warehouse.
const DEMO_SCENARIO: &str = include_str!("../graphs/warehouse-1000.yaml");
/// The route graph that [`DEMO_SCENARIO`] names.
const DEMO_GRAPH: &str = include_str!("../graphs/warehouse.yaml");

/// Reads the scenario in the file at `path`, or the built-in demo if `path` is `None`.
///
/// # Errors
/// Returns an error if the scenario or its route graph can't be read or is invalid.
pub fn load(path: Option<&Path>, overrides: &Overrides) -> Result<Scenario, ScenarioError> {
    match path {
        Some(path) => Scenario::read(path, overrides),
        None => Scenario::from_texts(DEMO_SCENARIO, DEMO_GRAPH, Path::new("built-in demo"), overrides),
    }
}
