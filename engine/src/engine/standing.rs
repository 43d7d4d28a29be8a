//! Places for robots that stand and wait for commands: seeded random nodes at which edges end,
//! where no two footprints touch and no zone holds more robots than its rule allows.

use std::collections::BTreeMap;

use glam::DVec2;
use regatta_base::most_apart;
use regatta_base::random::mix;
use regatta_layout::model::components::Components;
use regatta_layout::{EdgeIndex, Gear, Leg, NodeIndex, Orientation, RouteGraph};
use regatta_motion::Tracks;
use regatta_scenario::RobotType;

use super::footprint::Footprint;
use super::zone_room::ZoneRoom;
use crate::fleet::Placement;

/// The smallest distance between two footprints, in metres.
const MARGIN: f64 = 0.1;

/// Ends of edges in random order, and the footprints of robots that stand.
pub(super) struct StandingPlaces {
    /// They are in the main part of the layout, as robots can't work elsewhere. Ends at nodes with
    /// one edge in and one edge out come first: there, a robot blocks no other route.
    ends: Vec<EdgeIndex>,
    /// By robot type: the number of ends that were tried. Those are taken, or too near to another
    /// robot.
    tried: Vec<usize>,
    cells: BTreeMap<[i64; 2], Vec<Footprint>>,
    zones: ZoneRoom,
    /// Metres: two robots in cells that aren't neighbours are far enough from each other.
    cell_size: f64,
    /// The number of places that were taken.
    taken: usize,
}

impl StandingPlaces {
    pub fn new(graph: &RouteGraph, robot_types: &[RobotType], seed: u64) -> Self {
        let mut ends: Vec<_> = (0..graph.edges().len() as u32).map(EdgeIndex).collect();
        for place in (1..ends.len()).rev() {
            let random = mix(seed ^ mix(place as u64)) >> 32;
            ends.swap(place, ((random * (place as u64 + 1)) >> 32) as usize);
        }
        keep_main_part(graph, &mut ends);
        // A robot that stands in a cabin keeps it.
        ends.retain(|edge| {
            let node = graph.edge(*edge).destination;
            graph.lifts().iter().all(|lift| lift.level_of(node).is_none())
        });
        let arrivals = arrivals(graph);
        ends.sort_by_key(|edge| {
            let node = graph.edge(*edge).destination;
            let departures = graph.departures(node).iter();
            let exits = departures.filter(|leg| leg.gear == Gear::Forward).count();
            (arrivals[node.0 as usize], exits) != (1, 1)
        });
        let mut cell_size = 0.0_f64;
        for robot_type in robot_types {
            let diameter = f64::from(robot_type.length).hypot(f64::from(robot_type.width));
            cell_size = cell_size.max(diameter);
        }
        cell_size += MARGIN;
        Self {
            ends,
            tried: vec![0; robot_types.len()],
            cells: BTreeMap::new(),
            zones: ZoneRoom::new(graph),
            cell_size,
            taken: 0,
        }
    }

    /// Adds a robot on an edge, or at a node, with the node ahead of it.
    pub fn occupy(
        &mut self,
        robot_type: &RobotType,
        (position, heading): (DVec2, DVec2),
        (edge, node): (Option<EdgeIndex>, NodeIndex),
    ) {
        self.zones.add(edge, node);
        let footprint = Footprint::new(robot_type, position, heading);
        self.cells.entry(self.cell(position)).or_default().push(footprint);
    }

    /// Returns a place for another robot of a type, given its index; `None` if there is none left.
    pub fn take(
        &mut self,
        (graph, tracks): (&RouteGraph, &Tracks),
        (index, robot_type): (u16, &RobotType),
    ) -> Option<Placement> {
        loop {
            let tried = self.tried.get_mut(usize::from(index))?;
            let edge = *self.ends.get(*tried)?;
            *tried += 1;
            let pose @ (position, heading) = end_pose(graph, tracks, edge);
            // At the end of an edge, a robot stands at the node, and not in the zones of the edge.
            let place = (None, graph.edge(edge).destination);
            if self.zones.has_room(place.1)
                && self.is_free(position, &Footprint::new(robot_type, position, heading))
            {
                self.occupy(robot_type, pose, place);
                self.taken += 1;
                return Some(Placement::Edge(edge, tracks.edge_length(edge) as f32));
            }
        }
    }

    /// Whether another seed can't place more robots: as many places are taken as robots of any of
    /// the types ever find. Elsewhere nobody knows.
    pub fn are_all_taken(
        &self,
        (graph, tracks): (&RouteGraph, &Tracks),
        robot_types: &[RobotType],
    ) -> bool {
        let mut by_zone: BTreeMap<Option<u32>, Vec<EdgeIndex>> = BTreeMap::new();
        let zones = ZoneRoom::new(graph);
        for edge in &self.ends {
            let zone = zones.first_of(graph.edge(*edge).destination);
            by_zone.entry(zone).or_default().push(*edge);
        }
        let mut most = 0;
        for (zone, ends) in by_zone {
            let room = zone.map_or(usize::MAX, |zone| zones.room_of(zone));
            most += self.most((graph, tracks), robot_types, &ends).min(room);
        }
        self.taken >= most.min(self.most((graph, tracks), robot_types, &self.ends))
    }

