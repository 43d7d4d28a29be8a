//! The table of conflicts against brute force: poses that touch are in it.

use proptest::prelude::*;
use regatta_base::bezier::{CubicBezier, Side};
use regatta_base::sweep::Rectangle;
use regatta_plugin::world::{
    CurveRecord, EdgeRecord, NodeRecord, Orientation, RobotTypeRecord, WorldData,
};

use super::*;
use crate::model::worlds;

/// Points by arc length along the curve of an edge.
struct Line {
    cubic: CubicBezier,
    /// Arc length at each of equally spaced parameters.
    lengths: Vec<f64>,
}

impl Line {
    const PARTS: usize = 400;

    fn new(curve: &CurveRecord) -> Self {
        let cubic = CubicBezier { control_points: control_points(curve) };
        let mut lengths = vec![0.0];
        for part in 0..Self::PARTS {
            let at = |part: usize| part as f64 / Self::PARTS as f64;
            lengths.push(lengths[part] + cubic.length_between(at(part), at(part + 1)));
        }
        Self { cubic, lengths }
    }

    fn length(&self) -> f64 {
        self.lengths[Self::PARTS]
    }

    /// The outline of a robot at a distance from the origin.
    fn outline(&self, s: f64, orientation: Orientation, footprint: &Footprint) -> Rectangle {
        let part = self.lengths.partition_point(|length| *length < s).clamp(1, Self::PARTS);
        let (low, high) = (self.lengths[part - 1], self.lengths[part]);
        let share = if high > low { (s - low) / (high - low) } else { 0.0 };
        let t = (part as f64 - 1.0 + share) / Self::PARTS as f64;
        let tangent = self.cubic.tangent(t, Side::After);
        let heading = orientation.heading(tangent.y.atan2(tangent.x) as f32);
        footprint.at(self.cubic.position(t).as_vec2(), Vec2::from_angle(heading))
    }
}

/// Whether the table says that robots at two places may touch.
fn is_conflict(roads: &Roads, footprints: [usize; 2], [(a, s), (b, t)]: [(u32, f32); 2]) -> bool {
    if a == b {
        return (s - t).abs() < roads.conflicts().table(footprints[0], footprints[1]).separation(a);
    }
    roads.conflicts().of(footprints[0], footprints[1], a).filter(|(track, _)| *track == b).any(
        |(_, relation)| match relation {
            Relation::Crossing { own, other } => own.contains(s) && other.contains(t),
            Relation::Into(apart) => roads.edge(a).length - s + t < apart,
            Relation::From(apart) => roads.edge(b).length - t + s < apart,
        },
    )
}

fn point() -> impl Strategy<Value = [f32; 2]> {
    [0.0_f32..8.0, 0.0_f32..8.0]
}

fn orientation() -> impl Strategy<Value = Orientation> {
    prop_oneof![
        4 => Just(Orientation::Tangential),
        1 => (-3.0_f32..3.0).prop_map(Orientation::Offset),
        1 => (-3.0_f32..3.0).prop_map(Orientation::Fixed),
    ]
}

fn round(diameter: f32) -> RobotTypeRecord {
    RobotTypeRecord { shape: Shape::Circle as u32, ..RobotTypeRecord::new("", diameter, diameter) }
}

