//! The contents of a plan, and the nodes, edges and robots of its level.

use glam::Vec2;
use regatta_interface::text::with_plural;
use regatta_plugin::World;
use regatta_plugin::facility::FacilityState;
use regatta_plugin::frame::{Frame, RobotState};
use regatta_plugin::world::{EdgeRecord, NodeRecord};
use regatta_scene::camera::Bounds;
use regatta_scene::palette::{Colouring, Legend, Theme};

/// The contents of a plan.
#[derive(Clone, Copy, Debug)]
pub struct Plan<'a> {
    /// The route graph and the robot types.
    pub world: World<'a>,
    /// The robots.
    pub frame: Option<Frame<'a>>,
    /// Each robot's index into the robot types.
    pub robot_type: Option<&'a [f32]>,
    /// Each robot's value, if they are coloured by a column or by speed.
    pub values: Option<&'a [f32]>,
    /// The data that robots are coloured by.
    pub colouring: &'a Colouring,
    /// The meaning of the colours, for the same theme.
    pub legend: &'a Legend,
    /// The colour theme.
    pub theme: Theme,
    /// The indices of closed edges, sorted.
    pub closed: &'a [u32],
    /// The states of doors and lifts.
    pub facilities: &'a [FacilityState],
    /// The level whose nodes, edges and robots are shown; `None` for all levels.
    pub level: Option<&'a str>,
    /// The visible part, in metres.
    pub bounds: Bounds,
    /// Metres added to all positions.
    pub offset: Vec2,
    /// The scale: 200 for 1:200; `None` for one at which the drawing fits on A3.
    pub scale: Option<f32>,
    /// The name of the fleet or the recording.
    pub name: &'a str,
    /// The time of the frame in seconds, on the clock that is shown.
    pub seconds: f64,
}

impl<'a> Plan<'a> {
    /// Whether something is shown whose level has this offset into the world's texts.
    fn shows(&self, level: u32) -> bool {
        self.level.is_none_or(|shown| self.world.text(level) == shown)
    }

    pub(super) fn edges(&self) -> impl Iterator<Item = &'a EdgeRecord> {
        self.world.edges().iter().filter(|edge| self.shows(edge.level))
    }

    pub(super) fn nodes(&self) -> impl Iterator<Item = &'a NodeRecord> {
        self.world.nodes().iter().filter(|node| self.shows(node.level))
    }

    /// The closed edges.
    pub(super) fn closed_edges(&self) -> impl Iterator<Item = &'a EdgeRecord> {
        let edges = self.closed.iter().filter_map(|index| self.world.edges().get(*index as usize));
        edges.filter(|edge| self.shows(edge.level))
    }

    /// The rows of the frame's robots. A robot is on the level of its edge. A robot without an edge
    /// has no level.
    pub(super) fn rows(&self, frame: Frame<'a>) -> impl Iterator<Item = usize> {
        let present =
            (0..frame.len()).filter(move |&row| frame.state_of(row) != RobotState::Absent);
        present.filter(move |&row| {
            let edge = self.world.edges().get(frame.edge()[row] as usize);
            self.level.is_none() || edge.is_some_and(|edge| self.shows(edge.level))
        })
    }

    /// The text below the drawing.
    pub(super) fn title(&self) -> String {
        let level = self.level.map(|level| format!(", {level}")).unwrap_or_default();
        let seconds = self.seconds;
        let robots = self.frame.map_or(0, |frame| self.rows(frame).count());
        format!("{}{level}, {seconds:.2} s, {}", self.name, with_plural(robots as u64, "robot"))
    }
}
