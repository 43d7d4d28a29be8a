use crate::model::options::ReadOptions;
use crate::model::tags::Orientation;
use crate::{parse, parse_fixed};

const EDGE: &str = "CurveType: Linear, VelocityForward: 1";

fn fixed(text: &str) -> (crate::model::route_graph::RouteGraph, Vec<String>) {
    let (graph, _, fixes) =
        parse_fixed(text, "g", &ReadOptions::default()).expect("it can be mended");
    (graph, fixes)
}

#[test]
fn a_good_graph_stays_as_it_is() {
    let text = include_str!("../../../../../graphs/porto.yaml");
    let (graph, fixes) = fixed(text);
    let (same, _) = parse(text, "g", &ReadOptions::default()).expect("a graph");
    assert_eq!((graph.nodes(), graph.edges(), fixes.len()), (same.nodes(), same.edges(), 0));
}

#[test]
fn degrees_duplicates_and_gaps_are_mended() {
    let text = format!(
        "Vertices:\n- {{Id: 1, X: 0, Y: 0, Theta: 90}}\n- {{Id: 2, X: 0, Y: 5, Theta: 90}}\n\
         - {{Id: 3, X: 0.02, Y: 5.01, Theta: 91}}\n- {{Id: 4, X: 0, Y: 9, Theta: 90}}\n\
         Edges:\n- {{Id: 1, Origin_ID: 1, Destination_ID: 2, {EDGE}}}\n- {{Id: 1, Origin_ID: 1, Destination_ID: 2, {EDGE}}}\n\
         - {{Id: 1, Origin_ID: 3, Destination_ID: 4, {EDGE}}}\n"
    );
    assert!(parse(&text, "g", &ReadOptions::default()).is_err(), "edges with the same id");
    let (graph, fixes) = fixed(&text);
    assert_eq!((graph.nodes().len(), graph.edges().len(), fixes.len()), (3, 2, 4), "{fixes:?}");
    assert!((graph.nodes()[0].theta - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    assert_eq!(graph.edges()[0].destination, graph.edges()[1].origin, "they meet now");
    assert_eq!(graph.edges()[1].id, 2);
}

#[test]
fn degrees_of_other_formats_are_converted() {
    let node = |id: u32, x: u32| {
        format!(
            "{{\"nodeId\": \"{id}\", \"nodePosition\": {{\"x\": {x}, \"y\": 0}}, \
             \"vehicleTypeNodeProperties\": [{{\"vehicleTypeId\": \"A\", \"theta\": 90}}]}}"
        )
    };
    let text = format!(
        "{{\"layouts\": [{{\"nodes\": [{}, {}], \"edges\": [{{\"edgeId\": \"1\", \
         \"startNodeId\": \"1\", \
         \"endNodeId\": \"2\", \"vehicleTypeEdgeProperties\": [{{\"vehicleTypeId\": \"A\", \"maxSpeed\": 1, \
         \"orientationType\": \"GLOBAL\", \"vehicleOrientation\": 180}}]}}]}}]}}",
        node(1, 0),
        node(2, 5)
    );
    let (graph, fixes) = fixed(&text);
    assert_eq!(
        (graph.edges()[0].orientation, fixes.len()),
        (Orientation::Fixed(std::f64::consts::PI), 1),
        "{fixes:?}"
    );
    assert!((graph.nodes()[1].theta - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
}

#[test]
fn edges_that_differ_in_anything_but_their_names_stay() {
    let edge = |id: u32, more: &str| {
        format!("- {{Id: {id}, Origin_ID: 1, Destination_ID: 2, {EDGE}{more}}}\n")
    };
    let text = format!(
        "Vertices:\n- {{Id: 1, X: 0, Y: 0, Theta: 0}}\n- {{Id: 2, X: 5, Y: 0, Theta: \
         0}}\nEdges:\n{}{}{}{}{}",
        edge(1, ""),
        edge(2, ", Zone: trolleys"),
        edge(3, ", RotationAtOrigin: cw"),
        edge(4, ", Name: again"),
        "- {Id: 5, Origin_ID: 2, Destination_ID: 2, CurveType: Linear, VelocityForward: 1}\n",
    );
    let (graph, fixes) = fixed(&text);
    assert_eq!(
        graph.edges().iter().map(|edge| edge.id).collect::<Vec<_>>(),
        [1, 2, 3],
        "{fixes:?}"
    );
    assert_eq!(
        fixes,
        [
            "edge 4 (`again`): removed, it is the same as edge 1; its name `again` is kept",
            "edge 5: removed, it leads from a node to itself"
        ]
    );
}

#[test]
fn ends_of_other_formats_are_joined_whatever_their_headings() {
    let text = "id,x,y\nA,0,0\nB,10,0\nB2,10.004,0.003\nC,20,0\n\nfrom,to\nA,B\nB,A\nB2,C\n";
    let (graph, fixes) = fixed(text);
    assert_eq!((graph.nodes().len(), fixes.len()), (3, 1), "{fixes:?}");
}

#[test]
fn ends_of_straight_edges_are_joined_whatever_their_headings() {
    let nodes = "Vertices:\n- {Id: 1, X: 0, Y: 0, Theta: 0}\n- {Id: 2, X: 10, Y: 0, Theta: 0}\n\
                 - {Id: 3, X: 10.003, Y: 0, Theta: 1}\n- {Id: 4, X: 20, Y: 0, Theta: 0}\n";
    let edge = |id: u32, from: u32, to: u32, curve: &str| {
        format!(
            "- {{Id: {id}, Origin_ID: {from}, Destination_ID: {to}, CurveType: {curve}, \
             VelocityForward: 1}}\n"
        )
    };
    let text = |curve: &str| {
        let edges = [edge(1, 1, 2, "Linear"), edge(2, 2, 1, "Linear"), edge(3, 3, 4, curve)];
        format!("{nodes}Edges:\n{}", edges.concat())
    };
    let (graph, fixes) = fixed(&text("Linear"));
    assert_eq!((graph.nodes().len(), fixes.len()), (3, 1), "{fixes:?}");
    let (graph, fixes) = fixed(&text("Spline, ParamF: 4, ParamB: 4"));
    assert_eq!((graph.nodes().len(), fixes.len()), (4, 0), "a spline would bend: {fixes:?}");
}

#[test]
fn curves_that_nearly_meet_their_nodes_are_moved_to_them() {
    let text = "Vertices:\n- {Id: 1, X: 0, Y: 0, Theta: 0}\n- {Id: 2, X: 6, Y: 0, Theta: 0}\nEdges:\n\
                - {Id: 7, Origin_ID: 1, Destination_ID: 2, CurveType: Bezier, VelocityForward: 1, \
                ControlPoints: [[0.03, 0], [0, 4], [6, 4], [6, -0.04]]}\n";
    let (graph, fixes) = fixed(text);
    assert_eq!((graph.edges()[0].path.cubic_count(), fixes.len()), (1, 1), "{fixes:?}");
}

/// Two nodes, a road each way and a copy of the first one, with more of a file.
fn with_a_copy(more: &str) -> String {
    let edges = [(1, 1, 2), (2, 2, 1), (3, 1, 2)].map(|(id, from, to)| {
        format!("- {{Id: {id}, Origin_ID: {from}, Destination_ID: {to}, {EDGE}}}\n")
    });
    format!(
        "Vertices:\n- {{Id: 1, X: 0, Y: 0, Theta: 0}}\n- {{Id: 2, X: 10, Y: 0, Theta: 0}}\n\
         Edges:\n{}{more}",
        edges.concat()
    )
}

#[test]
fn headings_whose_unit_the_file_gives_stay() {
    let csv = "id,x,y,theta [deg]\nA,0,0,90\nB,10,0,450\n\nfrom,to\nA,B\nB,A\n";
    let point = |name: &str, x: u32, angle: i32| {
        format!(
            "<point name=\"{name}\" positionX=\"{x}\" positionY=\"0\" \
             vehicleOrientationAngle=\"{angle}\" type=\"HALT_POSITION\"/>"
        )
    };
    let paths = [("A", "B"), ("B", "A")].map(|(from, to)| {
        format!(
            "<path name=\"{from}-{to}\" sourcePoint=\"{from}\" destinationPoint=\"{to}\" \
             length=\"10000\" maxVelocity=\"1000\" maxReverseVelocity=\"0\" locked=\"false\"/>"
        )
    });
    let xml = format!(
        "<?xml version=\"1.0\"?>\n<model version=\"6.0.0\" name=\"X\">{}{}{}</model>",
        point("A", 0, 90),
        point("B", 10_000, -270),
        paths.concat()
    );
    let radians = "AngleUnit: rad\nVertices:\n- {Id: 1, X: 0, Y: 0, Theta: 7.853981633974483}\n\
                   - {Id: 2, X: 10, Y: 0, Theta: 0}\nEdges:\n\
                   - {Id: 1, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, VelocityForward: 1}\n";
    for text in [csv, &xml, &xml.replace("-270", "450"), radians] {
        let (graph, fixes) = fixed(text);
        assert_eq!(fixes, [""; 0], "{text}");
        assert!((graph.nodes()[0].theta - std::f64::consts::FRAC_PI_2).abs() < 1e-9, "{text}");
    }
}

#[test]
fn headings_without_a_unit_are_converted_where_a_check_warns_of_them() {
    let csv = "id,x,y,theta\nA,0,0,90\nB,10,0,180\n\nfrom,to\nA,B\nB,A\n";
    let told = |text: &str| {
        let (_, findings) = parse(text, "g", &ReadOptions::default()).expect("a graph");
        findings.as_slice().iter().any(|found| found.message.contains("more than a full turn"))
    };
    let (graph, fixes) = fixed(csv);
    assert!((graph.nodes()[0].theta - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    assert_eq!((fixes.len(), told(csv)), (1, true), "{fixes:?}");
    // One of the angles is surely in radians.
    let mixed = csv.replace("180", "3.1416");
    assert_eq!((fixed(&mixed).1.len(), told(&mixed)), (0, true));
    let edge = "Vertices:\n- {Id: 1, X: 0, Y: 0, Theta: 0}\n- {Id: 2, X: 10, Y: 0, Theta: 0}\n\
                Edges:\n- {Id: 1, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, \
                VelocityForward: 1, HeadingOffset: 90}\n";
    assert_eq!((fixed(edge).1.len(), told(edge)), (1, true));
}

#[test]
fn removed_edges_are_replaced_in_zones_and_at_doors() {
    let (graph, fixes) =
        fixed(&with_a_copy("Zones:\n- {Name: Z, Capacity: 1, Nodes: [], Edges: [3]}\n"));
    assert_eq!((graph.edges().len(), fixes.len()), (2, 1), "{fixes:?}");
    assert_eq!(graph.zones()[0].edges, [regatta_base::graph::EdgeIndex(0)]);
    let (graph, _) = fixed(&with_a_copy("Doors:\n- {Name: D, Edges: [1, 3]}\n"));
    assert_eq!(graph.doors()[0].edges, [regatta_base::graph::EdgeIndex(0)]);
    let a_loop =
        "- {Id: 4, Origin_ID: 2, Destination_ID: 2, CurveType: Linear, VelocityForward: 1}\n";
    let doors = "Doors:\n- {Name: D, Edges: [4]}\n- {Name: E, Edges: [2, 4]}\n";
    let (graph, fixes) = fixed(&with_a_copy(&format!("{a_loop}{doors}")));
    assert_eq!(graph.doors().len(), 1, "{fixes:?}");
    assert!(fixes[2].contains("door `D`: removed"), "{fixes:?}");
}

#[test]
fn ends_in_a_chain_are_joined_with_the_one_that_stays() {
    let text = "id,x,y,role\nA,0,0,pick\nB,10,0,drop\nE1,10.03,5,\nE2,10.06,5,\n\
                E3,10.03,5.03,\nF,0,5,\n\nfrom,to\nA,B\nB,A\nB,E1\nE2,F\nF,A\nE3,E1\n";
    let (graph, fixes) = fixed(text);
    assert_eq!((graph.nodes().len(), fixes.len()), (5, 1), "{fixes:?}");
    let without_edge = text.replace("E3,E1\n", "E3,A\n");
    let (graph, fixes) = fixed(&without_edge);
    assert_eq!((graph.nodes().len(), fixes.len()), (4, 2), "{fixes:?}");
    assert_eq!(graph.nodes_named("E3"), graph.nodes_named("E1"));
}

#[test]
fn joined_nodes_are_replaced_in_zones_and_stations() {
    let nodes = "Vertices:\n- {Id: 1, X: 0, Y: 0, Theta: 0}\n- {Id: 2, X: 10, Y: 0, Theta: 0}\n\
                 - {Id: 3, X: 10.02, Y: 0, Theta: 0}\n- {Id: 4, X: 20, Y: 0, Theta: 0}\n";
    let edges = format!(
        "Edges:\n- {{Id: 1, Origin_ID: 1, Destination_ID: 2, {EDGE}, VelocityBackwards: 1}}\n\
         - {{Id: 2, Origin_ID: 3, Destination_ID: 4, {EDGE}, VelocityBackwards: 1}}\n"
    );
    let rest = "Zones:\n- {Name: Z, Capacity: 1, Nodes: [3], Edges: []}\n\
                Stations:\n- {Name: S, Role: pick, Nodes: [3, 2]}\n";
    let (graph, fixes) = fixed(&format!("{nodes}{edges}{rest}"));
    let kept = graph.node_by_id(2).expect("node 2");
    assert_eq!(graph.zones()[0].nodes, [kept], "{fixes:?}");
    assert_eq!(graph.stations()[0].nodes, [kept], "{fixes:?}");
}

#[test]
fn nodes_of_different_levels_are_never_joined() {
    let text = |levels: [&str; 2]| {
        let [a, b] = levels;
        format!(
            "id,x,y,level\nA,0,0,{a}\nB,10,0,{a}\nC,10.04,0,{b}\nD,20,0,{b}\n\n\
             from,to\nA,B\nC,D\n"
        )
    };
    assert_eq!(fixed(&text(["G", "U"])).1, [""; 0]);
    assert_eq!(fixed(&text(["G", "G"])).1.len(), 1);
}

#[test]
fn joined_nodes_keep_their_names_and_roles() {
    let text = "id,x,y,role\nA,0,0,pick\nB,10,0,\nC,10.04,0,drop\nD,20,0,\n\n\
                from,to\nA,B\nB,A\nC,D\nD,C\n";
    let (graph, fixes) = fixed(text);
    let joined = graph.nodes_named("C")[0];
    assert_eq!(graph.node(joined).name(), Some("B"));
    assert_eq!(graph.node(joined).role, crate::Role::Drop);
    assert_eq!(
        fixes,
        ["node 3 (`C`): joined with node 2 (`B`), 0.040 m away; its role drop is kept; `C` is \
          another name of it now"]
    );
    let (graph, fixes) = fixed(&text.replace("B,10,0,", "B,10,0,pick"));
    assert_eq!((graph.nodes().len(), fixes.len()), (4, 0), "a role would be lost: {fixes:?}");
}

#[test]
fn gaps_that_a_check_tells_are_closed() {
    let roads = |x: &str| {
        format!(
            "id,x,y,role\nA,0,0,pick\nB,10,0,\nC,{x},0,\nD,20,0,drop\n\n\
             from,to,speed,bidirectional\nA,B,1,yes\nC,D,1,yes\n"
        )
    };
    let told = |text: &str| {
        let (_, findings) = parse(text, "g", &ReadOptions::default()).expect("a graph");
        let messages = findings.as_slice().iter().map(|found| found.message.clone());
        messages.filter(|message| message.contains("no edge joins them")).collect::<Vec<_>>()
    };
    let messages = told(&roads("10.04"));
    assert_eq!(messages.len(), 1, "{messages:?}");
    assert!(messages[0].contains("0.040 m from node `C`"), "{messages:?}");
    let (graph, fixes) = fixed(&roads("10.04"));
    assert_eq!((graph.nodes().len(), fixes.len()), (3, 1), "{fixes:?}");
    let messages = told(&roads("10.06"));
    assert!(messages[0].ends_with("joins ends up to 0.05 m apart only"), "{messages:?}");
    assert_eq!((told(&roads("10.3")), fixed(&roads("10.06")).1.len()), (Vec::new(), 0));
    // A node in the middle of a road is no end.
    let through = "id,x,y\nA,0,0\nB,10,0\nC,20,0\nD,10,0.04\nE,0,9\nF,20,9\n\n\
                   from,to,speed,bidirectional\nA,B,1,yes\nB,C,1,yes\nE,D,1,yes\nD,F,1,yes\n";
    assert_eq!((told(through), fixed(through).1.len()), (Vec::new(), 0));
}

#[test]
fn the_name_of_a_removed_edge_is_kept_or_told() {
    let edge = |id: u32, more: &str| {
        format!("- {{Id: {id}, Origin_ID: 1, Destination_ID: 2, {EDGE}{more}}}\n")
    };
    let text = format!(
        "Vertices:\n- {{Id: 1, X: 0, Y: 0, Theta: 0}}\n- {{Id: 2, X: 5, Y: 0, Theta: 0}}\n\
         Edges:\n{}{}{}",
        edge(1, ""),
        edge(2, ", Name: gate"),
        edge(3, ", Name: hall"),
    );
    let (graph, fixes) = fixed(&text);
    assert_eq!(graph.edges()[0].name(), Some("gate"));
    let expected = [
        "edge 2 (`gate`): removed, it is the same as edge 1; its name `gate` is kept",
        "edge 3 (`hall`): removed, it is the same as edge 1 (`gate`); no edge has the name `hall` \
         now",
    ];
    assert_eq!(fixes, expected);
}
