use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use glam::DVec2;
use proptest::prelude::*;

use super::curve::{EllipticArc, spline_to_cubics};
use crate::model::finding::{Findings, Report};
use crate::model::options::{LengthUnit, ReadOptions};
use crate::model::route_graph::RouteGraph;
use crate::read::file::Source;
use crate::read::layout::Layout;
use crate::read::parse;

fn sample(name: &str) -> String {
    let path =
        PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../graphs/imported/dxf")).join(name);
    std::fs::read_to_string(path).expect("a sample")
}

fn graph(text: &str, options: &ReadOptions) -> (RouteGraph, String) {
    let (graph, findings) = parse(text, "test.dxf", options).expect("a drawing");
    (graph, messages(&findings))
}

fn messages(findings: &Findings) -> String {
    findings.as_slice().iter().map(|finding| format!("{finding}\n")).collect()
}

/// Returns a drawing in metres of entities, each as codes and values that are separated by spaces.
fn drawing(entities: &[&str]) -> String {
    let entities: String =
        entities.iter().map(|entity| format!("{}\n", entity.replace(' ', "\n"))).collect();
    format!(
        "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n6\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n{entities}0\nENDSEC\n0\nEOF\n"
    )
}

fn line(from: [f64; 2], to: [f64; 2], layer: &str) -> String {
    format!("0 LINE 8 {layer} 10 {} 20 {} 11 {} 21 {}", from[0], from[1], to[0], to[1])
}

/// With time that grows with the square of the layers, this takes minutes.
#[test]
fn many_layers_take_linear_time() {
    let count = 100_000;
    let entities: Vec<String> =
        (0..count).map(|number| line([0.0, 0.0], [4.0, 0.0], &format!("L{number}"))).collect();
    let entities: Vec<&str> = entities.iter().map(String::as_str).collect();
    let (graph, messages) = graph(&drawing(&entities), &metres(&["l7"]));
    let layers = graph.edges().iter().map(|edge| &edge.tags.as_ref().expect("tags").properties);
    assert!(layers.clone().all(|layer| layer["layer"].as_ref() == "L7"), "{messages}");
    assert_eq!(layers.count(), 2, "{messages}");
}

fn metres(layers: &[&str]) -> ReadOptions {
    ReadOptions {
        layers: layers.iter().map(ToString::to_string).collect(),
        units: Some(LengthUnit::Metre),
        ..ReadOptions::default()
    }
}

#[test]
fn a_closed_polyline_of_a_program_is_read() {
    let (graph, messages) = graph(&sample("cc_dxflib.dxf"), &ReadOptions::default());
    // Five vertices, of which the last repeats the first.
    assert_eq!((graph.nodes().len(), graph.edges().len()), (4, 8), "{messages}");
    assert_eq!(
        graph.nodes()[1].position,
        DVec2::new(0.302_861_690_521_240_2, -1.579_475_760_459_9)
    );
    assert!(messages.contains("`--units mm`"), "{messages}");
    assert_eq!(
        graph.edges()[0].tags.as_ref().expect("tags").properties["layer"].as_ref(),
        "POLYLINE_001"
    );
}

#[test]
fn blocks_in_rows_and_columns_are_expanded() {
    let text = sample("multi_insert_with_attribs.dxf");
    let mut report = Report::new("test.dxf", &text);
    let source = Source { text: &text, folder: Path::new(""), stem: "" };
    let layout: Layout =
        super::read(source, &ReadOptions::default(), &mut report).expect("a drawing");
    // 25 flags: a pole of three lines, the last of which ends on the first, and a circle that
    // crosses the first with one of its four nodes: nine links.
    assert_eq!(
        (layout.nodes.len(), layout.edges.len()),
        (25 * 8, 25 * 2 * 9),
        "{}",
        messages(&report.into_findings())
    );
    // The flag in the second column: 10 m along 15°.
    let second = DVec2::from_angle(15f64.to_radians()) * 10.0;
    assert!(
        layout.nodes.iter().any(|node| node.position.is_some_and(|at| at.distance(second) < 1e-9))
    );
    assert!(layout.edges.iter().all(|edge| edge.tags.properties["layer"].as_ref() == "FLAGS"));
}

