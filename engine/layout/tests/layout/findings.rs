//! Tests each finding about a route graph file, and each way in which a file can't be read as a
//! route graph.

use std::path::Path;

use regatta_layout::{
    Detail, FindingKind, Format, GraphError, Handles, ReadOptions, Severity, Subject, parse,
};

/// Two nodes. Together with [`EDGES`], a graph without findings.
const NODES: &str = "Vertices:
- {Id: 1, X: 0, Y: 0, Theta: 0}
- {Id: 2, X: 5, Y: 0, Theta: 0}
";
/// An edge that may be driven in both directions.
const EDGES: &str = "Edges:
- {Id: 10, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, VelocityForward: 1, VelocityBackwards: 0.5}
";

/// Returns the findings about a text as `line severity subject: message`.
fn check_with(text: &str, options: &ReadOptions) -> Vec<String> {
    let findings = match regatta_layout::parse(text, "g.yaml", options) {
        Ok((_, warnings)) => warnings,
        Err(error) => error.findings().unwrap_or_else(|| panic!("{error}")).clone(),
    };
    findings
        .as_slice()
        .iter()
        .map(|finding| {
            format!(
                "{} {} {}: {}",
                finding.line, finding.severity, finding.subject, finding.message
            )
        })
        .collect()
}

fn check(text: &str) -> Vec<String> {
    check_with(text, &ReadOptions::default())
}

#[track_caller]
fn assert_only(found: &[String], start: &str, part: &str) {
    assert!(
        found.len() == 1 && found[0].starts_with(start) && found[0].contains(part),
        "{found:#?}"
    );
}

/// Returns the small graph with one more edge.
fn with_edge(edge: &str) -> String {
    format!("{NODES}{EDGES}- {{{edge}}}\n")
}

/// Returns the small graph with one more node.
fn with_node(node: &str) -> String {
    format!("{EDGES}{NODES}- {{{node}}}\n")
}

#[test]
fn edges_that_take_more_than_an_hour_are_told() {
    let slow = |gears: &str| {
        let edge = "Id: 11, Origin_ID: 2, Destination_ID: 1, CurveType: Linear";
        check(&with_edge(&format!("{edge}, {gears}")))
    };
    let found = slow("VelocityForward: 0.001");
    assert!(
        found
            .iter()
            .any(|line| line.contains("edge 11: robots take 1 h 23 min to drive it, at 0.001 m/s")),
        "{found:#?}"
    );
    let found = slow("VelocityForward: 1, VelocityBackwards: 0.0001");
    assert!(
        found.iter().any(|line| line.contains("13 h 53 min to drive it in reverse gear")),
        "{found:#?}"
    );
    let found = slow("VelocityForward: 0.002");
    assert!(found.iter().all(|line| !line.contains("robots take")), "{found:#?}");
}

#[test]
fn the_small_graph_has_no_findings() {
    assert_eq!(check(&format!("{NODES}{EDGES}")), [""; 0]);
    assert_eq!(check(&format!("{EDGES}{NODES}")), [""; 0]);
}

#[test]
fn a_graph_far_from_the_origin_gets_an_origin_of_its_own() {
    let far = format!("{NODES}{EDGES}").replace("X: ", "X: 50000").replace("Y: 0", "Y: -3000000");
    let (graph, findings) =
        regatta_layout::parse(&far, "g", &ReadOptions::default()).expect("a graph");
    assert_eq!(
        (graph.origin().x, graph.origin().y, findings.as_slice().len()),
        (500_000.0, -3_000_000.0, 0)
    );
    assert_eq!((graph.nodes()[0].position.x, graph.nodes()[1].position.x), (0.0, 5.0));
    let near = regatta_layout::parse(&format!("{NODES}{EDGES}"), "g", &ReadOptions::default())
        .expect("a graph")
        .0;
    assert_eq!((near.origin().x, near.edges()), (0.0, graph.edges()));
}

