//! The structure of a scenario file. Names are not resolved yet.

use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;
use std::num::NonZeroU32;
use std::path::PathBuf;

use serde::{Deserialize, Deserializer, de};

use super::{Battery, RobotCount, Shape};

/// A scenario file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScenarioFile {
    /// The route graph file, relative to the scenario's folder.
    pub graph: PathBuf,
    /// The options of reading it, if it is of another format.
    #[serde(default)]
    pub layout: LayoutEntry,
    /// The number of ticks per simulated second.
    #[serde(default = "default_rate")]
    pub rate: f64,
    /// The number of frames per simulated second; one per tick by default.
    pub publish_rate: Option<f64>,
    /// The seed of the random walks.
    #[serde(default)]
    pub seed: u64,
    /// Simulated seconds that `regatta run` drives before the first picture.
    #[serde(default)]
    pub warm_up: f64,
    /// Roles and names of nodes instead of those in the graph, by the node's id or name.
    #[serde(default, deserialize_with = "distinct")]
    pub nodes: BTreeMap<Key, NodeEntry>,
    /// The times of doors instead of those in the graph, by name.
    #[serde(default, deserialize_with = "distinct")]
    pub doors: BTreeMap<Key, DoorEntry>,
    /// The times and the capacity of lifts instead of those in the graph, by name.
    #[serde(default, deserialize_with = "distinct")]
    pub lifts: BTreeMap<Key, LiftEntry>,
    /// The robot types; one default type if empty.
    #[serde(default)]
    pub robot_types: Vec<RobotTypeEntry>,
    /// The groups of robots, in the order of their ids.
    pub robots: Vec<RobotGroupEntry>,
    /// The disturbances; none by default.
    #[serde(default)]
    pub disturbances: Disturbances,
    /// The transport orders of a fleet manager, which reads them itself.
    pub load: Option<de::IgnoredAny>,
    /// The plugins to start.
    #[serde(default)]
    pub plugins: Vec<PluginEntry>,
    /// Whether `regatta run` opens the viewer.
    #[serde(default)]
    pub viewer: Viewer,
    /// The lights of the viewer, which reads them itself.
    pub lights: Option<de::IgnoredAny>,
    /// The cameras of the viewer, which reads them itself.
    pub cameras: Option<de::IgnoredAny>,
}

fn default_rate() -> f64 {
    100.0
}

/// The options of reading a layout of another format.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LayoutEntry {
    /// The format; detected by the content by default.
    pub format: Option<String>,
    /// The level (floor) or layout to read; all by default.
    pub level: Option<String>,
    /// The vehicle type of a LIF layout; the first by default.
    pub vehicle_type: Option<String>,
    /// The layers of a drawing whose lines are edges; all by default.
    pub layers: Vec<String>,
    /// The unit of a drawing: mm, cm, m, in or ft.
    pub units: Option<String>,
    /// The width in metres of robots for which a roadmap is made of a map without a graph.
    pub skeleton: Option<f64>,
    /// The length in metres of the side of a grid map's cells; 1 by default.
    pub cell_size: Option<f64>,
    /// A map of the ROS map server whose outlines are drawn behind the layout, relative to the
    /// scenario's folder.
    pub background: Option<PathBuf>,
}

/// A node or an edge by its id or its name.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Key {
    /// A number.
    Id(u64),
    /// A text, which may look like a number.
    Name(String),
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Id(id) => id.fmt(f),
            Self::Name(name) => name.fmt(f),
        }
    }
}

impl<'de> Deserialize<'de> for Key {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(KeyVisitor)
    }
}

struct KeyVisitor;

impl de::Visitor<'_> for KeyVisitor {
    type Value = Key;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the id or the name of a node")
    }

    fn visit_u64<E>(self, id: u64) -> Result<Key, E> {
        Ok(Key::Id(id))
    }

    fn visit_str<E>(self, name: &str) -> Result<Key, E> {
        Ok(Key::Name(name.to_owned()))
    }
}

