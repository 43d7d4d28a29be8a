//! Files that tables and pictures are written to.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use mcap::MAGIC;

/// Creates a file, or overwrites one that is no recording: to lose one, the one that is read maybe, was not meant.
pub(crate) fn create(path: &Path) -> io::Result<File> {
    // Anything else, a pipe say, has nothing to lose, and a look would wait for it.
    let is_file = path.metadata().is_ok_and(|metadata| metadata.is_file());
    if is_file && is_recording(path) {
        return Err(io::Error::new(io::ErrorKind::AlreadyExists, "it is a recording; give another file, or remove it"));
    }
    File::create(path)
}

fn is_recording(path: &Path) -> bool {
    let mut magic = [0; MAGIC.len()];
    File::open(path).and_then(|mut file| file.read_exact(&mut magic)).is_ok() && magic == *MAGIC
}
