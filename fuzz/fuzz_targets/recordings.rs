//! The fuzz target of recordings: no file makes a reader panic, hang or exhaust memory, and the
//! copy of a repair can be read.

use std::fs;

use regatta_record::{Published, ReadingError, Recording, info, play, repair_copy};

/// Reads bytes as a recording, and repairs them.
pub fn read(bytes: &[u8]) {
    let folder = tempfile::tempdir().expect("a folder");
    let [path, copy] = ["fuzzed.mcap", "copy.mcap"].map(|name| folder.path().join(name));
    fs::write(&path, bytes).expect("written");
    let _told = info(&path).map(|info| info.to_string());
    let _played = play(&path, check);
    if let Ok(recording) = Recording::open(&path) {
        let _read = recording.contacts(|_, _, _| Ok::<_, ReadingError>(()));
    }
    if repair_copy(&path, &copy, false).is_ok() {
        let told = info(&copy);
        // The lost part may be all that there was of a fleet. A chunk without a checksum may hold
        // any message, which its reader refuses.
        let is_clear = matches!(
            told,
            Ok(_) | Err(ReadingError::NoFleet { .. } | ReadingError::Message { .. })
        );
        assert!(is_clear, "{told:?}");
    }
}

fn check(published: Published<'_>) {
    if let Published::Frame(frame) = published {
        assert!(frame.x().len() == frame.len() && frame.edge().len() == frame.len());
    }
}