/// The role and the name of a node. If absent, they are those of the graph.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NodeEntry {
    /// The purpose: none, pick, drop, park or charge.
    pub role: Option<String>,
    /// The name.
    pub name: Option<String>,
}

/// Reads a map in which no key is given twice.
fn distinct<'de, D, V>(deserializer: D) -> Result<BTreeMap<Key, V>, D::Error>
where
    D: Deserializer<'de>,
    V: Deserialize<'de>,
{
    struct Entries<V>(PhantomData<V>);

    impl<'de, V: Deserialize<'de>> de::Visitor<'de> for Entries<V> {
        type Value = BTreeMap<Key, V>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a map (key: value)")
        }

        fn visit_map<A: de::MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
            let mut entries = BTreeMap::new();
            while let Some(key) = map.next_key::<Key>()? {
                let name = key.to_string();
                if entries.insert(key, map.next_value()?).is_some() {
                    return Err(de::Error::custom(format!("{name} is given twice: remove one")));
                }
            }
            Ok(entries)
        }
    }

    deserializer.deserialize_map(Entries(PhantomData))
}

/// The times of a door. If absent, they are those of the graph.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DoorEntry {
    /// Seconds from closed to open.
    pub opening_secs: Option<f64>,
    /// Seconds from open to closed.
    pub closing_secs: Option<f64>,
}

/// The times and the capacity of a lift. If absent, they are those of the graph.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LiftEntry {
    /// Seconds of the cabin from a level to the next.
    pub level_secs: Option<f64>,
    /// Seconds from closed to open of its doors.
    pub opening_secs: Option<f64>,
    /// Seconds from open to closed.
    pub closing_secs: Option<f64>,
    /// The largest number of robots in the cabin.
    pub capacity: Option<NonZeroU32>,
    /// The name of the level where it stands at the beginning.
    pub home: Option<String>,
}

/// A robot type.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotTypeEntry {
    /// The name that `type:` refers to.
    pub name: String,
    /// The footprint; a rectangle by default.
    #[serde(default)]
    pub shape: Shape,
    /// Metres along the heading; the diameter of a circle.
    pub length: f32,
    /// Metres across the heading; required for a rectangle.
    pub width: Option<f32>,
    /// Metres per second; no limit by default.
    pub max_speed: Option<f32>,
    /// Metres per second squared; by default speed changes instantly.
    pub max_acceleration: Option<f32>,
    /// Radians per second at which it turns on the spot; by default it can't.
    pub max_rotation_speed: Option<f32>,
    /// Radians per second squared; by default the rotation speed changes instantly.
    pub max_rotation_acceleration: Option<f32>,
    /// The battery; by default it has none and never needs charging.
    pub battery: Option<Battery>,
}

/// A group of robots that start in the same way.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotGroupEntry {
    /// The number of robots; 1 by default.
    #[serde(default = "one")]
    pub count: RobotCount,
    /// The name of a robot type; the first type by default.
    #[serde(rename = "type")]
    pub robot_type: Option<String>,
    /// The ids or names of the edges in order, with `-` before those in reverse gear. The robots
    /// start at the beginning of the first.
    pub route: Option<Vec<LegKey>>,
    /// The action at the end of `route`.
    pub repeat: Option<Repeat>,
    /// Endless random walks from random places, or none: robots that wait for commands.
    pub routes: Option<RoutesEntry>,
    /// The id or the name of a node where the robots wait for commands.
    pub node: Option<Key>,
}

fn one() -> RobotCount {
    RobotCount(1)
}

/// The action of a robot at the end of its route.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Repeat {
    /// The robot stops.
    Once,
    /// The robot drives the route again; the route must end where it starts.
    Loop,
}

/// Routes that aren't listed edge by edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RoutesEntry {
    /// A random edge at each node.
    Random,
    /// None: robots wait for commands where they touch no others.
    None,
}

/// Disturbances of robots, at random by the scenario's seed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Disturbances {
    /// Robots that stop for a while.
    pub stalls: Option<Stalls>,
    /// Robots that break down.
    pub breakdowns: Option<Breakdowns>,
    /// The largest part of its speed by which a robot is slower on a leg; 0 to below 1.
    pub speed_variation: f32,
}

