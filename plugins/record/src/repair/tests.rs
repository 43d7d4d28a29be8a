//! The repair of a recording that was cut off or damaged keeps every complete chunk.

use std::fs;
use std::path::Path;
use std::time::Duration;

use mcap::records::MessageHeader;
use mcap::{MessageStream, Summary};
use proptest::prelude::*;
use tempfile::TempDir;

use crate::mcap_file::{Compression, McapFile};
use crate::reading::{Recording, Selection};
use crate::repair::{RepairError, index, repair, repair_copy};
use crate::schema::Topic;

/// The bytes of the record that ends the data: opcode, length and checksum.
const DATA_END_BYTES: usize = 13;

/// Writes a recording with many small chunks, and metadata at both ends.
fn recording(folder: &Path, compression: Compression) -> Vec<u8> {
    let path = folder.join("whole.mcap");
    let file = fs::File::create(&path).unwrap();
    let mut out = McapFile::create(file, compression, 600).unwrap();
    let about =
        || mcap::records::Metadata { name: "regatta".to_owned(), metadata: Default::default() };
    out.writer.write_metadata(&about()).unwrap();
    for i in 0..150_u64 {
        let topic = [Topic::Frames, Topic::Events, Topic::Column("load".parse().unwrap())]
            [i as usize % 3]
            .clone();
        let header =
            MessageHeader { channel_id: 0, sequence: 0, log_time: i * 10, publish_time: i };
        out.write(&topic, header, &[i as u8; 37]).unwrap();
    }
    out.writer.write_metadata(&about()).unwrap();
    out.writer.finish().unwrap();
    fs::read(path).unwrap()
}

/// Returns the log times of all messages in the order of the file.
fn times(bytes: &[u8]) -> Vec<u64> {
    MessageStream::new(bytes).unwrap().map(|message| message.unwrap().log_time).collect()
}

/// Cuts a recording to its first `length` bytes, repairs it, and compares the result with the whole
/// recording.
fn cut_and_repair(folder: &Path, whole: &[u8], length: usize) {
    let path = folder.join("cut.mcap");
    fs::write(&path, &whole[..length]).unwrap();
    let original = Summary::read(whole).unwrap().unwrap();
    let chunks = original.chunk_indexes.iter();
    let kept = chunks
        .filter(|chunk| chunk.chunk_start_offset + chunk.chunk_length <= length as u64)
        .count();
    let outcome = match repair(&path) {
        Ok(outcome) => outcome,
        // Not even the header is complete, so that no message can be lost.
        Err(RepairError::NoRecording { .. }) => {
            return assert_eq!((kept, length < 64), (0, true), "{length} bytes");
        }
        Err(error) => panic!("{length} bytes: {error}"),
    };
    assert_eq!(outcome.chunks as usize, kept, "{length} bytes");
    assert_eq!(outcome.was_closed, length == whole.len());
    let repaired = fs::read(&path).unwrap();
    let summary = Summary::read(&repaired).unwrap().expect("a summary");
    assert_eq!(summary.stats.as_ref().unwrap().message_count, outcome.messages);
    let kept_times = times(&repaired);
    assert_eq!(kept_times[..], times(whole)[..outcome.messages as usize]);
    // The indexes match the contents.
    for (repaired, original) in summary.chunk_indexes.iter().zip(&original.chunk_indexes) {
        assert_eq!(repaired, original, "{length} bytes");
    }
    for chunk in &summary.chunk_indexes {
        // A chunk with definitions only has no indexes.
        let indexes = summary.read_message_indexes(&repaired, chunk).unwrap_or_default();
        let indexed: usize = indexes.values().map(Vec::len).sum();
        assert_eq!(indexed, summary.stream_chunk(&repaired, chunk).unwrap().count());
    }
    assert!(repair(&path).unwrap().was_closed, "a second repair has nothing to do");
}

