//! Golden hashes: frames are bit-identical on every machine, instruction set and thread count.

use crate::fleet::{graphs, regatta, unique};

/// Runs the first ticks of a shipped scenario and returns the digest of all frames, or `None` if
/// the machine lacks the instruction set.
fn digest(test: &str, scenario: &str, ticks: u32, args: &[&str]) -> Option<String> {
    let output = regatta()
        .arg("engine")
        .arg(graphs(scenario))
        .args([
            "--fleet",
            &unique(test).to_string(),
            "--ticks",
            &ticks.to_string(),
            "--speed",
            "max",
            "--digest",
        ])
        .args(args)
        .output()
        .expect("regatta starts");
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    if message.contains("this machine can't run") {
        return None;
    }
    assert!(output.status.success(), "{message}");
    Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

fn assert_golden(test: &str, scenario: &str, ticks: u32, golden: &str) {
    let run = |name: &str, args: &[&str]| digest(&format!("{test}-{name}"), scenario, ticks, args);
    assert_eq!(run("scalar", &["--isa", "scalar"]).as_deref(), Some(golden), "scalar");
    assert_eq!(run("threads", &["--threads", "2"]).as_deref(), Some(golden), "two threads");
    for isa in ["baseline", "avx2", "avx512"] {
        if let Some(digest) = run(isa, &["--isa", isa]) {
            assert_eq!(digest, golden, "{isa}");
        }
    }
}

#[test]
fn the_frames_of_thirty_robots_match_the_golden_hash() {
    assert_golden("thirty", "thirty.yaml", 3000, GOLDEN_THIRTY);
}

#[test]
fn the_frames_of_a_thousand_robots_match_the_golden_hash() {
    assert_golden("warehouse", "warehouse-1000.yaml", 3000, GOLDEN_WAREHOUSE);
}

/// Smaller fleets are moved by one thread; 5000 robots give work to two.
#[test]
fn the_frames_of_5000_robots_on_two_threads_match_the_golden_hash() {
    let run = |threads: &str, isa: &str| {
        let args = ["--robots", "5000", "--threads", threads, "--isa", isa];
        digest(&format!("many-{threads}-{isa}"), "warehouse-1000.yaml", 600, &args)
    };
    assert_eq!(run("1", "scalar").as_deref(), Some(GOLDEN_5000));
    assert_eq!(run("2", "scalar").as_deref(), Some(GOLDEN_5000));
    assert_eq!(run("2", "baseline").as_deref(), Some(GOLDEN_5000));
}

#[test]
fn different_seeds_give_different_frames() {
    let seeds = ["1", "2"]
        .map(|seed| digest(&format!("seed-{seed}"), "warehouse-1000.yaml", 500, &["--seed", seed]));
    assert_ne!(seeds[0], seeds[1]);
}

const GOLDEN_THIRTY: &str = "6b3701e82ccd0d62d1679822b7bcb328";
const GOLDEN_5000: &str = "0832fe1c15759a0cc2305cc4bfad2c4b";
const GOLDEN_WAREHOUSE: &str = "7ffd6b81730a152ec58717c29102f47c";
