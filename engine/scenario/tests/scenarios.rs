//! Tests valid scenarios, and the errors of invalid ones.

use std::path::Path;

use regatta_layout::{Role, ZoneRule};
use regatta_scenario::{Overrides, Scenario, ScenarioError, Shape, Start};

/// Nodes 1, 2 and 3 in a row; edges 10 (1 to 2), 11 (2 to 1) and 12 (2 to 3, also in reverse gear).
const GRAPH: &str = "
Vertices:
- {Id: 1, X: 0, Y: 0, Theta: 0}
- {Id: 2, X: 5, Y: 0, Theta: 0}
- {Id: 3, X: 9, Y: 0, Theta: 0}
Edges:
- {Id: 10, Origin_ID: 1, Destination_ID: 2, CurveType: linear, VelocityForward: 1}
- {Id: 11, Origin_ID: 2, Destination_ID: 1, CurveType: linear, VelocityForward: 1}
- {Id: 12, Origin_ID: 2, Destination_ID: 3, CurveType: linear, VelocityForward: 1, VelocityBackwards: 0.5}
";

fn read(text: &str) -> Result<Scenario, ScenarioError> {
    let text = format!("graph: roads.yaml\n{text}");
    Scenario::from_texts(&text, GRAPH, Path::new("plant.yaml"), &Overrides::default())
}

#[test]
fn a_valid_scenario_is_resolved() {
    let scenario = read(
        "rate: 200\npublish_rate: 50\nseed: 3
robot_types:
- {name: tug, length: 1.2, width: 0.8, max_speed: 1.5, max_acceleration: 0.5}
- {name: disc, shape: circle, length: 0.7}
robots:
- {route: [10, 12, -12], repeat: once}
- {count: 3, type: disc, routes: random}
- {node: 3}",
    )
    .expect("a valid scenario");
    assert_eq!(
        (scenario.tick_period.as_millis(), scenario.ticks_per_frame, scenario.seed),
        (5, 4, 3)
    );
    let [tug, disc] = &scenario.robot_types[..] else { panic!("two types") };
    assert_eq!((tug.shape, tug.max_acceleration), (Shape::Rectangle, 0.5));
    assert_eq!(
        (disc.shape, disc.length, disc.width, disc.max_speed),
        (Shape::Circle, 0.7, 0.7, f32::INFINITY)
    );
    assert_eq!(scenario.robots(), 5);
    assert_eq!(scenario.group_of(3).robot_type, 1);
    assert!(
        matches!(&scenario.group_of(5).start, Start::Route { legs, .. } if legs.len() == 3),
        "groups repeat"
    );
    assert!(matches!(scenario.group_of(4).start, Start::Node(_)));
}

#[test]
fn nodes_get_the_roles_and_names_of_the_scenario() {
    let nodes =
        "nodes: {1: {role: pick, name: A1}, 3: {name: Dock}}\nrobots: [{count: 2, routes: none}]";
    let scenario = read(nodes).expect("a valid scenario");
    let nodes: Vec<_> =
        scenario.graph.nodes().iter().map(|node| (node.role, node.name())).collect();
    assert_eq!(nodes, [(Role::Pick, Some("A1")), (Role::None, None), (Role::None, Some("Dock"))]);
    assert!(matches!(scenario.group_of(1).start, Start::Standing));
}

