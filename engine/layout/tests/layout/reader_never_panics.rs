//! The reader accepts or rejects any input without panicking, and reads every generated file.

use proptest::prelude::*;
use regatta_layout::generate::{Grid, Warehouse};
use regatta_layout::model::info::Info;
use regatta_layout::{GraphError, Handles, ReadOptions, RouteGraph, draw, parse, read};

/// Reads a text; an accepted graph must be usable.
fn check(text: &str) {
    for handles in [None, Some(Handles::BAtOrigin), Some(Handles::FAtOrigin)] {
        match parse(text, "input.yaml", &ReadOptions { handles, ..ReadOptions::default() }) {
            Ok((graph, findings)) => {
                assert_eq!(findings.errors(), 0);
                let info = Info::of(&graph);
                assert!(info.length.shortest > 0.0 && info.length.total.is_finite());
                assert!(!draw::svg(&graph).contains("NaN"));
            }
            Err(error) => {
                assert!(!error.to_string().contains('\n'), "{error}");
                assert_eq!(
                    error.findings().is_some_and(|findings| findings.errors() > 0),
                    error.findings().is_some()
                );
            }
        }
    }
}

/// Fragments of route graph files.
fn fragment() -> impl Strategy<Value = String> {
    prop_oneof![
        4 => prop::sample::select(&[
            "Edges:", "Vertices:", "nodes: ", "- ", "\n", "  ", "{", "}", "[", "]", ", ", ": ", "Id: 1", "X: ", "Y: 3", "Theta: ",
            "Origin_ID: 1", "Destination_ID: 2", "CurveType: spline", "CurveType: linear", "ParamF: 1", "ParamB: ",
            "VelocityForward: 1", "&a ", "*a", "!t ", "<<: ", "? ", "| ", "> ", "\"", "'", "---\n", "%YAML 1.1\n", "#", "\t",
            ".nan", "-.inf", "1e999", "null", "~", "true", "é", "\u{feff}", "\0", "-0", "0x1f", "4294967296",
        ][..]).prop_map(str::to_owned),
        1 => any::<char>().prop_map(String::from),
        1 => any::<f64>().prop_map(|number| number.to_string()),
    ]
}

proptest! {
    #[test]
    fn fragments_in_any_order_do_not_panic(fragments in prop::collection::vec(fragment(), 0..60)) {
        check(&fragments.concat());
    }

    #[test]
    fn arbitrary_bytes_do_not_panic(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), &bytes).unwrap();
        let read = read(file.path(), &ReadOptions::default());
        let is_wrong_error = matches!(read, Err(GraphError::Unreadable { .. } | GraphError::TooLarge { .. }));
        prop_assert!(!is_wrong_error);
    }

    #[test]
    fn mutated_graphs_do_not_panic(
        changes in prop::collection::vec((any::<prop::sample::Index>(), 0usize..20, fragment()), 1..8),
        one_way: bool,
    ) {
        let mut text = Grid { columns: 3, rows: 2, spacing: 10, one_way }.generate().unwrap();
        for (at, removed, inserted) in changes {
            let from = at.index(text.len());
            let from = (0..=from).rev().find(|&from| text.is_char_boundary(from)).unwrap();
            let to = (from + removed..=text.len()).find(|&to| text.is_char_boundary(to)).unwrap_or(text.len());
            text.replace_range(from..to, &inserted);
        }
        check(&text);
    }

    /// Both names of the vertices, either order of the lists, any case.
    #[test]
    fn all_spellings_of_a_graph_are_equal(upper: bool, nodes: bool, vertices_first: bool) {
        let text = Warehouse { aisles: 1, rows: 1, bays: 1 }.generate().unwrap();
        let (graph, _) = parse(&text, "g", &ReadOptions::default()).unwrap();
        let mut other = text.replace("CurveType: Linear", "CurveType: lINEAR");
        if nodes {
            other = other.replace("Vertices:", "Nodes:");
        }
        if vertices_first {
            let (head, tail) = other.split_once("\nEdges:").unwrap();
            let (edges, vertices) = tail.split_once("\n\n").unwrap();
            other = format!("{head}\n{vertices}\nEdges:{edges}\n");
        }
        other = if upper { other.to_uppercase() } else { other.to_lowercase() };
        let (same, findings) = parse(&other, "g", &ReadOptions::default()).unwrap();
        prop_assert_eq!(findings.as_slice(), []);
        prop_assert_eq!(graph.nodes(), same.nodes());
        prop_assert_eq!(graph.edges(), same.edges());
    }
}

#[test]
fn both_spellings_of_the_format_are_read() {
    let dissertation = "\
        Nodes:\n- {FrameID: map, ID: 1, Theta: 0.5, X: 1, Y: 2}\n- {FrameID: map, ID: 2, Theta: 0.5, X: 9, Y: 6}\n\
        Edges:\n- ID: 7\n  Origin_ID: 1\n  Destination_ID: 2\n  CurveType: Spline\n  ParamF: 2\n  ParamB: 3\n  VelocityForward: 1.5\n";
    let navigation_stack = "\
        Edges:\n- CurveType: spline\n  Destination_ID: 2\n  Id: 7\n  Origin_ID: 1\n  ParamB: 3.0\n  ParamF: 2.0\n  \
        VelocityBackwards: 0.5\n  VelocityForward: 1.5\n\
        Vertices:\n- FrameId: map/nn0\n  Id: 1\n  Label: pass\n  Theta: 0.5\n  ThetaHolomonic: 3.01\n  X: 1.0\n  Y: 2.0\n\
        - FrameId: map/nn0\n  Id: 2\n  Label: pass\n  Theta: 0.5\n  ThetaHolomonic: 3.01\n  X: 9.0\n  Y: 6.0\n";
    let (one, _) = parse(dissertation, "g", &ReadOptions::default()).unwrap();
    let (other, findings) = parse(navigation_stack, "g", &ReadOptions::default()).unwrap();
    assert_eq!(findings.as_slice(), []);
    let poses = |graph: &RouteGraph| {
        graph.nodes().iter().map(|node| (node.id, node.position, node.theta)).collect::<Vec<_>>()
    };
    assert_eq!(poses(&one), poses(&other));
    let tags = other.nodes()[0].tags.as_ref().expect("a label and more");
    assert_eq!(
        (tags.name.as_deref(), tags.properties["ThetaHolomonic"].as_ref()),
        (Some("pass"), "3.01")
    );
    assert_eq!(one.edges()[0].path, other.edges()[0].path);
    assert_eq!((one.edges()[0].reverse_speed, other.edges()[0].reverse_speed), (None, Some(0.5)));
}
