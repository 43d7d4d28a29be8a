//! Frames from a producer to readers, within one process.

use std::time::{Duration, Instant};

use regatta_plugin::ProducerPorts;
use regatta_plugin::frame::{BYTES_PER_LINE, frame_lines};
use regatta_plugin::health::occupants;
use regatta_plugin::world::{CurveRecord, EdgeRecord, NodeRecord, WorldData};
use regatta_plugin::{OpenError, Subscriber, WorldReader};

use crate::common::{fleet, publish};

fn check(subscriber: &mut Subscriber, tick: u64, robots: usize) {
    let frame = subscriber.latest().unwrap().expect("a new frame");
    assert_eq!((frame.tick(), frame.len(), frame.x().len()), (tick, robots, robots));
    assert_eq!(
        (frame.x()[0], frame.x()[robots - 1]),
        (tick as f32, tick as f32 + (robots - 1) as f32)
    );
    assert_eq!(frame.state()[robots - 1], 3);
}

#[test]
fn a_reader_gets_the_newest_frame_once() {
    let fleet = fleet();
    let producer = ProducerPorts::create(&fleet, 10).unwrap();
    let mut subscriber = Subscriber::open(&fleet).unwrap();
    assert!(subscriber.latest().unwrap().is_none());
    publish(&producer, 1, 10);
    publish(&producer, 2, 10);
    check(&mut subscriber, 2, 10);
    assert!(subscriber.latest().unwrap().is_none(), "returned already");
    assert_eq!(subscriber.current().unwrap().unwrap().tick(), 2);
    subscriber.release();
    assert!(subscriber.current().unwrap().is_none());
}

#[test]
fn a_late_joiner_gets_the_last_frame_and_the_world_while_the_clock_stands() {
    let fleet = fleet();
    let mut producer = ProducerPorts::create(&fleet, 3).unwrap();
    let mut data = WorldData { origin: [4.5e6, -1.0], ..WorldData::default() };
    let (name, level) = (data.texts.add("dock"), data.texts.add("ground floor"));
    data.nodes = vec![NodeRecord { id: 4, x: 1.5, name, level, ..NodeRecord::default() }; 7];
    let line = CurveRecord::straight([0.0, 0.0], [3.0, 4.0]);
    data.add_edge(EdgeRecord { id: 9, level, ..EdgeRecord::default() }, [line, line, line]);
    data.add_edge(EdgeRecord { id: 10, ..EdgeRecord::default() }, [line]);
    assert_eq!(producer.publish_world(&data).unwrap(), 1);
    publish(&producer, 5, 3);
    let mut subscriber = Subscriber::open(&fleet).unwrap();
    let mut worlds = WorldReader::open(&fleet).unwrap();
    producer.update();
    check(&mut subscriber, 5, 3);
    let frame = subscriber.current().unwrap().unwrap();
    let world = worlds.latest().unwrap().expect("the world");
    assert_eq!((world.nodes(), world.edges()), (&data.nodes[..], &data.edges[..]));
    assert_eq!((world.origin(), world.all_curves()), ([4.5e6, -1.0], &data.curves[..]));
    assert_eq!(
        world.edges().iter().map(|edge| world.curves(edge).len()).collect::<Vec<_>>(),
        [3, 1]
    );
    assert_eq!(
        (world.text(world.nodes()[6].name), world.text(world.edges()[0].level)),
        ("dock", "ground floor")
    );
    assert_eq!((world.run_id(), world.revision()), (frame.run_id(), frame.header().world_revision));
}

#[test]
fn a_fleet_grows_from_ten_to_a_million_under_old_readers_and_new() {
    let fleet = fleet();
    let producer = ProducerPorts::create(&fleet, 10).unwrap();
    let mut reading = Subscriber::open(&fleet).unwrap();
    let mut holding = Subscriber::open(&fleet).unwrap();
    publish(&producer, 0, 10);
    check(&mut holding, 0, 10);
    let sizes = [10, 17, 100, 5_000, 4_999, 70_000, 1_000_000, 20, 1_000_000];
    for (tick, robots) in (1..).zip(sizes) {
        publish(&producer, tick, robots);
        check(&mut reading, tick, robots);
        let mut late = Subscriber::open(&fleet).unwrap();
        producer.update();
        check(&mut late, tick, robots);
    }
    assert_eq!(holding.current().unwrap().unwrap().x()[9], 9.0, "a held frame stays as it was");
    check(&mut holding, sizes.len() as u64, 1_000_000);
}

#[test]
fn one_robot_more_at_a_time_does_not_use_up_the_segments() {
    let fleet = fleet();
    let producer = ProducerPorts::create(&fleet, 1).unwrap();
    let mut subscriber = Subscriber::open(&fleet).unwrap();
    for robots in 1..6_000 {
        publish(&producer, robots as u64, robots);
        check(&mut subscriber, robots as u64, robots);
    }
}

