//! `regatta study --target`: the least number of robots for a day's orders, against numbers that
//! are known otherwise.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

use crate::fleet::regatta;
use crate::study_theory::bays;

/// The number of orders, all at once, each to a bay of its own.
const ORDERS: usize = 12;
/// The seconds that a robot stands at a stop: nearly all of the time of an order, as a way takes at
/// most a minute.
const DWELL_SECS: f64 = 300.0;
const WAY_SECS: f64 = 60.0;

/// Writes a plant without conflicts and a day of orders into a folder.
fn plant(folder: &Path) -> [PathBuf; 2] {
    let [plant, day] = ["bays.csv", "day.csv"].map(|name| folder.join(name));
    fs::write(&plant, bays(ORDERS)).expect("written");
    let rows = (0..ORDERS).map(|bay| format!("o{bay},0,1500,B{bay}:none:{DWELL_SECS}\n"));
    let rows: String = rows.collect();
    fs::write(&day, format!("name,time,deadline,stops\n{rows}")).expect("written");
    [plant, day]
}

fn study(folder: &Path, name: &str, args: &[&str]) -> (Output, Value) {
    let [plant, day] = plant(folder);
    let mut command = regatta();
    command.arg("study").arg(plant).arg("--orders").arg(day).args(["--resample", "none"]);
    command.args(args).arg("--output").arg(folder.join(name));
    let output = command.output().expect("regatta starts");
    let file = folder.join(name).join("study.json");
    let answer =
        fs::read(file).map_or(Value::Null, |bytes| serde_json::from_slice(&bytes).expect("JSON"));
    (output, answer)
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Checks that the parts of each order's time add up to it, in all runs of a study; returns the
/// number of orders.
fn check_parts(folder: &Path) -> usize {
    let results = fs::read_dir(folder.join("results")).expect("results");
    let mut orders = 0;
    for file in results.map(|entry| entry.expect("a file").path()) {
        let text = fs::read_to_string(&file).expect("a result");
        // A seal follows the JSON.
        let mut values = serde_json::Deserializer::from_str(&text).into_iter::<Value>();
        let outcome = values.next().expect("JSON").expect("JSON");
        let tick_secs = outcome["figures"]["tick_secs"].as_f64().expect("a time");
        for order in outcome["figures"]["finished"].as_array().expect("orders") {
            let parts = order["parts"].as_array().expect("parts").iter();
            let ticks: u64 = parts.map(|part| part.as_u64().expect("ticks")).sum();
            let secs = order["service_secs"].as_f64().expect("a time");
            assert_eq!((secs / tick_secs).round() as u64, ticks, "{order}");
            orders += 1;
        }
    }
    orders
}

/// The standing of each number of robots that was tried.
fn standings(answer: &Value) -> Vec<(u64, String)> {
    let points = answer["variants"][0]["points"].as_array().expect("points").iter();
    let standing = |point: &Value| {
        let standing = point["targets"][0]["standing"].as_str().expect("a standing");
        (point["robots"].as_u64().expect("a number"), standing.to_owned())
    };
    points.map(standing).collect()
}

#[test]
fn the_least_fleet_is_that_of_theory_and_of_all_numbers() {
    let folder = tempfile::tempdir().expect("a folder");
    // So many rounds of orders fit: ⌈12 / 3⌉ = 4 rounds take longer than the target, 3 don't.
    let target = "longest service < 1100s";
    const { assert!(4.0 * DWELL_SECS > 1100.0 && 3.0 * (DWELL_SECS + WAY_SECS) < 1100.0) };
    let args = ["--target", target, "--target", "late < 1%", "--seeds", "2..2"];
    let (output, answer) = study(folder.path(), "s", &[&args[..], &["--robots", "1..8"]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let least = &answer["variants"][0]["least"];
    assert_eq!((&least["robots"], &least["binding"]["robots"]), (&4.into(), &3.into()), "{least}");
    assert!(text(&output.stdout).starts_with("4 robots: the least"), "{}", text(&output.stdout));
    let all = ["--robots", "1,2,3,4,5,6,7,8"];
    let (_, exhaustive) = study(folder.path(), "all", &[&args[..], &all].concat());
    for (robots, standing) in standings(&exhaustive) {
        assert_eq!(standing == "met", robots >= 4, "{robots} robots: {standing}");
    }
    let (_, again) = study(folder.path(), "again", &[&args[..], &["--robots", "1..8"]].concat());
    assert_eq!(answer, again, "the same study gives the same answer");
    assert!(check_parts(&folder.path().join("s")) >= 2 * 3 * ORDERS);
    let page = fs::read_to_string(folder.path().join("s/index.html")).expect("a page");
    assert!(page.contains("How many robots does bays need?"), "{page}");
}

#[test]
fn targets_that_no_fleet_meets_have_a_closest_fleet() {
    let folder = tempfile::tempdir().expect("a folder");
    let args = ["--target", "p50 service < 200s", "--robots", "1..8", "--seeds", "2..2"];
    let (output, answer) = study(folder.path(), "s", &args);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    let least = &answer["variants"][0]["least"];
    assert_eq!(least["robots"], Value::Null);
    let said = text(&output.stdout);
    assert!(
        said.starts_with("None of the numbers that were tried, up to 8 robots, meets"),
        "{said}"
    );
    assert!(said.contains("p50 service is") && said.contains("'p50 service < 200 s'"), "{said}");
}

#[test]
fn variants_have_a_table_of_their_least_fleets() {
    let folder = tempfile::tempdir().expect("a folder");
    let args = ["--target", "longest service < 1100s", "--robots", "1..8", "--seeds", "2..2"];
    // The dwell time of the file stays; slower roads change only the ways.
    let vary = ["--vary", "speed_factor=1,0.5"];
    let (output, answer) = study(folder.path(), "s", &[&args[..], &vary].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    for variant in 0..2 {
        let robots = answer["variants"][variant]["least"]["robots"].as_u64();
        assert!(robots.is_some_and(|robots| (4..=6).contains(&robots)), "{robots:?}");
    }
    let page = fs::read_to_string(folder.path().join("s/study.md")).expect("a page");
    assert!(page.contains("| variant | robots | longest service < 1100 s | binds |"), "{page}");
}

/// Prices whose cost is calculated by hand below.
const PRICES: &str = "prices: {currency: EUR, robot_price: 50000, charger_price: 0, \
    project_price: 100000, interest_percent: 10, life_years: 2, maintenance_percent: 5, \
    robot_kw: 0.5, energy_price_per_kwh: 0.2, operator_per_year: 60000, \
    operating_hours_per_year: 4000}\n";

/// Studies four robots with prices; returns what is said, and the answer.
fn study_of_four(folder: &Path, name: &str, prices: &str) -> (String, Value) {
    plant(folder);
    let file = folder.join(format!("{name}.yaml"));
    let study = "plant: bays.csv\norders: day.csv\nresample: none\nrobots: [4]\n\
                 seeds: {least: 2, most: 2}\ntargets: [longest service < 1100s]\n";
    fs::write(&file, format!("{study}{prices}")).expect("written");
    let output = folder.join(name);
    let done = regatta().arg("study").arg(&file).arg("--output").arg(&output).output();
    let done = done.expect("regatta starts");
    assert!(done.status.success(), "{}", text(&done.stderr));
    let answer = fs::read(output.join("study.json")).expect("an answer");
    (text(&done.stdout), serde_json::from_slice(&answer).expect("JSON"))
}

#[test]
fn the_cost_and_the_hours_of_a_day_are_those_by_hand() {
    let folder = tempfile::tempdir().expect("a folder");
    let (said, answer) = study_of_four(folder.path(), "priced", PRICES);
    // Four robots and the project cost 300,000, of which 121 / 210 are due a year; maintenance is
    // 10,000, and energy 4 · 0.5 kW · 4000 h · 0.2.
    let year = 300_000.0 * 121.0 / 210.0 + 10_000.0 + 1600.0 + 60_000.0;
    let variant = &answer["variants"][0];
    let cost = &variant["cost"]["points"][0];
    let runs = variant["points"][0]["runs"].as_array().expect("runs").iter();
    let orders = runs.map(|run| 4000.0 * run["orders_per_hour"].as_f64().expect("a number"));
    let of_runs: Vec<f64> = orders.map(|orders| year / orders).collect();
    let order = of_runs.iter().sum::<f64>() / of_runs.len() as f64;
    for (figure, expected) in [("per_year", year), ("per_order", order)] {
        let mean = cost[figure]["mean"].as_f64().expect(figure);
        assert!((mean / expected - 1.0).abs() < 1e-9, "{figure}: {mean} instead of {expected}");
    }
    assert!(said.contains("Cost: 4 robots are the cheapest"), "{said}");
    // All orders come at once. After two rounds, four are open; after the third one, none.
    let peaks = &answer["peaks"];
    let hours = peaks["hours"].as_array().expect("hours");
    let count = |key: &str| hours[0][key]["mean"].as_f64().expect(key);
    assert_eq!((hours.len(), count("released"), count("carried")), (1, 12.0, 12.0));
    assert_eq!(peaks["backlog"]["largest"]["mean"], 12.0);
    for (key, rounds) in [("cleared_after_largest_secs", 2.0), ("cleared_after_last_secs", 3.0)] {
        let secs = peaks["backlog"][key]["mean"].as_f64().expect(key);
        let range = rounds * DWELL_SECS..rounds * (DWELL_SECS + WAY_SECS);
        assert!(range.contains(&secs), "{key}: {secs} s");
    }
    for part in ["in the mean hour 12.0 orders come", "At most 12 orders are open at once; "] {
        assert!(said.contains(part), "{said}");
    }
    for file in ["backlog.svg", "hours.png", "cost-year.svg", "cost-order.png"] {
        assert!(folder.path().join("priced").join(file).exists(), "{file}");
    }
}

#[test]
fn a_price_that_is_missing_is_told_with_the_figures_that_lack_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let prices = PRICES.replace("operator_per_year: 60000, ", "");
    let (said, answer) = study_of_four(folder.path(), "unpriced", &prices);
    let cost = &answer["variants"][0]["cost"];
    assert_eq!((&cost["points"][0]["per_year"], &cost["cheapest"]), (&Value::Null, &Value::Null));
    assert_eq!(cost["points"][0]["investment"], 300_000.0);
    let told =
        "operation a year lacks `operator_per_year`; therefore also cost a year, cost an order";
    assert!(said.contains(told), "{said}");
}

#[test]
fn a_day_is_replayed_in_a_run_as_in_a_study() {
    let folder = tempfile::tempdir().expect("a folder");
    let [plant, day] = plant(folder.path());
    let mut command = regatta();
    command.arg("run").arg(&plant).args(["--robots", "4", "--in-process", "--json"]);
    command.args(["--simulated", "30min", "--scale", "2", "--orders"]).arg(&day);
    // Orders that wait for over 20 minutes are findings, so that the exit code is 1.
    let output = command.output().expect("regatta starts");
    let figures: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let orders = ["orders_finished", "orders_open"].map(|key| figures[key].as_u64().expect(key));
    assert_eq!(orders.iter().sum::<u64>(), 24, "{figures}");
}

/// Writes a scenario in which one operator serves all robots, with a load.
fn with_operator(folder: &Path, name: &str, load: &str) -> PathBuf {
    let path = folder.join(name);
    let bays: Vec<String> = (0..ORDERS).map(|bay| format!("B{bay}")).collect();
    let stations = format!("stations: [{{at: [{}], operators: 1}}]", bays.join(", "));
    let text = format!(
        "graph: bays.csv\nrobots: [{{count: 4, routes: none}}]\nplugins: [fleet-manager]\n\
         load: {{{stations}, {load}}}\n"
    );
    fs::write(&path, text).expect("written");
    path
}

/// Returns the finished orders of a run of half an hour.
fn finished(scenario: &Path, args: &[&str]) -> u64 {
    let mut command = regatta();
    command.arg("run").arg(scenario).args(["--in-process", "--json", "--simulated", "30min"]);
    let output = command.args(args).output().expect("regatta starts");
    let figures: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    figures["orders_finished"].as_u64().expect("a number")
}

#[test]
fn the_stations_of_a_scenario_hold_for_the_orders_of_a_day() {
    let folder = tempfile::tempdir().expect("a folder");
    let [_, day] = plant(folder.path());
    let [day, folder] = [day, folder.path().to_owned()];
    let named = with_operator(&folder, "named.yaml", "generators: [{orders: day.csv}]");
    let other = with_operator(&folder, "other.yaml", "per_hour: 9");
    let of_load = finished(&named, &[]);
    assert!((4..=6).contains(&of_load), "one operator serves one robot in 5 minutes: {of_load}");
    assert_eq!(finished(&other, &["--orders", &day.display().to_string()]), of_load);
}

/// Returns the points of a study of a scenario.
fn points(folder: &Path, scenario: &Path, args: &[&str]) -> Value {
    let output = folder.join(format!("study-{}", args.len()));
    let mut command = regatta();
    command.arg("study").arg(scenario).args(["--robots", "1,4", "--duration", "2h"]).args(args);
    command.args(["--target", "p99 service < 70min"]);
    command.arg("--output").arg(&output);
    let found = command.output().expect("regatta starts");
    let text = fs::read(output.join("study.json")).unwrap_or_else(|_| {
        panic!("{}", String::from_utf8_lossy(&found.stderr));
    });
    let answer: Value = serde_json::from_slice(&text).expect("JSON");
    answer["variants"][0]["points"].clone()
}

#[test]
fn a_study_replays_the_file_of_orders_of_a_load() {
    let folder = tempfile::tempdir().expect("a folder");
    let [_, day] = plant(folder.path());
    let named = with_operator(folder.path(), "named.yaml", "generators: [{orders: day.csv}]");
    let other = with_operator(folder.path(), "other.yaml", "per_hour: 9");
    let of_load = points(folder.path(), &named, &["--resample", "none"]);
    let args = ["--resample", "none", "--orders", &day.display().to_string()];
    let of_option = points(folder.path(), &other, &args);
    assert_eq!(of_load, of_option);
    // One operator serves twelve robots in an hour, however many there are.
    assert!(of_load[1]["service_p99_secs"]["mean"].as_f64() > Some(3500.0), "{of_load}");
}

#[test]
fn a_file_of_orders_comes_with_other_generators() {
    let folder = tempfile::tempdir().expect("a folder");
    plant(folder.path());
    let load = "generators: [{orders: day.csv}, {per_hour: 60, from: [B0], to: [B1]}]";
    let scenario = with_operator(folder.path(), "both.yaml", load);
    assert!(points(folder.path(), &scenario, &[])[0]["orders_per_hour"].is_object());
}

#[test]
fn what_is_wrong_with_a_day_or_a_target_is_told_in_one_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let [plant, day] = plant(folder.path());
    let file = |name: &str, text: &str| {
        fs::write(folder.path().join(name), text).expect("written");
        name.to_owned()
    };
    let unknown = file("unknown.csv", "time,stops\n5,B1\n9,X9\n");
    let empty = file("empty.csv", "time,stops\n");
    let day = day.display().to_string();
    for (args, expected) in [
        (vec!["--target", "p98 service < 6min"], "it names no known figure"),
        (vec!["--scale", "2"], "give its --orders"),
        (vec!["--orders", "none.csv"], "can't read none.csv"),
        (vec!["--orders", &unknown], "line 3: stop 1 is at `X9`"),
        (vec!["--orders", &empty], "there are no orders in it"),
        (vec!["--orders", &day, "--resample", "soon"], "or none"),
        (vec!["--orders", &day, "--vary", "load={\"per_hour\":3}"], "--orders replaces it"),
    ] {
        let mut command: Command = regatta();
        command.arg("study").arg(&plant).args(&args).current_dir(folder.path());
        let output = command.output().expect("regatta starts");
        let message = text(&output.stderr);
        assert!(!output.status.success() && message.contains(expected), "{args:?}: {message}");
        assert!(message.lines().count() <= 4, "{args:?}: {message}");
    }
}
