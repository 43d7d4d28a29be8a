//! Generated graphs of any size can be driven without end, and are the same each time.

use glam::DVec2;
use proptest::prelude::*;
use regatta_layout::generate::{Grid, Warehouse};
use regatta_layout::model::components::Components;
use regatta_layout::{BackgroundLine, NodeIndex, ReadOptions, Role, RouteGraph};

#[track_caller]
fn parse(text: &str) -> RouteGraph {
    let (graph, warnings) =
        regatta_layout::parse(text, "generated", &ReadOptions::default()).unwrap();
    assert_eq!(warnings.as_slice(), []);
    graph
}

/// Asserts that the graph is strongly connected in forward gear, as random walks need it, and
/// without dead ends.
#[track_caller]
fn assert_drivable(graph: &RouteGraph) {
    let nodes = graph.nodes().len();
    for backwards in [false, true] {
        let mut next = vec![Vec::new(); nodes];
        for edge in graph.edges() {
            let (from, to) = (edge.origin.0, edge.destination.0);
            let (from, to) = if backwards { (to, from) } else { (from, to) };
            next[from as usize].push(to);
        }
        let (mut reached, mut open) = (vec![false; nodes], vec![0]);
        while let Some(node) = open.pop() {
            if !std::mem::replace(&mut reached[node as usize], true) {
                open.extend(&next[node as usize]);
            }
        }
        assert!(reached.into_iter().all(|reached| reached), "backwards: {backwards}");
    }
    assert!((0..nodes as u32).all(|node| !graph.departures(NodeIndex(node)).is_empty()));
    assert_eq!(Components::strong(graph).sizes.len(), 1);
}

#[test]
fn the_smallest_graphs_are_drivable() {
    assert_drivable(&parse(&Warehouse { aisles: 1, rows: 1, bays: 1 }.generate().unwrap()));
    for one_way in [false, true] {
        for (columns, rows) in [(2, 2), (2, 3), (3, 2), (3, 3)] {
            assert_drivable(&parse(
                &Grid { columns, rows, spacing: 10, one_way }.generate().unwrap(),
            ));
        }
    }
}

#[test]
fn large_graphs_have_the_expected_size() {
    let edges = |text: String| parse(&text).edges().len();
    assert!(edges(Warehouse { aisles: 60, rows: 6, bays: 6 }.generate().unwrap()) >= 4096);
    assert!(edges(Warehouse { aisles: 400, rows: 20, bays: 6 }.generate().unwrap()) >= 100_000);
    assert!(
        edges(Grid { columns: 80, rows: 80, spacing: 20, one_way: false }.generate().unwrap())
            >= 100_000
    );
}

#[test]
fn arguments_out_of_range_are_rejected() {
    let warehouse =
        |aisles, rows, bays| Warehouse { aisles, rows, bays }.generate().unwrap_err().to_string();
    assert_eq!(warehouse(0, 1, 1), "--aisles is 0: it must be 1 to 10000");
    assert!(warehouse(10_000, 10_000, 1000).contains("edges"));
    assert!(warehouse(2000, 1, 1).contains("m wide"));
    let grid = |columns, rows, spacing| {
        Grid { columns, rows, spacing, one_way: true }.generate().unwrap_err().to_string()
    };
    assert!(grid(1, 5, 20).contains("--columns is 1"));
    assert!(grid(2, 20, 1000).contains("m wide"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn warehouses_are_drivable_and_reproducible(aisles in 1u32..20, rows in 1u32..8, bays in 1u32..8) {
        let warehouse = Warehouse { aisles, rows, bays };
        let text = warehouse.generate().unwrap();
        prop_assert_eq!(&text, &warehouse.generate().unwrap());
        assert_drivable(&parse(&text));
        let with_chargers = parse(&warehouse.generate_with_chargers().unwrap());
        assert_drivable(&with_chargers);
        let chargers = with_chargers.nodes().iter().filter(|node| node.role == Role::Charge).count();
        prop_assert_eq!(chargers as u32, 2 * rows * (bays / 3));
    }

    #[test]
    fn grids_are_drivable(columns in 2u32..15, rows in 2u32..15, spacing in 10u32..60, one_way: bool) {
        assert_drivable(&parse(&Grid { columns, rows, spacing, one_way }.generate().unwrap()));
    }
}

#[test]
fn racks_stand_between_the_ways_and_the_floor_is_around_them() {
    let graph = parse(&Warehouse { aisles: 3, rows: 2, bays: 6 }.generate_with_chargers().unwrap());
    let [floor, racks @ ..] = graph.background() else { panic!("no background") };
    assert_eq!(racks.len(), 2 * 4 * 2, "an outline and the bays of each rack");
    let inside = |line: &BackgroundLine, point: DVec2| {
        let low = line.points.iter().copied().reduce(DVec2::min).unwrap();
        let high = line.points.iter().copied().reduce(DVec2::max).unwrap();
        point.cmpgt(low).all() && point.cmplt(high).all()
    };
    for edge in graph.edges() {
        for step in 0..=20 {
            let (point, _) = edge.path.at(f64::from(step) / 20.0);
            assert!(inside(floor, point), "{point} is on the floor");
            assert!(!racks.iter().any(|rack| inside(rack, point)), "{point} is in no rack");
        }
    }
}

#[test]
fn the_background_of_a_large_graph_stays_within_what_readers_get() {
    let graph = parse(&Warehouse { aisles: 400, rows: 20, bays: 20 }.generate().unwrap());
    let points: usize = graph.background().iter().map(|line| line.points.len()).sum();
    assert!(points < 250_000, "{points}");
    assert!(graph.background().len() > 8000, "racks");
}
