//! A replay is a producer like the engine.

use std::path::Path;

use regatta_kit::Spots;
use regatta_plugin::column::{COLLISION, TYPE};
use regatta_plugin::command::CommandKind;
use regatta_plugin::contact::ContactRecord;
use regatta_plugin::event::EventKind;
use regatta_plugin::frame::ClockState;
use regatta_plugin::recording::MarkKind;
use regatta_plugin::{
    ColumnReader, CommandLogReader, Commands, ContactReader, Control, ControlError, EventReader,
    FleetName, HistoryReader, Participant, ReadError, RecordingReader, Subscriber, TrafficReader,
    WorldReader,
};
use regatta_record::{ReadingError, Recording, Topic};
use tempfile::TempDir;

use crate::fleet::{Fleet, Process, TIMEOUT, eventually, graphs, regatta, unique};
use crate::record::{digest, file, record, record_contacts, recorder};

fn start(fleet: &FleetName, recording: &Path, args: &[&str]) -> Process {
    Process::start(
        regatta().arg("replay").arg(recording).args(["--fleet", &fleet.to_string()]).args(args),
    )
}

/// A replay that stands at its start, and what controls it.
fn paused(test: &str, recording: &Path, args: &[&str]) -> (FleetName, Process, Control) {
    let fleet = unique(test);
    let process = start(&fleet, recording, &[&["--paused"], args].concat());
    let mut control = eventually("control", || Control::open(&fleet).ok());
    eventually("the replay answers", || control.status().ok());
    (fleet, process, control)
}

#[test]
fn a_recording_of_a_replay_is_the_recording() {
    let (first, second) = (TempDir::new().expect("a folder"), TempDir::new().expect("a folder"));
    let golden = record("replay-source", "warehouse-1000.yaml", 200, &file(&first), &[]);
    let fleet = unique("replay-copy");
    let replay = start(&fleet, &file(&first), &["--speed", "max", "--lockstep", "recorder"]);
    let recorder = recorder(&fleet, &file(&second), &[]);
    let output = replay.finish();
    assert!(output.status.success(), "it ends by itself: {output:?}");
    assert!(recorder.interrupt().status.success());
    assert_eq!(digest(&file(&second)), golden);
    assert_eq!(headers(&file(&first)), headers(&file(&second)));
}

/// Messages by topic.
fn counts(recording: &Path) -> Vec<(String, u64)> {
    let recording = Recording::open(recording).expect("a recording");
    recording.topics().iter().map(|topic| (topic.name(), recording.count(topic))).collect()
}

#[test]
fn in_lockstep_all_that_a_plugin_publishes_is_recorded_again_and_again() {
    let (first, second) = (TempDir::new().expect("a folder"), TempDir::new().expect("a folder"));
    let fleet = unique("replay-all-source");
    let lockstep = ["--lockstep", "recorder", "collision", "--speed", "max", "--ticks", "150"];
    let mut command = regatta();
    command.arg("engine").arg(graphs("warehouse-1000.yaml")).args([
        "--robots",
        "300",
        "--fleet",
        &fleet.to_string(),
    ]);
    let engine = Process::start(command.args(lockstep));
    let collision =
        Process::start(regatta().args(["plugin", "collision", "--fleet", &fleet.to_string()]));
    let first_recorder = recorder(&fleet, &file(&first), &["--poses-rate", "0"]);
    assert!(engine.finish().status.success());
    for process in [collision, first_recorder] {
        assert!(process.interrupt().status.success());
    }
    let recorded = counts(&file(&first));
    let lists = recorded
        .iter()
        .filter(|(topic, _)| ["/contacts", "/contact_updates"].contains(&topic.as_str()));
    assert_eq!(lists.map(|(_, count)| count).sum::<u64>(), 151, "one list a tick: {recorded:?}");
    assert!(
        recorded.contains(&("/columns/collision".to_owned(), 151)),
        "one column a tick: {recorded:?}"
    );

    let fleet = unique("replay-all");
    let replay = start(&fleet, &file(&first), &["--speed", "max", "--lockstep", "recorder"]);
    let second_recorder = recorder(&fleet, &file(&second), &["--poses-rate", "0"]);
    assert!(replay.finish().status.success());
    let output = second_recorder.interrupt();
    let report = String::from_utf8_lossy(&output.stderr).into_owned();
    let frames = |counts: &[(String, u64)]| {
        counts.iter().filter(|(topic, _)| topic != "/frames").cloned().collect()
    };
    let (recorded, again): (Vec<_>, Vec<_>) = (frames(&recorded), frames(&counts(&file(&second))));
    assert_eq!(again, recorded, "{report}");
    assert!(
        report.contains("no frame lost") && !report.contains("other messages lost"),
        "{report}"
    );
}