#[test]
fn a_depot_has_all_kinds_of_lines() {
    let options = ReadOptions { layers: vec!["routes".into()], ..ReadOptions::default() };
    let (graph, messages) = graph(&sample("depot.dxf"), &options);
    let at = |x: f64, y: f64| {
        graph.nodes().iter().any(|node| node.position.distance(DVec2::new(x, y)) < 1e-6)
    };
    // The corners, the branch that ends on the lower side, and the ends of the station's block.
    for (x, y) in [(0.0, 1.0), (1.0, 0.0), (20.0, 0.0), (10.0, 0.0), (10.0, 5.0)] {
        assert!(at(x, y), "({x}, {y}) {messages}");
    }
    assert_eq!(graph.background().len(), 5);
    assert_eq!(graph.background()[0].points, [DVec2::new(-5.0, -5.0), DVec2::new(25.0, -5.0)]);
    // Eight links of the loop, five of which others split once each; a branch, an arc, a spline,
    // four quarters of a circle, a line to it, two bays.
    assert_eq!(
        (graph.nodes().len(), graph.edges().len()),
        (21, 2 * (8 + 5 + 1 + 1 + 1 + 4 + 1 + 2)),
        "{messages}"
    );
    assert!(
        messages.contains("line on the hidden layer `old routes`")
            && messages.contains("entity TEXT"),
        "{messages}"
    );
    let (_, all) =
        parse(&sample("depot.dxf"), "t.dxf", &ReadOptions::default()).expect("a drawing");
    let all = all.as_slice().iter().map(ToString::to_string).collect::<String>();
    assert!(all.contains("`old routes` (hidden)"), "{all}");
    let unknown =
        parse(&sample("depot.dxf"), "t.dxf", &metres(&["roads"])).expect_err("no such layer");
    assert!(unknown.to_string().contains("layer `roads` doesn't exist"), "{unknown}");
}

#[test]
fn lines_are_joined_and_split_where_others_end() {
    let (graph, messages) = graph(
        &drawing(&[
            &line([0.0, 0.0], [10.0, 0.0], "0"),
            // Ends on the first, within 1 mm.
            &line([4.0, 5.0], [4.0, 0.0008], "0"),
            // Continues it, within 1 mm.
            &line([10.0005, 0.0], [10.0, 7.0], "0"),
            // Crosses the first, without an end there.
            &line([2.0, -3.0], [2.0, 3.0], "0"),
            // Misses the first by 5 cm.
            &line([6.0, 0.05], [6.0, 3.0], "0"),
            // The first again, backwards, and a dot.
            &line([10.0, 7.0], [10.0, 0.0], "0"),
            &line([8.0, 8.0], [8.0, 8.0003], "0"),
        ]),
        &ReadOptions::default(),
    );
    assert_eq!((graph.nodes().len(), graph.edges().len()), (9, 12), "{messages}");
    assert!(messages.contains("(6.000, 0.050) m misses another by 50 mm"), "{messages}");
    assert!(
        messages.contains("drawn a second time") && messages.contains("shorter than 1 mm"),
        "{messages}"
    );
    assert_eq!(messages.matches("misses another").count(), 1, "{messages}");
}

#[test]
fn lines_that_are_drawn_twice_are_counted_as_they_were_drawn() {
    let (graph, messages) = graph(
        &drawing(&[
            &line([0.0, 0.0], [20.0, 0.0], "0"),
            // Both split the first one.
            &line([5.0, 0.0], [5.0, 4.0], "0"),
            &line([10.0, 0.0], [10.0, 4.0], "0"),
            // The first again, and half of it with as much beyond.
            &line([20.0, 0.0], [0.0, 0.0], "0"),
            &line([10.0, 0.0], [30.0, 0.0], "0"),
        ]),
        &ReadOptions::default(),
    );
    assert_eq!(graph.edges().len(), 2 * (3 + 2 + 1), "{messages}");
    assert!(
        messages.contains("warning: line that is drawn a second time: not used\n"),
        "{messages}"
    );
    assert!(
        messages.contains("warning: part of a line that is drawn a second time: not used\n"),
        "{messages}"
    );
}