#[test]
fn an_error_names_the_entry_and_what_to_do() {
    let robots = "robots: [{route: [10]}]";
    for (text, place, advice) in [
        (
            "robots: [{route: [10, 10]}]",
            "robots, entry 1",
            "edge 10 ends at node 2, but edge 10 starts at node 1",
        ),
        ("robots: [{node: 1}, {route: [99]}]", "robots, entry 2", "no edge 99"),
        ("robots: [{route: [-10]}]", "robots, entry 1", "VelocityBackwards"),
        (
            "robots: [{route: [10], repeat: loop}]",
            "robots, entry 1",
            "ends at node 2 and starts at node 1",
        ),
        ("robots: [{route: []}]", "robots, entry 1", "at least one edge"),
        ("robots: [{node: 7}]", "robots, entry 1", "no node 7"),
        ("robots: [{count: 0, node: 1}]", "robots, entry 1", "count is 0"),
        ("robots: [{count: 2}]", "robots, entry 1", "give one of"),
        ("robots: [{node: 1, routes: random}]", "robots, entry 1", "give one of"),
        ("robots: [{type: ghost, node: 1}]", "robots, entry 1", "list it under robot_types"),
        ("nodes: {9: {role: pick}}\nrobots: [{node: 1}]", "nodes, 9", "no node 9"),
        (
            "nodes: {1: {role: dance}}\nrobots: [{node: 1}]",
            "nodes, 1",
            "use none, pick, drop, park, charge or transfer",
        ),
        ("robots: []", "robots", "at least one"),
        (
            "robots: [{count: 4000000000, node: 1}, {count: 4000000000, node: 1}]",
            "robots",
            "at most",
        ),
        (&format!("rate: 0\n{robots}"), "rate", "0 ticks per second is out of range"),
        (&format!("warm_up: -1\n{robots}"), "warm_up", "-1 s is out of range: give 0 to 86400 s"),
        (&format!("rate: .nan\n{robots}"), "rate", "NaN ticks per second"),
        (&format!("publish_rate: 200\n{robots}"), "rate", "not above the rate"),
        (
            &format!("robot_types: [{{name: a, length: -1, width: 1}}]\n{robots}"),
            "robot_types",
            "a robot of -1 m",
        ),
        (
            "robot_types: [{name: tug, length: 1, width: 1}]\nrobots: [{type: tag, node: 1}]",
            "robots, entry 1",
            "'tug'?",
        ),
        (
            &format!("{robots}\nplugins: [{{name: a/b, command: [x]}}]"),
            "plugins",
            "entry 1: '/' in the name \"a/b\"",
        ),
        (
            &format!("robot_types: [{{name: a, length: 1}}]\n{robots}"),
            "robot_types",
            "width is missing",
        ),
        (
            &format!("robot_types: [{{name: a, shape: circle, length: 1, width: 2}}]\n{robots}"),
            "robot_types",
            "leave width out",
        ),
        (
            &format!(
                "robot_types: [{{name: a, length: 1, width: 1}}, {{name: a, length: 2, width: 1}}]\n{robots}"
            ),
            "robot_types",
            "a unique name",
        ),
    ] {
        let message = read(text).expect_err(text).to_string();
        assert!(message.starts_with(&format!("plant.yaml: {place}: ")), "{text}: {message}");
        assert!(message.contains(advice) && message.lines().count() == 1, "{text}: {message}");
    }
}

#[test]
fn extreme_limits_and_sizes_are_refused() {
    let number = |key: &str, value: &str| {
        let sizes = ["length", "width"]
            .map(|size| format!("{size}: {}", if size == key { value } else { "1" }))
            .join(", ");
        let limit =
            if key.starts_with("max") { format!(", {key}: {value}") } else { String::new() };
        read(&format!("robot_types: [{{name: a, {sizes}{limit}}}]\nrobots: [{{node: 1}}]"))
    };
    for (key, advice) in [
        ("max_acceleration", "give 0.001 to 1000000 m/s²"),
        ("max_speed", "give 0.001 to 1000 m/s"),
        ("length", "its length and its width must be 0.001 to 100 m"),
        ("width", "its length and its width must be 0.001 to 100 m"),
    ] {
        for value in ["1.0e-9", "0", "-1", "1.0e30", ".inf", ".nan"] {
            let message = number(key, value).expect_err(value).to_string();
            assert!(
                message.starts_with("plant.yaml: robot_types: a: ") && message.contains(advice),
                "{message}"
            );
        }
        for value in ["0.001", "1", "100"] {
            number(key, value).unwrap_or_else(|error| panic!("{key} {value}: {error}"));
        }
    }
}

