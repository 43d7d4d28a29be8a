//! Encoded messages are decoded bit for bit, both by this crate and by prost's generated decoder.

use proptest::prelude::*;
use prost::Message;
use regatta_plugin::column::ColumnHeader;
use regatta_plugin::command::CommandRecord;
use regatta_plugin::command_log::CommandLogHeader;
use regatta_plugin::contact::{ContactEvent, ContactEventHeader, ContactHeader, ContactRecord};
use regatta_plugin::event::{EventHeader, EventRecord};
use regatta_plugin::frame::{ColumnsMut, FrameHeader, Line, frame_lines, stride_lines};
use regatta_plugin::order::{OrderHeader, OrderKind, OrderRecord, StopAction};
use regatta_plugin::world::{
    CurveRecord, DoorRecord, EdgeRecord, LiftRecord, NodeRecord, Orientation, OtherNameRecord,
    RobotTypeRecord, Role, StationRecord, WorldData, ZoneRecord,
};
use regatta_plugin::{ColumnValues, CommandLog, ContactEvents, Events, Frame, Orders};

use crate::decode::{self, MessageError};
use crate::encode;
use crate::recorded::{RecordedColumn, RecordedFrame};
use crate::schema::regatta;

/// Returns a header, lines with arbitrary bits (including NaN), and the message of their frame.
fn recorded(words: &[u32], robots: usize) -> (FrameHeader, Vec<Line>, Vec<u8>) {
    let mut lines = vec![Line::default(); frame_lines(robots)];
    let target: &mut [u32] = bytemuck::cast_slice_mut(&mut lines);
    target
        .iter_mut()
        .zip(words.iter().cycle())
        .enumerate()
        .for_each(|(i, (to, word))| *to = word.rotate_left(i as u32));
    let header = FrameHeader {
        run_id: 7,
        tick: 123_456,
        sim_time_nanos: 9,
        late_ticks: 1,
        speed: f32::INFINITY,
        clock: 1,
        robots: robots as u32,
        stride_lines: stride_lines(robots) as u32,
        ..FrameHeader::default()
    };
    let message = encode::frame(&Frame::new(&header, &lines).expect("a frame"));
    (header, lines, message)
}

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|value| value.to_bits()).collect()
}

proptest! {
    #[test]
    fn frames_are_decoded_bit_for_bit(words in prop::collection::vec(any::<u32>(), 1..200), robots in 0_usize..500) {
        let (header, lines, message) = recorded(&words, robots);
        let frame = RecordedFrame::parse(&message).unwrap();
        prop_assert_eq!(FrameHeader { stride_lines: header.stride_lines, ..frame.header }, header);
        let mut copied = vec![Line::default(); frame_lines(robots)];
        frame.copy_to(&mut ColumnsMut::split(&mut copied, robots));
        let (original, copy) = (Frame::new(&header, &lines).unwrap(), Frame::new(&header, &copied).unwrap());
        for (one, other) in [
            (original.x(), copy.x()),
            (original.y(), copy.y()),
            (original.theta(), copy.theta()),
            (original.speed(), copy.speed()),
            (original.s(), copy.s()),
        ] {
            prop_assert_eq!(bits(one), bits(other));
        }
        prop_assert_eq!((original.edge(), original.state()), (copy.edge(), copy.state()));
        for robot in 0..robots {
            let row = frame.row(robot).unwrap();
            prop_assert_eq!([row.x.to_bits(), row.s.to_bits()], [original.x()[robot].to_bits(), original.s()[robot].to_bits()]);
            prop_assert_eq!((row.edge, row.state), (original.edge()[robot], original.state()[robot]));
        }
        prop_assert!(frame.row(robots).is_none());
    }

    #[test]
    fn frames_follow_their_schema(words in prop::collection::vec(any::<u32>(), 1..200), robots in 0_usize..100) {
        let (header, lines, message) = recorded(&words, robots);
        let frame = Frame::new(&header, &lines).unwrap();
        let plain = regatta::Frame::decode(&message[..]).unwrap();
        prop_assert_eq!((plain.tick, plain.robots as usize, plain.clock), (123_456, robots, 1));
        prop_assert_eq!(bits(&plain.theta), bits(frame.theta()));
        prop_assert_eq!((&plain.edge[..], &plain.state[..]), (frame.edge(), frame.state()));
    }

    #[test]
    fn damaged_frames_are_rejected_or_complete(robots in 1_usize..60, cut in any::<prop::sample::Index>(), bit in 0..8) {
        let (_, _, mut message) = recorded(&[1, 2, 3], robots);
        let at = cut.index(message.len());
        // A message that is cut off before its number of robots decodes as a frame without robots.
        prop_assert!(RecordedFrame::parse(&message[..at]).map_or(true, |frame| frame.len() == 0));
        message[at] ^= 1_u8 << bit;
        if let Ok(frame) = RecordedFrame::parse(&message) {
            let mut lines = vec![Line::default(); frame_lines(frame.len())];
            frame.copy_to(&mut ColumnsMut::split(&mut lines, frame.len()));
        }
    }

    #[test]
    fn columns_are_decoded_bit_for_bit(words in prop::collection::vec(any::<u32>(), 0..300)) {
        let values: Vec<_> = words.iter().map(|word| f32::from_bits(*word)).collect();
        let header = ColumnHeader { run_id: 3, tick: 8, robots: values.len() as u32, ..ColumnHeader::default() };
        let message = encode::column(&ColumnValues { header: &header, values: &values, missed: 0 });
        let column = RecordedColumn::parse(&message).unwrap();
        prop_assert_eq!((column.tick, bits(&column.values())), (8, words.clone()));
        prop_assert_eq!(bits(&regatta::Column::decode(&message[..]).unwrap().values), words);
    }
}

