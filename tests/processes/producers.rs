//! Behaviour that all producers share: the engine, a replay, and one that a user wrote; and the
//! plugin outside of the workspace that the README tells people to write.

use std::process::Command;
use std::time::Duration;

use regatta_plugin::frame::ClockState;
use regatta_plugin::{
    ColumnReader, Commands, Control, ControlError, FleetName, Participant, Subscriber,
};
use regatta_record::{Recording, Topic};
use tempfile::TempDir;

use crate::fleet::{Fleet, Process, build_example, eventually, graphs, regatta, unique};
use crate::record::{file, record, recorder};

/// A client of a fleet's control service, as soon as it answers.
fn control(fleet: &FleetName) -> Control {
    let mut control = eventually("control", || Control::open(fleet).ok());
    eventually("an answer", || control.status().ok());
    control
}

/// Asks for more steps than there is time for, and pauses meanwhile: the stepper must not wait for
/// ever.
fn a_pause_ends_a_step(fleet: &FleetName) {
    let mut pausing = control(fleet);
    pausing.pause().expect("paused");
    pausing.speed(0.1).expect("slow");
    let before = pausing.status().expect("answered").tick;
    let stepping = std::thread::spawn({
        let fleet = fleet.clone();
        move || control(&fleet).step(1_000)
    });
    eventually("the first step", || {
        (pausing.status().expect("answered").tick > before).then_some(())
    });
    pausing.pause().expect("paused");
    eventually("the stepper's answer", || stepping.is_finished().then_some(()));
    let refused = stepping.join().expect("no panic");
    assert!(
        matches!(
            &refused,
            Err(ControlError::Refused { reason, .. }) if reason.contains("a pause ended the step")
        ),
        "{refused:?}"
    );
    let status = pausing.status().expect("answered");
    assert_eq!(status.clock, ClockState::Paused as u32);
    assert!(status.tick < before + 1_000);
    assert!(status.resident_bytes > 1_000_000, "{status:?}");
    assert_eq!(pausing.step(1).expect("stepped").tick, status.tick + 1, "steps work as before");
}

#[test]
fn a_pause_ends_a_step_of_the_engine() {
    let fleet = Fleet::start("pause-engine", "thirty.yaml", &[]);
    a_pause_ends_a_step(&fleet.name);
}

#[test]
fn a_pause_ends_a_step_of_a_replay() {
    let folder = TempDir::new().expect("a folder");
    record("pause-source", "thirty.yaml", 2_000, &file(&folder), &[]);
    let fleet = unique("pause-replay");
    let args = ["--paused", "--fleet", fleet.as_str()];
    let _replay = Process::start(regatta().arg("replay").arg(file(&folder)).args(args));
    a_pause_ends_a_step(&fleet);
}

#[test]
fn the_example_producer_builds_by_itself_and_is_a_fleet_like_any_other() {
    let fleet = unique("own-producer");
    let lockstep =
        ["--fleet", fleet.as_str(), "--rate", "100", "--speed", "max", "--lockstep", "hello"];
    let gateway = Process::start(Command::new(build_example("own-producer")).args(lockstep));
    let hello = Process::start(regatta().args(["plugin", "hello", "--fleet", fleet.as_str()]));
    a_pause_ends_a_step(&fleet);

    let mut control = control(&fleet);
    assert_eq!(control.status().expect("answered").robots, 12);
    let mut frames = Subscriber::open(&fleet).expect("opened");
    let x = eventually("a frame of all of them", || {
        let frame = frames.wait(Duration::from_millis(100)).expect("readable")?;
        (frame.len() == 12).then(|| frame.x().to_vec())
    });
    assert!(x.iter().any(|x| *x > 9.0), "{x:?}");
    for refused in [control.robots(20), control.seek(Duration::ZERO)] {
        assert!(matches!(refused, Err(ControlError::Refused { .. })), "{refused:?}");
    }
    control.speed(f32::INFINITY).expect("changed");
    control.resume().expect("resumed");
    let tick = control.status().expect("answered").tick;
    eventually("the run goes on", || {
        (control.status().expect("answered").tick > tick + 50).then_some(())
    });
    let lines = String::from_utf8_lossy(&hello.interrupt().stdout).into_owned();
    let ticks: Vec<u64> = lines
        .lines()
        .filter_map(|line| line.strip_prefix("tick ")?.split(':').next()?.parse().ok())
        .collect();
    assert!(
        ticks.len() > 50 && ticks.windows(2).all(|pair| pair[1] == pair[0] + 1),
        "every tick once: {ticks:?}"
    );
    assert!(gateway.interrupt().status.success());
}