    /// Returns a number of robots that never finds more places at some ends of edges.
    fn most(
        &self,
        (graph, tracks): (&RouteGraph, &Tracks),
        robot_types: &[RobotType],
        ends: &[EdgeIndex],
    ) -> usize {
        let poses: Vec<_> = ends.iter().map(|edge| end_pose(graph, tracks, *edge)).collect();
        let positions: Vec<DVec2> = poses.iter().map(|(position, _)| *position).collect();
        let footprints: Vec<Vec<Footprint>> = poses
            .iter()
            .map(|(position, heading)| {
                let of_type = |robot_type| Footprint::new(robot_type, *position, *heading);
                robot_types.iter().map(of_type).collect()
            })
            .collect();
        most_apart(&positions, self.cell_size, |one, other| {
            let pairs = footprints[one]
                .iter()
                .flat_map(|a| footprints[other].iter().map(move |b| a.distance(b)));
            pairs.into_iter().all(|distance| distance < MARGIN)
        })
    }

    fn is_free(&self, position: DVec2, footprint: &Footprint) -> bool {
        let [column, row] = self.cell(position);
        let cells = (-1..=1).flat_map(|x| (-1..=1).map(move |y| [column + x, row + y]));
        let near = cells.filter_map(|cell| self.cells.get(&cell)).flatten();
        near.into_iter().all(|other| footprint.distance(other) >= MARGIN)
    }

    fn cell(&self, position: DVec2) -> [i64; 2] {
        (position / self.cell_size).floor().to_array().map(|cell| cell as i64)
    }
}

/// Keeps the edges that end in the main part of a layout; all of them if no road leads back to
/// where it began.
fn keep_main_part(graph: &RouteGraph, ends: &mut Vec<EdgeIndex>) {
    let components = Components::strong(graph);
    let main = components.main(graph);
    if components.sizes.iter().any(|nodes| *nodes > 1) {
        ends.retain(|edge| components.of_node[graph.edge(*edge).destination.0 as usize] == main);
    }
}

/// Returns the number of edges that lead to each node.
fn arrivals(graph: &RouteGraph) -> Vec<u32> {
    let mut arrivals = vec![0; graph.nodes().len()];
    for edge in graph.edges() {
        arrivals[edge.destination.0 as usize] += 1;
    }
    arrivals
}

/// Returns the position of a robot at the end of an edge, and its heading as a unit vector.
fn end_pose(graph: &RouteGraph, tracks: &Tracks, edge: EdgeIndex) -> (DVec2, DVec2) {
    let track =
        tracks.track(Leg { edge, gear: Gear::Forward }).expect("every edge is driven forward");
    let piece = &tracks.pieces()[track.last_piece() as usize];
    let tangent = piece.derivative(0.0).as_dvec2().normalize_or(DVec2::X);
    let heading = match graph.edge(edge).orientation {
        Orientation::Tangential => tangent,
        Orientation::Offset(angle) => DVec2::from_angle(angle).rotate(tangent),
        Orientation::Fixed(angle) => DVec2::from_angle(angle),
    };
    (piece.position(0.0).as_dvec2(), heading)
}

#[cfg(test)]
mod tests {
    use regatta_layout::generate::Warehouse;
    use regatta_layout::{ReadOptions, Zone, ZoneRule, parse};
    use regatta_scenario::Shape;

    use super::*;
    use crate::arc_length;

    fn robot_type() -> RobotType {
        RobotType {
            name: "amr".into(),
            shape: Shape::Rectangle,
            length: 0.9,
            width: 0.6,
            max_speed: 1.0,
            max_acceleration: f32::INFINITY,
            max_rotation_speed: 0.0,
            max_rotation_acceleration: f32::INFINITY,
            battery: None,
        }
    }

    /// Fills a graph until there is no place left, and returns the places.
    fn fill(graph: &RouteGraph, seed: u64) -> Vec<EdgeIndex> {
        let (types, tracks) = ([robot_type()], arc_length::compile(graph));
        let mut places = StandingPlaces::new(graph, &types, seed);
        let all = std::iter::from_fn(|| places.take((graph, &tracks), (0, &types[0])));
        let edge = |place| match place {
            Placement::Edge(edge, s) => {
                assert_eq!(s, tracks.edge_length(edge) as f32);
                edge
            }
            Placement::Node(node) => panic!("on {node:?}"),
        };
        all.map(edge).collect()
    }

