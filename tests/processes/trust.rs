//! The question whether a folder is trusted, and what strangers' texts do, in a pseudo-terminal.

use std::fs;
use std::path::{Path, PathBuf};

use pty_process::blocking::Command;
use tempfile::TempDir;

use crate::fleet::{Process, graphs, regatta, unique};
use crate::terminal::Terminal;

/// A folder of a stranger, with a program that leaves a marker, and the settings of the user.
struct Stranger {
    outside: TempDir,
}

impl Stranger {
    /// `folder` is the name of the stranger's folder.
    fn new(folder: &str) -> (Self, PathBuf) {
        let stranger = Self { outside: tempfile::tempdir().expect("a folder") };
        let folder = stranger.outside.path().join(folder);
        fs::create_dir(&folder).expect("a folder");
        let scenario = format!(
            "graph: {}\nviewer: off\nrobots: [{{routes: random}}]\n\
             plugins: [{{name: own, command: [sh, -c, 'touch {}']}}]\n",
            graphs("porto.yaml").display(),
            stranger.marker().display()
        );
        fs::write(folder.join("scenario.yaml"), scenario).expect("written");
        (stranger, folder.join("scenario.yaml"))
    }

    fn marker(&self) -> PathBuf {
        self.outside.path().join("marker")
    }

    fn list(&self) -> Option<String> {
        fs::read_to_string(self.outside.path().join("settings/regatta/trusted")).ok()
    }

    /// Runs the scenario for a moment in a terminal.
    fn run(&self, scenario: &Path) -> Terminal {
        let command = Command::new(env!("CARGO_BIN_EXE_regatta"))
            .arg("run")
            .arg(scenario)
            .args(["--for", "1s", "--fleet", unique("asked").as_str()])
            .env("XDG_CONFIG_HOME", self.outside.path().join("settings"))
            .env_remove("DISPLAY")
            .env_remove("WAYLAND_DISPLAY");
        Terminal::with(command, 200, 40)
    }
}

#[test]
fn a_terminal_is_asked_once_for_trust_and_yes_is_remembered() {
    let (stranger, scenario) = Stranger::new("plant");
    for answer in ["\r", "n\r", "maybe\r", "\u{4}"] {
        let terminal = stranger.run(&scenario);
        terminal.shows("wants to start 'sh -c touch");
        terminal.shows("Do you trust the files in");
        terminal.press(answer);
        assert!(!terminal.finish().success(), "{answer:?}");
        assert!(!stranger.marker().exists() && stranger.list().is_none(), "{answer:?}");
    }
    let terminal = stranger.run(&scenario);
    terminal.shows("[y/N]");
    terminal.press("y\r");
    terminal.finish();
    fs::remove_file(stranger.marker()).expect("the program ran");
    let folder = scenario.parent().and_then(|folder| folder.canonicalize().ok()).expect("there");
    assert_eq!(stranger.list(), Some(format!("{}\n", folder.display())));
    let again = stranger.run(&scenario);
    again.finish();
    assert!(stranger.marker().exists(), "it is asked no more");
}

#[test]
fn the_name_of_a_folder_does_not_change_the_question() {
    let (stranger, scenario) = Stranger::new("x\u{1b}[2J\u{1b}[H\u{202e}harmless");
    let terminal = stranger.run(&scenario);
    terminal.shows("x\\u{1b}[2J\\u{1b}[H\\u{202e}harmless? [y/N]");
    terminal.shows("wants to start 'sh -c touch");
    terminal.press("n\r");
    assert!(!terminal.finish().success());
}

/// Asserts that a command on a file prints no character that controls a terminal.
fn assert_plain(command: &[&str], path: &Path) {
    let output = Process::start(regatta().args(command).arg(path)).finish();
    let printed = String::from_utf8([output.stdout, output.stderr].concat()).expect("a text");
    let is_plain = printed.chars().all(|it| !it.is_control() || it == '\n');
    assert!(is_plain && !printed.contains('\u{202e}'), "{command:?}: {printed:?}");
    assert!(printed.contains("\\u{1b}"), "{command:?} tells nothing of it: {printed:?}");
}

#[test]
fn nothing_in_a_file_controls_the_terminal() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("plant.yaml");
    let evil = "\"\\e[31mred\\e]0;title\\a\\r\\u202e\"";
    for scenario in [
        format!("graph: {evil}\nrobots: [{{routes: random}}]\n"),
        format!("graph: x\n{evil}: 1\nrobots: [{{routes: random}}]\n"),
        format!("graph: x\nrobots: [{{routes: {evil}}}]\n"),
    ] {
        fs::write(&path, &scenario).expect("written");
        assert_plain(&["graph", "check"], &path);
        assert_plain(&["run"], &path);
    }
    fs::write(&path, format!("plant: x\n{evil}: 1\n")).expect("written");
    assert_plain(&["study"], &path);
    let square = fs::read_to_string(graphs("square.yaml")).expect("a layout");
    fs::write(&path, square.replacen("Linear", evil, 1)).expect("written");
    assert_plain(&["graph", "check"], &path);
    fs::write(&path, format!("orders: [{{{evil}: 1}}]\n")).expect("written");
    assert_plain(&["orders", "import"], &path);
}
