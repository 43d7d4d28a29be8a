//! Events: what happened to robots. One sample of `regatta/F/events` holds all events of one tick.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

/// The iceoryx2 user header of `regatta/F/events`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("regatta_EventHeader")]
pub struct EventHeader {
    /// The run that the tick belongs to.
    pub run_id: u64,
    /// The tick at which these happened.
    pub tick: u64,
    /// Events of this tick that were left out because there were too many.
    pub dropped: u64,
    /// Counts the samples of the run, from 1: a reader that finds a gap was too slow for the ones between.
    /// The publisher fills it in.
    pub sequence: u64,
}

/// One event.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("regatta_EventRecord")]
pub struct EventRecord {
    /// Token of the order that this answers, else zero.
    pub token: u64,
    /// An [`EventKind`].
    pub kind: u32,
    /// The robot, by id.
    pub robot: u32,
    /// `ReachedNode`: the node's id. `Refused`: the id that the order named.
    pub id: u32,
    /// `Refused`: a [`Refusal`].
    pub detail: u32,
}

/// Kinds of [`EventRecord`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum EventKind {
    /// A robot came to a node of its route.
    ReachedNode = 1,
    /// A robot came to the end of its route.
    RouteDone = 2,
    /// A robot came to the end of its released base and waits for more.
    WaitingForRelease = 3,
    /// A held robot has come to a stand.
    Held = 4,
    /// A held robot goes on.
    Resumed = 5,
    /// An order was carried out.
    Accepted = 6,
    /// An order was refused and changed nothing; `detail` says why.
    Refused = 7,
    /// A robot joined the fleet.
    Spawned = 8,
    /// A robot left the fleet.
    Removed = 9,
    /// A robot can't go on (a random walk at a dead end, say).
    Faulted = 10,
}

/// Why an order was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum Refusal {
    /// No robot has that id.
    UnknownRobot = 1,
    /// No edge has that id.
    UnknownEdge = 2,
    /// No node has that id.
    UnknownNode = 3,
    /// The world has no such robot type.
    UnknownRobotType = 4,
    /// A leg doesn't start where the one before it, the base, or the robot ends.
    NotConnected = 5,
    /// The edge can't be driven in reverse gear.
    NoReverse = 6,
    /// The route has no legs, or a released leg follows one that is not.
    MalformedRoute = 7,
    /// The distance is not on the edge.
    DistanceOutOfRange = 8,
    /// The fleet is as large as it may get.
    FleetFull = 9,
    /// The record's kind is unknown, or legs are missing.
    MalformedOrder = 10,
}
