use std::path::PathBuf;

use glam::DVec2;
use proptest::prelude::*;

use super::{scen, scenario_yaml};
use crate::model::finding::Findings;
use crate::model::options::{Millimetres, ReadOptions};
use crate::model::route_graph::RouteGraph;
use crate::model::tags::Role;
use crate::read::parse;

fn sample(name: &str) -> String {
    let path =
        PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../graphs/imported/movingai"))
            .join(name);
    std::fs::read_to_string(path).expect("a sample")
}

fn graph(text: &str) -> (RouteGraph, Findings) {
    parse(text, "test.map", &ReadOptions::default()).expect("a map")
}

fn messages(findings: &Findings) -> String {
    findings.as_slice().iter().map(|finding| format!("{finding}\n")).collect()
}

#[test]
fn samples_have_a_node_for_each_free_cell() {
    let (empty, _) = graph(&sample("empty-8-8.map"));
    assert_eq!((empty.nodes().len(), empty.edges().len()), (64, 4 * 7 * 8));
    let text = sample("random-32-32-10.map");
    let (random, _) = graph(&text);
    assert_eq!(
        random.nodes().len(),
        text.lines().skip(4).map(|row| row.matches('.').count()).sum::<usize>()
    );
    assert_eq!((random.nodes().len(), random.edges().len()), (922, 3238));
}

#[test]
fn the_bottom_left_corner_is_the_origin() {
    let (map, _) = graph("type octile\nheight 2\nwidth 3\nmap\n.@.\n...\n");
    let position = |id| map.node(map.node_by_id(id).expect("a node")).position;
    assert_eq!(position(0), DVec2::new(0.5, 1.5));
    assert_eq!(position(3), DVec2::new(0.5, 0.5));
    assert_eq!(position(5), DVec2::new(2.5, 0.5));
    assert_eq!((map.nodes().len(), map.edges().len()), (5, 8));
    assert!(map.node_by_id(1).is_none());
    let options = ReadOptions { cell_size: Some(Millimetres(250)), ..ReadOptions::default() };
    let (small, _) =
        parse("type octile\nheight 1\nwidth 2\nmap\nGS", "test.map", &options).expect("a map");
    assert_eq!(small.nodes()[1].position, DVec2::new(0.375, 0.125));
}

#[test]
fn letters_of_the_league_of_robot_runners_are_roles() {
    let (map, findings) = graph("type octile\nheight 3\nwidth 5\nmap\n.....\nESS@E\n.....\n");
    assert_eq!(map.nodes().len(), 14, "{}", messages(&findings));
    let roles = [5, 6, 9].map(|id| map.node(map.node_by_id(id).expect("a node")).role);
    assert_eq!(roles, [Role::Drop, Role::Pick, Role::Drop]);
    // Without an `E`, `S` is a swamp.
    let (swamp, _) = graph("type octile\nheight 1\nwidth 2\nmap\n.S\n");
    assert!(swamp.nodes().iter().all(|node| node.role == Role::None));
}

#[test]
fn robots_stand_as_on_the_first_edge_that_leaves() {
    let (map, _) = graph("type octile\nheight 2\nwidth 2\nmap\n.@\n..\n");
    let theta: Vec<f64> = map.nodes().iter().map(|node| node.theta).collect();
    assert_eq!(theta, [-std::f64::consts::FRAC_PI_2, 0.0, std::f64::consts::PI]);
}

#[test]
fn deviations_are_reported() {
    let (map, findings) = graph("type tile\r\nwidth 3\r\nheight 3\r\nmap\r\n..x.\r\n..\r\n");
    assert_eq!((map.nodes().len(), map.edges().len()), (4, 8));
    let messages = messages(&findings);
    for part in ["cell `x`", "beyond the width", "shorter than the map", "2 rows of 3"] {
        assert!(messages.contains(part), "{part}: {messages}");
    }
}

#[test]
fn texts_that_are_no_maps_are_refused() {
    for text in [
        "type octile\nheight 0\nwidth 3\nmap\n",
        "type octile\nheight 99999999999\nwidth 3\nmap\n",
        "type octile\nmap\n...\n",
        "type octile\nheight 3\nwidth 3\n",
        "type octile\nheight 1\nwidth 3\nmap\n@@@\n",
        "version 1\n0\ta.map\t8\t8\t0\t0\t1\t1\t2\n",
        "type octile\nwidth 65536\nheight 65536\nmap\n",
    ] {
        assert!(parse(text, "test.map", &ReadOptions::default()).is_err(), "{text}");
    }
}

