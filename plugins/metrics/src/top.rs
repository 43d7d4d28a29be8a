//! `regatta top`: shows a fleet live in a terminal, with keys to control it.

mod commands;
mod figures;
mod format;
mod graphs;
mod lists;
mod screen;
mod table;
mod theme;
mod view;
mod work;

use std::io::{self, IsTerminal, Stdout};
use std::time::{Duration, Instant};

use ratatui::Terminal;
use ratatui::backend::CrosstermBackend;
use ratatui::crossterm::cursor::Show;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use ratatui::crossterm::execute;
use regatta_plugin::{Error, FleetName, Participant, Result, Subscriber, Termination};

use crate::aggregator::wall_time_nanos;
use crate::fleet::{FleetReader, FleetState};
use crate::processes::ProcessMonitor;
use commands::{Command, CommandQueue};
use view::{SLOT, View};

/// The name under which this process joins its fleet.
const NAME: &str = "top";
/// The longest time between two drawings, unless a key is pressed.
const REDRAW: Duration = Duration::from_millis(100);
/// The longest sleep between two checks for a key.
const MAX_WAIT: Duration = Duration::from_millis(30);
/// The time without frames after which top checks whether there is an engine at all.
const LIVENESS_CHECK_DELAY: Duration = Duration::from_secs(1);
/// The time for which the outcome of a key is shown.
const OUTCOME_DURATION: Duration = Duration::from_secs(4);
/// The number of lines that Page Up and Page Down scroll.
const PAGE: isize = 10;

/// Shows a fleet until `q`, Esc, Ctrl-C or `SIGTERM`, or until its terminal is gone.
///
/// # Errors
/// Fails if there is no terminal, if shared memory can't be used, or if the fleet uses another
/// version of the contract.
pub fn run(fleet: &FleetName) -> Result {
    let termination = Termination::watch()?;
    check_terminal()?;
    let mut reader = Reader::open(fleet)?;
    let mut input = Input {
        commands: CommandQueue::start(fleet, NAME)?,
        shown_until: Instant::now(),
        ended: false,
    };
    let mut view = View::new(fleet);
    let mut terminal = TerminalGuard::enter()?;
    let mut next_drawing = Instant::now();
    while !termination.requested() && !input.ended && !is_hung_up() {
        let changed = input.read(&mut view)?;
        reader.read(next_drawing.saturating_duration_since(Instant::now()))?;
        if changed || Instant::now() >= next_drawing {
            reader.show(&mut view);
            terminal.screen.draw(|frame| screen::draw(frame, &mut view))?;
            next_drawing = Instant::now() + REDRAW;
        }
    }
    Ok(())
}

/// Whether the terminal is gone: its window was closed, or the connection to this host broke.
/// crossterm would look for keys for ever then, as it reads on at the end of its input.
#[cfg(unix)]
fn is_hung_up() -> bool {
    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    let stdin = io::stdin();
    let mut polled = [PollFd::new(&stdin, PollFlags::IN)];
    let is_known = poll(&mut polled, Some(&Timespec::default())).is_ok();
    let gone = PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL;
    is_known && polled[0].revents().intersects(gone)
}

#[cfg(not(unix))]
fn is_hung_up() -> bool {
    false
}

/// The reader of the fleet.
struct Reader {
    fleet: FleetName,
    frames: Subscriber,
    results: FleetReader,
    state: FleetState,
    /// Whether the newest frame belongs to the warm-up of a run.
    is_warm_up: bool,
    processes: ProcessMonitor,
    /// End of the current slot of the history.
    slot_end: Instant,
    /// Time of the next check for an engine, unless a frame arrives.
    next_check: Instant,
}

impl Reader {
    fn open(fleet: &FleetName) -> Result<Self> {
        let participant = Participant::join(fleet, NAME)?;
        Ok(Self {
            fleet: fleet.clone(),
            frames: Subscriber::open_on(&participant)?,
            results: FleetReader::open_on(&participant)?,
            state: FleetState::default(),
            is_warm_up: false,
            processes: ProcessMonitor::start(fleet)?,
            slot_end: Instant::now() + SLOT,
            next_check: Instant::now(),
        })
    }

