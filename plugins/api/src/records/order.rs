//! The order log: the progress of each transport order, on `regatta/F/orders`. One sample holds all
//! records of one tick of the fleet manager that writes it.

use bytemuck::{Pod, Zeroable};
#[cfg(feature = "shared-memory")]
use iceoryx2::prelude::ZeroCopySend;

use super::sequence::Sequenced;

/// The value of [`OrderRecord::robot`] for a record of no robot.
pub const NO_ROBOT: u32 = u32::MAX;

/// The iceoryx2 user header of `regatta/F/orders`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_OrderHeader"))]
pub struct OrderHeader {
    /// The run that the tick belongs to.
    pub run_id: u64,
    /// The tick of the frame that the fleet manager had when it wrote the records.
    pub tick: u64,
    /// Records of this tick that were left out because there were too many.
    pub dropped: u64,
    /// Counts the samples of the run, from 1. The publisher fills it in.
    pub sequence: u64,
}

/// Something that happened to an order. `kind` decides which fields have a meaning; the others are
/// zero, and `robot` is [`NO_ROBOT`].
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_OrderRecord"))]
pub struct OrderRecord {
    /// The number of the order, which no other order of the fleet manager's store has.
    pub order: u64,
    /// An [`OrderKind`].
    pub kind: u32,
    /// The robot, by id, or [`NO_ROBOT`].
    pub robot: u32,
    /// `Stop`, `Queued`, `Arrived`, `Handled`: the index of the stop among those of the order.
    pub stop: u32,
    /// `Stop`, `Queued`, `Arrived`, `Handled`: id of the stop's node in the route graph.
    /// `Unroutable` for want of a place: id of the first place of the storage.
    pub node: u32,
    /// `Stop`, `Queued`, `Arrived`, `Handled`: a [`StopAction`]. `Unroutable` for want of a place:
    /// `Drop` if the storage is full, `Pick` if it is empty.
    pub action: u32,
    /// `Stop`: the shortest time that a robot stands at the stop, in seconds. `Arrived`: the time
    /// for which it waits there until its dwell begins, in seconds.
    pub dwell_secs: f32,
    /// `Created`: the number of stops. `Withdrawn`, `Failed`, `Cancelled`: the fleet manager's
    /// number of the reason. `Unroutable`: an [`Obstacle`].
    pub detail: u32,
    /// `Created`: the seconds from now to the order's deadline, or 0 if it has none.
    pub due_secs: f32,
}

numbered! {
    /// Kinds of [`OrderRecord`].
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
    pub enum OrderKind: u32 {
        /// The order exists. One `Stop` for each of its stops follows in the same sample, or if it
        /// has to wait for a place of a storage, as soon as it has one.
        Created = 1,
        /// A stop of the order: its node, action and dwell.
        Stop = 2,
        /// The order was given to a robot.
        Assigned = 3,
        /// The manager withdrew the order from its robot before the first pick.
        Withdrawn = 4,
        /// The robot stands at a stop. Its dwell begins, unless it waits there for an operator, for
        /// a place for its load, or until the station opens.
        Arrived = 5,
        /// The dwell is over: the load is picked or dropped, for example.
        Handled = 6,
        /// All stops were handled.
        Finished = 7,
        /// The fleet manager has given the order up.
        Failed = 8,
        /// The order was cancelled on request.
        Cancelled = 9,
        /// No robot can reach its stops, or a storage has no place for it: it waits until it is
        /// `Reopened`.
        Unroutable = 10,
        /// Its stops can be reached again, or it has got its places.
        Reopened = 11,
        /// The robot waits in the queue before a stop: at a place of it, or elsewhere until one is
        /// free.
        Queued = 12,
    }
}

numbered! {
    /// The reason for which no robot can carry an order out.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
    pub enum Obstacle: u32 {
        /// The layout has no way there, or none from there to the next stop.
        #[default]
        NoWay = 0,
        /// Edges that are closed.
        ClosedEdges = 1,
        /// The fleet doesn't have the only robot that may get it.
        NoRobot = 2,
        /// No robot's full battery lasts for it, as the manager plans: with time for traffic and a
        /// reserve.
        Battery = 3,
        /// Its storage has no place for it.
        NoPlace = 4,
    }
}

impl Obstacle {
    /// The obstacle in words, such as `no way leads to its stops`.
    pub const fn text(self) -> &'static str {
        match self {
            Self::NoWay => "no robot has a way to its stops",
            Self::ClosedEdges => "closed edges lead to its stops",
            Self::NoRobot => "its robot isn't in the fleet",
            Self::Battery => {
                "no robot's full battery lasts for it, planned at twice the driving time"
            }
            Self::NoPlace => "its storage has no place for it",
        }
    }
}

numbered! {
    /// The action of a robot at a stop of an order.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
    pub enum StopAction: u32 {
        /// Nothing but to stand there.
        #[default]
        None = 0,
        /// Pick a load up.
        Pick = 1,
        /// Drop the load.
        Drop = 2,
        /// Charge.
        Charge = 3,
        /// Park.
        Park = 4,
    }
}

impl OrderRecord {
    /// Returns a record of an order without a robot, whose other fields are zero.
    pub const fn new(order: u64, kind: OrderKind) -> Self {
        let kind = kind as u32;
        Self {
            order,
            kind,
            robot: NO_ROBOT,
            stop: 0,
            node: 0,
            action: StopAction::None as u32,
            dwell_secs: 0.0,
            detail: 0,
            due_secs: 0.0,
        }
    }

    /// Returns the record with a robot, by id.
    #[must_use]
    pub const fn of_robot(self, robot: u32) -> Self {
        Self { robot, ..self }
    }

    /// Returns the record with a stop: its index among those of the order, the id of its node, and
    /// its action.
    #[must_use]
    pub const fn at_stop(self, stop: u32, node: u32, action: StopAction) -> Self {
        Self { stop, node, action: action as u32, ..self }
    }

    /// The kind; `None` if this contract doesn't know it.
    pub fn kind(&self) -> Option<OrderKind> {
        OrderKind::from_number(self.kind)
    }

    /// The obstacle of an `Unroutable` order. An unknown number counts as no way.
    pub fn obstacle(&self) -> Obstacle {
        Obstacle::from_number(self.detail).unwrap_or_default()
    }

    /// The action. An unknown number counts as nothing.
    pub fn action(&self) -> StopAction {
        StopAction::from_number(self.action).unwrap_or_default()
    }
}

impl Default for OrderRecord {
    /// Returns a record of no kind and no robot.
    fn default() -> Self {
        Self { kind: 0, ..Self::new(0, OrderKind::Created) }
    }
}

super::sequence::sequenced!(OrderHeader: sequence);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_are_read_as_they_were_written() {
        for kind in OrderKind::ALL {
            assert_eq!(OrderRecord::new(7, kind).kind(), Some(kind));
        }
        for action in StopAction::ALL {
            let record = OrderRecord::new(7, OrderKind::Arrived).of_robot(3).at_stop(1, 44, action);
            assert_eq!(
                (record.action(), record.robot, record.stop, record.node),
                (action, 3, 1, 44)
            );
        }
        assert_eq!((OrderRecord::default().kind(), OrderRecord::default().robot), (None, NO_ROBOT));
        assert_eq!(OrderRecord { action: 99, ..OrderRecord::default() }.action(), StopAction::None);
    }
}
