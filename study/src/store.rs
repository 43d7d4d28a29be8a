//! The store of a study: a folder with jobs, results and layouts, and an SQLite file with the
//! figures of all finished runs.
//!
//! ```text
//! study.sqlite          a row per finished run, for other programs: it is written, and never read
//! times.csv             the wall-clock time of each run: all other files are the same each time
//! files/HASH.yaml       layouts, by the hashes of their content
//! jobs/ID.json          the job of a run
//! results/ID.json       its outcome, with a seal
//! ```
//!
//! A result exists as a whole or not at all. A study that was killed continues: a run that has a
//! result isn't done again.
//!
//! The folder may come from somebody else, or may have been changed. Jobs and layouts follow from
//! the plant: each is compared with what the study would write, and written anew if it differs. A
//! result counts only with the [seal](crate::seal) of this user; any other is removed, told as a
//! doubt, and its run is done again.

mod database;
mod folder;
mod times;

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use regatta_base::file;
use tempfile::NamedTempFile;

use self::database::Row;
pub use self::folder::{Unsafe, check_folder};
pub use self::times::{Times, times};
use crate::job::{Job, JobId, layout_name};
use crate::outcome::{EdgeOutcome, Measured, Outcome};
use crate::seal::Key;

const RESULTS: &str = "results";
/// The size of the largest file that is compared or read: a result lists all orders of a run.
const MAX_FILE_BYTES: u64 = 1 << 30;

/// The error of a store.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// A file can't be written.
    #[error("{}: can't write: {reason}; finished runs are kept", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The reason.
        reason: std::io::Error,
    },
    /// The database can't be used.
    #[error(
        "{}: {reason}; finished runs are kept beside it; repeat the command to continue",
        path.display()
    )]
    Database {
        /// The file.
        path: PathBuf,
        /// The reason.
        reason: rusqlite::Error,
    },
    /// The folder may not be used.
    #[error(transparent)]
    Unsafe(#[from] Unsafe),
}

/// The results that a study accepts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Accepted {
    /// Those with the seal of this user.
    Sealed,
    /// Those of other users and machines, too.
    Any,
}

/// The columns of a row beside the figures of the run.
#[derive(Clone, Debug)]
pub struct Label<'a> {
    /// The variant's name.
    pub variant: &'a str,
    /// The number of robots.
    pub robots: u32,
    /// The seed.
    pub seed: u64,
    /// The command that repeats the run.
    pub command: &'a str,
}

/// The folder of a study.
#[derive(Debug)]
pub struct Store {
    folder: PathBuf,
    /// The rows of the database.
    rows: RefCell<BTreeMap<JobId, Row>>,
    times: RefCell<Times>,
    key: Key,
    accepted: Accepted,
    /// The files that weren't used as they were, one line each.
    doubts: RefCell<Vec<String>>,
}

impl Store {
    /// Opens the store in a folder, which is made if it doesn't exist.
    ///
    /// # Errors
    /// [`StoreError`] if the folder can't be used, or belongs to another user.
    pub fn open(folder: &Path, key: Key, accepted: Accepted) -> Result<Self, StoreError> {
        for name in ["jobs", RESULTS, "files"] {
            let path = folder.join(name);
            fs::create_dir_all(&path).map_err(|reason| StoreError::Write { path, reason })?;
        }
        check_folder(folder)?;
        let (rows, doubts) = (RefCell::default(), RefCell::default());
        let (folder, times) = (folder.to_owned(), RefCell::new(times(folder)));
        let store = Self { folder, rows, times, key, accepted, doubts };
        store.settle()?;
        Ok(store)
    }