/// Robots that stop for a while, after times with an exponential distribution.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stalls {
    /// Stalls per hour and robot.
    pub per_hour: f64,
    /// The mean of a stall's duration in seconds, which is distributed exponentially.
    pub mean_secs: f64,
    /// The part of the robots that stall; all by default.
    #[serde(default = "all")]
    pub share: f64,
}

fn all() -> f64 {
    1.0
}

/// Robots that break down, after times with an exponential distribution.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Breakdowns {
    /// Breakdowns per hour and robot.
    pub per_hour: f64,
    /// Seconds after which a robot is repaired; by default only a command repairs it.
    pub repair_secs: Option<f64>,
}

/// Whether to open the viewer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Viewer {
    /// If the viewer is installed and there is a display.
    #[default]
    Auto,
    /// Yes; a failure is an error.
    On,
    /// No.
    Off,
}

/// A plugin to start.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PluginEntry {
    /// The name of a plugin that comes with Regatta.
    Name(String),
    /// A plugin with arguments, or any other program.
    Detailed(PluginCommand),
}

// Not derived: `untagged` loses the problem inside of the map.
impl<'de> Deserialize<'de> for PluginEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(PluginVisitor)
    }
}

struct PluginVisitor;

impl<'de> de::Visitor<'de> for PluginVisitor {
    type Value = PluginEntry;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the name of a plugin, or a map with the keys name, command, args and after")
    }

    fn visit_str<E>(self, name: &str) -> Result<Self::Value, E> {
        Ok(PluginEntry::Name(name.to_owned()))
    }

    fn visit_map<A: de::MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
        PluginCommand::deserialize(de::value::MapAccessDeserializer::new(map))
            .map(PluginEntry::Detailed)
    }
}

/// The command line of a plugin.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PluginCommand {
    /// The name in messages; without a `command`, the name of a plugin that comes with Regatta.
    pub name: String,
    /// The program and its arguments. A program with a slash in its name is relative to the
    /// scenario's folder. `--fleet NAME` is appended.
    #[serde(default)]
    pub command: Vec<String>,
    /// Additional arguments.
    #[serde(default)]
    pub args: Vec<String>,
    /// The names of the plugins that this one comes after in lockstep.
    #[serde(default)]
    pub after: Vec<String>,
}

impl PluginCommand {
    /// Returns the command line in words: the program, or the plugin's name, and its arguments.
    pub fn in_words(&self) -> String {
        let name = std::slice::from_ref(&self.name);
        let program = if self.command.is_empty() { name } else { &self.command };
        [program, &self.args].concat().join(" ")
    }
}

/// A leg of a route: its edge, and `-` before it in reverse gear, from destination to origin.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LegKey {
    /// A number.
    Id {
        /// The id of the edge.
        id: u64,
        /// Whether the number is negative.
        is_reverse: bool,
    },
    /// A text: the name or the id of an edge, maybe after `-`.
    Name(String),
}

impl fmt::Display for LegKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Id { id, is_reverse } => {
                write!(f, "{}{id}", if *is_reverse { "-" } else { "" })
            }
            Self::Name(name) => name.fmt(f),
        }
    }
}

impl<'de> Deserialize<'de> for LegKey {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(LegVisitor)
    }
}

struct LegVisitor;

impl de::Visitor<'_> for LegVisitor {
    type Value = LegKey;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the id or the name of an edge, with - before it in reverse gear")
    }

    fn visit_u64<E>(self, id: u64) -> Result<LegKey, E> {
        Ok(LegKey::Id { id, is_reverse: false })
    }

    fn visit_i64<E>(self, id: i64) -> Result<LegKey, E> {
        Ok(LegKey::Id { id: id.unsigned_abs(), is_reverse: id < 0 })
    }

    fn visit_str<E>(self, name: &str) -> Result<LegKey, E> {
        Ok(LegKey::Name(name.to_owned()))
    }
}