#[test]
fn a_node_that_is_far_from_all_others_is_told_and_not_they() {
    let far = format!("{NODES}{EDGES}").replace("X: ", "X: 50000").replace("Y: 0", "Y: -3000000");
    let found = check(&far.replace("Edges:", "- {Id: 3, X: 0, Y: 0, Theta: 0}\nEdges:"));
    let errors: Vec<_> = found.iter().filter(|line| line.contains("error")).collect();
    assert_eq!(errors.len(), 2, "{found:#?}");
    for error in errors {
        assert!(error.starts_with("4 error node 3") && error.contains("most nodes are"), "{error}");
    }
}

#[test]
fn a_name_that_is_the_id_of_another_node_is_told() {
    let named = |name: &str| {
        format!("{EDGES}{}", NODES.replace("{Id: 2,", &format!("{{Id: 2, Name: '{name}',")))
    };
    assert_only(&check(&named("1")), "5 warning node 2", "its name is the id of another node");
    for own_or_no_id in ["2", "3", "A"] {
        assert_eq!(check(&named(own_or_no_id)), [""; 0]);
    }
}

#[test]
fn duplicate_ids_are_reported() {
    let edge = "Id: 10, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, VelocityForward: 1";
    assert_only(
        &check(&with_edge(edge)),
        "6 error edge 10: ",
        "the edge in line 5 has the same Id",
    );
    assert_only(
        &check(&with_node("Id: 2, X: 1, Y: 1, Theta: 0")),
        "6 error node 2: ",
        "the node in line 5",
    );
}

#[test]
fn an_edge_and_a_node_may_have_the_same_id() {
    let text = format!("{NODES}{EDGES}").replace("Id: 10", "Id: 1");
    assert_eq!(check(&text), [""; 0]);
}

#[test]
fn missing_nodes_and_keys_are_reported() {
    let edge = "Id: 11, Origin_ID: 7, Destination_ID: 2, CurveType: Linear, VelocityForward: 1";
    assert_only(
        &check(&with_edge(edge)),
        "6 error edge 11: ",
        "Origin_ID is 7, but no node has that Id",
    );
    assert_only(&check(&with_node("Id: 3, X: 1, Theta: 0")), "6 error node 3: ", "has no Y");
    assert_only(&check(&with_node("X: 1, Y: 2, Theta: 0")), "6 error node: ", "has no Id");
}

#[test]
fn an_edge_to_an_invalid_node_is_not_reported() {
    let text = format!("{NODES}{EDGES}").replace("X: 5", "X: far");
    assert_only(&check(&text), "3 error node 2: ", "X is `far`");
}

#[test]
fn all_findings_are_reported_at_once() {
    let text = "Vertices:\n- {Id: 1, X: 0, Y: 1e9, Theta: x}\n- {Id: 1, X: 0, Y: 0, Theta: 0}\nEdges:\n\
                - {Id: 4, Origin_ID: 8, Destination_ID: 9, CurveType: arc, VelocityForward: -1}\n";
    let found = check(text);
    assert_eq!(found.len(), 7, "{found:#?}");
}

#[test]
fn numbers_that_are_not_finite_or_out_of_range_are_reported() {
    for (x, part) in [
        (".nan", "X is NaN"),
        ("-.inf", "X is -inf"),
        ("1e999", "X is `1e999`"),
        ("16001", "X is 16001 m, beyond"),
        ("[1]", "X is a list"),
        ("{a: 1}", "X is a map"),
        ("true", "X is `true`"),
        ("", "X is empty"),
        ("!m 5", "X is a tagged value"),
    ] {
        let found = check(&with_node(&format!("Id: 3, X: {x}, Y: 0, Theta: 0")));
        assert_only(&found, "6 error node 3: ", part);
    }
    let found = check(&with_node("Id: 3, X: 0, Y: 0, Theta: 1e30"));
    assert!(
        found.iter().any(|finding| finding.starts_with("6 error node 3: Theta is 1")),
        "{found:#?}"
    );
}

