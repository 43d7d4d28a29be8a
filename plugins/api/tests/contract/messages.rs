//! Commands, events, requests, columns and lockstep, there and back, within one process.

use std::time::{Duration, Instant};

use iceoryx2::prelude::*;
use iceoryx2::service::attribute::{AttributeKey, AttributeValue};
use regatta_plugin::ProducerPorts;
use regatta_plugin::column::TYPE;
use regatta_plugin::command::{CommandKind, CommandRecord, RouteLeg};
use regatta_plugin::control::{ControlKind, ControlResponse};
use regatta_plugin::event::{EventKind, EventRecord};
use regatta_plugin::frame::{CONTRACT_VERSION, FrameHeader, Line};
use regatta_plugin::ports::error::RequestError;
use regatta_plugin::route::{LegAhead, RouteRequest, RouteResponse};
use regatta_plugin::{
    ColumnPublisher, ColumnReader, CommandError, Commands, Control, ControlError, EventReader,
    FleetName, LockstepError, OpenError, Participant, PublishError, ReadError, Reporter,
    RouteClient, RouteError, RouteServer, Subscriber, column_names, services,
};

use crate::common::{fleet, publish};

fn taken(producer: &mut ProducerPorts) -> Vec<Vec<CommandRecord>> {
    let mut samples = Vec::new();
    producer.take_commands(|_, _, records| samples.push(records.to_vec())).unwrap();
    samples
}

#[test]
fn commands_arrive_as_sent() {
    let fleet = fleet();
    let mut commands = Commands::open(&fleet).unwrap();
    commands.hold(1);
    assert_eq!(commands.send(), Err(CommandError::NoEngine { fleet: fleet.clone() }));
    let mut producer = ProducerPorts::create(&fleet, 1).unwrap();
    let token = commands.assign(3, &[RouteLeg::forward(7), RouteLeg::reverse(8).horizon()]);
    let spawn = commands.spawn_on_edge(2, 9, 1.5);
    assert_ne!(token, spawn);
    commands.send().unwrap();
    assert!(commands.pending().is_empty());
    let samples = taken(&mut producer);
    let [hold, assign, first, second, spawned] = &samples[0][..] else { panic!("{samples:?}") };
    assert_eq!((hold.kind, hold.robot), (CommandKind::Hold as u32, 1), "kept after the failure");
    assert_eq!((assign.token, assign.robot, assign.legs), (token, 3, 2));
    assert_eq!((first.id, first.reverse, first.released), (7, 0, 1));
    assert_eq!((second.id, second.reverse, second.released), (8, 1, 0));
    assert_eq!((spawned.token, spawned.id, spawned.s, spawned.robot_type), (spawn, 9, 1.5, 2));
    assert!(taken(&mut producer).is_empty());
}

#[test]
fn commands_that_nobody_takes_are_refused_rather_than_lost() {
    let fleet = fleet();
    let mut producer = ProducerPorts::create(&fleet, 1).unwrap();
    let mut commands = Commands::open(&fleet).unwrap();
    for _ in 0..services::COMMAND_BUFFER {
        commands.hold(1);
        commands.send().unwrap();
    }
    commands.hold(2);
    assert_eq!(commands.send(), Err(CommandError::Full { fleet }));
    assert_eq!(taken(&mut producer).len(), services::COMMAND_BUFFER);
    commands.send().unwrap();
    assert_eq!(taken(&mut producer)[0][0].robot, 2);
}

#[test]
fn ten_thousand_commands_fit_one_sample() {
    let fleet = fleet();
    let mut producer = ProducerPorts::create(&fleet, 1).unwrap();
    let mut commands = Commands::open(&fleet).unwrap();
    for robot in 0..10_000 {
        commands.hold(robot);
    }
    commands.send().unwrap();
    assert_eq!(taken(&mut producer)[0][9_999].robot, 9_999);
}

#[test]
fn tokens_of_different_senders_differ_and_repeat_from_run_to_run() {
    let fleet = fleet();
    let sender = |name| Commands::open_on(&Participant::join(&fleet, name).unwrap()).unwrap();
    let token = sender("a").hold(0);
    assert_ne!(token, sender("b").hold(0));
    assert_eq!(token, sender("a").hold(0));
}

