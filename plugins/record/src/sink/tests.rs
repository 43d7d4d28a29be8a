//! Files of a recording: each can be read by itself, and no chunk has anything that the others
//! lack.

use std::fs;
use std::path::{Path, PathBuf};

use mcap::Summary;
use prost::Message;
use regatta_plugin::ColumnValues;
use regatta_plugin::column::ColumnHeader;
use regatta_plugin::contact::ContactHeader;
use tempfile::TempDir;

use super::{Division, Payload, Settings, Sink};
use crate::arguments::Limit;
use crate::contacts::ContactList;
use crate::encode;
use crate::mcap_file::Compression;
use crate::reading::{ReadingError, Recording};
use crate::recorded::RecordedColumn;
use crate::repair::repair;
use crate::schema::{Topic, regatta};

/// The size of a robot in a frame.
const ROBOT_BYTES: usize = 25;
const SECOND: u64 = 1_000_000_000;

fn column() -> Topic {
    Topic::Column("type".parse().unwrap())
}

/// Records a world and a column once, and one frame of these many bytes and a list of contacts per
/// simulated second.
pub(crate) fn recording(folder: &Path, division: Division, frames: u64, bytes: usize) -> String {
    let settings = Settings { overwrite: false, compression: Compression::None, division };
    let mut sink = Sink::create(&folder.join("run.mcap"), settings).unwrap();
    sink.note("regatta", &[("fleet", "test".to_owned())]);
    let edge = regatta::Edge { id: 70, ..regatta::Edge::default() };
    let world = regatta::World { run_id: 1, edges: vec![edge], ..regatta::World::default() };
    sink.send(Topic::World, 0, 0, Payload::Message(world.encode_to_vec()));
    let header = ColumnHeader { run_id: 1, robots: 1, ..ColumnHeader::default() };
    let types = encode::column(&ColumnValues { header: &header, values: &[4.0], missed: 0 });
    sink.send(column(), 0, 0, Payload::Message(types));
    let robots = bytes / ROBOT_BYTES;
    for tick in 0..frames {
        let frame = regatta::Frame {
            run_id: 1,
            tick,
            robots: robots as u32,
            x: vec![1.0; robots],
            y: vec![1.0; robots],
            theta: vec![1.0; robots],
            speed: vec![1.0; robots],
            s: vec![1.0; robots],
            edge: vec![1; robots],
            state: vec![1; robots],
            ..regatta::Frame::default()
        };
        sink.send(Topic::Frames, tick * SECOND, 0, Payload::Message(frame.encode_to_vec()));
        let header = ContactHeader { run_id: 1, tick, ..ContactHeader::default() };
        let list = ContactList { header, pairs: Vec::new() };
        sink.send(Topic::Contacts, tick * SECOND, 0, Payload::Contacts(list));
    }
    let (tally, error) = sink.finish("regatta.end", &[]);
    assert!(error.is_none() && tally.lost == Default::default(), "{error:?}");
    tally.name
}

/// Returns the ticks of all frames and of all contacts. Both must have the same.
fn ticks(path: &Path) -> Vec<u64> {
    let recording = Recording::open(path).unwrap();
    let mut lists = Vec::new();
    let read = recording.contacts(|_, header, _| -> Result<(), ReadingError> {
        lists.push(header.tick);
        Ok(())
    });
    read.unwrap();
    assert_eq!(recording.count(&Topic::Frames), lists.len() as u64);
    lists
}