    /// Reads a frame, if one arrives within `time` or [`MAX_WAIT`].
    fn read(&mut self, time: Duration) -> Result {
        let frame = self.frames.wait(time.min(MAX_WAIT))?;
        let now = wall_time_nanos();
        if let Some(frame) = frame {
            let was_warm_up = std::mem::replace(&mut self.is_warm_up, frame.header().is_warm_up());
            if was_warm_up && !self.is_warm_up {
                self.state = FleetState::default();
            }
            self.results.add_frame(&mut self.state, &frame, now);
            self.next_check = Instant::now() + LIVENESS_CHECK_DELAY;
        } else if Instant::now() >= self.next_check {
            self.frames.forget_dead();
            self.state.aggregator.note_idle(self.frames.has_producer());
            self.next_check = Instant::now() + LIVENESS_CHECK_DELAY;
        }
        self.frames.release();
        self.results.update(&mut self.state, now);
        Ok(())
    }

    /// Updates the view.
    fn show(&mut self, view: &mut View) {
        let (processes, error) = match self.processes.newest() {
            Ok(processes) => (processes, None),
            Err(error) => (Vec::new(), Some(error)),
        };
        view.process_error = error;
        view.snapshot = self.state.snapshot(&self.fleet, processes);
        if Instant::now() >= self.slot_end {
            let interval = self.state.aggregator.take_interval();
            if !self.is_warm_up {
                view.history.add(&interval, &view.snapshot);
            }
            // After this process was stopped, no empty slots are added.
            self.slot_end = (self.slot_end + SLOT).max(Instant::now());
        }
    }
}

/// The keyboard input.
struct Input {
    commands: CommandQueue,
    /// Time at which the list of keys replaces the outcome of the last key.
    shown_until: Instant,
    ended: bool,
}

impl Input {
    /// Handles pressed keys and outcomes of commands. Returns whether they change the screen.
    fn read(&mut self, view: &mut View) -> Result<bool> {
        let mut changed = false;
        while event::poll(Duration::ZERO)? {
            changed = true;
            if let Event::Key(key) = event::read()?
                && key.kind != KeyEventKind::Release
            {
                self.press(key, view);
            }
        }
        if let Some(outcome) = self.commands.outcome() {
            view.outcome = Some(outcome);
            self.shown_until = Instant::now() + OUTCOME_DURATION;
            changed = true;
        } else if Instant::now() >= self.shown_until {
            view.outcome = None;
        }
        Ok(changed)
    }

    fn press(&mut self, key: KeyEvent, view: &mut View) {
        let control = key.modifiers.contains(KeyModifiers::CONTROL);
        let listed = view.snapshot.collisions.list.len();
        match key.code {
            KeyCode::Char('c') if control => self.ended = true,
            // The end of the input of a pseudo-terminal arrives as Ctrl-D or Ctrl-Space.
            _ if control => {}
            KeyCode::Esc if view.help => view.help = false,
            KeyCode::Char('q') | KeyCode::Esc => self.ended = true,
            KeyCode::Char('?' | 'h') => view.help = !view.help,
            KeyCode::Char(' ') => self.commands.send(Command::PauseOrResume),
            KeyCode::Char('s') => self.commands.send(Command::Step),
            KeyCode::Char('+' | '=') => self.commands.send(Command::Faster),
            KeyCode::Char('-' | '_') => self.commands.send(Command::Slower),
            KeyCode::Char('m') => self.commands.send(Command::FullSpeed),
            KeyCode::Char('e') => view.shows_jams = !view.shows_jams,
            KeyCode::Char('1') => self.commands.send(Command::RealTime),
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

/// A guard of the terminal in raw mode, on its alternate screen. Dropping it restores the terminal,
/// as does a panic.
struct TerminalGuard {
    /// The terminal to draw on.
    screen: Terminal<CrosstermBackend<Stdout>>,
}

/// Checks that there is a terminal.
///
/// # Errors
/// Fails unless standard input and output are terminals.
fn check_terminal() -> Result {
    match io::stdin().is_terminal() && io::stdout().is_terminal() {
        true => Ok(()),
        false => Err(Error::new(
            "`regatta top` needs a terminal to draw on; `regatta status` prints a line instead",
        )),
    }
}

impl TerminalGuard {
    /// Switches the terminal to full screen.
    ///
    /// # Errors
    /// Fails if the terminal can't be switched.
    fn enter() -> Result<Self> {
        let screen = ratatui::try_init().map_err(|reason| {
            ratatui::restore();
            Error::new(format_args!(
                "can't switch this terminal to full screen ({reason}); check that TERM names its \
                 type"
            ))
        })?;
        Ok(Self { screen })
    }
}

impl Drop for TerminalGuard {
    fn drop(&mut self) {
        // After a panic, the terminal was already restored before the message: restoring it again
        // would move the cursor onto that. A closed terminal needs no restoring.
        if !std::thread::panicking() {
            let _ = ratatui::try_restore();
        }
        let _ = execute!(io::stdout(), Show);
    }
}
