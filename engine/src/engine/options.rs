//! The options, the summary and the error of a run.

use std::fmt;
use std::time::Duration;

use regatta_motion::Isa;
use regatta_plugin::producer::{LockstepOptions, Speed};
use regatta_plugin::{FleetName, LockstepError, OpenError, PublishError, ReadError, services};
use regatta_scenario::MAX_ROBOTS;

use crate::fleet::FleetError;

/// Options of a run.
#[derive(Clone, Debug)]
pub struct Options {
    /// The name of the fleet, and so of its services in shared memory.
    pub fleet: FleetName,
    /// The number of robots, instead of the scenario's.
    pub robots: Option<u32>,
    /// Requested simulated seconds per wall second.
    pub speed: Speed,
    /// The number of threads that move robots; at least one.
    pub threads: usize,
    /// The instruction set of the motion kernel; `None` for the best of this machine.
    pub isa: Option<Isa>,
    /// The number of ticks after which to stop.
    pub ticks: Option<u64>,
    /// Whether to digest every frame.
    pub digest: bool,
    /// The plugins to wait for after each frame.
    pub lockstep: LockstepOptions,
    /// The beginning that is driven as fast as possible.
    pub warm_up: WarmUp,
}

/// The beginning of a run that is driven as fast as possible, before anybody watches.
#[derive(Clone, Debug, Default)]
pub struct WarmUp {
    /// Its simulated time; none if zero.
    pub duration: Duration,
    /// The plugins that take part: the engine waits for them after each frame.
    pub plugins: Vec<String>,
}

impl Default for Options {
    /// The robots of the scenario, one thread, real time, no end.
    fn default() -> Self {
        Self {
            fleet: FleetName::default(),
            robots: None,
            speed: Speed::Factor(1.0),
            threads: 1,
            isa: None,
            ticks: None,
            digest: false,
            lockstep: LockstepOptions::default(),
            warm_up: WarmUp::default(),
        }
    }
}

/// The result of a run.
#[derive(Clone, Copy, Debug)]
pub struct Summary {
    /// Ticks since the start.
    pub ticks: u64,
    /// Simulated time.
    pub sim_time: Duration,
    /// Wall time.
    pub wall_time: Duration,
    /// The number of ticks that ended after their deadline.
    pub late_ticks: u64,
    /// The digest of every frame's columns, if it was requested.
    pub digest: Option<u128>,
}

/// Whether robots that stand took all places of a layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlacesTaken {
    /// No seed places more robots.
    All,
    /// Another seed may place more.
    Some,
}

impl fmt::Display for PlacesTaken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::All => "which are all taken then, with any seed",
            Self::Some => "taken in the random order of the seed: another seed may place more",
        })
    }
}

/// The error that ends a run.
#[derive(Debug, thiserror::Error)]
pub enum EngineError {
    /// The fleet's services can't be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// A frame, world, event or column can't be published.
    #[error(transparent)]
    Publish(#[from] PublishError),
    /// Commands or requests can't be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A plugin in lockstep didn't finish a tick.
    #[error(transparent)]
    Lockstep(#[from] LockstepError),
    /// The scenario or the options don't fit the machine or each other.
    #[error(transparent)]
    Fleet(#[from] FleetError),
    /// Readers in lockstep would lose events between two frames.
    #[error(
        "with a frame every {0} ticks, plugins in lockstep would lose events; publish one at least \
         every {most} ticks",
        most = services::EVENT_BUFFER
    )]
    TooFewFrames(u32),
    /// No place was found for all robots that stand. They are placed one after the other: the
    /// number that fits is a lower bound unless all places are taken.
    #[error(
        "{fit} of {wanted} robots fit where they wait for commands (nodes of the layout's main part \
         at which an edge ends, 0.1 m from each other, and no more in a zone than it holds), \
         {places}; use fewer, or a larger graph"
    )]
    NoRoom {
        /// The requested number of robots.
        wanted: u32,
        /// The number that was placed.
        fit: u32,
        /// Whether another seed may place more.
        places: PlacesTaken,
    },
    /// A robot would begin in the shaft of a lift whose cabin is elsewhere.
    #[error(
        "robot {robot} begins in a lift at a level where its cabin isn't: put it elsewhere, or all \
         robots in that lift at one level"
    )]
    NoCabin {
        /// The robot.
        robot: u32,
    },
    /// More robots than a fleet can hold.
    #[error("{0} robots are too many: a fleet holds at most {max}", max = MAX_ROBOTS)]
    TooManyRobots(u32),
}