#[test]
fn plugins_in_lockstep_lose_no_events_because_frames_are_rare() {
    let fleet = unique("rare-frames");
    let output = regatta()
        .arg("engine")
        .arg(graphs("thirty.yaml"))
        .args(["--fleet", fleet.as_str(), "--publish-rate", "0.01", "--lockstep", "nobody"])
        .output()
        .expect("it starts");
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success() && message.lines().count() == 1, "{message}");
    assert!(message.contains("would lose events"), "{message}");
}

#[test]
fn a_step_beyond_the_end_of_a_run_is_refused_by_every_producer() {
    let folder = TempDir::new().expect("a folder");
    record("step-end-source", "thirty.yaml", 50, &file(&folder), &[]);
    let replay = unique("step-end-replay");
    let _replay = Process::start(regatta().arg("replay").arg(file(&folder)).args([
        "--paused",
        "--fleet",
        replay.as_str(),
    ]));
    let limited = unique("step-end-engine");
    let args = ["--ticks", "6000", "--fleet", limited.as_str()];
    let _limited = Process::start(regatta().arg("engine").arg(graphs("thirty.yaml")).args(args));
    for fleet in [&replay, &limited] {
        let mut control = control(fleet);
        control.pause().expect("paused");
        control.speed(f32::INFINITY).expect("changed");
        let refused = control.step(100_000);
        assert!(
            matches!(
                &refused,
                Err(ControlError::Refused { reason, .. }) if reason.contains("the end of the run")
            ),
            "{fleet}: {refused:?}"
        );
    }
}

/// Contact events and the order log overflow, too, if only the frames at a low rate have the
/// recorder read them.
#[test]
fn a_recorder_at_a_low_rate_loses_nothing() {
    let folder = TempDir::new().expect("a folder");
    let fleet = Fleet::start("record-rate", "warehouse-1000.yaml", &[]);
    let collision = fleet.plugin("collision");
    let recorder = recorder(&fleet.name, &file(&folder), &["--rate", "1", "--poses-rate", "0"]);
    fleet.let_ticks_pass(350);
    let output = recorder.interrupt();
    let report = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && collision.interrupt().status.success(), "{report}");
    assert!(
        report.contains("no frame lost") && !report.contains("other messages lost"),
        "{report}"
    );
    let recording = Recording::open(&file(&folder)).expect("a recording");
    assert!(recording.count(&Topic::ContactEvents) > 100, "{report}");
}

#[test]
fn the_example_plugin_builds_by_itself_and_reads_the_fleet() {
    // Built before the fleet starts: its robots drive for a few seconds only, and the build takes a
    // minute or two.
    let program = build_example("own-plugin");
    let fleet = Fleet::start("own-plugin", "thirty.yaml", &[]);
    let plugin = Process::start(Command::new(program).args(["--fleet", &fleet.name.to_string()]));
    let participant = Participant::join(&fleet.name, "test").expect("joined");
    let mut column = ColumnReader::open_on(&participant, "standing").expect("opened");
    let mut commands = Commands::open_on(&participant).expect("opened");
    commands.hold(7);
    commands.send().expect("sent");
    eventually("robot 7 stands for a second, and others drive on", || {
        let standing = column.latest().expect("readable")?.values;
        (standing.len() == 30 && standing[7] > 1.0 && standing.contains(&0.0)).then_some(())
    });
    let output = plugin.interrupt();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(
        text.lines().any(|line| line.contains("robot ") && line.contains("has stood for")),
        "{text}"
    );
}
