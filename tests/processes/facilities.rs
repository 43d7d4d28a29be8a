//! Doors and lifts on real engines: requested from the command line, and known to late readers.

use std::process::Output;

use regatta_plugin::facility::{DoorState, FacilityState};
use regatta_plugin::{FacilityReader, Participant, Subscriber};

use crate::fleet::{Fleet, eventually, regatta};

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
fn states(fleet: &Fleet) -> Vec<FacilityState> {
    let participant = Participant::join(&fleet.name, "late").expect("joined");
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
    let late = states(&fleet);
    assert_eq!((late.len(), late[2].level), (3, 1), "{late:?}");
    shows(&fleet, "lift  lift  at upper, closed");
    assert!(states(&fleet).iter().all(|state| state.door() == DoorState::Closed));
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