#[test]
fn events_arrive_tick_by_tick_and_a_slow_reader_knows_what_it_missed() {
    let fleet = fleet();
    let mut producer = ProducerPorts::create(&fleet, 1).unwrap();
    assert!(!producer.has_event_readers());
    let mut reader = EventReader::open(&fleet).unwrap();
    assert!(producer.has_event_readers());
    let mut send = |tick| {
        let event = EventRecord {
            kind: EventKind::RouteDone as u32,
            robot: tick as u32,
            ..EventRecord::default()
        };
        producer.publish_events(tick, 0, &[event; 300]).unwrap();
    };
    let mut take = || {
        let mut seen = Vec::new();
        reader
            .take(|events| {
                assert_eq!(
                    (events.records.len(), events.records[299].kind()),
                    (300, Some(EventKind::RouteDone))
                );
                seen.push((events.header.tick, events.missed));
                Ok::<_, ReadError>(())
            })
            .unwrap();
        seen
    };
    send(1);
    send(2);
    assert_eq!(take(), [(1, 0), (2, 0)]);
    let buffer = services::EVENT_BUFFER as u64;
    (3..=12 + buffer).for_each(&mut send);
    let seen = take();
    assert_eq!((seen[0], seen.len()), ((13, 10), services::EVENT_BUFFER));
}

/// The segment has fewer chunks than all buffers together: stopped readers wait for the same ones.
#[test]
fn as_many_stopped_readers_as_there_may_be_stop_no_publisher() {
    let fleet = fleet();
    let mut producer = ProducerPorts::create(&fleet, 1).unwrap();
    let mut readers: Vec<_> = (0..services::MAX_READERS)
        .map(|_| EventReader::open_on(producer.participant()).unwrap())
        .collect();
    let ticks = 3 * services::EVENT_BUFFER as u64;
    for tick in 1..=ticks {
        producer.publish_events(tick, 0, &[EventRecord::default(); 100]).unwrap();
        // Some readers stop early, some late.
        let reader = &mut readers[tick as usize % services::MAX_READERS];
        if tick < ticks / 3 {
            reader.take(|_| Ok::<_, ReadError>(())).unwrap();
        }
    }
    for reader in &mut readers {
        let mut seen = Vec::new();
        reader
            .take(|events| {
                seen.push(events.header.tick);
                Ok::<_, ReadError>(())
            })
            .unwrap();
        let newest = ticks - services::EVENT_BUFFER as u64;
        assert_eq!(seen, (newest + 1..=ticks).collect::<Vec<_>>());
    }
}

