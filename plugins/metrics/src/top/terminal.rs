//! The terminal: taken over whole, and given back however the program ends.

use std::io::{self, IsTerminal, Stdout};

use ratatui::Terminal;
use ratatui::backend::CrosstermBackend;
use ratatui::crossterm::cursor::Show;
use ratatui::crossterm::execute;
use regatta_plugin::{Error, Result};

/// What is drawn on.
pub type Screen = Terminal<CrosstermBackend<Stdout>>;

/// The terminal in raw mode, on its other screen. Dropping it gives the terminal back; a panic does so too.
pub struct Taken {
    /// To draw on.
    pub screen: Screen,
}

/// Makes sure that there is a terminal.
///
/// # Errors
/// If standard input and output are none.
pub fn check() -> Result {
    match io::stdin().is_terminal() && io::stdout().is_terminal() {
        true => Ok(()),
        false => Err(Error::new("`regatta top` needs a terminal to draw on; `regatta status` prints a line instead")),
    }
}

impl Taken {
    /// Takes the terminal over.
    ///
    /// # Errors
    /// If it can't be.
    pub fn take() -> Result<Self> {
        let screen = ratatui::try_init().map_err(|reason| {
            ratatui::restore();
            Error::new(format_args!("can't take over this terminal ({reason}); is TERM set to what it is?"))
        })?;
        Ok(Self { screen })
    }
}

impl Drop for Taken {
    fn drop(&mut self) {
        // After a panic it was given back already, before the message: again would put the cursor on top of that.
        // A terminal that was closed needs nothing back.
        if !std::thread::panicking() {
            let _ = ratatui::try_restore();
        }
        let _ = execute!(io::stdout(), Show);
    }
}
