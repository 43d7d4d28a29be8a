//! The files of a recording: their names, and the ones that are kept.

use std::collections::VecDeque;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::SinkError;
use super::part::{Part, create_file};
use crate::arguments::Limit;

/// The division of a recording into files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Division {
    /// One file.
    #[default]
    None,
    /// Numbered files of at most this time or size.
    Split(Limit),
    /// Numbered files, of which only the newest are kept: together, this time or size.
    Ring(Limit),
}

/// The number of files of a ring. A ring is longer than its limit by at most one of them.
const RING_FILES: u32 = 8;

/// The files of a recording.
pub(super) struct Parts {
    path: PathBuf,
    division: Division,
    overwrite: bool,
    number: u32,
    /// The files that are closed and kept.
    pub closed: VecDeque<ClosedPart>,
}

/// A file that is closed.
pub(super) struct ClosedPart {
    pub path: PathBuf,
    duration: u64,
    pub bytes: u64,
    pub frames: u64,
}

impl Parts {
    pub fn new(path: &Path, division: Division, overwrite: bool) -> Self {
        Self { path: path.to_owned(), division, overwrite, number: 0, closed: VecDeque::new() }
    }

    /// Creates the next file. The only file has the given name; others have it with a number, for
    /// example `run-0002.mcap`.
    pub fn create(&mut self) -> Result<(PathBuf, File), SinkError> {
        loop {
            self.number += 1;
            let is_first = self.number == 1;
            let path = match self.division {
                Division::None if is_first => self.path.clone(),
                _ => numbered(&self.path, self.number),
            };
            match create_file(&path, self.overwrite) {
                // A file of an earlier recording is left alone.
                Err(SinkError::Exists { .. }) if !is_first => {}
                created => return created.map(|file| (path, file)),
            }
        }
    }

    /// Whether a file is complete, so that a frame of the given time begins another one.
    pub fn is_complete(&self, part: &Part, log_time: u64) -> bool {
        let limit = match self.division {
            Division::None => return false,
            Division::Split(limit) => limit,
            Division::Ring(limit) => limit.divided(RING_FILES),
        };
        limit.is_reached(Duration::from_nanos(part.duration_until(log_time)), part.bytes_at_most())
    }

    /// Takes a closed file, and removes files that a ring doesn't need any more.
    pub fn close(&mut self, part: &Part, frames: u64) {
        let (duration, bytes) = (part.duration_until(0), part.bytes());
        self.closed.push_back(ClosedPart { path: part.path.clone(), duration, bytes, frames });
        let Division::Ring(limit) = self.division else { return };
        while self.closed.len() > 1 && self.suffices(limit) {
            let Some(oldest) = self.closed.pop_front() else { break };
            if let Err(error) = fs::remove_file(&oldest.path) {
                regatta_plugin::tell!("record: can't remove {} ({error})", oldest.path.display());
            }
        }
    }

    /// Whether the closed files without the oldest one reach a limit.
    fn suffices(&self, limit: Limit) -> bool {
        let (mut duration, mut bytes) = (0, 0);
        for part in self.closed.iter().skip(1) {
            duration += part.duration;
            bytes += part.bytes;
        }
        limit.is_reached(Duration::from_nanos(duration), bytes)
    }

    /// Returns the files of a ring in their order, if there are several to join to one with the
    /// returned name.
    pub fn ring(&self) -> Option<(&Path, impl Iterator<Item = &Path>)> {
        let is_ring = matches!(self.division, Division::Ring(_)) && !self.closed.is_empty();
        is_ring.then(|| (&self.path as &Path, self.closed.iter().map(|part| &part.path as &Path)))
    }

    /// Returns the name of the recording for messages: its only file, or the first and the last
    /// one.
    pub fn name(&self) -> String {
        match (self.closed.front(), self.closed.back()) {
            (Some(first), Some(last)) if first.path != last.path => {
                format!("{} to {}", first.path.display(), last.path.display())
            }
            (Some(only), _) => only.path.display().to_string(),
            _ => self.path.display().to_string(),
        }
    }
}

/// Returns a file's name with a number: `run-0002.mcap`.
fn numbered(path: &Path, number: u32) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let mut name = format!("{stem}-{number:04}");
    if let Some(extension) = path.extension() {
        name += &format!(".{}", extension.to_string_lossy());
    }
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_before_the_extension() {
        assert_eq!(numbered(Path::new("a/run.1.mcap"), 2), Path::new("a/run.1-0002.mcap"));
        assert_eq!(numbered(Path::new("run"), 12345), Path::new("run-12345"));
    }
}