/// The fields of each tick's header that a replay keeps.
fn headers(recording: &Path) -> Vec<[u64; 5]> {
    let mut headers = Vec::new();
    let read = Recording::open(recording).expect("a recording").frames(|_, frame| {
        let header = frame.header();
        headers.push([
            header.tick,
            header.sim_time_nanos,
            header.tick_period_nanos,
            header.late_ticks,
            u64::from(header.robots),
        ]);
        Ok::<_, ReadingError>(())
    });
    read.expect("readable");
    headers.dedup();
    headers
}

#[test]
fn a_replay_pauses_steps_and_seeks() {
    let folder = TempDir::new().expect("a folder");
    record("replay-control-source", "thirty.yaml", 400, &file(&folder), &[]);
    let (fleet, process, mut control) =
        paused("replay-control", &file(&folder), &["--from", "500ms"]);
    let mut frames = Subscriber::open(&fleet).expect("opened");
    let start = std::time::Instant::now();
    assert_eq!(control.step(7).expect("stepped").tick, 57);
    assert!(
        start.elapsed() >= std::time::Duration::from_millis(55),
        "at the wanted speed: {:?}",
        start.elapsed()
    );

    let before = control.status().expect("answered").run_id;
    let ahead = control.seek(std::time::Duration::from_secs(3)).expect("gone there");
    assert_eq!((ahead.tick, ahead.sim_time_nanos, ahead.run_id), (300, 3_000_000_000, before));
    let back = control.seek(std::time::Duration::from_millis(1_005)).expect("gone there");
    assert_eq!(back.tick, 100, "the newest frame until then");
    assert_ne!(back.run_id, before, "going back is another run");

    let mut recorded = None;
    let read = Recording::open(&file(&folder)).expect("a recording").frames(|_, frame| {
        recorded = recorded.take().or((frame.tick() == 100).then(|| frame.x().to_vec()));
        Ok::<_, ReadingError>(())
    });
    read.expect("readable");
    let shown = eventually("the frame", || {
        let frame = frames.latest().expect("readable")?;
        assert_eq!(frame.header().clock, ClockState::Paused as u32);
        (frame.tick() == 100).then(|| frame.x().to_vec())
    });
    assert_eq!(Some(shown), recorded);

    let mut worlds = WorldReader::open(&fleet).expect("opened");
    let world =
        eventually("the world", || worlds.latest().expect("readable").map(|world| world.run_id()));
    assert_eq!(world, back.run_id, "the world belongs to the new run");

    let refused = control.seek(std::time::Duration::from_secs(100));
    assert!(
        matches!(&refused, Err(ControlError::Refused { reason, .. }) if reason.contains("4.000 s")),
        "{refused:?}"
    );
    assert!(matches!(control.robots(5), Err(ControlError::Refused { .. })));

    control.speed(f32::INFINITY).expect("changed");
    control.resume().expect("resumed");
    assert!(process.finish().status.success(), "it ends by itself");
}

#[test]
fn a_replay_that_loops_begins_a_run_each_time() {
    let folder = TempDir::new().expect("a folder");
    record("replay-loop-source", "thirty.yaml", 50, &file(&folder), &[]);
    let fleet = unique("replay-loop");
    let process = start(&fleet, &file(&folder), &["--loop"]);
    let mut frames = eventually("frames", || Subscriber::open(&fleet).ok());
    let mut runs = std::collections::BTreeSet::new();
    while runs.len() < 3 {
        runs.extend(frames.wait(TIMEOUT).expect("readable").map(|frame| frame.run_id()));
    }
    assert!(process.interrupt().status.success());
}

