//! Facilities: the doors that robots pass and the lifts that they ride.

use std::num::NonZeroU32;

use glam::DVec2;
use regatta_base::graph::{CRAWL, EdgeIndex, NodeIndex};

use super::path::Path;
use super::route_graph::{Edge, RouteGraph};
use super::value::shorten;
use super::zones::{Zone, ZoneRule};

/// The times of a door, in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoorTimes {
    /// From closed to open.
    pub opening_secs: f64,
    /// From open to closed.
    pub closing_secs: f64,
}

impl Default for DoorTimes {
    /// 5 seconds each.
    fn default() -> Self {
        Self { opening_secs: 5.0, closing_secs: 5.0 }
    }
}

/// The time of a cabin from a level to the next, in seconds, if the file gives none.
pub const DEFAULT_LEVEL_SECS: f64 = 6.0;

/// The longest time of a door or of a cabin from a level to the next, in seconds.
pub const MAX_FACILITY_SECS: f64 = 3600.0;

/// A door across edges, on one level.
#[derive(Clone, Debug, PartialEq)]
pub struct Door {
    /// The name, unique among doors.
    pub name: Box<str>,
    /// The edges that lead through it, in ascending order; at least one.
    pub edges: Vec<EdgeIndex>,
    /// Its ends, in metres from the graph's origin; `None` if the file doesn't give them.
    pub line: Option<[DVec2; 2]>,
    /// Its times.
    pub times: DoorTimes,
}

/// The width in metres of a door that is drawn without a line of its own.
const DRAWN_WIDTH: f64 = 1.0;

/// The number of chords of each cubic by which the place of a door is found.
const CHORDS: usize = 16;

impl Door {
    /// Returns the metres from the origin of an edge, which leads through the door, to the door: to
    /// the crossing with its line or, without one, to the middle of the edge.
    pub fn place(&self, path: &Path) -> f64 {
        let middle = path.length() / 2.0;
        self.line.and_then(|line| crossing(path, line)).unwrap_or(middle)
    }

    /// Returns the ends of the door for a drawing. Without a line in the file, it is across the
    /// middle of its first edge.
    pub fn drawn_line(&self, graph: &RouteGraph) -> [DVec2; 2] {
        self.line.unwrap_or_else(|| {
            let (point, tangent) = graph.edge(self.edges[0]).path.at(0.5);
            let across = tangent.normalize_or_zero().perp() * (DRAWN_WIDTH / 2.0);
            [point - across, point + across]
        })
    }
}

/// Returns the distance along a path at which it first crosses a segment.
pub(crate) fn crossing(path: &Path, [start, end]: [DVec2; 2]) -> Option<f64> {
    let mut driven = 0.0;
    for cubic in path.cubics() {
        let at = |chord: usize| cubic.position(chord as f64 / CHORDS as f64);
        for chord in 0..CHORDS {
            let (from, to) = (at(chord), at(chord + 1));
            let (along, across) = (to - from, end - start);
            let determinant = along.perp_dot(across);
            let part = (start - from).perp_dot(across) / determinant;
            let other = (start - from).perp_dot(along) / determinant;
            if (0.0..=1.0).contains(&part) && (0.0..=1.0).contains(&other) {
                return Some(driven + part * along.length());
            }
            driven += along.length();
        }
    }
    None
}

/// A lift: a cabin that carries robots from level to level.
#[derive(Clone, Debug, PartialEq)]
pub struct Lift {
    /// The name, unique among lifts.
    pub name: Box<str>,
    /// Its levels from the lowest to the highest; at least two.
    pub levels: Vec<LiftLevel>,
    /// The edges from level to level within the cabin, in ascending order.
    pub rides: Vec<EdgeIndex>,
    /// The cabin; `None` if the file doesn't give it.
    pub cabin: Option<Cabin>,
    /// The times of the doors of cabin and shaft, which move together.
    pub door_times: DoorTimes,
    /// The time of the cabin from a level to the next, in seconds, without the doors.
    pub level_secs: f64,
    /// The largest number of robots in the cabin.
    pub capacity: NonZeroU32,
    /// The level where the cabin stands at the beginning: an index of `levels`.
    pub home: usize,
}

/// A level that a lift serves.
#[derive(Clone, Debug, PartialEq)]
pub struct LiftLevel {
    /// The name of the level.
    pub name: Box<str>,
    /// The nodes in the cabin while it is there, in the order of the file.
    pub nodes: Vec<NodeIndex>,
}

/// The footprint of a cabin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cabin {
    /// Metres from the graph's origin.
    pub centre: DVec2,
    /// Its extents along its own axes, in metres.
    pub size: DVec2,
    /// The angle of its first axis, in radians.
    pub yaw: f64,
}

impl Cabin {
    /// Returns the closed outline.
    pub fn outline(&self) -> [DVec2; 5] {
        let corners = [(0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5), (0.5, 0.5)];
        let turn = DVec2::from_angle(self.yaw);
        corners.map(|(x, y)| self.centre + turn.rotate(self.size * DVec2::new(x, y)))
    }
}