#[test]
fn a_second_producer_is_refused_and_told_by_whom() {
    let fleet = fleet();
    let first = ProducerPorts::create(&fleet, 1).unwrap();
    let error = ProducerPorts::create(&fleet, 1).unwrap_err();
    assert!(matches!(error, OpenError::AlreadyRunning { .. }), "{error}");
    assert!(error.to_string().contains(&format!("process {}", std::process::id())), "{error}");
    publish(&first, 1, 1);
    drop(first);
    ProducerPorts::create(&fleet, 1).unwrap();
}

#[test]
fn readers_live_on_when_the_producer_is_replaced() {
    let fleet = fleet();
    let first = ProducerPorts::create(&fleet, 4).unwrap();
    let mut subscriber = Subscriber::open(&fleet).unwrap();
    publish(&first, 8, 4);
    let run = first.run_id();
    drop(first);
    assert!(!subscriber.has_producer());
    let second = ProducerPorts::create(&fleet, 4).unwrap();
    assert_ne!(run, second.run_id());
    publish(&second, 0, 4);
    check(&mut subscriber, 0, 4);
    assert_eq!(subscriber.current().unwrap().unwrap().run_id(), second.run_id());
}

#[test]
fn a_reader_sleeps_until_it_is_woken() {
    let fleet = fleet();
    let producer = ProducerPorts::create(&fleet, 2).unwrap();
    let name = fleet.clone();
    let reader = std::thread::spawn(move || {
        let mut subscriber = Subscriber::open(&name).unwrap();
        let frame = subscriber.wait(Duration::from_secs(20)).unwrap().expect("woken");
        assert_eq!(frame.tick(), 77);
    });
    while producer.frame_readers() == 0 {
        std::thread::sleep(Duration::from_millis(1));
    }
    std::thread::sleep(Duration::from_millis(20));
    publish(&producer, 77, 2);
    reader.join().unwrap();
    let mut subscriber = Subscriber::open(&fleet).unwrap();
    producer.update();
    assert!(subscriber.latest().unwrap().is_some());
    let start = Instant::now();
    assert!(subscriber.wait(Duration::from_millis(30)).unwrap().is_none());
    assert!(start.elapsed() >= Duration::from_millis(30), "waits as long as told");
}

#[test]
fn a_reader_before_the_producer_gets_its_first_frame() {
    let fleet = fleet();
    let mut subscriber = Subscriber::open(&fleet).unwrap();
    assert!(!subscriber.has_producer());
    let producer = ProducerPorts::create(&fleet, 2).unwrap();
    publish(&producer, 0, 2);
    check(&mut subscriber, 0, 2);
}

#[test]
fn an_unsent_loan_is_never_seen_and_frees_its_place() {
    let fleet = fleet();
    let producer = ProducerPorts::create(&fleet, 2).unwrap();
    let mut subscriber = Subscriber::open(&fleet).unwrap();
    for _ in 0..100 {
        drop(producer.loan(2).unwrap());
    }
    let loan = producer.loan(2).unwrap();
    assert!(producer.loan(2).is_err(), "one at a time");
    drop(loan);
    assert!(subscriber.latest().unwrap().is_none());
}

#[test]
fn a_million_robots_take_the_memory_of_two_frames_and_one_per_reader_that_lags() {
    const ROBOTS: usize = 1_000_000;
    let fleet = fleet();
    let producer = ProducerPorts::create(&fleet, ROBOTS).unwrap();
    let mut reader = Subscriber::open(&fleet).unwrap();
    let mut lagging = Subscriber::open(&fleet).unwrap();
    let frames = || {
        let name = format!("regatta/{fleet}/producer");
        let bytes = occupants().unwrap().into_iter().find(|o| o.name == name).unwrap().bytes;
        bytes as f64 / (frame_lines(ROBOTS) * BYTES_PER_LINE) as f64
    };
    let tick = |tick: u64| {
        let mut frame = producer.loan(ROBOTS).unwrap();
        frame.header_mut().tick = tick;
        let columns = frame.columns_mut();
        for column in [columns.x, columns.y, columns.theta, columns.speed, columns.s] {
            column.fill(tick as f32);
        }
        columns.edge.fill(7);
        columns.state.fill(1);
        frame.send().unwrap();
    };
    for n in 0..20 {
        tick(n);
        reader.latest().unwrap();
        reader.release();
    }
    assert!(frames() < 2.1, "{:.2} frames", frames());
    lagging.latest().unwrap();
    for n in 20..40 {
        tick(n);
        reader.latest().unwrap();
    }
    assert!(frames() < 4.1, "{:.2} frames", frames());
}

#[test]
fn more_robots_than_shared_memory_can_hold_are_refused_before_it_is_too_late() {
    let fleet = fleet();
    let too_many = 4_000_000_000;
    let producer = ProducerPorts::create(&fleet, 10).unwrap();
    let error = producer.loan(too_many).unwrap_err();
    assert!(error.to_string().contains("MB are left"), "{error}");
    publish(&producer, 1, 10);
}
