use std::collections::BTreeMap;
use std::f64::consts::PI;

use proptest::prelude::*;

use super::*;
use crate::model::finding::Findings;
use crate::model::format::Format;
use crate::model::options::ReadOptions;
use crate::model::tags::{Orientation, Role};
use crate::model::zones::ZoneRule;
use crate::parse;
use crate::read::file::{GraphError, Source};
use crate::read::layout::{Layout, LayoutNode};
use crate::read::read_layout;

fn sample(name: &str) -> String {
    let path = format!("{}/../../graphs/imported/open-rmf/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(&path).expect(&path)
}

/// Reads a text; it must not have errors, though a level may have no lanes.
fn layout_of(text: &str, level: Option<&str>) -> (Layout, Findings) {
    let mut report = Report::new("test", text);
    let source = Source { text, folder: std::path::Path::new(""), stem: "test" };
    let options = ReadOptions { level: level.map(str::to_owned), ..ReadOptions::default() };
    let layout = read_layout(Format::detect(text), source, &options, &mut report).expect("a map");
    let findings = report.into_findings();
    let error = findings.first_error().filter(|error| !error.message.starts_with("no lanes"));
    assert_eq!(error, None);
    (layout, findings)
}

fn messages(findings: &Findings) -> String {
    findings.as_slice().iter().map(|finding| format!("{finding}\n")).collect()
}

fn place(node: &LayoutNode) -> DVec2 {
    node.position.expect("a position")
}

fn node<'a>(layout: &'a Layout, id: &str) -> &'a LayoutNode {
    layout.nodes.iter().find(|node| node.id == id).unwrap_or_else(|| panic!("no node {id}"))
}

fn errors_of(text: &str) -> String {
    match parse(text, "map.yaml", &ReadOptions::default()) {
        Err(GraphError::Invalid(findings)) => messages(&findings),
        Err(other) => other.to_string(),
        Ok(_) => String::new(),
    }
}

#[test]
fn every_sample_is_read_completely() {
    let cases = [
        ("battle_royale/0.yaml", 21, 40),
        ("campus/0.yaml", 145, 181),
        ("hotel/0.yaml", 55, 104 + 8),
        ("hotel/1.yaml", 20, 38),
        ("hotel/2.yaml", 54, 102 + 8),
        ("office/0.yaml", 29, 60),
        ("battle_royale.building.yaml", 21, 40),
        ("campus.building.yaml", 145, 181),
        ("hotel.building.yaml", 75, 244 + 8),
        ("office.building.yaml", 29, 60),
    ];
    for (name, nodes, edges) in cases {
        let text = sample(name);
        let (graph, findings) = parse(&text, name, &ReadOptions::default()).expect(name);
        assert_eq!((graph.nodes().len(), graph.edges().len()), (nodes, edges), "{name}");
        let of_routes = ["of a lane", "of a vertex:"];
        assert!(
            !of_routes.iter().any(|what| messages(&findings).contains(what)),
            "{name}: {}",
            messages(&findings)
        );
    }
}

#[test]
fn positions_names_and_roles_of_the_office() {
    let (layout, _) = layout_of(&sample("office/0.yaml"), None);
    let supplies = node(&layout, "presupplies");
    assert_eq!(place(supplies), DVec2::new(7.034_165_963_251_511, -2.110_989_673_230_760_5));
    assert_eq!(supplies.tags.level.as_deref(), Some("L1"));
    assert_eq!(
        place(node(&layout, "L1/3")),
        DVec2::new(18.739_524_294_973_8, -6.873_981_868_527_042)
    );
    assert_eq!(node(&layout, "tinyRobot1_charger").role, Role::Charge);
    assert_eq!(node(&layout, "pantry").role, Role::Pick);
    assert_eq!(node(&layout, "coe").role, Role::Drop);
    assert_eq!(node(&layout, "supplies").role, Role::Park);
    let doors: Vec<_> = layout
        .edges
        .iter()
        .filter(|edge| edge.tags.zone.as_deref() == Some("door coe_door"))
        .collect();
    assert_eq!(doors.iter().map(|edge| edge.id.as_str()).collect::<Vec<_>>(), ["L1/38", "L1/39"]);
    assert_eq!(doors[0].tags.properties.get("door_name").map(|name| &**name), Some("coe_door"));
    let stations: Vec<_> =
        layout.stations.iter().map(|station| (station.name.as_str(), station.role)).collect();
    assert_eq!(
        stations,
        [
            ("coke_dispenser", Role::Pick),
            ("coke_ingestor", Role::Drop),
            ("coke_ingestor_2", Role::Drop)
        ]
    );
    assert_eq!(layout.background.len(), 1, "no lane leads through the main door");
}

