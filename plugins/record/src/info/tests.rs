//! The description of a recording.

use std::fs;

use tempfile::TempDir;

use super::info;
use crate::reading::Recording;
use crate::schema::Topic;
use crate::sink::Division;
use crate::sink::tests::recording;

#[test]
fn a_recording_is_described_by_its_index() {
    let folder = TempDir::new().unwrap();
    recording(folder.path(), Division::None, 20, 1_000_000);
    let path = folder.path().join("run.mcap");
    let info = info(&path).unwrap();
    assert!(info.is_closed && info.fleet.as_deref() == Some("test"));
    assert_eq!((info.frames, info.ticks, info.robots), (20, Some([0, 19]), Some(40_000)));
    assert_eq!((info.start_s, info.end_s, info.frames_per_s), (0.0, 19.0, 1.0));
    assert_eq!(
        (info.nodes, info.edges, &info.runs[..]),
        (Some(0), Some(1), &["0000000000000001".to_owned()][..])
    );
    assert_eq!(info.bytes, fs::metadata(&path).unwrap().len());
    let frames = info.topics.iter().find(|topic| topic.name == "/frames").unwrap();
    assert_eq!((frames.messages, frames.messages_per_s), (20, 1.0));
    assert!(
        (20_000_000..20_100_000).contains(&frames.bytes) && frames.bytes == frames.bytes_in_file,
        "{frames:?}"
    );
    let all: u64 = info.topics.iter().map(|topic| topic.bytes_in_file).sum();
    // The rest is the index, and a copy of the descriptors (7.5 kB) for each topic.
    assert!(all <= info.bytes && info.bytes - all < 100_000, "{all} of {} bytes", info.bytes);
    let text = info.to_string();
    assert!(
        text.contains("20, ticks 0 to 19, 1.0 per second") && text.contains("/contact_updates"),
        "{text}"
    );
}

#[test]
fn a_recording_that_was_never_closed_is_described_as_incomplete() {
    let folder = TempDir::new().unwrap();
    recording(folder.path(), Division::None, 20, 1_000_000);
    let path = folder.path().join("run.mcap");
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    let info = info(&path).unwrap();
    assert_eq!(
        (info.is_closed, info.frames),
        (false, Recording::open(&path).unwrap().count(&Topic::Frames))
    );
    assert!(info.to_string().contains("never closed"), "{info}");
}
