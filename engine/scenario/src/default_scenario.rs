//! A default scenario for a layout without one.

use std::fmt::Write;

use regatta_base::graph::CRAWL;
use regatta_layout::traffic::{self, MainPart, RobotType};
use regatta_layout::{OTHER_VEHICLE_TYPES, ReadOptions, RouteGraph, VEHICLE_TYPES};

use crate::MadeUpLoad;

/// Metres of edges per robot.
const METRES_PER_ROBOT: f64 = 10.0;

/// The maximum number of robot types.
const MOST_TYPES: usize = 20;

/// The maximum number of robots.
const MOST_ROBOTS: f64 = 1000.0;

/// The most edges of a layout whose traffic is examined, which takes some seconds then.
const MOST_EXAMINED: usize = 30_000;

/// The part of the robots that can be under way, of which as many fit without a jam as a rule.
const PART_UNDER_WAY: f64 = 0.25;

/// Said of layouts with edges that are too slow.
const TOO_SLOW: &str = " (edges under 0.01 m/s are too slow to count: raise their speeds)";

/// The beginning of what is said of stations that made-up orders don't have.
pub const LEFT_OUT_OF_ORDERS: &str = "left out of the orders";

/// Returns the text of a scenario for a layout: a managed fleet that carries made-up orders in its
/// main part. If there is none, robots drive on random routes.
///
/// `file` is the path of the layout as the scenario names it, and `options` are those with which it
/// was read.
pub fn default_scenario(graph: &RouteGraph, file: &str, options: &ReadOptions) -> String {
    let mut text = format!("graph: {}\n", quoted(file));
    write_options(&mut text, options).expect("writing to a String never fails");
    text += "rate: 50                            # ticks per simulated second\nrobot_types:\n";
    let names = vehicle_types(graph, options);
    if !names.is_empty() {
        text += "# The vehicle types of the layout: complete their sizes and limits. Robots are of \
                 the first.\n";
    }
    let robot = RobotType::of_layout(graph, options);
    let names = if names.is_empty() {
        vec!["amr".to_owned()]
    } else {
        names.iter().map(|name| quoted(name)).collect()
    };
    for name in &names {
        text += &robot_type(name, &robot);
    }
    text + &fleet(graph, &robot)
}

/// Returns the robots, their orders and the plugins.
fn fleet(graph: &RouteGraph, robot: &RobotType) -> String {
    let Some(main) = MainPart::of(graph) else {
        // Nothing keeps two of them apart where they come to an end.
        return "robots:\n- count: 1\n  routes: random\nplugins:\n- collision\n".to_owned();
    };
    let load = MadeUpLoad::new(&main.graph);
    let robots = robots(&main, &load, robot);
    let load = load.section();
    let mut left_out = String::new();
    for part in &main.left_out {
        left_out += &format!("# Left out: {part}.\n");
    }
    format!(
        "robots:\n\
         - count: {robots}\n  \
           routes: none                      # they wait for orders\n\
         {left_out}{load}\
         plugins:\n\
         - name: fleet-manager\n  \
           args: [--in-turn]                 # distant stations are served, too\n\
         - collision\n\
         - traffic\n"
    )
}

/// Returns what a made-up fleet doesn't do on a layout, one line each.
pub fn limits(graph: &RouteGraph) -> Vec<String> {
    let Some(main) = MainPart::of(graph) else {
        let slow = if is_crawling(graph) { TOO_SLOW } else { "" };
        return vec![format!(
            "no road leads back to where it began{slow}: one robot drives at random, without a \
             fleet manager"
        )];
    };
    let left_out = main.left_out.iter().map(|part| format!("{LEFT_OUT_OF_ORDERS}: {part}"));
    left_out.chain(MadeUpLoad::new(&main.graph).other_stops(graph)).collect()
}

/// Whether some edge is slower than a crawl, so that it isn't counted as a road.
fn is_crawling(graph: &RouteGraph) -> bool {
    let edges = graph.edges().iter();
    let mut speeds = edges.flat_map(|edge| [Some(edge.speed), edge.reverse_speed]).flatten();
    speeds.any(|speed| speed < CRAWL)
}

/// Returns a number of robots that the layout allows without a jam: by the length of its roads, the
/// robots that can be under way, and the number of stations.
fn robots(main: &MainPart, load: &MadeUpLoad, robot: &RobotType) -> u32 {
    let mut robots = by_length(&main.graph);
    if let Some(stations) = load.stations() {
        robots = robots.min((stations as f64 / 2.0).floor());
    }
    if main.graph.edges().len() <= MOST_EXAMINED {
        let most = traffic::most_under_way(&main.graph, robot).at_nodes.robots;
        robots = robots.min((PART_UNDER_WAY * f64::from(most)).floor());
    }
    robots.max(1.0) as u32
}

