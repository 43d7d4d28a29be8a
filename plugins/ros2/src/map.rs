//! The layout as the desk knows it: nodes on the map of the layout's file, robot types, doors and
//! lifts.

use regatta_plugin::World;

use crate::message::geometry::{Pose, PoseStamped};
use crate::poses::MAP;

/// The largest distance of a goal from a node, in metres.
const NEAR: f64 = 5.0;

/// The layout.
#[derive(Clone, Debug, Default)]
pub(crate) struct Map {
    origin: [f64; 2],
    nodes: Vec<Place>,
    pub robot_types: Vec<String>,
    pub doors: Vec<Door>,
    pub lifts: Vec<Lift>,
}

/// A node.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Place {
    /// Its id in the contract.
    pub node: u32,
    /// Metres on the map of the layout's file.
    pub x: f64,
    pub y: f64,
    /// The name of its level; empty for none.
    pub level: String,
}

/// A door.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Door {
    pub name: String,
    /// The id of an edge through it.
    pub edge: u32,
}

/// A lift.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Lift {
    pub name: String,
    pub levels: Vec<LiftLevel>,
}

/// A level of a lift.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LiftLevel {
    pub name: String,
    /// The id of a node in the cabin there.
    pub node: u32,
}

/// The reason why a pose is no goal.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum GoalError {
    #[error("its frame is '{0}'; give a pose in the frame {MAP}")]
    Frame(String),
    #[error("its position isn't finite")]
    NotFinite,
    #[error(
        "the nearest node, {node}, is {distance:.1} m away; give a pose within {NEAR} m of a node"
    )]
    Far { node: u32, distance: f64 },
    #[error("the fleet has no nodes")]
    NoNodes,
}

impl Map {
    pub fn of(world: &World<'_>) -> Self {
        let [east, north] = world.origin();
        let nodes = world.nodes().iter().map(|node| Place {
            node: node.id,
            x: east + f64::from(node.x),
            y: north + f64::from(node.y),
            level: world.text(node.level).to_owned(),
        });
        Self {
            origin: world.origin(),
            nodes: nodes.collect(),
            robot_types: world.robot_types().iter().map(|kind| kind.name().to_owned()).collect(),
            doors: doors(world),
            lifts: lifts(world),
        }
    }

    pub fn origin(&self) -> [f64; 2] {
        self.origin
    }

    /// The node that a goal means.
    pub fn goal(&self, goal: &PoseStamped) -> Result<&Place, GoalError> {
        let frame = goal.header.frame_id.trim_start_matches('/');
        match frame {
            "" | MAP => self.near(&goal.pose, None),
            frame => Err(GoalError::Frame(frame.to_owned())),
        }
    }

    /// The node nearest to a pose, on a level if it is given.
    pub fn near(&self, pose: &Pose, level: Option<&str>) -> Result<&Place, GoalError> {
        let (x, y) = (pose.position.x, pose.position.y);
        if !x.is_finite() || !y.is_finite() {
            return Err(GoalError::NotFinite);
        }
        let level = level.filter(|level| !level.is_empty());
        let on_level = |place: &&Place| level.is_none_or(|level| place.level == level);
        let places = self.nodes.iter().filter(on_level);
        let nearest = places
            .map(|place| (place, (place.x - x).hypot(place.y - y)))
            .min_by(|one, other| one.1.total_cmp(&other.1));
        match nearest {
            None => Err(GoalError::NoNodes),
            Some((place, distance)) if distance > NEAR => {
                Err(GoalError::Far { node: place.node, distance })
            }
            Some((place, _)) => Ok(place),
        }
    }
}

fn doors(world: &World<'_>) -> Vec<Door> {
    let doors = world.doors().iter().filter_map(|door| {
        let edge = world.edges().get(*world.door_edges(door).first()? as usize)?;
        Some(Door { name: world.text(door.name).to_owned(), edge: edge.id })
    });
    doors.collect()
}

fn lifts(world: &World<'_>) -> Vec<Lift> {
    let lifts = world.lifts().iter().map(|lift| {
        let levels = world.lift_levels(lift).iter().filter_map(|level| {
            let node = world.nodes().get(*world.level_nodes(level).first()? as usize)?;
            Some(LiftLevel { name: world.text(level.name).to_owned(), node: node.id })
        });
        Lift { name: world.text(lift.name).to_owned(), levels: levels.collect() }
    });
    lifts.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map() -> Map {
        let place = |node, x, level: &str| Place { node, x, y: 0.0, level: level.to_owned() };
        Map { nodes: vec![place(7, 0.0, "L1"), place(8, 3.0, "L2")], ..Map::default() }
    }

    fn goal(frame: &str, x: f64) -> Result<u32, GoalError> {
        let mut goal = PoseStamped { pose: Pose::on_ground(x, 0.5, 0.0), ..PoseStamped::default() };
        goal.header.frame_id = frame.to_owned();
        map().goal(&goal).map(|place| place.node)
    }

    #[test]
    fn a_goal_means_the_nearest_node() {
        assert_eq!((goal("map", 1.4), goal("/map", 1.6), goal("", 9e-9)), (Ok(7), Ok(8), Ok(7)));
        assert_eq!(goal("odom", 1.0), Err(GoalError::Frame("odom".to_owned())));
        assert_eq!(goal("map", f64::NAN), Err(GoalError::NotFinite));
        assert!(matches!(goal("map", 50.0), Err(GoalError::Far { node: 8, .. })));
        let on = |level| map().near(&Pose::on_ground(0.0, 0.0, 0.0), level).map(|place| place.node);
        assert_eq!((on(None), on(Some("")), on(Some("L2"))), (Ok(7), Ok(7), Ok(8)));
        assert_eq!(on(Some("L3")), Err(GoalError::NoNodes));
    }
}