#[test]
fn rides_between_levels_of_different_heights_are_told() {
    let text = sample("hotel.building.yaml");
    let told = |text: &str| {
        let (_, findings) = parse(text, "h.yaml", &ReadOptions::default()).expect("a graph");
        let list = findings.as_slice().iter().map(ToString::to_string);
        list.filter(|message| message.contains("each ride")).collect::<Vec<_>>()
    };
    assert_eq!(told(&text), [""; 0], "all levels are 8 m apart");
    let told = told(&text.replace("elevation: 16", "elevation: 24"));
    assert!(told[0].contains("lift `Lift1`: its levels are 8.00 to 16.00 m apart"), "{told:?}");
    assert!(told[0].contains("takes 8.0 s, the time for the mean"), "{told:?}");
}

#[test]
fn a_building_has_the_times_of_its_doors_and_lifts() {
    let (graph, _) =
        parse(&sample("hotel.building.yaml"), "h.yaml", &ReadOptions::default()).expect("a graph");
    let [first, second] = graph.lifts() else { panic!("{:?}", graph.lifts()) };
    assert_eq!((&*first.name, &*second.name), ("Lift1", "Lift2"));
    let levels: Vec<_> = first.levels.iter().map(|level| &*level.name).collect();
    assert_eq!(levels, ["L1", "L2", "L3"]);
    assert!((first.level_secs - 6.0).abs() < 1e-9, "8 m at 2 m/s, with 1 m/s²");
    assert!((first.door_times.opening_secs - 6.75).abs() < 1e-9, "a leaf of 0.85 m");
    assert_eq!(first.cabin.map(|cabin| cabin.size), Some(DVec2::splat(2.7)));
    let door = graph.doors().iter().find(|door| &*door.name == "L1_door1").expect("a door");
    assert!((door.times.opening_secs - 6.472).abs() < 1e-3, "a quarter of a turn");
    let crossed = door.edges.iter().map(|edge| door.place(&graph.edge(*edge).path));
    assert!(
        crossed
            .zip(&door.edges)
            .all(|(place, edge)| { place > 0.0 && place < graph.edge(*edge).path.length() })
    );
}

