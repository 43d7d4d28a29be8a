//! Checks of input files.

use std::path::Path;

/// Checks that a path is a regular file. Reading a named pipe would block for ever.
pub fn check_regular(path: &Path) -> Result<(), String> {
    let is_file = path.metadata().map_err(|error| error.to_string())?.is_file();
    is_file.then_some(()).ok_or_else(|| "not a regular file".to_owned())
}
