use serde_json::{Value, json};

use super::*;
use crate::job::PLANNER;
use crate::plan::Setting;

fn variant(text: &str) -> Result<Variant, PlanError> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("plant.csv");
    std::fs::write(&path, text).expect("written");
    Variant::read(&path, &ReadOptions::default())
}

/// The part of a scenario that a variant keeps, as JSON.
fn setup(variant: &Variant) -> Value {
    serde_json::to_value(&variant.setup).expect("JSON")
}

const RING: &str = "id,x,y,role\nA,0,0,pick\nB,10,0,\nC,10,10,drop\n\nfrom,to\nA,B\nB,C\nC,A\n";

#[test]
fn a_layout_with_stations_gets_a_load_between_them() {
    let variant = variant(RING).expect("a variant");
    let job = variant.job("x.yaml", 5, 7, RunTime { secs: 600, rate_hz: 10 }, "0.1.0");
    let scenario = serde_json::to_value(&job.scenario).expect("JSON");
    assert_eq!(
        scenario["load"],
        json!({"endless": "robots", "from": "pick", "to": "drop", "seed": 7})
    );
    assert_eq!((&scenario["seed"], &scenario["graph"]), (&json!(7), &json!("x.yaml")));
    assert_eq!(scenario["robots"][0]["count"], 5);
    assert_eq!(job.manager, Manager::BuiltIn(vec![IN_TURN.to_owned()]));
    assert!(scenario.get("plugins").is_none());
}

/// A pick station at a charger, before, made orders lead from node to node.
#[test]
fn a_station_for_loads_at_a_charger_or_a_parking_place_gets_its_orders() {
    for role in ["charge", "park", "drop"] {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("plant.yaml");
        let node = |id: u32, x: u32, role: &str| {
            format!("- {{Id: {id}, X: {x}, Y: 0, Theta: 0, Role: {role}}}\n")
        };
        let edge = |id: u32, from: u32, to: u32| {
            format!(
                "- {{Id: {id}, Origin_ID: {from}, Destination_ID: {to}, CurveType: Linear, \
                 VelocityForward: 1}}\n"
            )
        };
        let text = format!(
            "Vertices:\n{}{}Edges:\n{}{}Stations:\n- {{Name: In, Role: pick, Nodes: [1]}}\n\
             - {{Name: Out, Role: drop, Nodes: [2]}}\n",
            node(1, 0, role),
            node(2, 9, "none"),
            edge(1, 1, 2),
            edge(2, 2, 1)
        );
        std::fs::write(&path, text).expect("written");
        let variant = Variant::read(&path, &ReadOptions::default()).expect("a variant");
        let told = variant.other_stops.is_some();
        assert_eq!(told, role == "drop", "{role}: {:?}", variant.other_stops);
        assert_eq!(variant.graph.chargers()[0], role == "charge");
    }
}

#[test]
fn places_where_robots_of_a_scenario_start_are_told_as_left_out() {
    let read = |robots: &str| {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("plant.csv"), RING).expect("written");
        let path = folder.path().join("scenario.yaml");
        let scenario = format!("graph: plant.csv\nrobots:\n- {{count: 1, {robots}}}\n");
        std::fs::write(&path, scenario).expect("written");
        Variant::read(&path, &ReadOptions::default()).expect("a variant").left_out
    };
    assert!(read("node: B").iter().any(|part| part.contains("where the scenario's robots start")));
    assert_eq!(read("routes: none"), Vec::<String>::new());
}

#[test]
fn stations_that_nobody_reaches_are_left_out_by_name() {
    let left_out = variant(
        "id,x,y,role\nA,0,0,pick\nB,9,0,\nC,9,9,drop\nD,0,9,drop\nE,5,5,drop\n\nfrom,to\nA,B\nB,C\n\
         C,A\nD,A\nE,A\n",
    );
    let left_out = left_out.expect("a variant");
    assert_eq!(left_out.other_stops, None);
    let told = left_out.warnings.of_scenario;
    assert!(!told.iter().any(|line| line.contains("left out")), "it is told once: {told:?}");
    assert_eq!(left_out.left_out, ["stations `D`, `E`, to which no way leads from the main part"]);
    let names: Vec<_> = left_out.graph.nodes().iter().filter_map(|node| node.name()).collect();
    assert_eq!(names, ["A", "B", "C"]);
    let error = variant("id,x,y\nA,0,0\nB,9,0\n\nfrom,to\nA,B\n").map(drop);
    let error = error.expect_err("one way").to_string();
    assert!(error.contains("no road leads back") && !error.contains('\n'), "{error}");
}

