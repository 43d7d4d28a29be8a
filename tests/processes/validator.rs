//! The validator on real engines, in lockstep, and on a recording.

use std::process::Output;

use crate::fleet::{Process, graphs, regatta, unique};

/// Runs a shipped scenario for some ticks under the validator, and returns what that says.
fn validated(test: &str, scenario: &str, ticks: &str, args: &[&str]) -> Output {
    let fleet = unique(test).to_string();
    let validator =
        Process::start(regatta().args(["plugin", "validator", "--fleet", &fleet]).args(args));
    let mut engine = regatta();
    engine
        .arg("engine")
        .arg(graphs(scenario))
        .args(["--fleet", &fleet, "--ticks", ticks, "--speed", "max"]);
    let output = Process::start(engine.args(["--lockstep", "validator"])).finish();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    validator.interrupt()
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned()
}

#[test]
fn robots_of_shipped_scenarios_move_as_they_should() {
    for (scenario, ticks) in [("square.yaml", "6000"), ("thirty.yaml", "6000")] {
        let output = validated("validator-clean", scenario, ticks, &["--allow", "contact"]);
        assert!(output.status.success(), "{scenario}: {}", text(&output));
        assert!(
            text(&output).contains("validator: ") && !text(&output).contains("missed"),
            "{}",
            text(&output)
        );
    }
}

#[test]
fn the_demo_without_a_manager_has_contacts_and_no_other_fault() {
    let folder = tempfile::tempdir().expect("a folder");
    let json = folder.path().join("report.json");
    let markdown = folder.path().join("report.md");
    let files = ["--json", json.to_str().unwrap(), "--markdown", markdown.to_str().unwrap()];
    let output = validated("validator-demo", "warehouse-1000.yaml", "500", &files);
    assert!(!output.status.success(), "contacts are findings: {}", text(&output));
    let report: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(json).unwrap()).expect("JSON");
    for kind in report["kinds"].as_array().expect("kinds") {
        let is_contact = kind["kind"] == "contact";
        assert_eq!(kind["count"].as_u64().unwrap() > 100, is_contact, "{kind}");
        assert!(is_contact || kind["count"] == 0, "{kind}");
    }
    assert!(std::fs::read_to_string(markdown).unwrap().contains("## contact"));
}

#[test]
fn a_recording_is_judged_as_its_fleet_was() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("run.mcap");
    let fleet = unique("validator-recording").to_string();
    let recorder = Process::start(regatta().args(["record", "--fleet", &fleet, "-o"]).arg(&file));
    let mut engine = regatta();
    engine
        .arg("engine")
        .arg(graphs("thirty.yaml"))
        .args(["--fleet", &fleet, "--ticks", "1000", "--speed", "max"]);
    assert!(Process::start(engine.args(["--lockstep", "record"])).finish().status.success());
    assert!(recorder.interrupt().status.success());
    let validate =
        |args: &[&str]| Process::start(regatta().arg("validate").arg(&file).args(args)).finish();
    let output = validate(&["--allow", "contact"]);
    assert!(output.status.success(), "{}", text(&output));
    assert!(text(&output).contains("1001 frames of 30 robots in 10.00 s"), "{}", text(&output));
    let output = validate(&["--allow", "collisions"]);
    assert!(text(&output).contains("invalid value 'collisions'"), "{}", text(&output));
}

/// Two loops that have nothing in common but a zone for one robot.
const TWO_LOOPS: &str = "Edges:
- {Id: 1, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, VelocityForward: 1}
- {Id: 2, Origin_ID: 2, Destination_ID: 1, CurveType: Linear, VelocityForward: 1}
- {Id: 3, Origin_ID: 3, Destination_ID: 4, CurveType: Linear, VelocityForward: 1}
- {Id: 4, Origin_ID: 4, Destination_ID: 3, CurveType: Linear, VelocityForward: 1}
Vertices:
- {Id: 1, X: 0, Y: 0, Theta: 0}
- {Id: 2, X: 9, Y: 0, Theta: 0}
- {Id: 3, X: 0, Y: 20, Theta: 0}
- {Id: 4, X: 9, Y: 20, Theta: 0}
Zones:
- {Name: door, Capacity: 1, Edges: [1, 3]}
";

#[test]
fn the_manager_keeps_a_zone_and_robots_without_one_do_not() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("plant.yaml"), TWO_LOOPS).expect("written");
    let orders = "orders:
