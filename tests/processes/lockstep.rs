//! Lockstep: the engine waits for named plugins, and their runs are reproducible.

use std::process::Output;
use std::time::Duration;

use regatta_plugin::lockstep::Reporter;
use regatta_plugin::{FleetName, Orders, Participant, Subscriber};

use crate::fleet::{Process, TIMEOUT, graphs, regatta, unique};

const TICKS: u64 = 300;

fn engine(fleet: &FleetName, args: &[&str]) -> Process {
    let ticks = TICKS.to_string();
    let common = ["--ticks", &ticks, "--speed", "max", "--digest", "--fleet", &fleet.to_string()].map(str::to_owned);
    Process::start(regatta().arg("engine").arg(graphs("thirty.yaml")).args(common).args(args))
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A controller that holds and releases robots by the tick that it sees, after a pause of its own.
fn control(fleet: &FleetName, pause: Duration) {
    let participant = Participant::join(fleet, "controller").expect("joined");
    let mut frames = Subscriber::open_on(&participant).expect("opened");
    let mut orders = Orders::open_on(&participant).expect("opened");
    let reporter = Reporter::open_on(&participant).expect("opened");
    let mut next = 0;
    while next <= TICKS {
        let frame = frames.wait(TIMEOUT).expect("readable").expect("a frame in time");
        let (run, tick) = (frame.run_id(), frame.tick());
        let robot = (tick % 30) as u32;
        assert_eq!(tick, next, "every tick, from the one before the first step");
        if tick.is_multiple_of(7) {
            std::thread::sleep(pause);
            orders.hold(robot);
        } else {
            orders.resume(robot);
        }
        orders.send().expect("sent");
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
    assert_ne!(text(&fast.stdout), text(&alone.stdout), "the controller's orders count");
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
        .map(|line| line.strip_prefix("tick ").and_then(|rest| rest.split(':').next()?.parse().ok()).expect("a tick"))
        .collect();
    assert_eq!(ticks, (0..=TICKS).collect::<Vec<_>>(), "each once, in order");
}

#[test]
fn a_plugin_that_is_not_there_is_named_when_time_is_up() {
    let output = engine(&unique("lockstep-nobody"), &["--lockstep", "nobody", "--lockstep-timeout", "0.3"]).finish();
    let message = text(&output.stderr);
    assert!(!output.status.success() && message.contains("nobody") && message.lines().count() == 1, "{message}");
}
