//! How to run a scenario, what a run comes to, and why it may end early.

use std::time::Duration;

use regatta_plugin::lockstep::LockstepError;
use regatta_plugin::{FleetName, OpenError, PublishError, ReadError};

use crate::clock::Speed;
use crate::fleet::FleetError;
use crate::motion::Isa;
use crate::scenario::MAX_ROBOTS;

/// How to run a scenario.
#[derive(Clone, Debug)]
pub struct Options {
    /// Name of the fleet: of its services in shared memory.
    pub fleet: FleetName,
    /// Number of robots, instead of the scenario's.
    pub robots: Option<u32>,
    /// Wanted simulated seconds per wall second.
    pub speed: Speed,
    /// Threads that move robots; at least one.
    pub threads: usize,
    /// Instruction set of the motion kernel; the best of this machine if `None`.
    pub isa: Option<Isa>,
    /// Stop after so many ticks.
    pub ticks: Option<u64>,
    /// Digest every frame.
    pub digest: bool,
    /// Plugins to wait for after each tick.
    pub lockstep: Vec<String>,
    /// How long to wait for them.
    pub lockstep_timeout: Duration,
}

/// What a run came to.
#[derive(Clone, Copy, Debug)]
pub struct Summary {
    /// Ticks since the start.
    pub ticks: u64,
    /// Simulated time.
    pub sim_time: Duration,
    /// Wall time.
    pub wall_time: Duration,
    /// Ticks that ended after their deadline.
    pub late_ticks: u64,
    /// Digest of every frame's columns, if it was asked for.
    pub digest: Option<u128>,
}

/// Why a run ended before its time.
#[derive(Debug, thiserror::Error)]
pub enum EngineError {
    /// The fleet's services can't be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// A frame, world, event or column can't be published.
    #[error(transparent)]
    Publish(#[from] PublishError),
    /// Orders or requests can't be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A plugin in lockstep didn't finish a tick.
    #[error(transparent)]
    Lockstep(#[from] LockstepError),
    /// The scenario or the options don't fit the machine or each other.
    #[error(transparent)]
    Fleet(#[from] FleetError),
    /// More robots than a fleet can hold.
    #[error("{0} robots are too many: a fleet holds at most {max}", max = MAX_ROBOTS)]
    TooManyRobots(u32),
}