#[test]
fn requests_are_answered_now_later_or_never() {
    let fleet = fleet();
    let mut control = Control::open(&fleet).unwrap();
    assert_eq!(control.status(), Err(ControlError::NoEngine { fleet: fleet.clone() }));
    let name = fleet.clone();
    let engine = std::thread::spawn(move || {
        let mut producer = ProducerPorts::create(&name, 1).unwrap();
        let (mut tick, mut later) = (0, Vec::new());
        let start = Instant::now();
        while start.elapsed() < Duration::from_secs(60) {
            tick += 1;
            let status = ControlResponse { tick, ..ControlResponse::default() };
            while let Some((ticket, request)) = producer.take_request().unwrap() {
                match request.kind() {
                    Some(ControlKind::Status) => producer.answer(ticket, status.accept()),
                    Some(ControlKind::Step) => later.push((tick + request.count, ticket)),
                    Some(ControlKind::Resume) => return,
                    _ => producer.answer(ticket, status.refuse("not today")),
                }
            }
            for (_, ticket) in later.extract_if(.., |(due, _)| tick >= *due) {
                producer.answer(ticket, status.accept());
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    });
    let start = Instant::now();
    while !control.has_engine() {
        assert!(start.elapsed() < Duration::from_secs(20));
        std::thread::sleep(Duration::from_millis(1));
    }
    let before = control.status().unwrap().tick;
    assert!(control.step(20).unwrap().tick >= before + 20);
    let refused = ControlError::Refused { fleet: fleet.clone(), reason: "not today".to_owned() };
    assert_eq!(control.pause(), Err(refused));
    // The engine keeps this one, then ends.
    let gone = RequestError::Gone { server: "the engine", fleet: fleet.clone() };
    assert_eq!(control.resume(), Err(gone.into()));
    engine.join().unwrap();
    assert_eq!(control.status(), Err(ControlError::NoEngine { fleet }));
}

#[test]
fn routes_are_told_by_whoever_knows_them() {
    let fleet = fleet();
    let mut client = RouteClient::open(&fleet).unwrap();
    let producer = ProducerPorts::create(&fleet, 1).unwrap();
    assert_eq!(
        client.route(0),
        Err(RouteError::NoRoutes { fleet: fleet.clone() }),
        "a producer that has none"
    );
    let mut server = RouteServer::open_on(producer.participant()).unwrap();
    let again =
        RouteServer::open_on(producer.participant()).map(|_| ()).expect_err("it has one server");
    let OpenError::Full { service, limit, holders } = &again else { panic!("{again}") };
    assert_eq!((service, *limit), (&services::service_name(&fleet, "routes"), 1));
    assert!(
        holders.contains("producer") && holders.contains("routes"),
        "the processes at the service: {holders}"
    );
    let timeout = Duration::from_millis(20);
    for _ in 0..3 {
        let robots = [0; services::MAX_OPEN_ROUTES];
        assert_eq!(
            client.routes(&robots, timeout),
            Err(RequestError::Timeout { server: "the engine", fleet: fleet.clone(), timeout }
                .into())
        );
    }
    let asker = std::thread::spawn({
        let robots: Vec<_> = (0..20).collect();
        let fleet = fleet.clone();
        move || RouteClient::open(&fleet).unwrap().routes(&robots, Duration::from_secs(60))
    });
    let start = Instant::now();
    while !asker.is_finished() {
        assert!(start.elapsed() < Duration::from_secs(60));
        let answer = |request: &RouteRequest| {
            let response = RouteResponse::unknown(7, 8, request.robot);
            if request.robot == 3 {
                response
            } else {
                response.with_legs(1, 2, [(request.robot, true), (9, false)].into_iter())
            }
        };
        server.answer(2, answer).unwrap();
        std::thread::sleep(Duration::from_millis(1));
    }
    let routes = asker.join().unwrap().unwrap();
    assert!(routes.iter().map(|route| route.robot).eq(0..20));
    assert!(!routes[3].is_found() && routes[4].is_found());
    assert_eq!(
        routes[4].legs().next(),
        Some(LegAhead { edge: 4, reverse: true, released: true, released_metres: f32::INFINITY })
    );
    let pending = client.ask(5).unwrap();
    assert_eq!(client.answer(&pending), Ok(None), "not answered yet");
    server.answer(8, |request| RouteResponse::unknown(7, 9, request.robot)).unwrap();
    assert_eq!(client.answer(&pending), Ok(Some(RouteResponse::unknown(7, 9, 5))));
    drop(server);
    assert_eq!(client.route(0), Err(RouteError::NoRoutes { fleet }));
}

#[test]
fn an_engine_that_stands_still_times_out() {
    let fleet = fleet();
    let _producer = ProducerPorts::create(&fleet, 1).unwrap();
    let mut control = Control::open(&fleet).unwrap();
    let timeout = Duration::from_millis(50);
    let request = regatta_plugin::control::ControlRequest::new(ControlKind::Status);
    for _ in 0..2 * services::MAX_OPEN_REQUESTS {
        assert_eq!(
            control.request(request, timeout),
            Err(RequestError::Timeout { server: "the engine", fleet: fleet.clone(), timeout }
                .into())
        );
    }
}

#[test]
fn columns_belong_to_a_frame_and_grow_with_the_fleet() {
    let fleet = fleet();
    let mut producer = ProducerPorts::create(&fleet, 3).unwrap();
    let mut subscriber = Subscriber::open(&fleet).unwrap();
    let plugin = Participant::join(&fleet, "plugin").unwrap();
    let mut column = ColumnPublisher::open_on(&plugin, "risk").unwrap();
    let error = ColumnPublisher::open_on(&plugin, "risk").unwrap_err().to_string();
    assert!(error.contains("already published"), "{error}");
    for (tick, robots) in [(1, 3), (2, 40_000)] {
        publish(&producer, tick, robots);
        let frame = subscriber.latest().unwrap().unwrap();
        let values: Vec<f32> = (0..robots).map(|robot| robot as f32).collect();
        let error = column.publish(&frame, &values[1..]).unwrap_err();
        assert_eq!(error, PublishError::ColumnLength { values: robots - 1, robots });
        column.publish(&frame, &values).unwrap();
        // One that joins late, too.
        let mut reader = ColumnReader::open_on(&plugin, "risk").unwrap();
        column.update();
        let read = reader.latest().unwrap().unwrap();
        assert_eq!(
            (read.header.tick, read.header.run_id, read.values),
            (tick, frame.run_id(), &values[..])
        );
    }
    producer.publish_column(TYPE.name(), 0, &[0.0, 1.0, 0.0]).unwrap();
    let mut types = ColumnReader::open_on(&plugin, TYPE.name()).unwrap();
    producer.update();
    assert_eq!(types.latest().unwrap().unwrap().values, [0.0, 1.0, 0.0]);
    let names: Vec<_> = column_names(&fleet).iter().map(ToString::to_string).collect();
    assert_eq!(names, ["risk", "type"]);
}

#[test]
fn a_reader_for_all_gets_every_column_and_is_told_what_it_missed() {
    let fleet = fleet();
    let mut producer = ProducerPorts::create(&fleet, 1).unwrap();
    let plugin = Participant::join(&fleet, "plugin").unwrap();
    let mut all = ColumnReader::open_for_all_on(&plugin, TYPE.name()).unwrap();
    let mut newest = ColumnReader::open_on(&plugin, TYPE.name()).unwrap();
    let mut publish = |ticks: std::ops::RangeInclusive<u64>| {
        for tick in ticks {
            producer.publish_column(TYPE.name(), tick, &[0.5]).unwrap();
        }
    };
    let mut take_all = || {
        let mut taken = Vec::new();
        while let Some(column) = all.take_next().unwrap() {
            taken.push((column.header.tick, column.missed));
        }
        taken
    };
    publish(1..=3);
    assert_eq!(take_all(), [(1, 0), (2, 0), (3, 0)]);
    let late = 4 + services::COLUMN_BUFFER as u64 + 5;
    publish(4..=late);
    let taken = take_all();
    assert_eq!(
        (taken.len(), taken[0], taken.last()),
        (services::COLUMN_BUFFER, (late - 7, 6), Some(&(late, 0)))
    );
    let column = newest.latest().unwrap().unwrap();
    assert_eq!((column.header.tick, column.header.sequence), (late, late));
    assert!(newest.latest().unwrap().is_none());
}

#[test]
fn lockstep_waits_for_those_named_and_names_those_missing() {
    let fleet = fleet();
    let mut producer = ProducerPorts::create(&fleet, 1).unwrap();
    let names = ["planner".to_owned(), "recorder".to_owned()];
    let planner = Reporter::open_on(&Participant::join(&fleet, "planner").unwrap()).unwrap();
    planner.done(producer.run_id(), 1).unwrap();
    let timeout = Duration::from_millis(50);
    let error = producer.wait_done(&names, 1, timeout).unwrap_err();
    let missing = vec!["recorder".to_owned()];
    assert_eq!(error, LockstepError::Timeout { tick: 1, timeout, missing });
    let recorder = Reporter::open_on(&Participant::join(&fleet, "recorder").unwrap()).unwrap();
    recorder.done(producer.run_id() + 1, 1).unwrap();
    assert!(producer.wait_done(&names, 1, timeout).is_err(), "a report of another run");
    recorder.done(producer.run_id(), 1).unwrap();
    producer.wait_done(&names, 1, timeout).unwrap();
    producer.wait_done(&[], 2, timeout).unwrap();
    planner.leave(producer.run_id()).unwrap();
    recorder.done(producer.run_id(), 7).unwrap();
    producer.wait_done(&names, 7, timeout).unwrap();
    planner.done(producer.run_id(), 7).unwrap();
    assert!(producer.wait_done(&names, 8, timeout).is_err(), "it is back");
}

#[test]
fn the_longest_names_of_fleet_and_plugin_go_together() {
    let fleet: FleetName =
        format!("{:x<64}", format!("test-long-{}", std::process::id())).parse().unwrap();
    let participant = Participant::join(&fleet, &"p".repeat(64)).unwrap();
    assert_eq!(participant.name().len(), 64);
    Subscriber::open_on(&participant).unwrap();
}

#[test]
fn a_fleet_of_another_contract_version_is_refused_naming_both() {
    let fleet = fleet();
    let node = NodeBuilder::new()
        .config(regatta_plugin::iceoryx2_config().unwrap())
        .create::<ipc::Service>()
        .unwrap();
    let version = AttributeSpecifier::new()
        .define(
            &AttributeKey::new(services::VERSION_ATTRIBUTE.as_bytes()).unwrap(),
            &AttributeValue::new(b"999").unwrap(),
        )
        .unwrap();
    let name = |service: &str| ServiceName::new(&services::service_name(&fleet, service)).unwrap();
    // The same types, so that only the attribute differs; and another type, which iceoryx2 finds by
    // itself.
    let _frames = node
        .service_builder(&name("frames"))
        .publish_subscribe::<[Line]>()
        .user_header::<FrameHeader>()
        .create_with_attributes(&version)
        .unwrap();
    let _commands = node
        .service_builder(&name("commands"))
        .publish_subscribe::<u64>()
        .create_with_attributes(&version)
        .unwrap();
    let errors = [
        ProducerPorts::create(&fleet, 1).unwrap_err(),
        Subscriber::open(&fleet).unwrap_err(),
        Commands::open(&fleet).unwrap_err(),
    ];
    for error in errors {
        assert!(
            matches!(&error, OpenError::OtherVersion { theirs, .. } if theirs == "999"),
            "{error}"
        );
        let text = error.to_string();
        assert!(
            text.contains("version 999") && text.contains(&format!("version {CONTRACT_VERSION}")),
            "{text}"
        );
        assert_eq!(text.lines().count(), 1);
    }
}