#[test]
fn a_day_whose_stops_lack_a_way_names_each_with_the_way_that_is_missing() {
    let day = |stop: &str| {
        let plant = "id,x,y,name,role\nA,0,0,In,pick\nB,9,0,Out,drop\nC,9,9,Trap,drop\n\
                     D,0,9,Far,\n\n\
                     from,to\nA,B\nB,A\nB,C\nD,A\n";
        let day = Day {
            file: "day.csv".to_owned(),
            timetable: String::new(),
            stops: ["In", "Out"].into_iter().chain(stop.split(',')).map(str::to_owned).collect(),
            orders: 2,
            has_dwell: false,
            clock: None,
            last_secs: 0.0,
            scale: 1.0,
            shift_secs: 0.0,
            block_secs: None,
        };
        let read = variant(plant).expect("a variant").with_day(&Arc::new(day));
        if let Ok(variant) = &read {
            let words = variant.load_in_words();
            assert!(words.contains("robots spend no time at stops"), "{words}");
            assert!(words.contains("all at time 0"), "{words}");
        }
        read.map(drop).map_err(|error| error.to_string())
    };
    let reason = |stop: &str| day(stop).expect_err(stop);
    assert_eq!(day("Out"), Ok(()));
    assert!(reason("Trap").contains("serve the station Trap of"), "{}", reason("Trap"));
    assert!(reason("C").contains("as no way leads back from it"), "{}", reason("C"));
    assert!(reason("Far").contains("as no way leads to it"), "{}", reason("Far"));
    let both = reason("Trap,Far");
    assert!(
        both.contains("(Far, as no way leads to it from the main part; Trap, as no way"),
        "{both}"
    );
    assert!(both.contains("connect them") && !both.contains('\n'), "{both}");
}

#[test]
fn orders_with_other_stops_than_the_stations_suggest_say_so() {
    let trap =
        "id,x,y,role\nA,0,0,pick\nB,9,0,\nC,9,9,\nD,0,9,drop\n\nfrom,to\nA,B\nB,C\nC,A\nB,D\n";
    let trap = variant(trap).expect("a variant");
    let words = trap.load_in_words();
    assert!(words.contains("no time at stops, where `regatta run` and `regatta new`"), "{words}");
    let reason = trap.other_stops.expect("a reason");
    assert!(reason.contains("from a pick station to a drop station"), "{reason}");
    assert_eq!(trap.left_out, ["station `D`, from which no way leads back"]);
}

#[test]
fn a_load_keeps_the_stations_that_take_part() {
    let folder = tempfile::tempdir().expect("a folder");
    let layout = "id,x,y\nA,0,0\nB,10,0\nC,10,10\nD,0,10\n\nfrom,to\nA,B\nB,C\nC,A\nD,A\n";
    std::fs::write(folder.path().join("plant.csv"), layout).expect("written");
    let scenario = |inbound: &str| {
        let text = format!(
            "graph: plant.csv\nrobots: [{{count: 2, routes: none}}]\n\
             load: {{groups: {{in: {inbound}, out: [B]}}, endless: robots, from: in, to: out}}\n"
        );
        let path = folder.path().join("s.yaml");
        std::fs::write(&path, text).expect("written");
        Variant::read(&path, &ReadOptions::default())
    };
    let kept = scenario("[A, D, C]").expect("a variant");
    assert_eq!(setup(&kept)["load"]["groups"], json!({"in": ["A", "C"], "out": ["B"]}));
    let error = scenario("[D]").map(drop).expect_err("an empty group").to_string();
    assert!(error.contains("group in") && !error.contains('\n'), "{error}");
}

/// A ring with a pick and a drop, another one with more of them, and a dead end.
const TWO_RINGS: &str = "id,x,y,role\nP1,0,0,pick\nD1,9,0,drop\nC,9,9,\nP2,50,0,pick\n\
    P3,59,0,pick\nD2,59,9,drop\nT,0,9,drop\n\nfrom,to\nP1,D1\nD1,C\nC,P1\nP2,P3\nP3,D2\nD2,P2\n\
    C,T\n";

fn with_load(load: &str) -> Result<Variant, PlanError> {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("plant.csv"), TWO_RINGS).expect("written");
    let path = folder.path().join("s.yaml");
    let robots = "robots: [{count: 2, routes: none}]";
    std::fs::write(&path, format!("graph: plant.csv\n{robots}\nload: {load}\n")).expect("written");
    Variant::read(&path, &ReadOptions::default())
}

