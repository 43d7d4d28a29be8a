use rusqlite::Connection;

use super::database::DATABASE;
use super::*;
use crate::job::{Ending, Manager};

fn job() -> Job {
    let scenario = serde_json::json!({
        "graph": layout_name("Edges: []\n"), "rate": 10, "seed": 1,
        "robots": [{"count": 3, "routes": "none"}],
    });
    let scenario = serde_json::from_value(scenario).expect("a scenario");
    let manager = Manager::BuiltIn(Vec::new());
    let (program, ending) = ("0.1.0".to_owned(), Ending::AtTime);
    Job { program, scenario, secs: 600, rate_hz: 10, ending, manager }
}

fn outcome(id: &JobId) -> Outcome {
    Outcome {
        job: id.clone(),
        digest: "0".repeat(32),
        figures: regatta_meter::Figures { secs: 600.0, period_secs: 10.0, ..Default::default() },
        findings: BTreeMap::new(),
        examples: BTreeMap::new(),
        stalls: Vec::new(),
        edges: vec![EdgeOutcome { waiting_secs: 2.5, ..EdgeOutcome::new(7) }],
        ending: Ending::AtTime,
    }
}

const LABEL: Label<'_> = Label { variant: "", robots: 3, seed: 1, command: "" };

/// A store whose run has a result.
fn store(folder: &Path, key: &Key) -> (Store, JobId) {
    let store = Store::open(folder, key.clone(), Accepted::Sealed).expect("a store");
    let id = job().id();
    let text = serde_json::to_string(&outcome(&id)).expect("JSON");
    fs::write(store.result_file(&id), text).expect("written");
    store.take_result(&id, &LABEL).expect("a database").expect("a result");
    (store, id)
}

#[test]
fn a_result_of_a_worker_is_sealed_and_found_again() {
    let (folder, key) = (tempfile::tempdir().expect("a folder"), Key::random().expect("a key"));
    let (store, id) = store(folder.path(), &key);
    drop(store);
    let again = Store::open(folder.path(), key, Accepted::Sealed).expect("a store");
    let measured = again.finished(&id, &LABEL).expect("a database").expect("a result");
    assert_eq!(measured, outcome(&id).measured());
    assert_eq!(again.edges(std::slice::from_ref(&id)), outcome(&id).edges);
    again.settle().expect("written");
    let database = Connection::open(folder.path().join(DATABASE)).expect("a database");
    let rows: i64 =
        database.query_row("SELECT count(*) FROM runs", [], |row| row.get(0)).expect("a count");
    assert_eq!((rows, again.take_doubts()), (1, Vec::new()));
}

#[test]
fn a_result_that_was_changed_is_told_and_removed() {
    let key = Key::random().expect("a key");
    type Change = fn(&str) -> String;
    let changes: [(Change, &str); 6] = [
        (|text| text.replace("2.5", "2.6"), "it was changed"),
        (|_| String::new(), "it was changed"),
        (|text| text[..text.len() / 2].to_owned(), "it was changed"),
        (|text| text.replace("}\n", "}"), "it was changed"),
        (|_| "\u{0}".repeat(100), "it was changed"),
        // Somebody else's own, with a seal.
        (|text| Key::random().expect("a key").sealed(text), "made by another user"),
    ];
    for (change, reason) in changes {
        let folder = tempfile::tempdir().expect("a folder");
        let (store, id) = store(folder.path(), &key);
        let path = store.result_file(&id);
        let text = fs::read_to_string(&path).expect("a result");
        fs::write(&path, change(&text)).expect("written");
        assert_eq!(store.finished(&id, &LABEL).expect("a database"), None);
        let doubts = store.take_doubts();
        assert!(doubts.len() == 1 && doubts[0].contains(reason), "{doubts:?}");
        assert!(doubts[0].contains(id.as_str()) && doubts[0].ends_with("is done again"));
        assert!(!path.exists(), "it is removed");
        assert_eq!(store.finished(&id, &LABEL).expect("a database"), None);
        assert!(store.take_doubts().is_empty(), "a run that isn't done is no doubt");
    }
}

#[test]
fn a_result_of_another_job_is_told() {
    let (folder, key) = (tempfile::tempdir().expect("a folder"), Key::random().expect("a key"));
    let (store, id) = store(folder.path(), &key);
    let other = Job { secs: 601, ..job() }.id();
    fs::copy(store.result_file(&id), store.result_file(&other)).expect("copied");
    assert_eq!(store.finished(&other, &LABEL).expect("a database"), None);
    assert!(store.take_doubts()[0].contains("the result of another job"));
}

#[test]
fn results_of_others_are_accepted_on_request_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let (store, id) = store(folder.path(), &Key::random().expect("a key"));
    drop(store);
    let key = Key::random().expect("a key");
    let store = Store::open(folder.path(), key.clone(), Accepted::Any).expect("a store");
    assert!(store.finished(&id, &LABEL).expect("a database").is_some());
    drop(store);
    let store = Store::open(folder.path(), key, Accepted::Sealed).expect("a store");
    assert!(store.finished(&id, &LABEL).expect("a database").is_some(), "sealed since then");
}

#[test]
fn jobs_and_layouts_that_were_changed_are_written_anew() {
    let (folder, key) = (tempfile::tempdir().expect("a folder"), Key::random().expect("a key"));
    let store = Store::open(folder.path(), key, Accepted::Sealed).expect("a store");
    let (job, layout) = (job(), "Edges: []\n");
    let name = store.keep_layout(layout).expect("kept");
    store.keep_job(&job).expect("kept");
    assert!(store.take_doubts().is_empty());
    let (layout_file, job_file) = (store.files().join(name), store.job_file(&job.id()));
    fs::write(&layout_file, "Edges: [1]\n").expect("written");
    fs::write(&job_file, "").expect("written");
    store.keep_layout(layout).expect("kept");
    store.keep_job(&job).expect("kept");
    assert_eq!(fs::read_to_string(layout_file).expect("a layout"), layout);
    assert_eq!(Job::read(&job_file).expect("a job"), job);
    let doubts = store.take_doubts();
    assert!(doubts.len() == 2 && doubts.iter().all(|doubt| doubt.contains("written again")));
}

#[cfg(unix)]
#[test]
fn nothing_is_written_through_links() {
    use std::os::unix::fs::symlink;
    let (outside, key) = (tempfile::tempdir().expect("a folder"), Key::random().expect("a key"));
    let precious = outside.path().join("precious");
    fs::write(&precious, "text").expect("written");
    for name in ["jobs", RESULTS, "files"] {
        let folder = tempfile::tempdir().expect("a folder");
        symlink(outside.path(), folder.path().join(name)).expect("a link");
        let error = Store::open(folder.path(), key.clone(), Accepted::Sealed).expect_err("a link");
        assert!(error.to_string().contains("a link"), "{error}");
    }
    let folder = tempfile::tempdir().expect("a folder");
    symlink(&precious, folder.path().join(DATABASE)).expect("a link");
    let store = Store::open(folder.path(), key, Accepted::Sealed).expect("a store");
    symlink(&precious, store.job_file(&job().id())).expect("a link");
    store.keep_job(&job()).expect("kept");
    assert_eq!(fs::read_to_string(&precious).expect("a text"), "text");
}