- {name: a, robot: 0, stops: [{at: 2}, {at: 1}, {at: 2}]}
- {name: b, robot: 1, stops: [{at: 4}, {at: 3}, {at: 4}]}
";
    std::fs::write(folder.path().join("orders.yaml"), orders).expect("written");
    let file = folder.path().join("scenario.yaml");
    let run = |robots: &str, manager: &str| {
        let scenario = format!(
            "graph: plant.yaml\nrobot_types: [{{name: a, length: 0.9, width: 0.6, \
             max_rotation_speed: 1}}]\nviewer: off\nrobots:\n{robots}plugins:\n{manager}- validator\n"
        );
        std::fs::write(&file, scenario).expect("written");
        let args = ["--in-process", "--simulated", "3min", "--trust"];
        Process::start(regatta().current_dir(folder.path()).arg("run").arg(&file).args(args))
            .finish()
    };
    let alone = run("- {route: [1, 2], repeat: loop}\n- {route: [3, 4], repeat: loop}\n", "");
    assert!(!alone.status.success(), "{}", text(&alone));
    assert!(text(&alone).contains("2 in zone `door`, which has room for 1"), "{}", text(&alone));
    let manager = "- {name: fleet-manager, args: [--orders, orders.yaml]}\n";
    let managed = run("- node: 1\n- node: 3\n", manager);
    assert!(managed.status.success(), "{}", text(&managed));
    assert!(text(&managed).contains("2 finished"), "{}", text(&managed));
}

/// A loop with a station at one of its nodes, and a node from which no way leads back.
const STATION: &str = "Edges:
- {Id: 1, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, VelocityForward: 1}
- {Id: 2, Origin_ID: 2, Destination_ID: 1, CurveType: Linear, VelocityForward: 1}
- {Id: 3, Origin_ID: 3, Destination_ID: 1, CurveType: Linear, VelocityForward: 1}
Vertices:
- {Id: 1, X: 0, Y: 0, Theta: 0}
- {Id: 2, X: 9, Y: 0, Theta: 0, Properties: {aliases: '[\"Storage 01\"]'}}
- {Id: 3, X: 0, Y: 20, Theta: 0, Name: island}
";

#[test]
fn an_order_without_a_way_is_a_finding_and_a_node_is_found_by_another_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).expect("written");
    };
    write("plant.yaml", STATION);
    write(
        "scenario.yaml",
        "graph: plant.yaml\nviewer: off\nrobots: [{node: 1}]\n\
         plugins: [{name: fleet-manager, args: [--orders, orders.yaml]}]\n",
    );
    let run = |stop: &str| {
        write("orders.yaml", &format!("orders:\n- {{name: a, stops: [{{at: {stop}}}]}}\n"));
        let args = ["run", "scenario.yaml", "--trust", "--in-process", "--simulated", "1min"];
        Process::start(regatta().current_dir(folder.path()).args(args)).finish()
    };
    let stored = run("Storage 01");
    assert!(stored.status.success(), "{}", text(&stored));
    assert!(text(&stored).contains("1 finished"), "{}", text(&stored));
    let lost = run("island");
    assert_eq!(lost.status.code(), Some(1), "{}", text(&lost));
    assert!(text(&lost).contains("1 unroutable"), "{}", text(&lost));
}

/// A robot drives 9 m to a stop and 9 m back to its charger: planned at twice the driving time of
/// 18 s and more, that takes more than 100 Ws at 100 W, and less than 10 Wh.
#[test]
fn an_order_that_no_full_battery_lasts_for_is_a_finding_with_its_reason() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).expect("written");
    };
    write(
        "plant.yaml",
        &STATION.replace("Theta: 0}\n- {Id: 2", "Theta: 0, Role: charge}\n- {Id: 2"),
    );
    write("orders.yaml", "orders:\n- {name: a, stops: [{at: 2}]}\n");
    let run = |capacity_wh: f64| {
        let scenario = format!(
            "graph: plant.yaml\nviewer: off\nrobot_types: [{{name: a, length: 0.9, width: 0.6, \
             battery: {{capacity: {capacity_wh}, drain_moving: 100, drain_standing: 1, \
             charge_rate: 100, charge: 100}}}}]\nrobots: [{{node: 1}}]\n\
             plugins: [{{name: fleet-manager, args: [--orders, orders.yaml]}}, validator]\n"
        );
        write("scenario.yaml", &scenario);
        let args = ["run", "scenario.yaml", "--trust", "--in-process", "--simulated", "1min"];
        Process::start(regatta().current_dir(folder.path()).args(args)).finish()
    };
    let large = run(10.0);
    assert!(large.status.success() && text(&large).contains("1 finished"), "{}", text(&large));
    let small = run(100.0 / 3600.0);
    assert_eq!(small.status.code(), Some(1), "{}", text(&small));
    assert!(text(&small).contains("no robot's full battery lasts for it"), "{}", text(&small));
}

