//! The files that are drawn: meshes and pictures, with their texts.

use std::fs::File;
use std::path::Path;

use regatta_base::file;

/// The size of the largest file.
const MAX_BYTES: u64 = 1 << 30;

/// Opens a file.
pub fn open(path: &Path) -> Result<File, String> {
    file::open(path, MAX_BYTES).map_err(|error| error.to_string())
}

/// Reads a file.
pub fn read(path: &Path) -> Result<Vec<u8>, String> {
    file::read(path, MAX_BYTES).map_err(|error| error.to_string())
}

/// Reads a file as a text.
pub fn read_text(path: &Path) -> Result<String, String> {
    file::read_text(path, MAX_BYTES).map_err(|error| error.to_string())
}
