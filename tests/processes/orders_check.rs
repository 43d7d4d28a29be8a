//! `regatta orders check`: each row that can't be used is a line, and the others are counted.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::fleet::{graphs, regatta};

/// A day as a warehouse exports it: semicolons, German headers and Windows-1252.
const DAY: &[u8] = b"Auftrag;Quelle;Ziel;Zeit;F\xe4llig;Artikel\n\
    1;1;3;08:10;08:30;Schraube\n2;1;3;08:20;;\n3;2;S\xfcd;09:00;;\n4;1;3;25:00;;\n5;4;2;11:05;;\n\
    2;4;2;11:06;;\n";

fn check(folder: &Path, args: &[&str]) -> (i32, String) {
    let day = folder.join("day.csv");
    fs::write(&day, DAY).expect("written");
    let mut command = regatta();
    command.args(["orders", "check"]).arg(day).arg("--plant").arg(graphs("square.yaml")).args(args);
    let output = command.output().expect("regatta starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    (output.status.code().expect("an exit code"), text)
}

#[test]
fn each_row_that_cannot_be_used_is_a_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let (code, text) = check(folder.path(), &[]);
    assert_eq!(code, 1, "{text}");
    for expected in [
        "columns       Auftrag = name, Quelle = from, Ziel = to, Zeit = time, Fällig = deadline",
        "not used      Artikel",
        "line 4: stop 2: `Süd` is neither the name nor the id of a node",
        "line 5: column time: `25:00` has an hour",
        "line 7: there are two orders `2`, the first in line 3",
        "orders        3, problems 3",
        "start         08:00, which is time 0 of a run",
        "longest gap   165 min without an order, 0.3 h after the start",
        "   0       2\n   1 to 2: none\n   3       1\n",
        "     2  1 → 3\n",
    ] {
        assert!(text.contains(expected), "'{expected}' isn't in:\n{text}");
    }
}

