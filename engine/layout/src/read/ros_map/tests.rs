use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use glam::DVec2;
use proptest::prelude::*;

use super::background;
use super::grid::{Cell, Grid, MapFile};
use crate::model::finding::{Findings, Report};
use crate::model::options::{Millimetres, ReadOptions};
use crate::model::route_graph::RouteGraph;
use crate::read::file::{GraphError, Ignored};
use crate::read::read;

fn sample() -> PathBuf {
    PathBuf::from(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../graphs/imported/ros-map/turtlebot3_world.yaml"
    ))
}

fn roadmap(path: &Path, width: u32) -> Result<(RouteGraph, Findings), GraphError> {
    read(path, &ReadOptions { skeleton: Some(Millimetres(width)), ..ReadOptions::default() })
}

fn grid(path: &Path) -> Grid {
    let text = std::fs::read_to_string(path).expect("a map");
    let map = MapFile::read(&text, &mut Ignored::default()).expect("a map");
    Grid::read(&map, path.parent().expect("a folder")).expect("a picture")
}

/// Writes a map of rows from the top: `.` free, `#` occupied, `?` unknown. Returns the path of its
/// YAML.
fn write(folder: &Path, resolution: f64, rows: &[String], extra: &str) -> PathBuf {
    let mut picture = format!("P2\n{} {}\n255\n", rows[0].len(), rows.len());
    for cell in rows.iter().flat_map(|row| row.chars()) {
        let brightness = match cell {
            '.' => 254,
            '#' => 0,
            _ => 205,
        };
        writeln!(picture, "{brightness}").expect("text");
    }
    std::fs::write(folder.join("map.pgm"), picture).expect("a file");
    let yaml = format!(
        "image: map.pgm\nresolution: {resolution}\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n{extra}"
    );
    std::fs::write(folder.join("map.yaml"), yaml).expect("a file");
    folder.join("map.yaml")
}

/// Returns the least distance in metres between points of the roadmap, 5 cm apart, and cells that
/// aren't free.
fn least_clearance(graph: &RouteGraph, grid: &Grid, reach: f64) -> f64 {
    let mut least = f64::INFINITY;
    let corner = grid.metres(DVec2::ZERO);
    for edge in graph.edges() {
        for cubic in edge.path.cubics() {
            let count = (cubic.length() / 0.05).ceil().max(1.0) as u32;
            for index in 0..=count {
                let point = graph.origin() + cubic.position(f64::from(index) / f64::from(count));
                least = least.min(clearance(
                    (point - corner) / grid.resolution,
                    grid,
                    reach / grid.resolution,
                ));
            }
        }
    }
    least * grid.resolution
}

/// Returns the distance in cells of a point from the nearest square that isn't free, if that is
/// within a distance.
fn clearance(point: DVec2, grid: &Grid, reach: f64) -> f64 {
    let mut least = reach;
    let range = |at: f64, count: usize| {
        (at - reach).max(0.0) as usize..((at + reach) as usize + 1).min(count)
    };
    for row in range(point.y, grid.height) {
        for column in range(point.x, grid.width) {
            if grid.cells[row * grid.width + column] != Cell::Free {
                let min = DVec2::new(column as f64, row as f64);
                least = least.min(point.distance(point.clamp(min, min + DVec2::ONE)));
            }
        }
    }
    least
}

/// A closed room of free cells around another free space.
fn room(
    columns: std::ops::Range<usize>,
    rows: std::ops::Range<usize>,
) -> impl Fn(usize, usize) -> bool {
    move |column, row| columns.contains(&column) && rows.contains(&row)
}

fn picture(width: usize, height: usize, is_free: impl Fn(usize, usize) -> bool) -> Vec<String> {
    let cell = |column, row| if is_free(column, row) { '.' } else { '#' };
    (0..height).map(|row| (0..width).map(|column| cell(column, row)).collect()).collect()
}

