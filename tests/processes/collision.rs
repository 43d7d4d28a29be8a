//! The collision plugin on a real engine, with two robots that touch at known times.

use std::fs;
use std::path::PathBuf;

use regatta_plugin::column::COLLISION;
use regatta_plugin::contact::{ContactChange, ContactEvent, ContactLevel};
use regatta_plugin::{ColumnReader, ContactEventReader, ContactReader, Participant, ReadError};
use rustix::process::Signal;
use tempfile::TempDir;

use crate::fleet::{Fleet, Process, eventually, regatta, unique};

/// Two robots, each 1 m long, drive towards each other at 1 m/s from both ends of a line of 20 m.
const GRAPH: &str = "
Vertices:
- {Id: 1, X: 0, Y: 0, Theta: 0}
- {Id: 2, X: 20, Y: 0, Theta: 0}
- {Id: 3, X: 20, Y: 0, Theta: 3.141592653589793}
- {Id: 4, X: 0, Y: 0, Theta: 3.141592653589793}
Edges:
- {Id: 10, Origin_ID: 1, Destination_ID: 2, CurveType: linear, VelocityForward: 1}
- {Id: 11, Origin_ID: 3, Destination_ID: 4, CurveType: linear, VelocityForward: 1}
";
const SCENARIO: &str = "graph: line.yaml
rate: 100
robot_types: [{name: cart, length: 1, width: 0.5}]
robots: [{route: [10]}, {route: [11]}]
viewer: off
";
/// The time at which the robots begin to touch: their centres are 1 m apart after (20 - 1) / 2 s.
const TOUCH_SECS: f64 = 9.5;
/// The time at which the robots have passed each other and stop touching.
const PART_SECS: f64 = 10.5;

fn scenario() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("line.yaml"), GRAPH).expect("written");
    let path = folder.path().join("meet.yaml");
    fs::write(&path, SCENARIO).expect("written");
    (folder, path)
}

/// Appends all new contact events.
fn append_events(reader: &mut ContactEventReader, events: &mut Vec<ContactEvent>) {
    reader
        .take(|tick| {
            events.extend_from_slice(tick.records);
            Ok::<_, ReadError>(())
        })
        .expect("readable");
}

fn time_of(events: &[ContactEvent], level: ContactLevel, change: ContactChange) -> Option<f64> {
    let matches =
        |event: &&ContactEvent| event.level == level as u32 && event.change == change as u32;
    events.iter().find(matches).map(|event| event.sim_time_nanos as f64 * 1e-9)
}

