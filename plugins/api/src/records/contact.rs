//! Contacts: pairs of robots that touch or are about to. A collision checker publishes all current
//! pairs on `regatta/F/contacts`, and the changes of a tick on `regatta/F/contact_events`.

use bytemuck::{Pod, Zeroable};
#[cfg(feature = "shared-memory")]
use iceoryx2::prelude::ZeroCopySend;

use super::sequence::Sequenced;

/// The iceoryx2 user header of `regatta/F/contacts`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_ContactHeader"))]
pub struct ContactHeader {
    /// The run of the frame that was checked.
    pub run_id: u64,
    /// The tick of the frame that was checked.
    pub tick: u64,
    /// Its simulated time, in nanoseconds.
    pub sim_time_nanos: u64,
    /// The number of pairs that have begun to touch since the checker's first frame of the run.
    pub touching_ever: u64,
    /// The number of pairs that have become possible collisions since then.
    pub possible_ever: u64,
    /// The number of frames of the run that the checker lost because it was too slow.
    pub frames_skipped: u64,
    /// Counts the samples of the run, from 1. The publisher fills it in.
    pub sequence: u64,
    /// The number of pairs that touch now.
    pub touching: u32,
    /// The number of pairs that don't touch but may.
    pub possible: u32,
    /// 1 if there were more pairs than the checker examines: the list is incomplete then.
    pub capped: u32,
    /// Zero.
    pub reserved: u32,
}

/// A pair of robots that touch, or may.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_ContactRecord"))]
pub struct ContactRecord {
    /// The tick in which the pair reached this level.
    pub since_tick: u64,
    /// Its simulated time, in nanoseconds.
    pub since_nanos: u64,
    /// Ids, the lower one first.
    pub robots: [u32; 2],
    /// A [`ContactLevel`].
    pub level: u32,
    /// Index of the first robot's edge in the world, or [`NO_EDGE`](crate::frame::NO_EDGE).
    pub edge: u32,
    /// Metres east: the centre of the overlap, or about the point where they are nearest now.
    pub x: f32,
    /// Metres north.
    pub y: f32,
    /// The relative speed of the two, in metres per second.
    pub relative_speed: f32,
    /// Zero.
    pub reserved: u32,
}

/// A pair that reached a level, or left it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_ContactEvent"))]
pub struct ContactEvent {
    /// The tick of the change.
    pub tick: u64,
    /// Its simulated time, in nanoseconds.
    pub sim_time_nanos: u64,
    /// Ids, the lower one first.
    pub robots: [u32; 2],
    /// A [`ContactLevel`].
    pub level: u32,
    /// A [`ContactChange`].
    pub change: u32,
    /// Index of the first robot's edge in the world, or [`NO_EDGE`](crate::frame::NO_EDGE).
    pub edge: u32,
    /// Metres east.
    pub x: f32,
    /// Metres north.
    pub y: f32,
    /// The relative speed of the two, in metres per second.
    pub relative_speed: f32,
}

/// The iceoryx2 user header of `regatta/F/contact_events`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_ContactEventHeader"))]
pub struct ContactEventHeader {
    /// The run that the tick belongs to.
    pub run_id: u64,
    /// The tick of the changes.
    pub tick: u64,
    /// Counts the samples of the run, from 1. The publisher fills it in.
    pub sequence: u64,
}

numbered! {
    /// The distance of two robots from a collision: the values of the column
    /// [`COLLISION`](super::column::COLLISION), where 0 is
    /// clear.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
    pub enum ContactLevel: u32 {
        /// They are within the safety margin, or will touch within the horizon if both continue as
        /// they do.
        Possible = 1,
        /// Their footprints overlap.
        Touching = 2,
    }
}

numbered! {
    /// The change that a [`ContactEvent`] reports.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
    pub enum ContactChange: u32 {
        /// The pair reached the level.
        Began = 1,
        /// The pair left the level.
        Ended = 2,
    }
}

super::sequence::sequenced!(ContactHeader: sequence);
super::sequence::sequenced!(ContactEventHeader: sequence);

/// All pairs of one frame, borrowed from shared memory.
#[derive(Clone, Copy, Debug)]
pub struct Contacts<'sample> {
    /// The frame, and totals.
    pub header: &'sample ContactHeader,
    /// The pairs: those that touch first, then the others, each sorted by the robots' ids.
    pub pairs: &'sample [ContactRecord],
    /// The number of samples that were published between the one that this reader returned before
    /// and this one.
    pub missed: u64,
}
