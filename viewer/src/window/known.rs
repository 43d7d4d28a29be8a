//! What is known of a fleet beside what is drawn of it.

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use glam::Vec2;
use regatta_plugin::control::ControlResponse;
use regatta_plugin::{ColumnName, Frame};

use crate::interface::facts::Thing;
use crate::interface::labels::Labels;
use crate::interface::rig::Pose;
use crate::interface::rows::Rows;
use crate::link::Fact;

/// What was found out of the fleet, beside what the stage reads.
#[derive(Debug, Default)]
pub struct Known {
    pub status: Option<Box<ControlResponse>>,
    pub columns: Vec<ColumnName>,
    pub labels: Labels,
    pub values: Vec<(ColumnName, f32)>,
    pub rows: Option<Rows>,
    pub lag: Option<f64>,
    /// When the newest frame came.
    pub heard: Option<Instant>,
    /// The followed robot in the frame before and in the newest.
    pub followed: Option<(u32, [Pose; 2])>,
    /// Whose values are asked for.
    pub asked: Option<Thing>,
    /// Whose routes are asked for.
    pub routes_of: Vec<u32>,
}

impl Known {
    /// Takes what the link has found out; whether a person would see a difference.
    pub fn take(&mut self, fact: Fact) -> bool {
        match fact {
            Fact::Status(status) => {
                let differs = differ(self.status.as_deref(), status.as_deref());
                self.status = status;
                differs
            }
            Fact::Rows(rows) => self.rows.replace(rows) != self.rows,
            Fact::Columns(columns) => std::mem::replace(&mut self.columns, columns) != self.columns,
            Fact::Values(values) => std::mem::replace(&mut self.values, values) != self.values,
        }
    }

    /// Takes the frame that is shown: how old it was when it came, if it is new, and where the followed robot is.
    pub fn note(&mut self, frame: &Frame<'_>, is_new: bool, followed: Option<u32>, offset: Vec2, now: Instant) {
        if is_new {
            self.heard = Some(now);
            let sent = Duration::from_nanos(frame.header().wall_time_nanos);
            let age = SystemTime::now().duration_since(UNIX_EPOCH + sent);
            self.lag = age.ok().map(|age| age.as_secs_f64());
        }
        let pose = followed.and_then(|robot| {
            let row = robot as usize;
            let place = Vec2::new(*frame.x().get(row)?, *frame.y().get(row)?) + offset;
            Some((robot, Pose { place, theta: *frame.theta().get(row)? }))
        });
        self.followed = match (pose, self.followed) {
            (Some((robot, pose)), Some((before, [_, last]))) if robot == before && is_new => {
                Some((robot, [last, pose]))
            }
            (Some((robot, _)), Some(known)) if robot == known.0 => Some(known),
            (Some((robot, pose)), _) => Some((robot, [pose; 2])),
            (None, _) => None,
        };
    }
}

/// Whether a person would see a difference between what an engine said of itself.
fn differ(one: Option<&ControlResponse>, other: Option<&ControlResponse>) -> bool {
    let seen = |status: &ControlResponse| ControlResponse {
        wall_time_nanos: 0,
        tick_cost_p50_nanos: 0,
        tick_cost_p99_nanos: 0,
        resident_bytes: 0,
        real_time_factor: (status.real_time_factor * 100.0).round(),
        ..*status
    };
    one.map(seen) != other.map(seen)
}