impl Lift {
    /// Returns the level of a node in the cabin, as an index of `levels`; `None` for other nodes.
    pub fn level_of(&self, node: NodeIndex) -> Option<usize> {
        self.levels.iter().position(|level| level.nodes.contains(&node))
    }

    /// Returns the name of the zone that holds its robots.
    pub fn zone_name(&self) -> String {
        format!("lift {}", self.name)
    }

    /// The number of robots that it carries at a time: its capacity, as far as there is a node for
    /// each of them on every level.
    pub fn places(&self) -> NonZeroU32 {
        let nodes = self.levels.iter().map(|level| level.nodes.len()).min().unwrap_or(1);
        let nodes = u32::try_from(nodes).ok().and_then(NonZeroU32::new);
        self.capacity.min(nodes.unwrap_or(NonZeroU32::MIN))
    }

    /// Tells that it carries fewer robots than its capacity allows, if so.
    pub fn lack_of_places(&self) -> Option<String> {
        let (places, capacity) = (self.places(), self.capacity);
        let level = self.levels.iter().min_by_key(|level| level.nodes.len())?;
        let robots = if places.get() == 1 { "robot" } else { "robots" };
        (places < capacity).then(|| {
            format!(
                "has a capacity of {capacity}, but carries {places} {robots} at a time: level {} \
                 has no more nodes in the cabin; add nodes for the others to each level",
                shorten(&level.name)
            )
        })
    }

    /// Returns the zone of its robots: its nodes, and all edges from them and to them. A robot in a
    /// doorway keeps the cabin, too.
    pub(crate) fn zone(&self, edges: &[Edge]) -> Zone {
        let mut nodes: Vec<NodeIndex> =
            self.levels.iter().flat_map(|level| level.nodes.iter().copied()).collect();
        nodes.sort_unstable();
        let is_inside = |node: &NodeIndex| nodes.binary_search(node).is_ok();
        let edges = (0..).map(EdgeIndex).zip(edges);
        let edges =
            edges.filter(|(_, edge)| is_inside(&edge.origin) || is_inside(&edge.destination));
        Zone {
            name: self.zone_name().into(),
            rule: ZoneRule::Capacity(self.places()),
            edges: edges.map(|(index, _)| index).collect(),
            nodes,
            inner: Vec::new(),
        }
    }

    /// Sets the speeds of a ride: the edge takes as long as the cabin. The edge may be too short
    /// for that, where the levels are drawn over each other; then it is driven at a [crawl](CRAWL)
    /// at the end of the ride.
    pub(crate) fn time_ride(&self, edge: &mut Edge) {
        let fastest = crate::check::validate::MAX_SPEED;
        let speed = (edge.path.length() / self.level_secs).clamp(CRAWL, fastest);
        edge.speed = speed;
        edge.reverse_speed = edge.reverse_speed.map(|_| speed);
    }
}

#[cfg(test)]
mod tests {
    use regatta_base::bezier::CubicBezier;

    use super::*;

    #[test]
    fn a_lift_carries_as_many_robots_as_it_has_nodes_on_each_level() {
        let level = |nodes: &[u32]| LiftLevel {
            name: "level".into(),
            nodes: nodes.iter().map(|node| NodeIndex(*node)).collect(),
        };
        let lift = |levels: Vec<LiftLevel>| Lift {
            name: "lift".into(),
            levels,
            rides: Vec::new(),
            cabin: None,
            door_times: DoorTimes::default(),
            level_secs: 6.0,
            capacity: NonZeroU32::new(3).expect("not zero"),
            home: 0,
        };
        let (one, two) =
            (lift(vec![level(&[1]), level(&[2])]), lift(vec![level(&[1, 2]), level(&[3, 4, 5])]));
        assert_eq!((one.places().get(), two.places().get()), (1, 2));
        for (lift, told) in [(one, "carries 1 robot at a time"), (two, "carries 2 robots")] {
            assert!(lift.lack_of_places().is_some_and(|lack| lack.contains(told)), "{told}");
        }
        let three = lift(vec![level(&[1, 2, 3, 4]), level(&[5, 6, 7, 8])]);
        assert_eq!((three.places().get(), three.lack_of_places()), (3, None));
    }

    #[test]
    fn a_door_stands_where_its_line_crosses_the_edge() {
        let path = Path::from(CubicBezier::straight(DVec2::ZERO, DVec2::X * 8.0));
        let door = |line| Door {
            name: "d".into(),
            edges: vec![EdgeIndex(0)],
            line,
            times: DoorTimes::default(),
        };
        let line = [DVec2::new(3.0, -1.0), DVec2::new(3.0, 1.0)];
        assert!((door(Some(line)).place(&path) - 3.0).abs() < 1e-9);
        assert_eq!(door(None).place(&path), 4.0);
        let beside = [DVec2::new(3.0, 1.0), DVec2::new(3.0, 2.0)];
        assert_eq!(door(Some(beside)).place(&path), 4.0, "it doesn't cross the edge");
    }
}
