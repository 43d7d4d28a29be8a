//! Creates the files of exports and plots.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use mcap::MAGIC;

/// Creates a file or overwrites an existing one, but never a recording: it may be the one that is being read.
pub(crate) fn create(path: &Path) -> io::Result<File> {
    // Only regular files are checked: a pipe, for example, has no content to lose, and opening it would block.
    let is_file = path.metadata().is_ok_and(|metadata| metadata.is_file());
    if is_file && is_recording(path) {
        return Err(io::Error::new(
            io::ErrorKind::AlreadyExists,
            "it is a recording; choose another file, or remove it",
        ));
    }
    File::create(path)
}

fn is_recording(path: &Path) -> bool {
    let mut magic = [0; MAGIC.len()];
    File::open(path).and_then(|mut file| file.read_exact(&mut magic)).is_ok() && magic == *MAGIC
}
