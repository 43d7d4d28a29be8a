//! `regatta top` in a pseudo-terminal, whose screen the tests parse.

use std::io::{Read, Write};
use std::num::NonZeroU16;
use std::process::ExitStatus;
use std::sync::Arc;

use parking_lot::Mutex;
use pty_process::Size;
use pty_process::blocking::{Command, Pty, open};
use regatta_plugin::contact::{ContactHeader, ContactRecord};
use regatta_plugin::{ContactPublisher, FleetName, Participant};
use rustix::process::Signal;
use rustix::termios::{LocalModes, Termios, tcgetattr};
use vt100::Parser;

use crate::fleet::{Fleet, Process, eventually, regatta, unique};
use crate::readers::costs_no_late_tick;

/// A pseudo-terminal with a program in it. The program is killed when the terminal is dropped.
struct Terminal {
    pty: Arc<Pty>,
    parser: Arc<Mutex<Parser>>,
    program: Process,
    /// The modes of the terminal before the program started.
    modes: Termios,
}

impl Terminal {
    /// Starts `regatta` in a terminal of the given size.
    fn start(args: &[&str], columns: u16, rows: u16) -> Self {
        let (pty, pts) = open().expect("a pseudo-terminal");
        pty.resize(Size::new(rows, columns)).expect("resized");
        let modes = tcgetattr(&pty).expect("the modes");
        let command =
            Command::new(env!("CARGO_BIN_EXE_regatta")).args(args).env("TERM", "xterm-256color");
        let program = Process(command.env_remove("NO_COLOR").spawn(pts).expect("regatta starts"));
        let terminal = Self {
            pty: Arc::new(pty),
            parser: Arc::new(Mutex::new(Parser::new(non_zero(rows), non_zero(columns), 0))),
            program,
            modes,
        };
        terminal.parse_output();
        terminal
    }

    /// Parses the output of the program in a thread, until the program ends.
    fn parse_output(&self) {
        let (pty, parser) = (Arc::clone(&self.pty), Arc::clone(&self.parser));
        std::thread::spawn(move || {
            let mut bytes = [0; 4096];
            while let Ok(count @ 1..) = (&*pty).read(&mut bytes) {
                parser.lock().process(&bytes[..count]);
            }
        });
    }

    /// Returns the text on the screen.
    fn text(&self) -> String {
        self.parser.lock().screen().contents()
    }

    /// Waits until the screen shows a text.
    fn shows(&self, text: &str) {
        self.shows_that(text, |screen| screen.contains(text));
    }

    /// Waits until the screen fulfils a condition.
    fn shows_that(&self, expected: &str, mut condition: impl FnMut(&str) -> bool) {
        let shown = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            eventually(expected, || condition(&self.text()).then_some(()));
        }));
        assert!(shown.is_ok(), "{expected} is not on the screen:\n{}", self.text());
    }

    /// Presses keys.
    fn press(&self, keys: &str) {
        (&*self.pty).write_all(keys.as_bytes()).expect("typed");
    }

    fn resize(&self, columns: u16, rows: u16) {
        self.pty.resize(Size::new(rows, columns)).expect("resized");
        self.parser.lock().screen_mut().set_size(non_zero(rows), non_zero(columns));
    }

    fn signal(&self, signal: Signal) {
        self.program.signal(signal);
    }

    /// Waits for the end of the program, asserts that the terminal has its former modes, and
    /// returns the exit status.
    fn finish(mut self) -> ExitStatus {
        let status =
            eventually("the program ends", || self.program.0.try_wait().expect("a status"));
        eventually("the terminal is restored", || {
            let parser = self.parser.lock();
            (!parser.screen().alternate_screen() && !parser.screen().hide_cursor()).then_some(())
        });
        let modes = tcgetattr(&*self.pty).expect("the modes");
        assert!(
            modes.local_modes.contains(LocalModes::ICANON | LocalModes::ECHO),
            "{:?}",
            modes.local_modes
        );
        assert_eq!(
            (modes.local_modes, modes.input_modes),
            (self.modes.local_modes, self.modes.input_modes)
        );
        assert_eq!(
            (modes.output_modes, modes.control_modes),
            (self.modes.output_modes, self.modes.control_modes)
        );
        status
    }
}

fn non_zero(length: u16) -> NonZeroU16 {
    NonZeroU16::new(length).expect("a size")
}

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
        "driving",
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
    top.shows("halted");
    // Escape closes the help before it quits.
    top.press("\x1b");
    top.shows_that("no help", |screen| !screen.contains("pause or resume"));
    fleet.engine.signal(Signal::CONT);
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
