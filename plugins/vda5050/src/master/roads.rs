//! The roads of a plant, by which a master places vehicles: the ids of orders, the contract's
//! numbers, and the paths of edges.

use regatta_base::graph::{EdgeIndex, Gear, Leg};
use regatta_plugin::World;
use regatta_plugin::world::CurveRecord;
use rustc_hash::FxHashMap;

use crate::map::{Map, Place, Road};

/// The distance between two points of a path, in metres.
const STEP: f64 = 0.2;
/// The least and the largest number of lines that a curve is made of.
const FEWEST_LINES: f64 = 4.0;
const MOST_LINES: f64 = 1000.0;

/// The roads of a plant. Positions are metres on the map of its file.
#[derive(Debug, Default)]
pub struct Roads {
    map: Map,
    paths: Vec<Path>,
    edges_by_number: FxHashMap<u32, u32>,
    /// By node: an edge that leads there.
    arrivals: Vec<Option<u32>>,
}

/// The path of an edge, as lines from point to point.
#[derive(Debug)]
struct Path {
    points: Vec<[f64; 2]>,
    /// Metres from the origin, by point; the last is the edge's length.
    metres: Vec<f64>,
}

/// The place on a path that is nearest to a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Metres from where the leg is entered.
    pub travelled: f64,
    /// Metres between the position and the path.
    pub distance: f64,
}

impl Roads {
    /// Takes the roads of a world. Nodes without a level are on the map `map_id`.
    pub fn of(world: &World<'_>, map_id: &str) -> Self {
        let map = Map::of(world, map_id);
        let origin = world.origin();
        let paths = world.edges().iter().map(|edge| {
            let length = f64::from(edge.length);
            Path::of(world.curves(edge), origin, length)
        });
        let mut arrivals = vec![None; map.nodes().len()];
        for (edge, index) in world.edges().iter().zip(0..) {
            arrivals[edge.destination as usize].get_or_insert(index);
        }
        let numbers = world.edges().iter().map(|edge| edge.id).zip(0..);
        Self { paths: paths.collect(), edges_by_number: numbers.collect(), arrivals, map }
    }

    /// The nodes and edges by their ids.
    pub fn map(&self) -> &Map {
        &self.map
    }

    /// A leg of a command. `None` if there is no such edge.
    pub fn leg(&self, number: u32, reverse: bool) -> Option<Leg> {
        let edge = EdgeIndex(*self.edges_by_number.get(&number)?);
        Some(Leg { edge, gear: if reverse { Gear::Reverse } else { Gear::Forward } })
    }

    /// The index of an edge by its number in the contract.
    pub fn edge_with_number(&self, number: u32) -> Option<u32> {
        self.edges_by_number.get(&number).copied()
    }

    /// The edge of a leg.
    ///
    /// # Panics
    /// If the leg isn't one of these roads.
    pub fn edge(&self, leg: Leg) -> &Road {
        self.map.edge(leg.edge.0).expect("legs are made of edges of these roads")
    }

    /// A node.
    ///
    /// # Panics
    /// If it isn't one of these roads.
    pub fn node(&self, node: u32) -> &Place {
        self.map.node(node).expect("nodes are those of these roads")
    }

    /// Whether a leg can be driven at all.
    pub fn is_drivable(&self, leg: Leg) -> bool {
        leg.gear == Gear::Forward || self.edge(leg).reverse_speed > 0.0
    }

    /// Metres of a leg.
    pub fn length(&self, leg: Leg) -> f64 {
        self.edge(leg).length
    }

    /// The node where a leg begins.
    pub fn start(&self, leg: Leg) -> u32 {
        let road = self.edge(leg);
        if leg.gear == Gear::Forward { road.origin } else { road.destination }
    }

    /// The node where a leg ends.
    pub fn end(&self, leg: Leg) -> u32 {
        let road = self.edge(leg);
        if leg.gear == Gear::Forward { road.destination } else { road.origin }
    }

    /// The leg on which a robot at a node counts as standing, and the metres from its start: at the
    /// end of an edge that leads there, or else at the start of one that leaves it. `None` for a
    /// node without edges.
    pub fn stance(&self, node: u32) -> Option<(Leg, f64)> {
        let arrival = self.arrivals.get(node as usize).copied().flatten();
        match arrival {
            Some(edge) => {
                let leg = Leg { edge: EdgeIndex(edge), gear: Gear::Forward };
                Some((leg, self.length(leg)))
            }
            None => self.map.exit(node).map(|leg| (leg, 0.0)),
        }
    }

    /// The place on a leg that is nearest to a position.
    pub fn nearest_on(&self, leg: Leg, position: [f64; 2]) -> Nearest {
        let length = self.length(leg);
        let found = self.paths[leg.edge.0 as usize].nearest(position);
        match leg.gear {
            Gear::Forward => found,
            Gear::Reverse => Nearest { travelled: length - found.travelled, ..found },
        }
    }

    /// The position of a place on a leg.
    pub fn position(&self, leg: Leg, travelled: f64) -> [f64; 2] {
        let metres = match leg.gear {
            Gear::Forward => travelled,
            Gear::Reverse => self.length(leg) - travelled,
        };
        self.paths[leg.edge.0 as usize].position(metres)
    }

