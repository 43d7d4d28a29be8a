//! Contacts, the command log and the order log, there and back.

use std::sync::atomic::{AtomicU32, Ordering};

use regatta_plugin::ProducerPorts;
use regatta_plugin::command::{CommandKind, CommandRecord};
use regatta_plugin::contact::{
    ContactChange, ContactEvent, ContactHeader, ContactLevel, ContactRecord,
};
use regatta_plugin::order::{OrderKind, OrderRecord, StopAction};
use regatta_plugin::world::WorldData;
use regatta_plugin::{
    CommandLogReader, ContactEventReader, ContactPublisher, ContactReader, FleetName, OpenError,
    OrderPublisher, OrderReader, Participant, ReadError, services,
};

static NEXT: AtomicU32 = AtomicU32::new(0);

/// A fleet name that no other test has.
fn fleet() -> FleetName {
    format!("contacts-{}-{}", std::process::id(), NEXT.fetch_add(1, Ordering::Relaxed))
        .parse()
        .unwrap()
}

fn pair(a: u32, b: u32) -> ContactRecord {
    ContactRecord {
        robots: [a, b],
        level: ContactLevel::Touching as u32,
        ..ContactRecord::default()
    }
}

#[test]
fn a_late_reader_gets_all_pairs_and_nobody_else_may_publish_them() {
    let participant = Participant::join(&fleet(), "checker").unwrap();
    let mut publisher = ContactPublisher::open_on(&participant).unwrap();
    let pairs: Vec<_> = (0..1_000).map(|robot| pair(robot, robot + 1)).collect();
    publisher
        .publish(&ContactHeader { tick: 7, touching: 1_000, ..ContactHeader::default() }, &pairs)
        .unwrap();

    let mut reader = ContactReader::open_on(&participant).unwrap();
    publisher.update();
    let contacts = reader.latest().unwrap().expect("contacts");
    assert_eq!((contacts.header.tick, contacts.header.touching), (7, 1_000));
    assert_eq!(contacts.pairs, pairs);
    assert!(reader.latest().unwrap().is_none(), "read already");
    assert_eq!(reader.current().expect("kept").header.tick, 7);

    publisher.publish(&ContactHeader { tick: 8, ..ContactHeader::default() }, &[]).unwrap();
    assert!(reader.latest().unwrap().expect("contacts").pairs.is_empty());
    assert!(matches!(ContactPublisher::open_on(&participant), Err(OpenError::Taken { .. })));
    assert!(reader.has_publisher());
}

#[test]
fn changes_arrive_in_order_and_gaps_are_told() {
    let participant = Participant::join(&fleet(), "checker").unwrap();
    let mut publisher = ContactPublisher::open_on(&participant).unwrap();
    let mut reader = ContactEventReader::open_on(&participant).unwrap();
    let last = 10 + services::EVENT_BUFFER as u64;
    for tick in 1..=last {
        let began =
            ContactEvent { tick, change: ContactChange::Began as u32, ..ContactEvent::default() };
        publisher.publish_events(3, tick, &[began]).unwrap();
    }
    let mut seen = Vec::new();
    reader
        .take(|events| {
            assert_eq!((events.header.run_id, events.records.len()), (3, 1));
            seen.push((events.records[0].tick, events.missed));
            Ok::<_, ReadError>(())
        })
        .unwrap();
    // The first ten overflowed; which run they belonged to, nobody can know.
    assert_eq!(
        seen.iter().map(|(tick, _)| *tick).collect::<Vec<_>>(),
        (11..=last).collect::<Vec<_>>()
    );
}

#[test]
fn the_command_log_tells_what_was_taken_and_when() {
    let fleet = fleet();
    let mut producer = ProducerPorts::create(&fleet, 1).unwrap();
    assert!(!producer.has_command_log_readers());
    let mut reader =
        CommandLogReader::open_on(&Participant::join(&fleet, "recorder").unwrap()).unwrap();
    assert!(producer.has_command_log_readers());
    let hold =
        CommandRecord { kind: CommandKind::Hold as u32, robot: 5, ..CommandRecord::default() };
    producer.publish_command_log(9, &[hold; 100]).unwrap();
    let mut seen = Vec::new();
    reader
        .take(|log| {
            seen.push((log.header.run_id, log.header.tick, log.records.to_vec()));
            Ok::<_, ReadError>(())
        })
        .unwrap();
    assert_eq!(seen, [(producer.run_id(), 9, vec![hold; 100])]);
}

#[test]
fn the_order_log_is_read_tick_by_tick_and_has_one_writer() {
    let fleet = fleet();
    let mut publisher =
        OrderPublisher::open_on(&Participant::join(&fleet, "manager").unwrap()).unwrap();
    assert!(!publisher.has_readers());
    let second = OrderPublisher::open_on(&Participant::join(&fleet, "second").unwrap());
    assert!(matches!(second, Err(OpenError::Taken { .. })));
    let mut reader =
        OrderReader::open_on(&Participant::join(&fleet, "validator").unwrap()).unwrap();
    assert!(publisher.has_readers());
    let record = |tick| {
        OrderRecord::new(tick, OrderKind::Handled).of_robot(5).at_stop(1, 9, StopAction::Drop)
    };
    let last = 10 + services::EVENT_BUFFER as u64;
    for tick in 1..=last {
        publisher.publish(7, tick, u64::from(tick == last), &[record(tick); 100]).unwrap();
    }
    let mut seen = Vec::new();
    let mut last_dropped = 0;
    reader
        .take(|orders| {
            assert_eq!(
                (orders.header.run_id, orders.records),
                (7, &[record(orders.header.tick); 100][..])
            );
            seen.push(orders.header.tick);
            last_dropped = orders.header.dropped;
            Ok::<_, ReadError>(())
        })
        .unwrap();
    assert_eq!(
        (seen, last_dropped),
        ((11..=last).collect::<Vec<_>>(), 1),
        "the first ten overflowed"
    );
    publisher.publish(7, last + 1, 0, &[]).unwrap();
    let mut next = None;
    reader
        .take(|orders| {
            next = Some((orders.header.tick, orders.missed));
            Ok::<_, ReadError>(())
        })
        .unwrap();
    assert_eq!(next, Some((last + 1, 0)));
}

#[test]
fn another_run_has_another_id_and_counts_its_worlds_afresh() {
    let mut producer = ProducerPorts::create(&fleet(), 1).unwrap();
    let first = producer.run_id();
    assert_eq!(producer.publish_world(&WorldData::default()).unwrap(), 1);
    producer.begin_run();
    assert_ne!(producer.run_id(), first);
    assert_eq!(producer.loan(1).unwrap().header_mut().run_id, producer.run_id());
    assert_eq!(producer.publish_world(&WorldData::default()).unwrap(), 1);
}