#[test]
fn a_column_whose_length_differs_from_the_frame_is_rejected() {
    let (_, _, mut message) = recorded(&[5], 3);
    // A later field replaces an earlier one: this is a second column x, with one value.
    message.extend_from_slice(&[0x82, 0x01, 4, 0, 0, 0, 0]);
    assert_eq!(
        RecordedFrame::parse(&message).unwrap_err(),
        MessageError::ColumnLength { bytes: 4, robots: 3 }
    );
}

#[test]
fn events_and_commands_are_decoded_as_they_were_encoded() {
    let flat = EventRecord { kind: 13, robot: 4, detail: 1, ..EventRecord::default() };
    let records = [
        EventRecord { token: 1, kind: 7, robot: 2, id: 3, detail: 5 },
        flat,
        EventRecord::default(),
    ];
    let header = EventHeader { run_id: 1, tick: 40, dropped: 2, sequence: 9 };
    let message = encode::events(&Events { header: &header, records: &records, missed: 4 });
    let (decoded, events) = decode::events(&message).unwrap();
    assert_eq!((decoded.tick, decoded.dropped, &events[..]), (40, 2, &records[..]));

    let record = CommandRecord {
        token: u64::MAX,
        kind: 1,
        robot: 4,
        legs: 1,
        id: 5,
        reverse: 1,
        released: 1,
        robot_type: 6,
        s: 0.5,
    };
    let header = CommandLogHeader { run_id: 1, tick: 41, sequence: 1 };
    let message = encode::commands(&CommandLog { header: &header, records: &[record], missed: 0 });
    assert_eq!(decode::commands(&message).unwrap(), (1, 41, vec![record]));
}

#[test]
fn orders_are_decoded_as_they_were_encoded() {
    let stop =
        OrderRecord::new(u64::MAX, OrderKind::Handled).of_robot(4).at_stop(1, 9, StopAction::Park);
    let records = [
        OrderRecord { dwell_secs: 2.5, detail: 3, due_secs: 60.0, ..stop },
        OrderRecord::default(),
    ];
    let header = OrderHeader { run_id: 1, tick: 42, dropped: 5, sequence: 3 };
    let message = encode::orders(&Orders { header: &header, records: &records, missed: 6 });
    assert_eq!(decode::orders(&message).unwrap(), (header, records.to_vec(), 6));
}

#[test]
fn contacts_are_decoded_as_they_were_encoded() {
    let pair = ContactRecord {
        since_tick: 1,
        since_nanos: 2,
        robots: [3, 4],
        level: 2,
        edge: 5,
        x: 0.25,
        y: -1.0,
        relative_speed: 3.0,
        reserved: 0,
    };
    let header = ContactHeader {
        tick: 9,
        touching_ever: 8,
        touching: 1,
        capped: 1,
        ..ContactHeader::default()
    };
    let message = encode::contacts(&header, &[pair], 7).encode_to_vec();
    let update = regatta::ContactUpdate::decode(&message[..]).unwrap();
    let pairs: Vec<_> = update.added.iter().map(decode::contact).collect();
    assert_eq!((decode::contact_header(&update), pairs, update.number), (header, vec![pair], 7));
    let whole = regatta::Contacts::decode(&message[..]).unwrap();
    assert_eq!((whole.touching_ever, whole.number, whole.pairs), (8, 7, update.added));

    let event = ContactEvent {
        tick: 9,
        robots: [3, 4],
        level: 1,
        change: 2,
        x: 7.0,
        ..ContactEvent::default()
    };
    let header = ContactEventHeader { run_id: 1, tick: 9, sequence: 2 };
    let message =
        encode::contact_events(&ContactEvents { header: &header, records: &[event], missed: 0 });
    assert_eq!(decode::contact_events(&message).unwrap(), (1, 9, vec![event]));
}

