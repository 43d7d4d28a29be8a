//! Findings, counted by kind, with examples.

use std::borrow::Cow;
use std::fmt;

use clap::ValueEnum;
use serde::Serialize;

/// A kind of finding. Options and reports name it in lower case, with hyphens.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
#[repr(u8)]
pub enum Kind {
    /// The footprints of two robots overlap.
    Contact,
    /// A pose is beside the curve of its edge.
    OffGraph,
    /// A heading differs from that of the edge.
    Heading,
    /// A robot drives an edge against its direction, or in a gear that isn't allowed.
    WrongDirection,
    /// A robot moved further than its speed limit and the time allow.
    Teleport,
    /// A robot is faster than its edge or its type allows.
    Speed,
    /// A robot speeds up faster than its type allows.
    Acceleration,
    /// A robot slows down faster than its type allows. The engine brakes so only when a command
    /// shortens its route.
    HardBraking,
    /// A robot turns on the spot faster than its type allows.
    Rotation,
    /// A robot is on an edge that doesn't follow the one before.
    BrokenRoute,
    /// A pose that is not a number.
    InvalidPose,
    /// A load was dropped that wasn't picked.
    DropWithoutPick,
    /// A stop was handled by a robot that didn't stand at its node.
    WrongPlace,
    /// A robot stayed at a stop for less than its dwell time.
    ShortDwell,
    /// A robot moved during its dwell time.
    MovedInDwell,
    /// A stop was left out.
    SkippedStop,
    /// A robot got an order while it had another.
    TwoOrders,
    /// An order went on after its end.
    DoneTwice,
    /// An order wasn't finished for a long time.
    Unserved,
    /// No robot can carry an order out: no way leads to its stops, its robot isn't in the fleet,
    /// or no battery lasts for it.
    Unroutable,
    /// A robot did nothing for a long time while orders waited.
    Idle,
    /// Records of an order that contradict each other.
    ContradictoryRecords,
    /// A robot stopped because its battery was flat.
    FlatBattery,
    /// More robots are in a zone than its rule allows, or robots from several sides.
    Zone,
    /// All robots with orders stood for a long time.
    Standstill,
    /// Robots with orders drove for a long time, some in circles, and none came to a stop.
    Livelock,
    /// A robot with an order stood for a long time while others drove.
    Stuck,
}

/// The number of kinds.
const KINDS: usize = Kind::Stuck as usize + 1;

impl Kind {
    /// All kinds, in the order of reports.
    pub fn all() -> impl Iterator<Item = Self> {
        Self::value_variants().iter().copied()
    }

    /// The unit of a finding's value and limit; empty if it has none.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Contact
            | Self::OffGraph
            | Self::Teleport
            | Self::WrongPlace
            | Self::WrongDirection => "m",
            Self::Heading => "rad",
            Self::Speed => "m/s",
            Self::Acceleration | Self::HardBraking => "m/s²",
            Self::Rotation => "rad/s",
            Self::ShortDwell | Self::Unserved | Self::Idle => "s",
            Self::Standstill | Self::Livelock | Self::Stuck => "s",
            _ => "",
        }
    }

    /// The kinds that depend on nothing but the place of a robot, its heading, and whether it
    /// stands: those of [`check_place`](crate::graph::check_place), as bits.
    pub(crate) const OF_PLACE: u32 = Self::OffGraph.bit() | Self::Heading.bit();

    pub(crate) const fn bit(self) -> u32 {
        1 << self as u8
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.to_possible_value().map_or(Ok(()), |value| f.pad(value.get_name()))
    }
}

/// One finding.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// The first tick in which it was seen.
    pub tick: u64,
    /// Its simulated time in seconds.
    pub time_secs: f64,
    /// The robots, by id.
    pub robots: Vec<u32>,
    /// The order.
    pub order: Option<u64>,
    /// The id of the first robot's edge.
    pub edge: Option<u32>,
    /// Metres east and north.
    pub place: Option<[f32; 2]>,
    /// The measured value, in the unit of the kind.
    pub value: Option<f64>,
    /// The allowed value, in the same unit.
    pub limit: Option<f64>,
    /// Its duration in seconds (contacts, and robots that made no progress, only).
    pub duration_secs: Option<f64>,
    /// An explanation, if the kind alone isn't enough.
    pub note: Cow<'static, str>,
}

impl Finding {
    pub(crate) fn at(tick: u64, time_secs: f64) -> Self {
        Self {
            tick,
            time_secs,
            robots: Vec::new(),
            order: None,
            edge: None,
            place: None,
            value: None,
            limit: None,
            duration_secs: None,
            note: Cow::Borrowed(""),
        }
    }
}

/// The count of each kind, and its first examples.
#[derive(Clone, Debug)]
pub(crate) struct Findings {
    counts: [u64; KINDS],
    examples: [Vec<Finding>; KINDS],
    max_examples: usize,
}

impl Findings {
    pub fn new(max_examples: usize) -> Self {
        Self { counts: [0; KINDS], examples: [const { Vec::new() }; KINDS], max_examples }
    }

    /// Counts a finding. `make` makes the example, if there is room for one.
    pub fn add(&mut self, kind: Kind, make: impl FnOnce() -> Finding) {
        self.counts[kind as usize] += 1;
        let examples = &mut self.examples[kind as usize];
        if examples.len() < self.max_examples {
            examples.push(make());
        }
    }

    /// Sets the duration of the newest finding of a kind, if it is an example.
    pub fn set_duration(&mut self, kind: Kind, duration_secs: f64) {
        let examples = &mut self.examples[kind as usize];
        if self.counts[kind as usize] == examples.len() as u64
            && let Some(newest) = examples.last_mut()
        {
            newest.duration_secs = Some(duration_secs);
        }
    }

    /// Sets the duration of the newest finding of a kind about a robot, if it is an example.
    pub fn set_duration_of(&mut self, kind: Kind, robot: u32, duration_secs: f64) {
        let mut newest_first = self.examples[kind as usize].iter_mut().rev();
        if let Some(found) = newest_first.find(|found| found.robots == [robot]) {
            found.duration_secs = Some(duration_secs);
        }
    }

    pub fn count(&self, kind: Kind) -> u64 {
        self.counts[kind as usize]
    }

    pub fn examples(&self, kind: Kind) -> &[Finding] {
        &self.examples[kind as usize]
    }
}
