//! The filter of robots: by activity, type, order and zone. Robots that don't match are dimmed in
//! the picture, and those of other levels than the filter's are hidden. A thread other than the
//! drawing one computes the matches.

use std::sync::Arc;

use regatta_plugin::World;
use regatta_plugin::activity::Activity;
use regatta_plugin::column::ACTIVITY;
use regatta_plugin::frame::{Frame, RobotState};

use crate::orders::OpenOrders;

/// Conditions that robots match; all of them must hold.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Filter {
    /// The activity.
    pub activity: Option<Activity>,
    /// The type, by its index in the world.
    pub robot_type: Option<u32>,
    /// The order.
    pub order: OrderFilter,
    /// The zone of the edge that the robot is on.
    pub zone: Option<String>,
    /// The level of the edge that the robot is on.
    pub level: Option<String>,
}

/// The columns beside the frame that a filter reads, each with a value per robot.
#[derive(Clone, Copy, Debug, Default)]
pub struct FilterColumns<'a> {
    /// Each robot's index into the robot types. A robot without one has the first type.
    pub types: Option<&'a [f32]>,
    /// The activities that a fleet manager publishes; empty if there are none.
    pub activities: &'a [f32],
}

impl FilterColumns<'_> {
    fn type_of(self, row: usize) -> u32 {
        self.types.and_then(|types| types.get(row)).map_or(0, |index| *index as u32)
    }
}

/// Returns the activity of a robot by its state and by the values of the column `activity`, which
/// may be none. Returns `None` if the robot is absent.
pub fn activity_of(state: RobotState, activities: &[f32], robot: u32) -> Option<Activity> {
    let published = activities.get(robot as usize).and_then(|value| ACTIVITY.element(*value));
    Activity::of(state, published)
}

/// A condition on a robot's order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OrderFilter {
    /// Any order or none.
    #[default]
    Any,
    /// It has an order.
    Some,
    /// It has none.
    None,
    /// It has the order with this number.
    Number(u64),
}

/// A set of robots: a bit per robot, 32 to a word, the lowest one first. Each picture clones and
/// compares sets, which costs nothing as long as they are one set in memory.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RobotSet(Arc<Vec<u32>>);

/// The robots that match a filter.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Matches {
    /// The robots that meet all conditions but that of the level; `None` if there is no other
    /// condition.
    pub matching: Option<RobotSet>,
    /// The robots on the filter's level; `None` if it has none.
    pub on_level: Option<RobotSet>,
    /// The numbers of these robots.
    pub counts: MatchCounts,
}

/// The numbers of robots that match a filter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MatchCounts {
    /// Those that meet all conditions but that of the level.
    pub matching: u32,
    /// Those among them that are on the filter's level; all of them if it has none.
    pub on_level: u32,
    /// Those in the fleet.
    pub all: u32,
}

impl RobotSet {
    /// Creates an empty set with room for a number of robots.
    pub fn new(robots: usize) -> Self {
        Self(Arc::new(vec![0; robots.div_ceil(32)]))
    }

    /// Whether a robot is in the set.
    pub fn contains(&self, robot: u32) -> bool {
        self.0.get(robot as usize / 32).is_some_and(|word| word >> (robot % 32) & 1 == 1)
    }

    /// Adds a robot. One beyond the room of the set is left out.
    pub fn insert(&mut self, robot: u32) {
        if let Some(word) = Arc::make_mut(&mut self.0).get_mut(robot as usize / 32) {
            *word |= 1 << (robot % 32);
        }
    }

    /// The bits, 32 robots to a word.
    pub fn words(&self) -> &[u32] {
        &self.0
    }
}

/// Whether a robot is in a set; `None` is the set of all robots.
pub fn is_in(robots: Option<&RobotSet>, robot: u32) -> bool {
    robots.is_none_or(|robots| robots.contains(robot))
}

impl Filter {
    /// Whether all robots match.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Whether there are conditions beside that of the level.
    pub fn has_conditions(&self) -> bool {
        !self.of_level(None).is_empty()
    }

    /// Returns the filter for another level, or for all.
    pub fn of_level(&self, level: Option<&str>) -> Self {
        Self { level: level.map(str::to_owned), ..self.clone() }
    }

    /// Whether another filter differs in nothing but the level.
    pub fn is_like(&self, other: &Self) -> bool {
        self.of_level(other.level.as_deref()) == *other
    }

    /// Computes which robots of a frame match.
    pub fn matches(
        &self,
        frame: &Frame<'_>,
        world: &World<'_>,
        columns: FilterColumns<'_>,
        orders: &OpenOrders,
    ) -> Matches {
        let in_zone: Option<Vec<bool>> = self
            .zone
            .as_ref()
            .map(|zone| world.edges().iter().map(|edge| world.text(edge.zone) == zone).collect());
        let on_level: Option<Vec<bool>> = self.level.as_ref().map(|level| {
            world.edges().iter().map(|edge| world.text(edge.level) == level).collect()
        });
        let (mut matching, mut of_level) = (RobotSet::new(frame.len()), RobotSet::new(frame.len()));
        let mut counts = MatchCounts::default();
        for row in 0..frame.len() {
            let (state, edge) = (frame.state_of(row), frame.edge()[row]);
            let Some(activity) = activity_of(state, columns.activities, row as u32) else {
                continue;
            };
            let matches = self.activity.is_none_or(|wanted| wanted == activity)
                && self.robot_type.is_none_or(|wanted| wanted == columns.type_of(row))
                && has_edge(in_zone.as_deref(), edge)
                && self.order.holds(row as u32, orders);
            let is_on_level = has_edge(on_level.as_deref(), edge);
            if matches {
                matching.insert(row as u32);
            }
            if is_on_level {
                of_level.insert(row as u32);
            }
            counts.matching += u32::from(matches);
            counts.on_level += u32::from(matches && is_on_level);
            counts.all += 1;
        }
        Matches {
            matching: self.has_conditions().then_some(matching),
            on_level: self.level.is_some().then_some(of_level),
            counts,
        }
    }
}

