//! A pseudo-terminal with a program in it, whose screen tests parse.

use std::io::{Read, Write};
use std::num::NonZeroU16;
use std::process::ExitStatus;
use std::sync::Arc;

use parking_lot::Mutex;
use pty_process::Size;
use pty_process::blocking::{Command, Pty, open};
use rustix::process::Signal;
use rustix::termios::{LocalModes, Termios, tcgetattr};
use vt100::Parser;

use crate::fleet::{Process, eventually};

/// A pseudo-terminal with a program in it. The program is killed when the terminal is dropped.
pub struct Terminal {
    pty: Arc<Pty>,
    parser: Arc<Mutex<Parser>>,
    program: Process,
    /// The modes of the terminal before the program started.
    modes: Termios,
}

impl Terminal {
    /// Starts `regatta` in a terminal of the given size.
    pub fn start(args: &[&str], columns: u16, rows: u16) -> Self {
        Self::with(Command::new(env!("CARGO_BIN_EXE_regatta")).args(args), columns, rows)
    }

    /// Starts a command in a terminal of the given size.
    pub fn with(command: Command, columns: u16, rows: u16) -> Self {
        let (pty, pts) = open().expect("a pseudo-terminal");
        pty.resize(Size::new(rows, columns)).expect("resized");
        let modes = tcgetattr(&pty).expect("the modes");
        let command = command.env("TERM", "xterm-256color").env_remove("NO_COLOR");
        let program = Process(command.spawn(pts).expect("it starts"));
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
    pub fn text(&self) -> String {
        self.parser.lock().screen().contents()
    }

    /// Waits until the screen shows a text.
    pub fn shows(&self, text: &str) {
        self.shows_that(text, |screen| screen.contains(text));
    }

    /// Waits until the screen fulfils a condition.
    pub fn shows_that(&self, expected: &str, mut condition: impl FnMut(&str) -> bool) {
        let shown = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            eventually(expected, || condition(&self.text()).then_some(()));
        }));
        assert!(shown.is_ok(), "{expected} is not on the screen:\n{}", self.text());
    }

    /// Presses keys.
    pub fn press(&self, keys: &str) {
        (&*self.pty).write_all(keys.as_bytes()).expect("typed");
    }

    pub fn resize(&self, columns: u16, rows: u16) {
        self.pty.resize(Size::new(rows, columns)).expect("resized");
        self.parser.lock().screen_mut().set_size(non_zero(rows), non_zero(columns));
    }

    pub fn signal(&self, signal: Signal) {
        self.program.signal(signal);
    }

    /// Waits for the end of the program, asserts that the terminal has its former modes, and
    /// returns the exit status.
    pub fn finish(mut self) -> ExitStatus {
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
