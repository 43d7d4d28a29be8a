//! The figures of a meter.

use std::collections::BTreeMap;

/// The figures of a master. Times are in seconds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figures {
    /// The vehicles that were seen.
    pub vehicles: usize,
    /// Those of them that never got an order.
    pub never_ordered: u64,
    /// The messages with orders and updates.
    pub orders: u64,
    /// The time of the first of them.
    pub first_order: Option<f64>,
    /// The time of the last of them.
    pub last_order: Option<f64>,
    /// The bases that vehicles asked for.
    pub bases: Vec<BaseWait>,
    /// The transports from a pick to a drop, in the order of their ends.
    pub finished: Vec<Finished>,
    /// The transport orders that were handed over, and not finished.
    pub open_orders: u64,
    /// From the end of a vehicle's order to its next one.
    pub idle_secs: Vec<f64>,
    /// From the timestamps of states to their arrival.
    pub delay_secs: Vec<f32>,
    /// The errors that vehicles told, by type.
    pub errors: BTreeMap<String, u64>,
}

/// A base that a vehicle asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct BaseWait {
    /// The first levels of the topics of the vehicle.
    pub vehicle: String,
    /// The last node of its base.
    pub node: String,
    /// The node that it wanted to drive to; `None` if the order didn't tell.
    pub next_node: Option<String>,
    /// The edge by which it came, and the one that it wanted to drive.
    pub edges: [Option<String>; 2],
    /// Seconds from the state that asked to the base.
    pub secs: f64,
    /// Seconds of them in which the vehicle stood at the end of its base.
    pub standing_secs: f64,
    /// The answer of the master.
    pub answer: Answer,
}

/// The answer of a master to a vehicle that asked for a base.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// It came, and all of its nodes were free since the vehicle had asked: the time is the
    /// master's own.
    Free,
    /// It came, and others had one of its nodes meanwhile: the time is one of traffic, too.
    Held,
    /// It hasn't come, though the nodes ahead are free.
    MissingFree,
    /// It hasn't come, and others have one of the nodes ahead.
    MissingHeld,
}

impl Answer {
    /// Whether nothing but the master took the time.
    pub const fn is_of_master(self) -> bool {
        matches!(self, Self::Free | Self::MissingFree)
    }

    /// Whether it hasn't come.
    pub const fn is_missing(self) -> bool {
        matches!(self, Self::MissingFree | Self::MissingHeld)
    }
}

/// A transport that was carried out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finished {
    /// The time of the drop.
    pub time: f64,
    /// The number of the transport order that was handed over; `None` if none fits.
    pub number: Option<u64>,
    /// Seconds from its hand-over to its end.
    pub service_secs: Option<f64>,
}
