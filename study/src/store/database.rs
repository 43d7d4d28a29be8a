//! The database of a study: a row for each finished run, for other programs. It is written as a
//! whole, in the order of the jobs: runs end in any order, and the same study has the same bytes.

use std::collections::BTreeMap;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use rusqlite::{Connection, params};

use super::{Label, StoreError};
use crate::job::JobId;
use crate::outcome::Measured;

const TABLES: &str = "
CREATE TABLE runs (
    id TEXT PRIMARY KEY, variant TEXT NOT NULL, robots INTEGER NOT NULL, seed INTEGER NOT NULL, command TEXT NOT NULL,
    digest TEXT NOT NULL, orders_per_hour REAL NOT NULL, measured TEXT NOT NULL
) STRICT;
PRAGMA user_version = 5;
";
pub(super) const DATABASE: &str = "study.sqlite";

/// A row.
#[derive(Clone, Debug)]
pub(super) struct Row {
    variant: String,
    robots: u32,
    seed: u64,
    command: String,
    measured: Measured,
}

impl Row {
    pub(super) fn new(label: &Label<'_>, measured: Measured) -> Self {
        let Label { variant, robots, seed, command } = *label;
        Self { variant: variant.to_owned(), robots, seed, command: command.to_owned(), measured }
    }
}

/// Writes the database of a study's folder.
///
/// # Errors
/// [`StoreError`].
pub(super) fn write(folder: &Path, rows: &BTreeMap<JobId, Row>) -> Result<(), StoreError> {
    let path = folder.join(DATABASE);
    // Those of a program that was killed while it wrote to the database would change this one.
    for ending in ["-journal", "-wal", "-shm"] {
        remove(folder.join(format!("{DATABASE}{ending}")))?;
    }
    let file = match super::new_file(folder) {
        Ok(file) => file,
        Err(reason) => return Err(StoreError::Write { path, reason }),
    };
    if let Err(reason) = fill(file.path(), rows) {
        return Err(StoreError::Database { path, reason });
    }
    match file.persist(&path) {
        Ok(_) => Ok(()),
        Err(error) => Err(StoreError::Write { path, reason: error.error }),
    }
}

fn remove(path: PathBuf) -> Result<(), StoreError> {
    match fs::remove_file(&path) {
        Err(reason) if reason.kind() != ErrorKind::NotFound => {
            Err(StoreError::Write { path, reason })
        }
        _ => Ok(()),
    }
}

fn fill(path: &Path, rows: &BTreeMap<JobId, Row>) -> rusqlite::Result<()> {
    let mut database = Connection::open(path)?;
    // It can be made again from the results, and appears only when it is complete.
    database.pragma_update(None, "journal_mode", "OFF")?;
    database.pragma_update(None, "synchronous", "OFF")?;
    database.execute_batch(TABLES)?;
    let transaction = database.transaction()?;
    for (id, Row { variant, robots, seed, command, measured }) in rows {
        let text = serde_json::to_string(measured).unwrap_or_default();
        transaction.execute(
            "INSERT INTO runs VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)",
            params![
                id.as_str(),
                variant,
                robots,
                *seed as i64,
                command,
                measured.digest,
                measured.orders_per_hour,
                text
            ],
        )?;
    }
    transaction.commit()?;
    database.close().map_err(|(_, reason)| reason)
}