#[test]
fn a_contact_is_predicted_published_logged_and_summarised() {
    let (folder, path) = scenario();
    let (log, rotated) = (folder.path().join("contacts.csv"), folder.path().join("contacts.csv.1"));
    let path = path.to_string_lossy().into_owned();
    // The path is absolute, because the scenario is outside `graphs`.
    let fleet = Fleet::start("collision", &path, &["--speed", "0.001"]);
    let participant = Participant::join(&fleet.name, "test").expect("joined");
    let mut reader = ContactEventReader::open_on(&participant).expect("opened");
    let mut contacts = ContactReader::open_on(&participant).expect("opened");
    let mut column = ColumnReader::open_on(&participant, COLLISION.name()).expect("opened");
    let name = fleet.name.to_string();
    let args = [
        "plugin",
        "collision",
        "--fleet",
        &name,
        "--margin",
        "0.1",
        "--horizon",
        "2",
        "--summary",
        "--log",
    ];
    let plugin = Process::start(regatta().args(args).arg(&log));
    eventually("the first column", || column.latest().expect("readable").map(|_| ()));

    let mut events = Vec::new();
    let mut levels = Vec::new();
    fleet.control(&["pause"]);
    fleet.control(&["speed", "max"]);
    // Stepping lets the plugin see every tenth tick even on a busy machine.
    for step in 0..115 {
        if step == 60 {
            // Before the first event the log is rotated, as logrotate does.
            fs::rename(&log, &rotated).expect("moved");
            plugin.signal(Signal::HUP);
        }
        fleet.control(&["step", "10"]);
        let tick = fleet.tick();
        eventually("the column of that tick", || {
            let values =
                column.latest().expect("readable").filter(|values| values.header.tick == tick)?;
            levels.push(values.values[0]);
            Some(())
        });
        append_events(&mut reader, &mut events);
    }

    use ContactChange::{Began, Ended};
    use ContactLevel::{Possible, Touching};
    let near =
        |time: Option<f64>, expected: f64| time.is_some_and(|time| (time - expected).abs() <= 0.11);
    assert!(near(time_of(&events, Touching, Began), TOUCH_SECS), "{events:?}");
    assert!(near(time_of(&events, Touching, Ended), PART_SECS), "{events:?}");
    let predicted = time_of(&events, Possible, Began).expect("a prediction");
    let expected = TOUCH_SECS - 2.2..=TOUCH_SECS - 1.8;
    assert!(
        expected.contains(&predicted),
        "the horizon is 2 s, but the contact was predicted at {predicted} s"
    );
    assert_eq!(events.len(), 4, "each level begins and ends once: {events:?}");
    assert!(events.iter().all(|event| event.robots == [0, 1]));
    let touching = &events[1];
    assert!(
        (touching.x - 10.0).abs() < 0.2
            && touching.y.abs() < 0.3
            && (touching.relative_speed - 2.0).abs() < 0.01
    );
    let sequence: Vec<_> = levels.chunk_by(|a, b| a == b).map(|same| same[0]).collect();
    assert_eq!(
        sequence,
        [0.0, 1.0, 2.0, 1.0, 0.0],
        "clear, possible, touching, within the margin, clear"
    );
    let totals = eventually("totals", || {
        contacts.latest().expect("readable").map(|contacts| *contacts.header)
    });
    assert_eq!(
        (totals.touching_ever, totals.possible_ever, totals.touching, totals.capped),
        (1, 1, 0, 0)
    );

    let output = plugin.interrupt();
    let summary = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(
        summary.contains("1 contacts (0 touch now)") && summary.contains("robots 0 and 1"),
        "{summary}"
    );
    assert!(summary.contains("edge 10"), "{summary}");
    let text = fs::read_to_string(&log).expect("the log");
    assert_eq!(text.lines().count(), 5, "the log has a header and four events: {text}");
    assert!(
        text.lines().nth(2).is_some_and(|line| line.contains("began,touching,0,1,10,")),
        "{text}"
    );
    let rotated = fs::read_to_string(&rotated).expect("the rotated log");
    assert_eq!(
        rotated.lines().collect::<Vec<_>>(),
        text.lines().take(1).collect::<Vec<_>>(),
        "it has the header only"
    );
}

/// A robot comes from the west to a node from which one edge leads on to the east, to a robot that
/// stands there, and one to the north.
const FORK: &str = "
Vertices:
- {Id: 1, X: 0, Y: 0, Theta: 0}
- {Id: 2, X: 6, Y: 0, Theta: 0}
- {Id: 3, X: 7.5, Y: 0, Theta: 0}
- {Id: 4, X: 6, Y: 6, Theta: 1.5707963267948966}
Edges:
- {Id: 10, Origin_ID: 1, Destination_ID: 2, CurveType: linear, VelocityForward: 1}
- {Id: 11, Origin_ID: 2, Destination_ID: 3, CurveType: linear, VelocityForward: 1}
- {Id: 12, Origin_ID: 2, Destination_ID: 4, CurveType: linear, VelocityForward: 1}
";

/// Returns the contact events while a robot drives a route on the fork.
fn events_on_fork(name: &str, route: &str) -> Vec<ContactEvent> {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("line.yaml"), FORK).expect("written");
    let path = folder.path().join("fork.yaml");
    let scenario = SCENARIO
        .replace("[{route: [10]}, {route: [11]}]", &format!("[{{route: {route}}}, {{node: 3}}]"));
    fs::write(&path, scenario).expect("written");
    let fleet = Fleet::start(name, &path.to_string_lossy(), &["--speed", "0.001"]);
    let participant = Participant::join(&fleet.name, "test").expect("joined");
    let mut reader = ContactEventReader::open_on(&participant).expect("opened");
    let mut column = ColumnReader::open_on(&participant, COLLISION.name()).expect("opened");
    let args = ["plugin", "collision", "--margin", "0", "--fleet", &fleet.name.to_string()];
    let _plugin = Process::start(regatta().args(args));
    eventually("the first column", || column.latest().expect("readable").map(|_| ()));
    fleet.control(&["pause"]);
    fleet.control(&["speed", "max"]);
    let mut events = Vec::new();
    for _ in 0..80 {
        fleet.control(&["step", "10"]);
        let tick = fleet.tick();
        eventually("the column of that tick", || {
            column
                .latest()
                .expect("readable")
                .filter(|values| values.header.tick == tick)
                .map(|_| ())
        });
        append_events(&mut reader, &mut events);
    }
    events
}