#[test]
fn a_replay_that_holds_stays_at_its_end() {
    let folder = TempDir::new().expect("a folder");
    record("replay-hold-source", "thirty.yaml", 50, &file(&folder), &[]);
    let (_, process, mut control) =
        paused("replay-hold", &file(&folder), &["--hold", "--speed", "max"]);
    control.resume().expect("resumed");
    let status = eventually("the end", || control.status().ok().filter(|status| status.tick == 50));
    assert!([ClockState::Paused as u32, ClockState::Running as u32].contains(&status.clock));
    assert_eq!(control.seek(std::time::Duration::from_millis(200)).expect("gone there").tick, 20);
    assert!(process.interrupt().status.success());
}

#[test]
fn commands_events_and_columns_are_replayed() {
    let folder = TempDir::new().expect("a folder");
    let engine = Fleet::start("replay-commands-source", "thirty.yaml", &[]);
    let recorder = recorder(&engine.name, &file(&folder), &[]);
    engine.let_ticks_pass(50);
    let mut commands = Commands::open(&engine.name).expect("opened");
    let token = commands.hold(3);
    commands.send().expect("sent");
    engine.let_ticks_pass(200);
    assert!(recorder.interrupt().status.success());

    let (fleet, _process, mut control) = paused("replay-commands", &file(&folder), &[]);
    let participant = Participant::join(&fleet, "test").expect("joined");
    let mut log = CommandLogReader::open_on(&participant).expect("opened");
    let mut events = EventReader::open_on(&participant).expect("opened");
    let mut column = ColumnReader::open_on(&participant, TYPE.name()).expect("opened");
    control.resume().expect("resumed");
    let (mut held, mut accepted) = (None, None);
    eventually("the command and its answer", || {
        let taken = log.take(|log| -> Result<(), ReadError> {
            held = held.or(log
                .records
                .iter()
                .find(|command| command.token == token)
                .map(|command| (command.kind, command.robot)));
            Ok(())
        });
        taken.expect("readable");
        let taken = events.take(|events| -> Result<(), ReadError> {
            accepted = accepted.or(events
                .records
                .iter()
                .find(|event| event.token == token)
                .map(|event| event.kind));
            Ok(())
        });
        taken.expect("readable");
        held.zip(accepted)
    });
    assert_eq!(
        (held, accepted),
        (Some((CommandKind::Hold as u32, 3)), Some(EventKind::Accepted as u32))
    );
    let types = eventually("the column type", || {
        column.latest().expect("readable").map(|column| column.values.len())
    });
    assert_eq!(types, 30);
}

#[test]
fn contacts_are_replayed_unless_a_live_plugin_has_their_name() {
    let folder = TempDir::new().expect("a folder");
    let engine = Fleet::start("replay-contacts-source", "thirty.yaml", &[]);
    let collision = engine.plugin("collision");
    let recorder = recorder(&engine.name, &file(&folder), &[]);
    let column = Topic::Column("collision".parse().expect("a name"));
    engine.let_ticks_pass(300);
    assert!(recorder.interrupt().status.success() && collision.interrupt().status.success());
    let recording = Recording::open(&file(&folder)).expect("a recording");
    assert!(
        recording.count(&column) > 0 && recording.count(&Topic::Contacts) > 0,
        "{:?}",
        recording.topics()
    );

    let (fleet, process, _control) = paused("replay-contacts", &file(&folder), &["--from", "2s"]);
    let participant = Participant::join(&fleet, "test").expect("joined");
    let mut contacts = ContactReader::open_on(&participant).expect("opened");
    let tick = eventually("contacts", || {
        contacts.latest().expect("readable").map(|contacts| contacts.header.tick)
    });
    assert!(tick <= 200, "those of the frame that is shown, or the last before: {tick}");
    assert!(process.interrupt().status.success());

    // Here somebody works them out anew.
    let fleet = unique("replay-contacts-live");
    let collision =
        Process::start(regatta().args(["plugin", "collision", "--fleet", &fleet.to_string()]));
    let waiting = Participant::join(&fleet, "test").expect("joined");
    let live = ContactReader::open_on(&waiting).expect("opened");
    eventually("the plugin", || live.has_publisher().then_some(()));
    let output = start(&fleet, &file(&folder), &["--speed", "max"]).finish();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && message.contains("contacts are left out"), "{message}");
    assert!(collision.interrupt().status.success());
}