#[test]
fn ids_that_are_not_whole_numbers_are_reported() {
    for id in ["-1", "4294967296", "1.5", "one", "[1]", "1e99", "99999999999999999999999"] {
        let found = check(&with_node(&format!("Id: {id}, X: 0, Y: 0, Theta: 0")));
        assert_only(&found, "6 error node: ", "it must be a whole number from 0 to 4294967295");
    }
}

#[test]
fn numbers_may_be_written_in_several_ways() {
    let text = format!("{NODES}{EDGES}")
        .replace("X: 5", "X: '5.0'")
        .replace("Id: 2", "Id: 2.0")
        .replace("Y: 0", "Y: +0");
    let (graph, findings) =
        regatta_layout::parse(&text, "g.yaml", &ReadOptions::default()).unwrap();
    assert_eq!(findings.as_slice(), []);
    assert_eq!(graph.node(graph.node_by_id(2).unwrap()).position.x, 5.0);
}

#[test]
fn edges_without_length_are_reported() {
    let edge = "Id: 11, Origin_ID: 1, Destination_ID: 1, CurveType: Linear, VelocityForward: 1";
    assert_only(&check(&with_edge(edge)), "6 error edge 11: ", "same node");
    let text = format!("{NODES}{EDGES}").replace("X: 5", "X: 0");
    assert_only(&check(&text), "5 error edge 10: ", "no length");
}

#[test]
fn invalid_curve_types_and_handles_are_reported() {
    let edge = |curve: &str| {
        with_edge(&format!("Id: 11, Origin_ID: 1, Destination_ID: 2, {curve} VelocityForward: 1"))
    };
    assert_only(
        &check(&edge("CurveType: arc,")),
        "6 error edge 11: ",
        "CurveType is `arc`: use Spline, Linear or Bezier",
    );
    assert_only(&check(&edge("CurveType: 3,")), "6 error edge 11: ", "CurveType is 3");
    assert_only(&check(&edge("")), "6 error edge 11: ", "has no CurveType");
    assert_only(
        &check(&edge("CurveType: spline, ParamF: 1,")),
        "6 error edge 11: ",
        "has no ParamB",
    );
    assert_only(
        &check(&edge("CurveType: SPLINE, ParamF: -1, ParamB: 1,")),
        "6 error edge 11: ",
        "ParamF is -1",
    );
    assert_only(
        &check(&edge("CurveType: Spline, ParamF: 1, ParamB: 15000,")),
        "6 error edge 11: ",
        "extend beyond",
    );
}

#[test]
fn invalid_speeds_are_reported() {
    for (speeds, part) in [
        ("VelocityForward: 0", "VelocityForward is 0"),
        ("VelocityForward: -2", "VelocityForward is -2"),
        ("VelocityForward: 51", "VelocityForward is 51"),
        ("VelocityBackwards: 1", "has no VelocityForward"),
        ("VelocityForward: 1, VelocityBackwards: -1", "VelocityBackwards is -1"),
        ("VelocityForward: 1, VelocityBackwards: fast", "VelocityBackwards is `fast`"),
    ] {
        let edge = format!("Id: 11, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, {speeds}");
        assert_only(&check(&with_edge(&edge)), "6 error edge 11: ", part);
    }
}

#[test]
fn an_empty_graph_is_reported() {
    assert_only(
        &check("Edges: []\nVertices:\n"),
        "1 error file: ",
        "has no nodes and no edges: list them",
    );
    assert_only(&check(NODES), "1 error file: ", "has no edges: list them under Edges");
    assert_only(&check("{}"), "1 error file: ", "has no nodes and no edges");
}

#[test]
fn keys_given_twice_are_reported() {
    assert_only(
        &check(&with_node("Id: 3, X: 1, x: 2, Y: 1, Theta: 0")),
        "6 error node 3: ",
        "`x` is given twice",
    );
    let found = check(&format!("{NODES}{EDGES}nodes: []\n"));
    assert_only(&found, "6 error file: ", "`nodes` is given twice");
}

