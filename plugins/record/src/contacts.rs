//! Lists of contacts, recorded as changes from list to list.
//!
//! With many robots most pairs stay in the list for many ticks, and their positions and speeds
//! change evenly. An update therefore has the difference from an even change only: mostly one byte
//! per number. A whole list now and then lets readers start in the middle, and limits what damage
//! costs.

mod decoder;
mod encoder;

use regatta_plugin::contact::{ContactHeader, ContactRecord};

pub(crate) use decoder::ContactDecoder;
pub(crate) use encoder::ContactEncoder;

/// A list of contacts as it was published.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ContactList {
    pub header: ContactHeader,
    pub pairs: Vec<ContactRecord>,
}

/// The latest changes of the bits of a pair's `x`, `y` and `relative_speed`.
type Trend = [i32; 3];

/// The bits of a pair's numbers that change evenly, as integers.
fn motion(pair: &ContactRecord) -> [i32; 3] {
    [pair.x, pair.y, pair.relative_speed].map(|value| value.to_bits().cast_signed())
}

/// The order of lists: by level, touching pairs first, then by robots.
fn key(pair: &ContactRecord) -> (u32, [u32; 2]) {
    (u32::MAX - pair.level, pair.robots)
}

#[cfg(test)]
mod tests;
