//! Scenarios: a route graph, the robots on it and their routes, the tick rate, and the plugins to
//! start.
//!
//! ```
//! use std::path::Path;
//! use regatta_scenario::{Overrides, Scenario};
//!
//! let layout = "
//! Edges:
//! - {Id: 1, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, VelocityForward: 1.5}
//! Vertices:
//! - {Id: 1, X: 0.0, Y: 0.0, Theta: 0.0}
//! - {Id: 2, X: 4.0, Y: 0.0, Theta: 0.0}
//! ";
//! let text = "graph: road.yaml\nrate: 50\nrobots: [{count: 1, route: [1]}]\n";
//! let scenario =
//!     Scenario::from_texts(text, layout, Path::new("scenario.yaml"), &Overrides::default())?;
//! assert_eq!((scenario.robots(), scenario.tick_period.as_millis()), (1, 20));
//! # Ok::<(), regatta_scenario::ScenarioError>(())
//! ```

mod count;
mod default_scenario;
mod explain;
mod facilities;
mod made_up_load;
mod names;
mod places;
mod read;
mod resolve;
mod robot_type;
mod warnings;
pub mod yaml;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

pub use count::{ParseRobotCountError, RobotCount};
pub use default_scenario::{LEFT_OUT_OF_ORDERS, default_scenario, limits};
pub use explain::{YamlProblem, closest};
pub use made_up_load::MadeUpLoad;
pub use names::find_edge;
pub use read::{document, is_scenario};
use regatta_layout::{GraphError, Leg, NodeIndex, ReadOptions, RouteGraph};
pub use robot_type::{Battery, ChargeRange, RobotType, Shape};
use serde::de::{DeserializeOwned, IgnoredAny};
pub use warnings::{Told, Warnings};
pub use yaml::{Breakdowns, Disturbances, PluginCommand, Repeat, Stalls, Viewer};

/// The largest number of robots of a scenario: ids and columns stay far below the limits of `u32`.
pub const MAX_ROBOTS: u32 = 16_000_000;
/// The size of the largest scenario file that is read. Layouts may be larger.
const MAX_FILE_BYTES: u64 = 64 << 20;

/// A validated scenario: all names are resolved, all routes are connected.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// The route graph.
    pub graph: Arc<RouteGraph>,
    /// The simulated time per tick.
    pub tick_period: Duration,
    /// The number of ticks between two published frames.
    pub ticks_per_frame: u32,
    /// The seed of the random walks.
    pub seed: u64,
    /// The simulated time that `regatta run` drives before the first picture, as fast as possible.
    pub warm_up: Duration,
    /// The robot types; at least one.
    pub robot_types: Vec<RobotType>,
    /// The robots by ascending id; at least one group.
    pub groups: Vec<RobotGroup>,
    /// The disturbances.
    pub disturbances: Disturbances,
    /// The plugins to start.
    pub plugins: Vec<PluginCommand>,
    /// Whether to open the viewer.
    pub viewer: Viewer,
    /// The text, for the sections that belong to others.
    pub source: Source,
    /// Warnings about the scenario and its graph.
    pub warnings: Warnings,
    /// The parts of these warnings that results rest on: speeds, edges, or who drives on them are
    /// others than the layout's file says, or it doesn't say them.
    pub assumptions: Vec<String>,
    /// Whether the file was a layout, so that the rest is that of the default scenario.
    pub is_default: bool,
}

/// The text of a scenario.
///
/// Some of its sections belong to others: the load to a fleet manager, lights and cameras to the
/// viewer. These are not checked with the scenario; their owners read them from here.
///
/// ```
/// # use std::path::Path;
/// # use regatta_scenario::{Overrides, Scenario};
/// # let layout = "
/// # Edges:
/// # - {Id: 1, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, VelocityForward: 1.5}
/// # Vertices:
/// # - {Id: 1, X: 0.0, Y: 0.0, Theta: 0.0}
/// # - {Id: 2, X: 4.0, Y: 0.0, Theta: 0.0}
/// # ";
/// #[derive(serde::Deserialize)]
/// struct Sections {
///     load: Option<Load>,
/// }
/// #[derive(serde::Deserialize)]
/// struct Load {
///     seed: u64,
/// }
///
/// let text = "graph: road.yaml\nload: {seed: 7}\nrobots: [{node: 1}]\n";
/// let scenario =
///     Scenario::from_texts(text, layout, Path::new("scenario.yaml"), &Overrides::default())?;
/// let sections: Sections = scenario.source.sections()?;
/// assert_eq!(sections.load.map(|load| load.seed), Some(7));
/// # Ok::<(), regatta_scenario::ScenarioError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Source {
    /// The path that messages name.
    path: PathBuf,
    text: Arc<str>,
}