#[test]
fn lifts_join_the_levels_of_the_hotel() {
    let (layout, findings) = layout_of(&sample("hotel/0.yaml"), None);
    assert!(
        messages(&findings).contains("3 levels (L1, L2, L3) lie over each other"),
        "{}",
        messages(&findings)
    );
    let lifts: Vec<_> = layout.edges.iter().filter(|edge| edge.id.starts_with("lift ")).collect();
    assert_eq!(lifts.len(), 8, "also where the vertices are at the same place");
    assert_eq!((lifts[0].origin.as_str(), lifts[0].destination.as_str()), ("L1/9", "L2/15"));
    assert_eq!(lifts[0].tags.zone.as_deref(), Some("lift Lift1"));
    assert_eq!(node(&layout, "L1/9").tags.zone.as_deref(), Some("lift Lift1"));
    let cabin = layout.zones.iter().find(|zone| zone.name == "lift Lift1").expect("a zone");
    assert_eq!((cabin.rule, cabin.nodes.len(), cabin.edges.len()), (ZoneRule::EXCLUSIVE, 3, 4));
    let served: Vec<_> =
        layout.lifts.iter().map(|lift| (lift.name.as_str(), lift.nodes.len())).collect();
    assert_eq!(served, [("Lift1", 3), ("Lift2", 3)]);
    let doors: Vec<_> = layout.doors.iter().map(|door| door.name.as_str()).collect();
    assert_eq!(
        doors,
        ["L1_door1", "L1_door2", "L2_door2", "L3_door2"],
        "the others are drawn only"
    );
    assert!(layout.doors.iter().all(|door| door.line.is_some() && door.edges.len() == 2));
    let (layout, findings) = layout_of(&sample("hotel/0.yaml"), Some("L2"));
    assert_eq!((layout.nodes.len(), layout.edges.len()), (17, 32));
    assert!(!messages(&findings).contains("lie over"));
    assert!(errors_of(&sample("office/0.yaml")).is_empty());
    let options = ReadOptions { level: Some("L9".into()), ..ReadOptions::default() };
    let error = parse(&sample("hotel/0.yaml"), "h.yaml", &options).expect_err("no such level");
    assert!(
        messages(error.findings().expect("findings"))
            .contains("there is no level `L9`: use one of L1, L2, L3")
    );
}

/// Levels of a file may stand in any order, and a lift may pass some.
#[test]
fn rides_lead_from_a_level_to_the_next_above_at_which_the_lift_stops() {
    let hotel = sample("hotel.building.yaml");
    let rides = |text: &str| {
        let (graph, _) = parse(text, "h.yaml", &ReadOptions::default()).expect("a graph");
        let lift = &graph.lifts()[0];
        let levels: Vec<String> = lift.levels.iter().map(|level| level.name.to_string()).collect();
        (levels.join(" "), lift.level_secs)
    };
    let (levels, secs) = rides(&hotel);
    assert_eq!(levels, "L1 L2 L3");
    let upside_down = hotel
        .replace("elevation: 16", "elevation: -8")
        .replace("highest_floor: L3", "highest_floor: L2")
        .replace("lowest_floor: L1", "lowest_floor: L3");
    assert_eq!(rides(&upside_down), ("L3 L1 L2".to_owned(), secs));
}

#[test]
fn a_lift_without_vertices_on_a_level_is_told() {
    let level = |name: &str, lift: &str| {
        format!(
            "  {name}:\n    lanes: [[0, 1, {{}}], [1, 0, {{}}]]\n    vertices: [[0, 0, {{{lift}}}], \
             [3, 0, {{}}]]\n"
        )
    };
    let of = |first: &str| {
        let levels = [level("L1", first), level("L2", "lift: A")].concat();
        messages(&layout_of(&format!("building_name: x\nlevels:\n{levels}lifts: {{}}\n"), None).1)
    };
    let passed = [level("L1", "lift: A"), level("L2", ""), level("L3", "lift: A")].concat();
    let passed = format!("building_name: x\nlevels:\n{passed}lifts: {{}}\n");
    let told = messages(&layout_of(&passed, None).1);
    assert!(told.contains("has no vertex on L2: its ride from L1 to L3 takes the time"), "{told}");
    let told = "lift `A` joins no levels: it has vertices on L2 only";
    assert!(of("").contains(told), "{}", of(""));
    assert!(!of("lift: A").contains(told), "{}", of("lift: A"));
}

