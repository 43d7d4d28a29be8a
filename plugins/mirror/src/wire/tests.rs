use proptest::prelude::*;
use regatta_plugin::Frame;
use regatta_plugin::column::ColumnHeader;
use regatta_plugin::command::CommandRecord;
use regatta_plugin::event::{EventHeader, EventRecord};
use regatta_plugin::frame::{ColumnsMut, FrameHeader, Line, frame_lines, stride_lines};
use regatta_plugin::world::{CurveRecord, EdgeRecord, NodeRecord, RobotTypeRecord, WorldData};

use super::*;

/// Lines of a frame whose every value is a float with these bits.
fn lines_of(bits: &[u32]) -> Vec<Line> {
    let mut lines = vec![Line::default(); frame_lines(bits.len())];
    let columns = ColumnsMut::split(&mut lines, bits.len());
    for (row, &bits) in bits.iter().enumerate() {
        for column in [&mut *columns.x, columns.y, columns.theta, columns.speed, columns.s] {
            column[row] = f32::from_bits(bits);
        }
        columns.edge[row] = bits;
        columns.state[row] = bits as u8;
    }
    lines
}

fn header(robots: usize) -> FrameHeader {
    let stride_lines = stride_lines(robots) as u32;
    FrameHeader { tick: 7, robots: robots as u32, stride_lines, ..FrameHeader::default() }
}

/// Encodes a frame, and returns the lines that its message gives.
fn through(lines: &[Line], robots: usize, encoding: Encoding) -> Vec<Line> {
    let header = header(robots);
    let bytes = encode_frame(&Frame::new(&header, lines).expect("a frame"), encoding);
    let message = FrameMessage::parse(&bytes, encoding).expect("it was just encoded");
    assert_eq!((message.len(), message.header.tick), (robots, 7));
    let mut copy = vec![Line::default(); frame_lines(robots)];
    message.write(&mut ColumnsMut::split(&mut copy, robots));
    copy
}

fn world() -> WorldData {
    let mut world = WorldData { origin: [1e6, 2e6], ..WorldData::default() };
    let name = world.texts.add("dock 1");
    world.nodes = vec![NodeRecord { id: 1, name, ..NodeRecord::default() }; 2];
    let edge = EdgeRecord { id: 7, destination: 1, length: 3.0, ..EdgeRecord::default() };
    world.add_edge(edge, [CurveRecord::straight([0.0, 0.0], [3.0, 0.0])]);
    world.robot_types = vec![RobotTypeRecord::new("tug", 1.2, 0.8)];
    world
}

proptest! {
    #[test]
    fn raw_frames_keep_every_bit(bits in prop::collection::vec(any::<u32>(), 0..100)) {
        let lines = lines_of(&bits);
        let copy = through(&lines, bits.len(), Encoding::Raw);
        prop_assert_eq!(bytemuck::cast_slice::<Line, u8>(&copy), bytemuck::cast_slice::<Line, u8>(&lines));
    }

    #[test]
    fn q16_is_off_by_half_a_step_at_most(values in prop::collection::vec(-3.0_f32..3.0, 2..100)) {
        let bits: Vec<_> = values.iter().map(|value| value.to_bits()).collect();
        let robots = values.len();
        let copy = through(&lines_of(&bits), robots, Encoding::Q16);
        let header = header(robots);
        let frame = Frame::new(&header, &copy).expect("a frame");
        prop_assert_eq!((frame.edge(), frame.state()[1]), (&bits[..], bits[1] as u8));
        for (column, step) in [(frame.x(), 6.0 / 65535.0), (frame.s(), 6.0 / 65535.0),
            (frame.theta(), 1e-4), (frame.speed(), 2e-3)] {
            for (read, written) in column.iter().zip(&values) {
                prop_assert!((read - written).abs() <= 0.51 * step, "{} {}", read, written);
            }
        }
    }

    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..400), kind in 0_u32..10) {
        let mut framed = message(Kind::World, &[0_u8; 0], &[&bytes]);
        framed[8..12].copy_from_slice(&kind.to_le_bytes());
        for bytes in [&bytes, &framed] {
            read_all(bytes);
        }
    }

    #[test]
    fn changed_messages_never_panic(at in 0_usize..2_000, byte: u8, cut in 0_usize..2_000) {
        let lines = lines_of(&[0; 9]);
        let header = header(9);
        let frame = Frame::new(&header, &lines).expect("a frame");
        for mut bytes in [
            encode_frame(&frame, Encoding::Raw),
            encode_frame(&frame, Encoding::Q16),
            encode_world(&world().view(1, 1)),
        ] {
            let length = bytes.len();
            bytes[at % length] = byte;
            bytes.truncate(cut.max(1));
            read_all(&bytes);
        }
    }
}