    /// Writes the database of the runs that are known so far, and their times.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn settle(&self) -> Result<(), StoreError> {
        database::write(&self.folder, &self.rows.borrow())?;
        times::write(&self.folder, &self.times.borrow())
    }

    /// Notes the wall-clock time of a run in seconds.
    pub fn note_time(&self, id: &JobId, secs: f64) {
        self.times.borrow_mut().insert(id.to_string(), secs);
    }

    /// Takes the files that weren't used as they were: lines for the user.
    pub fn take_doubts(&self) -> Vec<String> {
        self.doubts.take()
    }

    /// Returns the folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Returns the folder of the layouts.
    pub fn files(&self) -> PathBuf {
        self.folder.join("files")
    }

    /// Returns the file of a job.
    pub fn job_file(&self, id: &JobId) -> PathBuf {
        self.folder.join("jobs").join(format!("{id}.json"))
    }

    /// Returns the file of a job's result.
    pub fn result_file(&self, id: &JobId) -> PathBuf {
        self.folder.join(RESULTS).join(format!("{id}.json"))
    }

    /// Keeps a layout, and returns the name of its file.
    ///
    /// # Errors
    /// [`StoreError::Write`].
    pub fn keep_layout(&self, text: &str) -> Result<String, StoreError> {
        let name = layout_name(text);
        self.keep(&self.files().join(&name), text)?;
        Ok(name)
    }

    /// Writes a job's file.
    ///
    /// # Errors
    /// [`StoreError::Write`].
    pub fn keep_job(&self, job: &Job) -> Result<(), StoreError> {
        self.keep(&self.job_file(&job.id()), &job.text())
    }

    /// Writes a file that is named by its content, unless it is there as it should be.
    fn keep(&self, path: &Path, text: &str) -> Result<(), StoreError> {
        match file::read(path, MAX_FILE_BYTES) {
            Ok(bytes) if bytes == text.as_bytes() => return Ok(()),
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            _ => self.doubt(path, "it was changed, and is written again"),
        }
        write_whole(path, text.as_bytes())
    }

    /// Returns the figures of a run that was done before, and keeps them for the database; `None` if
    /// it has no result. A doubtful one is removed.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn finished(&self, id: &JobId, label: &Label<'_>) -> Result<Option<Measured>, StoreError> {
        let path = self.result_file(id);
        let (outcome, seal) = match self.read_result(id, self.accepted) {
            Ok(result) => result,
            Err(Doubt::Missing) => return Ok(None),
            Err(doubt) => {
                self.doubt(&path, &format!("{doubt}: its run is done again"));
                // A file that can't be removed can't be replaced either: the run will tell it.
                let _ = fs::remove_file(&path);
                return Ok(None);
            }
        };
        self.keep_seal(&outcome, seal)?;
        Ok(Some(self.keep_figures(id, label, &outcome)))
    }

    /// Takes the result that a worker of this study has just written, seals it, and returns its
    /// figures; `None` if there is no valid one.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn take_result(
        &self,
        id: &JobId,
        label: &Label<'_>,
    ) -> Result<Option<Measured>, StoreError> {
        let Ok((outcome, seal)) = self.read_result(id, Accepted::Any) else { return Ok(None) };
        self.keep_seal(&outcome, seal)?;
        Ok(Some(self.keep_figures(id, label, &outcome)))
    }

    fn keep_figures(&self, id: &JobId, label: &Label<'_>, outcome: &Outcome) -> Measured {
        let measured = outcome.measured();
        self.rows.borrow_mut().insert(id.clone(), Row::new(label, measured.clone()));
        measured
    }

    /// Returns the outcomes of some finished runs.
    pub fn outcomes(&self, ids: &[JobId]) -> Vec<Outcome> {
        let read = ids.iter().filter_map(|id| self.read_result(id, Accepted::Sealed).ok());
        read.map(|(outcome, _)| outcome).collect()
    }

    /// Returns the edges of some finished runs: the means of their figures.
    pub fn edges(&self, ids: &[JobId]) -> Vec<EdgeOutcome> {
        let outcomes = self.outcomes(ids);
        let mut sums: BTreeMap<u32, EdgeOutcome> = BTreeMap::new();
        for edge in outcomes.iter().flat_map(|outcome| &outcome.edges) {
            let sum = sums.entry(edge.edge).or_insert(EdgeOutcome::new(edge.edge));
            sum.waiting_secs += edge.waiting_secs;
            sum.caused_secs += edge.caused_secs;
            sum.entered_per_hour += edge.entered_per_hour;
        }
        let runs = outcomes.len().max(1) as f64;
        for edge in sums.values_mut() {
            edge.waiting_secs /= runs;
            edge.caused_secs /= runs;
            edge.entered_per_hour /= runs;
        }
        sums.into_values().collect()
    }

    /// Reads the result of a run, and tells whether it has this user's seal.
    fn read_result(&self, id: &JobId, accepted: Accepted) -> Result<(Outcome, Seal), Doubt> {
        let path = self.result_file(id);
        let text = match file::read_text(&path, MAX_FILE_BYTES) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound => return Err(Doubt::Missing),
            Err(reason) => return Err(Doubt::Unreadable(reason)),
        };
        let seal = if self.key.has_sealed(&text) { Seal::Own } else { Seal::Missing };
        if (seal, accepted) == (Seal::Missing, Accepted::Sealed) {
            return Err(Doubt::Unsealed);
        }
        let outcome: Outcome = serde_json::from_str(&text).map_err(|_| Doubt::NoOutcome)?;
        if !outcome.is_plausible() {
            return Err(Doubt::NoOutcome);
        }
        if outcome.job != *id {
            return Err(Doubt::OfAnotherJob);
        }
        Ok((outcome, seal))
    }

    /// Seals a result that is accepted without a seal.
    fn keep_seal(&self, outcome: &Outcome, seal: Seal) -> Result<(), StoreError> {
        if seal == Seal::Own {
            return Ok(());
        }
        // There is nothing in it that JSON can't hold.
        let text = serde_json::to_string(outcome).unwrap_or_default();
        write_whole(&self.result_file(&outcome.job), self.key.sealed(&text).as_bytes())
    }

    fn doubt(&self, path: &Path, reason: &str) {
        self.doubts.borrow_mut().push(format!("{}: {reason}", path.display()));
    }
}

/// Whether a result has this user's seal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Seal {
    Own,
    Missing,
}

/// The reason why a result isn't used.
#[derive(Debug, thiserror::Error)]
enum Doubt {
    #[error("there is none")]
    Missing,
    #[error("can't be read: {0}")]
    Unreadable(std::io::Error),
    #[error("it was changed, or made by another user")]
    Unsealed,
    #[error("it isn't a result")]
    NoOutcome,
    #[error("it is the result of another job")]
    OfAnotherJob,
}

/// Makes a file without a lasting name, which other users may read, as any new file.
fn new_file(folder: &Path) -> std::io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

/// Writes a file that appears under its name only when it is complete, also after a crash of the
/// system.
fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let written = new_file(folder).and_then(|mut file| {
        file.write_all(bytes)?;
        file.as_file().sync_all()?;
        Ok(file.persist(path)?)
    });
    match written {
        Ok(_) => Ok(()),
        Err(reason) => Err(StoreError::Write { path: path.to_owned(), reason }),
    }
}

#[cfg(test)]
mod tests;