#[test]
fn every_cut_around_the_last_chunks_and_the_summary_is_repaired() {
    let folder = TempDir::new().unwrap();
    let whole = recording(folder.path(), Compression::Lz4);
    let chunks = Summary::read(&whole).unwrap().unwrap().chunk_indexes;
    assert!(chunks.len() > 8, "{} chunks", chunks.len());
    let from = chunks[chunks.len() - 2].chunk_start_offset as usize;
    // Every byte of the last chunks, but only some of the summary, which repeats long definitions.
    let cuts = (0..100)
        .chain(from..from + 1700)
        .chain((from + 1700..whole.len()).step_by(501))
        .chain([whole.len()]);
    cuts.for_each(|length| cut_and_repair(folder.path(), &whole, length));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_cut_is_repaired(cut in any::<prop::sample::Index>(), zstd in any::<bool>()) {
        let folder = TempDir::new().unwrap();
        let whole = recording(folder.path(), if zstd { Compression::Zstd } else { Compression::None });
        cut_and_repair(folder.path(), &whole, cut.index(whole.len() + 1));
    }

    #[test]
    fn chunks_before_any_damage_are_kept(at in any::<prop::sample::Index>(), bit in 0..8) {
        let folder = TempDir::new().unwrap();
        let path = folder.path().join("damaged.mcap");
        let whole = recording(folder.path(), Compression::Lz4);
        let chunks = Summary::read(&whole).unwrap().unwrap().chunk_indexes;
        let data_end = chunks.last().map_or(0, |chunk| (chunk.chunk_start_offset + chunk.chunk_length) as usize);
        // The file is cut off as well, because the repair would otherwise use its summary.
        let mut bytes = whole[..data_end].to_vec();
        let at = at.index(data_end - 64) + 64;
        bytes[at] ^= 1_u8 << bit;
        fs::write(&path, &bytes).unwrap();
        let outcome = repair(&path).unwrap();
        let before = chunks.iter().filter(|chunk| (chunk.chunk_start_offset + chunk.chunk_length) as usize <= at).count();
        prop_assert!(outcome.chunks as usize >= before);
        let repaired = fs::read(&path).unwrap();
        prop_assert!(Summary::read(&repaired).unwrap().is_some());
        prop_assert_eq!(times(&repaired)[..].len() as u64, outcome.messages);
    }
}

/// An index whose checksum was never written may say anything about its chunks.
#[test]
fn an_index_that_contradicts_the_chunks_is_written_anew() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("lies.mcap");
    let whole = recording(folder.path(), Compression::Lz4);
    let data_end = mcap::read::footer(&whole).unwrap().summary_start as usize - DATA_END_BYTES;
    let lies: [fn(&mut Summary); 5] = [
        |summary| summary.chunk_indexes[3].compressed_size += 7000,
        |summary| summary.chunk_indexes[3].chunk_length -= 1,
        |summary| {
            summary.chunk_indexes[3].message_index_offsets.pop_first();
        },
        |summary| summary.metadata_indexes[0].offset += 1,
        |summary| summary.chunk_indexes[3].compression = "zstd".to_owned(),
    ];
    for (number, lie) in lies.into_iter().enumerate() {
        let mut summary = Summary::read(&whole).unwrap().unwrap();
        lie(&mut summary);
        let end = index(&summary, data_end as u64);
        fs::write(&path, [&whole[..data_end], &end].concat()).unwrap();
        let outcome = repair(&path).unwrap();
        assert_eq!((outcome.was_closed, outcome.lost.len()), (false, 0), "lie {number}");
        let text = outcome.to_string();
        assert!(text.contains("150 messages") && text.contains("index written anew"), "{text}");
        assert_eq!(times(&fs::read(&path).unwrap()), times(&whole), "lie {number}");
        assert!(repair(&path).unwrap().was_closed, "lie {number}");
    }
}
/// Readers with and without an index lose the damaged chunk, and no other.
#[test]
fn damage_in_a_closed_recording_costs_only_the_damaged_chunk() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("damaged.mcap");
    let whole = recording(folder.path(), Compression::Lz4);
    let chunks = Summary::read(&whole).unwrap().unwrap().chunk_indexes;
    // The first chunks contain definitions, without which a reader without an index fails.
    for number in [4, 7, chunks.len() - 1] {
        let chunk = &chunks[number];
        let start = chunk.chunk_start_offset as usize;
        // The opcode, the length, the header and the compressed content.
        for at in [0, 1, 6, 40, chunk.chunk_length as usize / 2] {
            let mut bytes = whole.clone();
            bytes[start + at] ^= 0x80;
            fs::write(&path, &bytes).unwrap();
            let outcome = repair(&path).unwrap();
            let (from, to) = (chunk.message_start_time, chunk.message_end_time);
            let lost = [(Duration::from_nanos(from), Duration::from_nanos(to))];
            assert_eq!(
                (outcome.was_closed, &outcome.lost[..]),
                (false, &lost[..]),
                "byte {at} of chunk {number}"
            );
            let repaired = fs::read(&path).unwrap();
            let mut kept = times(&whole);
            kept.retain(|time| !(from..=to).contains(time));
            assert_eq!(times(&repaired), kept, "byte {at} of chunk {number}");
            let summary = Summary::read(&repaired).unwrap().expect("a summary");
            assert_eq!(summary.stats.unwrap().message_count, kept.len() as u64);
            assert_eq!(indexed_times(&path), kept, "byte {at} of chunk {number}");
            assert!(repair(&path).unwrap().was_closed, "a second repair has nothing to do");
        }
        // Damage after the last message: some readers don't notice it, but others fail.
        let mut bytes = whole.clone();
        bytes[start + chunk.chunk_length as usize - 1] ^= 0x80;
        fs::write(&path, &bytes).unwrap();
        let kept = repair(&path).unwrap().messages;
        assert_eq!(
            (indexed_times(&path).len(), times(&fs::read(&path).unwrap()).len()),
            (kept as usize, kept as usize)
        );
    }
}

