//! The scenario file as it is written: names, not yet looked up.

use std::path::PathBuf;

use serde::{Deserialize, Deserializer, de};

/// A scenario file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScenarioFile {
    /// Route graph, relative to the scenario's folder.
    pub graph: PathBuf,
    /// Ticks per simulated second.
    #[serde(default = "default_rate")]
    pub rate: f64,
    /// Frames per simulated second; every tick if left out.
    pub publish_rate: Option<f64>,
    /// Seed of the random walks.
    #[serde(default)]
    pub seed: u64,
    /// Kinds of robots; one default kind if left out.
    #[serde(default)]
    pub robot_types: Vec<RobotTypeEntry>,
    /// Groups of robots, in the order of their ids.
    pub robots: Vec<RobotsEntry>,
    /// Plugins to start.
    #[serde(default)]
    pub plugins: Vec<PluginEntry>,
    /// Whether `regatta run` opens the viewer.
    #[serde(default)]
    pub viewer: Viewer,
    /// Lamps that the viewer hangs up beside the sun.
    #[serde(default)]
    pub lights: Vec<LightEntry>,
}

fn default_rate() -> f64 {
    100.0
}

/// A kind of robot.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotTypeEntry {
    /// What `type:` refers to.
    pub name: String,
    /// Footprint; a rectangle if left out.
    #[serde(default)]
    pub shape: ShapeEntry,
    /// Metres along the heading; of a circle, its diameter.
    pub length: f32,
    /// Metres across it; needed for a rectangle.
    pub width: Option<f32>,
    /// Metres per second; no limit if left out.
    pub max_speed: Option<f32>,
    /// Metres per second squared; speed changes at once if left out.
    pub max_acceleration: Option<f32>,
}

/// The footprint of a robot type.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ShapeEntry {
    /// `length` times `width`.
    #[default]
    Rectangle,
    /// Of diameter `length`.
    Circle,
}

/// One robot with a listed route, or `count` robots alike.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotsEntry {
    /// How many.
    #[serde(default = "one")]
    pub count: u32,
    /// Name of a robot type; the first if left out.
    #[serde(rename = "type")]
    pub robot_type: Option<String>,
    /// Ids of edges in order, `-ID` in reverse gear. They start at the beginning of the first.
    pub route: Option<Vec<LegName>>,
    /// What to do at the end of `route`.
    pub repeat: Option<RepeatEntry>,
    /// Random walks that never end, from random places.
    pub routes: Option<RoutesEntry>,
    /// Id of a node to stand on, waiting for orders.
    pub node: Option<u32>,
}

fn one() -> u32 {
    1
}

/// What a robot does at the end of its route.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RepeatEntry {
    /// It stands.
    Once,
    /// It drives the route again; the route must end where it starts.
    Loop,
}

/// Routes that aren't listed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RoutesEntry {
    /// At each node, a random edge.
    Random,
}

/// Whether to open the viewer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Viewer {
    /// If there is one and a display to show it on.
    #[default]
    Auto,
    /// Yes; failing to is an error.
    On,
    /// No.
    Off,
}

/// A lamp.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LightEntry {
    /// Metres to the east.
    pub x: f32,
    /// Metres to the north.
    pub y: f32,
    /// Metres above the floor.
    pub z: f32,
    /// Red, green and blue, linear: 0 to 1 and above; white if left out.
    #[serde(default = "white")]
    pub colour: [f32; 3],
}

fn white() -> [f32; 3] {
    [1.0; 3]
}

/// A plugin to start: the name of a built-in one, or a command line.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(untagged)]
pub enum PluginEntry {
    /// Name of a plugin of this project.
    Name(String),
    /// With arguments, or a program of your own.
    Detailed(PluginCommand),
}

/// A plugin with its arguments.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PluginCommand {
    /// What messages call it; with no `command`, the name of a plugin of this project.
    pub name: String,
    /// Program and arguments, relative to the scenario's folder if it has a slash. `--fleet NAME` is appended.
    #[serde(default)]
    pub command: Vec<String>,
    /// More arguments.
    #[serde(default)]
    pub args: Vec<String>,
}

/// An edge of a route: its id, and whether to drive it in reverse gear.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LegName {
    /// Id of the edge.
    pub edge_id: u32,
    /// From destination to origin.
    pub reverse: bool,
}

/// A text that is no [`LegName`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' names no edge: write its id, or -ID to drive it in reverse gear")]
pub struct ParseLegError(String);

impl std::str::FromStr for LegName {
    type Err = ParseLegError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (reverse, digits) = text.strip_prefix('-').map_or((false, text), |digits| (true, digits));
        let edge_id = digits.parse().map_err(|_| ParseLegError(text.to_owned()))?;
        Ok(Self { edge_id, reverse })
    }
}

impl std::fmt::Display for LegName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}{}", if self.reverse { "-" } else { "" }, self.edge_id)
    }
}

impl<'de> Deserialize<'de> for LegName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum NumberOrText {
            Number(i64),
            Text(String),
        }
        let text = match NumberOrText::deserialize(deserializer)? {
            NumberOrText::Number(number) => number.to_string(),
            NumberOrText::Text(text) => text,
        };
        text.parse().map_err(de::Error::custom)
    }
}
