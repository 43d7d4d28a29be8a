//! A fleet has two homes, shared memory and the memory of one process: ports behave alike in both.

use std::collections::BTreeSet;

use regatta_plugin::command::{Authority, CommandRecord};
use regatta_plugin::event::EventRecord;
use regatta_plugin::route::{RouteRequest, RouteResponse};
use regatta_plugin::services::{CHUNKS_IN_USE, COLUMN_BUFFER, COMMAND_BUFFER, EVENT_BUFFER};
use regatta_plugin::world::{NodeRecord, WorldData};
use regatta_plugin::{
    ColumnPublisher, ColumnReader, CommandError, Commands, EventReader, LocalFleet, OpenError,
    OrderPublisher, Ownership, Participant, ProducerPorts, ReadError, RouteClient, RouteServer,
    Subscriber, WorldReader,
};

use crate::common::{fleet, publish};

/// A fleet, to be joined under a name.
type Home = Box<dyn Fn(&str) -> Participant>;

/// An empty fleet in each home.
fn homes() -> [Home; 2] {
    let (shared, local) = (fleet(), LocalFleet::new(fleet()));
    [
        Box::new(move |name| Participant::join(&shared, name).unwrap()),
        Box::new(move |name| local.join(name)),
    ]
}

/// Returns the commands that have arrived, each with the authority of its sender.
fn authorities(producer: &mut ProducerPorts) -> Vec<(u64, Authority)> {
    let mut taken = Vec::new();
    producer
        .take_commands(|_, authority, records| taken.push((records[0].token, authority)))
        .unwrap();
    taken
}

#[test]
fn one_participant_owns_the_movement_until_it_ends() {
    for join in homes() {
        let mut producer = ProducerPorts::create_on(join("producer"), 1).unwrap();
        let (manager, other) = (join("manager"), join("other"));
        let mut own = Commands::open_on(&manager).unwrap();
        let mut foreign = Commands::open_on(&other).unwrap();
        let mut send_both = || {
            let tokens = (own.cancel(0), foreign.cancel(0));
            own.send().unwrap();
            foreign.send().unwrap();
            tokens
        };
        let (a, b) = send_both();
        assert_eq!(producer.owner(), None);
        assert_eq!(authorities(&mut producer), [(a, Authority::Full), (b, Authority::Full)]);

        let ownership = Ownership::claim(&manager).unwrap();
        let (a, b) = send_both();
        assert_eq!(
            authorities(&mut producer),
            [(a, Authority::Full), (b, Authority::WithoutMovement)]
        );
        let owner = producer.owner().unwrap().to_owned();
        assert!(owner.starts_with("manager"), "{owner}");
        let error = Ownership::claim(&other).unwrap_err();
        assert!(matches!(&error, OpenError::Owned { owner: named, .. } if *named == owner));

        drop(ownership);
        let (a, b) = send_both();
        assert_eq!(authorities(&mut producer), [(a, Authority::Full), (b, Authority::Full)]);
        let _ownership = Ownership::claim(&other).unwrap();
    }
}

#[test]
fn a_slow_reader_loses_the_oldest_samples_and_gets_their_number() {
    for join in homes() {
        let mut producer = ProducerPorts::create_on(join("producer"), 1).unwrap();
        let mut columns = ColumnReader::open_for_all_on(&join("reader"), "load").unwrap();
        producer.publish_column("load", 0, &[0.0]).unwrap();
        assert_eq!(columns.take_next().unwrap().unwrap().values, [0.0]);
        for tick in 1..=COLUMN_BUFFER as u64 + 3 {
            producer.publish_column("load", tick, &[tick as f32]).unwrap();
        }
        let oldest = columns.take_next().unwrap().unwrap();
        assert_eq!((oldest.values, oldest.missed), (&[4.0][..], 3));
        let newest = columns.latest().unwrap().unwrap();
        let skipped = COLUMN_BUFFER as u64 - 2;
        assert_eq!((newest.header.tick, newest.missed), (COLUMN_BUFFER as u64 + 3, skipped));
    }
}

#[test]
fn a_reader_of_events_loses_the_oldest_ticks_and_gets_their_number() {
    for join in homes() {
        let mut producer = ProducerPorts::create_on(join("producer"), 1).unwrap();
        let mut events = EventReader::open_on(&join("reader")).unwrap();
        let mut ticks = Vec::new();
        for tick in 0..=EVENT_BUFFER as u64 + 5 {
            producer.publish_events(tick, 0, &[EventRecord::default()]).unwrap();
            if tick == 0 {
                events.take(|_| Ok::<_, ReadError>(())).unwrap();
            }
        }
        events
            .take(|events| {
                ticks.push((events.header.tick, events.missed));
                Ok::<_, ReadError>(())
            })
            .unwrap();
        assert_eq!((ticks.len(), ticks[0], ticks[1]), (EVENT_BUFFER, (6, 5), (7, 0)));
        assert_eq!(events.lost(), 5);
    }
}

