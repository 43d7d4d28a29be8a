//! Producers and readers as processes: stopped, killed, replaced. This program starts itself again
//! as each.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use regatta_plugin::ProducerPorts;
use regatta_plugin::command::Authority;
use regatta_plugin::health::{occupants, services_of};
use regatta_plugin::world::WorldData;
use regatta_plugin::{
    Commands, FleetName, Frame, OpenError, Ownership, Participant, Plugin, Result, Subscriber,
    World,
};
use rustix::process::{Pid, Signal, kill_process};

use crate::common::{fleet, publish};

/// Longest wait for anything: machines may be busy.
const PATIENCE: Duration = Duration::from_secs(30);

/// Not a test but what the children run: `ROLE FLEET`.
#[test]
fn child() {
    let Ok(role) = std::env::var("REGATTA_TEST_ROLE") else { return };
    let fleet: FleetName = std::env::var("REGATTA_TEST_FLEET").unwrap().parse().unwrap();
    match role.as_str() {
        "producer" => produce(&fleet),
        "holder" => hold(&fleet),
        "owner" => own(&fleet),
        "plugin" => plugin(&fleet),
        other => panic!("no role {other}"),
    }
}

fn produce(fleet: &FleetName) {
    let mut producer = ProducerPorts::create(fleet, 5_000).unwrap();
    producer.publish_world(&WorldData::default()).unwrap();
    for tick in 0.. {
        publish(&producer, tick, 5_000);
        producer.update();
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Takes a frame and holds it for ever.
fn hold(fleet: &FleetName) {
    let mut subscriber = Subscriber::open(fleet).unwrap();
    while subscriber.wait(Duration::from_millis(100)).unwrap().is_none() {}
    println!("ready");
    loop {
        std::thread::sleep(Duration::from_secs(1));
    }
}

/// Owns the movement of the fleet for ever.
fn own(fleet: &FleetName) {
    let _ownership = Ownership::claim(&Participant::join(fleet, "owner").unwrap()).unwrap();
    println!("ready");
    loop {
        std::thread::sleep(Duration::from_secs(1));
    }
}

#[derive(Default)]
struct Witness {
    frames: u64,
    run_id: u64,
    /// The argument of the last call of `on_idle` since the last frame.
    has_producer: Option<bool>,
}

impl Plugin for Witness {
    fn on_world(&mut self, world: &World) -> Result {
        self.run_id = world.run_id();
        println!("world");
        Ok(())
    }

    fn on_frame(&mut self, frame: &Frame) -> Result {
        let world_first = frame.header().world_revision == 0 || frame.run_id() == self.run_id;
        assert!(world_first, "a frame before its world");
        self.frames += 1;
        self.has_producer = None;
        println!("frame");
        Ok(())
    }

    fn on_idle(&mut self, has_producer: bool) -> Result {
        if self.has_producer.replace(has_producer) != Some(has_producer) {
            println!("idle, {}", if has_producer { "producer" } else { "nobody" });
        }
        Ok(())
    }

    fn on_stop(&mut self) -> Result {
        println!("stopped");
        Ok(())
    }
}

fn plugin(fleet: &FleetName) {
    regatta_plugin::run_from(Witness::default(), ["witness", "--fleet", fleet.as_str()]).unwrap();
    println!("ended");
}

/// A child; killed when dropped.
struct Role {
    child: Child,
    lines: Receiver<String>,
}

impl Role {
    fn start(role: &str, fleet: &FleetName) -> Self {
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "processes::child", "--nocapture", "--test-threads=1"])
            .env("REGATTA_TEST_ROLE", role)
            .env("REGATTA_TEST_FLEET", fleet.as_str())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let stdout = BufReader::new(child.stdout.take().unwrap());
        let (sender, lines) = std::sync::mpsc::channel();
        std::thread::spawn(move || {
            stdout.lines().map_while(|line| line.ok()).try_for_each(|line| sender.send(line))
        });
        Self { child, lines }
    }

    fn signal(&self, signal: Signal) {
        kill_process(Pid::from_raw(self.child.id() as i32).unwrap(), signal).unwrap();
    }

    /// Reads what the child prints until that line, and meanwhile calls `idle`. (The test harness
    /// may have printed something on the same line before it.)
    fn wait_for(&mut self, wanted: &str, mut idle: impl FnMut()) {
        let start = Instant::now();
        while start.elapsed() < PATIENCE {
            match self.lines.recv_timeout(Duration::from_millis(2)) {
                Ok(line) if line.ends_with(wanted) => return,
                Ok(_) => {}
                Err(RecvTimeoutError::Timeout) => idle(),
                Err(RecvTimeoutError::Disconnected) => {
                    panic!("the child ended without printing {wanted:?}")
                }
            }
        }
        panic!("the child has not printed {wanted:?} in time");
    }

    fn kill(mut self) {
        self.signal(Signal::KILL);
        self.child.wait().unwrap();
    }
}

