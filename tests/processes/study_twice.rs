//! The same study twice: the same bytes in all files, but for the one with times.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::fleet::{graphs, regatta};

/// The file with the wall-clock times of runs.
const TIMES: &str = "times.csv";

/// Studies two numbers of robots, some runs side by side, into the folder `s` of another one.
fn study(folder: &Path) {
    let plant = graphs("thirty.yaml");
    let mut command = regatta();
    command.current_dir(folder).arg("study").arg(plant).args(["--output", "s"]);
    command.args(["--robots", "2,4", "--duration", "5min", "--seeds", "2..3", "--reliefs", "1"]);
    command.args(["--vary", "max_speed=1,0.5", "--jobs", "2"]);
    let output = command.output().expect("regatta starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// Returns the content of all files of a folder and of those in it, by their paths in it.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let name = path.strip_prefix(folder).expect("in the folder").display().to_string();
            files.insert(name, fs::read(path).expect("readable"));
        }
    }
    files
}

#[test]
fn the_same_study_gives_the_same_files() {
    let folders = [tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder")];
    let [first, second] = folders.each_ref().map(|folder| {
        study(folder.path());
        files(&folder.path().join("s"))
    });
    let names: Vec<&String> = first.keys().collect();
    assert_eq!(names, second.keys().collect::<Vec<_>>());
    let kinds = ["index.html", "study.json", "study.md", "study.sqlite", "throughput.png", TIMES];
    assert!(kinds.iter().all(|name| first.contains_key(*name)), "{names:?}");
    assert!(names.iter().filter(|name| name.starts_with("results")).count() >= 8, "{names:?}");
    for (name, bytes) in &first {
        let is_same = *bytes == second[name];
        assert!(is_same || name == TIMES, "{name} differs");
    }
}
