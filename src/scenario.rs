//! Loads the scenario of `regatta run` and `regatta engine`: a file, standard input as `-`, or the built-in demo if no file
//! is named.

use std::path::Path;

use regatta_engine::scenario::{Overrides, Scenario, ScenarioError};

use crate::output::STANDARD_STREAM;
use crate::progress::Progress;

/// The scenario of the built-in demo: a thousand robots in a warehouse.
const DEMO_SCENARIO: &str = include_str!("../graphs/warehouse-1000.yaml");
/// The route graph that [`DEMO_SCENARIO`] names.
const DEMO_GRAPH: &str = include_str!("../graphs/warehouse.yaml");

/// The name of standard input in messages. Paths in a scenario that comes from there are relative to the current folder.
pub const STANDARD_INPUT: &str = "standard input";

/// Whether a path stands for standard input.
pub fn is_standard_input(path: Option<&Path>) -> bool {
    path == Some(Path::new(STANDARD_STREAM))
}

/// Reads the scenario in the file at `path`, or the built-in demo if `path` is `None`.
///
/// # Errors
/// Returns an error if the scenario or its route graph can't be read or is invalid.
pub fn load(path: Option<&Path>, overrides: &Overrides) -> Result<Scenario, ScenarioError> {
    let name = path.map_or("the demo".into(), Path::to_string_lossy);
    let _progress = Progress::start(format!("reading {name}"), 0);
    match path {
        path if is_standard_input(path) => {
            Scenario::read_from(std::io::stdin().lock(), Path::new(STANDARD_INPUT), overrides)
        }
        Some(path) => Scenario::read(path, overrides),
        None => Scenario::from_texts(DEMO_SCENARIO, DEMO_GRAPH, Path::new("built-in demo"), overrides),
    }
}
