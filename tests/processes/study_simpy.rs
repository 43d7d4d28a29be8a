//! Studies against a second simulator: a loop in SimPy, which nobody here wrote
//! (`simpy_loop.py`).
//!
//! Robots queue on the road behind two stations, so that traffic decides about the throughput, and
//! no formula is exact. The two simulators share no code, no random numbers and no model of a road:
//! cells there, claims of stretches and braking here.

use regatta_study::statistics::Interval;

use crate::fleet::{python_with, root};
use crate::study_theory::{figure, study};

/// The part of the throughput by which the two models of a road may differ, beside their intervals:
/// a robot here goes on after a stop at the next tick.
const MODEL: f64 = 0.01;

/// A loop of 40 m at 1 m/s with a station to pick at and one to drop at, half a loop apart, and
/// nodes for eight robots.
const RING: &str = "id,x,y,role\nA,0,0,pick\nB,5,0,\nC,10,0,\nD,10,5,\nE,10,10,drop\nF,5,10,\n\
    G,0,10,\nH,0,5,\n\nfrom,to,speed\nA,B,1\nB,C,1\nC,D,1\nD,E,1\nE,F,1\nF,G,1\nG,H,1\nH,A,1\n";

/// Returns the finished orders an hour of the loop in SimPy; `None` if Python doesn't have it.
fn in_simpy(robots: u32) -> Option<Interval> {
    let mut python = python_with("simpy")?;
    python.arg(root().join("tests/processes/simpy_loop.py"));
    let output = python.args(["--robots", &robots.to_string()]).output().expect("python3 starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let values: Vec<f64> = serde_json::from_slice(&output.stdout).expect("a list");
    Interval::of(&values)
}

/// Compares the throughput of a number of robots.
fn check_loop(robots: u32) {
    let Some(theirs) = in_simpy(robots) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let load = "{endless: robots, from: pick, to: drop, dwell: {min: 2, max: 18}}";
    let answer = study(folder.path(), "loop", RING, load, robots, "90min");
    let (ours, half_width) = figure(&answer, "orders_per_hour");
    let their_half = theirs.half_width.expect("several seeds");
    println!(
        "{robots} robots: {ours:.1} ± {half_width:.1} here, {:.1} ± {their_half:.1} in SimPy",
        theirs.mean
    );
    let difference = (ours - theirs.mean).abs();
    assert!(
        difference <= half_width + their_half + MODEL * theirs.mean,
        "{robots} robots: {ours} ± {half_width}, in SimPy {} ± {their_half}",
        theirs.mean
    );
    assert!(half_width < 0.03 * ours, "an interval that tells something: ± {half_width}");
}

#[test]
fn robots_of_a_loop_carry_as_much_as_in_simpy() {
    check_loop(4);
}

#[test]
fn robots_that_queue_on_a_loop_carry_as_much_as_in_simpy() {
    check_loop(8);
}
