//! Random small layouts and robots.

use glam::DVec2;
use proptest::prelude::*;
use regatta_base::bezier::CubicBezier;

use crate::model::route_graph::{Edge, Node, RouteGraph};
use crate::model::tags::{Role, Station};
use crate::traffic::{RobotType, Turning};
use crate::{NodeIndex, Orientation};

/// A road between two nodes.
#[derive(Clone, Copy, Debug)]
pub enum Road {
    OneWay,
    /// Two edges on one line.
    TwoWay,
    /// An edge with reverse gear.
    Reverse,
    /// Two edges that bow apart, each by this share of the distance of their ends.
    Bow(f64),
    /// An edge on which robots keep this heading.
    Sideways(f64),
}

fn road() -> impl Strategy<Value = Road> {
    prop_oneof![
        4 => Just(Road::OneWay),
        5 => Just(Road::TwoWay),
        2 => Just(Road::Reverse),
        2 => (0.03..0.5).prop_map(Road::Bow),
        1 => (-3.0..3.0).prop_map(Road::Sideways),
    ]
}

/// A robot type of 0.2 to 2 m; one of four is round.
pub fn robot() -> impl Strategy<Value = RobotType> {
    let is_round = prop::bool::weighted(0.25);
    (0.2..2.0, 0.2..1.2, any::<bool>(), is_round).prop_map(|(length, width, turns, is_round)| {
        let turning = if turns { Turning::OnTheSpot } else { Turning::Never };
        let robot = match is_round {
            true => RobotType::round(length, turning),
            false => RobotType::new(length, width, turning),
        };
        robot.expect("within the range")
    })
}

/// A layout of 4 to 9 nodes: each is joined with an earlier one, mostly, and some further roads.
pub fn layout() -> impl Strategy<Value = RouteGraph> {
    let node = (0_u32..12, 0_u32..12, 0_u32..4, prop::bool::weighted(0.3));
    let join = (any::<prop::sample::Index>(), any::<bool>(), road(), prop::bool::weighted(0.9));
    let nodes = prop::collection::vec((node, join), 4..10);
    let any_node = any::<prop::sample::Index>;
    let more = prop::collection::vec((any_node(), any_node(), road()), 0..7);
    // Metres between the nodes: some are close, or none; and two-way roads, or none.
    let spacing = prop_oneof![Just(1.5), Just(6.0)];
    let is_loop = prop::bool::weighted(0.25);
    (nodes, more, spacing, any::<bool>(), is_loop).prop_map(build)
}

/// A node with its place and role, and the road that joins it with an earlier one.
type Drawn = ((u32, u32, u32, bool), (prop::sample::Index, bool, Road, bool));
/// A further road.
type More = (prop::sample::Index, prop::sample::Index, Road);

fn build(
    (nodes, more, spacing, is_one_way, is_loop): (Vec<Drawn>, Vec<More>, f64, bool, bool),
) -> RouteGraph {
    let mut roads = Vec::new();
    for (index, (_, (other, flipped, road, is_joined))) in nodes.iter().enumerate().skip(1) {
        let other = if is_loop { index - 1 } else { other.index(index) };
        let ends = if *flipped && !is_loop { (index, other) } else { (other, index) };
        roads.extend(is_joined.then_some((ends.0, ends.1, *road)));
    }
    let count = nodes.len();
    roads.extend(is_loop.then_some((count - 1, 0, Road::OneWay)));
    roads.extend(more.iter().map(|(a, b, road)| (a.index(count), b.index(count), *road)));
    for (_, _, road) in roads.iter_mut().filter(|_| is_one_way) {
        *road = Road::OneWay;
    }
    let places = nodes.iter().map(|((x, y, shift, is_station), _)| {
        // Nodes beside the grid, so that few coincide.
        let shift = f64::from(*shift) * 0.37;
        let place = spacing * DVec2::new(f64::from(*x), f64::from(*y)) + DVec2::new(shift, -shift);
        (place, *is_station)
    });
    graph(&places.collect::<Vec<_>>(), &roads)
}

/// Makes a graph of places, some with a role, and roads between them.
pub fn graph(places: &[(DVec2, bool)], roads: &[(usize, usize, Road)]) -> RouteGraph {
    let mut nodes = Vec::new();
    let mut stations = Vec::new();
    for (id, &(place, is_station)) in (0..).zip(places) {
        let role = if is_station && id % 2 == 0 { Role::Pick } else { Role::None };
        nodes.push(Node { role, ..Node::new(id, place, 0.0) });
        if is_station && id % 2 == 1 {
            let (name, nodes) = (format!("Dock {id}"), vec![NodeIndex(id)]);
            stations.push(Station { name, role: Role::Drop, nodes, ..Station::default() });
        }
    }
    let mut edges: Vec<Edge> = Vec::new();
    // Readers refuse roads without a length.
    let has_length = |from: usize, to: usize| places[from].0.distance(places[to].0) > 1e-3;
    for &(from, to, road) in roads.iter().filter(|(from, to, _)| has_length(*from, *to)) {
        for edge in edges_of(places, from, to, road) {
            edges.push(Edge { id: edges.len() as u32, ..edge });
        }
    }
    if edges.is_empty() {
        edges.extend(edges_of(places, 0, 1, Road::TwoWay));
    }
    RouteGraph::from_valid_parts(nodes, edges).with_surroundings(stations, Vec::new())
}

fn edges_of(places: &[(DVec2, bool)], from: usize, to: usize, road: Road) -> Vec<Edge> {
    let forth = edge(places, from, to, 0.0);
    match road {
        Road::OneWay => vec![forth],
        Road::TwoWay => vec![forth, edge(places, to, from, 0.0)],
        Road::Reverse => vec![Edge { reverse_speed: Some(0.5), ..forth }],
        Road::Bow(share) => vec![edge(places, from, to, share), edge(places, to, from, share)],
        Road::Sideways(heading) => {
            vec![Edge { orientation: Orientation::Fixed(heading), ..forth }]
        }
    }
}

/// Returns an edge that bows to the right by a share of the distance of its ends.
fn edge(places: &[(DVec2, bool)], from: usize, to: usize, bow: f64) -> Edge {
    let [start, end] = [from, to].map(|node| places[node].0);
    let CubicBezier { control_points: [p0, p1, p2, p3] } = CubicBezier::straight(start, end);
    let aside = -(end - start).perp() * bow * 4.0 / 3.0;
    let curve = CubicBezier { control_points: [p0, p1 + aside, p2 + aside, p3] };
    Edge::new(0, NodeIndex(from as u32), NodeIndex(to as u32), curve, 1.0)
}
