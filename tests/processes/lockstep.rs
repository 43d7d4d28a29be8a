//! Lockstep: the engine waits for named plugins, and their runs are reproducible.

use std::process::Output;
use std::time::Duration;

use regatta_plugin::event::EventKind;
use regatta_plugin::frame::ClockState;
use regatta_plugin::{
    ColumnPublisher, ColumnReader, Commands, EventReader, FleetName, Frame, Participant, Plugin,
    ReadError, Reporter, Result, Subscriber, WorldReader,
};

use crate::fleet::{Fleet, Process, TIMEOUT, graphs, messages, regatta, unique};

const TICKS: u64 = 300;

fn engine(fleet: &FleetName, args: &[&str]) -> Process {
    engine_of("thirty.yaml", fleet, args)
}

fn engine_of(scenario: &str, fleet: &FleetName, args: &[&str]) -> Process {
    let ticks = TICKS.to_string();
    let common = ["--ticks", &ticks, "--speed", "max", "--digest", "--fleet", &fleet.to_string()]
        .map(str::to_owned);
    Process::start(regatta().arg("engine").arg(graphs(scenario)).args(common).args(args))
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A controller that holds and releases robots by the tick that it sees, after a pause of its own.
fn control(fleet: &FleetName, pause: Duration) {
    let participant = Participant::join(fleet, "controller").expect("joined");
    let mut frames = Subscriber::open_on(&participant).expect("opened");
    let mut commands = Commands::open_on(&participant).expect("opened");
    let reporter = Reporter::open_on(&participant).expect("opened");
    let mut next = 0;
    while next <= TICKS {
        let frame = frames.wait(TIMEOUT).expect("readable").expect("a frame in time");
        let (run, tick) = (frame.run_id(), frame.tick());
        let robot = (tick % 30) as u32;
        assert_eq!(tick, next, "every tick, from the one before the first step");
        if tick.is_multiple_of(7) {
            std::thread::sleep(pause);
            commands.hold(robot);
        } else {
            commands.resume(robot);
        }
        commands.send().expect("sent");
        reporter.done(run, tick).expect("reported");
        next += 1;
    }
}

fn controlled_run(test: &str, pause: Duration) -> Output {
    let fleet = unique(test);
    let engine = engine(&fleet, &["--lockstep", "controller"]);
    control(&fleet, pause);
    let output = engine.finish();
    assert!(output.status.success(), "{}", text(&output.stderr));
    output
}

#[test]
fn a_controllers_run_is_reproducible_however_slow_it_is() {
    let fast = controlled_run("lockstep-fast", Duration::ZERO);
    let slow = controlled_run("lockstep-slow", Duration::from_millis(3));
    let alone = engine(&unique("lockstep-alone"), &[]).finish();
    assert_eq!(text(&fast.stdout), text(&slow.stdout));
    assert_ne!(text(&fast.stdout), text(&alone.stdout), "the controller's commands count");
}

/// A controller that closes edges and opens them again, by the tick that it sees, after a pause of
/// its own.
fn close_edges(fleet: &FleetName, pause: Duration) {
    let participant = Participant::join(fleet, "controller").expect("joined");
    let mut frames = Subscriber::open_on(&participant).expect("opened");
    let mut worlds = WorldReader::open_on(&participant).expect("opened");
    let mut commands = Commands::open_on(&participant).expect("opened");
    let reporter = Reporter::open_on(&participant).expect("opened");
    let mut closed = Vec::new();
    for next in 0..=TICKS {
        let (run, edge_ids) = {
            let frame = frames.wait(TIMEOUT).expect("readable").expect("a frame in time");
            assert_eq!(frame.tick(), next);
            worlds.latest().expect("readable");
            let world =
                worlds.current().expect("readable").expect("a world comes before its frames");
            // Edges that robots are on, so that closing them makes a difference.
            let edges =
                frame.edge().iter().take(50).filter_map(|edge| world.edges().get(*edge as usize));
            (frame.run_id(), edges.map(|edge| edge.id).collect::<Vec<u32>>())
        };
        if next % 100 == 0 {
            std::thread::sleep(pause);
            closed = edge_ids;
            closed.iter().for_each(|edge| _ = commands.close_edge(*edge));
        } else if next % 100 == 80 {
            closed.iter().for_each(|edge| _ = commands.open_edge(*edge));
        }
        commands.send().expect("sent");
        reporter.done(run, next).expect("reported");
    }
}

#[test]
fn a_run_with_closures_repeats() {
    let run = |test: &str, pause: Duration| {
        let fleet = unique(test);
        let engine = engine_of(
            "warehouse-1000.yaml",
            &fleet,
            &["--robots", "200", "--lockstep", "controller"],
        );
        close_edges(&fleet, pause);
        let output = engine.finish();
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stdout)
    };
    let (fast, slow) =
        (run("closures-fast", Duration::ZERO), run("closures-slow", Duration::from_millis(50)));
    assert_eq!(fast.trim().len(), 32, "{fast}");
    assert_eq!(fast, slow, "the same digest twice");
    let alone =
        engine_of("warehouse-1000.yaml", &unique("closures-alone"), &["--robots", "200"]).finish();
    assert_ne!(fast, text(&alone.stdout), "closed edges make a difference");
}

