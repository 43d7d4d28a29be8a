//! Events of robots. One sample of `regatta/F/events` holds all events of one tick.

use bytemuck::{Pod, Zeroable};
#[cfg(feature = "shared-memory")]
use iceoryx2::prelude::ZeroCopySend;

use super::sequence::Sequenced;

/// The iceoryx2 user header of `regatta/F/events`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_EventHeader"))]
pub struct EventHeader {
    /// The run that the tick belongs to.
    pub run_id: u64,
    /// The tick in which the events happened.
    pub tick: u64,
    /// Events of this tick that were left out because there were too many.
    pub dropped: u64,
    /// Counts the samples of the run, from 1. The publisher fills it in.
    pub sequence: u64,
}

/// One event.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_EventRecord"))]
pub struct EventRecord {
    /// The token of the command that this event answers, or zero.
    pub token: u64,
    /// An [`EventKind`].
    pub kind: u32,
    /// The robot, by id; [`NO_ROBOT`](super::order::NO_ROBOT) for events of edges, doors and lifts,
    /// and the answers to their commands.
    pub robot: u32,
    /// `ReachedNode`: the node's id. `EdgeClosed`, `EdgeOpened`: the edge's. `DoorOpened`,
    /// `DoorClosed`: that of the door's first edge. `LiftArrived`: that of a node in its cabin.
    /// `ActionFailed`: that of the node where the robot stands.
    /// `Refused`: the id that the command named.
    pub id: u32,
    /// `Refused`: a [`Refusal`]. `BrokenDown`: a [`BreakdownCause`]. `WaitingForRelease`:
    /// [`BASE_WANTED`] if the robot doesn't wait yet.
    pub detail: u32,
}

/// The detail of a robot that asks for a longer base before it comes to the end of the one that it
/// has.
pub const BASE_WANTED: u32 = 1;

numbered! {
    /// Kinds of [`EventRecord`].
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum EventKind: u32 {
        /// A robot reached a node of its route.
        ReachedNode = 1,
        /// A robot reached the end of its route.
        RouteDone = 2,
        /// A robot reached the end of its released base and waits for a release, or comes to a
        /// closed edge, a closed door or a lift and waits for it. Or it drives, and asks for a
        /// longer base so that it needn't brake.
        WaitingForRelease = 3,
        /// A held robot has come to a stop.
        Held = 4,
        /// A held robot continues.
        Resumed = 5,
        /// A command was carried out.
        Accepted = 6,
        /// A command was refused and changed nothing; `detail` is the reason.
        Refused = 7,
        /// A robot joined the fleet after the first frame.
        Spawned = 8,
        /// A robot left the fleet.
        Removed = 9,
        /// A robot can't continue (a random walk at a node without a way out, for example).
        Faulted = 10,
        /// A robot stalls: it stops for a while.
        Stalled = 11,
        /// A robot no longer stalls.
        Recovered = 12,
        /// A robot is broken; `detail` is the cause.
        BrokenDown = 13,
        /// A robot is no longer broken.
        Repaired = 14,
        /// An edge is closed: no robot enters it.
        EdgeClosed = 15,
        /// An edge is open again.
        EdgeOpened = 16,
        /// A door is open.
        DoorOpened = 17,
        /// A door is closed.
        DoorClosed = 18,
        /// A cabin has come to a level, and its doors are open.
        LiftArrived = 19,
        /// A robot's action at a stop (to pick, to drop, to charge) has failed.
        ActionFailed = 20,
    }
}

numbered! {
    /// The cause of a breakdown.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
    pub enum BreakdownCause: u32 {
        /// Not known.
        #[default]
        Unknown = 0,
        /// Its battery is flat. It stays broken until it is repaired, which brings a full battery,
        /// or until it has been charged.
        FlatBattery = 1,
    }
}

numbered! {
    /// The reason why a command was refused.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
    pub enum Refusal: u32 {
        /// No robot has that id.
        UnknownRobot = 1,
        /// No edge has that id.
        UnknownEdge = 2,
        /// No node has that id.
        UnknownNode = 3,
        /// The world has no such robot type.
        UnknownRobotType = 4,
        /// A leg doesn't start where the leg before it or the base ends, or where the robot is.
        NotConnected = 5,
        /// The edge can't be driven in reverse gear.
        NoReverse = 6,
        /// The route has no legs, or a released leg follows one that is not.
        MalformedRoute = 7,
        /// The distance is not on the edge, or not a number.
        DistanceOutOfRange = 8,
        /// The fleet has reached its maximum size.
        FleetFull = 9,
        /// The record's kind is unknown, or legs are missing.
        MalformedCommand = 10,
        /// The producer takes no commands: a replay, a UDP source.
        NotSteerable = 11,
        /// The leg to release is not at or after the end of the robot's base.
        NotAhead = 12,
        /// A leg of the route is along a closed edge.
        EdgeClosed = 13,
        /// Another process owns the movement of the fleet.
        NotOwner = 14,
        /// No door is across that edge.
        NoDoor = 15,
        /// That node is in no cabin.
        NoLift = 16,
        /// The lift is requested for another robot.
        LiftInUse = 17,
        /// The cabin isn't at that node.
        NoCabin = 18,
    }
}

super::sequence::sequenced!(EventHeader: sequence);

impl EventRecord {
    /// The kind of the event; `None` if this contract doesn't know it.
    pub fn kind(&self) -> Option<EventKind> {
        EventKind::from_number(self.kind)
    }
}
