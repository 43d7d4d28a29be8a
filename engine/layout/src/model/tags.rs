//! The properties of nodes, edges and stations besides their geometry.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use glam::DVec2;
use regatta_base::graph::NodeIndex;

use super::angle::normalize_angle;

/// The key of the property with the vehicle types of a LIF layout that a node or an edge has its
/// properties of, separated by commas and spaces.
pub const VEHICLE_TYPES: &str = "vehicleTypeId";

/// The key of the property with the vehicle types whose properties differ and aren't kept.
pub const OTHER_VEHICLE_TYPES: &str = "otherVehicleTypeId";

/// The property of a node with its other names: a list of texts in JSON.
pub const ALIASES: &str = "aliases";
/// The property with the name in the file of a node or an edge whose id is a text.
pub(crate) const NAME: &str = "name";

/// Names, places and free properties of a node or an edge. They are boxed, as most graphs have
/// none.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tags {
    /// The name: the id in the file if that isn't a number, or a separate name.
    pub name: Option<Box<str>>,
    /// The level (floor) of a building.
    pub level: Option<Box<str>>,
    /// The group of nodes and edges in the file: a zone, a block or a mutex group. Those with a
    /// rule are [`zones`](crate::RouteGraph::zones), too.
    pub zone: Option<Box<str>>,
    /// All other keys of the file, as text.
    pub properties: BTreeMap<Box<str>, Box<str>>,
}

impl Tags {
    /// Returns the tags in a box, or `None` if there are none.
    pub fn boxed(self) -> Option<Box<Self>> {
        (self != Self::default()).then(|| Box::new(self))
    }

    /// Returns a box of tags with only a name.
    pub fn named(name: &str) -> Self {
        Self { name: Some(name.into()), ..Self::default() }
    }

    /// Returns the other names of a node: the one beside an id that is a text, and those of nodes
    /// at the same place that are joined with it.
    pub fn aliases(&self) -> Vec<String> {
        let mut names: Vec<String> =
            self.properties.get(NAME).map(ToString::to_string).into_iter().collect();
        names.extend(self.joined_names());
        names
    }

    /// Returns the names of the nodes that are joined with a node.
    fn joined_names(&self) -> Vec<String> {
        let json = self.properties.get(ALIASES);
        json.and_then(|json| serde_json::from_str(json).ok()).unwrap_or_default()
    }

    /// Adds other names of a node that it doesn't have.
    pub(crate) fn add_aliases(&mut self, names: Vec<String>) {
        let mut all = self.joined_names();
        for name in names {
            if self.name.as_deref() != Some(&name) && !self.aliases().contains(&name) {
                all.push(name);
                self.set_aliases(&all);
            }
        }
    }

    /// Sets the other names of a node.
    pub(crate) fn set_aliases(&mut self, names: &[String]) {
        self.set(ALIASES, &serde_json::Value::from(names).to_string());
    }

    /// Adds a property, unless its value is empty.
    pub fn set(&mut self, key: &str, value: &str) {
        if !value.is_empty() {
            self.properties.insert(key.into(), value.into());
        }
    }
}

/// The purpose of a node or a station.
#[derive(
    Clone,
    Copy,
    Debug,
    Default,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    strum::IntoStaticStr,
    strum::VariantArray,
)]
#[strum(serialize_all = "lowercase")]
#[repr(u8)]
pub enum Role {
    /// No special purpose.
    #[default]
    None = 0,
    /// Pick a load up.
    Pick = 1,
    /// Drop a load.
    Drop = 2,
    /// Park.
    Park = 3,
    /// Charge.
    Charge = 4,
    /// Pick a load up, or drop one.
    Transfer = 5,
}

impl Role {
    /// Whether loads are picked up there.
    pub fn is_pick(self) -> bool {
        matches!(self, Self::Pick | Self::Transfer)
    }

    /// Whether loads are dropped there.
    pub fn is_drop(self) -> bool {
        matches!(self, Self::Drop | Self::Transfer)
    }

    /// Whether loads are picked up or dropped there.
    pub fn handles_loads(self) -> bool {
        self.is_pick() || self.is_drop()
    }

    /// Returns the role of a place with two roles: the one of loads, or else the first;
    /// [`Transfer`](Self::Transfer) if loads are picked up and dropped there.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        match (self, other) {
            (Self::None, other) => other,
            (Self::Pick, Self::Drop | Self::Transfer)
            | (Self::Drop, Self::Pick | Self::Transfer) => Self::Transfer,
            (Self::Park | Self::Charge, other) if other.handles_loads() => other,
            _ => self,
        }
    }
}

regatta_base::named!(Role, "a role");

/// The heading of a robot along an edge. It is the same in both gears.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Orientation {
    /// Along the tangent of the edge, from origin to destination.
    #[default]
    Tangential,
    /// This angle to the tangent, in radians in (-π, π]. π is tail first. Other angles need a robot
    /// that can drive sideways.
    Offset(f64),
    /// This heading on the map, in radians in (-π, π].
    Fixed(f64),
}

impl Orientation {
    /// Returns the heading in radians, in (-π, π], where the tangent of the edge has the angle
    /// `tangent`.
    pub fn heading(self, tangent: f64) -> f64 {
        match self {
            Self::Tangential => tangent,
            Self::Offset(offset) => normalize_angle(tangent + offset),
            Self::Fixed(heading) => heading,
        }
    }

    /// Returns the orientation of the reversed edge at which robots keep their heading.
    #[must_use]
    pub fn reversed(self) -> Self {
        match self {
            Self::Tangential => Self::Offset(PI),
            Self::Offset(angle) => Self::Offset(normalize_angle(angle + PI)),
            Self::Fixed(heading) => Self::Fixed(heading),
        }
    }

    /// Applies a function to the angle of the orientation, if it has one.
    #[must_use]
    pub(crate) fn map(self, change: impl FnOnce(f64) -> f64) -> Self {
        match self {
            Self::Tangential => Self::Tangential,
            Self::Offset(angle) => Self::Offset(change(angle)),
            Self::Fixed(heading) => Self::Fixed(change(heading)),
        }
    }

    /// Returns the offset or the heading in radians; `None` for [`Orientation::Tangential`].
    pub(crate) fn angle(self) -> Option<f64> {
        match self {
            Self::Tangential => None,
            Self::Offset(angle) | Self::Fixed(angle) => Some(angle),
        }
    }
}

/// A line that is drawn under the graph and means nothing to robots: a wall, the outline of a floor
/// or a rack.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BackgroundLine {
    /// The points that it leads through, in metres.
    pub points: Vec<DVec2>,
    /// The level (floor) of a building.
    pub level: Option<Box<str>>,
}

/// A line on all levels.
impl From<Vec<DVec2>> for BackgroundLine {
    fn from(points: Vec<DVec2>) -> Self {
        Self { points, level: None }
    }
}

/// A place that robots serve from adjacent nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Station {
    /// The name, unique among stations.
    pub name: String,
    /// The purpose of the station.
    pub role: Role,
    /// The nodes from which robots serve the station.
    pub nodes: Vec<NodeIndex>,
    /// Metres; `None` if the file gives no position.
    pub position: Option<DVec2>,
    /// All other keys of the file, as text.
    pub properties: BTreeMap<Box<str>, Box<str>>,
}

/// The key of a station's second name in LIF.
const STATION_NAME: &str = "stationName";

impl Station {
    /// Returns its name, and the second one that LIF gives it, which several stations may have.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        let second = self.properties.get(STATION_NAME).map(|name| &**name);
        std::iter::once(self.name.as_str()).chain(second)
    }
}