/// The vertices of the generator's graph, and its lanes as pairs of them, each by its nearest in
/// ours.
fn compare(ours: &Layout, theirs: &Layout) {
    let nearest = |node: &LayoutNode| {
        let level = ours.nodes.iter().filter(|ours| ours.tags.level == node.tags.level);
        level.min_by(|a, b| {
            place(a).distance(place(node)).total_cmp(&place(b).distance(place(node)))
        })
    };
    let mut ids = BTreeMap::new();
    for node in &theirs.nodes {
        let our = nearest(node).expect("a node");
        let distance = place(our).distance(place(node));
        assert!(distance < 1e-3, "{} is {distance} m from {}", node.id, our.id);
        let name = |node: &LayoutNode| {
            node.id
                .split('/')
                .next_back()
                .filter(|id| id.parse::<u32>().is_err())
                .map(str::to_owned)
        };
        assert_eq!(name(our), name(node));
        assert_eq!(our.role, node.role, "{}", node.id);
        assert_eq!(our.tags.zone, node.tags.zone, "{}", node.id);
        ids.insert(node.id.as_str(), our.id.as_str());
    }
    for edge in &theirs.edges {
        let ends = (ids[edge.origin.as_str()], ids[edge.destination.as_str()]);
        let found: Vec<_> = ours
            .edges
            .iter()
            .filter(|our| (our.origin.as_str(), our.destination.as_str()) == ends)
            .collect();
        assert_eq!(found.len(), 1, "{}", edge.id);
        assert_eq!(found[0].tags.zone, edge.tags.zone, "{}", edge.id);
        assert_eq!(found[0].orientation, edge.orientation);
    }
}

#[test]
fn maps_agree_with_the_graphs_that_open_rmf_makes_of_them() {
    for name in ["office", "campus", "battle_royale"] {
        let (ours, _) = layout_of(&sample(&format!("{name}.building.yaml")), None);
        let (theirs, _) = layout_of(&sample(&format!("{name}/0.yaml")), None);
        assert_eq!(
            (ours.nodes.len(), ours.edges.len()),
            (theirs.nodes.len(), theirs.edges.len()),
            "{name}"
        );
        compare(&ours, &theirs);
    }
}

#[test]
fn levels_are_aligned_as_open_rmf_does() {
    let text = sample("hotel.building.yaml");
    for level in ["L1", "L2", "L3"] {
        let (all, findings) = layout_of(&text, Some(level));
        assert!(messages(&findings).contains("3 graphs of different fleets"));
        for graph in ["0", "1", "2"] {
            let (theirs, _) = layout_of(&sample(&format!("hotel/{graph}.yaml")), Some(level));
            let (mut ours, _) = layout_of(&text, Some(level));
            ours.edges.retain(|edge| {
                edge.tags.properties.get("graph_idx").map(|index| &**index) == Some(graph)
            });
            ours.nodes.retain(|node| {
                ours.edges.iter().any(|edge| edge.origin == node.id || edge.destination == node.id)
            });
            assert_eq!(
                (ours.nodes.len(), ours.edges.len()),
                (theirs.nodes.len(), theirs.edges.len()),
                "{level} {graph}"
            );
            compare(&ours, &theirs);
        }
        assert!(!all.background.is_empty());
    }
}

#[test]
fn walls_and_floors_are_the_background() {
    let (layout, findings) = layout_of(&sample("office.building.yaml"), None);
    assert_eq!(layout.background.len(), 33 + 1 + 4, "walls, the door without a lane, floors");
    assert!(layout.background.iter().all(|line| line.level.as_deref() == Some("L1")));
    assert_eq!(layout.stations[0].name, "coke_dispenser");
    assert!(layout.stations[0].position.expect("a place").distance(DVec2::new(17.76, -5.50)) < 0.1);
    assert!(
        messages(&findings).is_empty() || !messages(&findings).contains("disagree"),
        "{}",
        messages(&findings)
    );
}