#[test]
fn counts_of_robots_may_have_a_unit() {
    let scenario =
        read("robots: [{count: 10k, node: 1}, {count: 1.5M, node: 1}, {count: 7, node: 1}]")
            .expect("valid");
    assert_eq!(scenario.robots(), 1_510_007);
}

#[test]
fn an_error_of_the_yaml_names_line_entry_and_advice_without_words_of_the_program() {
    for (text, expected) in [
        (
            "robots:\n- {rout: [10]}",
            ":3: robots, entry 1: unknown key 'rout'; did you mean 'route'?; possible keys: count, type, route, repeat, \
             routes, node",
        ),
        (
            "robots: [{route: [x10]}]",
            ": robots, entry 1: the graph has no edge with the id or the name 'x10'",
        ),
        (
            "viewer: of\nrobots: [{node: 1}]",
            ":2: viewer: unknown value 'of'; did you mean 'off'?; possible values: auto, on",
        ),
        (
            "robots: [{route: [[1]]}]",
            "entry 1: a list is given, but this must be the id or the name of an edge",
        ),
        (
            "robots: [{node: 1}]\nplugins: [5]",
            ":3: plugins, entry 1: 5 is given, but this must be the name of a plugin",
        ),
        (
            "robots: [{node: 1}]\nplugins: [{nam: x}]",
            ":3: plugins, entry 1: unknown key 'nam'; did you mean 'name'?",
        ),
        (
            "robots: [{node: 1}]\nplugins: [{args: [x]}]",
            ":3: plugins, entry 1: name is missing: add it",
        ),
        (
            "rate: fast\nrobots: [{node: 1}]",
            ":2: rate: the text \"fast\" is given, but this must be a number",
        ),
        (
            "seed: -1\nrobots: [{node: 1}]",
            ":2: seed: -1 is given, but this must be a whole number, 0 or more",
        ),
        (
            "robots: [{count: many, node: 1}]",
            "but this must be a number of robots such as 500, 10k or 1M",
        ),
        ("robots: 5", ":2: robots: 5 is given, but this must be a list"),
        ("rate: 5", ": robots is missing: add it"),
        ("rate: 5\nrate: 6\nrobots: [{node: 1}]", "rate is given twice: remove one"),
        (
            "robots: [{node: 1}]\nlifts: {a: {capacity: 0}}",
            ":3: lifts, a, capacity: 0 is given, but this must be a whole number, 1 or more",
        ),
        (
            "robots: [{node: 1}]\ndoors: {a: {}, b: {}, a: {}}",
            ":3: doors: a is given twice: remove one",
        ),
        (
            "robots: [{node: 1}]\nnodes: {1: {role: pick}, 1: {role: drop}}",
            ":3: nodes: 1 is given twice: remove one",
        ),
        ("Vertices: []", "this is a route graph, not a scenario"),
        ("Handles: b_at_origin", "this is a route graph, not a scenario"),
        ("robots: [", ":3: "),
        ("robots: {", ":2: robots: a map (key: value) is given, but this must be a list"),
    ] {
        let message = read(text).expect_err(text).to_string();
        assert!(
            message.starts_with("plant.yaml:") && message.contains(expected),
            "{text}: {message}"
        );
        assert!(message.lines().count() == 1, "{text}: {message}");
        for word in ["untagged", "variant", "struct ", "field", "u32", "f64", "sequence"] {
            assert!(!message.contains(word) || text.ends_with('['), "{text}: {message}");
        }
    }
    let not_a_map = Scenario::from_text("- 1", Path::new("list.yaml"), &Overrides::default())
        .expect_err("a list");
    assert_eq!(
        not_a_map.to_string(),
        "list.yaml:1: a list is given, but this must be a map with the keys graph and robots"
    );
    let prose = "Ölfässer stehen in der Halle. ".repeat(50);
    let not_a_map = Scenario::from_text(&prose, Path::new("prose.yaml"), &Overrides::default())
        .expect_err("a text")
        .to_string();
    assert!(not_a_map.contains("Ölfässer stehen") && not_a_map.contains("…\" is given"));
    assert!(not_a_map.chars().count() < 200, "{not_a_map}");
}

