//! Replays the corpora of fuzz targets, for tests on a stable toolchain.

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

/// The longest time to read an input. Test machines may be busy.
const LONGEST: Duration = Duration::from_secs(10);
/// The number of beginnings, and of ends, of each file that are read, too.
const PARTS: usize = 40;

/// Passes the files of a folder, their beginnings and their ends to a target.
pub fn replay(folder: &Path, target: fn(&[u8])) {
    let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{folder:?}: {error}"));
    let mut files = 0;
    for entry in entries {
        let path = entry.expect("an entry").path();
        let bytes = fs::read(&path).expect("a file");
        for part in 0..=PARTS {
            let middle = bytes.len() * part / PARTS;
            for input in [&bytes[..middle], &bytes[middle..]] {
                let started = Instant::now();
                target(input);
                assert!(started.elapsed() < LONGEST, "{path:?}, part {part}");
            }
        }
        files += 1;
    }
    assert!(files > 0, "{folder:?} is empty");
}
