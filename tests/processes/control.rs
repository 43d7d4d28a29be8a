//! Requests to the control service of a running engine: pause, resume, step, speed and the number
//! of robots.

use std::time::{Duration, Instant};

use regatta_plugin::{CommandLogReader, Commands, Participant, ReadError};

use crate::fleet::{Fleet, TIMEOUT, eventually, regatta, unique};

#[test]
fn a_paused_fleet_makes_no_ticks_until_it_is_stepped() {
    let fleet = Fleet::start("pause", "thirty.yaml", &[]);
    fleet.control(&["pause"]);
    let tick = fleet.tick();
    assert_eq!(fleet.status()["clock"], "paused");
    std::thread::sleep(Duration::from_millis(100));
    assert_eq!(fleet.tick(), tick, "no tick while paused");
    fleet.control(&["step", "7"]);
    assert_eq!(fleet.tick(), tick + 7);
    fleet.control(&["resume"]);
    fleet.let_ticks_pass(10);
    assert!(fleet.engine.interrupt().status.success());
}

#[test]
fn a_status_lists_the_processes_of_the_fleet_without_itself() {
    let fleet = Fleet::start("listed", "thirty.yaml", &[]);
    let status = fleet.status();
    let processes = status["processes"].as_array().expect("a list");
    let names: Vec<_> = processes.iter().filter_map(|process| process["name"].as_str()).collect();
    assert_eq!(names, ["engine"], "{processes:?}");
    assert_eq!(processes[0]["pid"], status["pid"]);
    assert_eq!(processes[0]["state"], "running");
    let output = regatta().args(["status", "--fleet", &fleet.name.to_string()]).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("\nprocess  engine  running  pid "), "{text}");
}

#[test]
fn steps_are_made_at_the_requested_speed() {
    let fleet = Fleet::start("paced-steps", "thirty.yaml", &["--speed", "2"]);
    fleet.control(&["pause"]);
    let start = Instant::now();
    fleet.control(&["step", "101"]);
    // At twice real time a step of 10 ms takes 5 ms; the first is made immediately.
    assert!(start.elapsed() >= Duration::from_millis(499), "{:?}", start.elapsed());
    fleet.control(&["speed", "max"]);
    // An hour of simulated time, at full speed.
    fleet.control(&["step", "360000"]);
    assert_eq!(fleet.status()["clock"], "paused");
}

#[test]
fn speed_changes_how_fast_simulated_time_passes() {
    let fleet = Fleet::start("speed", "thirty.yaml", &["--speed", "0.5"]);
    fleet.control(&["speed", "max"]);
    let status = fleet.status();
    assert_eq!(status["speed"], "max");
    let before = status["sim_time_secs"].as_f64().unwrap();
    eventually("an hour of simulated time", || {
        (fleet.status()["sim_time_secs"].as_f64()? > before + 3600.0).then_some(())
    });
}

#[test]
fn the_number_of_robots_changes_while_the_engine_runs() {
    let fleet = Fleet::start("robots", "warehouse-1000.yaml", &["--robots", "10"]);
    let mut reader = fleet.subscriber();
    for robots in [10_000usize, 7, 1000] {
        fleet.control(&["robots", &robots.to_string()]);
        assert_eq!(fleet.status()["robots"].as_u64(), Some(robots as u64));
        eventually("a frame of the new size", || {
            let frame = reader.latest().expect("readable")?;
            (frame.len() == robots && frame.x().iter().all(|x| x.is_finite())).then_some(())
        });
    }
}

#[test]
fn refused_requests_and_missing_fleets_are_reported_with_the_reason() {
    let fleet = Fleet::start("refusals", "thirty.yaml", &[]);
    let name = fleet.name.to_string();
    let output = regatta().args(["robots", "4000000000", "--fleet", &name]).output().unwrap();
    assert!(!output.status.success());
    assert!(String::from_utf8_lossy(&output.stderr).contains("at most"), "{output:?}");

    let output = regatta().args(["seek", "2s", "--fleet", &name]).output().unwrap();
    assert!(!output.status.success());
    assert!(String::from_utf8_lossy(&output.stderr).contains("a replay can"), "{output:?}");

    let missing = unique("missing").to_string();
    let output = regatta().args(["status", "--fleet", &missing]).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        !output.status.success() && message.contains(&missing) && message.lines().count() == 1,
        "{message}"
    );
}

#[test]
fn frames_are_published_at_the_publish_rate() {
    let fleet = Fleet::start("publish-rate", "thirty.yaml", &["--publish-rate", "10"]);
    let mut reader = fleet.subscriber();
    let mut ticks = Vec::new();
    while ticks.len() < 5 {
        ticks.extend(reader.wait(TIMEOUT).expect("readable").map(|frame| frame.tick()));
    }
    assert!(ticks.iter().all(|tick| tick.is_multiple_of(10)), "{ticks:?}");
}

#[test]
fn the_command_log_contains_the_commands_that_the_engine_took() {
    let fleet = Fleet::start("command-log", "thirty.yaml", &[]);
    let participant = Participant::join(&fleet.name, "recorder").unwrap();
    let mut log = CommandLogReader::open_on(&participant).unwrap();
    let mut commands = Commands::open_on(&participant).unwrap();
    let token = commands.hold(3);
    commands.hold(4_000);
    let before = fleet.tick();
    commands.send().unwrap();
    let (tick, records) = eventually("the commands in the log", || {
        let mut seen = None;
        log.take(|log| {
            seen = Some((log.header.tick, log.records.to_vec()));
            Ok::<_, ReadError>(())
        })
        .unwrap();
        seen
    });
    assert!(tick > before && tick <= fleet.tick());
    assert_eq!((records[0].token, records[0].robot), (token, 3));
    assert_eq!(records[1].robot, 4_000, "a refused command is in the log too");
}