#[test]
fn a_scenario_is_told_from_a_route_graph() {
    use regatta_scenario::is_scenario;
    assert!(is_scenario("graph: a.yaml\nrobots: 5") && is_scenario("{\"graph\": \"a\"}"));
    assert!(
        !is_scenario(GRAPH)
            && !is_scenario("")
            && !is_scenario("- graph: 1")
            && !is_scenario("graph: [")
    );
}

#[test]
fn a_publish_rate_that_does_not_divide_the_rate_is_rounded_with_a_warning() {
    let scenario =
        read("rate: 100\npublish_rate: 40\nrobots: [{node: 1}]").expect("a valid scenario");
    assert_eq!(scenario.ticks_per_frame, 3);
    assert!(
        scenario
            .warnings
            .of_scenario
            .iter()
            .any(|warning| warning.contains(": warning: publish_rate 40 doesn't divide")
                && warning.contains("33.333 frames per second")),
        "{scenario:?}"
    );
    let scenario =
        read("rate: 100\npublish_rate: 50\nrobots: [{node: 1}]").expect("a valid scenario");
    assert!(
        !scenario.warnings.of_scenario.iter().any(|warning| warning.contains("publish_rate")),
        "{scenario:?}"
    );
}

#[test]
fn files_that_can_not_be_read_are_rejected() {
    let read = |path: &str| {
        Scenario::read(Path::new(path), &Overrides::default()).expect_err(path).to_string()
    };
    assert!(read("no/such.yaml").starts_with("no/such.yaml: "));
    assert!(read(env!("CARGO_MANIFEST_DIR")).contains("this is a folder"));
    if cfg!(target_os = "linux") {
        assert!(read("/dev/zero").contains("a pipe or a device"));
    }
}

#[test]
fn plugins_come_after_plugins_of_the_scenario_without_a_cycle() {
    let plugins = |list: &str| read(&format!("robots: [{{node: 1}}]\nplugins: {list}\n"));
    let scenario =
        plugins("[collision, {name: mine, command: [./mine], after: [collision]}]").expect("valid");
    assert_eq!(scenario.plugins[1].after, ["collision"]);
    for (list, expected) in [
        ("[{name: mine, command: [./mine], after: [collision]}]", "which is not among the plugins"),
        ("[{name: a, command: [./a], after: [a]}]", "a come after each other"),
        (
            "[hello, {name: a, command: [./a], after: [b, hello]}, {name: b, command: [./b], after: [a]}]",
            "a and b come after each other",
        ),
    ] {
        let error = plugins(list).expect_err(list).to_string();
        assert!(error.contains("plant.yaml") && error.contains(expected), "{error}");
    }
}

/// Comparing each with all others would take minutes.
#[test]
fn more_plugins_than_a_fleet_has_room_for_are_refused() {
    let after = format!("[hello, {{name: a, after: [{}]}}]", "hello, ".repeat(101));
    for list in [format!("[{}]", "hello, ".repeat(101)), after] {
        let text = format!("robots: [{{node: 1}}]\nplugins: {list}\n");
        let error = read(&text).expect_err("too many").to_string();
        assert!(error.contains("more than 100 names of plugins: remove some"), "{error}");
    }
}

/// Nodes and edges with names: two nodes are called `gate`, one `20`, and one has an alias.
const NAMED: &str = "
Vertices:
- {Id: 10, X: 0, Y: 0, Theta: 0, Name: gate}
- {Id: 20, X: 5, Y: 0, Theta: 0, Name: gate}
- {Id: 30, X: 9, Y: 0, Theta: 0, Name: '20', Properties: {aliases: '[\"dock\"]'}}
Edges:
- {Id: 1, Origin_ID: 10, Destination_ID: 20, CurveType: linear, VelocityForward: 1, Name: in}
- {Id: 2, Origin_ID: 20, Destination_ID: 30, CurveType: linear, VelocityForward: 1, VelocityBackwards: 1, Name: out}
";

