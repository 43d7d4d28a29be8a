//! The store of a study: a folder with jobs, results and layouts, and an SQLite file with the
//! figures of all finished runs.
//!
//! ```text
//! study.sqlite          a row per finished run
//! files/HASH.yaml       layouts, by the hashes of their content
//! jobs/ID.json          the job of a run
//! results/ID.json       its outcome
//! ```
//!
//! A result exists as a whole or not at all. A study that was killed continues: a run that has a
//! row or a result isn't done again.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use rusqlite::{Connection, OptionalExtension, params};

use crate::job::{Job, JobId, content_hash};
use crate::outcome::{EdgeOutcome, Measured, Outcome};

/// The version of the tables.
const VERSION: i64 = 4;

const TABLES: &str = "
CREATE TABLE IF NOT EXISTS runs (
    id TEXT PRIMARY KEY, variant TEXT NOT NULL, robots INTEGER NOT NULL, seed INTEGER NOT NULL, command TEXT NOT NULL,
    digest TEXT NOT NULL, orders_per_hour REAL NOT NULL, wall_secs REAL NOT NULL, measured TEXT NOT NULL
) STRICT;
";

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
        "{}: {reason}; finished runs are kept beside it, and the same command goes on",
        path.display()
    )]
    Database {
        /// The file.
        path: PathBuf,
        /// The reason.
        reason: rusqlite::Error,
    },
    /// The file is of another version of Regatta.
    #[error("{}: a study of another version ({found}); give another folder", path.display())]
    Version {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: i64,
    },
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
    database: Connection,
}

impl Store {
    /// Opens the store in a folder, which is made if it doesn't exist.
    ///
    /// # Errors
    /// [`StoreError`] if the folder can't be used.
    pub fn open(folder: &Path) -> Result<Self, StoreError> {
        for name in ["jobs", "results", "files"] {
            let path = folder.join(name);
            fs::create_dir_all(&path).map_err(|reason| StoreError::Write { path, reason })?;
        }
        let path = folder.join("study.sqlite");
        match open_database(&path) {
            Ok((database, 0 | VERSION)) => Ok(Self { folder: folder.to_owned(), database }),
            Ok((_, found)) => Err(StoreError::Version { path, found }),
            Err(reason) => Err(StoreError::Database { path, reason }),
        }
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
        self.folder.join("results").join(format!("{id}.json"))
    }

    /// Keeps a layout, and returns the name of its file.
    ///
    /// # Errors
    /// [`StoreError::Write`].
    pub fn keep_layout(&self, text: &str) -> Result<String, StoreError> {
        let name = format!("{}.yaml", content_hash(text.as_bytes()));
        write_whole(&self.files().join(&name), text.as_bytes())?;
        Ok(name)
    }

    /// Writes a job's file.
    ///
    /// # Errors
    /// [`StoreError::Write`].
    pub fn keep_job(&self, job: &Job) -> Result<(), StoreError> {
        write_whole(&self.job_file(&job.id()), job.text().as_bytes())
    }

    /// Returns the figures of a finished run.
    ///
    /// # Errors
    /// [`StoreError::Database`].
    pub fn measured(&self, id: &JobId) -> Result<Option<Measured>, StoreError> {
        let text: Option<String> = self
            .database
            .query_row("SELECT measured FROM runs WHERE id = ?1", [id.as_str()], |row| row.get(0))
            .optional()
            .map_err(|reason| self.failed(reason))?;
        // A row that can't be read is of another version, and its run is done again.
        Ok(text.and_then(|text| serde_json::from_str(&text).ok()))
    }

    /// Takes the result file of a run into the database, and returns its figures; `None` if there
    /// is no valid one.
    ///
    /// # Errors
    /// [`StoreError::Database`].
    pub fn take_result(
        &self,
        id: &JobId,
        label: &Label<'_>,
    ) -> Result<Option<Measured>, StoreError> {
        let Some(outcome) = self.outcome(id) else { return Ok(None) };
        let measured = outcome.measured();
        let text = serde_json::to_string(&measured).unwrap_or_default();
        let Label { variant, robots, seed, command } = label;
        self.database
            .execute(
                "INSERT OR REPLACE INTO runs VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9)",
                params![
                    id.as_str(),
                    variant,
                    robots,
                    *seed as i64,
                    command,
                    measured.digest,
                    measured.orders_per_hour,
                    measured.wall_secs,
                    text
                ],
            )
            .map_err(|reason| self.failed(reason))?;
        Ok(Some(measured))
    }

    /// Returns the edges of some finished runs: the means of their figures.
    pub fn edges(&self, ids: &[JobId]) -> Vec<EdgeOutcome> {
        let outcomes: Vec<Outcome> = ids.iter().filter_map(|id| self.outcome(id)).collect();
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

    /// Reads the result of a run; `None` if there is none, or it isn't one of this job.
    fn outcome(&self, id: &JobId) -> Option<Outcome> {
        let text = fs::read_to_string(self.result_file(id)).ok()?;
        serde_json::from_str::<Outcome>(&text).ok().filter(|outcome| outcome.job == *id)
    }

    fn failed(&self, reason: rusqlite::Error) -> StoreError {
        StoreError::Database { path: self.folder.join("study.sqlite"), reason }
    }
}

/// Opens the database, and returns the version that it had; its tables are made if that is ours.
fn open_database(path: &Path) -> rusqlite::Result<(Connection, i64)> {
    let database = Connection::open(path)?;
    let found = database.query_row("PRAGMA user_version", [], |row| row.get(0))?;
    if found == 0 || found == VERSION {
        database.execute_batch(TABLES)?;
        database.pragma_update(None, "user_version", VERSION)?;
    }
    Ok((database, found))
}

/// Writes a file that appears under its name only when it is complete. A file that exists already
/// has the same content, as its name says.
fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    if path.exists() {
        return Ok(());
    }
    let folder = path.parent().unwrap_or(Path::new("."));
    let written = tempfile::NamedTempFile::new_in(folder).and_then(|mut file| {
        file.write_all(bytes)?;
        Ok(file.persist(path)?)
    });
    match written {
        Ok(_) => Ok(()),
        Err(reason) => Err(StoreError::Write { path: path.to_owned(), reason }),
    }
}