/// Returns a world with an edge of two curves, texts, an orientation and an origin.
fn world() -> WorldData {
    let mut world = WorldData { origin: [3.5e6, -5.25e6], ..WorldData::default() };
    let (name, level, zone) =
        (world.texts.add("dock 1"), world.texts.add("ground floor"), world.texts.add("north"));
    world.nodes = vec![
        NodeRecord {
            id: 1,
            x: 1.0,
            name,
            level,
            role: Role::Charge as u32,
            ..NodeRecord::default()
        },
        NodeRecord { id: 2, level, zone, ..NodeRecord::default() },
    ];
    let edge = EdgeRecord {
        id: 7,
        length: 5.0,
        destination: 1,
        speed: 1.5,
        zone,
        ..EdgeRecord::default()
    };
    let line = CurveRecord::straight;
    world.add_edge(
        edge.with_orientation(Orientation::Offset(1.5)),
        [line([0.0; 2], [2.0, 0.0]), line([2.0, 0.0], [2.0, 3.0])],
    );
    world.add_edge(EdgeRecord { id: 8, ..edge }, [line([0.0; 2], [1.0, 1.0])]);
    world.robot_types = vec![RobotTypeRecord {
        max_rotation_speed: 0.5,
        battery_capacity: 90.0,
        ..RobotTypeRecord::new("tug", 1.2, 0.8)
    }];
    let name = world.texts.add("block");
    world.add_zone(ZoneRecord { name, capacity: 2, ..ZoneRecord::default() }, [0], [0]);
    world.add_zone(ZoneRecord { rule: 1, ..ZoneRecord::default() }, [], [0]);
    let name = world.texts.add("gate");
    let line = [[1.0, -1.0], [1.0, 1.0]];
    world.add_door(DoorRecord { name, opening_secs: 3.0, line, ..DoorRecord::default() }, [0, 1]);
    let [name, level] = ["north", "L1"].map(|name| world.texts.add(name));
    let lift = LiftRecord { name, capacity: 2, level_secs: 8.0, yaw: 0.5, ..LiftRecord::default() };
    world.add_lift(lift, [(level, vec![0])], [1]);
    let name = world.texts.add("Storage 01");
    world.other_names.push(OtherNameRecord { name, node: 0 });
    let station =
        StationRecord { name, level, x: 1.5, y: -2.0, role: 5, ..StationRecord::default() };
    world.add_station(station, [1, 0]);
    world.add_background_line(level, [[0.0, 0.0], [9.0, 0.0], [9.0, 4.0]]);
    world.add_background_line(0, [[1.0, 1.0], [2.0, 2.0]]);
    world
}

#[test]
fn a_world_is_decoded_as_it_was_encoded() {
    let data = world();
    let decoded = decode::world(&encode::world(&data.view(9, 1))).unwrap();
    assert_eq!((decoded.run_id, decoded.is_repeated), (9, false));
    assert_eq!(decoded.data.edges, data.edges);
    assert_eq!(decoded.data, data);
}

#[test]
fn a_world_of_an_older_recording_has_one_curve_per_edge() {
    let numbers: Vec<_> = (0..8_u8).map(f32::from).collect();
    let edge =
        regatta::Edge { id: 7, length: 5.0, control_points: numbers, ..regatta::Edge::default() };
    let robot_type =
        regatta::RobotType { name: "tug".into(), max_speed: 2.0, ..regatta::RobotType::default() };
    let world = regatta::World {
        run_id: 9,
        edges: vec![edge],
        robot_types: vec![robot_type],
        ..regatta::World::default()
    };
    let data = decode::world(&world.encode_to_vec()).unwrap().data;
    let view = data.view(9, 1);
    let curves = view.curves(&view.edges()[0]);
    assert_eq!(
        curves,
        [CurveRecord { control_points: [[0.0, 1.0], [2.0, 3.0], [4.0, 5.0], [6.0, 7.0]] }]
    );
    assert_eq!((view.edges()[0].orientation(), view.origin()), (Orientation::Tangential, [0.0; 2]));
    let robot_type = view.robot_types()[0];
    assert_eq!(
        (robot_type.max_rotation_speed, robot_type.max_rotation_acceleration),
        (0.0, f32::INFINITY)
    );
}