#[test]
fn areas_whose_skeleton_is_a_point_are_told_with_their_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let square = room(2..48, 2..48);
    let path = write(folder.path(), 0.1, &picture(50, 50, &square), "");
    let alone = roadmap(&path, 600).expect_err("no road").to_string();
    assert!(alone.contains("is about as long as wide"), "{alone}");

    let corridor = room(60..190, 20..30);
    let both = |column, row| square(column, row) || corridor(column, row);
    let path = write(folder.path(), 0.1, &picture(200, 50, both), "");
    let (graph, findings) = roadmap(&path, 600).expect("a roadmap");
    assert!(graph.edges().len() >= 2);
    let told = findings
        .as_slice()
        .iter()
        .any(|finding| finding.message.contains("is about as long as wide"));
    assert!(told, "{findings:?}");

    let path = write(folder.path(), 0.1, &picture(200, 50, corridor), "");
    let (_, findings) = roadmap(&path, 600).expect("a roadmap");
    let told = findings.as_slice().iter().any(|finding| finding.message.contains("free area"));
    assert!(!told, "{findings:?}");
}

#[test]
fn a_map_without_a_width_has_no_graph() {
    let error = read(&sample(), &ReadOptions::default()).expect_err("no graph").to_string();
    assert!(error.contains("--skeleton WIDTH") && error.contains("--background"), "{error}");
}

/// Returns what is told about passages of a map of two corridors, with a throat of some cells
/// between them.
fn told_of_throat(resolution: f64, cells: usize, robot: u32) -> (usize, Vec<String>) {
    let folder = tempfile::tempdir().expect("a folder");
    let rooms = [room(2..42, 2..12), room(60..100, 2..12), room(42..60, 5..5 + cells)];
    let free = |column, row| rooms.iter().any(|room| room(column, row));
    let path = write(folder.path(), resolution, &picture(102, 14, free), "");
    let (graph, findings) = roadmap(&path, robot).expect("a roadmap");
    let told = findings.as_slice().iter().map(|finding| finding.message.clone());
    (graph.nodes().len(), told.filter(|told| told.contains("passages")).collect())
}

#[test]
fn throats_that_are_too_narrow_for_the_cells_are_told() {
    let (_, told) = told_of_throat(0.25, 4, 600);
    let [throat] = &told[..] else { panic!("{told:?}") };
    assert!(throat.starts_with("passages of less than 1.45 m may have no road"), "{throat}");
    assert!(throat.contains("aren't connected, though such a robot fits through"), "{throat}");
    let (_, told) = told_of_throat(0.25, 6, 600);
    assert!(told.len() == 1 && !told[0].contains("aren't connected"), "{told:?}");
    let (_, told) = told_of_throat(0.25, 2, 600);
    assert!(!told[0].contains("aren't connected"), "a robot doesn't fit through: {told:?}");
    assert_eq!(told_of_throat(0.05, 8, 200).1, [""; 0], "a road leads through");
}

#[test]
fn the_sample_becomes_a_roadmap_that_keeps_its_distance() {
    let (graph, findings) = roadmap(&sample(), 300).expect("a roadmap");
    let length: f64 = graph.edges().iter().map(|edge| edge.path.length()).sum::<f64>() / 2.0;
    println!(
        "{} nodes, {} edges, {length:.1} m, {} outlines",
        graph.nodes().len(),
        graph.edges().len(),
        graph.background().len()
    );
    findings.as_slice().iter().take(5).for_each(|finding| println!("{finding}"));
    let least = least_clearance(&graph, &grid(&sample()), 1.0);
    println!("clearance {least:.3} m");
    assert!(least >= 0.15, "{least}");
    assert!(length > 15.0 && graph.edges().len() > 20);
}

#[test]
fn outlines_are_where_the_map_is_occupied() {
    let lines = background(&sample()).expect("a map");
    // The world of the sample is 5 m across, in the middle of its map.
    assert!(lines.iter().flatten().all(|point| point.abs().max_element() < 4.0));
    assert!(lines.iter().all(|line| line.first() == line.last()));
    let folder = tempfile::tempdir().expect("a folder");
    let rows = ["....", ".##.", ".#.#", "...."].map(str::to_owned);
    let lines = background(&write(folder.path(), 0.5, &rows, "")).expect("a map");
    let points =
        |line: &[(f64, f64)]| line.iter().map(|&(x, y)| DVec2::new(x, y)).collect::<Vec<_>>();
    assert_eq!(
        lines[0],
        points(&[
            (0.5, 0.5),
            (1.0, 0.5),
            (1.0, 1.0),
            (1.5, 1.0),
            (1.5, 1.5),
            (0.5, 1.5),
            (0.5, 0.5)
        ])
    );
    assert_eq!(lines[1], points(&[(1.5, 0.5), (2.0, 0.5), (2.0, 1.0), (1.5, 1.0), (1.5, 0.5)]));
    assert!(background(&folder.path().join("none.yaml")).is_err());
}