#[test]
fn arcs_bulges_and_circles_are_exact() {
    let text = drawing(&[
        "0 ARC 8 0 10 5 20 0 40 5 50 90 51 180",
        "0 LWPOLYLINE 8 0 70 0 10 20 20 0 42 1 10 30 20 0 10 40 20 0",
        "0 CIRCLE 8 0 10 0 20 50 40 100",
        "0 ELLIPSE 8 0 10 0 20 -90 11 4 21 0 40 0.5 41 0 42 3.141592653589793",
        "0 ARC 8 0 10 -60 20 0 40 5 50 0 51 90 210 0 220 0 230 -1",
    ]);
    let (graph, messages) = graph(&text, &ReadOptions::default());
    assert_eq!(graph.edges().len(), 2 * (1 + 2 + 4 + 1 + 1), "{messages}");
    let on_circle = |edge: usize, centre: DVec2, radius: f64| {
        let samples = (0..=100).map(|i| graph.edges()[edge].path.at(f64::from(i) / 100.0).0);
        samples.map(|point| (point.distance(centre) - radius).abs()).fold(0.0, f64::max)
    };
    assert!(on_circle(0, DVec2::new(5.0, 0.0), 5.0) < 1.1e-6);
    // A bulge of 1: a half turn counter-clockwise, below the chord.
    assert!(on_circle(2, DVec2::new(25.0, 0.0), 5.0) < 1.1e-6);
    assert!(graph.edges()[2].path.at(0.5).0.distance(DVec2::new(25.0, -5.0)) < 1e-5);
    assert!(
        (6..14).map(|edge| on_circle(edge, DVec2::new(0.0, 50.0), 100.0)).fold(0.0, f64::max)
            < 1.1e-6
    );
    assert!(graph.edges()[14].path.at(0.5).0.distance(DVec2::new(0.0, -88.0)) < 1e-5);
    // Seen from below: x is reversed.
    assert!(on_circle(16, DVec2::new(60.0, 0.0), 5.0) < 1.1e-6);
}

#[test]
fn curves_are_split_too() {
    let text =
        drawing(&["0 ARC 8 0 10 0 20 0 40 5 50 0 51 180", &line([0.0, 5.0], [0.0, 9.0], "0")]);
    let (graph, messages) = graph(&text, &ReadOptions::default());
    assert_eq!((graph.nodes().len(), graph.edges().len()), (4, 6), "{messages}");
    let length: f64 = graph.edges().iter().map(|edge| edge.path.length()).sum();
    assert!((length - 2.0 * (5.0 * PI + 4.0)).abs() < 1e-4);
}

#[test]
fn a_spline_is_exact() {
    let points =
        [(0.0, 0.0), (1.0, 2.0), (3.0, 2.0), (4.0, 0.0), (6.0, 0.0)].map(|(x, y)| DVec2::new(x, y));
    let knots = [0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0, 2.0];
    let cubics = spline_to_cubics(3, &knots, &points, &[]).expect("a spline");
    assert_eq!(
        cubics[0].control_points,
        [(0.0, 0.0), (1.0, 2.0), (2.0, 2.0), (2.75, 1.5)].map(|(x, y)| DVec2::new(x, y))
    );
    assert_eq!(
        cubics[1].control_points,
        [(2.75, 1.5), (3.5, 1.0), (4.0, 0.0), (6.0, 0.0)].map(|(x, y)| DVec2::new(x, y))
    );
    let uniform: Vec<f64> = (0..8).map(f64::from).collect();
    assert_eq!(spline_to_cubics(2, &uniform, &points, &[1.0; 5]).expect("a spline").len(), 3);
    assert!(spline_to_cubics(3, &knots, &points, &[1.0, 2.0, 1.0, 1.0, 1.0]).is_some());
    assert!(spline_to_cubics(3, &knots[1..], &points, &[]).is_none());
    let text = drawing(&[
        "0 SPLINE 8 0 70 8 71 3 40 0 40 0 40 0 40 0 40 1 40 1 40 1 40 1 10 0 20 0 10 1 20 2 10 3 20 2 10 4 20 0",
    ]);
    assert_eq!(graph(&text, &ReadOptions::default()).0.edges().len(), 2);
}

