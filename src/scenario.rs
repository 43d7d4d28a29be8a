//! Loads the scenario of `regatta run` and `regatta engine`: a file, standard input as `-`, or the
//! built-in demo if no file is named.

use std::path::Path;

use regatta_scenario::{Overrides, Scenario, ScenarioError, Told};

use crate::output::STANDARD_STREAM;
use crate::progress::Progress;

/// A built-in demo: robots in a warehouse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Demo {
    /// Four hundred carry transport orders under the fleet manager.
    Managed,
    /// A thousand drive random routes, and nothing keeps them apart.
    Unmanaged,
}

impl Demo {
    /// The text of the scenario.
    pub const fn text(self) -> &'static str {
        match self {
            Self::Managed => include_str!("../graphs/demo.yaml"),
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

/// The warnings that the user wants: all with `-v`.
pub fn wanted_warnings() -> Told {
    if is_verbose() { Told::All } else { Told::MostImportant }
}

/// Whether the user gave `-v`.
pub fn is_verbose() -> bool {
    tracing::enabled!(tracing::Level::INFO)
}

/// Prints the warnings about a scenario that the user wants.
pub fn tell_warnings(scenario: &Scenario) {
    for finding in scenario.warnings.told(wanted_warnings()) {
        regatta_plugin::tell!("{finding}");
    }
}

/// Reads the scenario in the file at `path`, or a built-in demo if `path` is `None`, and checks the
/// sections of the viewer.
///
/// # Errors
/// If the scenario or its route graph can't be read or is invalid.
pub fn load(
    path: Option<&Path>,
    demo: Demo,
    overrides: &Overrides,
) -> Result<Scenario, ScenarioError> {
    let name = path.map_or("the demo".into(), Path::to_string_lossy);
    let _progress = Progress::start(format!("reading {name}"), 0);
    let scenario = match path {
        path if is_standard_input(path) => {
            Scenario::read_from(std::io::stdin().lock(), Path::new(STANDARD_INPUT), overrides)
        }
        Some(path) => Scenario::read(path, overrides),
        None => {
            Scenario::from_texts(demo.text(), DEMO_GRAPH, Path::new("built-in demo"), overrides)
        }
    }?;
    viewer_args(&scenario)?;
    Ok(scenario)
}

/// Checks the sections of a scenario that belong to the viewer, and returns them as its arguments.
///
/// # Errors
/// If an entry is invalid. Without the feature `viewer`, the sections are not read.
pub fn viewer_args(scenario: &Scenario) -> Result<Vec<String>, ScenarioError> {
    #[cfg(feature = "viewer")]
    {
        let sections: regatta_viewer::sections::Sections = scenario.source.sections()?;
        sections.to_args().map_err(|error| scenario.source.invalid(error.section, error.message))
    }
    #[cfg(not(feature = "viewer"))]
    {
        let _ = scenario;
        Ok(Vec::new())
    }
}

#[cfg(all(test, feature = "viewer"))]
mod tests {
    use super::*;

    const GRAPH: &str = include_str!("../graphs/square.yaml");

    /// Reads a scenario with a section of the viewer; returns the error.
    fn error(section: &str) -> String {
        let text = format!("graph: none.yaml\n{section}\nrobots: [{{node: 1}}]\n");
        let scenario = Scenario::from_texts(&text, GRAPH, Path::new("test"), &Overrides::default())
            .expect("sections of the viewer are not checked with the scenario");
        viewer_args(&scenario).expect_err(section).to_string()
    }

    #[test]
    fn wrong_cameras_are_refused_in_one_line() {
        for (cameras, reason) in [
            ("[{name: fit, x: 0, y: 0, height: 4}]", "not fit, top or plan"),
            ("[{name: 'a=b', x: 0, y: 0, height: 4}]", "without , and ="),
            ("[{name: a, x: 0, y: 0, height: 0}]", "above 0"),
            ("[{name: a, x: 0, y: 0, z: 3}]", "either z, yaw and pitch"),
            (
                "[{name: a, x: 0, y: 0, z: 3, yaw: 0, pitch: 1, height: 2}]",
                "either z, yaw and pitch",
            ),
            ("[{name: a, x: .nan, y: 0, height: 2}]", "out of range"),
            ("[{name: a, x: 0, y: 0, height: 2}, {name: a, x: 0, y: 0, height: 3}]", "used twice"),
        ] {
            let error = error(&format!("cameras: {cameras}"));
            assert!(
                error.starts_with("test: cameras: entry ")
                    && error.contains(reason)
                    && !error.contains('\n'),
                "{cameras}: {error}"
            );
        }
    }

    #[test]
    fn wrong_lights_are_refused_in_one_line() {
        let nine = format!("[{}]", ["{x: 0, y: 0, z: 5}"; 9].join(", "));
        for (lights, start, reason) in [
            (
                "[{x: 0, y: 0, z: 5}, {x: 0, y: .inf, z: 5}]",
                "test: lights: entry 2: ",
                "y is inf; give metres",
            ),
            ("[{x: 0, y: 0, z: .nan}]", "test: lights: entry 1: ", "z is NaN; give metres"),
            (
                "[{x: 0, y: 0, z: 5, colour: [1, -1, 0]}]",
                "test: lights: entry 1: ",
                "colour has -1",
            ),
            (&*nine, "test: lights: ", "give at most 8"),
            ("[{x: 1, y: 2}]", "test:2: lights, entry 1", "z is missing"),
            (
                "[{x: 1, y: 2, z: 3, color: [1, 1, 1]}]",
                "test:2: lights, entry 1",
                "unknown key 'color'",
            ),
            ("[{x: 1, y: 2, z: 3, colour: [1, 1]}]", "test:2: lights, entry 1", ""),
            (
                "[{x: 0, y: 0, z: 0, colour: red}]",
                "test:2: lights, entry 1",
                "this must be a list of 3 numbers",
            ),
        ] {
            let error = error(&format!("lights: {lights}"));
            assert!(
                error.starts_with(start) && error.contains(reason) && !error.contains('\n'),
                "{lights}: {error}"
            );
        }
    }
}
