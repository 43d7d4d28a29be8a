//! Studies against queueing theory: layouts so small that formulas tell what must come out.
//!
//! Kleinrock, Queueing Systems, volume 1 (1975), section 5.6, for the Pollaczek-Khinchine formula;
//! for several servers, the approximation of Lee and Longton with Cosmetatos' correction (Tijms, A
//! First Course in Stochastic Models, 2003, section 9.6).

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::fleet::regatta;

/// Studies a scenario with a number of robots, and returns its answer.
pub(crate) fn study(
    folder: &Path,
    name: &str,
    layout: &str,
    load: &str,
    robots: u32,
    duration: &str,
) -> Value {
    fs::write(folder.join("plant.csv"), layout).expect("written");
    let scenario = folder.join(format!("{name}.yaml"));
    let text = format!(
        "graph: plant.csv\n\
         robot_types: [{{name: amr, length: 0.9, width: 0.6}}]\nrobots: [{{routes: none}}]\nload: {load}\n\
         plugins: [{{name: fleet-manager, args: [--in-turn]}}]\n"
    );
    fs::write(&scenario, text).expect("written");
    let output = regatta()
        .arg("study")
        .arg(&scenario)
        .args([
            "--robots",
            &robots.to_string(),
            "--duration",
            duration,
            "--seeds",
            "6..6",
            "--reliefs",
            "0",
            "--output",
        ])
        .arg(folder.join(name))
        .output()
        .expect("regatta starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&fs::read(folder.join(name).join("study.json")).expect("an answer"))
        .expect("JSON")
}

/// Returns the mean and half of the 95 % interval of a figure at the only point.
pub(crate) fn figure(answer: &Value, name: &str) -> (f64, f64) {
    let interval = &answer["variants"][0]["points"][0][name];
    (
        interval["mean"].as_f64().expect("a mean"),
        interval["half_width"].as_f64().expect("an interval"),
    )
}

/// A loop of 40 m at 1 m/s with a station to pick at and one to drop at, half a loop apart.
pub(crate) const LOOP: &str = "id,x,y,role\nA,0,0,pick\nB,10,0,\nC,10,10,drop\nD,0,10,\n\n\
    from,to,speed\nA,B,1\nB,C,1\nC,D,1\nD,A,1\n";

/// A robot drives to the pick (20 s), stands there (2 to 18 s), drives to the drop (20 s) and
/// stands there (2 to 18 s).
const SERVICE_SECS: f64 = 60.0;
/// The variance of two times that are uniform over 16 s.
const SERVICE_VARIANCE: f64 = 2.0 * 16.0 * 16.0 / 12.0;

#[test]
fn a_single_server_loop_agrees_with_pollaczek_and_khinchine() {
    let folder = tempfile::tempdir().expect("a folder");
    const STOPS: &str = "from: pick, to: drop, dwell: {min: 2, max: 18}";
    let endless = format!("{{endless: robots, {STOPS}}}");
    let busy = study(folder.path(), "busy", LOOP, &endless, 1, "90min");
    // Closed: the robot is never without an order, so it finishes one in each service time.
    let (orders_per_hour, half_width) = figure(&busy, "orders_per_hour");
    let service_secs = 3600.0 / orders_per_hour;
    let half_width_secs = service_secs * half_width / orders_per_hour;
    // The manager looks ten times a second, four times an order.
    assert!(
        (service_secs - SERVICE_SECS).abs() <= half_width_secs + 0.8,
        "{service_secs} ± {half_width_secs} s an order"
    );

    // Open: orders come at random, 60 % of what the robot can carry.
    let per_hour = 36.0;
    let random = format!("{{per_hour: {per_hour}, {STOPS}}}");
    let open = study(folder.path(), "open", LOOP, &random, 1, "90min");
    let (response_secs, half_width) = figure(&open, "service_mean_secs");
    let rate = per_hour / 3600.0;
    let load = rate * service_secs;
    let second_moment = service_secs.powi(2) + SERVICE_VARIANCE;
    let expected = service_secs + rate * second_moment / (2.0 * (1.0 - load));
    assert!(
        (response_secs - expected).abs() <= half_width,
        "from creation to end: {response_secs} ± {half_width} s, by the formula {expected} s"
    );
    assert!(half_width < 0.25 * expected, "an interval that tells something: ± {half_width} s");
    let (utilisation, half_width) = figure(&open, "utilisation");
    assert!(
        (utilisation - load).abs() <= half_width + 0.02,
        "{utilisation} ± {half_width}, by Little's law {load}"
    );
}

/// A ring of bays off the road, where robots stand without blocking others: nearly all of the time
/// of an order.
pub(crate) fn bays(count: usize) -> String {
    let (mut nodes, mut edges) = (String::from("id,x,y,role\n"), String::from("\nfrom,to,speed\n"));
    for index in 0..count {
        let angle = std::f64::consts::TAU * index as f64 / count as f64;
        let next = (index + 1) % count;
        let half = std::f64::consts::PI / count as f64;
        let (road, bay) = (on_circle(angle, 12.0), on_circle(angle + half, 17.0));
        nodes += &format!("R{index},{road},\nB{index},{bay},pick\n");
        edges += &format!("R{index},R{next},2\nR{index},B{index},2\nB{index},R{next},2\n");
    }
    nodes + &edges
}

/// Formats a point of a circle around (0, 0).
fn on_circle(angle: f64, radius: f64) -> String {
    format!("{:.3},{:.3}", radius * angle.cos(), radius * angle.sin())
}

/// Returns the probability that an order has to wait if orders come at random and service times are
/// exponential (Erlang C).
fn erlang_c(servers: u32, offered: f64) -> f64 {
    // Erlang B, by its recursion.
    let blocked = (1..=servers)
        .fold(1.0, |blocked, n| offered * blocked / (f64::from(n) + offered * blocked));
    let load = offered / f64::from(servers);
    blocked / (1.0 - load * (1.0 - blocked))
}

/// Returns the mean wait of random arrivals for several servers, in units of the service time, by
/// its squared coefficient of variation.
pub(crate) fn wait_in_services(servers: u32, offered: f64, squared_variation: f64) -> f64 {
    let (c, load) = (f64::from(servers), offered / f64::from(servers));
    let exponential = erlang_c(servers, offered) / (c * (1.0 - load));
    let deterministic = 0.5
        * (1.0 + (1.0 - load) * (c - 1.0) * ((4.0 + 5.0 * c).sqrt() - 2.0) / (16.0 * load * c))
        * exponential;
    squared_variation * exponential + (1.0 - squared_variation) * deterministic
}

#[test]
fn the_formulas_are_those_of_the_books() {
    // Tables of Hillier and Yu (1981): M/M/2 and M/D/2 at a load of 0.7 wait for 0.9608 and 0.5 ·
    // 1.0172 of that.
    assert!((wait_in_services(2, 1.4, 1.0) - 0.9608).abs() < 1e-4);
    assert!((wait_in_services(1, 0.5, 0.0) - 0.5).abs() < 1e-9, "M/D/1");
    assert!(
        (erlang_c(1, 0.6) - 0.6).abs() < 1e-12,
        "with one server, it waits as often as the server is busy"
    );
}

#[test]
fn several_servers_agree_with_erlang() {
    const SERVERS: u32 = 3;
    let folder = tempfile::tempdir().expect("a folder");
    let layout = bays(8);
    let load = |arrivals: &str| {
        format!("{{{arrivals}, from: pick, to: pick, dwell: {{min: 5, max: 115}}}}")
    };
    let busy = study(folder.path(), "busy", &layout, &load("endless: robots"), SERVERS, "90min");
    let (orders_per_hour, half_width) = figure(&busy, "orders_per_hour");
    let service_secs = 3600.0 * f64::from(SERVERS) / orders_per_hour;
    let service_error = service_secs * half_width / orders_per_hour;
    // Two dwells, and two ways of which any length is equally likely (up to 40 s).
    let variance = 2.0 * (110.0_f64.powi(2) + 40.0_f64.powi(2)) / 12.0;

    let per_hour = 45.0;
    let open = study(
        folder.path(),
        "open",
        &layout,
        &load(&format!("per_hour: {per_hour}")),
        SERVERS,
        "90min",
    );
    let (response_secs, half_width) = figure(&open, "service_mean_secs");
    let offered = per_hour / 3600.0 * service_secs;
    let expected =
        service_secs * (1.0 + wait_in_services(SERVERS, offered, variance / service_secs.powi(2)));
    assert!(
        (response_secs - expected).abs() <= half_width + service_error,
        "from creation to end: {response_secs} ± {half_width} s, by the formula {expected} s ± {service_error} s"
    );
    let (utilisation, half_width) = figure(&open, "utilisation");
    let load = offered / f64::from(SERVERS);
    assert!(
        (utilisation - load).abs() <= half_width + 0.03,
        "{utilisation} ± {half_width}, by Little's law {load}"
    );
}
