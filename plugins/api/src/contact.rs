//! Contacts: which robots touch or are about to. A collision checker publishes all current pairs on
//! `regatta/F/contacts`, and what changed in a tick on `regatta/F/contact_events`.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

pub use crate::contact_ports::{ContactEventReader, ContactEvents, ContactPublisher, ContactReader, Contacts};

/// The iceoryx2 user header of `regatta/F/contacts`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("regatta_ContactHeader")]
pub struct ContactHeader {
    /// The run of the frame that was checked.
    pub run_id: u64,
    /// The tick of the frame that was checked.
    pub tick: u64,
    /// Its simulated time, in nanoseconds.
    pub sim_time_nanos: u64,
    /// Pairs that have begun to touch since the checker saw the run's first frame.
    pub touching_ever: u64,
    /// Pairs that have come to be possible collisions since then.
    pub possible_ever: u64,
    /// Frames of the run that the checker was too slow for.
    pub frames_skipped: u64,
    /// Pairs that touch now.
    pub touching: u32,
    /// Pairs that don't touch but may.
    pub possible: u32,
    /// 1 if there were more pairs than the checker looks at: then these are not all.
    pub capped: u32,
    /// Counts the samples of the publisher, from 1, round and round.
    pub sequence: u32,
}

/// Two robots that touch, or may.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("regatta_ContactRecord")]
pub struct ContactRecord {
    /// The tick at which the pair came to this level.
    pub since_tick: u64,
    /// Its simulated time, in nanoseconds.
    pub since_nanos: u64,
    /// Ids, the lower one first.
    pub robots: [u32; 2],
    /// A [`ContactLevel`].
    pub level: u32,
    /// Index of the first robot's edge in the world, or [`NO_EDGE`](crate::frame::NO_EDGE).
    pub edge: u32,
    /// Metres east: where they touch or come nearest.
    pub x: f32,
    /// Metres north.
    pub y: f32,
    /// Metres per second between the two.
    pub relative_speed: f32,
    /// Zero.
    pub reserved: u32,
}

/// A pair that came to a level, or left it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("regatta_ContactEvent")]
pub struct ContactEvent {
    /// The tick at which it did.
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
    /// Metres per second between the two.
    pub relative_speed: f32,
}

/// The iceoryx2 user header of `regatta/F/contact_events`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("regatta_ContactEventHeader")]
pub struct ContactEventHeader {
    /// The run that the tick belongs to.
    pub run_id: u64,
    /// The tick at which these happened.
    pub tick: u64,
    /// Counts the samples of the publisher, from 1. The publisher fills it in.
    pub sequence: u64,
}

/// How near two robots are to a collision: the values of the column `collision`, where 0 is clear.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u32)]
pub enum ContactLevel {
    /// Within the safety margin, or they will touch within the horizon if both go on as they do.
    Possible = 1,
    /// Their footprints overlap.
    Touching = 2,
}

/// What a [`ContactEvent`] tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum ContactChange {
    /// The pair came to the level.
    Began = 1,
    /// The pair left the level.
    Ended = 2,
}

impl ContactLevel {
    /// The level of that number, if there is one.
    pub fn from_number(number: u32) -> Option<Self> {
        [Self::Possible, Self::Touching].into_iter().find(|level| *level as u32 == number)
    }
}

impl ContactChange {
    /// The change of that number, if there is one.
    pub fn from_number(number: u32) -> Option<Self> {
        [Self::Began, Self::Ended].into_iter().find(|change| *change as u32 == number)
    }
}