#[test]
fn units_and_layers_are_chosen() {
    let entities =
        [line([0.0, 0.0], [3000.0, 0.0], "Fahrwege ü"), line([0.0, 9.0], [1000.0, 9.0], "walls")];
    let text = drawing(&[&entities[0], &entities[1]]);
    // The layer's name has a space, which `drawing` takes for a separator.
    let text = text.replace("Fahrwege\nü", "Fahrwege ü");
    let options = ReadOptions {
        layers: vec!["fahrwege Ü".into()],
        units: Some(LengthUnit::Millimetre),
        ..ReadOptions::default()
    };
    let (graph, _) = graph(&text, &options);
    assert_eq!((graph.edges().len(), graph.nodes()[1].position), (2, DVec2::X * 3.0));
    assert_eq!(
        graph.background(),
        [vec![DVec2::new(0.0, 9.0 * 0.001), DVec2::new(1.0, 9.0 * 0.001)].into()]
    );
    let millimetres = text.replace("70\n6\n", "70\n4\n");
    let (all, messages) = self::graph(&millimetres, &ReadOptions::default());
    assert_eq!(all.edges().len(), 4);
    assert!(messages.contains("`Fahrwege ü`, `walls`: choose with `--layer NAME`"), "{messages}");
}

#[test]
fn what_is_no_drawing_is_refused() {
    for (text, part) in [
        ("0\nSECTION\n2\nENTITIES\n0\nENDSEC\n0\nEOF\n", "no lines"),
        ("0\nSECTION\nx\nENTITIES\n", "isn't a group code"),
        ("AutoCAD Binary DXF\r\n\x1a", "binary drawing"),
        (
            &drawing(&["0 LINE 8 0 10 x 20 0 11 1 21 0", "0 LINE 8 0 10 0 20 0 11 1 21 0"]),
            "isn't a number",
        ),
        (
            &drawing(&["0 LINE 8 0 10 nan 20 0 11 1 21 0", "0 LINE 8 0 10 0 20 0 11 1 21 0"]),
            "isn't a number",
        ),
    ] {
        let options = ReadOptions { format: Some(crate::Format::Dxf), ..ReadOptions::default() };
        let error = parse(text, "test.dxf", &options).expect_err(text);
        assert!(error.to_string().contains(part), "{error}");
    }
}

#[test]
fn a_binary_drawing_is_told_to_be_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("binary.dxf");
    std::fs::write(&path, b"AutoCAD Binary DXF\r\n\x1a\x00\x00\x00SECTION\x00").expect("a file");
    let error =
        crate::read::read(&path, &ReadOptions::default()).expect_err("a binary file").to_string();
    assert!(error.contains("save it as DXF in ASCII"), "{error}");
}

#[test]
fn nested_blocks_are_bounded() {
    let mut text = String::from(
        "0\nSECTION\n2\nBLOCKS\n0\nBLOCK\n2\nB0\n0\nLINE\n10\n0\n20\n0\n11\n1\n21\n0\n0\nENDBLK\n",
    );
    for level in 1..12 {
        text += &format!("0\nBLOCK\n2\nB{level}\n");
        text += &format!("0\nINSERT\n2\nB{}\n70\n32000\n71\n32000\n44\n1\n", level - 1).repeat(10);
        text += "0\nENDBLK\n";
    }
    text +=
        "0\nBLOCK\n2\nSELF\n0\nINSERT\n2\nSELF\n0\nENDBLK\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n";
    let end = "0\nENDSEC\n0\nEOF\n";
    let bomb = parse(&format!("{text}0\nINSERT\n2\nB11\n{end}"), "t.dxf", &metres(&[]))
        .expect_err("a bomb");
    assert!(bomb.to_string().contains("too many entities"), "{bomb}");
    let line = "0\nLINE\n10\n0\n20\n0\n11\n1\n21\n0\n";
    let (graph, messages) = graph(&format!("{text}0\nINSERT\n2\nSELF\n{line}{end}"), &metres(&[]));
    assert!(graph.edges().len() == 2 && messages.contains("blocks deep"), "{messages}");
}

