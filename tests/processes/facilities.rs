//! Doors and lifts on real engines: requested from the command line, and known to late readers.

use std::process::Output;
use std::time::Duration;

use regatta_plugin::facility::{DoorState, FacilityState};
use regatta_plugin::{Control, FacilityReader, FleetName, Participant, Subscriber};
use tempfile::TempDir;

use crate::fleet::{Fleet, Process, eventually, regatta, unique};
use crate::record::{file, recorder};

fn run(fleet: &Fleet, arguments: &[&str]) -> Output {
    let mut command = regatta();
    command.args(arguments).args(["--fleet", &fleet.name.to_string()]);
    command.output().expect("the program starts")
}

fn status(fleet: &Fleet) -> String {
    String::from_utf8_lossy(&run(fleet, &["status"]).stdout).into_owned()
}

/// Waits until the status has a line.
fn shows(fleet: &Fleet, line: &str) {
    eventually(line, || status(fleet).lines().any(|other| other == line).then_some(()));
}

fn accepted(fleet: &Fleet, arguments: &[&str]) {
    let output = run(fleet, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
}

/// Reads the states of doors and lifts as one who joins now.
fn states(fleet: &FleetName) -> Vec<FacilityState> {
    let participant = Participant::join(fleet, "late").expect("joined");
    let mut facilities = FacilityReader::open_on(&participant).expect("a reader");
    let mut frames = Subscriber::open_on(&participant).expect("a reader");
    eventually("the states", || {
        let run = frames.latest().expect("readable")?.run_id();
        facilities.take().expect("readable").then(|| facilities.states(run).to_vec())
    })
}

#[test]
fn doors_and_lifts_are_requested_from_the_command_line() {
    let fleet = Fleet::start("facilities", "lift.yaml", &["--robots", "1", "--speed", "4"]);
    shows(&fleet, "door  hall  closed");
    shows(&fleet, "lift  lift  at ground, closed");
    accepted(&fleet, &["command", "door", "hall"]);
    shows(&fleet, "door  hall  open");
    assert!(status(&fleet).contains("door  store  closed"), "{}", status(&fleet));
    shows(&fleet, "door  hall  closed");
    accepted(&fleet, &["command", "lift", "lift", "upper"]);
    shows(&fleet, "lift  lift  from ground to upper");
    shows(&fleet, "lift  lift  at upper, open");
    let late = states(&fleet.name);
    assert_eq!((late.len(), late[2].level), (3, 1), "{late:?}");
    shows(&fleet, "lift  lift  at upper, closed");
    assert!(states(&fleet.name).iter().all(|state| state.door() == DoorState::Closed));
    for (arguments, message) in [
        (&["command", "door", "gate"][..], "no door is called 'gate'; there are hall, store"),
        (&["command", "lift", "lift", "roof"], "no level of that lift is called 'roof'"),
        (&["command", "lift", "north", "upper"], "no lift is called 'north'; there are lift"),
    ] {
        let output = run(&fleet, arguments);
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && error.contains(message), "{arguments:?}: {error}");
    }
}

#[test]
fn a_door_that_was_open_is_open_in_the_replay() {
    let folder = TempDir::new().expect("a folder");
    let fleet = Fleet::start("facilities-live", "lift.yaml", &["--robots", "1", "--speed", "4"]);
    let recorder = recorder(&fleet.name, &file(&folder), &[]);
    eventually("the recorder is there", || file(&folder).exists().then_some(()));
    accepted(&fleet, &["command", "door", "hall"]);
    shows(&fleet, "door  hall  open");
    fleet.control(&["pause"]);
    let live = states(&fleet.name);
    assert_eq!(live[0].door(), DoorState::Open);
    let mut control = Control::open(&fleet.name).expect("an engine");
    let opened = Duration::from_nanos(control.status().expect("an answer").sim_time_nanos);
    fleet.control(&["resume"]);
    shows(&fleet, "door  hall  closed");
    let closed = Duration::from_nanos(control.status().expect("an answer").sim_time_nanos);
    eventually("a second more", || {
        let now = Duration::from_nanos(control.status().ok()?.sim_time_nanos);
        (now > closed + Duration::from_secs(1)).then_some(())
    });
    assert!(recorder.interrupt().status.success());

    let replay = unique("facilities-replay");
    let mut command = regatta();
    command.arg("replay").arg(file(&folder)).args(["--paused", "--fleet", &replay.to_string()]);
    let _replay = Process::start(&mut command);
    let mut control = eventually("control", || Control::open(&replay).ok());
    eventually("the replay answers", || control.status().ok());
    let mut shows = |time, door| {
        control.seek(time).expect("it is a replay");
        eventually("the state of that time", || {
            Some(states(&replay)).filter(|states| states[0].door() == door)
        })
    };
    assert_eq!(shows(opened, DoorState::Open), live, "the states of the live run");
    shows(closed, DoorState::Closed);
    assert_eq!(shows(opened, DoorState::Open), live, "back in time");
}