    /// The edges whose paths are within a distance of a position, in ascending order.
    pub fn edges_near(&self, position: [f64; 2], metres: f64) -> Vec<u32> {
        let paths = (0..).zip(&self.paths);
        let near = paths.filter(|(_, path)| path.nearest(position).distance <= metres);
        near.map(|(edge, _)| edge).collect()
    }

    /// The forward leg that is nearest to a position, with the place on it.
    pub fn nearest_leg(&self, position: [f64; 2]) -> Option<(Leg, Nearest)> {
        let legs = (0..self.paths.len() as u32)
            .map(|edge| Leg { edge: EdgeIndex(edge), gear: Gear::Forward });
        let places = legs.map(|leg| (leg, self.nearest_on(leg, position)));
        places.min_by(|a, b| a.1.distance.total_cmp(&b.1.distance))
    }
}

impl Path {
    /// Makes the path of an edge's curves. Its metres are stretched to the length of the edge.
    fn of(curves: &[CurveRecord], origin: [f64; 2], length: f64) -> Self {
        let mut points = Vec::new();
        for curve in curves {
            let control = curve
                .control_points
                .map(|[x, y]| [origin[0] + f64::from(x), origin[1] + f64::from(y)]);
            let lines = (distance(control[0], control[3]) / STEP).clamp(FEWEST_LINES, MOST_LINES);
            let lines = lines.ceil() as u32;
            if points.is_empty() {
                points.push(control[0]);
            }
            points.extend(
                (1..=lines).map(|line| bezier(&control, f64::from(line) / f64::from(lines))),
            );
        }
        let mut metres = vec![0.0];
        for ends in points.windows(2) {
            metres.push(metres[metres.len() - 1] + distance(ends[0], ends[1]));
        }
        let sum = metres[metres.len() - 1];
        if sum > 0.0 {
            metres.iter_mut().for_each(|metre| *metre *= length / sum);
        }
        Self { points, metres }
    }

    /// The position so many metres from the origin.
    fn position(&self, metres: f64) -> [f64; 2] {
        let Some(last) = self.points.len().checked_sub(1).filter(|last| *last > 0) else {
            return self.points.first().copied().unwrap_or_default();
        };
        let line = self.metres.partition_point(|start| *start <= metres).clamp(1, last);
        let (from, to) = (self.metres[line - 1], self.metres[line]);
        let part = if to > from { ((metres - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        mix(self.points[line - 1], self.points[line], part)
    }

    fn nearest(&self, position: [f64; 2]) -> Nearest {
        let start = self.points.first().copied().unwrap_or_default();
        let mut best = Nearest { travelled: 0.0, distance: distance(start, position) };
        for (ends, metres) in self.points.windows(2).zip(self.metres.windows(2)) {
            let along = part_of(ends[0], ends[1], position);
            let place = mix(ends[0], ends[1], along);
            let found = distance(place, position);
            if found < best.distance {
                let travelled = metres[0] + along * (metres[1] - metres[0]);
                best = Nearest { travelled, distance: found };
            }
        }
        best
    }
}

/// Metres between two points.
pub fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

fn mix(a: [f64; 2], b: [f64; 2], part: f64) -> [f64; 2] {
    [0, 1].map(|axis| a[axis] + part * (b[axis] - a[axis]))
}

/// The part of a line, in [0, 1], at which it is nearest to a point.
fn part_of(a: [f64; 2], b: [f64; 2], point: [f64; 2]) -> f64 {
    let line = [b[0] - a[0], b[1] - a[1]];
    let square = line[0].powi(2) + line[1].powi(2);
    if square == 0.0 {
        return 0.0;
    }
    let along = (point[0] - a[0]) * line[0] + (point[1] - a[1]) * line[1];
    (along / square).clamp(0.0, 1.0)
}

fn bezier(control: &[[f64; 2]; 4], part: f64) -> [f64; 2] {
    let [a, b, c, d] = *control;
    let (ab, bc, cd) = (mix(a, b, part), mix(b, c, part), mix(c, d, part));
    mix(mix(ab, bc, part), mix(bc, cd, part), part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_on_a_path_are_found_in_both_gears() {
        let (world, _) = crate::master::tests::line(3);
        let roads = Roads::of(&world.view(1, 1), "map");
        let leg = roads.leg(10, false).expect("an edge");
        let found = roads.nearest_on(leg, [101.5, 200.25]);
        assert!((found.travelled - 1.5).abs() < 1e-6 && (found.distance - 0.25).abs() < 1e-6);
        let back = roads.nearest_on(Leg { gear: Gear::Reverse, ..leg }, [101.5, 200.25]);
        assert!((back.travelled - 3.5).abs() < 1e-6, "{back:?}");
        assert_eq!(roads.position(leg, 1.5), [101.5, 200.0]);
        assert_eq!(roads.position(Leg { gear: Gear::Reverse, ..leg }, 1.5), [103.5, 200.0]);
        assert_eq!(
            (roads.position(leg, -1.0), roads.position(leg, 9.0)),
            ([100.0, 200.0], [105.0, 200.0])
        );
        assert_eq!(roads.edges_near([104.9, 200.0], 0.2), [0, 1]);
        assert_eq!(roads.stance(1), Some((leg, 5.0)), "at the end of the edge that leads there");
        assert_eq!(roads.stance(0), Some((leg, 0.0)), "no edge leads there");
        assert_eq!(roads.leg(99, false), None);
    }
}
