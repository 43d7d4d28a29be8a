//! Findings: what the judge found, counted by kind, with examples.

use serde::Serialize;

/// A kind of finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Kind {
    /// The footprints of two robots overlap.
    Contact,
    /// A pose is beside the curve of its edge.
    OffGraph,
    /// A heading differs from that of the edge.
    Heading,
    /// A robot drives an edge against its direction, or against its gear.
    WrongDirection,
    /// A robot moved further than its speed limit and the time allow.
    Teleport,
    /// A robot is faster than its edge or its type allows.
    Speed,
    /// A robot speeds up faster than its type allows.
    Acceleration,
    /// A robot slows down faster than its type allows. The engine brakes so only when an order
    /// takes its road away.
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
    /// A robot got a task while it had another.
    TwoTasks,
    /// A task went on after its end.
    DoneTwice,
    /// A task wasn't finished for a long time.
    Unserved,
    /// A robot did nothing for a long time while tasks waited.
    Idle,
    /// Records of a task that contradict each other.
    TaskOrder,
    /// A robot stopped because its battery was flat.
    FlatBattery,
}

impl Kind {
    /// All kinds, in the order of reports.
    pub const ALL: [Self; 22] = [
        Self::Contact,
        Self::OffGraph,
        Self::Heading,
        Self::WrongDirection,
        Self::Teleport,
        Self::Speed,
        Self::Acceleration,
        Self::HardBraking,
        Self::Rotation,
        Self::BrokenRoute,
        Self::InvalidPose,
        Self::DropWithoutPick,
        Self::WrongPlace,
        Self::ShortDwell,
        Self::MovedInDwell,
        Self::SkippedStop,
        Self::TwoTasks,
        Self::DoneTwice,
        Self::Unserved,
        Self::Idle,
        Self::TaskOrder,
        Self::FlatBattery,
    ];

    /// The name, as options and reports have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Contact => "contact",
            Self::OffGraph => "off-graph",
            Self::Heading => "heading",
            Self::WrongDirection => "wrong-direction",
            Self::Teleport => "teleport",
            Self::Speed => "speed",
            Self::Acceleration => "acceleration",
            Self::HardBraking => "hard-braking",
            Self::Rotation => "rotation",
            Self::BrokenRoute => "broken-route",
            Self::InvalidPose => "invalid-pose",
            Self::DropWithoutPick => "drop-without-pick",
            Self::WrongPlace => "wrong-place",
            Self::ShortDwell => "short-dwell",
            Self::MovedInDwell => "moved-in-dwell",
            Self::SkippedStop => "skipped-stop",
            Self::TwoTasks => "two-tasks",
            Self::DoneTwice => "done-twice",
            Self::Unserved => "unserved",
            Self::Idle => "idle",
            Self::TaskOrder => "task-order",
            Self::FlatBattery => "flat-battery",
        }
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
            _ => "",
        }
    }

    pub(crate) fn bit(self) -> u32 {
        1 << self as u8
    }
}

impl std::str::FromStr for Kind {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|kind| kind.name() == text).ok_or_else(|| {
            let names: Vec<_> = Self::ALL.iter().map(|kind| kind.name()).collect();
            format!("unknown kind '{text}'; the kinds are {}", names.join(", "))
        })
    }
}

/// One finding.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// The tick in which it was seen first.
    pub tick: u64,
    /// Its simulated time in seconds.
    pub time_secs: f64,
    /// The robots, by id.
    pub robots: Vec<u32>,
    /// The task.
    pub task: Option<u64>,
    /// The id of the first robot's edge.
    pub edge: Option<u32>,
    /// Metres east and north.
    pub place: Option<[f32; 2]>,
    /// What was measured, in the unit of the kind.
    pub value: Option<f64>,
    /// What is allowed, in the same unit.
    pub limit: Option<f64>,
    /// How long it lasted, in seconds (contacts).
    pub duration_secs: Option<f64>,
    /// What is wrong, if the kind alone doesn't say it.
    pub note: &'static str,
}

impl Finding {
    pub(crate) fn at(tick: u64, time_secs: f64) -> Self {
        Self {
            tick,
            time_secs,
            robots: Vec::new(),
            task: None,
            edge: None,
            place: None,
            value: None,
            limit: None,
            duration_secs: None,
            note: "",
        }
    }
}

/// Counts of all kinds, and the first examples of each.
#[derive(Clone, Debug)]
pub(crate) struct Findings {
    counts: [u64; Kind::ALL.len()],
    examples: [Vec<Finding>; Kind::ALL.len()],
    most_examples: usize,
}

impl Findings {
    pub fn new(most_examples: usize) -> Self {
        Self {
            counts: [0; Kind::ALL.len()],
            examples: std::array::from_fn(|_| Vec::new()),
            most_examples,
        }
    }

    /// Counts a finding; `make` makes the example, if there is room for one.
    pub fn add(&mut self, kind: Kind, make: impl FnOnce() -> Finding) {
        self.counts[kind as usize] += 1;
        let examples = &mut self.examples[kind as usize];
        if examples.len() < self.most_examples {
            examples.push(make());
        }
    }

    pub fn count(&self, kind: Kind) -> u64 {
        self.counts[kind as usize]
    }

    pub fn examples(&self, kind: Kind) -> &[Finding] {
        &self.examples[kind as usize]
    }
}
