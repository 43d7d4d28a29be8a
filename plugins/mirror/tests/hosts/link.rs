//! World, frames and columns; processes that come late, are killed, stopped and started again.

use std::time::Duration;

use regatta_plugin::{ColumnReader, Control, Participant, Subscriber, WorldReader};
use rustix::process::Signal;
use zenoh::{Config, Wait};

use crate::engine::{Engine, NODE};
use crate::process::{Hosts, Process, wait_for};

#[test]
fn a_late_joiner_sees_world_frames_and_columns() {
    let hosts = Hosts::new("joiner");
    let _engine = hosts.engine();
    let _send = hosts.send();
    let _receive = hosts.receive();
    let run = hosts.wait_for_frames();

    let fleet = Participant::join(&hosts.copy, "test").expect("the fleet");
    let mut worlds = WorldReader::open_on(&fleet).expect("a reader");
    wait_for("the world", || {
        let world = worlds.latest().expect("a world or none")?;
        assert_eq!((world.run_id(), world.edges()[0].id), (run, 7));
        assert_eq!(world.text(world.nodes()[0].name), NODE);
        Some(())
    });
    for (name, moves) in [("battery", true), ("type", false)] {
        let mut column = ColumnReader::open_on(&fleet, name).expect("a reader");
        wait_for(name, || {
            let column = column.latest().expect("a column or none")?;
            assert_eq!((column.header.run_id, column.values.len()), (run, Engine::ROBOTS));
            let expected = if moves { column.header.tick as f32 } else { 0.0 };
            assert_eq!(column.values[Engine::ROBOTS - 1], expected);
            Some(())
        });
    }
}

#[test]
fn q16_shows_the_same_robots() {
    let hosts = Hosts::new("q16");
    let _engine = hosts.engine();
    let _send = hosts.send();
    let _receive = hosts.receive_with(&["--encoding", "q16"]);
    let mut frames = Subscriber::open(&hosts.copy).expect("a subscriber");
    wait_for("a frame", || {
        let frame = frames.wait(Duration::from_millis(100)).expect("a frame or none")?;
        for (row, x) in frame.x().iter().enumerate() {
            let error = (x - crate::engine::value(frame.tick(), row)).abs();
            assert!(error < 2000.0 / 65535.0, "{error}");
        }
        Some(())
    });
}

#[test]
fn each_process_may_be_killed_and_started_again() {
    let hosts = Hosts::new("restarts");
    let engine = hosts.engine();
    let send = hosts.send();
    let receive = hosts.receive();
    let first = hosts.wait_for_frames();
    drop(send);
    let _send = hosts.send();
    assert_eq!(hosts.wait_for_frames(), first, "the same run of the engine");
    drop(engine);
    let _engine = hosts.engine();
    let second =
        wait_for("another run", || Some(hosts.wait_for_frames()).filter(|run| *run != first));
    drop(receive);
    let _receive = hosts.receive();
    wait_for("another run", || Some(hosts.wait_for_frames()).filter(|run| *run != second));
}

#[test]
fn a_stopped_receiver_stops_nobody_else() {
    let hosts = Hosts::new("stopped");
    let _engine = hosts.engine();
    let _send = hosts.send();
    let stopped = hosts.receive();
    hosts.wait_for_frames();
    stopped.signal(Signal::STOP);
    let other = Hosts { copy: format!("{}-b", hosts.copy).parse().expect("a name"), ..hosts };
    let _receive = other.receive();
    other.wait_for_frames();
    let mut control = Control::open(&other.fleet).expect("control");
    let tick = control.status().expect("the engine answers").tick;
    wait_for("ticks", || (control.status().ok()?.tick > tick + 20).then_some(()));
    stopped.signal(Signal::CONT);
    let back = other.copy.as_str().strip_suffix("-b").expect("it").parse().expect("a name");
    Hosts { copy: back, ..other }.wait_for_frames();
}

#[test]
fn malformed_messages_are_ignored() {
    let hosts = Hosts::new("malformed");
    let _engine = hosts.engine();
    let mut send = hosts.send();
    let own = Hosts::new("free").address;
    let mut receive = hosts.receive_with(&["--listen", &own]);
    hosts.wait_for_frames();
    let session = stranger(&[&hosts.address, &own]);
    let fleet = &hosts.fleet;
    for bytes in [&b"RGTM"[..], b"", &[0xFF; 70_000]] {
        for key in ["commands", "events", "frames/raw", "columns/battery", "world"] {
            session.put(format!("regatta/{fleet}/{key}"), bytes).wait().expect("sent");
        }
        for key in ["control", "world", "columns/*"] {
            let replies = session.get(format!("regatta/{fleet}/{key}")).payload(bytes).wait();
            while let Ok(reply) = replies.as_ref().expect("asked").recv() {
                let is_control = key == "control";
                assert_eq!(reply.result().is_err(), is_control, "an error in zenoh's protocol");
            }
        }
    }
    hosts.wait_for_frames();
    assert!(send.is_running() && receive.is_running());
}

/// A peer of both sides that isn't Regatta's.
fn stranger(addresses: &[&str]) -> zenoh::Session {
    let mut config = Config::default();
    for (key, value) in [
        ("scouting/multicast/enabled", "false"),
        ("listen/endpoints", "[]"),
        ("connect/endpoints", &format!("{addresses:?}")),
    ] {
        config.insert_json5(key, value).expect("a setting");
    }
    zenoh::open(config).wait().expect("a session")
}

#[test]
fn an_address_in_use_is_told() {
    let hosts = Hosts::new("address");
    let mut first = hosts.send();
    let mut second: Option<Process> = None;
    wait_for("a refusal", || {
        let second = second.get_or_insert_with(|| hosts.send());
        (!second.is_running()).then_some(())
    });
    assert!(first.is_running());
}
