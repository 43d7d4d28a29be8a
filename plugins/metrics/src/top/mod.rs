//! `regatta top`: a fleet live in a terminal, and keys to steer it.

mod figures;
mod format;
mod graphs;
mod history;
mod lists;
mod screen;
mod steering;
mod terminal;
mod theme;

use std::time::{Duration, Instant};

use ratatui::crossterm::event::{self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use regatta_plugin::{FleetName, Participant, Result, Subscriber, Termination};

use crate::collisions::CollisionReader;
use crate::fold::{Fold, wall_time_nanos};
use crate::processes::ProcessWatch;
use history::SLOT;
use screen::View;
use steering::{Command, Steering};
use terminal::Taken;

/// The name that this process goes by in its fleet.
const NAME: &str = "top";
/// Between two drawings, unless a key is pressed.
const REDRAW: Duration = Duration::from_millis(100);
/// Longest sleep between two looks for a key.
const NAP: Duration = Duration::from_millis(30);
/// Without frames for so long, look whether there is an engine at all.
const SILENCE: Duration = Duration::from_secs(1);
/// How long the outcome of a key is shown.
const SHOWN: Duration = Duration::from_secs(4);
/// Lines that Page Up and Page Down scroll.
const PAGE: isize = 10;

/// Shows a fleet until `q`, Esc, Ctrl-C or `SIGTERM`.
///
/// # Errors
/// If there is no terminal, shared memory can't be used, or the fleet speaks another version of the contract.
pub fn run(fleet: &FleetName) -> Result {
    let termination = Termination::watch()?;
    terminal::check()?;
    let mut reader = Reader::open(fleet)?;
    let mut keys = Keys { steering: Steering::start(fleet)?, shown_until: Instant::now(), ended: false };
    let mut view = View::new(fleet);
    let mut terminal = Taken::take()?;
    let mut next_drawing = Instant::now();
    while !termination.requested() && !keys.ended {
        let touched = keys.read(&mut view)?;
        reader.read(next_drawing.saturating_duration_since(Instant::now()))?;
        if touched || Instant::now() >= next_drawing {
            reader.show(&mut view);
            terminal.screen.draw(|frame| screen::draw(frame, &mut view))?;
            next_drawing = Instant::now() + REDRAW;
        }
    }
    Ok(())
}

/// Reads the fleet.
struct Reader {
    fleet: FleetName,
    frames: Subscriber,
    collisions: CollisionReader,
    processes: ProcessWatch,
    fold: Fold,
    /// When this slot of the history ends.
    slot_end: Instant,
    /// When to look whether there is an engine, unless a frame comes.
    next_look: Instant,
}

impl Reader {
    fn open(fleet: &FleetName) -> Result<Self> {
        let participant = Participant::join(fleet, NAME)?;
        Ok(Self {
            fleet: fleet.clone(),
            frames: Subscriber::open_on(&participant)?,
            collisions: CollisionReader::open_on(&participant)?,
            processes: ProcessWatch::start(fleet)?,
            fold: Fold::default(),
            slot_end: Instant::now() + SLOT,
            next_look: Instant::now(),
        })
    }

    /// Takes in a frame, if one comes in `time` or a [`NAP`].
    fn read(&mut self, time: Duration) -> Result {
        let frame = self.frames.wait(time.min(NAP))?;
        let now = wall_time_nanos();
        if let Some(frame) = frame {
            self.fold.frame(&frame, now);
            self.next_look = Instant::now() + SILENCE;
        } else if Instant::now() >= self.next_look {
            self.frames.forget_dead();
            self.fold.idle(self.frames.has_producer());
            self.next_look = Instant::now() + SILENCE;
        }
        self.frames.release();
        self.collisions.update(&mut self.fold, now);
        Ok(())
    }

    /// Brings the view up to date.
    fn show(&mut self, view: &mut View) {
        let collisions = self.collisions.collisions(self.fold.newest());
        let (processes, error) = match self.processes.newest() {
            Ok(processes) => (processes, None),
            Err(error) => (Vec::new(), Some(error)),
        };
        view.process_error = error;
        view.snapshot = self.fold.snapshot(self.fleet.clone(), collisions, processes, wall_time_nanos());
        if Instant::now() >= self.slot_end {
            view.history.add(&self.fold.lap(), &view.snapshot);
            // Behind, after this process was stopped: no empty slots.
            self.slot_end = (self.slot_end + SLOT).max(Instant::now());
        }
    }
}

/// Reads the keyboard.
struct Keys {
    steering: Steering,
    /// When the outcome of the last key makes room for the list of keys again.
    shown_until: Instant,
    ended: bool,
}

impl Keys {
    /// Carries out what was pressed, and takes in what came of it. Whether that changes the screen.
    fn read(&mut self, view: &mut View) -> Result<bool> {
        let mut touched = false;
        while event::poll(Duration::ZERO)? {
            touched = true;
            match event::read()? {
                Event::Key(key) if key.kind != KeyEventKind::Release => self.press(key, view),
                _ => {}
            }
        }
        if let Some(outcome) = self.steering.outcome() {
            view.outcome = Some(outcome);
            self.shown_until = Instant::now() + SHOWN;
            touched = true;
        } else if Instant::now() >= self.shown_until {
            view.outcome = None;
        }
        Ok(touched)
    }

    fn press(&mut self, key: KeyEvent, view: &mut View) {
        let control = key.modifiers.contains(KeyModifiers::CONTROL);
        let listed = view.snapshot.collisions.list.len();
        match key.code {
            KeyCode::Char('c') if control => self.ended = true,
            KeyCode::Esc if view.help => view.help = false,
            KeyCode::Char('q') | KeyCode::Esc => self.ended = true,
            KeyCode::Char('?' | 'h') => view.help = !view.help,
            KeyCode::Char(' ') => self.steering.ask(Command::PauseOrResume),
            KeyCode::Char('s') => self.steering.ask(Command::Step),
            KeyCode::Char('+' | '=') => self.steering.ask(Command::Faster),
            KeyCode::Char('-' | '_') => self.steering.ask(Command::Slower),
            KeyCode::Char('m') => self.steering.ask(Command::FullSpeed),
            KeyCode::Char('1') => self.steering.ask(Command::RealTime),
            KeyCode::Up | KeyCode::Char('k') => view.scroll_by(-1),
            KeyCode::Down | KeyCode::Char('j') => view.scroll_by(1),
            KeyCode::PageUp => view.scroll_by(-PAGE),
            KeyCode::PageDown => view.scroll_by(PAGE),
            KeyCode::Home => view.scroll = 0,
            KeyCode::End => view.scroll = listed,
            _ => {}
        }
    }
}