#[test]
fn items_of_the_wrong_type_are_reported() {
    let found = check(&format!("{NODES}{EDGES}- 7\n- [a]\n"));
    assert_eq!(found.len(), 2, "{found:#?}");
    assert!(found[0].contains("edge number 2 of the list must be a map, not 7"), "{found:#?}");
    let found = check(&format!("{NODES}Edges: 12\n"));
    assert_eq!(
        found,
        ["4 error file: `Edges` must be a list, not 12"],
        "and not that there are no edges"
    );
}

#[test]
fn each_unknown_key_is_reported_once() {
    let text = format!("{NODES}{EDGES}Author: me\n")
        .replace("Theta: 0}", "Theta: 0, Colour: red, Label: pass}");
    let found = check(&text);
    assert_eq!(found.len(), 2, "{found:#?}");
    assert!(
        found[0].starts_with("2 warning file: `Colour` is not a key of a node: ignored (2 times)"),
        "{found:#?}"
    );
    assert!(
        found[1].starts_with("6 warning file: `Author` is not a key of the file"),
        "{found:#?}"
    );
}

#[test]
fn invalid_settings_are_reported() {
    let ok = |line: &str| check(&format!("{line}\n{NODES}{EDGES}"));
    assert_eq!(ok("AngleUnit: deg"), [""; 0]);
    assert_eq!(ok("handles: F_at_origin"), [""; 0]);
    assert_only(&ok("AngleUnit: grad"), "1 error file: ", "use rad or deg");
    assert_only(&ok("Handles: left"), "1 error file: ", "use b_at_origin or f_at_origin");
}

#[test]
fn angles_in_degrees_are_suspected_and_can_be_declared() {
    let text = format!("{NODES}{EDGES}").replace("Theta: 0", "Theta: 90");
    let found = check(&text);
    assert!(
        found[0]
            .starts_with("2 warning node 1: Theta is 90, more than a full turn (and 1 more node)"),
        "{found:#?}"
    );
    let (graph, warnings) =
        regatta_layout::parse(&format!("angleunit: DEG\n{text}"), "g", &ReadOptions::default())
            .unwrap();
    assert_eq!(warnings.as_slice(), []);
    assert_eq!(graph.nodes()[0].theta, std::f64::consts::FRAC_PI_2);
}

#[test]
fn swapped_handles_are_suspected() {
    let text = "Edges:\n- {Id: 1, Origin_ID: 1, Destination_ID: 2, CurveType: Spline, ParamB: 9, ParamF: 1, \
                VelocityForward: 1, VelocityBackwards: 1}\nVertices:\n- {Id: 1, X: 0, Y: 0, Theta: 0}\n- {Id: 2, X: 2, Y: 9, Theta: 1.57}\n";
    assert_only(
        &check(text),
        "1 warning file: ",
        "with `Handles: f_at_origin`: if the latter is meant",
    );
    let options = ReadOptions { handles: Some(Handles::FAtOrigin), ..ReadOptions::default() };
    assert_eq!(check_with(text, &options), [""; 0]);
    assert_eq!(check(&format!("{text}Handles: f_at_origin\n")), [""; 0]);
    let options = ReadOptions { handles: Some(Handles::BAtOrigin), ..ReadOptions::default() };
    assert_eq!(check_with(&format!("{text}Handles: f_at_origin\n"), &options).len(), 1);
}

#[test]
fn heading_jumps_are_reported() {
    let text = with_node("Id: 3, X: 5, Y: 4, Theta: 0").replace(
        "Vertices",
        "- {Id: 11, Origin_ID: 2, Destination_ID: 3, CurveType: Linear, VelocityForward: 1, VelocityBackwards: 1}\nVertices",
    );
    assert_only(&check(&text), "6 warning node 2: ", "the heading changes by 90.0° from edge");
    let gentle = text.replace("Y: 4", "Y: 0.3").replace("Id: 3, X: 5", "Id: 3, X: 10");
    assert_eq!(check(&gentle), [""; 0]);
}

