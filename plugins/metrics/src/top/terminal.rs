//! The terminal: switched to full screen, and restored however the program ends.

use std::io::{self, IsTerminal, Stdout};

use ratatui::Terminal;
use ratatui::backend::CrosstermBackend;
use ratatui::crossterm::cursor::Show;
use ratatui::crossterm::execute;
use regatta_plugin::{Error, Result};

/// The terminal to draw on.
pub type Screen = Terminal<CrosstermBackend<Stdout>>;

/// A guard of the terminal in raw mode, on its alternate screen. Dropping it restores the terminal,
/// as does a panic.
pub struct TerminalGuard {
    /// The terminal to draw on.
    pub screen: Screen,
}

/// Checks that there is a terminal.
///
/// # Errors
/// Fails unless standard input and output are terminals.
pub fn check() -> Result {
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
    pub fn enter() -> Result<Self> {
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