#[test]
fn commands_without_room_are_refused_and_the_others_kept() {
    for join in homes() {
        let mut producer = ProducerPorts::create_on(join("producer"), 1).unwrap();
        let mut commands = Commands::open_on(&join("sender")).unwrap();
        for robot in 0..COMMAND_BUFFER as u32 {
            commands.hold(robot);
            commands.send().unwrap();
        }
        commands.hold(1_000);
        let fleet = producer.participant().fleet().clone();
        assert_eq!(commands.send(), Err(CommandError::Full { fleet }));
        let robots = taken(&mut producer).into_iter().map(|command| command.robot);
        assert!(robots.eq(0..COMMAND_BUFFER as u32), "all of them, in the order of sending");
        commands.send().unwrap();
        assert_eq!(taken(&mut producer)[0].robot, 1_000);
    }
}

fn taken(producer: &mut ProducerPorts) -> Vec<CommandRecord> {
    let mut taken = Vec::new();
    producer.take_commands(|_, _, records| taken.extend_from_slice(records)).unwrap();
    taken
}

#[test]
fn a_second_publisher_is_refused_until_the_first_has_left() {
    for join in homes() {
        let producer = ProducerPorts::create_on(join("producer"), 1).unwrap();
        let error = ProducerPorts::create_on(join("second"), 1).unwrap_err();
        assert!(matches!(error, OpenError::AlreadyRunning { .. }), "{error}");
        drop(producer);
        ProducerPorts::create_on(join("third"), 1).unwrap();

        let column = ColumnPublisher::open_on(&join("first"), "load").unwrap();
        let error = ColumnPublisher::open_on(&join("second"), "load").unwrap_err();
        assert!(matches!(error, OpenError::ColumnTaken { .. }), "{error}");
        drop(column);
        ColumnPublisher::open_on(&join("third"), "load").unwrap();

        let _orders = OrderPublisher::open_on(&join("first")).unwrap();
        let error = OrderPublisher::open_on(&join("second")).unwrap_err();
        assert!(matches!(error, OpenError::Taken { .. }), "{error}");

        let _routes = RouteServer::open_on(&join("first")).unwrap();
        let error = RouteServer::open_on(&join("second")).unwrap_err();
        assert!(matches!(error, OpenError::Full { limit: 1, .. }), "{error}");
    }
}

#[test]
fn a_late_joiner_gets_the_newest_frame_world_and_column() {
    for join in homes() {
        let mut producer = ProducerPorts::create_on(join("producer"), 2).unwrap();
        for nodes in [3, 5] {
            let nodes = vec![NodeRecord::default(); nodes];
            producer.publish_world(&WorldData { nodes, ..WorldData::default() }).unwrap();
        }
        for tick in 1..=4 {
            producer.publish_column("load", tick, &[tick as f32, 0.5]).unwrap();
            publish(&producer, tick, 2);
        }
        let late = join("late");
        let mut frames = Subscriber::open_on(&late).unwrap();
        let mut worlds = WorldReader::open_on(&late).unwrap();
        let mut column = ColumnReader::open_on(&late, "load").unwrap();
        producer.update();
        assert_eq!(frames.latest().unwrap().unwrap().x(), [4.0, 5.0]);
        assert_eq!(worlds.latest().unwrap().unwrap().nodes().len(), 5);
        assert_eq!(column.latest().unwrap().unwrap().values, [4.0, 0.5]);
        assert!(frames.latest().unwrap().is_none(), "returned already");
    }
}

#[test]
fn a_request_is_answered_once_and_only_by_a_server() {
    for join in homes() {
        let client = RouteClient::open_on(&join("client")).unwrap();
        assert!(client.ask(1).is_err(), "nobody answers");
        let mut server = RouteServer::open_on(&join("server")).unwrap();
        let pending = [client.ask(4).unwrap(), client.ask(5).unwrap()];
        assert!(client.answer(&pending[0]).unwrap().is_none(), "not answered yet");
        let mut asked = Vec::new();
        let answer = |request: &RouteRequest| {
            asked.push(request.robot);
            RouteResponse::unknown(1, 9, request.robot)
        };
        server.answer(100, answer).unwrap();
        assert_eq!(asked, [4, 5]);
        for (pending, robot) in pending.iter().zip([4, 5]) {
            let route = client.answer(pending).unwrap().expect("an answer");
            assert_eq!((route.robot, route.tick), (robot, 9));
        }
    }
}

#[test]
fn the_memory_of_old_frames_serves_new_ones() {
    for join in homes() {
        let producer = ProducerPorts::create_on(join("producer"), 1_000).unwrap();
        let mut frames = Subscriber::open_on(&join("reader")).unwrap();
        let mut addresses = BTreeSet::new();
        for tick in 0..100 {
            publish(&producer, tick, 1_000);
            addresses.insert(frames.latest().unwrap().unwrap().x().as_ptr());
        }
        assert!(addresses.len() <= CHUNKS_IN_USE, "{addresses:?}");
    }
}