#[test]
fn a_live_fleet_keeps_its_name_from_a_replay() {
    let folder = TempDir::new().expect("a folder");
    record("replay-taken-source", "thirty.yaml", 10, &file(&folder), &[]);
    let engine = Fleet::start("replay-taken", "thirty.yaml", &[]);
    let output = start(&engine.name, &file(&folder), &[]).finish();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success() && message.lines().count() == 1, "{message}");
    assert!(message.contains("already running"), "{message}");
}

#[test]
fn what_is_no_recording_is_refused_in_one_line() {
    for bad in ["README.md", "nothing-there.mcap"] {
        let path = crate::fleet::root().join(bad);
        let output = start(&unique("replay-bad"), &path, &[]).finish();
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(
            !output.status.success() && message.contains(bad) && message.lines().count() == 1,
            "{message}"
        );
    }
}

#[test]
fn a_live_collision_checker_works_on_a_recording_that_has_no_contacts() {
    let folder = TempDir::new().expect("a folder");
    record("replay-checked", "thirty.yaml", 100, &file(&folder), &[]);
    let (fleet, replay, _control) = paused("replay-checker", &file(&folder), &["--hold"]);
    let checker =
        Process::start(regatta().args(["plugin", "collision", "--fleet", &fleet.to_string()]));
    let participant = Participant::join(&fleet, "test").expect("joined");
    let mut column = ColumnReader::open_on(&participant, COLLISION.name()).expect("opened");
    let mut contacts = ContactReader::open_on(&participant).expect("opened");
    let robots = eventually("the column", || {
        column.latest().expect("readable").map(|column| column.values.len())
    });
    assert_eq!(robots, 30);
    eventually("contacts", || contacts.latest().expect("readable").map(|_| ()));
    for process in [checker, replay] {
        let output = process.interrupt();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
fn a_viewer_of_a_file_says_in_one_line_what_is_wrong() {
    let folder = TempDir::new().expect("a folder");
    record("viewer-file", "thirty.yaml", 100, &file(&folder), &[]);
    let (recording, text) =
        (file(&folder).display().to_string(), folder.path().join("text").display().to_string());
    std::fs::write(&text, "no recording").expect("written");
    let film = folder.path().join("film").display().to_string();
    let cases: [(&[&str], &str); 6] = [
        (&[&text], "can't read"),
        (&["/no/such.mcap"], "can't read /no/such.mcap"),
        (
            &[&recording, "--film", &film, "--from", "800ms", "--to", "200ms"],
            "--from 0.800 s is after --to 0.200 s",
        ),
        (
            &[&recording, "--film", &film, "--to", "2s"],
            "--to 2.000 s is outside of the recording, 0.000 s to 1.000 s",
        ),
        (&[&recording, "--film", "film.avi"], "film.avi: pictures are not written in this format"),
        (&[&recording, "--film", &film, "--speed", "0"], "is not a factor from 0.001 to 1000"),
    ];
    for (args, reason) in cases {
        let output = regatta().arg("viewer").args(args).output().expect("it starts");
        let stderr = String::from_utf8_lossy(&output.stderr);
        let lines: Vec<_> = stderr.lines().filter(|line| line.starts_with("regatta: ")).collect();
        assert!(
            !output.status.success() && lines.len() == 1 && lines[0].contains(reason),
            "{args:?}: {stderr}"
        );
    }
    assert!(!Path::new(&film).exists());
}

#[test]
fn a_jump_shows_the_columns_of_its_time_at_once_and_its_contacts_soon() {
    let folder = TempDir::new().expect("a folder");
    record_contacts("replay-jump-source", &file(&folder), &[]);
    let (fleet, process, mut control) = paused("replay-jump", &file(&folder), &[]);
    let participant = Participant::join(&fleet, "test").expect("joined");
    let mut column = ColumnReader::open_on(&participant, COLLISION.name()).expect("opened");
    let mut contacts = ContactReader::open_on(&participant).expect("opened");
    let (mut types, mut world) = (
        ColumnReader::open_on(&participant, TYPE.name()).expect("opened"),
        WorldReader::open_on(&participant).expect("opened"),
    );
    control.status().expect("answered");
    control.status().expect("this comes after the readers were connected");
    for (millis, tick) in [(1000, 100), (500, 50), (1400, 140), (0, 0), (700, 70)] {
        let status = control.seek(std::time::Duration::from_millis(millis)).expect("gone there");
        assert_eq!(status.tick, tick);
        column.latest().expect("readable");
        let shown = column.current().expect("readable").expect("a column").header;
        assert_eq!((shown.tick, shown.run_id), (tick, status.run_id), "with the frame");
        types.latest().expect("readable");
        world.latest().expect("readable");
        assert_eq!(types.current().expect("readable").expect("types").values.len(), 300);
        let shown = world.current().expect("readable").expect("a world").run_id();
        assert_eq!(shown, status.run_id, "each run has its world");
        let found = eventually("contacts", || {
            let header = contacts.latest().expect("readable")?.header;
            (header.tick == tick).then_some(*header)
        });
        assert_eq!(found.run_id, status.run_id);
    }
    assert!(process.interrupt().status.success());
}

#[test]
fn a_replay_tells_its_file_its_time_and_its_marks() {
    let folder = TempDir::new().expect("a folder");
    record_contacts("replay-marks-source", &file(&folder), &[]);
    let mut notes = file(&folder).into_os_string();
    notes.push(".notes");
    std::fs::write(&notes, "0.25 a first note\n\n1.0 a second one\n").expect("written");
    let file_of_notes = notes;
    let (fleet, process, mut control) = paused("replay-marks", &file(&folder), &[]);
    let participant = Participant::join(&fleet, "test").expect("joined");
    let mut reader = RecordingReader::open_on(&participant).expect("opened");
    let marks = eventually("the search is over", || {
        reader.take().expect("readable");
        let recording =
            reader.current().filter(|recording| recording.header.searched_nanos == u64::MAX)?;
        Some(recording.marks.to_vec())
    });
    let header = *reader.current().expect("told").header;
    assert_eq!(
        (header.file(), header.start_nanos, header.end_nanos),
        ("run.mcap", 0, 1_500_000_000)
    );
    let of = |kind: MarkKind| {
        marks.iter().filter(move |mark| mark.kind() == Some(kind)).collect::<Vec<_>>()
    };
    let notes: Vec<_> = of(MarkKind::Note).iter().map(|mark| mark.time_nanos).collect();
    assert_eq!(notes, [250_000_000, 1_000_000_000]);
    assert!(!of(MarkKind::Contact).is_empty() && of(MarkKind::Fault).is_empty(), "{marks:?}");
    assert!(marks.is_sorted_by_key(|mark| mark.time_nanos));
    let seek = control.seek(std::time::Duration::from_millis(600)).expect("gone there");
    let header = eventually("the note", || {
        reader.take().expect("readable");
        reader
            .current()
            .map(|recording| *recording.header)
            .filter(|header| !header.note().is_empty())
    });
    assert_eq!(
        (header.note(), header.run_id, header.time_of(600_000_000)),
        ("a first note", seek.run_id, 600_000_000)
    );
    // Somebody adds a note while the recording stands.
    std::fs::write(file_of_notes, "0.25 a first note\n0.500000000 added\n1.0 a second one\n")
        .expect("written");
    let (note, marks) = eventually("the added note", || {
        reader.take().expect("readable");
        let recording = reader.current().filter(|recording| recording.header.note() == "added")?;
        Some((recording.header.note().to_owned(), recording.marks.to_vec()))
    });
    let notes: Vec<_> = marks.iter().filter(|mark| mark.kind() == Some(MarkKind::Note)).collect();
    assert_eq!((note.as_str(), notes.len(), notes[1].time_nanos), ("added", 3, 500_000_000));
    assert!(
        marks.is_sorted_by_key(|mark| mark.time_nanos) && marks.len() > notes.len(),
        "others are still there"
    );
    assert!(process.interrupt().status.success());
}

/// The robot seconds that a recording's robots lose, of all frames.
fn lost_secs(recording: &Path) -> f64 {
    let recording = Recording::open(recording).expect("a recording");
    let mut lists: Vec<(u64, Vec<ContactRecord>)> = Vec::new();
    let read = recording.contacts(|_, header, pairs| {
        lists.push((header.tick, pairs.to_vec()));
        Ok::<_, ReadingError>(())
    });
    read.expect("readable");
    let mut spots = Spots::default();
    let read = recording.frames(|_, frame| -> Result<(), ReadingError> {
        let pairs = lists
            .iter()
            .rfind(|(tick, _)| *tick <= frame.tick())
            .map_or(&[][..], |(_, pairs)| pairs);
        spots.add(frame, pairs);
        Ok(())
    });
    read.expect("readable");
    spots.list().iter().map(|spot| spot.lost_secs()).sum()
}

#[test]
fn the_history_of_a_recording_is_all_of_it_whatever_is_played() {
    let folder = TempDir::new().expect("a folder");
    record_contacts("history-source", &file(&folder), &[]);
    let expected = lost_secs(&file(&folder));
    assert!(expected > 5.0, "the recording has contacts: {expected} robot s");
    let fleet = unique("history");
    let plugin =
        Process::start(regatta().args(["plugin", "traffic", "--fleet", &fleet.to_string()]));
    let traffic = Participant::join(&fleet, "probe")
        .and_then(|probe| TrafficReader::open_on(&probe))
        .expect("a reader");
    eventually("the traffic plugin", || traffic.has_publisher().then_some(()));
    let replay = start(&fleet, &file(&folder), &["--paused"]);
    let mut control = eventually("control", || Control::open(&fleet).ok());
    let participant = Participant::join(&fleet, "test").expect("joined");
    let mut reader = HistoryReader::open_on(&participant).expect("a reader");
    let mut history_of = |run_id: u64| {
        eventually("the history of the whole recording", || {
            reader.update().expect("readable");
            let (header, samples) = reader.samples()?;
            let is_whole = header.run_id == run_id && header.sim_time_nanos >= 1_400_000_000;
            let (spots, places) = reader.spots()?;
            let lost: f64 = places.iter().map(|spot| spot.lost_secs()).sum();
            (is_whole && spots.run_id == run_id)
                .then(|| (header.began_nanos, samples.to_vec(), lost))
        })
    };
    let run_id = eventually("a status", || control.status().ok()).run_id;
    let (began, samples, lost) = history_of(run_id);
    assert_eq!((began, samples[0].secs), (0, 0.0));
    assert!(
        samples.len() >= 3 && samples.iter().all(|sample| sample.robots() == 300),
        "{samples:?}"
    );
    assert!(
        samples
            .iter()
            .skip(1)
            .all(|sample| sample.touching().is_some() && sample.throughput() > Some(0.0))
    );
    // One frame in ten counts, up to a tenth of a second before the end.
    assert!((lost - expected).abs() < 0.12 * expected, "{lost} of {expected} robot s");

    // Jumps forth, which goes on with the run, and back, which begins another one.
    assert_eq!(
        control.seek(std::time::Duration::from_millis(1_000)).expect("gone there").run_id,
        run_id
    );
    assert_eq!(history_of(run_id).2, lost);
    let back = control.seek(std::time::Duration::from_millis(300)).expect("gone there").run_id;
    assert_ne!(back, run_id);
    assert_eq!(history_of(back).2, lost);
    assert!(plugin.interrupt().status.success());
    let messages = String::from_utf8_lossy(&replay.interrupt().stderr).into_owned();
    assert!(!messages.contains("left out"), "{messages}");
}

#[test]
fn the_time_of_a_jump_is_counted_on_no_edge() {
    let folder = TempDir::new().expect("a folder");
    record("jump-source", "thirty.yaml", 800, &file(&folder), &[]);
    let (fleet, replay, mut control) = paused("jump", &file(&folder), &[]);
    let plugin =
        Process::start(regatta().args(["plugin", "traffic", "--fleet", &fleet.to_string()]));
    let participant = Participant::join(&fleet, "test").expect("joined");
    let mut reader = TrafficReader::open_on(&participant).expect("a reader");
    // With nothing played, whatever is counted would be the time of a jump.
    let mut jump = |secs: u64| {
        let tick = control.seek(std::time::Duration::from_secs(secs)).expect("gone there").tick;
        eventually("the figures of the frame", || {
            let traffic =
                reader.latest().expect("readable").filter(|traffic| traffic.header.tick == tick)?;
            let entered: f32 = traffic.periods[2].iter().map(|edge| edge.entered_per_hour).sum();
            Some((traffic.header.period_secs[2], entered))
        })
    };
    for secs in [2, 5, 7] {
        assert_eq!(jump(secs), (0.0, 0.0), "after the jump to {secs} s");
    }
    let output = plugin.interrupt();
    assert!(output.status.success(), "beside the history of a replay: {output:?}");
    drop(replay);
}