#[test]
fn orientation_speed_and_zones_of_lanes() {
    let text = "levels:\n  A:\n    vertices:\n    - [0, 0, {name: a, mutex: m}]\n    - [5, 0, {name: b}]\n    - [5, 5, {name: b}]\n    \
                lanes:\n    - [0, 1, {orientation_constraint: backward, speed_limit: 0.5, mutex: x, door_name: d}]\n    \
                - [1, 2, {speed_limit: 0, is_bidirectional: true, dock_name: dock}]\n    - [2, 2, {}]\n    - [2, 0, {odd: {a: 1}}]\n";
    let (layout, findings) = layout_of(text, None);
    assert_eq!(
        layout.nodes.iter().map(|node| node.id.as_str()).collect::<Vec<_>>(),
        ["a", "A/1", "A/2"]
    );
    assert_eq!(node(&layout, "A/1").tags.name.as_deref(), Some("b"));
    assert_eq!(node(&layout, "a").tags.zone.as_deref(), Some("m"));
    let [first, second, third, last] = layout.edges.as_slice() else {
        panic!("{:?}", layout.edges)
    };
    assert_eq!((first.orientation, first.speed), (Orientation::Offset(PI), Some(0.5)));
    assert_eq!(first.tags.zone.as_deref(), Some("x"));
    let zones = layout.zones.iter().map(|zone| (zone.name.as_str(), &*zone.nodes, &*zone.edges));
    let expected: [(&str, &[usize], &[usize]); 2] = [("m", &[0], &[]), ("x", &[], &[0])];
    assert_eq!(zones.collect::<Vec<_>>(), expected, "a door is no mutex");
    assert_eq!((second.id.as_str(), second.speed), ("A/1", None));
    assert_eq!((third.id.as_str(), third.origin.as_str()), ("A/1/reverse", "A/2"));
    assert_eq!(third.tags.properties.get("undock_name").map(|name| &**name), Some("dock"));
    assert_eq!(last.id, "A/3");
    let messages = messages(&findings);
    assert!(messages.contains("test:10: warning: lane `A/2` starts and ends"), "{messages}");
    assert!(messages.contains("key `odd` of a lane: not used"), "{messages}");
}

#[test]
fn measurements_that_disagree_are_reported() {
    let map = |second: f64| {
        format!(
            "levels:\n  A:\n    measurements:\n    - [0, 1, {{distance: [3, 1]}}]\n    - [1, 2, {{distance: [3, {second}]}}]\n    \
             vertices:\n    - [0, 0, 0, a]\n    - [100, 0, 0, b]\n    - [100, 50, 0, '']\n    lanes:\n    \
             - [0, 1, {{bidirectional: [4, true], orientation: [1, forward]}}]\n"
        )
    };
    let (layout, findings) = layout_of(&map(0.5), None);
    assert_eq!(place(node(&layout, "b")), DVec2::new(1.0, 0.0));
    assert_eq!(
        layout.edges.iter().map(|edge| edge.orientation).collect::<Vec<_>>(),
        [Orientation::Tangential, Orientation::Offset(PI)]
    );
    assert_eq!(messages(&findings), "");
    let (layout, findings) = layout_of(&map(1.0), None);
    assert!(place(node(&layout, "b")).distance(DVec2::new(1.5, 0.0)) < 1e-12);
    assert!(
        messages(&findings).contains("disagree: 0.01000 to 0.02000 m per pixel"),
        "{}",
        messages(&findings)
    );
}

#[test]
fn cartesian_maps_keep_their_coordinates() {
    let text = "coordinate_system: cartesian_meters\nlevels:\n  A:\n    vertices:\n    - [1, 2, 0, a]\n    - [3, 4, 0, b]\n    lanes:\n    \
                - [0, 1, {}]\n";
    assert_eq!(place(node(&layout_of(text, None).0, "b")), DVec2::new(3.0, 4.0));
    let text = text.replace("cartesian_meters", "web_mercator");
    assert!(
        errors_of(&text).contains("coordinate system `web_mercator` can't be read"),
        "{}",
        errors_of(&text)
    );
}

