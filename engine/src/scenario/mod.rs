//! Scenarios: which robots drive where on which graph, at what rate, watched by which plugins.

mod resolve;
pub mod yaml;

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use crate::fleet::{Repeat, RobotType};
use crate::graph::{self, GraphError, Handles, Leg, NodeIndex, RouteGraph};
pub use yaml::{LegName, LightEntry, PluginCommand, Viewer};

/// Most robots that a scenario may ask for: ids and columns stay far inside `u32`.
pub const MAX_ROBOTS: u32 = 16_000_000;
/// Most lamps beside the sun: as many as the viewer has.
pub const MAX_LIGHTS: usize = 8;
/// Largest scenario file that is read.
const MAX_FILE_BYTES: u64 = 64 << 20;

/// A scenario that can be run: all names looked up, all routes connected.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// The roads.
    pub graph: Arc<RouteGraph>,
    /// Simulated time per tick.
    pub tick_period: Duration,
    /// A frame is published every so many ticks.
    pub ticks_per_frame: u32,
    /// Seed of the random walks.
    pub seed: u64,
    /// Kinds of robots; at least one.
    pub robot_types: Vec<RobotType>,
    /// Robots by ascending id; at least one group.
    pub groups: Vec<RobotGroup>,
    /// Plugins to start beside the engine.
    pub plugins: Vec<PluginCommand>,
    /// Whether to open the viewer.
    pub viewer: Viewer,
    /// The viewer's lamps beside the sun; at most [`MAX_LIGHTS`], all numbers finite.
    pub lights: Vec<LightEntry>,
    /// What the graph's author should look at.
    pub warnings: Vec<String>,
}

/// Robots alike.
#[derive(Clone, Debug)]
pub struct RobotGroup {
    /// How many; at least one.
    pub count: u32,
    /// Index into the scenario's robot types.
    pub robot_type: u16,
    /// Where they start and what they drive.
    pub start: Start,
}

/// Where a robot starts and what it drives.
#[derive(Clone, Debug)]
pub enum Start {
    /// At the beginning of a route.
    Route {
        /// Connected legs; at least one.
        legs: Arc<[Leg]>,
        /// What to do at the end.
        repeat: Repeat,
    },
    /// Anywhere, on a random walk.
    Random,
    /// On a node, waiting for orders.
    Node(NodeIndex),
}

/// What a command line may change about a scenario.
#[derive(Clone, Debug, Default)]
pub struct Overrides {
    /// Which handle belongs to which end of a spline.
    pub handles: Option<Handles>,
    /// Ticks per simulated second.
    pub rate: Option<f64>,
    /// Frames per simulated second.
    pub publish_rate: Option<f64>,
    /// Seed of the random walks.
    pub seed: Option<u64>,
}

/// Why a scenario can't be run.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioError {
    /// The file can't be read.
    #[error("{}: {source}: is the path right?", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is far larger than any scenario.
    #[error("{}: too large for a scenario (at most {MAX_FILE_BYTES} bytes)", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
    },
    /// The file is not a scenario.
    #[error("{}: {source}", path.display())]
    Yaml {
        /// The file.
        path: PathBuf,
        /// Where and why.
        source: serde_yaml::Error,
    },
    /// The route graph can't be driven.
    #[error(transparent)]
    Graph(#[from] GraphError),
    /// A value in the file makes no sense.
    #[error("{}: {place}: {message}", path.display())]
    Invalid {
        /// The file.
        path: PathBuf,
        /// Which entry.
        place: String,
        /// What is wrong and what to do.
        message: String,
    },
}

impl Scenario {
    /// Reads a scenario and its graph.
    ///
    /// # Errors
    /// If either can't be read or makes no sense; the message names file, entry and remedy.
    pub fn read(path: &Path, overrides: &Overrides) -> Result<Self, ScenarioError> {
        let text = read_text(path)?;
        let file = parse(&text, path)?;
        let graph_path = path.parent().unwrap_or(Path::new("")).join(&file.graph);
        let (graph, findings) = graph::read(&graph_path, &graph::ReadOptions { handles: overrides.handles })?;
        let warnings = findings.as_slice().iter().map(ToString::to_string).collect();
        resolve::resolve(file, path, graph, warnings, overrides)
    }

    /// A scenario from texts, for the ones that are built in: `graph_text` takes the place of the file that
    /// the scenario names.
    ///
    /// # Errors
    /// As [`Scenario::read`].
    pub fn from_texts(text: &str, graph_text: &str, name: &Path, overrides: &Overrides) -> Result<Self, ScenarioError> {
        let file = parse(text, name)?;
        let (graph, findings) = graph::parse(
            graph_text,
            &file.graph.display().to_string(),
            &graph::ReadOptions { handles: overrides.handles },
        )?;
        let warnings = findings.as_slice().iter().map(ToString::to_string).collect();
        resolve::resolve(file, name, graph, warnings, overrides)
    }

    /// Number of robots.
    pub fn robots(&self) -> u32 {
        self.groups.iter().map(|group| group.count).sum()
    }

    /// The group of the robot with that id. Beyond the robots that the scenario lists, the groups repeat:
    /// so a fleet can grow while it runs.
    pub fn group_of(&self, robot: u32) -> &RobotGroup {
        let mut rest = robot % self.robots();
        self.groups
            .iter()
            .find(|group| {
                let found = rest < group.count;
                rest = rest.wrapping_sub(group.count);
                found
            })
            .expect("the counts add up to more than any remainder")
    }
}

fn parse(text: &str, path: &Path) -> Result<yaml::ScenarioFile, ScenarioError> {
    serde_yaml::from_str(text).map_err(|source| ScenarioError::Yaml { path: path.into(), source })
}

fn read_text(path: &Path) -> Result<String, ScenarioError> {
    let read_error = |source| ScenarioError::Read { path: path.into(), source };
    // Counted while reading: a pipe or a device doesn't tell its size.
    let file = std::fs::File::open(path).map_err(read_error)?;
    let mut text = String::new();
    file.take(MAX_FILE_BYTES + 1).read_to_string(&mut text).map_err(read_error)?;
    if text.len() as u64 > MAX_FILE_BYTES {
        return Err(ScenarioError::TooLarge { path: path.into() });
    }
    Ok(text)
}
