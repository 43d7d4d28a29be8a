//! The world model of the checks: edges and footprints.

use regatta_plugin::World;

use crate::body::Footprint;
use crate::leg_table::LegTable;
use crate::prediction::Limits;

/// The edges that robots drive on, and the footprints and limits of their types.
#[derive(Debug)]
pub(crate) struct WorldModel {
    legs: LegTable,
    /// Footprints by robot type; at least one.
    footprints: Vec<Footprint>,
    /// Limits by robot type.
    limits: Vec<Limits>,
}

impl WorldModel {
    pub(crate) fn new(world: &World<'_>) -> Self {
        let robot_types = world.robot_types();
        let mut footprints: Vec<_> = robot_types.iter().map(Footprint::of).collect();
        if footprints.is_empty() {
            footprints.push(Footprint::UNKNOWN);
        }
        let limits = robot_types
            .iter()
            .map(|robot_type| Limits::new(robot_type.max_speed, robot_type.max_acceleration))
            .collect();
        Self { legs: LegTable::new(world), footprints, limits }
    }

    pub(crate) fn legs(&self) -> &LegTable {
        &self.legs
    }

    /// Returns the limits of a robot type: none if there is no such type.
    pub(crate) fn limits(&self, robot_type: u32) -> Limits {
        self.limits.get(robot_type as usize).copied().unwrap_or(Limits::NONE)
    }

    /// Returns the footprints by robot type; at least one.
    pub(crate) fn footprints(&self) -> &[Footprint] {
        &self.footprints
    }

    /// Returns the robot type that a value of the column `type` stands for: the first one if the
    /// value is no valid index.
    pub(crate) fn robot_type(&self, value: f32) -> u32 {
        // The conversion maps NaN and negative values to 0.
        let robot_type = value as u32;
        if (robot_type as usize) < self.footprints.len() { robot_type } else { 0 }
    }
}