/// Checks a table of orders against a plant, by default a square.
fn check_rows(rows: &str, plant: Option<&str>) -> (Option<i32>, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let [day, own_plant] = ["day.csv", "plant.csv"].map(|name| folder.path().join(name));
    fs::write(&day, rows).expect("written");
    fs::write(&own_plant, plant.unwrap_or_default()).expect("written");
    let plant = plant.map_or(graphs("square.yaml"), |_| own_plant);
    let mut command = regatta();
    let output = command.args(["orders", "check"]).arg(day).arg("--plant").arg(plant).output();
    let output = output.expect("regatta starts");
    (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Times that no table of hours can hold, and what only the fleet manager refused before.
#[test]
fn what_no_run_takes_is_a_line_too() {
    let stops = "1 2 ".repeat(501);
    let rows = format!("name,time,stops\na,0,1 2\nb,1e15,1 2\n..,1,1 2\nd,1,{stops}\n");
    let (code, text) = check_rows(&rows, None);
    assert_eq!(code, Some(1), "{text}");
    for expected in [
        "line 3: `time` is 1000000000000000, and must be 0 to 1000000000 seconds",
        "line 4: ",
        "line 5: an order has 1 to 1000 stops, and this one has 1002",
        "orders        1, problems 3",
    ] {
        assert!(text.contains(expected), "'{expected}' isn't in:\n{text}");
    }
}

#[test]
fn stops_of_a_plant_that_no_robot_can_serve_twice_are_lines() {
    let one_way = "id,x,y\nA,0,0\nB,9,0\nC,18,0\n\nfrom,to,speed\nA,B,1\nB,C,1\n";
    let (code, text) = check_rows("from,to\nA,C\nA,c\n", Some(one_way));
    assert_eq!(code, Some(1), "{text}");
    for expected in [
        "time          in no column: all orders come at time 0",
        "line 2: stop 1: robots can't serve `A`, as no way leads back from it; connect it",
        "line 2: stop 2: robots can't serve `C`, as no way leads back from it; connect it",
        "line 3: stop 2: `c` is neither the name nor the id of a node; did you mean `C`?",
    ] {
        assert!(text.contains(expected), "'{expected}' isn't in:\n{text}");
    }
}

#[test]
fn a_node_by_its_name_and_by_its_id_is_one_end_of_a_flow() {
    let plant = "id,name,x,y\nA,Dock,0,0\nB,Shelf,9,0\n\nfrom,to,speed\nA,B,1\nB,A,1\n";
    let rows = "from,to,time\nDock,B,0\nA,Shelf,30\nA,B,120\nB,Dock,130\n";
    let (code, text) = check_rows(rows, Some(plant));
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains("     3  Dock → Shelf\n     1  Shelf → Dock\n"), "{text}");
    assert!(text.contains("longest gap   90 s without an order"), "{text}");
    let (_, text) = check_rows("stops\nA:pick B:drop A:park\nA:pick B:drop A:park\n", Some(plant));
    assert!(text.contains("     2  A → B\n     2  B → A\n"), "{text}");
}

/// The first node of the station is a trap: orders for the station went there before.
#[test]
fn a_station_is_served_at_a_node_that_can_be_left() {
    let folder = tempfile::tempdir().expect("a folder");
    let [day, plant] = ["day.csv", "plant.yaml"].map(|name| folder.path().join(name));
    let edge = |id: u32, from: u32, to: u32| {
        format!(
            "- {{Id: {id}, Origin_ID: {from}, Destination_ID: {to}, CurveType: Linear, \
             VelocityForward: 1}}\n"
        )
    };
    let nodes = "- {Id: 1, X: 0, Y: 0, Theta: 0}\n- {Id: 2, X: 9, Y: 0, Theta: 0}\n\
                 - {Id: 3, X: 9, Y: 9, Theta: 0}\n";
    let edges = [edge(1, 1, 2), edge(2, 2, 1), edge(3, 2, 3)].concat();
    let text =
        format!("Vertices:\n{nodes}Edges:\n{edges}Stations:\n- {{Name: Out, Nodes: [3, 2]}}\n");
    fs::write(&plant, text).expect("written");
    fs::write(&day, "from,to\n1,Out\n").expect("written");
    let mut command = regatta();
    command.args(["orders", "check"]).arg(day).arg("--plant").arg(plant);
    let output = command.output().expect("regatta starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(0), "{text}");
}

/// Of such nodes, the first had the orders before.
#[test]
fn a_name_beside_the_ids_of_two_nodes_is_a_line() {
    let plant = "id,name,x,y\nA,Dock,0,0\nB,Ramp,9,0\nC,Ramp,9,9\n\nfrom,to\nA,B\nB,C\nC,A\n";
    let (code, text) = check_rows("from,to\nDock,B\nDock,Ramp\n", Some(plant));
    assert_eq!(code, Some(1), "{text}");
    assert!(text.contains("line 3: stop 2: `Ramp` is neither the name nor the id"), "{text}");
}

#[test]
fn hours_without_orders_share_a_line() {
    let rows = "from,to,time\n1,3,2019-05-01 08:10\n1,3,2026-05-01 09:20\n";
    let (_, text) = check_rows(rows, None);
    assert!(text.contains("   0       1\n   1 to 61368: none\n61369       1\n"), "{text}");
    assert!(text.contains("longest gap   2557 days without an order"), "{text}");
    assert!(text.lines().count() < 20, "{text}");
}

#[test]
fn a_night_shift_goes_on_after_midnight() {
    let (code, text) = check_rows("from,to,time\n1,3,22:10\n1,3,23:50\n1,3,00:20\n", None);
    assert_eq!(code, Some(0), "{text}");
    for expected in
        ["start         22:00", "from line 4 on, times are of the next day", "   2       1\n"]
    {
        assert!(text.contains(expected), "'{expected}' isn't in:\n{text}");
    }
}

#[test]
fn json_has_all_of_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let (code, text) = check(folder.path(), &["--json"]);
    let json: Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!((code, json["problems"].as_array().map(Vec::len)), (1, Some(3)), "{json:#}");
    assert_eq!(json["flows"][0], serde_json::json!({"from": "1", "to": "3", "orders": 2}));
    assert_eq!(json["columns"]["Quelle"], "from");
}

/// Stations that a study refuses, and whose orders a run counts as unroutable.
#[test]
fn a_stop_that_lacks_a_way_is_a_line() {
    let plant = "id,x,y,name\nA,0,0,In\nB,9,0,Out\nC,9,9,Trap\nI,50,0,Island\nJ,60,0,\n\n\
                from,to\nA,B\nB,A\nB,C\nI,J\nJ,I\n";
    let rows = "name,time,stops\na,0,In Out\nb,1,A Trap\nc,2,Island B\n";
    let (code, text) = check_rows(rows, Some(plant));
    assert_eq!(code, Some(1), "{text}");
    for expected in [
        "line 3: stop 2: robots can't serve `Trap`, as no way leads back from it; connect it",
        "line 4: stop 1: robots can't serve `Island`, as no way joins it with the main part",
        "orders        1, problems 2",
    ] {
        assert!(text.contains(expected), "'{expected}' isn't in:\n{text}");
    }
}
