//! The alarms of the viewer's log are those that hold, also in a window that opens later and after
//! jumps in a recording.

use std::collections::BTreeMap;
use std::time::Duration;

use regatta_plugin::{Control, FleetName, Participant, WorldReader};
use regatta_viewer::interface::log::{AlarmKey, FleetLog};
use regatta_viewer::log::LogCollector;

use crate::fleet::{Fleet, Process, eventually, regatta, unique};
use crate::record::{file, recorder};

/// The log of a window.
struct Window {
    collector: LogCollector,
    log: FleetLog,
    _participant: Participant,
}

impl Window {
    fn open(fleet: &FleetName) -> Self {
        let participant = Participant::join(fleet, "window").expect("joined");
        Self {
            collector: LogCollector::open(&participant).expect("a log"),
            log: FleetLog::default(),
            _participant: participant,
        }
    }

    /// Returns the texts of the alarms that hold now.
    fn alarms(&mut self) -> BTreeMap<AlarmKey, String> {
        self.log.take(self.collector.poll().expect("readable"));
        let alarms = self.log.alarms().into_iter().filter(|(_, alarm)| alarm.is_active);
        alarms.map(|(key, alarm)| (key, alarm.entry.text.clone())).collect()
    }

    /// Waits until these are the alarms that hold, and returns their texts.
    fn await_alarms(&mut self, wanted: &[AlarmKey]) -> Vec<String> {
        eventually(&format!("the alarms {wanted:?}"), || {
            let alarms = self.alarms();
            alarms.keys().eq(wanted).then(|| alarms.into_values().collect())
        })
    }
}

fn command(fleet: &FleetName, arguments: &[&str]) {
    let output = regatta()
        .arg("command")
        .args(arguments)
        .args(["--fleet", &fleet.to_string()])
        .output()
        .expect("it starts");
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
}

fn first_edge(fleet: &FleetName) -> u32 {
    let mut worlds = WorldReader::open(fleet).expect("a reader");
    eventually("a world", || Some(worlds.latest().expect("readable")?.edges().first()?.id))
}

#[test]
fn a_window_that_opens_late_has_the_alarms_that_hold() {
    let fleet = Fleet::start("late-alarms", "thirty.yaml", &[]);
    let edge = first_edge(&fleet.name);
    let both = [AlarmKey::Robot(7), AlarmKey::Edge(edge)];
    let mut early = Window::open(&fleet.name);
    eventually("a frame", || (early.alarms().is_empty() && fleet.tick() > 0).then_some(()));
    command(&fleet.name, &["break", "7"]);
    command(&fleet.name, &["close", &edge.to_string()]);
    assert_eq!(
        early.await_alarms(&both),
        ["robot 7 broke down".to_owned(), format!("edge {edge} closed")]
    );
    fleet.let_ticks_pass(20);
    let mut late = Window::open(&fleet.name);
    let since = "since before this window opened";
    assert_eq!(
        late.await_alarms(&both),
        [format!("robot 7 is broken, {since}"), format!("edge {edge} is closed, {since}")]
    );
    assert_eq!(
        (early.log.entries().len(), late.log.entries().len()),
        (2, 2),
        "nothing is told twice"
    );
    command(&fleet.name, &["repair", "7"]);
    command(&fleet.name, &["open", &edge.to_string()]);
    for window in [&mut early, &mut late] {
        window.await_alarms(&[]);
        assert_eq!(window.log.entries().len(), 4, "{:?}", window.log.entries());
    }
    assert!(fleet.engine.interrupt().status.success());
}

#[test]
fn after_jumps_in_a_recording_the_alarms_are_those_of_the_shown_time() {
    let folder = tempfile::TempDir::new().expect("a folder");
    let fleet = Fleet::start("recorded-alarms", "thirty.yaml", &["--speed", "5"]);
    let recorder = recorder(&fleet.name, &file(&folder), &[]);
    let edge = first_edge(&fleet.name);
    let now =
        || Duration::from_secs_f64(fleet.status()["sim_time_secs"].as_f64().expect("seconds"));
    let after_ticks = || {
        fleet.let_ticks_pass(100);
        let time = now();
        fleet.let_ticks_pass(100);
        time
    };
    let before = after_ticks();
    command(&fleet.name, &["break", "7"]);
    command(&fleet.name, &["close", &edge.to_string()]);
    let during = after_ticks();
    command(&fleet.name, &["repair", "7"]);
    let after = after_ticks();
    assert!(recorder.interrupt().status.success() && fleet.engine.interrupt().status.success());

    let name = unique("replayed-alarms");
    let mut command = regatta();
    let replay =
        command.arg("replay").arg(file(&folder)).args(["--paused", "--fleet", &name.to_string()]);
    let replay = Process::start(replay);
    let mut control = eventually("control", || Control::open(&name).ok());
    eventually("the replay answers", || control.status().ok());
    control.seek(during).expect("gone there");
    let mut window = Window::open(&name);
    let [robot, edge] = [AlarmKey::Robot(7), AlarmKey::Edge(edge)];
    let texts = window.await_alarms(&[robot, edge]);
    // The frame may be there before the window knows that it is of a recording.
    assert!(texts[0].starts_with("robot 7 is broken, since before "), "{texts:?}");
    for (time, wanted) in [
        (after, &[edge][..]),
        (before, &[]),
        (during, &[robot, edge]),
        (before, &[]),
        (after, &[edge]),
    ] {
        control.seek(time).expect("gone there");
        window.await_alarms(wanted);
    }
    assert_eq!(window.log.alarms().len(), 1, "what is over needs no acknowledgement");
    assert!(replay.interrupt().status.success());
}