    #[test]
    fn robots_stand_apart_and_where_they_are_in_nobodys_way_first() {
        let text = Warehouse { aisles: 3, rows: 2, bays: 4 }.generate().expect("a warehouse");
        let (graph, _) = parse(&text, "warehouse.yaml", &ReadOptions::default()).expect("a graph");
        let (places, tracks) = (fill(&graph, 1), arc_length::compile(&graph));
        let footprint = |edge: &EdgeIndex| {
            let (position, heading) = end_pose(&graph, &tracks, *edge);
            Footprint::new(&robot_type(), position, heading)
        };
        let footprints: Vec<_> = places.iter().map(footprint).collect();
        for (number, one) in footprints.iter().enumerate() {
            assert!(
                footprints[..number].iter().all(|other| one.distance(other) >= MARGIN),
                "robot {number}"
            );
        }
        let untaken =
            (0..graph.edges().len() as u32).map(EdgeIndex).filter(|edge| !places.contains(edge));
        for edge in untaken {
            assert!(
                footprints.iter().any(|other| footprint(&edge).distance(other) < MARGIN),
                "{edge:?} is free"
            );
        }
        assert_eq!(places, fill(&graph, 1));
        assert_ne!(places, fill(&graph, 2));
        let is_simple =
            |edge: &EdgeIndex| arrivals(&graph)[graph.edge(*edge).destination.0 as usize] == 1;
        assert!(is_simple(&places[0]) && !places.iter().all(is_simple));
    }

    #[test]
    fn places_are_all_taken_only_where_no_seed_finds_more() {
        let are_all_taken = |graph: &RouteGraph, seed| {
            let (types, tracks) = ([robot_type()], arc_length::compile(graph));
            let mut places = StandingPlaces::new(graph, &types, seed);
            let room = std::iter::from_fn(|| places.take((graph, &tracks), (0, &types[0])));
            (room.count(), places.are_all_taken((graph, &tracks), &types))
        };
        let parsed = |text: &str| parse(text, "t.csv", &ReadOptions::default()).expect("a graph").0;
        let ring = parsed("id,x,y\nA,0,0\nB,9,0\nC,9,9\n\nfrom,to\nA,B\nB,C\nC,A\nB,A\n");
        assert_eq!(are_all_taken(&ring, 1), (3, true), "one robot at each node");
        let door = Zone {
            name: "door".into(),
            rule: ZoneRule::EXCLUSIVE,
            nodes: vec![NodeIndex(0), NodeIndex(1)],
            edges: Vec::new(),
            inner: Vec::new(),
        };
        assert_eq!(are_all_taken(&ring.with_zones(vec![door]), 1), (2, true), "a zone");
        // Three nodes in a row: that in the middle is too near to both others.
        let row = parsed("id,x,y\nA,0,0\nB,0.6,0\nC,1.2,0\nD,9,9\n\nfrom,to\nA,B\nB,C\nC,D\nD,A\n");
        let answers: Vec<_> = (0..16).map(|seed| are_all_taken(&row, seed)).collect();
        let most = answers.iter().map(|(room, _)| *room).max();
        for (room, are_all) in &answers {
            assert!(!are_all || Some(*room) == most, "{answers:?}");
        }
        assert!(answers.contains(&(2, false)) && answers.contains(&(3, true)), "{answers:?}");
    }

    #[test]
    fn no_zone_holds_more_robots_than_its_rule_allows() {
        let text = "id,x,y\nA,0,0\nB,9,0\nC,9,9\n\nfrom,to\nA,B\nB,C\nC,A\n";
        let (graph, _) = parse(text, "ring.csv", &ReadOptions::default()).expect("a graph");
        let door = Zone {
            name: "door".into(),
            rule: ZoneRule::EXCLUSIVE,
            nodes: vec![NodeIndex(0), NodeIndex(1)],
            edges: Vec::new(),
            inner: Vec::new(),
        };
        let graph = graph.with_zones(vec![door]);
        for seed in 0..8 {
            let ends: Vec<_> =
                fill(&graph, seed).iter().map(|edge| graph.edge(*edge).destination.0).collect();
            assert!(ends.len() == 2 && ends.contains(&2), "{seed}: {ends:?}");
        }
    }

    #[test]
    fn robots_stand_at_the_end_of_an_edge_whose_zone_is_full() {
        let text = "id,x,y\nA,0,0\nB,9,0\nC,9,9\n\nfrom,to\nA,B\nB,C\nC,A\n";
        let (graph, _) = parse(text, "ring.csv", &ReadOptions::default()).expect("a graph");
        let road = Zone {
            name: "road".into(),
            rule: ZoneRule::EXCLUSIVE,
            nodes: Vec::new(),
            edges: vec![EdgeIndex(0), EdgeIndex(1), EdgeIndex(2)],
            inner: Vec::new(),
        };
        let graph = graph.with_zones(vec![road]);
        for seed in 0..8 {
            assert_eq!(fill(&graph, seed).len(), 3, "{seed}");
        }
    }

    #[test]
    fn no_robot_stands_on_an_island() {
        let text = "id,x,y\nA,0,0\nB,9,0\nI,0,50\nJ,9,50\n\nfrom,to\nI,J\nA,B\nB,A\n";
        let (graph, _) = parse(text, "roads.csv", &ReadOptions::default()).expect("a graph");
        for seed in 0..8 {
            let mut places = fill(&graph, seed);
            places.sort_unstable();
            assert_eq!(places, [EdgeIndex(1), EdgeIndex(2)], "{seed}");
        }
    }
}