fn read_named(robots: &str) -> Result<Scenario, ScenarioError> {
    let text = format!("graph: g.yaml\nrobots: [{robots}]\n");
    Scenario::from_texts(&text, NAMED, Path::new("s.yaml"), &Overrides::default())
}

#[test]
fn nodes_are_found_by_id_and_by_name() {
    for (node, id) in [("20", 20), ("'20'", 30), ("'10'", 10), ("dock", 30)] {
        let scenario = read_named(&format!("{{node: {node}}}")).expect(node);
        let Start::Node(index) = scenario.groups[0].start else { panic!("a node") };
        assert_eq!(scenario.graph.node(index).id, id, "{node}");
    }
    for (node, error) in [
        ("gate", "s.yaml: robots, entry 1: 2 nodes are called 'gate': give the id of one"),
        ("dok", "the graph has no node with the id or the name 'dok'; did you mean 'dock'?"),
        ("99", "the graph has no node 99"),
    ] {
        let message = read_named(&format!("{{node: {node}}}")).expect_err(node).to_string();
        assert!(message.ends_with(error), "{message}");
    }
}

#[test]
fn routes_name_edges() {
    let scenario = read_named("{route: [in, out, -out, '2']}").expect("a route");
    let Start::Route { legs, .. } = &scenario.groups[0].start else { panic!("a route") };
    let legs: Vec<_> =
        legs.iter().map(|leg| (scenario.graph.edge(leg.edge).id, leg.gear)).collect();
    let [there, back] = [regatta_layout::Gear::Forward, regatta_layout::Gear::Reverse];
    assert_eq!(legs, [(1, there), (2, there), (2, back), (2, there)]);
    let between = read_named("{route: [10..20, 20..dock, -20..30]}").expect("a route");
    let Start::Route { legs, .. } = &between.groups[0].start else { panic!("a route") };
    assert_eq!(legs.iter().map(|leg| leg.gear).collect::<Vec<_>>(), [there, there, back]);
    let message = read_named("{route: [10..30]}").expect_err("no edge").to_string();
    assert!(message.contains("no edge of the graph leads from 10 to 30"), "{message}");
    let message = read_named("{route: [inn]}").expect_err("unknown").to_string();
    assert!(message.contains("no edge with the id or the name 'inn'; did you mean 'in'?"));
}

/// A ring of two nodes, a dead end, an island, and a node from which a way leads to the ring.
const PARTS: &str = "
Vertices:
- {Id: 1, X: 0, Y: 0, Theta: 0}
- {Id: 2, X: 5, Y: 0, Theta: 0}
- {Id: 3, X: 9, Y: 0, Theta: 0, Name: dock}
- {Id: 4, X: 0, Y: 50, Theta: 0}
- {Id: 5, X: 0, Y: 5, Theta: 0}
Edges:
- {Id: 1, Origin_ID: 1, Destination_ID: 2, CurveType: linear, VelocityForward: 1}
- {Id: 2, Origin_ID: 2, Destination_ID: 1, CurveType: linear, VelocityForward: 1}
- {Id: 3, Origin_ID: 2, Destination_ID: 3, CurveType: linear, VelocityForward: 1}
- {Id: 4, Origin_ID: 5, Destination_ID: 1, CurveType: linear, VelocityForward: 1}
";

#[test]
fn robots_that_start_where_they_cannot_work_are_named() {
    let warnings = |robots: &str| {
        let text = format!("graph: g.yaml\nrobots: [{robots}]\n");
        let read = Scenario::from_texts(&text, PARTS, Path::new("s.yaml"), &Overrides::default());
        read.expect(robots).warnings.of_scenario
    };
    let cut_off = |robots: &str| {
        warnings(robots)
            .into_iter()
            .find(|warning| warning.contains("outside of the layout's main part"))
    };
    for robots in ["{node: 1}", "{node: 5}", "{count: 2, routes: none}", "{route: [3]}"] {
        assert_eq!(cut_off(robots), None, "{robots}");
    }
    let told = cut_off("{node: 2}, {count: 2, node: dock}, {node: 4}").expect("a warning");
    assert!(
        told.contains("robots 1 (at `dock`), 2 (at `dock`), 3 (at node 4) start outside"),
        "{told}"
    );
}