#[test]
fn nodes_without_a_way_out_or_in_are_reported() {
    let text = format!("{NODES}{EDGES}").replace(", VelocityBackwards: 0.5", "");
    let found = check(&text);
    assert_eq!(found.len(), 2, "{found:#?}");
    assert!(
        found[0].starts_with("2 warning node 1: unreachable: no edge leads to it"),
        "{found:#?}"
    );
    assert!(found[1].starts_with("3 warning node 2: no way out"), "{found:#?}");
    assert_only(
        &check(&with_node("Id: 3, X: 1, Y: 1, Theta: 0")),
        "6 warning node 3: ",
        "no edge starts or ends here",
    );
    // However many there are, that is one warning.
    let many: String =
        (3..20).map(|id| format!("- {{Id: {id}, X: {id}, Y: 9, Theta: 0}}\n")).collect();
    let found = check(&format!("{NODES}{many}{EDGES}"));
    assert_only(
        &found,
        "4 warning node 3: ",
        "connect it or remove it (and 16 more nodes: 4, 5, 6, 7, 8, …)",
    );
}

#[test]
fn a_component_that_no_edge_enters_is_reported_once() {
    let text = format!(
        "{NODES}- {{Id: 3, X: 9, Y: 9, Theta: 0}}\n- {{Id: 4, X: 9, Y: 12, Theta: 0}}\n{EDGES}\
         - {{Id: 11, Origin_ID: 3, Destination_ID: 4, CurveType: Linear, VelocityForward: 1, VelocityBackwards: 1}}\n"
    );
    assert_only(&check(&text), "4 warning node 3: ", "this part of 2 nodes");
}

#[test]
fn a_reversible_edge_with_id_zero_is_reported() {
    let text = format!("{NODES}{EDGES}").replace("Id: 10", "Id: 0");
    assert_only(&check(&text), "5 warning edge 0: ", "-Id");
}

#[test]
fn lines_are_correct_in_block_style_with_comments_and_multibyte_characters() {
    let text = "# Straße – 道路\nedges:\n  -\n    # first\n    ID: 1\n    origin_id: 1\n    DESTINATION_ID: 99\n    curvetype: LINEAR\n\
                \x20   velocityforward: 1\n\nNODES:\n  - FrameID: 'é'\n    ID: 1\n    x: 0\n    y: \"?\"\n    theta: 0\n";
    let found = check(text);
    assert_eq!(found.len(), 2, "{found:#?}");
    assert!(found[0].starts_with("5 error edge 1: Destination_ID is 99"), "{found:#?}");
    assert!(found[1].starts_with("12 error node 1: Y is `?`"), "{found:#?}");
}

#[test]
fn an_error_is_displayed_as_one_line() {
    let error = regatta_layout::parse(
        &with_node("Id: 2, X: far, Y: 1, Theta: 0"),
        "g.yaml",
        &ReadOptions::default(),
    )
    .unwrap_err();
    assert_eq!(
        error.to_string(),
        "g.yaml:6: error: node 2: X is `far`: it must be a finite number (and 1 more error)"
    );
    let findings = error.findings().unwrap();
    assert_eq!((findings.errors(), findings.warnings()), (2, 0));
    let first = findings.first_error().unwrap();
    assert_eq!(
        (first.severity, first.subject, first.line),
        (Severity::Error, Subject::Node(Some(2)), 6)
    );
}

#[track_caller]
fn assert_rejected(text: &str, part: &str) {
    let error = regatta_layout::parse(text, "g.yaml", &ReadOptions::default()).unwrap_err();
    assert!(error.findings().is_none(), "{error}");
    let message = error.to_string();
    assert!(
        message.starts_with("g.yaml:") && message.contains(part) && !message.contains('\n'),
        "{message}"
    );
}