#[test]
fn broken_files_say_what_to_do() {
    let cases = [
        ("levels: {}\n", "no `levels`"),
        (
            "levels:\n  A:\n    vertices:\n    - [x, 1]\n    lanes: []\n",
            "4: error: a vertex is a list",
        ),
        (
            "levels:\n  A:\n    vertices:\n    - [0, 1]\n    lanes:\n    - [0, 7, {}]\n",
            "6: error: a lane joins the vertices 0 and 7",
        ),
        (
            "levels:\n  A:\n    vertices:\n    - [0, 1]\n    lanes:\n    - [0, -1, {}]\n",
            "6: error: a lane is a list",
        ),
        ("levels:\n  A:\n    vertices: []\n", "has no nodes"),
        (
            "levels:\n  A:\n    vertices:\n    - [.inf, 1]\n    - [.nan, 1]\n",
            "4: error: a vertex is",
        ),
        ("levels: [\n", "map.yaml:"),
        (
            "levels:\n  A:\n    vertices:\n    - [[1]]\n    - [0, 1]\n",
            "4: error: a vertex is a list",
        ),
        ("levels: [[[1]]]\n", "it has no `levels`"),
    ];
    for (text, expected) in cases {
        assert!(errors_of(text).contains(expected), "{text}\n{}", errors_of(text));
    }
}

#[test]
fn long_names_are_not_copied() {
    let long = "n".repeat(101);
    let text = format!(
        "levels:\n  A:\n    vertices: [[0, 1, {{name: {long}}}], [3, 4, {{}}]]\n    lanes: [[0, 1, {{}}]]\n"
    );
    let (layout, _) = layout_of(&text, None);
    assert_eq!(
        (layout.nodes[0].id.as_str(), layout.nodes[0].tags.name.as_deref()),
        ("A/0", Some(long.as_str()))
    );
    let (layout, _) = layout_of(&text.replace(&long, &long[1..]), None);
    assert_eq!(layout.edges[0].origin, long[1..]);
    let map = |name: &str| {
        format!(
            "coordinate_system: cartesian_meters\nlevels:\n  A:\n    vertices: [[0, 0, 0, a, {{dock_name: [1, {name}]}}], \
             [2, 0, 0, b], [1, -1, 0, c], [1, 1, 0, d]]\n    lanes: [[0, 1, {{}}]]\n    doors: [[2, 3, {{name: [1, {name}]}}]]\n\
             lifts:\n  {name}: {{x: 2, y: 0, width: 1, depth: 1, level_doors: {{A: [d]}}}}\n"
        )
    };
    let (layout, _) = layout_of(&map(&long[1..]), None);
    let properties = &layout.edges[0].tags.properties;
    assert_eq!(["door_name", "undock_name"].map(|key| &*properties[key]), [&long[1..]; 2]);
    assert_eq!(*node(&layout, "b").tags.properties["lift"], long[1..]);
    let (layout, findings) = layout_of(&map(&long), None);
    let properties = &layout.edges[0].tags.properties;
    assert!(["door_name", "undock_name"].iter().all(|key| !properties.contains_key(*key)));
    assert!(node(&layout, "b").tags.properties.is_empty());
    let messages = messages(&findings);
    for what in
        ["name of the door `n", "name of the lift `n", "dock with a name of more than 100 bytes"]
    {
        assert!(messages.contains(what), "{messages}");
    }
}

/// Reads any text in both ways: it must return.
fn read_both(text: &str) {
    for format in [Format::OpenRmf, Format::OpenRmfBuilding] {
        let options = ReadOptions { format: Some(format), ..ReadOptions::default() };
        drop(parse(text, "map.yaml", &options));
    }
}