/// Reads bytes as a message of each kind, and what is accepted into a frame of that size.
fn read_all(bytes: &[u8]) {
    for encoding in Encoding::ALL {
        if let Ok(message) = FrameMessage::parse(bytes, encoding) {
            let mut lines = vec![Line::default(); frame_lines(message.len())];
            message.write(&mut ColumnsMut::split(&mut lines, message.len()));
            message.robots_by_state();
        }
    }
    let _ = decode_world(bytes);
    let _ = decode_events(bytes);
    let _ = decode_commands(bytes);
    let _ = decode_column(bytes);
    let _ = control_request(bytes);
    let _ = control_response(bytes);
}

#[test]
fn worlds_events_columns_and_commands_are_read_as_they_were_written() {
    let data = world();
    let (header, read) = decode_world(&encode_world(&data.view(5, 3))).expect("a world");
    assert_eq!((header.run_id, header.revision), (5, 3));
    assert_eq!((read.nodes.clone(), read.edges.clone()), (data.nodes.clone(), data.edges.clone()));
    assert_eq!(read.view(1, 1).text(read.nodes[0].name), "dock 1");
    assert_eq!((read.curves, read.robot_types), (data.curves, data.robot_types));

    let events = [EventRecord { token: 4, kind: 2, robot: 9, id: 1, detail: 0 }; 2];
    let header = EventHeader { tick: 3, ..EventHeader::default() };
    let bytes = encode_events(&header, &events);
    assert_eq!(decode_events(&bytes), Ok((header, events.to_vec())));
    assert_eq!(decode_events(&bytes[..bytes.len() - 1]), Err(WireError::Length));
    assert_eq!(decode_column(&bytes), Err(WireError::OtherKind { kind: Kind::Events as u32 }));

    let header = ColumnHeader { robots: 2, tick: 4, ..ColumnHeader::default() };
    let column = decode_column(&encode_column(&header, &[1.0, 2.0])).expect("a column");
    assert_eq!((column.header, column.values), (header, vec![1.0, 2.0]));
    assert_eq!(decode_column(&encode_column(&header, &[1.0])), Err(WireError::Length));

    let command = CommandRecord { token: 1, kind: 5, robot: 3, ..CommandRecord::default() };
    assert_eq!(decode_commands(&encode_commands(&[command])), Ok(vec![command]));
}

#[test]
fn messages_of_others_are_refused_by_their_reason() {
    let lines = lines_of(&[0; 2]);
    let header = FrameHeader { robots: u32::MAX, ..header(2) };
    let mut bytes = message(Kind::RawFrame, &header, &[bytemuck::cast_slice(&lines)]);
    let too_many = WireError::TooMany { count: u32::MAX.into(), max: MAX_ROBOTS.into() };
    assert_eq!(FrameMessage::parse(&bytes, Encoding::Raw).map(|_| ()), Err(too_many));
    bytes[4] = 0xFF;
    let parsed = FrameMessage::parse(&bytes, Encoding::Raw).map(|_| ());
    assert!(matches!(parsed, Err(WireError::OtherVersion { .. })));
    assert_eq!(decode_events(b"GET / HTTP/1.1\r\n\r\n"), Err(WireError::Foreign));
}
