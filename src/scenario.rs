//! Loads the scenario of `regatta run` and `regatta engine`: a file, standard input as `-`, or the
//! built-in demo if no file is named.

use std::path::Path;

use regatta_scenario::{Overrides, Scenario, ScenarioError};

use crate::output::STANDARD_STREAM;
use crate::progress::Progress;

/// A built-in demo: a thousand robots in a warehouse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Demo {
    /// They carry transport orders under the fleet manager.
    Managed,
    /// They drive random routes, and nothing keeps them apart.
    Unmanaged,
}

impl Demo {
    /// The text of the scenario.
    pub const fn text(self) -> &'static str {
        match self {
            Self::Managed => include_str!("../graphs/warehouse-managed.yaml"),
            Self::Unmanaged => include_str!("../graphs/warehouse-1000.yaml"),
        }
    }
}

/// The route graph that the demos name.
const DEMO_GRAPH: &str = include_str!("../graphs/warehouse.yaml");

/// The name of standard input in messages. Paths in a scenario that comes from there are relative
/// to the current folder.
pub const STANDARD_INPUT: &str = "standard input";

/// Whether a path stands for standard input.
pub fn is_standard_input(path: Option<&Path>) -> bool {
    path == Some(Path::new(STANDARD_STREAM))
}

/// Reads the scenario in the file at `path`, or a built-in demo if `path` is `None`.
///
/// # Errors
/// Returns an error if the scenario or its route graph can't be read or is invalid.
pub fn load(
    path: Option<&Path>,
    demo: Demo,
    overrides: &Overrides,
) -> Result<Scenario, ScenarioError> {
    let name = path.map_or("the demo".into(), Path::to_string_lossy);
    let _progress = Progress::start(format!("reading {name}"), 0);
    match path {
        path if is_standard_input(path) => {
            Scenario::read_from(std::io::stdin().lock(), Path::new(STANDARD_INPUT), overrides)
        }
        Some(path) => Scenario::read(path, overrides),
        None => {
            Scenario::from_texts(demo.text(), DEMO_GRAPH, Path::new("built-in demo"), overrides)
        }
    }
}