#[test]
fn a_corridor_with_a_branch_has_its_roads_in_the_middle() {
    let folder = tempfile::tempdir().expect("a folder");
    // Two corridors of 2.1 m that cross at (10, 5), and a closet too far from the others.
    let inside = |x: usize, y: usize| {
        (x.abs_diff(100) <= 10 && y >= 2)
            || (y.abs_diff(50) <= 10 && (2..198).contains(&x))
            || (x < 30 && y > 80 && x > 10 && y < 95)
    };
    let row =
        |y: usize| (0..200).map(|x| if inside(x, 99 - y) { '.' } else { '#' }).collect::<String>();
    let rows: Vec<String> = (0..100).map(row).collect();
    let path = write(folder.path(), 0.1, &rows, "made_by: hand\n");
    let (graph, findings) = roadmap(&path, 800).expect("a roadmap");
    assert_eq!((graph.nodes().len(), graph.edges().len()), (5, 8), "{:?}", graph.nodes());
    let messages: String =
        findings.as_slice().iter().map(|finding| format!("{finding}\n")).collect();
    assert!(messages.contains("left out") && messages.contains("key `made_by`"), "{messages}");
    let centre = DVec2::new(10.05, 5.05);
    assert!(
        graph.nodes().iter().any(|node| node.position.distance(centre) < 0.3),
        "{:?}",
        graph.nodes()
    );
    assert!(least_clearance(&graph, &grid(&path), 2.0) >= 0.4);
    let wide = roadmap(&path, 3000).expect_err("too wide").to_string();
    assert!(wide.contains("a robot of 3000 mm"), "{wide}");
}

#[test]
fn rotated_and_negated_maps_are_understood() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = write(folder.path(), 1.0, &["#?.".to_owned()], "");
    assert_eq!(grid(&path).cells[6..9], [Cell::Occupied, Cell::Unknown, Cell::Free]);
    let yaml =
        "image: map.pgm\nresolution: 1.0\norigin: [5, 6, 1.5707963267948966]\nnegate: true\n";
    std::fs::write(&path, yaml).expect("a file");
    let grid = grid(&path);
    assert_eq!(grid.cells[6..9], [Cell::Free, Cell::Occupied, Cell::Occupied]);
    assert!(grid.metres(DVec2::new(2.0, 1.0)).distance(DVec2::new(5.0, 7.0)) < 1e-12);
}

#[test]
fn broken_maps_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("map.yaml");
    std::fs::write(folder.path().join("bomb.pgm"), "P5\n60000 60000\n255\n").expect("a file");
    for yaml in [
        "image: none.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n",
        "image: bomb.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n",
        "image: bomb.pgm\nresolution: 0\norigin: [0, 0, 0]\n",
        "image: bomb.pgm\nresolution: 0.05\norigin: [0]\n",
        "image: map.yaml\nresolution: 0.05\norigin: [.nan, 0, 0]\n",
        "image: map.yaml\nresolution: 0.05\norigin: [0, 0, 0]\n",
        "image: [1]\nresolution: 0.05\norigin: [0, 0, 0]\n",
    ] {
        std::fs::write(&path, yaml).expect("a file");
        assert!(roadmap(&path, 500).is_err(), "{yaml}");
        assert!(background(&path).is_err(), "{yaml}");
    }
}

/// A map with an unknown key `1`, and `levels` unknown lists `a0`, `a1` …, each of ten aliases of
/// the one before.
fn map_with_aliases(levels: usize) -> String {
    let mut text = "image: map.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n1: 2\n".to_owned();
    text += "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
    for level in 1..levels {
        let aliases = vec![format!("*a{}", level - 1); 10].join(", ");
        text += &format!("a{level}: &a{level} [{aliases}]\n");
    }
    text
}