/// A world of nodes at random places, and edges between them: straight, or with random handles.
fn world() -> impl Strategy<Value = WorldData> {
    let edge = (0_u32..6, 0_u32..6, proptest::option::of([point(), point()]), orientation());
    let size = || (0.1_f32..1.5, 0.1_f32..1.0, any::<bool>());
    let sizes = [size(), size()];
    (proptest::collection::vec(point(), 6), proptest::collection::vec(edge, 2..7), sizes).prop_map(
        |(nodes, edges, sizes)| {
            let records =
                nodes.iter().map(|&[x, y]| NodeRecord { x, y, ..NodeRecord::default() }).collect();
            let mut world = WorldData { nodes: records, ..WorldData::default() };
            for (origin, destination, handles, orientation) in edges {
                let [from, to] = [origin, destination].map(|node| nodes[node as usize]);
                let curve = match handles {
                    Some([a, b]) => CurveRecord { control_points: [from, a, b, to] },
                    None if origin == destination => continue,
                    None => CurveRecord::straight(from, to),
                };
                let record =
                    EdgeRecord { origin, destination, speed: 1.0, ..EdgeRecord::default() };
                world.add_edge(record.with_orientation(orientation), [curve]);
            }
            world.robot_types = sizes
                .map(|(length, width, is_round)| match is_round {
                    true => round(length),
                    false => RobotTypeRecord::new("", length, width),
                })
                .to_vec();
            world
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    /// Poses that touch are in the table, for all pairs of footprints, on the same edge and on
    /// different ones.
    #[test]
    fn poses_that_touch_are_in_the_table(data in world(), places in proptest::collection::vec((0.0_f64..1.0, 0.0_f64..1.0), 40)) {
        let world = data.view(1, 1);
        let roads = Roads::new(&world);
        let lines: Vec<Line> = world.edges().iter().map(|edge| Line::new(&world.curves(edge)[0])).collect();
        let outline = |edge: usize, s: f64, footprint: usize| {
            lines[edge].outline(s, world.edges()[edge].orientation(), &roads.footprints()[footprint])
        };
        let footprints = roads.footprints().len();
        for (a, b) in (0..lines.len()).flat_map(|a| (0..lines.len()).map(move |b| (a, b))) {
            for &(s, t) in &places {
                let (s, t) = (s * lines[a].length(), t * lines[b].length());
                for (own, other) in (0..footprints).flat_map(|own| (0..footprints).map(move |other| (own, other))) {
                    if outline(a, s, own).touches(&outline(b, t, other)) {
                        let places = [(a as u32, s as f32), (b as u32, t as f32)];
                        prop_assert!(is_conflict(&roads, [own, other], places), "{places:?}, footprints {own} and {other}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_straight_road_keeps_robots_a_length_apart() {
    let nodes =
        (0..4).map(|place| NodeRecord { x: 5.0 * place as f32, ..NodeRecord::default() }).collect();
    let mut data = WorldData { nodes, ..WorldData::default() };
    for origin in 0..3 {
        let curve =
            CurveRecord::straight([5.0 * origin as f32, 0.0], [5.0 * origin as f32 + 5.0, 0.0]);
        let edge =
            EdgeRecord { origin, destination: origin + 1, speed: 1.0, ..EdgeRecord::default() };
        data.add_edge(edge, [curve]);
    }
    data.robot_types = vec![RobotTypeRecord::new("", 0.9, 0.6)];
    let roads = Roads::new(&data.view(1, 1));
    let separation = roads.conflicts().table(0, 0).separation(1);
    // The length, a margin of 3 mm at both ends of both robots, and what the table rounds by.
    assert!((separation - (0.906 + RESOLUTION)).abs() < 1e-4, "{separation}");
    let relations: Vec<_> = roads.conflicts().of(0, 0, 1).collect();
    let [(0, Relation::From(behind)), (2, Relation::Into(ahead))] = relations[..] else {
        panic!("{relations:?}")
    };
    assert!((0.9..0.95).contains(&behind) && (0.9..0.95).contains(&ahead), "{relations:?}");
    assert_eq!(
        roads.stops(0).last_open(Leg::new(1, false), 5.0, 0.0, 5.0),
        Some(5.0),
        "nobody is blocked there"
    );
}

/// A road, and a place 1 m beside it where robots turn: discs of 0.9 m clear each other by 0.1 m.
#[test]
fn a_disc_beside_a_road_is_in_nobodys_way() {
    let conflicts = |robot: RobotTypeRecord| {
        let mut data = WorldData::default();
        let points = [[0.0, 0.0], [10.0, 0.0], [2.0, 4.0], [5.0, 1.0], [8.0, 4.0]];
        data.nodes =
            points.iter().map(|&[x, y]| NodeRecord { x, y, ..NodeRecord::default() }).collect();
        for (origin, destination) in [(0, 1), (2, 3), (3, 4)] {
            let [from, to] = [origin, destination].map(|node: u32| points[node as usize]);
            let edge = EdgeRecord { origin, destination, speed: 1.0, ..EdgeRecord::default() };
            data.add_edge(edge, [CurveRecord::straight(from, to)]);
        }
        data.robot_types = vec![RobotTypeRecord { max_rotation_speed: 1.0, ..robot }];
        let roads = Roads::new(&data.view(1, 1));
        let tracks: Vec<u32> = roads.conflicts().of(0, 0, 0).map(|(track, _)| track).collect();
        (tracks, roads.conflicts().of(0, 0, 1).count())
    };
    assert_eq!(conflicts(round(0.9)), (vec![], 2), "the other edge, and turns at its end");
    let (tracks, _) = conflicts(RobotTypeRecord::new("", 0.9, 0.9));
    assert_eq!(tracks, [1, 2, 6], "both edges, and turns where they meet");
}

#[test]
fn robots_longer_than_edges_keep_their_length_apart() {
    let point = |place: u32| [5.0 * place as f32, 0.0];
    let nodes = (0..9).map(|place| NodeRecord { x: point(place)[0], ..NodeRecord::default() });
    let mut data = WorldData { nodes: nodes.collect(), ..WorldData::default() };
    for origin in 0..8 {
        let edge =
            EdgeRecord { origin, destination: origin + 1, speed: 1.0, ..EdgeRecord::default() };
        data.add_edge(edge, [CurveRecord::straight(point(origin), point(origin + 1))]);
    }
    for length in [7.9, 8.0, 18.0, 29.0] {
        data.robot_types = vec![RobotTypeRecord::new("", length, 1.0)];
        let roads = Roads::new(&data.view(1, 1));
        for (track, relation) in roads.conflicts().of(0, 0, 0) {
            let Relation::Into(apart) = relation else { panic!("{relation:?}") };
            let between = 5.0 * (track - 1) as f32;
            assert!(between + apart >= length, "{length} m, edge {track}: {relation:?}");
        }
    }
}

#[test]
fn robots_wait_before_a_crossing_and_not_in_it() {
    let mut data = WorldData::default();
    let points = [[-5.0, 0.0], [5.0, 0.0], [0.0, -5.0], [0.0, 5.0]];
    data.nodes =
        points.iter().map(|&[x, y]| NodeRecord { x, y, ..NodeRecord::default() }).collect();
    for (origin, destination) in [(0, 1), (2, 3)] {
        let curve = CurveRecord::straight(points[origin as usize], points[destination as usize]);
        let edge = EdgeRecord { origin, destination, speed: 1.0, ..EdgeRecord::default() };
        data.add_edge(edge, [curve]);
    }
    data.robot_types = vec![RobotTypeRecord::new("", 0.9, 0.6)];
    let roads = Roads::new(&data.view(1, 1));
    let relations: Vec<_> = roads.conflicts().of(0, 0, 0).collect();
    let [(1, Relation::Crossing { own, .. })] = relations[..] else { panic!("{relations:?}") };
    // Half of the one's length and half of the other's width, rounded outwards.
    assert!((4.0..4.25).contains(&own.low) && (5.75..6.0).contains(&own.high), "{own:?}");
    let before = roads.stops(0).last_open(Leg::new(0, false), 10.0, 0.0, 5.0);
    assert!(before.is_some_and(|place| place < own.low && place > own.low - 0.1), "{before:?}");
    let behind = roads.stops(0).next_open(Leg::new(0, true), 10.0, 5.0);
    assert!(behind.is_some_and(|place| place > 10.0 - own.low), "{behind:?}, in reverse gear");
    for (node, name) in data.nodes.iter_mut().zip(["L1", "L1", "L2", "L2"]) {
        node.level = data.texts.add(name);
    }
    let roads = Roads::new(&data.view(1, 1));
    assert!(roads.conflicts().is_empty(), "a bridge leads over the other road");
}

/// An aisle of three edges between two streets of short edges, joined by corners.
#[test]
fn aisles_are_reservoirs_and_junctions_are_not() {
    let mut world =
        WorldData { robot_types: vec![RobotTypeRecord::new("", 0.9, 0.6)], ..WorldData::default() };
    let places = [
        [0.0, 0.0],
        [2.0, 0.0],
        [4.0, 0.0],
        [2.0, 4.0],
        [2.0, 8.0],
        [2.0, 12.0],
        [0.0, 12.0],
        [4.0, 12.0],
    ];
    for (id, [x, y]) in (0..).zip(places) {
        world.nodes.push(NodeRecord { id, x, y, ..NodeRecord::default() });
    }
    for (id, (origin, destination)) in
        (0..).zip([(0, 1), (1, 2), (1, 3), (3, 4), (4, 5), (6, 5), (5, 7)])
    {
        let [from, to] = [origin, destination].map(|node: u32| places[node as usize]);
        let length = (to[0] - from[0]).hypot(to[1] - from[1]);
        let edge =
            EdgeRecord { id, origin, destination, length, speed: 1.0, ..EdgeRecord::default() };
        world.add_edge(edge, [CurveRecord::straight(from, to)]);
    }
    let roads = Roads::new(&world.view(1, 1));
    let reservoirs: Vec<u32> = (0..7).filter(|edge| roads.is_reservoir(*edge)).collect();
    assert_eq!(reservoirs, [2, 3, 4]);
}

#[test]
fn dead_ends_of_two_sections_or_more_are_stubs() {
    let stubs = |world: &WorldData| {
        let roads = Roads::new(&world.view(1, 1));
        let numbers = (0..roads.edges().len() as u32).map(|edge| roads.stubs().of(edge));
        (numbers.collect::<Vec<_>>(), roads)
    };
    let (numbers, roads) = stubs(&worlds::ring_with_stub(3));
    assert_eq!(
        numbers,
        [[None; 8].as_slice(), &[Some(0); 6]].concat(),
        "the ring, and three sections"
    );
    assert_eq!(roads.stubs().edges(0), [8, 9, 10, 11, 12, 13]);
    assert_eq!(
        stubs(&worlds::ring_with_stub(1)).0,
        [None; 10],
        "nobody could stand before another robot"
    );
    assert_eq!(stubs(&worlds::streets(4, 6.0, false)).0, [None; 24]);
    let line = [[0.0, 0.0], [5.0, 0.0], [10.0, 0.0], [15.0, 0.0]];
    let edges = [[0, 1], [1, 0], [1, 2], [2, 1], [2, 3], [3, 2]];
    let line = worlds::straight(&line, &edges, [0.9, 0.6], Orientation::Fixed(0.0));
    assert_eq!(stubs(&line).0, [None; 6], "a track without a way round leads nowhere else");
}

#[test]
fn a_robot_comes_to_a_node_in_reverse_gear_where_no_edge_leads() {
    let mut world = worlds::straight(
        &[[0.0, 0.0], [9.0, 0.0], [18.0, 0.0]],
        &[[0, 1], [1, 2], [2, 1]],
        [0.9, 0.6],
        Orientation::Tangential,
    );
    assert_eq!(Roads::new(&world.view(1, 1)).arrival(0), None);
    world.edges[0].reverse_speed = 0.5;
    let roads = Roads::new(&world.view(1, 1));
    assert_eq!(roads.arrival(0), Some(Leg::new(0, true)));
    assert_eq!(roads.arrival(1), Some(Leg::new(2, false)));
}