#[test]
fn a_map_without_lanes_says_so() {
    for text in [
        "building_name: hall\nlevels:\n  L1:\n    vertices:\n    - [0, 0, {name: a}]\n    lanes: []\n",
        "coordinate_system: cartesian_meters\nlevels:\n  L1:\n    vertices:\n    - [0, 0, 0, a]\n    walls: []\n",
    ] {
        let error = parse(text, "m.yaml", &ReadOptions::default()).expect_err(text).to_string();
        assert!(error.contains("no lanes on its levels (L1)"), "{error}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn changed_samples_dont_panic(which in 0..3_usize, at in 0.0..1.0_f64, length in 0..40_usize, with in "[-0-9a-z:,.{}\\[\\]&*# \n]{0,12}") {
        let name = ["office/0.yaml", "battle_royale.building.yaml", "hotel/1.yaml"][which];
        let text = sample(name);
        let start = text.floor_char_boundary((text.len() as f64 * at) as usize);
        let end = text.floor_char_boundary((start + length).min(text.len()));
        read_both(&format!("{}{with}{}", &text[..start], &text[end..]));
        read_both(&text[..start]);
    }

    #[test]
    fn any_numbers_dont_panic(numbers in prop::collection::vec(prop_oneof![any::<f64>(), -3.0..3.0_f64], 12)) {
        let n = |index: usize| numbers[index];
        let text = format!(
            "levels:\n  A:\n    vertices: [[{}, {}, 0, a], [{}, {}, 0, b]]\n    lanes: [[0, 1, {{speed_limit: [3, {}]}}]]\n    \
             fiducials: [[{}, {}, f], [{}, {}, g]]\n    measurements: [[0, 1, {{distance: [3, {}]}}]]\n  \
             B:\n    vertices: [[1, 2, 0, c], [3, 4, 0, d]]\n    lanes: [[0, 1, {{}}]]\n    fiducials: [[{}, {}, f], [3, 4, g]]\n",
            n(0), n(1), n(2), n(3), n(4), n(5), n(6), n(7), n(8), n(9), n(10), n(11)
        );
        read_both(&text);
        read_both(&format!("coordinate_system: wgs84\nparameters: {{generate_crs: [1, 'EPSG:32632']}}\n{text}"));
    }
}

#[test]
fn old_maps_without_a_coordinate_system_are_told_by_their_vertices() {
    let text = "levels:\n  A:\n    vertices: [[0, 1, 0, a], [3, 4, 0, b]]\n    lanes: [[0, 1, {bidirectional: [4, true]}]]\n";
    assert_eq!(Format::detect(text), Format::OpenRmf);
    let (layout, findings) = layout_of(text, None);
    assert_eq!((place(node(&layout, "b")), layout.edges.len()), (DVec2::new(3.0, -4.0), 2));
    assert!(messages(&findings).contains("one pixel is read as one metre"));
}

#[test]
fn what_a_building_map_says_besides_routes_is_listed_once_by_kind() {
    let (_, findings) = layout_of(&sample("office.building.yaml"), None);
    let messages = messages(&findings);
    for kind in [
        "`crowd_sim` of the file",
        "`drawing` of a level",
        "`layers` of a level",
        "`parameters` of a floor",
    ] {
        assert_eq!(
            messages.matches(&format!("key {kind}: not used")).count(),
            1,
            "{kind}: {messages}"
        );
    }
    assert_eq!(
        messages.matches("model that is neither a dispenser nor an ingestor: not used (").count(),
        1
    );
    assert!(messages.contains("test:2: warning: key `crowd_sim` of the file"), "{messages}");
}

#[test]
fn empty_values_and_zero_heights_are_not_listed() {
    let map = |z: u32, more: &str| {
        format!(
            "coordinate_system: cartesian_meters\n{more}levels:\n  L:\n    vertices: [[0, 0, {z}, a], [9, 0, {z}, b]]\n    \
             lanes: [[0, 1, {{}}]]\n    models: []\n    drawing: {{filename: ''}}\n"
        )
    };
    let not_used = |text: &str| messages(&layout_of(text, None).1).matches("not used").count();
    assert_eq!(not_used(&map(0, "crowd_sim: {goal_sets: []}\n")), 0);
    assert_eq!(not_used(&map(1, "")), 1);
    assert_eq!(not_used(&map(1, "odd: 1\n")), 2);
}