#[test]
fn the_roads_are_those_on_which_the_load_is() {
    let first = |load: &str| {
        let variant = with_load(load).expect(load);
        variant.graph.nodes()[0].name().map(str::to_owned)
    };
    assert_eq!(first("{endless: robots}").as_deref(), Some("P2"), "it has more pairs");
    assert_eq!(first("{endless: robots, from: [P1], to: D1}").as_deref(), Some("P1"));
    let named = "{groups: {out: [D1, T]}, endless: robots, from: P1, to: out}";
    let named = with_load(named).expect("a variant");
    assert_eq!(setup(&named)["load"]["groups"], json!({"out": ["D1"]}));
}

#[test]
fn a_generator_on_other_roads_is_left_out_and_told() {
    let load = |first: &str| {
        format!(
            "{{generators: [{{per_hour: 9, from: [{first}], to: [T]}}, {{per_hour: 9, from: [P2], \
             to: [D2]}}]}}"
        )
    };
    let kept = with_load(&load("P1")).expect("a variant");
    let generators = setup(&kept)["load"]["generators"].clone();
    assert_eq!(generators, json!([{"per_hour": 9, "from": ["P2"], "to": ["D2"]}]));
    let told = &kept.left_out;
    assert!(told.iter().any(|part| part.starts_with("generator 1 of the load")), "{told:?}");
}

#[test]
fn types_that_orders_name_stay_without_robots() {
    let job = |load: &str| {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("plant.csv"), RING).expect("written");
        let path = folder.path().join("s.yaml");
        let text = format!(
            "graph: plant.csv\nrobot_types: [{{name: a, length: 1, width: 1}}, {{name: b, length: 1, \
             width: 1}}]\nrobots: [{{count: 3, type: a, routes: none}}, {{count: 1, type: b, routes: \
             none}}]\nload: {load}\n"
        );
        std::fs::write(&path, text).expect("written");
        let variant = Variant::read(&path, &ReadOptions::default()).expect("a variant");
        let job = variant.job("plant", 1, 1, RunTime { secs: 60, rate_hz: 10 }, "0");
        job.scenario.setup.robot_types.map_or(0, |types| types.len())
    };
    assert_eq!(job("{endless: robots}"), 1);
    assert_eq!(job("{generators: [{endless: 2, robot_types: b}]}"), 2);
}

#[test]
fn settings_change_what_they_name() {
    let with = |setting, value: Value| {
        variant(RING).expect("a variant").with(setting, &value, &ReadOptions::default())
    };
    let fast = with(Setting::MaxSpeed, json!(2.5)).expect("faster");
    assert_eq!(setup(&fast)["robot_types"][0]["max_speed"], 2.5);
    assert_eq!((fast.max_speed(), fast.max_width()), (2.5, 0.6));
    let slow = with(Setting::SpeedFactor, json!(0.5)).expect("slower");
    assert_eq!(slow.graph.edges()[0].speed, 0.5);
    let detour = variant(&format!("{RING}A,C\n")).expect("a variant");
    let options = ReadOptions::default();
    let unknown = detour.clone().with(Setting::Closed, &json!(["A..Z"]), &options);
    assert!(unknown.is_err_and(|error| error.to_string().contains("'Z'")));
    let named = detour.clone().with(Setting::Closed, &json!(["B..C"]), &options);
    let closed = detour.with(Setting::Closed, &json!([2]), &options);
    let closed = closed.expect("closed");
    assert_eq!(named.expect("closed").layout_text(), closed.layout_text());
    assert_eq!(
        (closed.graph.edges().len(), &closed.left_out[..]),
        (2, &["node `B`, from which no way leads back".to_owned()][..])
    );
    let dwelling = with(Setting::Dwell, json!({"min": 1, "max": 4})).expect("dwell");
    let made_up =
        json!({"endless": "robots", "from": "pick", "to": "drop", "dwell": {"min": 1, "max": 4}});
    assert_eq!(setup(&dwelling)["load"], made_up);
    let broken = with(Setting::BreakdownsPerHour, json!(0.5)).expect("breakdowns");
    assert_eq!(setup(&broken)["disturbances"]["breakdowns"]["repair_secs"], 300.0);
    let never = broken.with(Setting::BreakdownsPerHour, &json!(0), &ReadOptions::default());
    let never = setup(&never.expect("no breakdowns"));
    assert!(never["disturbances"].get("breakdowns").is_none(), "{never}");
    let own = with(Setting::Manager, json!("python own.py")).expect("a manager");
    assert_eq!(own.manager, Manager::Command(vec!["python".to_owned(), "own.py".to_owned()]));
    for (setting, value) in [
        (Setting::MaxSpeed, json!("fast")),
        (Setting::Closed, json!([99])),
        (Setting::Type, json!("tugger")),
        (Setting::Manager, json!(" ")),
        (Setting::MaxSpeed, json!(0)),
        (Setting::SpeedFactor, json!(0.0)),
        (Setting::Load, json!("orders.json")),
        (Setting::Dwell, json!(-1)),
        (Setting::Dwell, json!({"min": 3, "max": 2})),
        (Setting::Dwell, json!("soon")),
        (Setting::Layout, json!("nowhere.csv")),
    ] {
        let error = with(setting, value).map(drop).expect_err("invalid").to_string();
        assert!(!error.contains('\n') && error.contains(": "), "{error}");
    }
}

