//! A message as it was seen on a broker, and what its topic says.

use core::fmt;

use crate::message::{Topic, Version};

/// A message as it was seen on a broker.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    /// The time when it came, in seconds since 1970; `None` if that isn't known.
    pub time: Option<f64>,
    /// The topic.
    pub topic: &'a str,
    /// The content.
    pub payload: &'a [u8],
    /// The way it was published; `None` if that isn't known.
    pub delivery: Option<Delivery>,
}

/// The way in which a message was published.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Delivery {
    /// The quality of service.
    pub quality: u8,
    /// Whether the broker keeps it for those who come later.
    pub retained: bool,
}

/// A topic of the standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Subject {
    /// A topic whose messages are read.
    Read(Topic),
    /// The zones of a map; 3.0. Only its form is judged.
    ZoneSet,
    /// The answers of the master; 3.0. Only their form is judged.
    Responses,
}

impl Subject {
    /// The number of topics.
    pub const COUNT: usize = 8;

    pub fn of(name: &str) -> Option<Self> {
        match name {
            "zoneSet" => Some(Self::ZoneSet),
            "responses" => Some(Self::Responses),
            _ => Topic::ALL.into_iter().find(|topic| topic.name() == name).map(Self::Read),
        }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Read(topic) => topic.name(),
            Self::ZoneSet => "zoneSet",
            Self::Responses => "responses",
        }
    }

    /// Its place among all topics.
    pub fn index(self) -> usize {
        match self {
            Self::Read(topic) => Topic::ALL.iter().position(|other| *other == topic).unwrap_or(0),
            Self::ZoneSet => 6,
            Self::Responses => 7,
        }
    }

    /// Whether the master sends it.
    pub fn is_of_master(self) -> bool {
        matches!(
            self,
            Self::Read(Topic::Order | Topic::InstantActions) | Self::ZoneSet | Self::Responses
        )
    }

    /// Whether the broker keeps the last message of the topic.
    pub fn is_kept(self) -> bool {
        matches!(self, Self::Read(Topic::Connection | Topic::Factsheet) | Self::ZoneSet)
    }
}

/// The levels of a topic of a vehicle: `INTERFACE/vMAJOR/MANUFACTURER/SERIAL/NAME`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Address<'a> {
    /// All levels but the last, which tell the vehicle.
    pub vehicle: &'a str,
    /// The major version.
    pub major: char,
    /// The manufacturer.
    pub manufacturer: &'a str,
    /// The serial number.
    pub serial_number: &'a str,
    /// The topic; `None` if the standard doesn't know it.
    pub subject: Option<Subject>,
}

impl<'a> Address<'a> {
    /// Reads a topic; `None` if it isn't one of this interface.
    pub fn of(topic: &'a str) -> Option<Self> {
        let (vehicle, name) = topic.rsplit_once('/')?;
        let mut levels = vehicle.rsplitn(4, '/');
        let (serial_number, manufacturer) = (levels.next()?, levels.next()?);
        let major = match levels.next()? {
            "v2" => '2',
            "v3" => '3',
            _ => return None,
        };
        levels.next().filter(|interface| !interface.is_empty())?;
        Some(Self { vehicle, major, manufacturer, serial_number, subject: Subject::of(name) })
    }
}

/// The versions that traffic is judged by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Protocol {
    /// That of each message's header.
    #[default]
    Auto,
    /// One version, whatever headers say.
    Only(Version),
}

impl core::str::FromStr for Protocol {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "auto" {
            return Ok(Self::Auto);
        }
        text.parse().map(Self::Only).map_err(|_| "give auto, 2.0, 2.1 or 3.0".to_owned())
    }
}

impl fmt::Display for Protocol {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Only(version) => version.fmt(f),
        }
    }
}