/// Checks that the file has the world and the column at its start and at its end.
fn assert_has_states(path: &Path) {
    let recording = Recording::open(path).unwrap();
    let start =
        recording.last_until(&Topic::Frames, u64::MAX - 1).unwrap().map_or(0, |(time, _)| time);
    for at in [recording.span().0.as_nanos() as u64 + 1, start] {
        assert!(recording.state_before(&Topic::World, at).unwrap().is_some(), "{}", path.display());
        let (_, types) = recording.state_before(&column(), at).unwrap().expect("the column");
        assert_eq!(RecordedColumn::parse(&types).unwrap().values(), [4.0]);
    }
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<_> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

#[test]
fn any_lost_chunk_costs_neither_the_world_nor_a_column() {
    let folder = TempDir::new().unwrap();
    recording(folder.path(), Division::None, 20, 1_000_000);
    let path = folder.path().join("run.mcap");
    let whole = fs::read(&path).unwrap();
    let chunks = Summary::read(&whole).unwrap().unwrap().chunk_indexes;
    assert!(chunks.len() > 5, "{} chunks", chunks.len());
    for chunk in &chunks {
        let mut bytes = whole.clone();
        let start = chunk.chunk_start_offset as usize;
        bytes[start..start + chunk.chunk_length as usize].fill(0);
        fs::write(&path, &bytes).unwrap();
        assert!(!repair(&path).unwrap().was_closed);
        assert_has_states(&path);
    }
}

#[test]
fn a_divided_recording_is_complete_and_each_file_can_be_read_by_itself() {
    for limit in [Limit::Bytes(3_000_000), Limit::Time(std::time::Duration::from_secs(3))] {
        let folder = TempDir::new().unwrap();
        let name = recording(folder.path(), Division::Split(limit), 20, 1_000_000);
        let files = files(folder.path());
        assert!(
            name.contains("run-0001.mcap to ") && (6..=7).contains(&files.len()),
            "{name}: {files:?}"
        );
        let mut all = Vec::new();
        for file in &files {
            assert_has_states(file);
            assert!(fs::metadata(file).unwrap().len() < 4_200_000, "{}", file.display());
            all.extend(ticks(file));
        }
        assert_eq!(all, (0..20).collect::<Vec<_>>());
    }
}

#[test]
fn a_ring_keeps_the_newest_part_in_one_file() {
    let folder = TempDir::new().unwrap();
    let ring = Division::Ring(Limit::Bytes(16_000_000));
    recording(folder.path(), ring, 60, 1_000_000);
    let path = folder.path().join("run.mcap");
    assert_eq!(files(folder.path()), std::slice::from_ref(&path));
    let ticks = ticks(&path);
    assert!(
        (16..=20).contains(&ticks.len()) && ticks.ends_with(&[58, 59]) && ticks.is_sorted(),
        "{ticks:?}"
    );
    assert!(repair(&path).unwrap().was_closed, "the index is right");
    assert_has_states(&path);

    let folder = TempDir::new().unwrap();
    recording(folder.path(), ring, 5, 1_000_000);
    assert_eq!(files(folder.path()), [folder.path().join("run.mcap")]);
}

#[test]
fn files_of_an_earlier_recording_are_left_alone() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("run-0002.mcap"), "precious").unwrap();
    recording(folder.path(), Division::Split(Limit::Bytes(3_000_000)), 8, 1_000_000);
    assert_eq!(fs::read_to_string(folder.path().join("run-0002.mcap")).unwrap(), "precious");
    assert!(folder.path().join("run-0003.mcap").exists());
}

#[test]
fn chunks_have_either_frames_or_contacts_or_columns() {
    let folder = TempDir::new().unwrap();
    recording(folder.path(), Division::None, 20, 1_000_000);
    let summary =
        Summary::read(&fs::read(folder.path().join("run.mcap")).unwrap()).unwrap().unwrap();
    for chunk in summary.chunk_indexes {
        let topic = |channel: &u16| Topic::from_name(&summary.channels[channel].topic).unwrap();
        let topics: Vec<_> = chunk.message_index_offsets.keys().map(topic).collect();
        // Repetitions of all states are together.
        let is_repetition = topics.iter().all(Topic::is_repeated);
        let has = |topic: Topic| usize::from(topics.contains(&topic));
        let has_contacts = usize::from(has(Topic::Contacts) + has(Topic::ContactUpdates) > 0);
        let groups = has(Topic::Frames) + has_contacts + has(column()) + has(Topic::World);
        assert!(is_repetition || groups <= 1, "{topics:?}");
    }
}
