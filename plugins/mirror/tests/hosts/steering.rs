//! Control requests, commands and their answers.

use regatta_plugin::command::RouteLeg;
use regatta_plugin::event::{EventKind, EventRecord, Refusal};
use regatta_plugin::frame::ClockState;
use regatta_plugin::{Commands, Control, EventReader, Result};

use crate::engine::Engine;
use crate::process::{Hosts, wait_for};

/// Sends commands to the copy until each has an answer; returns the answers.
fn answers(hosts: &Hosts) -> [EventRecord; 2] {
    let mut events = EventReader::open(&hosts.copy).expect("events");
    let mut commands = Commands::open(&hosts.copy).expect("commands");
    let tokens = [commands.hold(3), commands.assign(5, &[RouteLeg::forward(7); 3])];
    commands.send().expect("the receiver takes them");
    let mut found: Vec<EventRecord> = Vec::new();
    wait_for("answers", || {
        events
            .take(|tick| -> Result {
                let of_ours = tick.records.iter().filter(|event| tokens.contains(&event.token));
                found.extend(of_ours);
                Ok(())
            })
            .expect("events or none");
        found.first_chunk::<2>().copied()
    })
}

#[test]
fn commands_reach_the_engine_and_their_answers_come_back() {
    let hosts = Hosts::new("commands");
    let _engine = hosts.engine();
    let send = hosts.send();
    let _receive = hosts.receive();
    hosts.wait_for_frames();
    let [hold, assign] = answers(&hosts);
    let accepted = EventKind::Accepted as u32;
    // The engine answers with the number of records: two commands and three legs.
    assert_eq!([hold.kind, hold.robot, hold.id], [accepted, 3, 5]);
    assert_eq!([assign.kind, assign.robot, assign.id], [accepted, 5, 5]);
    drop(send);
    wait_for("a refusal", || {
        let [hold, _] = answers(&hosts);
        let refused = (EventKind::Refused as u32, Refusal::NotSteerable as u32);
        ((hold.kind, hold.detail) == refused).then_some(())
    });
}

#[test]
fn control_requests_are_answered_by_the_engine() {
    let hosts = Hosts::new("control");
    let _engine = hosts.engine();
    let send = hosts.send();
    let _receive = hosts.receive();
    let run = hosts.wait_for_frames();
    let mut control = Control::open(&hosts.copy).expect("control");
    let status = control.status().expect("a status");
    assert_eq!((status.run_id, status.robots), (run, Engine::ROBOTS as u32));
    let paused = control.pause().expect("a pause");
    assert_eq!(paused.clock, ClockState::Paused as u32);
    let stepped = control.step(5).expect("five ticks");
    assert_eq!(stepped.tick, paused.tick + 5);
    let refused = control.robots(3).expect_err("it can't change them").to_string();
    assert!(refused.contains("can't change its number of robots"), "{refused}");
    assert_eq!(control.speed(2.0).expect("a speed").speed, 2.0);
    control.resume().expect("it runs");
    hosts.wait_for_frames();
    drop(send);
    let lost = wait_for("a refusal", || control.pause().err()).to_string();
    assert!(lost.contains("can't be reached"), "{lost}");
}

#[test]
fn a_sender_that_only_shows_takes_neither_commands_nor_requests() {
    let hosts = Hosts::new("read-only");
    let _engine = hosts.engine();
    let _send = hosts.send_with(&["--read-only"]);
    let _receive = hosts.receive();
    hosts.wait_for_frames();
    let [hold, assign] = answers(&hosts);
    assert_eq!([hold.detail, assign.detail], [Refusal::NotSteerable as u32; 2]);
    let mut control = Control::open(&hosts.copy).expect("control");
    assert!(control.pause().is_err());
}