/// Returns one robot for each 10 m of edges, and at most a thousand.
fn by_length(graph: &RouteGraph) -> f64 {
    let metres: f64 = graph.edges().iter().map(|edge| edge.path.length()).sum();
    let most = MOST_ROBOTS.min(graph.edges().len() as f64);
    (metres / METRES_PER_ROBOT).floor().clamp(1.0, most)
}

/// Returns the vehicle types of a LIF layout, the one in use first.
fn vehicle_types(graph: &RouteGraph, options: &ReadOptions) -> Vec<String> {
    let nodes = graph.nodes().iter().map(|node| node.tags.as_deref());
    let edges = graph.edges().iter().map(|edge| edge.tags.as_deref());
    let keys = [VEHICLE_TYPES, OTHER_VEHICLE_TYPES];
    let lists = nodes.chain(edges).flatten();
    let lists = lists.flat_map(|tags| keys.map(|key| tags.properties.get(key))).flatten();
    let mut names: Vec<String> = options.vehicle_type.iter().cloned().collect();
    for name in lists.flat_map(|list| list.split(", ")).filter(|name| !name.is_empty()) {
        if names.len() < MOST_TYPES && !names.iter().any(|known| known == name) {
            names.push(name.to_owned());
        }
    }
    names
}

/// Returns a robot type of a scenario.
fn robot_type(name: &str, robot: &RobotType) -> String {
    let (length, width) = (robot.length(), robot.width());
    format!(
        "- name: {name}\n  \
           length: {length:<26}# metres\n  \
           width: {width}\n  \
           max_speed: 1.5                    # metres per second; edges limit it further\n  \
           max_acceleration: 0.8             # metres per second squared\n  \
           max_rotation_speed: 1.0           # radians per second, on the spot\n  \
           max_rotation_acceleration: 2.0    # radians per second squared\n"
    )
}

fn write_options(text: &mut String, options: &ReadOptions) -> std::fmt::Result {
    let ReadOptions {
        handles: _,
        format,
        level,
        vehicle_type,
        layers,
        units,
        skeleton,
        cell_size,
        background,
    } = options;
    let layers: Vec<_> = layers.iter().map(|layer| quoted(layer)).collect();
    let entries = [
        format.map(|format| format!("format: {format}")),
        level.as_ref().map(|level| format!("level: {}", quoted(level))),
        (!layers.is_empty()).then(|| format!("layers: [{}]", layers.join(", "))),
        units.map(|unit| format!("units: {}", unit.name())),
        skeleton.map(|width| format!("skeleton: {width}")),
        vehicle_type.as_ref().map(|name| format!("vehicle_type: {}", quoted(name))),
        background
            .as_ref()
            .map(|map| format!("background: {}", quoted(&map.display().to_string()))),
        cell_size.map(|length| format!("cell_size: {length}")),
    ];
    let entries: Vec<_> = entries.into_iter().flatten().collect();
    if entries.is_empty() {
        return Ok(());
    }
    writeln!(text, "layout:")?;
    entries.iter().try_for_each(|entry| writeln!(text, "  {entry}"))
}