/// Robots of one type that start in the same way.
#[derive(Clone, Debug)]
pub struct RobotGroup {
    /// The number of robots; at least one.
    pub count: u32,
    /// The index of their type in [`Scenario::robot_types`].
    pub robot_type: u16,
    /// The place where they start, and their route.
    pub start: Start,
}

/// The place where a robot starts, and its route.
#[derive(Clone, Debug)]
pub enum Start {
    /// At the beginning of a route.
    Route {
        /// The connected legs of the route; at least one.
        legs: Arc<[Leg]>,
        /// The action at the end of the route.
        repeat: Repeat,
    },
    /// At a random place, on a random walk.
    Random,
    /// On a node, waiting for commands.
    Node(NodeIndex),
    /// At a random end of an edge where it touches no other robot, waiting for commands.
    Standing,
}

/// Settings of a command line that override those of the scenario.
#[derive(Clone, Debug, Default)]
pub struct Overrides {
    /// The options of reading the layout. Options that aren't set are those of the scenario.
    pub layout: ReadOptions,
    /// The number of ticks per simulated second.
    pub rate: Option<f64>,
    /// The number of frames per simulated second.
    pub publish_rate: Option<f64>,
    /// The seed of the random walks.
    pub seed: Option<u64>,
}

/// The error of reading a scenario.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioError {
    /// The file can't be read.
    #[error("{}: {source}: check the path", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The file is larger than any reasonable scenario.
    #[error("{}: too large for a scenario (at most {} MiB)", path.display(), MAX_FILE_BYTES >> 20)]
    TooLarge {
        /// The file.
        path: PathBuf,
    },
    /// The file is not a scenario.
    #[error("{}{problem}", path.display())]
    Yaml {
        /// The file.
        path: PathBuf,
        /// The line, the entry, and its problem.
        problem: YamlProblem,
        /// The YAML reader's error.
        source: serde_yaml::Error,
    },
    /// The file has no key of a scenario, and isn't a layout either.
    #[error(
        "{}: neither a layout nor a scenario: a scenario has the keys graph and robots; --format \
         names the format of a layout that its content doesn't tell",
        path.display()
    )]
    Neither {
        /// The file.
        path: PathBuf,
    },
    /// The route graph can't be read or has errors.
    #[error(transparent)]
    Graph(#[from] GraphError),
    /// A value in the file is invalid.
    #[error("{}: {place}: {message}", path.display())]
    Invalid {
        /// The file.
        path: PathBuf,
        /// The invalid entry.
        place: String,
        /// The problem and what to do about it.
        message: String,
    },
}

impl Source {
    /// Reads the sections that the fields of `T` name.
    ///
    /// # Errors
    /// [`ScenarioError::Yaml`] with the line and the entry.
    pub fn sections<T: DeserializeOwned>(&self) -> Result<T, ScenarioError> {
        document(&self.text, &self.path)
    }

    /// Returns the whole text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Whether the scenario has a section that isn't empty.
    pub fn has(&self, section: &str) -> bool {
        let sections = self.sections::<BTreeMap<String, Option<IgnoredAny>>>();
        sections.is_ok_and(|sections| matches!(sections.get(section), Some(Some(_))))
    }

    /// Returns the error of an invalid value of a section. `place` is the entry.
    pub fn invalid(&self, place: &str, message: String) -> ScenarioError {
        ScenarioError::Invalid { path: self.path.clone(), place: place.to_owned(), message }
    }
}

impl Scenario {
    /// Returns the number of robots.
    pub fn robots(&self) -> u32 {
        self.groups.iter().map(|group| group.count).sum()
    }

    /// Returns the group of the robot with an id. Beyond the robots that the scenario lists, the
    /// groups repeat, so that a fleet can grow while it runs.
    pub fn group_of(&self, robot: u32) -> &RobotGroup {
        let mut rest = robot % self.robots();
        for group in &self.groups {
            if rest < group.count {
                return group;
            }
            rest -= group.count;
        }
        unreachable!("the remainder is less than the sum of the counts")
    }
}
