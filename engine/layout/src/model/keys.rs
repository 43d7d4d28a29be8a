//! The keys of nodes, edges, stations, zones, doors, lifts and background lines in our own format.

/// The keys of nodes and edges.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Field {
    Id,
    X,
    Y,
    Theta,
    /// The heading of robots, where `Theta` is that of curves.
    BodyHeading,
    Origin,
    Destination,
    CurveType,
    ParamF,
    ParamB,
    VelocityForward,
    VelocityBackwards,
    Name,
    Level,
    Zone,
    Role,
    /// The heading of robots on the map, constant along the edge.
    Heading,
    /// The angle of robots to the tangent of the edge.
    HeadingOffset,
    RotationAtOrigin,
    RotationAtDestination,
    /// A list of points.
    ControlPoints,
    /// A list of ids of nodes.
    Nodes,
    /// A list of ids of edges.
    Edges,
    /// The largest number of robots in a zone or a lift.
    Capacity,
    /// The rule of a zone, by name.
    Rule,
    OpeningSeconds,
    ClosingSeconds,
    SecondsPerLevel,
    /// The extents of a cabin.
    Width,
    Depth,
    /// The level where a cabin stands at the beginning.
    Home,
    /// A map of texts.
    Properties,
    /// A key of the format that is kept as a property.
    Kept,
}

/// The number of fields with a value.
pub(crate) const FIELDS: usize = Field::Kept as usize;

/// The keys of a node, normalized as by [`find`].
pub(crate) const NODE_KEYS: [(&str, Field); 13] = [
    ("id", Field::Id),
    ("x", Field::X),
    ("y", Field::Y),
    ("theta", Field::Theta),
    ("name", Field::Name),
    ("label", Field::Name),
    ("level", Field::Level),
    ("zone", Field::Zone),
    ("role", Field::Role),
    ("properties", Field::Properties),
    ("frameid", Field::Kept),
    ("thetaholomonic", Field::BodyHeading),
    ("thetaholonomic", Field::BodyHeading),
];

/// The keys of an edge, normalized as by [`find`].
pub(crate) const EDGE_KEYS: [(&str, Field); 19] = [
    ("id", Field::Id),
    ("originid", Field::Origin),
    ("destinationid", Field::Destination),
    ("curvetype", Field::CurveType),
    ("paramf", Field::ParamF),
    ("paramb", Field::ParamB),
    ("velocityforward", Field::VelocityForward),
    ("velocitybackwards", Field::VelocityBackwards),
    ("velocitybackward", Field::VelocityBackwards),
    ("name", Field::Name),
    ("label", Field::Name),
    ("level", Field::Level),
    ("zone", Field::Zone),
    ("heading", Field::Heading),
    ("headingoffset", Field::HeadingOffset),
    ("rotationatorigin", Field::RotationAtOrigin),
    ("rotationatdestination", Field::RotationAtDestination),
    ("controlpoints", Field::ControlPoints),
    ("properties", Field::Properties),
];

/// The keys of a station.
pub(crate) const STATION_KEYS: [(&str, Field); 7] = [
    ("name", Field::Name),
    ("label", Field::Name),
    ("role", Field::Role),
    ("nodes", Field::Nodes),
    ("x", Field::X),
    ("y", Field::Y),
    ("properties", Field::Properties),
];

/// The keys of a zone.
pub(crate) const ZONE_KEYS: [(&str, Field); 5] = [
    ("name", Field::Name),
    ("capacity", Field::Capacity),
    ("rule", Field::Rule),
    ("nodes", Field::Nodes),
    ("edges", Field::Edges),
];

/// The keys of a door.
pub(crate) const DOOR_KEYS: [(&str, Field); 5] = [
    ("name", Field::Name),
    ("edges", Field::Edges),
    ("line", Field::ControlPoints),
    ("openingseconds", Field::OpeningSeconds),
    ("closingseconds", Field::ClosingSeconds),
];

/// The keys of a lift.
pub(crate) const LIFT_KEYS: [(&str, Field); 12] = [
    ("name", Field::Name),
    ("nodes", Field::Nodes),
    ("x", Field::X),
    ("y", Field::Y),
    ("theta", Field::Theta),
    ("width", Field::Width),
    ("depth", Field::Depth),
    ("openingseconds", Field::OpeningSeconds),
    ("closingseconds", Field::ClosingSeconds),
    ("secondsperlevel", Field::SecondsPerLevel),
    ("capacity", Field::Capacity),
    ("home", Field::Home),
];

/// The keys of a line of the background.
pub(crate) const BACKGROUND_KEYS: [(&str, Field); 3] =
    [("line", Field::ControlPoints), ("points", Field::ControlPoints), ("level", Field::Level)];

/// Looks up a key, ignoring case, `_`, `-` and spaces.
pub(crate) fn find<T: Copy>(keys: &[(&str, T)], key: &str) -> Option<T> {
    let letters = key.bytes().filter(|byte| !b"_- ".contains(byte));
    let letters = letters.map(|byte| byte.to_ascii_lowercase());
    keys.iter().find(|(name, _)| letters.clone().eq(name.bytes())).map(|&(_, found)| found)
}
