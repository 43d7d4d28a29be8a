//! The world, as the checks need it.

use regatta_plugin::world::{EdgeRecord, RobotTypeRecord};

use crate::footprint::Footprint;
use crate::path::{Chord, Paths};

/// What robots are and where they drive.
#[derive(Debug)]
pub(crate) struct Roads {
    paths: Paths,
    /// By type; at least one.
    footprints: Vec<Footprint>,
}

impl Roads {
    pub(crate) fn new(edges: &[EdgeRecord], types: &[RobotTypeRecord]) -> Self {
        let mut footprints: Vec<_> = types.iter().map(Footprint::of).collect();
        if footprints.is_empty() {
            footprints.push(Footprint::UNKNOWN);
        }
        Self { paths: Paths::new(edges), footprints }
    }

    /// Of an edge, by its index; none if there is no such edge, or it is no curve.
    pub(crate) fn chords(&self, edge: u32) -> &[Chord] {
        self.paths.of(edge)
    }

    /// By type, at least one.
    pub(crate) fn footprints(&self) -> &[Footprint] {
        &self.footprints
    }

    /// The type by a value of the column `type`. What is no type there counts as the first.
    pub(crate) fn kind(&self, value: f32) -> u32 {
        // The conversion takes NaN and what is negative for 0.
        let kind = value as u32;
        if (kind as usize) < self.footprints.len() { kind } else { 0 }
    }
}
