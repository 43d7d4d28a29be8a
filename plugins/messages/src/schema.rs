//! The topics and the schemas of their messages.

use regatta_plugin::ColumnName;
use regatta_plugin::column::{ACTIVITY, TYPE};

/// The messages of `proto/regatta.proto`.
#[allow(clippy::all, clippy::pedantic, missing_docs, dead_code, reason = "generated")]
pub mod regatta {
    include!(concat!(env!("OUT_DIR"), "/regatta.rs"));
}

/// Foxglove's messages, which Foxglove, Rerun and other tools show.
#[allow(clippy::all, clippy::pedantic, missing_docs, dead_code, reason = "generated")]
pub mod foxglove {
    include!(concat!(env!("OUT_DIR"), "/foxglove.rs"));
}

/// The name of the encoding of protocol buffers, for messages and for schemas.
pub const PROTOBUF: &str = "protobuf";

/// The definitions of our messages: an encoded `google.protobuf.FileDescriptorSet`.
pub const REGATTA_DESCRIPTORS: &[u8] =
    include_bytes!(concat!(env!("OUT_DIR"), "/regatta.descriptors"));
/// The definitions of Foxglove's messages.
pub const FOXGLOVE_DESCRIPTORS: &[u8] =
    include_bytes!(concat!(env!("OUT_DIR"), "/foxglove.descriptors"));

/// The name of the coordinate frame of poses and the graph.
pub const FRAME_ID: &str = "map";

/// A topic. Each topic has its own channel.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Topic {
    /// The route graph and the robot types.
    World,
    /// Frames, bit for bit.
    Frames,
    /// Events of robots.
    Events,
    /// Commands that took effect or were refused.
    Commands,
    /// The log of transport orders.
    Orders,
    /// Pairs of robots that touch or may touch: whole lists.
    Contacts,
    /// Lists of contacts as changes from the list before.
    ContactUpdates,
    /// Contacts that began or ended.
    ContactEvents,
    /// The states of doors and lifts: those of all of them with each change.
    Facilities,
    /// A plugin's column.
    Column(ColumnName),
    /// Poses for general tools.
    Poses,
    /// Positions and states of robots as points, for tools that don't draw poses.
    Robots,
    /// The route graph for general tools.
    Graph,
    /// Points on the route graph, for tools that don't draw lines.
    GraphPoints,
    /// Robots that touch or may touch, as spheres.
    ContactMarkers,
}

const COLUMNS: &str = "/columns/";

impl Topic {
    /// All topics but those of columns.
    pub const FIXED: [Self; 14] = [
        Self::World,
        Self::Frames,
        Self::Events,
        Self::Commands,
        Self::Orders,
        Self::Contacts,
        Self::ContactUpdates,
        Self::ContactEvents,
        Self::Facilities,
        Self::Poses,
        Self::Robots,
        Self::Graph,
        Self::GraphPoints,
        Self::ContactMarkers,
    ];

    /// Returns the topic of the column that producers themselves publish: each robot's type.
    pub fn types() -> Option<Self> {
        TYPE.name().parse().ok().map(Self::Column)
    }

    /// Returns the topic of the column of activities.
    pub fn activities() -> Option<Self> {
        ACTIVITY.name().parse().ok().map(Self::Column)
    }

    /// Returns the name, or the start of the name of a column's topic, and the full name of the
    /// message type.
    fn name_and_schema(&self) -> (&'static str, &'static str) {
        match self {
            Self::World => ("/world", "regatta.World"),
            Self::Frames => ("/frames", "regatta.Frame"),
            Self::Events => ("/events", "regatta.Events"),
            Self::Commands => ("/commands", "regatta.Commands"),
            Self::Orders => ("/orders", "regatta.TransportOrders"),
            Self::Contacts => ("/contacts", "regatta.Contacts"),
            Self::ContactUpdates => ("/contact_updates", "regatta.ContactUpdate"),
            Self::ContactEvents => ("/contact_events", "regatta.ContactEvents"),
            Self::Facilities => ("/facilities", "regatta.Facilities"),
            Self::Column(_) => (COLUMNS, "regatta.Column"),
            Self::Poses => ("/poses", "foxglove.PosesInFrame"),
            Self::Robots => ("/robots", "foxglove.PointCloud"),
            Self::Graph => ("/graph", "foxglove.SceneUpdate"),
            Self::GraphPoints => ("/graph_points", "foxglove.PointCloud"),
            Self::ContactMarkers => ("/contact_markers", "foxglove.SceneUpdate"),
        }
    }

    /// Returns the name.
    pub fn name(&self) -> String {
        let (name, _) = self.name_and_schema();
        self.column().map_or_else(|| name.to_owned(), |column| format!("{name}{column}"))
    }

    /// Returns the topic with a name, if this crate knows it.
    pub fn from_name(name: &str) -> Option<Self> {
        if let Some(column) = name.strip_prefix(COLUMNS) {
            return column.parse().ok().map(Self::Column);
        }
        Self::FIXED.into_iter().find(|topic| topic.name() == name)
    }

    /// Returns the full name of the message type.
    pub fn schema(&self) -> &'static str {
        self.name_and_schema().1
    }

    /// Returns the definition of the message type: an encoded `google.protobuf.FileDescriptorSet`.
    pub fn descriptors(&self) -> &'static [u8] {
        match self.schema().starts_with("foxglove.") {
            true => FOXGLOVE_DESCRIPTORS,
            false => REGATTA_DESCRIPTORS,
        }
    }

    /// Returns the column's name, if this is the topic of a column.
    pub fn column(&self) -> Option<&ColumnName> {
        match self {
            Self::Column(name) => Some(name),
            _ => None,
        }
    }

    /// Whether a message stays valid on its own until the next one, so that it is worth repeating.
    pub fn is_repeated(&self) -> bool {
        matches!(self, Self::World | Self::Column(_) | Self::Facilities)
            || matches!(self, Self::Graph | Self::GraphPoints)
    }

    /// Whether a plugin publishes the messages rather than the producer.
    pub fn is_from_plugin(&self) -> bool {
        match self {
            Self::Column(name) => name.as_str() != TYPE.name(),
            _ => matches!(
                self,
                Self::Orders | Self::Contacts | Self::ContactUpdates | Self::ContactEvents
            ),
        }
    }

    /// Whether each message is a state that is valid until the next message, or an update of one. A
    /// reader that starts in the middle of a recording needs the state at its start.
    pub fn is_state(&self) -> bool {
        matches!(self, Self::World | Self::Column(_) | Self::Facilities)
            || matches!(self, Self::Contacts | Self::ContactUpdates)
    }
}

#[cfg(test)]
mod tests {
    use prost::Message;

    use super::*;

    fn all() -> Vec<Topic> {
        Topic::FIXED.into_iter().chain([Topic::Column("collision".parse().unwrap())]).collect()
    }

    #[test]
    fn topics_are_found_by_their_names() {
        for topic in all() {
            assert_eq!(Topic::from_name(&topic.name()), Some(topic));
        }
        assert_eq!(Topic::from_name("/columns/a b"), None);
        assert_eq!(Topic::from_name("/tf"), None);
    }

    #[test]
    fn every_schema_is_in_its_descriptors() {
        for topic in all() {
            let set = prost_types::FileDescriptorSet::decode(topic.descriptors()).unwrap();
            let names = set.file.iter().flat_map(|file| {
                file.message_type
                    .iter()
                    .map(move |message| format!("{}.{}", file.package(), message.name()))
            });
            assert!(names.into_iter().any(|name| name == topic.schema()), "{topic:?}");
        }
    }
}
