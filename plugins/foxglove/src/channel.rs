//! The channels: topics of recordings, live, and two that only live views have.

use regatta_messages::Topic;
use regatta_messages::schema::{FOXGLOVE_DESCRIPTORS, REGATTA_DESCRIPTORS};

/// A channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Channel {
    World,
    Frames,
    Poses,
    Robots,
    Graph,
    GraphPoints,
    Contacts,
    ContactMarkers,
    Figures,
    Log,
}

impl Channel {
    pub const ALL: [Self; 10] = [
        Self::World,
        Self::Frames,
        Self::Poses,
        Self::Robots,
        Self::Graph,
        Self::GraphPoints,
        Self::Contacts,
        Self::ContactMarkers,
        Self::Figures,
        Self::Log,
    ];

    /// The channels whose messages are those of a frame.
    pub const OF_FRAMES: [Self; 3] = [Self::Frames, Self::Poses, Self::Robots];
    /// The channels whose messages are those of a world.
    pub const OF_WORLDS: [Self; 3] = [Self::World, Self::Graph, Self::GraphPoints];
    /// The channels whose messages are those of a list of contacts.
    pub const OF_CONTACTS: [Self; 2] = [Self::Contacts, Self::ContactMarkers];

    /// Its number in the protocol.
    pub fn id(self) -> u32 {
        self as u32 + 1
    }

    /// The channel with a number.
    pub fn of_id(id: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|channel| channel.id() == id)
    }

    /// The topic of recordings that it has live.
    fn recorded(self) -> Option<Topic> {
        Some(match self {
            Self::World => Topic::World,
            Self::Frames => Topic::Frames,
            Self::Poses => Topic::Poses,
            Self::Robots => Topic::Robots,
            Self::Graph => Topic::Graph,
            Self::GraphPoints => Topic::GraphPoints,
            Self::Contacts => Topic::Contacts,
            Self::ContactMarkers => Topic::ContactMarkers,
            Self::Figures | Self::Log => return None,
        })
    }

    pub fn topic(self) -> String {
        match self {
            Self::Log => "/log".to_owned(),
            channel => channel.recorded().map_or("/figures".to_owned(), |topic| topic.name()),
        }
    }

    /// The full name of the type of its messages.
    pub fn schema(self) -> &'static str {
        match self {
            Self::Log => "foxglove.Log",
            channel => channel.recorded().map_or("regatta.Figures", |topic| topic.schema()),
        }
    }

    /// The definition of that type: an encoded `google.protobuf.FileDescriptorSet`.
    pub fn descriptors(self) -> &'static [u8] {
        match self.schema().starts_with("foxglove.") {
            true => FOXGLOVE_DESCRIPTORS,
            false => REGATTA_DESCRIPTORS,
        }
    }

    /// Whether every message counts: those of the other channels are states, of which only the
    /// newest one does.
    pub fn is_log(self) -> bool {
        self == Self::Log
    }

    fn bit(self) -> u16 {
        1 << self as u8
    }
}

/// Some of the channels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct ChannelSet(u16);

impl ChannelSet {
    pub fn of(channels: &[Channel]) -> Self {
        channels.iter().fold(Self::default(), |set, channel| set.with(*channel))
    }

    #[must_use]
    pub fn with(self, channel: Channel) -> Self {
        Self(self.0 | channel.bit())
    }

    #[must_use]
    pub fn without(self, channel: Channel) -> Self {
        Self(self.0 & !channel.bit())
    }

    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    pub fn has(self, channel: Channel) -> bool {
        self.0 & channel.bit() != 0
    }

    pub fn is_empty(self) -> bool {
        self.0 == 0
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn each_channel_has_a_number_and_a_topic_of_its_own() {
        let ids: BTreeSet<_> = Channel::ALL.iter().map(|channel| channel.id()).collect();
        let topics: BTreeSet<_> = Channel::ALL.iter().map(|channel| channel.topic()).collect();
        assert_eq!((ids.len(), topics.len()), (Channel::ALL.len(), Channel::ALL.len()));
        for channel in Channel::ALL {
            assert_eq!(Channel::of_id(channel.id()), Some(channel));
        }
        assert_eq!(Channel::of_id(0), None);
    }

    #[test]
    fn sets_hold_channels() {
        let set = ChannelSet::of(&Channel::OF_FRAMES).with(Channel::Log);
        assert!(set.has(Channel::Poses) && set.has(Channel::Log) && !set.has(Channel::World));
        assert!(!set.without(Channel::Log).has(Channel::Log));
        assert!(set.and(ChannelSet::of(&Channel::OF_WORLDS)).is_empty());
    }
}
