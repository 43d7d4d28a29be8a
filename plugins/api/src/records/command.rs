//! Commands of a fleet manager to robots. One sample of `regatta/F/commands` is a slice of
//! [`CommandRecord`]s, applied in order at the start of the next tick.

use bytemuck::{Pod, Zeroable};
#[cfg(feature = "shared-memory")]
use iceoryx2::prelude::ZeroCopySend;

/// The iceoryx2 user header of `regatta/F/commands`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_CommandHeader"))]
pub struct CommandHeader {
    /// The hash of the sender's name. In lockstep, the samples of a tick are applied in the order
    /// of this value.
    pub sender: u64,
}

/// One command, or one leg of the route of the command before it. `kind` decides which fields have
/// a meaning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_CommandRecord"))]
pub struct CommandRecord {
    /// A number chosen by the sender; the events that answer this command carry it. Zero means
    /// none.
    pub token: u64,
    /// A [`CommandKind`].
    pub kind: u32,
    /// The robot, by id; [`NO_ROBOT`](super::order::NO_ROBOT) for `CloseEdge` and `OpenEdge`, no
    /// meaning for spawns and `Leg`. Requests of doors and lifts: the robot for which they are
    /// made; `NO_ROBOT` for those of an operator.
    pub robot: u32,
    /// `Assign`, `Extend`: the number of `Leg` records that follow this one.
    pub legs: u32,
    /// `Leg`, `Release`, `SpawnOnEdge`, `CloseEdge`, `OpenEdge`, `RequestDoor`, `ReleaseDoor`: id
    /// of the edge in the route graph. `SpawnAtNode`, `CallLift`, `ReleaseLift`: id of the node.
    pub id: u32,
    /// `Leg`, `Release`: 1 to drive the edge from destination to origin in reverse gear, else 0.
    pub reverse: u32,
    /// `Leg`: 1 if the robot may drive this edge now, 0 if it is horizon. Once 0, all later legs
    /// are.
    pub released: u32,
    /// Spawns: index of the robot type in the world.
    pub robot_type: u32,
    /// `SpawnOnEdge`: metres from the edge's origin node. `Release`: metres from the node at which
    /// the leg is entered.
    pub s: f32,
}

numbered! {
    /// Kinds of [`CommandRecord`].
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum CommandKind: u32 {
        /// Part of the route of the `Assign` or `Extend` before it.
        Leg = 0,
        /// Give a robot a new route. The route starts where the robot is: at the end of its current
        /// edge, which it finishes first, or at its node. If no leg is released, a base that ends
        /// within the current edge still ends there; that of a robot that stands within an edge
        /// without a route ends where it stands.
        Assign = 1,
        /// Drop the horizon and append legs at the end of the released base. If it ends within a
        /// leg and an appended leg is released, the rest of that leg is, too.
        Extend = 2,
        /// Drop the whole route beyond the end of the robot's current edge, or of its base if that
        /// is on the edge.
        Cancel = 3,
        /// Brake, stop and keep the route.
        Hold = 4,
        /// End a hold.
        Resume = 5,
        /// Add a robot on a node, in the node's pose.
        SpawnAtNode = 6,
        /// Add a robot on an edge at distance `s`.
        SpawnOnEdge = 7,
        /// Remove a robot from the fleet. A later spawn may reuse its id.
        Remove = 8,
        /// Release the horizon up to `s` metres along a leg: the first leg with this edge and gear
        /// at or after the end of the base. All legs before it become wholly released. `s` at or
        /// beyond the leg's length, or infinity, releases all of it; the end of the base may be
        /// within the leg that the robot is on.
        ///
        /// Nothing is ever taken back: less than is released already changes nothing. So the
        /// command may be sent again. It takes one record; the legs aren't sent again.
        Release = 9,
        /// Make a robot break down: it brakes, stops and keeps its route until it is repaired.
        /// Commands for its route are accepted, and take effect afterwards.
        Break = 10,
        /// Repair a robot that is broken. It goes on with its route, unless it is held.
        Repair = 11,
        /// Close an edge in both gears: from now on no robot enters it, also along a route that it
        /// has, and no new route may lead along it. A robot on the edge leaves it. A robot that
        /// comes to it waits at the node before it, and brakes harder than usual if need be.
        CloseEdge = 12,
        /// Open a closed edge again. Robots that wait before it drive on.
        OpenEdge = 13,
        /// Open the doors across an edge for a robot, and keep them open for
        /// [`REQUEST_SECS`]. Who needs them for longer sends the command again.
        RequestDoor = 14,
        /// End a robot's request of the doors across an edge: they close when no other request
        /// keeps them open and no robot is in them.
        ReleaseDoor = 15,
        /// Call a lift, for a robot, to the level of a node in its cabin. The cabin comes, opens
        /// its doors and stays for [`REQUEST_SECS`] at least. It leaves a level only when each
        /// robot in it rides along. Who needs it for longer sends the command again. While it is
        /// requested for one robot, calls for others are refused.
        CallLift = 16,
        /// End a robot's call of the lift with that node.
        ReleaseLift = 17,
    }
}

/// The simulated time, in seconds, for which a request of a door or a lift holds.
pub const REQUEST_SECS: f64 = 10.0;

impl CommandKind {
    /// Whether commands of this kind move a robot along a route, as only the owner of a fleet's
    /// movement may.
    pub const fn moves(self) -> bool {
        matches!(self, Self::Assign | Self::Extend | Self::Release | Self::Cancel)
    }
}

/// The commands that their sender may give.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Authority {
    /// All commands: the sender owns the movement of the fleet, or nobody does.
    Full,
    /// All but those that [move](CommandKind::moves) robots: another process owns their movement.
    WithoutMovement,
}

/// One edge of a route in a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RouteLeg {
    /// Id of the edge in the route graph.
    pub edge: u32,
    /// Whether to drive it from destination to origin, in reverse gear.
    pub reverse: bool,
    /// Whether the robot may drive it now; if not, it is horizon, and so are all legs after it.
    pub released: bool,
}

impl RouteLeg {
    /// A released leg that is driven forward.
    pub const fn forward(edge: u32) -> Self {
        Self { edge, reverse: false, released: true }
    }

    /// A released leg that is driven in reverse gear.
    pub const fn reverse(edge: u32) -> Self {
        Self { edge, reverse: true, released: true }
    }

    /// The same leg as horizon: planned, not released.
    pub const fn horizon(self) -> Self {
        Self { released: false, ..self }
    }
}