impl Drop for Role {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn eventually(what: &str, mut check: impl FnMut() -> bool) {
    let start = Instant::now();
    while !check() {
        assert!(start.elapsed() < PATIENCE, "{what}: not in time");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Publishes frames and returns the longest time that one took.
fn publish_many(producer: &ProducerPorts, ticks: std::ops::Range<u64>) -> Duration {
    let mut longest = Duration::ZERO;
    for tick in ticks {
        let start = Instant::now();
        publish(producer, tick, 1_000);
        producer.update();
        longest = longest.max(start.elapsed());
    }
    longest
}

#[test]
fn a_stopped_reader_does_not_hold_up_anybody() {
    let fleet = fleet();
    let producer = ProducerPorts::create(&fleet, 1_000).unwrap();
    let mut stopped = Role::start("plugin", &fleet);
    let mut reading = Subscriber::open(&fleet).unwrap();
    stopped.wait_for("frame", || publish(&producer, 0, 1_000));
    stopped.signal(Signal::STOP);
    std::thread::sleep(Duration::from_millis(50));
    // Far more than any socket buffer holds.
    let longest = publish_many(&producer, 1..20_000);
    assert!(longest < Duration::from_millis(500), "a send took {longest:?}");
    assert_eq!(reading.latest().unwrap().unwrap().tick(), 19_999);
    // It goes on when it is continued: to be stopped and continued is no request to end.
    stopped.signal(Signal::CONT);
    (0..2).for_each(|_| stopped.wait_for("frame", || publish(&producer, 20_000, 1_000)));
    stopped.signal(Signal::TERM);
    stopped.wait_for("stopped", || ());
    stopped.wait_for("ended", || ());
}

#[test]
fn a_plugin_hears_that_no_frame_comes_and_whether_there_is_a_producer() {
    let fleet = fleet();
    let mut witness = Role::start("plugin", &fleet);
    witness.wait_for("idle, nobody", || ());
    let producer = Role::start("producer", &fleet);
    witness.wait_for("frame", || ());
    producer.signal(Signal::STOP);
    witness.wait_for("idle, producer", || ());
    producer.kill();
    witness.wait_for("idle, nobody", || ());
}

#[test]
fn killed_readers_leave_room_for_more() {
    let fleet = fleet();
    let producer = ProducerPorts::create(&fleet, 1_000).unwrap();
    for round in 0..20 {
        let mut role = Role::start("holder", &fleet);
        role.wait_for("ready", || publish(&producer, round, 1_000));
        role.kill();
        // Of the dead, each new one to join cleans up: more have died than a fleet has places.
        publish_many(&producer, 0..100);
    }
    let mut reader = Subscriber::open(&fleet).unwrap();
    publish(&producer, 7, 1_000);
    assert_eq!(reader.latest().unwrap().unwrap().tick(), 7);
}

#[test]
fn a_killed_producer_is_replaced_while_its_readers_live_on() {
    let fleet = fleet();
    let mut reader = Subscriber::open(&fleet).unwrap();
    let mut witness = Role::start("plugin", &fleet);
    let first = Role::start("producer", &fleet);
    let run = reader.wait(PATIENCE).unwrap().expect("a frame").run_id();
    assert!(
        matches!(ProducerPorts::create(&fleet, 1), Err(OpenError::AlreadyRunning { .. })),
        "it is alive"
    );
    witness.wait_for("frame", || ());
    first.kill();
    assert_eq!(reader.current().unwrap().unwrap().run_id(), run, "a frame in hand stays");
    let second = Role::start("producer", &fleet);
    eventually("a frame of the next run", || {
        reader
            .wait(Duration::from_millis(100))
            .unwrap()
            .is_some_and(|frame| frame.run_id() != run && frame.len() == 5_000)
    });
    witness.wait_for("world", || ());
    witness.wait_for("frame", || ());
    second.kill();
    witness.signal(Signal::INT);
    witness.wait_for("ended", || ());
    drop(reader);
    // The dead one's traces go with the next process to join any fleet.
    drop(Subscriber::open(&crate::common::fleet()).unwrap());
    assert!(services_of(&fleet).unwrap().is_empty(), "{:?}", services_of(&fleet));
}

#[test]
fn ten_readers_come_and_go() {
    let fleet = fleet();
    let producer = ProducerPorts::create(&fleet, 100).unwrap();
    let mut readers: Vec<_> = (0..10).map(|_| Role::start("plugin", &fleet)).collect();
    eventually("ten read", || {
        publish(&producer, 1, 100);
        producer.frame_readers() == 10
    });
    for role in &mut readers {
        role.wait_for("frame", || publish(&producer, 2, 100));
        role.signal(Signal::INT);
        role.wait_for("ended", || ());
    }
    eventually("none reads", || producer.frame_readers() == 0);
    let alive = occupants().unwrap();
    let mine = alive.iter().filter(|o| o.name.starts_with(&format!("regatta/{fleet}/")) && o.alive);
    assert_eq!(
        mine.map(|o| (o.name.as_str(), o.pid)).collect::<Vec<_>>(),
        [(format!("regatta/{fleet}/producer").as_str(), std::process::id())]
    );
    drop(producer);
    assert!(services_of(&fleet).unwrap().is_empty(), "nothing is left");
}

#[test]
fn a_plugin_says_once_that_it_waits_for_an_engine() {
    let fleet = fleet();
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "processes::child", "--nocapture"])
        .env("REGATTA_TEST_ROLE", "plugin")
        .env("REGATTA_TEST_FLEET", fleet.as_str())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let output = BufReader::new(child.stderr.take().unwrap()).lines().map_while(|line| line.ok());
    let mut lines = output.filter(|line| !line.is_empty());
    let expected = format!("witness: waiting for an engine of fleet '{fleet}'");
    assert_eq!(lines.next(), Some(expected));
    // A plugin that repeated it would do so after another second.
    std::thread::sleep(Duration::from_millis(1_500));
    kill_process(Pid::from_raw(child.id() as i32).unwrap(), Signal::TERM).unwrap();
    assert_eq!(lines.next(), None);
    assert!(child.wait().unwrap().success());
}

/// Sends a command that moves a robot, and returns the authority that the producer gives it.
fn authority(producer: &mut ProducerPorts, commands: &mut Commands) -> Option<Authority> {
    commands.cancel(0);
    commands.send().unwrap();
    let mut found = None;
    producer.take_commands(|_, authority, _| found = Some(authority)).unwrap();
    found
}

#[test]
fn ownership_ends_when_its_process_is_killed() {
    let fleet = fleet();
    let mut producer = ProducerPorts::create(&fleet, 1).unwrap();
    // Opened before: it doesn't clean up after the owner.
    let mut commands = Commands::open(&fleet).unwrap();
    let mut owner = Role::start("owner", &fleet);
    owner.wait_for("ready", || {});
    let found = authority(&mut producer, &mut commands);
    assert_eq!(found, Some(Authority::WithoutMovement));
    owner.kill();
    let start = Instant::now();
    while authority(&mut producer, &mut commands) != Some(Authority::Full) {
        assert!(start.elapsed() < PATIENCE, "the owner is dead");
        std::thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(producer.owner(), None);
}