#[test]
fn a_made_up_load_keeps_to_the_stations_that_closed_edges_leave() {
    let cut = format!("{RING}A,A2\nA2,A\n").replace("C,10,10,drop\n", "C,10,10,drop\nA2,0,9,\n");
    let options = ReadOptions::default();
    let dwelling = variant(&cut).expect("a variant").with(Setting::Dwell, &json!(7), &options);
    let closed = dwelling.expect("a dwell time").with(Setting::Closed, &json!([2]), &options);
    let closed = closed.expect("closed");
    assert_eq!(
        setup(&closed)["load"],
        json!({
            "endless": "robots", "from": "stops", "to": "stops", "groups": {"stops": [1, 4]},
            "dwell": 7,
        })
    );
    assert!(closed.other_stops.is_some(), "it tells that there is no drop any more");
}

#[test]
fn a_load_is_endless_if_each_robot_has_an_order_at_any_time() {
    for (load, is_endless) in [
        ("{endless: robots}", true),
        ("{endless: 2}", false),
        ("{per_hour: 90}", false),
        ("{generators: [{per_hour: 9}, {endless: robots}]}", true),
    ] {
        assert_eq!(with_load(load).expect(load).is_load_endless(), is_endless, "{load}");
    }
}

#[test]
fn files_of_orders_that_a_study_does_not_read_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("plant.csv"), RING).expect("written");
    let path = folder.path().join("s.yaml");
    let plugin = "{name: fleet-manager, args: [--orders, day.yaml, --planner, lanes]}";
    let text = format!("graph: plant.csv\nrobots: [{{node: 1}}]\nplugins: [{plugin}]\n");
    std::fs::write(&path, text).expect("written");
    let variant = Variant::read(&path, &ReadOptions::default()).expect("a variant");
    let left_out = variant.left_out.join("\n");
    assert!(left_out.contains("`--orders day.yaml`"), "{left_out}");
}

#[test]
fn another_layout_gets_a_load_of_its_own_and_the_last_planner_counts() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("plain.csv");
    std::fs::write(&path, "id,x,y\nP,0,0\nQ,10,0\nR,10,10\n\nfrom,to\nP,Q\nQ,R\nR,P\n")
        .expect("written");
    let (layout, options) = (json!(path.to_string_lossy()), ReadOptions::default());
    let other = variant(RING)
        .expect("a variant")
        .with(Setting::Layout, &layout, &options)
        .expect("a layout");
    assert_eq!(
        setup(&other)["load"],
        json!({
            "endless": "robots", "from": "stops", "to": "stops", "groups": {"stops": [1, 2, 3]},
        }),
        "it has no stations to pick and drop at"
    );
    assert_eq!(other.other_stops, None);
    assert_eq!(other.manager, Manager::BuiltIn(vec![IN_TURN.to_owned()]));
    let planned =
        |variant: Variant, name: &str| variant.with(Setting::Planner, &json!(name), &options);
    let planned = planned(planned(other, "tea").expect("a planner"), "pibt").expect("a planner");
    assert_eq!(
        planned.manager,
        Manager::BuiltIn([IN_TURN, PLANNER, "pibt"].map(str::to_owned).to_vec())
    );
}

#[test]
fn what_the_engine_would_refuse_is_found_before_any_run() {
    let fast = variant(RING).expect("a variant").with(
        Setting::SpeedFactor,
        &json!(100),
        &ReadOptions::default(),
    );
    let error = fast.and_then(|fast| fast.check(10)).expect_err("over 50 m/s").to_string();
    assert!(error.contains("50 m/s") && !error.contains('\n'), "{error}");
    variant(RING).and_then(|variant| variant.check(10)).expect("a variant that can run");
}

