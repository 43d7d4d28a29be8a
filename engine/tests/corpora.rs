//! The corpora of the fuzz targets, on a stable toolchain: each file was hostile to a reader once, or
//! might be. Each of them is read as every format, as the fuzz targets do it.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use regatta_layout::Format;

#[path = "../../fuzz/fuzz_targets/layout.rs"]
mod layout;

/// The longest time to read a file as all formats. Test machines may be busy.
const LONGEST: Duration = Duration::from_secs(10);

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{folder:?}: {error}"));
    entries.map(|entry| entry.expect("an entry").path()).collect()
}

#[test]
fn no_file_of_the_corpora_makes_a_reader_panic_or_hang() {
    let fuzz = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz");
    let mut read = 0;
    for folder in files(&fuzz.join("corpora")) {
        for path in files(&folder) {
            let bytes = fs::read(&path).expect("a file");
            let text = String::from_utf8_lossy(&bytes);
            let started = Instant::now();
            for &format in Format::ALL {
                layout::read(&text, format);
            }
            assert!(started.elapsed() < LONGEST, "{}: {:?}", path.display(), started.elapsed());
            read += 1;
        }
    }
    assert!(read > 100, "{read} files");
}