#[test]
fn curves_in_blocks_are_bounded_by_their_points() {
    let insert = "0 INSERT 2 B 70 32000 71 32000";
    let end = "0 ENDBLK 0 ENDSEC 0 SECTION 2 ENTITIES";
    // Each fails, or is left out as too far away, after it has been read.
    let knots: String = (0..2002).map(|knot| format!(" 40 {knot}")).collect();
    let spline = format!("0 SPLINE 71 1{knots}{}", " 10 2e7 20 1 10 3e7 20 1".repeat(1000));
    for entity in [
        &spline,
        &spline.replace("71 1", "71 9"),
        &format!("0 LWPOLYLINE{}", " 10 1 20 1".repeat(2000)),
    ] {
        let text =
            format!("0 SECTION 2 BLOCKS 0 BLOCK 2 B {entity} {end} {insert}").replace(' ', "\n");
        let error = parse(&text, "t.dxf", &metres(&[])).expect_err("too much");
        assert!(error.to_string().contains("too many entities"), "{error}");
    }
}

#[test]
fn long_names_are_refused() {
    let name = "n".repeat(256);
    let error =
        |text: &str| parse(text, "t.dxf", &metres(&[])).expect_err("a long name").to_string();
    assert!(
        error(&drawing(&[&line([0.0, 0.0], [1.0, 0.0], &name)]))
            .contains("isn't a name of at most 255 bytes")
    );
    let (graph, _) = graph(&drawing(&[&line([0.0, 0.0], [1.0, 0.0], &name[1..])]), &metres(&[]));
    assert_eq!(
        graph.edges()[0].tags.as_ref().expect("tags").properties["layer"].as_ref(),
        &name[1..]
    );
}

#[test]
fn curves_that_are_much_longer_than_the_rest_take_no_longer() {
    let short = |x: f64| line([x, 0.0], [x, 1.0], "0");
    let mut entities: Vec<String> = (0..200).map(|index| short(f64::from(index) * 0.002)).collect();
    entities.push(line([0.0, 0.0], [7000.0, 7000.0], "0"));
    entities.push(line([-7000.0, 0.5], [7000.0, 0.5], "0"));
    let (graph, _) =
        graph(&drawing(&entities.iter().map(String::as_str).collect::<Vec<_>>()), &metres(&[]));
    // The long ones cross the others, whose ends they don't touch; one starts at an end.
    assert_eq!((graph.nodes().len(), graph.edges().len()), (2 * 200 + 3, 2 * 202));
}

#[test]
fn closed_curves_are_divided() {
    for (entity, length) in [
        ("0 ARC 10 0 20 0 40 5000", 1e4 * PI),
        ("0 ARC 8 0 10 0 20 0 40 5 50 0 51 359.999999", 10.0 * PI),
        ("0 ELLIPSE 8 0 10 0 20 0 11 5 21 0 40 1 41 0 42 6.283185", 10.0 * PI),
        ("0 CIRCLE 8 0 10 0 20 0 40 5", 10.0 * PI),
    ] {
        let (graph, messages) = graph(&drawing(&[entity]), &ReadOptions::default());
        let sum: f64 = graph.edges().iter().map(|edge| edge.path.length()).sum();
        assert!((sum / 2.0 - length).abs() < 0.001 * length, "{entity}: {sum} {messages}");
    }
    // One cubic that ends within the tolerance of its start.
    let spline = "0 SPLINE 8 0 70 8 71 3 40 0 40 0 40 0 40 0 40 1 40 1 40 1 40 1 10 0 20 0 10 4 20 \
                  0 10 4 20 4 10 0 20 0.0003";
    let (graph, messages) = graph(&drawing(&[spline]), &ReadOptions::default());
    assert_eq!((graph.nodes().len(), graph.edges().len()), (2, 4), "{messages}");
}

#[test]
fn a_line_whose_ends_are_joined_to_one_node_is_left_out() {
    let (graph, messages) = graph(
        &drawing(&[
            &line([0.0, 0.0], [9.0, 0.0], "0"),
            &line([8.9993, 0.0007], [9.0007, 0.0007], "0"),
        ]),
        &ReadOptions::default(),
    );
    assert_eq!((graph.nodes().len(), graph.edges().len()), (2, 2), "{messages}");
    assert!(messages.contains("whose ends are joined to one node: not used"), "{messages}");
}