/// Returns the log times of all messages as [`Recording`] reads them.
fn indexed_times(path: &Path) -> Vec<u64> {
    let recording = Recording::open(path).unwrap();
    let mut reader = recording.read(&Selection::all_of(Vec::new())).unwrap();
    std::iter::from_fn(|| reader.next().unwrap().map(|entry| entry.log_time)).collect()
}

#[test]
fn the_error_of_reading_a_damaged_chunk_names_the_repair_command() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("damaged.mcap");
    let mut bytes = recording(folder.path(), Compression::Lz4);
    let chunk = Summary::read(&bytes).unwrap().unwrap().chunk_indexes[3].clone();
    let end = (chunk.chunk_start_offset + chunk.chunk_length) as usize;
    bytes[end - chunk.compressed_size as usize..end].fill(0xa5);
    fs::write(&path, &bytes).unwrap();
    let recording = Recording::open(&path).unwrap();
    let mut reader = recording.read(&Selection::all_of(Vec::new())).unwrap();
    let error = loop {
        match reader.next() {
            Ok(entry) => assert!(entry.is_some(), "the damage is found"),
            Err(error) => break error.to_string(),
        }
    };
    assert!(error.contains("regatta record --repair") && error.lines().count() == 1, "{error}");
}

#[test]
fn a_recording_that_was_never_closed_can_be_read_without_repair() {
    let folder = TempDir::new().unwrap();
    let whole = recording(folder.path(), Compression::Lz4);
    let path = folder.path().join("cut.mcap");
    fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    let recording = Recording::open(&path).unwrap();
    assert!(!recording.is_closed() && recording.count(&Topic::Frames) > 5);
    assert_eq!(
        fs::metadata(&path).unwrap().len(),
        (whole.len() / 2) as u64,
        "the file is unchanged"
    );
}

#[test]
fn a_file_that_is_not_a_recording_is_left_unchanged() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("notes.txt");
    fs::write(&path, "not a recording at all, but somebody's notes").unwrap();
    assert!(matches!(repair(&path), Err(RepairError::NoRecording { .. })));
    assert_eq!(fs::read_to_string(&path).unwrap(), "not a recording at all, but somebody's notes");
    assert!(matches!(repair(&folder.path().join("none.mcap")), Err(RepairError::Io { .. })));
}

#[test]
fn a_repaired_copy_leaves_the_recording_as_it_is() {
    let folder = TempDir::new().unwrap();
    let whole = recording(folder.path(), Compression::Lz4);
    let (path, copy) = (folder.path().join("cut.mcap"), folder.path().join("copy.mcap"));
    let cut = &whole[..whole.len() / 2];
    fs::write(&path, cut).unwrap();
    let repaired = repair_copy(&path, &copy, false).unwrap();
    assert_eq!(fs::read(&path).unwrap(), cut);
    assert_eq!(times(&fs::read(&copy).unwrap()).len() as u64, repaired.messages);
    assert!(repair(&copy).unwrap().was_closed);
    // An existing file isn't overwritten, and nothing is left of a copy that fails.
    fs::write(folder.path().join("notes.txt"), "precious").unwrap();
    for (from, to) in [(&path, "notes.txt"), (&folder.path().join("notes.txt"), "copy-2.mcap")] {
        assert!(repair_copy(from, &folder.path().join(to), false).is_err());
    }
    assert_eq!(fs::read_to_string(folder.path().join("notes.txt")).unwrap(), "precious");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 4, "whole, cut, copy and notes");
}