#[test]
fn a_plugin_in_lockstep_sees_every_tick() {
    let fleet = unique("lockstep-hello");
    let hello = Process::start(regatta().args(["plugin", "hello", "--fleet", &fleet.to_string()]));
    let output = engine(&fleet, &["--lockstep", "hello"]).finish();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let printed = text(&hello.interrupt().stdout);
    let ticks: Vec<u64> = printed
        .lines()
        .map(|line| {
            line.strip_prefix("tick ")
                .and_then(|rest| rest.split(':').next()?.parse().ok())
                .expect("a tick")
        })
        .collect();
    assert_eq!(ticks, (0..=TICKS).collect::<Vec<_>>(), "each once, in order");
}

#[test]
fn a_plugin_that_ends_as_it_was_asked_to_leaves_the_lockstep() {
    let fleet = unique("lockstep-leave");
    let hello = Process::start(regatta().args(["plugin", "hello", "--fleet", &fleet.to_string()]));
    let ticks = ["--ticks", "400", "--speed", "1", "--rate", "100"];
    let mut command = regatta();
    command
        .arg("engine")
        .arg(graphs("thirty.yaml"))
        .args(ticks)
        .args(["--fleet", &fleet.to_string()]);
    let engine = Process::start(command.args(["--lockstep", "hello", "--lockstep-timeout", "2"]));
    let mut frames = Subscriber::open(&fleet).expect("opened");
    crate::fleet::eventually("the run has begun", || {
        frames.latest().expect("readable").filter(|frame| frame.tick() > 10).map(drop)
    });
    assert!(hello.interrupt().status.success());
    let output = engine.finish();
    let message = text(&output.stderr);
    assert!(output.status.success(), "{message}");
    assert_eq!(message.matches("hello has left the lockstep").count(), 1, "{message}");
}

#[test]
fn a_frame_of_a_tick_that_was_published_before_says_so() {
    let fleet = Fleet::start("repeated", "thirty.yaml", &["--rate", "20"]);
    let mut reader = fleet.subscriber();
    fleet.control(&["pause"]);
    let paused = crate::fleet::eventually("the paused frame", || {
        let frame = reader.latest().expect("readable")?;
        (frame.header().clock == ClockState::Paused as u32).then(|| *frame.header())
    });
    assert_eq!(paused.repeated, 1);
    fleet.control(&["robots", "31"]);
    let grown = crate::fleet::eventually("another robot", || {
        reader
            .latest()
            .expect("readable")
            .map(|frame| *frame.header())
            .filter(|header| header.robots == 31)
    });
    assert_eq!((grown.tick, grown.repeated), (paused.tick, 1));
    fleet.control(&["step"]);
    let next = crate::fleet::eventually("the next tick", || {
        reader
            .latest()
            .expect("readable")
            .map(|frame| *frame.header())
            .filter(|header| header.tick > paused.tick)
    });
    assert_eq!(next.tick, paused.tick + 1);
}