#[test]
fn names_of_layers_are_in_the_code_page_of_the_drawing() {
    let start = "0\r\nSECTION\r\n2\r\nHEADER\r\n9\r\n$DWGCODEPAGE\r\n3\r\n";
    let begin = b"\r\n0\r\nENDSEC\r\n0\r\nSECTION\r\n2\r\nENTITIES\r\n0\r\nLINE\r\n8\r\n";
    let end = b"\r\n10\r\n0\r\n20\r\n0\r\n11\r\n8\r\n21\r\n0\r\n0\r\nENDSEC\r\n0\r\nEOF\r\n";
    for (page, name, decoded) in [
        ("ANSI_1252", b"Fahrspur_S\xfcd".as_slice(), "Fahrspur_Süd"),
        ("ANSI_936", b"\xb3\xb5\xb5\xc0", "车道"),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.dxf");
        let bytes = [start.as_bytes(), page.as_bytes(), begin, name, end].concat();
        std::fs::write(&path, bytes).expect("a file");
        let options = metres(&[decoded]);
        let (graph, findings) = crate::read::read(&path, &options).expect("a drawing");
        let tags = graph.edges()[0].tags.as_ref().expect("tags");
        assert_eq!(tags.properties["layer"].as_ref(), decoded);
        assert!(!messages(&findings).contains("Windows-1252"), "{}", messages(&findings));
    }
}

#[test]
fn escapes_in_names_of_layers_are_resolved() {
    let text = drawing(&[&line([0.0, 0.0], [9.0, 0.0], "Süd"), &line([0.0, 1.0], [9.0, 1.0], "0")]);
    let table = "0\nSECTION\n2\nTABLES\n0\nLAYER\n2\nS\\U+00FCd\n62\n-7\n0\nENDSEC\n";
    let (graph, messages) = graph(&format!("{table}{text}"), &ReadOptions::default());
    assert_eq!(graph.edges().len(), 2, "{messages}");
    assert!(messages.contains("line on the hidden layer `Süd`"), "{messages}");
}

#[test]
fn a_curve_of_many_parts_is_split_at_each() {
    let count = 3000;
    let knots: String = (0..count + 2).map(|knot| format!(" 40 {knot}")).collect();
    let points: String = (0..count).map(|index| format!(" 10 {index} 20 {}", index % 2)).collect();
    let mut entities = vec![format!("0 SPLINE 71 1{knots}{points}")];
    entities.extend(
        (0..count - 1)
            .map(|index| line([f64::from(index) + 0.5, 0.5], [f64::from(index) + 0.5, -9.0], "0")),
    );
    let (graph, messages) =
        graph(&drawing(&entities.iter().map(String::as_str).collect::<Vec<_>>()), &metres(&[]));
    assert_eq!(graph.edges().len(), 2 * (count as usize + count as usize - 1), "{messages}");
    let corner = &graph.edges()[2].path;
    assert_eq!(
        (corner.start(), corner.end(), corner.cubic_count()),
        (DVec2::new(0.5, 0.5), DVec2::new(1.5, 0.5), 2)
    );
}

#[test]
fn arcs_stay_within_a_micrometre() {
    for radius in [0.1, 1.0, 30.0, 1000.0] {
        let arc = EllipticArc::circular(DVec2::ZERO, radius, 0.3, 4.0);
        let cubics = arc.cubics(1.0);
        let points =
            cubics.iter().flat_map(|cubic| (0..=50).map(|i| cubic.position(f64::from(i) / 50.0)));
        let worst = points.map(|point| (point.length() - radius).abs()).fold(0.0, f64::max);
        assert!(worst < 1.01e-6, "{radius}: {worst}, {} cubics", cubics.len());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]
    #[test]
    fn damaged_drawings_never_panic(
        name in prop::sample::select(vec!["depot.dxf", "cc_dxflib.dxf", "multi_insert_with_attribs.dxf"]),
        cut in 0.0..1.2f64,
        changes in prop::collection::vec((0.0..1.0f64, "[0-9.\n-]{0,3}|\\PC{0,2}|LINE|ENDBLK|POLYLINE|1e308|nan"), 0..6),
    ) {
        let text = sample(name);
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        for (place, new) in changes {
            let index = (place * lines.len() as f64) as usize;
            lines[index] = new;
        }
        lines.truncate((cut * lines.len() as f64) as usize);
        let options = ReadOptions { format: Some(crate::Format::Dxf), ..ReadOptions::default() };
        let _ = parse(&lines.join("\n"), "test.dxf", &options);
    }
}