/// Whether an edge is in a set of edges. Without a set, all edges are. The number of a robot
/// without an edge is in no set.
fn has_edge(edges: Option<&[bool]>, edge: u32) -> bool {
    edges.is_none_or(|edges| edges.get(edge as usize) == Some(&true))
}

impl OrderFilter {
    fn holds(self, robot: u32, orders: &OpenOrders) -> bool {
        if self == Self::Any {
            return true;
        }
        let order = orders.of_robot(robot).map(|order| order.number);
        match self {
            Self::Any => true,
            Self::Some => order.is_some(),
            Self::None => order.is_none(),
            Self::Number(number) => order == Some(number),
        }
    }
}

#[cfg(test)]
mod tests {
    use regatta_plugin::frame::{
        ColumnsMut, FrameHeader, Line, NO_EDGE, frame_lines, stride_lines,
    };
    use regatta_plugin::order::{OrderKind, OrderRecord};
    use regatta_plugin::world::{CurveRecord, EdgeRecord, WorldData};

    use super::*;

    #[test]
    fn all_conditions_must_hold() {
        let mut world = WorldData::default();
        let zone = world.texts.add("north");
        let upstairs = world.texts.add("upstairs");
        for (zone, level) in [(zone, 0), (0, upstairs)] {
            let line = CurveRecord::straight([0.0, 0.0], [1.0, 0.0]);
            world
                .add_edge(EdgeRecord { length: 1.0, zone, level, ..EdgeRecord::default() }, [line]);
        }
        let header = FrameHeader {
            run_id: 1,
            robots: 40,
            stride_lines: stride_lines(40) as u32,
            ..FrameHeader::default()
        };
        let mut lines = vec![Line::default(); frame_lines(40)];
        let columns = ColumnsMut::split(&mut lines, 40);
        for row in 0..40 {
            columns.edge[row] = [0, 1, NO_EDGE][row % 3];
            columns.state[row] =
                if row == 0 { RobotState::Absent as u8 } else { RobotState::Driving as u8 };
        }
        columns.state[33] = RobotState::Held as u8;
        let frame = Frame::new(&header, &lines).expect("a frame");
        let mut orders = OpenOrders::default();
        orders.take(1, &[OrderRecord::new(7, OrderKind::Assigned).of_robot(36)]);
        let types: Vec<f32> = (0..40).map(|row| (row % 2) as f32).collect();
        let mut activities = vec![f32::NAN; 40];
        activities[32] = f32::from(Activity::Carrying as u8);
        activities[33] = f32::from(Activity::Carrying as u8);
        let columns = FilterColumns { types: Some(&types), activities: &activities };
        let found = |filter: Filter| filter.matches(&frame, &world.view(1, 1), columns, &orders);
        let ids_in = |robots: &RobotSet| -> Vec<usize> {
            (0..40).filter(|row| robots.contains(*row as u32)).collect()
        };
        let ids = |filter| {
            let found = found(filter);
            assert_eq!(found.on_level, None);
            let ids = ids_in(&found.matching.expect("conditions"));
            let number = ids.len() as u32;
            assert_eq!(found.counts, MatchCounts { matching: number, on_level: number, all: 39 });
            ids
        };
        let all = Filter::default();
        assert!(all.is_empty());
        let counts = MatchCounts { matching: 39, on_level: 39, all: 39 };
        assert_eq!(found(all.clone()), Matches { counts, ..Matches::default() });
        let doing = |activity| Filter { activity: Some(activity), ..all.clone() };
        assert_eq!(ids(doing(Activity::Held)), [33], "it can't move, whatever it was told to do");
        assert_eq!(ids(doing(Activity::Carrying)), [32], "the word of the list, not the state");
        assert_eq!(ids(doing(Activity::Moving)).len(), 37);
        assert_eq!(ids(Filter { order: OrderFilter::Some, ..all.clone() }), [36]);
        assert!(ids(Filter { order: OrderFilter::Number(8), ..all.clone() }).is_empty());
        assert_eq!(ids(Filter { order: OrderFilter::None, ..all.clone() }).len(), 38);
        let on_edge_1: Vec<usize> = (1..40).filter(|row| row % 3 == 1).collect();
        let upstairs = found(all.of_level(Some("upstairs")));
        assert_eq!(upstairs.on_level.as_ref().map(ids_in), Some(on_edge_1));
        assert_eq!(upstairs.matching, None);
        assert_eq!(upstairs.counts, MatchCounts { matching: 39, on_level: 13, all: 39 });
        let held_elsewhere =
            found(Filter { activity: Some(Activity::Held), ..all.of_level(Some("upstairs")) });
        assert_eq!(
            held_elsewhere.matching.as_ref().map(ids_in),
            Some(vec![33]),
            "the level is no condition"
        );
        assert_eq!(held_elsewhere.on_level, upstairs.on_level);
        assert_eq!(held_elsewhere.counts, MatchCounts { matching: 1, on_level: 0, all: 39 });
        let north = Filter { zone: Some("north".into()), robot_type: Some(1), ..all };
        assert_eq!(ids(north), [3, 9, 15, 21, 27, 33, 39]);
    }
}