#[test]
fn texts_that_are_not_route_graphs_are_rejected() {
    assert_rejected("", "is empty");
    assert_rejected("  \n# nothing\n", "is empty");
    assert_rejected("just words", "found `just words`");
    assert_rejected("- 1\n- 2\n", "found a list");
    assert_rejected("Edges: [\n", "g.yaml:");
    assert_rejected("Edges: [}\n", "g.yaml:1");
    assert_rejected("Edges: []\n---\nEdges: []\n", "more than one document");
    assert_rejected("a: \u{1}\n", "control characters");
    assert_rejected("a\0b", "zero byte");
    assert_rejected("*nowhere", "anchor");
    assert_rejected(&"[".repeat(100_000), "nested brackets");
    assert_rejected(&"- ".repeat(7_000_000), "nested lists");
    assert_rejected(&"a".repeat(257 << 20), "too large");
}

#[test]
fn a_yaml_bomb_is_rejected_in_bounded_memory() {
    let mut bomb = String::from("a: &a [lol, lol, lol, lol, lol, lol, lol, lol, lol]\n");
    for (this, last) in ('b'..='i').zip('a'..) {
        bomb.push_str(&format!("{this}: &{this} [{}]\n", vec![format!("*{last}"); 9].join(",")));
    }
    assert_rejected(&format!("{bomb}Edges: *i\n{NODES}"), "aliases included");
    let keys: String = (0..2000).map(|key| format!("k{key}: 0, ")).collect();
    let items = "*e, ".repeat(100_000);
    assert_rejected(&format!("Vertices: [&e {{{keys}}}, {items}]\n"), "aliases included");
}

/// Only our own reader reads large files part by part; the others would take gigabytes.
#[test]
fn other_formats_have_fewer_entries() {
    let text = format!("levels:\n{}", "- {a: 1, b: 2, c: 3}\n".repeat(1_000_000));
    let options =
        ReadOptions { format: Some(regatta_layout::Format::OpenRmf), ..ReadOptions::default() };
    let error = regatta_layout::parse(&text, "g.yaml", &options).unwrap_err();
    assert!(
        matches!(&error, GraphError::TooLarge { limit, .. } if limit.contains("entries")),
        "{error}"
    );
}

#[test]
fn a_scalar_may_be_an_alias() {
    let text = format!("{NODES}{EDGES}").replace("X: 0", "X: &zero 0").replace("Y: 0", "Y: *zero");
    assert_eq!(check(&text), [""; 0]);
}

#[test]
fn files_that_can_not_be_read_are_rejected() {
    let folder = tempfile::tempdir().unwrap();
    let read = |name: &str| {
        regatta_layout::read(&folder.path().join(name), &ReadOptions::default()).unwrap_err()
    };
    assert!(matches!(
        regatta_layout::read(folder.path(), &ReadOptions::default()),
        Err(GraphError::Folder { .. })
    ));
    assert!(matches!(read("missing"), GraphError::Unreadable { .. }));
    std::fs::write(folder.path().join("binary"), [b'E', b'\n', 0x01, 0xff]).unwrap();
    assert!(matches!(read("binary"), GraphError::NotText { line: 2, .. }));
    std::fs::write(folder.path().join("utf16"), [b'E', 0, b'd', 0]).unwrap();
    assert!(read("utf16").to_string().contains("UTF-16"));
    // A sparse file: it takes no space on the disk, and must take none in memory.
    std::fs::File::create(folder.path().join("large")).unwrap().set_len(2 << 30).unwrap();
    assert!(read("large").to_string().contains("too large: at most 256 MiB"));
    let device = regatta_layout::read(std::path::Path::new("/dev/zero"), &ReadOptions::default());
    assert!(device.unwrap_err().to_string().contains("a pipe or a device"));
}

#[test]
fn a_byte_order_mark_is_ignored() {
    assert_eq!(check(&format!("\u{feff}{NODES}{EDGES}")), [""; 0]);
}

