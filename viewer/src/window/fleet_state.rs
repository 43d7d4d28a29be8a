//! The state of a fleet for the interface, in addition to the data that the stage reads for
//! drawing.

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use glam::Vec2;
use regatta_interface::labels::Labels;
use regatta_interface::orders::{NamedOrder, RobotOrder};
use regatta_interface::pose::Pose;
use regatta_interface::robot_filter::{Filter, Matches, RobotSet};
use regatta_interface::rows::Rows;
use regatta_interface::view_model::Item;
use regatta_plugin::control::ControlResponse;
use regatta_plugin::work::WorkFigures;
use regatta_plugin::{ColumnName, Frame};

use crate::jams::JamQuery;
use crate::link::Fact;
use crate::plans::PlanQuery;

/// The state of a fleet as reported by the link, and values derived from its frames.
#[derive(Debug, Default)]
pub struct FleetState {
    pub status: Option<Box<ControlResponse>>,
    pub columns: Vec<ColumnName>,
    pub labels: Labels,
    pub values: Vec<(ColumnName, f32)>,
    pub order: Option<RobotOrder>,
    /// The order of the selected robot, as the fleet manager names it.
    pub named_order: Option<NamedOrder>,
    /// The figures of the fleet's work, with their run.
    pub work: Option<(u64, WorkFigures)>,
    /// The filter that was requested last.
    pub filter: Filter,
    /// The robots that match it, or as long as they are not known, the filter before.
    pub matches: Option<Matches>,
    pub rows: Option<Rows>,
    /// The age of the newest frame when it was read, in seconds.
    pub lag: Option<f64>,
    /// The time at which the newest frame was read.
    pub last_frame_at: Option<Instant>,
    /// The followed robot, and its poses in the frame before and in the newest frame.
    pub followed: Option<(u32, [Pose; 2])>,
    /// The item whose values were requested last.
    pub values_of: Option<Item>,
    /// The robots whose routes were requested last.
    pub routes_of: Vec<u32>,
    /// The query for plans that was sent last.
    pub plan_query: PlanQuery,
    /// The query for jams that was sent last.
    pub jam_query: JamQuery,
}

impl FleetState {
    /// The robots that match the filter, if it has conditions beside the level.
    pub fn matching(&self) -> Option<RobotSet> {
        let matches = self.matches.as_ref().filter(|_| self.filter.has_conditions())?;
        matches.matching.clone()
    }

    /// Applies a report of the link. Returns whether it makes a visible difference.
    pub fn apply(&mut self, fact: Fact) -> bool {
        match fact {
            Fact::Status(status) => {
                let differs = differ(self.status.as_deref(), status.as_deref());
                self.status = status;
                differs
            }
            Fact::Rows(rows) => self.rows.replace(rows) != self.rows,
            Fact::Columns(columns) => std::mem::replace(&mut self.columns, columns) != self.columns,
            Fact::Order(order) => {
                let is_another =
                    self.order.map(|order| order.number) != order.map(|order| order.number);
                if is_another && self.order.is_some() {
                    // The name is that of the order before.
                    self.named_order = None;
                }
                std::mem::replace(&mut self.order, order) != self.order
            }
            Fact::NamedOrder(order) => {
                let is_selected = order
                    .as_ref()
                    .is_none_or(|order| self.values_of == Some(Item::Robot(order.robot)));
                let order = order.filter(|_| is_selected);
                std::mem::replace(&mut self.named_order, order) != self.named_order
            }
            Fact::Work(work) => std::mem::replace(&mut self.work, work) != self.work,
            Fact::Values(values) => std::mem::replace(&mut self.values, values) != self.values,
        }
    }

    /// Records the shown frame: its age if it is new, and the pose of the followed robot.
    pub fn record_frame(
        &mut self,
        frame: &Frame<'_>,
        is_new: bool,
        followed: Option<u32>,
        offset: Vec2,
        now: Instant,
    ) {
        if is_new {
            self.last_frame_at = Some(now);
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
            (Some((robot, _)), Some(unchanged)) if robot == unchanged.0 => Some(unchanged),
            (Some((robot, pose)), _) => Some((robot, [pose; 2])),
            (None, _) => None,
        };
    }
}

/// Whether two statuses of an engine differ visibly.
fn differ(one: Option<&ControlResponse>, other: Option<&ControlResponse>) -> bool {
    one.map(visible) != other.map(visible)
}

/// Returns the parts of a status that are visible.
fn visible(status: &ControlResponse) -> ControlResponse {
    ControlResponse {
        wall_time_nanos: 0,
        tick_cost_p50_nanos: 0,
        tick_cost_p99_nanos: 0,
        resident_bytes: 0,
        real_time_factor: (status.real_time_factor * 100.0).round(),
        ..*status
    }
}