#[test]
fn a_plugin_that_is_not_there_is_named_when_time_is_up() {
    let output =
        engine(&unique("lockstep-nobody"), &["--lockstep", "nobody", "--lockstep-timeout", "0.3"])
            .finish();
    let message = messages(&output.stderr);
    assert!(
        !output.status.success() && message.contains("nobody") && message.lines().count() == 1,
        "{message}"
    );
}

/// Holds every robot that reaches a node, and lets the robots that it held a while before drive on:
/// by events alone.
fn steer_by_events(fleet: &FleetName, ticks: u64) {
    let participant = Participant::join(fleet, "gatekeeper").expect("joined");
    let mut frames = Subscriber::open_on(&participant).expect("opened");
    let mut events = EventReader::open_on(&participant).expect("opened");
    let mut commands = Commands::open_on(&participant).expect("opened");
    let reporter = Reporter::open_on(&participant).expect("opened");
    let mut held = std::collections::VecDeque::new();
    let mut tick = 0;
    while tick < ticks {
        let frame = frames.wait(TIMEOUT).expect("readable").expect("a frame in time");
        tick = frame.tick();
        let read = events.take(|events| -> Result<(), ReadError> {
            assert_eq!(events.header.tick, tick, "the events of this frame's tick, and no others");
            for event in
                events.records.iter().filter(|event| event.kind() == Some(EventKind::ReachedNode))
            {
                commands.hold(event.robot);
                held.push_back((tick + 7, event.robot));
            }
            Ok(())
        });
        read.expect("readable");
        while held.front().is_some_and(|(until, _)| *until <= tick) {
            commands.resume(held.pop_front().map_or(0, |(_, robot)| robot));
        }
        commands.send().expect("sent");
        reporter.done(frame.run_id(), tick).expect("reported");
    }
}

/// Keeps both cores of a small machine busy.
struct Busy(std::sync::Arc<std::sync::atomic::AtomicBool>);

impl Busy {
    fn start() -> Self {
        let over = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(false));
        for _ in 0..2 {
            let over = over.clone();
            std::thread::spawn(move || while !over.load(std::sync::atomic::Ordering::Relaxed) {});
        }
        Self(over)
    }
}

impl Drop for Busy {
    fn drop(&mut self) {
        self.0.store(true, std::sync::atomic::Ordering::Relaxed);
    }
}

#[test]
fn a_controller_that_reacts_to_events_gives_one_digest_on_a_busy_machine() {
    const TICKS: u64 = 200;
    let _busy = Busy::start();
    let digests: Vec<String> = (0..10)
        .map(|run| {
            let fleet = unique(&format!("lockstep-events-{run}"));
            let ticks = TICKS.to_string();
            let args =
                ["--ticks", &ticks, "--speed", "max", "--digest", "--lockstep", "gatekeeper"];
            let mut command = regatta();
            command
                .arg("engine")
                .arg(graphs("warehouse-1000.yaml"))
                .args(["--fleet", fleet.as_str()])
                .args(args);
            let engine = Process::start(&mut command);
            steer_by_events(&fleet, TICKS);
            let output = engine.finish();
            assert!(output.status.success(), "{}", text(&output.stderr));
            text(&output.stdout)
        })
        .collect();
    assert!(
        !digests[0].is_empty() && digests.iter().all(|digest| *digest == digests[0]),
        "{digests:?}"
    );
}

/// Publishes the tick as a column, after a pause that makes it the slower of the two plugins.
struct First(Option<ColumnPublisher>);

impl Plugin for First {
    fn on_start(&mut self, fleet: &Participant) -> Result {
        self.0 = Some(ColumnPublisher::open_on(fleet, "first")?);
        Ok(())
    }

    fn on_frame(&mut self, frame: &Frame) -> Result {
        std::thread::sleep(Duration::from_micros(500));
        let column = self.0.as_mut().expect("started");
        Ok(column.publish(frame, &vec![frame.tick() as f32; frame.len()])?)
    }
}

/// Checks that the column belongs to the tick of the frame.
struct Second {
    column: Option<ColumnReader>,
    ticks: std::sync::mpsc::Sender<(u64, u64)>,
}