#[test]
fn all_errors_of_an_edge_are_reported_at_once() {
    let edge = "Id: 11, Origin_ID: 1, Destination_ID: 9, CurveType: wavy, ParamF: -5, ParamB: 1e6, VelocityForward: 0";
    let found = check(&with_edge(edge));
    for part in [
        "Destination_ID is 9",
        "CurveType",
        "ParamF is -5",
        "ParamB is 1000000",
        "VelocityForward is 0",
    ] {
        assert!(found.iter().any(|finding| finding.contains(part)), "{part}: {found:#?}");
    }
    assert_eq!(found.len(), 5, "{found:#?}");
}

#[test]
fn a_straight_edge_needs_no_handles_but_invalid_ones_are_reported() {
    let edge = |handles: &str| {
        with_edge(&format!(
            "Id: 11, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, VelocityForward: 1{handles}"
        ))
    };
    let copy = check(&edge(""));
    assert!(
        matches!(&copy[..], [warning] if warning.contains("the same road as edge 10")),
        "{copy:#?}"
    );
    assert_eq!(check(&edge(", ParamF: 1, ParamB: 2")), copy);
    assert_eq!(check(&edge(", ParamF: .nan, ParamB: hello")).len(), 2);
}

/// A graph in flow style that is large enough to be read part by part.
fn large() -> String {
    let graph =
        regatta_layout::generate::Grid { columns: 60, rows: 60, spacing: 20, one_way: false }
            .generate()
            .expect("a graph");
    assert!(graph.len() > 1 << 20, "{} bytes", graph.len());
    graph
}

#[test]
fn a_large_file_is_read_as_a_small_one() {
    let text = large();
    let parts = regatta_layout::parse(&text, "g", &ReadOptions::default()).expect("a graph").0;
    // An ampersand may be an anchor, with which a file is read as a whole.
    let whole = regatta_layout::parse(&format!("# &\n{text}"), "g", &ReadOptions::default())
        .expect("a graph")
        .0;
    assert!(parts.nodes() == whole.nodes() && parts.edges() == whole.edges());
}

#[test]
fn findings_in_a_large_file_have_their_lines() {
    let text = large();
    let line = 20_500;
    assert!(text.lines().count() > line);
    let replaced = |new: &str| {
        let lines =
            (1..).zip(text.lines()).map(|(number, old)| if number == line { new } else { old });
        lines.flat_map(|line| [line, "\n"]).collect::<String>()
    };
    let found = check(&replaced(
        "- {Id: no, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, VelocityForward: 1}",
    ));
    assert!(
        found.iter().any(|finding| finding.starts_with(&format!("{line} error "))),
        "{found:#?}"
    );
    let error = regatta_layout::parse(&replaced("- {Id: 1, : :}"), "g", &ReadOptions::default())
        .expect_err("no YAML")
        .to_string();
    assert!(error.starts_with(&format!("g:{line}: not a route graph")), "{error}");
}

#[test]
fn a_grid_has_one_warning_about_turns_after_a_conversion() {
    let map = format!(
        "type octile\nheight 30\nwidth 30\nmap\n{}",
        format!("{}\n", ".".repeat(30)).repeat(30)
    );
    let options = ReadOptions::default();
    let (graph, of_map) = parse(&map, "grid.map", &options).unwrap();
    let yaml = regatta_layout::write(&graph, Format::Regatta).unwrap().text;
    let (_, of_yaml) = parse(&yaml, "grid.yaml", &options).unwrap();
    for findings in [of_map, of_yaml] {
        let turns: Vec<_> = findings
            .as_slice()
            .iter()
            .filter(|finding| finding.message.starts_with("the heading"))
            .collect();
        assert_eq!(turns.len(), 1);
        assert!(turns[0].message.contains("by more than 5° at 900 nodes: robots turn there"));
        assert_eq!(turns[0].kind, FindingKind::TurnsAtNodes);
    }
}