#[test]
fn a_robot_whose_route_turns_away_is_not_predicted_to_hit_and_one_whose_route_turns_towards_is() {
    assert!(events_on_fork("collision-away", "[10, 12]").is_empty());
    let events = events_on_fork("collision-towards", "[10, 11]");
    let [possible, touching] = [ContactLevel::Possible, ContactLevel::Touching]
        .map(|level| time_of(&events, level, ContactChange::Began));
    // The robots are 1 m long, and the second one's centre is 7.5 m from the start.
    assert!(possible.is_some_and(|time| (4.4..4.7).contains(&time)), "{events:?}");
    assert!(touching.is_some_and(|time| (6.4..6.7).contains(&time)), "{events:?}");
}

#[test]
fn a_stopped_and_a_killed_checker_cost_no_late_tick_and_another_one_replaces_it() {
    let fleet = Fleet::start("collision-kill", "thirty.yaml", &["--rate", "50"]);
    let participant = Participant::join(&fleet.name, "test").expect("joined");
    let mut column = ColumnReader::open_on(&participant, COLLISION.name()).expect("opened");
    let mut next = || {
        eventually("a column", || {
            column.latest().expect("readable").map(|column| column.header.tick)
        })
    };
    let first = fleet.plugin("collision");
    next();
    let before = fleet.late_ticks();
    first.signal(Signal::STOP);
    fleet.let_ticks_pass(100);
    let second = fleet.plugin("collision").finish();
    let message = String::from_utf8_lossy(&second.stderr).into_owned();
    assert!(!second.status.success() && message.contains("already published"), "{message}");
    first.signal(Signal::KILL);
    drop(first);
    let third = fleet.plugin("collision");
    let tick = fleet.tick();
    eventually("a column of the new checker", || (next() > tick).then_some(()));
    let late = fleet.late_ticks() - before;
    assert!(third.interrupt().status.success());
    assert!(late * 5 < fleet.tick(), "{late} late ticks");
}

#[test]
fn the_checker_continues_with_the_next_engine_and_prints_a_summary_of_each_run() {
    let fleet = Fleet::start("collision-restart", "thirty.yaml", &[]);
    let name = fleet.name.clone();
    let plugin = Process::start(regatta().args([
        "plugin",
        "collision",
        "--summary",
        "--fleet",
        &name.to_string(),
    ]));
    let participant = Participant::join(&name, "test").expect("joined");
    let mut column = ColumnReader::open_on(&participant, COLLISION.name()).expect("opened");
    let mut run_other_than = |previous: u64| {
        eventually("a column of the run", || {
            let run = column.latest().expect("readable")?.header.run_id;
            (run != previous).then_some(run)
        })
    };
    let first = run_other_than(0);
    fleet.engine.signal(Signal::KILL);
    assert!(!fleet.engine.finish().status.success());
    let fleet = Fleet::restart(name, "thirty.yaml", &[]);
    run_other_than(first);
    assert!(fleet.engine.interrupt().status.success());
    let output = plugin.interrupt();
    let printed = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && printed.matches(" touch now)").count() == 2, "{printed}");
}

#[test]
fn a_scenario_starts_the_checker() {
    let (_folder, path) = scenario();
    let text = format!("{SCENARIO}plugins: [{{name: collision, args: [--summary]}}]\n");
    fs::write(&path, text).expect("written");
    let name = unique("collision-run").to_string();
    let output = regatta()
        .arg("run")
        .arg(path)
        .args(["--for", "3s", "--fleet", &name])
        .output()
        .expect("regatta starts");
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(printed.contains(" touch now)"), "{printed}");
}

#[test]
fn invalid_options_are_reported_in_one_line() {
    for args in [["--margin", "-1"], ["--horizon", "soon"], ["--log", "/no/such/folder/log.csv"]] {
        let output =
            regatta().args(["plugin", "collision"]).args(args).output().expect("regatta starts");
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && message.lines().count() == 1, "{args:?}: {message}");
    }
}