/// Returns a text as a YAML scalar in double quotes.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for letter in text.chars() {
        match letter {
            '"' | '\\' => quoted.extend(['\\', letter]),
            control if control.is_control() => quoted += &format!("\\u{:04x}", u32::from(control)),
            other => quoted.push(other),
        }
    }
    quoted + "\""
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use regatta_layout::{LengthUnit, Millimetres, parse};

    use super::*;
    use crate::{Overrides, Scenario};

    const GRAPH: &str = include_str!("../../../graphs/square.yaml");

    #[test]
    fn the_default_scenario_can_be_run() {
        let (graph, _) = parse(GRAPH, "square.yaml", &ReadOptions::default()).expect("a graph");
        let text = default_scenario(&graph, "a \"plant\".yaml", &ReadOptions::default());
        let scenario =
            Scenario::from_texts(&text, GRAPH, Path::new("s.yaml"), &Overrides::default());
        let scenario = scenario.expect("a scenario");
        assert!(scenario.robots() >= 1 && scenario.robot_types[0].max_rotation_speed == 1.0);
    }

    #[test]
    fn the_vehicle_types_of_a_layout_are_robot_types() {
        let mut text = String::from(GRAPH);
        assert!(text.contains("Id: "), "{text}");
        text =
            text.replacen("Theta: ", "Properties: {vehicleTypeId: \"AGV 1, tugger\"}, Theta: ", 1);
        let (graph, _) = parse(&text, "square.yaml", &ReadOptions::default()).expect("a graph");
        let scenario_text = default_scenario(&graph, "square.yaml", &ReadOptions::default());
        let scenario =
            Scenario::from_texts(&scenario_text, &text, Path::new("s.yaml"), &Overrides::default());
        let names: Vec<_> =
            scenario.expect("a scenario").robot_types.into_iter().map(|of| of.name).collect();
        assert_eq!(names, ["AGV 1", "tugger"]);
    }

    #[test]
    fn roads_that_are_too_slow_are_told_as_such() {
        let told = |back: &str| {
            let text = format!("id,x,y\nA,0,0\nB,10,0\n\nfrom,to,speed\nA,B,1\n{back}");
            let (graph, _) = parse(&text, "t.csv", &ReadOptions::default()).expect("a graph");
            limits(&graph)
        };
        assert!(told("B,A,0.001\n")[0].contains("too slow to count: raise their speeds"));
        assert!(!told("")[0].contains("slow"), "{:?}", told(""));
    }

    #[test]
    fn a_layout_without_a_way_back_gets_one_robot_that_nothing_collides_with() {
        let text = "id,x,y\nA,0,0\nB,80,0\nC,160,0\n\nfrom,to\nA,B\nB,C\n";
        let scenario = Scenario::from_text(text, Path::new("t.csv"), &Overrides::default());
        assert_eq!(scenario.expect("a scenario").robots(), 1);
    }

    #[test]
    fn a_default_scenario_doesnt_warn_of_turns_that_its_robots_make() {
        let text = "id,x,y\nA,0,0\nB,10,0\nC,10,10\n\nfrom,to\nA,B\nB,C\nC,B\nB,A\n";
        let (_, findings) = parse(text, "t.csv", &ReadOptions::default()).expect("a graph");
        assert!(
            findings
                .as_slice()
                .iter()
                .any(|finding| finding.message.contains("max_rotation_speed"))
        );
        let scenario = Scenario::from_text(text, Path::new("t.csv"), &Overrides::default())
            .expect("a scenario");
        let told = scenario.warnings.told(crate::Told::All);
        assert!(
            scenario.is_default && !told.iter().any(|line| line.contains("max_rotation_speed"))
        );
    }

    #[test]
    fn a_layout_gets_a_managed_fleet_that_it_can_hold() {
        let text = "id,x,y,role\nA,0,0,pick\nB,20,0,\nC,20,20,drop\nD,0,20,\nI,50,50,drop\n\n\
                    from,to\nA,B\nB,C\nC,D\nD,A\n";
        let scenario = Scenario::from_text(text, Path::new("t.csv"), &Overrides::default());
        let scenario = scenario.expect("a scenario");
        let plugins: Vec<_> = scenario.plugins.iter().map(|plugin| &*plugin.name).collect();
        assert_eq!(plugins, ["fleet-manager", "collision", "traffic"]);
        assert_eq!(scenario.robots(), 1);
        let text = scenario.source.text();
        assert!(
            text.contains("    pick: [1]\n    drop: [3]\n  from: pick\n  to: drop\n"),
            "{text}"
        );
        assert!(
            text.contains("# Left out: station `I`, which no way joins with the main part.\n"),
            "{text}"
        );
    }

    #[test]
    fn robots_fit_into_the_cells_of_a_grid() {
        let text = "type octile\nheight 4\nwidth 4\nmap\n....\n....\n....\n....\n";
        let scenario = Scenario::from_text(text, Path::new("t.map"), &Overrides::default());
        let scenario = scenario.expect("a scenario");
        let robot_type = &scenario.robot_types[0];
        assert_eq!([robot_type.length, robot_type.width], [0.6, 0.6]);
        assert!((1..=4).contains(&scenario.robots()), "{}", scenario.robots());
    }

    #[test]
    fn a_file_that_is_nothing_says_so() {
        for text in ["{}", "", "{\"colour\": \"red\"}"] {
            let error = Scenario::from_text(text, Path::new("x.json"), &Overrides::default())
                .expect_err("nothing");
            assert!(
                error.to_string().starts_with("x.json: neither a layout nor a scenario: "),
                "{error}"
            );
        }
    }

    #[test]
    fn the_options_of_the_layout_are_kept() {
        let (graph, _) = parse(GRAPH, "square.yaml", &ReadOptions::default()).expect("a graph");
        let options = ReadOptions {
            level: Some("L \"1\"".into()),
            layers: vec!["Lanes".into(), "0".into()],
            units: Some(LengthUnit::Inch),
            skeleton: Some(Millimetres(650)),
            ..ReadOptions::default()
        };
        let text = default_scenario(&graph, "x", &options);
        assert!(
            text.contains(
                "layout:\n  level: \"L \\\"1\\\"\"\n  layers: [\"Lanes\", \"0\"]\n  units: in\n  \
                 skeleton: 0.65\n"
            ),
            "{text}"
        );
        assert!(text.contains("length: 0.975 ") && text.contains("width: 0.65\n"), "{text}");
    }
}
