//! Which robots match a filter: by state, type, task and zone. The others are dimmed in the picture. It is computed on another
//! thread than the one that draws.

use regatta_plugin::World;
use regatta_plugin::frame::{Frame, RobotState};

use crate::tasks::TaskBook;

/// Conditions that robots match; all of them must hold.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Filter {
    /// The state.
    pub state: Option<RobotState>,
    /// The type, by its index in the world.
    pub robot_type: Option<u32>,
    /// The task.
    pub task: TaskFilter,
    /// The zone of the edge that the robot is on.
    pub zone: Option<String>,
    /// The level of the edge that the robot is on.
    pub level: Option<String>,
}

/// A condition on a robot's task.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TaskFilter {
    /// Any task or none.
    #[default]
    Any,
    /// It has a task.
    Some,
    /// It has none.
    None,
    /// It has the task with this number.
    Number(u64),
}

/// The robots that match.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Matches {
    /// A bit per robot, 32 to a word, the lowest one first.
    pub bits: Vec<u32>,
    /// The number of robots that match, and of those in the fleet.
    pub counts: [u32; 2],
}

impl Filter {
    /// Whether all robots match.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Whether another filter differs in nothing but the level.
    pub fn is_like(&self, other: &Self) -> bool {
        Self { level: other.level.clone(), ..self.clone() } == *other
    }

    /// Computes which robots of a frame match. `types` holds each robot's index into the robot types; a robot without one has
    /// the first type.
    pub fn matches(&self, frame: &Frame<'_>, world: &World<'_>, types: Option<&[f32]>, tasks: &TaskBook) -> Matches {
        let in_zone: Option<Vec<bool>> =
            self.zone.as_ref().map(|zone| world.edges().iter().map(|edge| world.text(edge.zone) == zone).collect());
        let on_level: Option<Vec<bool>> =
            self.level.as_ref().map(|level| world.edges().iter().map(|edge| world.text(edge.level) == level).collect());
        // A robot on no edge is in no zone and on no level: no edge has its number.
        let is_in_place = |edge: u32| {
            let holds = |edges: &Option<Vec<bool>>| {
                edges.as_ref().is_none_or(|edges| edges.get(edge as usize).is_some_and(|holds| *holds))
            };
            holds(&in_zone) && holds(&on_level)
        };
        let type_of = |row: usize| types.and_then(|types| types.get(row)).map_or(0, |index| *index as u32);
        let mut found = Matches { bits: vec![0; frame.len().div_ceil(32)], counts: [0; 2] };
        for row in 0..frame.len() {
            let state = frame.state_of(row);
            if state == RobotState::Absent {
                continue;
            }
            let matches = self.state.is_none_or(|wanted| wanted == state)
                && self.robot_type.is_none_or(|wanted| wanted == type_of(row))
                && is_in_place(frame.edge()[row])
                && self.task.holds(row as u32, tasks);
            found.bits[row / 32] |= u32::from(matches) << (row % 32);
            found.counts[0] += u32::from(matches);
            found.counts[1] += 1;
        }
        found
    }
}

impl TaskFilter {
    fn holds(self, robot: u32, tasks: &TaskBook) -> bool {
        let task = || tasks.of_robot(robot).map(|task| task.task);
        match self {
            Self::Any => true,
            Self::Some => task().is_some(),
            Self::None => task().is_none(),
            Self::Number(number) => task() == Some(number),
        }
    }
}

#[cfg(test)]
mod tests {
    use regatta_plugin::frame::{ColumnsMut, FrameHeader, Line, NO_EDGE, frame_lines, stride_lines};
    use regatta_plugin::task::{TaskKind, TaskRecord};
    use regatta_plugin::world::{CurveRecord, EdgeRecord, WorldData};

    use super::*;

    #[test]
    fn all_conditions_must_hold() {
        let mut world = WorldData::default();
        let zone = world.texts.add("north");
        let upstairs = world.texts.add("upstairs");
        for (zone, level) in [(zone, 0), (0, upstairs)] {
            let line = CurveRecord::straight([0.0, 0.0], [1.0, 0.0]);
            world.add_edge(EdgeRecord { length: 1.0, zone, level, ..EdgeRecord::default() }, [line]);
        }
        let header =
            FrameHeader { run_id: 1, robots: 40, stride_lines: stride_lines(40) as u32, ..FrameHeader::default() };
        let mut lines = vec![Line::default(); frame_lines(40)];
        let columns = ColumnsMut::split(&mut lines, 40);
        for row in 0..40 {
            columns.edge[row] = [0, 1, NO_EDGE][row % 3];
            columns.state[row] = if row == 0 { RobotState::Absent as u8 } else { RobotState::Driving as u8 };
        }
        columns.state[33] = RobotState::Held as u8;
        let frame = Frame::new(&header, &lines).expect("a frame");
        let mut tasks = TaskBook::default();
        tasks.take(1, &[TaskRecord::new(7, TaskKind::Assigned).of_robot(36)]);
        let types: Vec<f32> = (0..40).map(|row| (row % 2) as f32).collect();
        let found = |filter: Filter| filter.matches(&frame, &world.view(1, 1), Some(&types), &tasks);
        let ids = |filter| {
            let found = found(filter);
            let ids: Vec<_> = (0..40_usize).filter(|row| found.bits[row / 32] >> (row % 32) & 1 == 1).collect();
            assert_eq!(found.counts, [ids.len() as u32, 39]);
            ids
        };
        let all = Filter::default();
        assert!(all.is_empty());
        assert_eq!(ids(all.clone()).len(), 39);
        assert_eq!(ids(Filter { state: Some(RobotState::Held), ..all.clone() }), [33]);
        assert_eq!(ids(Filter { task: TaskFilter::Some, ..all.clone() }), [36]);
        assert!(ids(Filter { task: TaskFilter::Number(8), ..all.clone() }).is_empty());
        assert_eq!(ids(Filter { task: TaskFilter::None, ..all.clone() }).len(), 38);
        let on_edge_1: Vec<usize> = (1..40).filter(|row| row % 3 == 1).collect();
        assert_eq!(ids(Filter { level: Some("upstairs".into()), ..all.clone() }), on_edge_1);
        let north = Filter { zone: Some("north".into()), robot_type: Some(1), ..all };
        assert_eq!(ids(north), [3, 9, 15, 21, 27, 33, 39]);
    }
}