#[test]
fn robots_are_shared_out_among_the_types() {
    let variant = Variant {
        types: [(Some("a"), 10.0), (Some("b"), 5.0), (None, 0.1)]
            .map(|(name, weight)| TypeShare { name: name.map(str::to_owned), weight })
            .to_vec(),
        ..variant(RING).expect("a variant")
    };
    let counts =
        |robots| -> Vec<u32> { variant.groups(robots).iter().map(|group| group.count).collect() };
    assert_eq!((counts(1), counts(3), counts(15)), (vec![1], vec![2, 1], vec![10, 5]));
    assert_eq!(counts(1510), [1000, 500, 10]);
}

/// Writes a scenario on the ring, and reads it.
fn on_ring(text: &str) -> Variant {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("ring.csv"), RING).expect("written");
    let path = folder.path().join("s.yaml");
    std::fs::write(&path, format!("graph: ring.csv\n{text}")).expect("written");
    Variant::read(&path, &ReadOptions::default()).expect("a variant")
}

#[test]
fn closed_edges_that_cut_the_last_station_to_pick_off_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    // Edges 1 and 2 lead to the station to pick at and back.
    let layout = "id,x,y,role\nA,0,0,pick\nB,9,0,\nC,9,9,drop\n\n\
                  id,from,to\n1,A,B\n2,B,A\n3,B,C\n4,C,B\n";
    std::fs::write(folder.path().join("plant.csv"), layout).expect("written");
    let path = folder.path().join("s.yaml");
    let text = "graph: plant.csv\nrobots: [{count: 2, routes: none}]\n\
                load: {generators: [{per_hour: 60, from: pick, to: drop}]}\n";
    std::fs::write(&path, text).expect("written");
    let base = Variant::read(&path, &ReadOptions::default()).expect("a variant");
    let closed = |edges: Value| {
        let closed = base.clone().with(Setting::Closed, &edges, &ReadOptions::default());
        closed.map(drop).map_err(|error| error.with_name("closed").to_string())
    };
    assert_eq!(closed(json!([])), Ok(()));
    let error = closed(json!([2])).expect_err("no station to pick at");
    assert!(error.starts_with("with closed: "), "{error}");
    assert!(error.contains("s.yaml: load: no station to pick is left"), "{error}");
}

#[test]
fn a_load_that_names_a_file_of_orders_tells_the_option_for_it() {
    let variant = on_ring(
        "robots: [{count: 2, routes: none}]\n\
         load: {stations: [{at: A, operators: 1}],\n  \
         generators: [{orders: day.csv, scale: 1.2, dwell: 7, deadline: 900}]}\n",
    );
    let error = variant.check(10).expect_err("a file of orders").to_string();
    assert!(error.contains("s.yaml: load: ") && !error.contains('\n'), "{error}");
    assert!(error.contains("day.csv --scale 1.2, which replaces"), "{error}");

    // Keys of the load for orders without times hold for those of the option.
    let day = Day { file: "day.csv".to_owned(), scale: 1.2, ..Day::default() };
    let with_day = variant.with_day(&Arc::new(day)).expect("a day");
    let load = &setup(&with_day)["load"];
    assert_eq!((&load["dwell"], &load["deadline"]), (&json!(7), &json!(900)), "{load}");
    assert_eq!(load["stations"], json!([{"at": "A", "operators": 1}]), "{load}");
    with_day.check(10).expect("no file is named");
}

#[test]
fn speeds_of_another_vehicle_type_are_assumed() {
    let of = |kind: &str, speed: f64| json!({"vehicleTypeId": kind, "maxSpeed": speed});
    let node = |id: &str, x: f64| {
        let properties = json!([{"vehicleTypeId": "small"}, {"vehicleTypeId": "big"}]);
        json!({"nodeId": id, "nodePosition": {"x": x, "y": 0.0},
            "vehicleTypeNodeProperties": properties})
    };
    let edge = |id: &str, from: &str, to: &str, big: f64| {
        json!({"edgeId": id, "startNodeId": from, "endNodeId": to,
            "vehicleTypeEdgeProperties": [of("small", 1.5), of("big", big)]})
    };
    let assumptions = |big: f64| {
        let layout = json!({"layoutId": "l", "nodes": [node("A", 0.0), node("B", 9.0)],
            "edges": [edge("1", "A", "B", big), edge("2", "B", "A", 1.5)], "stations": []});
        let text = json!({"metaInformation": {"lifVersion": "1.0.0"}, "layouts": [layout]});
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("plant.lif.json");
        std::fs::write(&path, text.to_string()).expect("written");
        Variant::read(&path, &ReadOptions::default()).expect("a variant").assumptions
    };
    assert_eq!(assumptions(1.5), Vec::<String>::new());
    let differ = assumptions(0.5).join("\n");
    assert!(differ.contains("vehicle types differ in their properties here"), "{differ}");
}