#[test]
fn an_order_for_a_missing_robot_is_a_finding_and_a_last_stop_without_a_way_on_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).expect("written");
    };
    let trap =
        "- {Id: 4, Origin_ID: 2, Destination_ID: 4, CurveType: Linear, VelocityForward: 1}\n";
    let trapping = STATION.replace("Vertices:\n", &format!("{trap}Vertices:\n"));
    write("plant.yaml", &format!("{trapping}- {{Id: 4, X: 9, Y: 9, Theta: 0, Name: trap}}\n"));
    write(
        "scenario.yaml",
        "graph: plant.yaml\nviewer: off\nrobots: [{node: 1}]\n\
         plugins: [{name: fleet-manager, args: [--orders, orders.yaml]}]\n",
    );
    let run = |order: &str| {
        write("orders.yaml", &format!("orders:\n- {{name: a, {order}}}\n"));
        let args = ["run", "scenario.yaml", "--trust", "--in-process", "--simulated", "1min"];
        Process::start(regatta().current_dir(folder.path()).args(args)).finish()
    };
    let missing = run("robot: 7, stops: [{at: 2}]");
    assert_eq!(missing.status.code(), Some(1), "{}", text(&missing));
    assert!(text(&missing).contains("1 unroutable"), "{}", text(&missing));
    let trapped = run("stops: [{at: trap}]");
    assert!(trapped.status.success(), "{}", text(&trapped));
    let warning = "order a ends at trap, from which no way leads back";
    assert!(text(&trapped).contains(warning), "{}", text(&trapped));
    for order in ["stops: [{at: 2}]", "stops: [{at: 1}, {at: 1}]"] {
        let kept = run(order);
        assert!(!text(&kept).contains("no way leads back"), "{}", text(&kept));
    }
    write(
        "scenario.yaml",
        "graph: plant.yaml\nviewer: off\nrobots: [{node: island}]\n\
         plugins: [{name: fleet-manager, args: [--orders, orders.yaml]}]\n",
    );
    let kept = run("stops: [{at: 2}]");
    assert!(!text(&kept).contains("no way leads back"), "{}", text(&kept));
}

#[test]
fn a_robot_leaves_a_node_to_which_no_edge_leads() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).expect("written");
    };
    write("plant.yaml", STATION);
    write("orders.yaml", "orders:\n- {name: a, stops: [{at: 2}, {at: 1}]}\n");
    write(
        "scenario.yaml",
        "graph: plant.yaml\nviewer: off\nrobots: [{node: island}]\n\
         plugins: [{name: fleet-manager, args: [--orders, orders.yaml]}, validator]\n",
    );
    let args = ["run", "scenario.yaml", "--trust", "--in-process", "--simulated", "5min"];
    let run = Process::start(regatta().current_dir(folder.path()).args(args)).finish();
    assert!(run.status.success(), "{}", text(&run));
    assert!(text(&run).contains("1 finished"), "{}", text(&run));
}

#[test]
fn a_load_that_leads_where_no_way_leads_back_is_told_once_at_the_start() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).expect("written");
    };
    let nodes = "id,x,y,role\nA,0,0,pick\nB,9,0,drop\nT,9,9,drop\nU,18,9,\n";
    write("plant.csv", &format!("{nodes}\nfrom,to\nA,B\nB,A\nB,T\nT,U\nU,T\n"));
    let run = |to: &str| {
        write(
            "scenario.yaml",
            &format!(
                "graph: plant.csv\nviewer: off\nrobots: [{{node: A}}, {{node: B}}]\n\
                 load: {{per_hour: 60, from: [A], to: {to}}}\nplugins: [fleet-manager]\n"
            ),
        );
        let args = ["run", "scenario.yaml", "--trust", "--in-process", "--simulated", "5min"];
        text(&Process::start(regatta().current_dir(folder.path()).args(args)).finish())
    };
    let trapped = run("[B, T]");
    let warning = "orders end at `T`, from which no way leads back: their robots stay there";
    assert_eq!(trapped.matches(warning).count(), 1, "{trapped}");
    assert_eq!(trapped.matches("no way leads back").count(), 1, "{trapped}");
    let kept = run("[B]");
    assert!(!kept.contains("no way leads back"), "{kept}");
}