#[test]
fn a_larger_robot_type_that_no_robot_has_is_told() {
    let warnings = |types: &str| {
        let text = format!("graph: g.yaml\nrobots: [{{node: 1}}]\nrobot_types: [{types}]\n");
        let read = Scenario::from_texts(&text, PARTS, Path::new("s.yaml"), &Overrides::default());
        read.expect(types).warnings.of_scenario
    };
    let small = "{name: small, length: 0.9, width: 0.6}";
    let told = warnings(&format!("{small}, {{name: big, length: 2, width: 0.6}}"));
    assert!(told.iter().any(|line| line.contains("no robot has the type `big`")), "{told:?}");
    let told = warnings(&format!("{small}, {{name: tiny, length: 0.5, width: 0.5}}"));
    assert!(told.iter().all(|line| !line.contains("no robot has")), "{told:?}");
}

#[test]
fn doors_and_lifts_get_the_times_of_the_scenario() {
    let graph = "
Vertices:
- {Id: 1, X: 0, Y: 0, Theta: 0, Level: low}
- {Id: 2, X: 5, Y: 0, Theta: 0, Level: low}
- {Id: 3, X: 7, Y: 0, Theta: 0, Level: high}
Edges:
- {Id: 10, Origin_ID: 1, Destination_ID: 2, CurveType: linear, VelocityForward: 1}
- {Id: 11, Origin_ID: 2, Destination_ID: 3, CurveType: linear, VelocityForward: 1}
Doors:
- {Name: gate, Edges: [10]}
Lifts:
- {Name: north, Nodes: [2, 3], SecondsPerLevel: 8}
";
    let read = |text: &str| {
        let text = format!("graph: roads.yaml\nrobots: [{{node: 1}}]\n{text}");
        Scenario::from_texts(&text, graph, Path::new("plant.yaml"), &Overrides::default())
    };
    let scenario = read(
        "doors: {gate: {closing_secs: 2}}
lifts: {north: {level_secs: 20, opening_secs: 1, capacity: 2, home: high}}",
    );
    let scenario = scenario.expect("a scenario");
    let (door, lift) = (&scenario.graph.doors()[0], &scenario.graph.lifts()[0]);
    assert_eq!((door.times.opening_secs, door.times.closing_secs), (5.0, 2.0));
    assert_eq!((lift.level_secs, lift.door_times.opening_secs, lift.home), (20.0, 1.0, 1));
    let zone = scenario.graph.zones().last().expect("the zone of the lift");
    // Two robots fit into the cabin, but there is one node for them on each level.
    assert_eq!((lift.capacity.get(), lift.places().get()), (2, 1));
    assert_eq!(zone.rule, ZoneRule::Capacity(lift.places()));
    let told = "lifts, north: it has a capacity of 2, but carries 1 robot at a time: level low";
    assert!(
        scenario.warnings.of_scenario.iter().any(|line| line.contains(told)),
        "{:?}",
        scenario.warnings
    );
    assert_eq!(scenario.graph.edge(lift.rides[0]).speed, 0.1, "two metres in twenty seconds");
    for (text, message) in [
        ("doors: {gat: {closing_secs: 2}}", "doors, gat: the layout has no door of that name"),
        ("doors: {gate: {closing_secs: -2}}", "closing_secs is -2; give 0 to 3600"),
        ("lifts: {north: {level_secs: 0}}", "level_secs is 0; give more than 0"),
        ("lifts: {north: {home: hihg}}", "home is 'hihg', which it doesn't serve; did you mean"),
        ("lifts: {north: {speed: 1}}", "unknown key 'speed'; possible keys: level_secs"),
    ] {
        let error = read(text).map(drop).expect_err(text).to_string();
        assert!(error.contains(message), "{error}");
    }
}