#[test]
fn speeds_in_another_unit_are_one_warning() {
    let edges: String = (1..100).map(|id| format!("{},{id},0.001\n", id - 1)).collect();
    let nodes: String = (0..100).map(|id| format!("{id},{},0\n", id * 10)).collect();
    let text = format!("id,x,y\n{nodes}\nfrom,to,speed\n{edges}");
    let (_, findings) = parse(&text, "map.csv", &ReadOptions::default()).unwrap();
    let slow: Vec<_> =
        findings.as_slice().iter().filter(|finding| finding.message.contains("its unit")).collect();
    assert_eq!(slow.len(), 1, "{slow:?}");
    assert!(slow[0].message.contains("(and over an hour for 98 more edges)"), "{}", slow[0]);
}

#[test]
fn a_fraction_with_a_comma_is_told() {
    let text = format!("{NODES}{EDGES}").replace("VelocityForward: 1,", "VelocityForward: 1,5,");
    let found = check(&text);
    assert!(
        found[0].contains("`5` is not a key of an edge: ignored; write fractions"),
        "{found:?}"
    );
}

#[test]
fn a_corner_where_turns_are_forbidden_is_found() {
    let corner = |rotation: &str| {
        check(&format!(
            "Vertices:
- {{Id: 1, X: 0, Y: 0, Theta: 0}}
- {{Id: 2, X: 5, Y: 0, Theta: 0}}
- {{Id: 3, X: 5, Y: 5, Theta: 0}}
Edges:
- {{Id: 10, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, VelocityForward: 1}}
- {{Id: 11, Origin_ID: 2, Destination_ID: 3, CurveType: Linear, VelocityForward: 1, {rotation}}}
- {{Id: 12, Origin_ID: 3, Destination_ID: 1, CurveType: Linear, VelocityForward: 1}}
"
        ))
    };
    let forbidden = |findings: &[String]| {
        let found = findings.iter().filter(|finding| finding.contains("rotation `none`"));
        found.cloned().collect::<Vec<_>>()
    };
    for allowed in ["RotationAtOrigin: cw", "RotationAtDestination: shorter"] {
        assert!(forbidden(&corner(allowed)).is_empty(), "{allowed}");
    }
    let at_origin = forbidden(&corner("RotationAtOrigin: none"));
    assert!(at_origin.len() == 1 && at_origin[0].starts_with("3 warning node 2:"), "{at_origin:?}");
    let both = forbidden(&corner("RotationAtOrigin: none, RotationAtDestination: none"));
    assert!(both.len() == 1 && both[0].contains("(and 1 more node: 3)"), "{both:?}");
}

#[test]
fn lines_of_the_background_that_cannot_be_drawn_are_told() {
    let graph = |line: &str| format!("{NODES}{EDGES}Background:\n- {{{line}}}\n");
    assert_eq!(check(&graph("Line: [[0, 0], [1, 1], [2, 1]], Level: L1")), [""; 0]);
    let few = "the Line of the background has 3 numbers: give two points [x, y] or more";
    assert_only(&check(&graph("Line: [[0, 0], [1]]")), "7 error", few);
    assert_only(&check(&graph("Level: L1")), "7 error", "has 0 numbers");
    let unknown = "`colour` is not a key of a line of the background";
    assert_only(&check(&graph("Line: [[0, 0], [1, 1]], colour: red")), "7 warning", unknown);
    let far = check(&graph("Line: [[0, 0], [1e300, 1]]"));
    assert_only(&far, "1 warning", "1 line of the background beyond ±15000 m: not drawn");
}

#[test]
fn unused_keys_of_a_layout_share_the_last_line() {
    let file = "../../graphs/imported/open-rmf/battle_royale.building.yaml";
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    let (_, findings) = regatta_layout::read(&file, &ReadOptions::default()).expect("a layout");
    let lines = findings.told(Detail::Grouped { most: 20 });
    assert_eq!(lines.len(), 3, "{lines:?}");
    assert!(lines[0].contains("40 edges have no speed limit"), "{lines:?}");
    assert!(lines[2].contains("10 keys not used: ") && lines[2].ends_with("; -v names each"));
    let each = findings.told(Detail::Each);
    assert_eq!(each.len(), findings.warnings());
    assert_eq!(each.iter().filter(|line| line.contains(": not used")).count(), 10);
}