impl Plugin for Second {
    fn on_start(&mut self, fleet: &Participant) -> Result {
        self.column = Some(ColumnReader::open_on(fleet, "first")?);
        Ok(())
    }

    fn on_frame(&mut self, frame: &Frame) -> Result {
        let column = self
            .column
            .as_mut()
            .expect("started")
            .latest()?
            .map_or(u64::MAX, |column| column.header.tick);
        // The test may have ended.
        let _ = self.ticks.send((frame.tick(), column));
        Ok(())
    }

    fn after(&self) -> Vec<String> {
        vec!["first".to_owned()]
    }
}

#[test]
fn a_plugin_that_comes_after_another_finds_its_column_of_the_same_tick() {
    let fleet = unique("lockstep-order");
    let engine = engine(&fleet, &["--lockstep", "first", "second"]);
    let (sender, ticks) = std::sync::mpsc::channel();
    // Plugins run until their process ends.
    for name in ["second", "first"] {
        let (fleet, ticks) = (fleet.clone(), sender.clone());
        std::thread::spawn(move || {
            let args = [name, "--fleet", fleet.as_str()];
            let ended = match name {
                "first" => regatta_plugin::run_from(First(None), args),
                _ => regatta_plugin::run_from(Second { column: None, ticks }, args),
            };
            ended.expect("the plugin runs");
        });
    }
    let seen: Vec<_> =
        (0..=TICKS).map(|_| ticks.recv_timeout(TIMEOUT).expect("a tick in time")).collect();
    assert!(engine.finish().status.success());
    // The second may join after the first has published the column of tick 0.
    assert_eq!(seen[1..], (1..=TICKS).map(|tick| (tick, tick)).collect::<Vec<_>>());
}

#[test]
fn a_plugin_cannot_come_after_itself() {
    let fleet = unique("lockstep-itself");
    let args = ["plugin", "hello", "--after", "hello", "--fleet", fleet.as_str()];
    let output = Process::start(regatta().args(args)).finish();
    let message = text(&output.stderr);
    assert!(
        !output.status.success()
            && message.contains("after itself")
            && message.lines().count() == 1,
        "{message}"
    );
}

/// Counts the ticks with events, and those lost.
struct Listener(std::sync::mpsc::Sender<(u64, u64, bool)>);

impl Plugin for Listener {
    fn on_frame(&mut self, frame: &Frame) -> Result {
        let _ = self.0.send((frame.tick(), 0, true));
        Ok(())
    }

    fn on_events(&mut self, events: &regatta_plugin::Events<'_>) -> Result {
        let _ = self.0.send((events.header.tick, events.missed, false));
        Ok(())
    }

    fn wants_events(&self) -> bool {
        true
    }
}

/// At 100 Hz and one frame a second, some 100 ticks with events pass between two frames, and 64 fit
/// the buffer.
#[test]
fn a_plugin_at_a_low_rate_loses_no_events() {
    let fleet = unique("rate-events");
    let (sender, seen) = std::sync::mpsc::channel();
    let name = fleet.clone();
    std::thread::spawn(move || {
        let args = ["listener", "--rate", "1", "--fleet", name.as_str()];
        regatta_plugin::run_from(Listener(sender), args).expect("the plugin runs");
    });
    let mut command = regatta();
    command.arg("engine").arg(graphs("warehouse-1000.yaml")).args([
        "--fleet",
        fleet.as_str(),
        "--ticks",
        "350",
    ]);
    assert!(Process::start(&mut command).finish().status.success());
    let (mut frames, mut ticks, mut lost) = (0, 0, 0);
    while let Ok((_, missed, is_frame)) = seen.recv_timeout(Duration::from_secs(1)) {
        frames += u64::from(is_frame);
        ticks += u64::from(!is_frame);
        lost += missed;
    }
    assert!(frames >= 2 && frames * 20 < ticks, "about one a second of {ticks} ticks: {frames}");
    assert!(ticks > 150 && lost == 0, "{ticks} ticks with events, {lost} lost");
}
