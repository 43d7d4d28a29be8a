//! The world model of the checks: edges and footprints.

use regatta_plugin::world::{EdgeRecord, RobotTypeRecord};

use crate::edge_table::{Chord, EdgeTable};
use crate::footprint::Footprint;

/// The edges that robots drive on, and the footprints of their types.
#[derive(Debug)]
pub(crate) struct WorldModel {
    edge_table: EdgeTable,
    /// Footprints by robot type; at least one.
    footprints: Vec<Footprint>,
}

impl WorldModel {
    pub(crate) fn new(edges: &[EdgeRecord], robot_types: &[RobotTypeRecord]) -> Self {
        let mut footprints: Vec<_> = robot_types.iter().map(Footprint::of).collect();
        if footprints.is_empty() {
            footprints.push(Footprint::UNKNOWN);
        }
        Self { edge_table: EdgeTable::new(edges), footprints }
    }

    /// Returns the chords of an edge by its index; empty if there is no such edge, or it isn't a curve.
    pub(crate) fn chords(&self, edge: u32) -> &[Chord] {
        self.edge_table.chords(edge)
    }

    /// Returns the footprints by robot type; at least one.
    pub(crate) fn footprints(&self) -> &[Footprint] {
        &self.footprints
    }

    /// Returns the robot type that a value of the column `type` stands for: the first one if the value is no valid
    /// index.
    pub(crate) fn robot_type(&self, value: f32) -> u32 {
        // The conversion maps NaN and negative values to 0.
        let robot_type = value as u32;
        if (robot_type as usize) < self.footprints.len() { robot_type } else { 0 }
    }
}
