//! The system's dialog that asks for a file to open. It answers on a thread of its own, so that the
//! window goes on meanwhile.

use std::ffi::OsStr;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

#[cfg(feature = "file-dialog")]
use super::opened::{PLANTS, RECORDING};

/// The time before which nobody answers a dialog: an empty answer within it means that the system
/// has none.
const FASTEST_ANSWER: Duration = Duration::from_millis(400);
/// Shown where no dialog opens.
const NO_DIALOG: &str = if cfg!(feature = "file-dialog") {
    "no file dialog answers: Linux needs xdg-desktop-portal or zenity; drop the file on the window, \
     or start `regatta run FILE` or `regatta viewer FILE.mcap`"
} else {
    "this program is built without the file dialog (feature file-dialog); drop the file on the \
     window, or start `regatta run FILE` or `regatta viewer FILE.mcap`"
};

/// The dialog, as far as it is open.
#[derive(Debug, Default)]
pub struct FileDialog(Option<Open>);

#[derive(Debug)]
struct Open {
    since: Instant,
    /// Whether the system has a program that could show it.
    is_provided: bool,
    answer: Receiver<Option<PathBuf>>,
}

impl FileDialog {
    /// Opens the dialog over a window, unless it is open.
    pub fn open(&mut self, window: &winit::window::Window) {
        if self.0.is_none() {
            let (since, is_provided) = (Instant::now(), is_provided());
            self.0 = Some(Open { since, is_provided, answer: ask(window) });
        }
    }

    /// Whether the dialog is open.
    pub fn is_open(&self) -> bool {
        self.0.is_some()
    }

    /// Returns the answer once: the chosen file, or a message for the user where no dialog opens.
    /// A cancelled dialog has none.
    pub fn answer(&mut self) -> Option<Result<PathBuf, &'static str>> {
        let Open { since, is_provided, answer } = self.0.as_ref()?;
        let chosen = match answer.try_recv() {
            Err(TryRecvError::Empty) => return None,
            Ok(chosen) => chosen,
            Err(TryRecvError::Disconnected) => None,
        };
        // On a busy machine, the lack of a dialog may take longer to find.
        let is_absent = !is_provided || since.elapsed() < FASTEST_ANSWER;
        let is_missing = chosen.is_none() && is_absent;
        self.0 = None;
        if is_missing { Some(Err(NO_DIALOG)) } else { chosen.map(Ok) }
    }
}

/// Whether the system has a program that could show the dialog.
fn is_provided() -> bool {
    if !cfg!(target_os = "linux") {
        return true;
    }
    let data = std::env::var_os("XDG_DATA_DIRS").filter(|folders| !folders.is_empty());
    let data = data.unwrap_or_else(|| "/usr/local/share:/usr/share".into());
    let path = std::env::var_os("PATH").unwrap_or_default();
    is_in(&data, "dbus-1/services/org.freedesktop.portal.Desktop.service") || is_in(&path, "zenity")
}

/// Whether one of some folders, which are separated as in `PATH`, has a file.
fn is_in(folders: &OsStr, file: &str) -> bool {
    std::env::split_paths(folders).any(|folder| folder.join(file).is_file())
}

/// Asks for a file. The channel ends without an answer where that is impossible.
#[cfg(feature = "file-dialog")]
fn ask(window: &winit::window::Window) -> Receiver<Option<PathBuf>> {
    let (sender, answer) = channel();
    let dialog = rfd::AsyncFileDialog::new()
        .set_parent(window)
        .set_title("Open a layout, a scenario or a recording")
        .add_filter("Layouts, scenarios, recordings", &[&PLANTS[..], &[RECORDING]].concat())
        .add_filter("All files", &["*"]);
    // Some systems open dialogs on the thread of the window alone; any thread may wait for them.
    let chosen = dialog.pick_file();
    let thread = std::thread::Builder::new().name("file dialog".to_owned());
    // Without a thread the sender is dropped, which ends the channel.
    let _ = thread.spawn(move || {
        let file = pollster::block_on(chosen).map(|file| file.path().to_owned());
        // The window may have closed.
        let _ = sender.send(file);
    });
    answer
}

#[cfg(not(feature = "file-dialog"))]
fn ask(_window: &winit::window::Window) -> Receiver<Option<PathBuf>> {
    channel().1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answered(
        age: Duration,
        is_provided: bool,
        chosen: Option<&str>,
    ) -> Option<Result<PathBuf, &'static str>> {
        let (sender, answer) = channel();
        let since = Instant::now().checked_sub(age).expect("the clock is older");
        let mut dialog = FileDialog(Some(Open { since, is_provided, answer }));
        assert_eq!(dialog.answer(), None, "it is open");
        sender.send(chosen.map(PathBuf::from)).expect("open");
        let answer = dialog.answer();
        assert!(!dialog.is_open() && dialog.answer().is_none());
        answer
    }

    #[test]
    fn an_answer_is_a_file_or_nothing_or_that_there_is_no_dialog() {
        let long = 2 * FASTEST_ANSWER;
        assert_eq!(answered(Duration::ZERO, true, Some("a.mcap")), Some(Ok("a.mcap".into())));
        assert_eq!(answered(long, true, None), None, "cancelled");
        assert_eq!(answered(long, false, None), Some(Err(NO_DIALOG)), "on a busy machine");
        assert_eq!(answered(Duration::ZERO, true, None), Some(Err(NO_DIALOG)));
        let open = Open { since: Instant::now(), is_provided: true, answer: channel().1 };
        let mut dialog = FileDialog(Some(open));
        assert_eq!(dialog.answer(), Some(Err(NO_DIALOG)), "nobody will answer");
    }
}
