//! What a file says about nodes and edges besides their geometry.

use std::collections::BTreeMap;

/// Names, places and free properties of a node or an edge. Most graphs have none, so they are kept
/// aside.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tags {
    /// The name: the file's own id if that isn't a number, or a name besides it.
    pub name: Option<Box<str>>,
    /// The level (floor) of a building.
    pub level: Option<Box<str>>,
    /// The zone, block or mutex group: what the file groups nodes and edges by.
    pub zone: Option<Box<str>>,
    /// Everything else that the file says, as text.
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

    /// Adds a property, unless its value is empty.
    pub fn set(&mut self, key: &str, value: &str) {
        if !value.is_empty() {
            self.properties.insert(key.into(), value.into());
        }
    }
}

/// What robots do at a node or a station.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Role {
    /// Nothing in particular.
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
}

impl Role {
    /// All roles, by number.
    pub const ALL: [Self; 5] = [Self::None, Self::Pick, Self::Drop, Self::Park, Self::Charge];

    /// Returns the name used in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Pick => "pick",
            Self::Drop => "drop",
            Self::Park => "park",
            Self::Charge => "charge",
        }
    }
}

/// The error of parsing a [`Role`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{}` is not a role: use none, pick, drop, park or charge", .0.escape_debug())]
pub struct ParseRoleError(String);

impl std::str::FromStr for Role {
    type Err = ParseRoleError;

    /// Parses a name, ignoring case.
    fn from_str(text: &str) -> Result<Self, ParseRoleError> {
        let is = |role: &Self| role.name().eq_ignore_ascii_case(text.trim());
        Self::ALL.into_iter().find(is).ok_or_else(|| ParseRoleError(text.trim().to_owned()))
    }
}

/// The heading of a robot along an edge. It is the same in both gears.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Orientation {
    /// Along the tangent of the edge, from origin to destination.
    #[default]
    Tangential,
    /// At this angle to the tangent, in radians in (-π, π]. π is tail first; other angles need a
    /// robot that can drive sideways.
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
            Self::Offset(offset) => super::angle::normalize_angle(tangent + offset),
            Self::Fixed(heading) => heading,
        }
    }
}

/// A place where robots do something, from nodes beside it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Station {
    /// The name, unique among stations.
    pub name: String,
    /// What robots do there.
    pub role: Role,
    /// The nodes from which they do it.
    pub nodes: Vec<regatta_base::graph::NodeIndex>,
    /// Metres, if the file says where it is itself.
    pub position: Option<glam::DVec2>,
    /// Everything else that the file says, as text.
    pub properties: BTreeMap<Box<str>, Box<str>>,
}
