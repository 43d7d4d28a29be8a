//! The doors of a building, and the times of doors and cabins.

use std::collections::BTreeMap;

use glam::DVec2;

use crate::model::raw::RawDoorTimes;
use crate::read::layout::{Layout, LayoutDoor};

/// A door as the file describes it.
#[derive(Debug)]
pub(super) struct DoorPlan {
    pub at: u32,
    pub line: [DVec2; 2],
    pub times: RawDoorTimes,
}

/// Adds the doors that edges lead through. Other doors are drawn only.
pub(super) fn add(plans: &BTreeMap<String, DoorPlan>, layout: &mut Layout) {
    let mut doors: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (index, edge) in layout.edges.iter().enumerate() {
        if let Some(name) = edge.tags.properties.get("door_name").filter(|name| !name.is_empty()) {
            doors.entry(name).or_default().push(index);
        }
    }
    let doors = doors.into_iter().map(|(name, edges)| {
        let plan = plans.get(name);
        LayoutDoor {
            at: plan.map_or(layout.edges[edges[0]].at, |plan| plan.at),
            name: name.to_owned(),
            line: plan.map(|plan| plan.line),
            times: plan.map(|plan| plan.times).unwrap_or_default(),
            edges,
        }
    });
    layout.doors = doors.collect();
}

/// The motion of a part in Open-RMF's simulation: it accelerates and brakes evenly.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drive {
    /// Metres or radians per second.
    pub max_speed: f64,
    /// Metres or radians per second squared.
    pub acceleration: f64,
}

/// The parameters with which Open-RMF's map tools generate their plugins.
pub(super) const SLIDING_DOOR: Drive = Drive { max_speed: 0.2, acceleration: 0.08 };
pub(super) const HINGED_DOOR: Drive = Drive { max_speed: 0.5, acceleration: 0.15 };
pub(super) const CABIN: Drive = Drive { max_speed: 2.0, acceleration: 1.0 };

impl Drive {
    /// Returns the seconds for a distance in metres or radians.
    pub fn secs(self, distance: f64) -> f64 {
        let Self { max_speed, acceleration } = self;
        if distance * acceleration < max_speed * max_speed {
            2.0 * (distance / acceleration).sqrt()
        } else {
            distance / max_speed + max_speed / acceleration
        }
    }
}

/// Returns the times of a door that takes as long to open as to close.
pub(super) fn times(drive: Drive, distance: f64) -> RawDoorTimes {
    let secs = Some(drive.secs(distance)).filter(|secs| secs.is_finite());
    RawDoorTimes { opening: secs, closing: secs }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drive_speeds_up_and_brakes() {
        assert!((CABIN.secs(8.0) - 6.0).abs() < 1e-9, "two seconds more than at full speed");
        assert!((CABIN.secs(1.0) - 2.0).abs() < 1e-9, "it never reaches its full speed");
        assert_eq!(CABIN.secs(0.0), 0.0);
    }
}