#[test]
fn unknown_keys_are_reported() {
    let text = map_with_aliases(4);
    let mut ignored = Ignored::default();
    MapFile::read(&text, &mut ignored).expect("a map");
    let mut report = Report::new("map.yaml", &text);
    ignored.report(&mut report);
    let messages: String =
        report.into_findings().as_slice().iter().map(|finding| format!("{finding}\n")).collect();
    assert!(
        messages.contains("key `1` of the map: not used") && messages.lines().count() == 5,
        "{messages}"
    );
}

#[test]
fn aliases_that_grow_too_large_are_refused() {
    let error = MapFile::read(&map_with_aliases(10), &mut Ignored::default())
        .expect_err("a text of billions of entries");
    assert!(error.message.contains("aliases included"), "{}", error.message);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn roadmaps_keep_their_distance_on_any_map(
        blocks in prop::collection::vec((0usize..40, 0usize..40, 1usize..12, 1usize..12), 0..25),
        width in 100u32..800,
    ) {
        let folder = tempfile::tempdir().expect("a folder");
        let blocked = |x: usize, y: usize| {
            blocks.iter().any(|&(left, bottom, columns, rows)| {
                (left..left + columns).contains(&x) && (bottom..bottom + rows).contains(&y)
            })
        };
        let row = |y| (0..40).map(|x| if blocked(x, y) { '#' } else { '.' }).collect::<String>();
        let path = write(folder.path(), 0.1, &(0..40).map(row).collect::<Vec<_>>(), "");
        if let Ok((graph, _)) = roadmap(&path, width) {
            let least = least_clearance(&graph, &grid(&path), 1.0);
            prop_assert!(least >= f64::from(width) / 2000.0, "{least} for {width} mm");
            // Robots turn at nodes only.
            prop_assert!(graph.edges().iter().all(|edge| edge.path.largest_corner() == 0.0));
            let pairs: BTreeSet<_> = graph.edges().iter().map(|edge| (edge.origin, edge.destination)).collect();
            prop_assert_eq!(pairs.len(), graph.edges().len());
        }
    }

    #[test]
    fn damaged_maps_never_panic(cut in 0usize..300, at in 0usize..130, new in "\\PC{0,3}") {
        let folder = tempfile::tempdir().expect("a folder");
        let text = std::fs::read_to_string(sample()).expect("a map").replace("map.pgm", "turtlebot3_world.pgm");
        let picture = std::fs::read(sample().with_extension("pgm")).expect("a picture");
        std::fs::write(folder.path().join("turtlebot3_world.pgm"), &picture[..cut * 10]).expect("a file");
        let mut text: String = text.chars().take(130).collect();
        if let Some(end) = at.checked_add(1).filter(|&end| end <= text.len()) {
            text.replace_range(at..end, &new);
        }
        std::fs::write(folder.path().join("map.yaml"), text).expect("a file");
        let _ = roadmap(&folder.path().join("map.yaml"), 500);
    }
}

/// A map of 4000 × 4000 cells of rooms and racks takes seconds in release: `cargo test --release --
/// --ignored`.
#[test]
#[ignore = "slow without optimization"]
fn large_maps_are_read_in_seconds() {
    let folder = tempfile::tempdir().expect("a folder");
    let side = 4000usize;
    let mut picture = format!("P5\n{side} {side}\n255\n").into_bytes();
    picture.extend((0..side * side).map(|cell| {
        let (x, y) = (cell % side, cell / side);
        let wall = x % 800 < 4 && y % 400 > 60
            || y % 800 < 4 && x % 400 > 60
            || x > 2000 && x % 60 < 24 && y % 200 > 50;
        if wall { 0u8 } else { 254 }
    }));
    std::fs::write(folder.path().join("map.pgm"), picture).expect("a file");
    let path = folder.path().join("map.yaml");
    std::fs::write(&path, "image: map.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n").expect("a file");
    let start = std::time::Instant::now();
    let (graph, _) = roadmap(&path, 600).expect("a roadmap");
    println!("{} edges in {:.1} s", graph.edges().len(), start.elapsed().as_secs_f64());
    assert!(least_clearance(&graph, &grid(&path), 0.5) >= 0.3);
}
