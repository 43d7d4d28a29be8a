//! The end of a run: children that save their work are waited for, others are killed.

use std::fs;
use std::path::Path;

use tempfile::TempDir;

use crate::fleet::{Process, graphs, regatta, unique};

/// Needs 7 s to save its work, and says that it goes on.
const SAVER: &str = "
save() {
    for second in 1 2 3 4 5 6 7; do
        sleep 1
        printf . >> \"$REGATTA_FINISHING\"
    done
    touch saved
    exit
}
trap save TERM
while :; do sleep 0.1; done
";
/// Says nothing.
const DEAF: &str = "
trap '' TERM
while :; do sleep 0.1; done
";
/// Says once that it saves its work, and then hangs.
const HANGING: &str = "
trap 'printf . >> \"$REGATTA_FINISHING\"' TERM
while :; do sleep 0.1; done
";

/// Writes a scenario that starts these scripts as plugins.
fn scenario(folder: &Path, scripts: &[(&str, &str)]) {
    let mut text = format!("graph: {}\nviewer: off\n", graphs("porto.yaml").display());
    text += "robots: [{routes: random}]\nplugins:\n";
    for (name, script) in scripts {
        fs::write(folder.join(name), script).expect("written");
        text += &format!("- {{name: {name}, command: [sh, {name}]}}\n");
    }
    fs::write(folder.join("scenario.yaml"), text).expect("written");
}

#[test]
fn a_child_that_saves_its_work_is_waited_for_and_one_that_hangs_is_killed() {
    let folder = TempDir::new().expect("a folder");
    scenario(folder.path(), &[("saver", SAVER), ("deaf", DEAF), ("hanging", HANGING)]);
    let mut command = regatta();
    command.args(["run", "scenario.yaml", "--trust", "--for", "2s", "--fleet"]);
    command.arg(unique("ending").as_str()).current_dir(folder.path());
    let output = Process::start(&mut command).finish();
    let messages = String::from_utf8_lossy(&output.stderr);
    assert!(folder.path().join("saved").exists(), "{messages}");
    for message in [
        "saver is still saving its work; another Ctrl-C kills it",
        "deaf did not end within 5 s and was killed",
        "hanging made no progress for 5 s at its end and was killed",
    ] {
        assert!(messages.contains(message), "{messages}");
    }
    assert!(!output.status.success() && !messages.contains("saver made"), "{messages}");
}
