//! `regatta top` in a pseudo-terminal.

use regatta_plugin::contact::{ContactHeader, ContactRecord};
use regatta_plugin::{ContactPublisher, FleetName, Participant};
use rustix::process::Signal;

use crate::fleet::{Fleet, Process, eventually, regatta, unique};
use crate::readers::costs_no_late_tick;
use crate::terminal::Terminal;

fn top(fleet: &FleetName) -> Terminal {
    Terminal::start(&["top", "--fleet", &fleet.to_string()], 80, 24)
}

#[test]
fn a_fleet_is_shown_and_controlled_by_keys() {
    let fleet = Fleet::start("top", "thirty.yaml", &[]);
    let top = top(&fleet.name);
    for text in [
        "running",
        "×1",
        "tick cost",
        "real time",
        "frame age",
        "robots",
        "moving",
        "engine",
        "q quit",
    ] {
        top.shows(text);
    }
    top.shows_that("all 30 robots", |screen| {
        screen.lines().any(|line| line.contains("robots") && line.contains(" 30 "))
    });

    top.press(" ");
    top.shows("● paused");
    assert_eq!(fleet.status()["clock"], "paused");
    let tick = fleet.tick();
    top.press("s");
    eventually("a step", || (fleet.tick() == tick + 1).then_some(()));
    top.shows("stepped to tick");
    top.press("+");
    eventually("twice the speed", || (fleet.status()["speed"] == 2.0).then_some(()));
    top.press("--");
    eventually("half the speed", || (fleet.status()["speed"] == 0.5).then_some(()));
    top.press(" ");
    eventually("the clock runs", || (fleet.status()["clock"] == "running").then_some(()));
    top.press("m");
    eventually("full speed", || (fleet.status()["speed"] == "max").then_some(()));
    top.shows("max");
    top.press("?");
    top.shows("pause or resume");

    top.press("q");
    assert_eq!(top.finish().code(), Some(0));
    fleet.let_ticks_pass(10);
}

#[test]
fn top_waits_for_an_engine_and_continues_with_the_next_one() {
    let name = unique("top-waits");
    let top = top(&name);
    top.shows("No engine runs");
    let fleet = Fleet::restart(name.clone(), "thirty.yaml", &[]);
    top.shows("● running");
    fleet.engine.signal(Signal::KILL);
    fleet.engine.finish();
    top.shows("No engine runs");
    let _fleet = Fleet::restart(name, "thirty.yaml", &[]);
    top.shows("● running");
    top.press("\x03");
    assert_eq!(top.finish().code(), Some(0), "Ctrl-C");
}

#[test]
fn top_responds_to_keys_while_the_engine_is_stopped() {
    let fleet = Fleet::start("top-stopped", "thirty.yaml", &[]);
    let top = top(&fleet.name);
    top.shows("● running");
    fleet.engine.signal(Signal::STOP);
    top.press(" ");
    top.press("?");
    top.shows("pause or resume");
    top.shows("has not answered");
    // Escape closes the help before it quits.
    top.press("\x1b");
    top.shows_that("no help", |screen| !screen.contains("pause or resume"));
    top.shows("halted");
    fleet.engine.signal(Signal::CONT);
    top.press("q");
    assert_eq!(top.finish().code(), Some(0));
}

#[test]
fn the_end_of_input_is_no_key() {
    let fleet = Fleet::start("top-input-ends", "thirty.yaml", &[]);
    let top = top(&fleet.name);
    top.shows("● running");
    // Programs such as `script` send one of these at the end of their input.
    top.press("\0\x04");
    // The answer shows that the keys before were read.
    top.press("?");
    top.shows("pause or resume");
    fleet.let_ticks_pass(10);
    assert_eq!(fleet.status()["clock"], "running");
    top.press("q");
    assert_eq!(top.finish().code(), Some(0));
}

#[test]
fn sigterm_restores_the_terminal() {
    let fleet = Fleet::start("top-sigterm", "thirty.yaml", &[]);
    let top = top(&fleet.name);
    top.shows("● running");
    top.signal(Signal::TERM);
    assert_eq!(top.finish().code(), Some(0));
}

#[test]
fn a_missing_terminal_is_reported_in_one_line() {
    let output = Process::start(regatta().arg("top")).finish();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        !output.status.success() && message.lines().count() == 1 && message.contains("terminal"),
        "{message}"
    );
}

#[test]
fn collisions_are_listed_and_scroll() {
    let fleet = Fleet::start("top-collisions", "thirty.yaml", &[]);
    let mut checker =
        ContactPublisher::open_on(&Participant::join(&fleet.name, "checker").expect("joined"))
            .expect("contacts");
    let mut frames = fleet.subscriber();
    let (run_id, tick) =
        eventually("a frame", || frames.latest().ok()?.map(|frame| (frame.run_id(), frame.tick())));
    let mut pairs = Vec::new();
    for k in 0..40 {
        let level = if k < 3 { 2 } else { 1 };
        pairs.push(ContactRecord { robots: [100 + k, 200 + k], level, ..Default::default() });
    }
    let header =
        ContactHeader { run_id, tick, touching: 3, possible: 37, ..ContactHeader::default() };
    let top = top(&fleet.name);
    // The contacts are published again and again, as a checker does, because old ones are not
    // shown.
    let mut shows = |text: &str| {
        top.shows_that(text, |screen| {
            checker.publish(&header, &pairs).expect("published");
            screen.contains(text)
        });
    };
    shows("3 touching, 37 possible");
    shows("100 200");
    top.press("\x1b[F");
    shows("139 239");
    top.press("\x1b[H");
    shows("100 200");
    top.resize(120, 40);
    shows("115 215");
    top.press("q");
    assert_eq!(top.finish().code(), Some(0));
}

#[test]
fn top_causes_no_late_tick() {
    costs_no_late_tick("top-killed", |fleet| {
        let top = top(&fleet.name);
        top.shows("● running");
        top.signal(Signal::STOP);
        fleet.let_ticks_pass(60);
        top.signal(Signal::CONT);
        fleet.let_ticks_pass(10);
        top.signal(Signal::KILL);
    });
}

/// The window of a terminal is closed, or the connection to its host breaks.
#[test]
fn top_ends_with_its_terminal() {
    let (pty, pts) = pty_process::blocking::open().expect("a pseudo-terminal");
    pty.resize(pty_process::Size::new(24, 80)).expect("resized");
    let name = unique("top-hung-up").to_string();
    let command = pty_process::blocking::Command::new(env!("CARGO_BIN_EXE_regatta"));
    let command = command.args(["top", "--fleet", &name]).env("TERM", "xterm-256color");
    let top = Process(command.spawn(pts).expect("it starts"));
    let mut drawn = Vec::new();
    while !String::from_utf8_lossy(&drawn).contains("No engine runs") {
        let mut bytes = [0; 4096];
        let count = std::io::Read::read(&mut &pty, &mut bytes).expect("a drawing");
        drawn.extend_from_slice(&bytes[..count]);
    }
    drop(pty);
    top.finish();
}