#[test]
fn cells_that_the_text_lacks_take_no_memory() {
    let text =
        format!("type octile\nheight 65536\nwidth 65536\nmap\n{}.\n.@\n..", "\n".repeat(65_533));
    let (map, findings) = graph(&text);
    let ids: Vec<u32> = map.nodes().iter().map(|node| node.id).collect();
    let last = 65_535 * 65_536;
    assert_eq!(ids, [last - 2 * 65_536, last - 65_536, last, last + 1]);
    assert_eq!(map.edges().len(), 6);
    assert!(
        messages(&findings)
            .contains("whose missing cells count as blocked: not used (65536 times)")
    );
}

#[test]
fn a_scenario_has_a_route_for_each_pair() {
    let entries = scen(&sample("random-32-32-10-random-1.scen")).expect("a scenario");
    assert_eq!(
        (entries[0].start, entries[0].goal, entries[0].size),
        ([11, 6], [7, 18], Some([32, 32]))
    );
    assert_eq!(
        (entries[0].map.as_str(), entries[0].length),
        ("random-32-32-10.map", 13.656_854_25)
    );
    let (map, _) = graph(&sample("random-32-32-10.map"));
    let scenario = scenario_yaml(&entries, "random-32-32-10.map", &map, 32, usize::MAX);
    assert_eq!(scenario.skipped, Vec::<String>::new());
    let robots: Vec<&str> =
        scenario.text.lines().filter(|line| line.starts_with("- route")).collect();
    assert_eq!(robots.len(), entries.len());
    let ids = robots[0].trim_start_matches("- route: [").trim_end_matches(']').split(", ");
    let mut node = map.node_by_id(6 * 32 + 11).expect("the start");
    let mut length = 0;
    for id in ids {
        let edge = map.edge(map.edge_by_id(id.parse().expect("an id")).expect("an edge"));
        assert_eq!(edge.origin, node);
        (node, length) = (edge.destination, length + 1);
    }
    assert_eq!((map.node(node).id, length), (18 * 32 + 7, 16));
}

#[test]
fn entries_without_a_path_are_skipped() {
    let (map, _) = graph("type octile\nheight 1\nwidth 5\nmap\n..@..\n");
    let text = "version 1.0\n0 m.map 5 1 0 0 1 0 1\n0 m.map 5 1 0 0 4 0 4\n0 m.map 1 0 1 0 0\n0 m.map 5 1 2 0 1 0 1\n0 m.map 6 1 0 0 1 0 1";
    let entries = scen(text).expect("a scenario");
    let scenario = scenario_yaml(&entries, "m.map", &map, 5, 10);
    assert_eq!(
        scenario.text,
        "graph: \"m.map\"\nrobots:\n- route: [1]\n  repeat: once\n- node: 1\n"
    );
    assert_eq!(scenario.skipped.len(), 3, "{:?}", scenario.skipped);
    assert!(scen("version 1\nnonsense\n").is_err() && scen("version 1\n").is_err());
}

proptest! {
    #[test]
    fn damaged_maps_and_scenarios_never_panic(cut in 0usize..110, at in 0usize..105, new in "\\PC{0,3}") {
        for name in ["empty-8-8.map", "random-32-32-10-random-1.scen"] {
            let mut text: String = sample(name).chars().take(105).collect();
            text.replace_range(at..at + 1, &new);
            let text: String = text.chars().take(cut).collect();
            let _ = parse(&text, "test.map", &ReadOptions::default());
            let _ = scen(&text);
        }
    }
}

/// Takes seconds in release, and gigabytes of memory: `cargo test --release -- --ignored`.
#[test]
#[ignore = "slow without optimization"]
fn the_largest_maps_are_read_in_seconds() {
    let text = format!(
        "type octile\nheight 1024\nwidth 2048\nmap\n{}",
        format!("{}\n", ".".repeat(2048)).repeat(1024)
    );
    let start = std::time::Instant::now();
    let (map, _) = graph(&text);
    assert_eq!((map.nodes().len(), map.edges().len()), (1 << 21, 2 * (1023 * 2048 + 1024 * 2047)));
    println!("1024 × 2048 cells in {:.1} s", start.elapsed().as_secs_f64());
}
