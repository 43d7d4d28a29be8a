//! The store of orders: an SQLite file that any tool can read.
//!
//! An acknowledged order survives the death of this process at any moment, because its commit is
//! with the operating system (WAL). It isn't synchronised with the disk at every commit: after a
//! power failure the last orders may be missing, but the file is whole. All writing happens on a
//! thread of its own, in groups.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rusqlite::types::FromSql;
use rusqlite::{Connection, ErrorCode, OptionalExtension as _, params};

use self::row::order_of;
use super::order::OrderName;
use super::places::Places;
use super::pool::{Known, Restored};

#[cfg(feature = "http")]
pub(super) use archive::Archive;
pub(super) use writer::Writer;

#[cfg(feature = "http")]
mod archive;
mod row;
mod writer;

/// `RGTA`: distinguishes stores from the databases of other programs.
const APPLICATION_ID: i32 = 0x5247_5441;
/// The version of the tables.
const VERSION: i32 = 3;
/// From version 1 to 2.
const INTENDED_ROBOT: &str = "ALTER TABLE transport_order ADD COLUMN intended_robot INTEGER;";
/// From version 2 to 3: JSON, the names of robot types; null for any.
const ROBOT_TYPES: &str = "ALTER TABLE transport_order ADD COLUMN robot_types TEXT;";
/// From no tables to version 1.
const SCHEMA: &str = "
    CREATE TABLE transport_order (
        name TEXT NOT NULL PRIMARY KEY,
        id INTEGER,                     -- the number in the order log; null until the manager \
             has taken the order
        state TEXT NOT NULL,
        priority INTEGER NOT NULL,
        created REAL,                   -- all times in seconds of simulated time
        earliest REAL NOT NULL,
        deadline REAL,
        robot INTEGER,
        handled_stops INTEGER NOT NULL,
        reason TEXT NOT NULL,
        stops TEXT NOT NULL,            -- JSON: node (id of the route graph's file), action, \
             dwell in seconds
        history TEXT NOT NULL           -- JSON: time, event, and what belongs to it
    );
    CREATE INDEX open_order ON transport_order (state) \
        WHERE state NOT IN ('finished', 'failed', 'cancelled');
    CREATE TABLE run (number INTEGER PRIMARY KEY, run_id TEXT NOT NULL);";

/// The error of using a store.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// Another process has it.
    #[error("another process keeps its orders in {}; end it, or choose another file", .0.display())]
    InUse(PathBuf),
    /// It is not a store of orders.
    #[error("{} is not a store of orders, and is left as it is; choose another file", .0.display())]
    Foreign(PathBuf),
    /// It is a store of a later version of this program.
    #[error(
        "{} was written by a newer version of Regatta (tables {version}, not {VERSION}); use that \
         version, or choose another file",
        path.display()
    )]
    Newer {
        /// The file.
        path: PathBuf,
        /// The version of its tables.
        version: i32,
    },
    /// It is damaged.
    #[error(
        "{} is damaged ({reason}), and is left as it is; move it away to begin with an empty store",
        path.display()
    )]
    Corrupt {
        /// The file.
        path: PathBuf,
        /// The damage that SQLite found.
        reason: String,
    },
    /// It can't be opened, read or written.
    #[error("can't use the store {} ({reason})", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The reason.
        reason: String,
    },
}

/// Opens a store, or makes a new one, and begins a run in it. Returns the thread that writes to it,
/// and its content.
pub(super) fn open(
    path: &Path,
    places: Arc<Places>,
    run_id: u64,
    now_secs: f64,
) -> Result<(Writer, Restored), StoreError> {
    let mut store = OrderStore::open(path, places)?;
    let restored = store.restore(run_id, now_secs)?;
    let writer = Writer::start(store)
        .map_err(|error| StoreError::Io { path: path.to_owned(), reason: error.to_string() })?;
    Ok((writer, restored))
}

/// An open store.
#[derive(Debug)]
struct OrderStore {
    // The connection is closed before the lock is given back.
    connection: Connection,
    path: PathBuf,
    places: Arc<Places>,
    _lock: File,
}

impl OrderStore {
    /// Opens a store, or makes a new one. The file `PATH.lock` stays beside it.
    pub(super) fn open(path: &Path, places: Arc<Places>) -> Result<Self, StoreError> {
        check_header(path)?;
        let lock = lock(path)?;
        make_private(path)
            .map_err(|error| StoreError::Io { path: path.to_owned(), reason: error.to_string() })?;
        let connection = Connection::open(path).map_err(|error| sqlite_error(path, &error))?;
        check_content(&connection, path)?;
        prepare(&connection).map_err(|error| sqlite_error(path, &error))?;
        Ok(Self { connection, path: path.to_owned(), places, _lock: lock })
    }

    /// Begins a run, or continues it if it is the last one of the store. Times and robots of other
    /// runs are invalid in this run: their open orders start again at `now_secs`.
    pub(super) fn restore(&mut self, run_id: u64, now_secs: f64) -> Result<Restored, StoreError> {
        self.read(run_id, now_secs).map_err(|error| sqlite_error(&self.path, &error))
    }

    fn read(&mut self, run_id: u64, now_secs: f64) -> rusqlite::Result<Restored> {
        let transaction = self.connection.transaction()?;
        let run_text = format!("{run_id:016x}");
        let last: Option<(u64, String)> = transaction
            .query_row("SELECT number, run_id FROM run ORDER BY number DESC LIMIT 1", [], |row| {
                Ok((row.get(0)?, row.get(1)?))
            })
            .optional()?;
        let is_same = last.as_ref().is_some_and(|(_, id)| *id == run_text);
        let run = last.map_or(0, |(number, _)| number) + u64::from(!is_same);
        if !is_same {
            transaction.execute("INSERT INTO run VALUES (?, ?)", params![run, run_text])?;
            transaction.execute("UPDATE transport_order SET id = NULL", [])?;
            // Robots of another run were sent to nodes of its world.
            transaction.execute(
                "UPDATE transport_order SET state = 'cancelled', reason = 'its run has ended'
                 WHERE name LIKE ? AND state NOT IN ('finished', 'failed', 'cancelled')",
                [format!("{}%", OrderName::REQUESTED)],
            )?;
        }
        let mut next_id = 1 + transaction.query_row(
            "SELECT ifnull(max(id), 0) FROM transport_order",
            [],
            |row| row.get::<_, u64>(0),
        )?;
        let (mut orders, mut unplaced) = (Vec::new(), 0);
        let mut statement = transaction.prepare(
            "SELECT name, id, state, priority, created, earliest, deadline, robot, handled_stops, \
             stops, history, intended_robot, robot_types
             FROM transport_order WHERE state NOT IN ('finished', 'failed', 'cancelled')
             ORDER BY rowid",
        )?;
        let mut rows = statement.query([])?;
        while let Some(row) = rows.next()? {
            match order_of(row, &self.places, is_same, now_secs, next_id)? {
                Some(order) => {
                    next_id = next_id.max(order.id.0 + 1);
                    orders.push(order);
                }
                None => unplaced += 1,
            }
        }
        drop(rows);
        drop(statement);
        let names = names(&transaction)?;
        transaction.commit()?;
        Ok(Restored { orders, next_id, known: Known { names, run }, unplaced })
    }
}

fn names(connection: &Connection) -> rusqlite::Result<BTreeSet<String>> {
    let mut statement = connection.prepare("SELECT name FROM transport_order")?;
    statement.query_map([], |row| row.get(0))?.collect()
}

/// Refuses a file that has content, but not that of SQLite.
fn check_header(path: &Path) -> Result<(), StoreError> {
    let mut header = Vec::new();
    let file = regatta_base::file::open(path, u64::MAX);
    let read = file.and_then(|file| file.take(16).read_to_end(&mut header));
    match read {
        Ok(_) => {}
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        Err(error) => {
            return Err(StoreError::Io { path: path.to_owned(), reason: error.to_string() });
        }
    }
    match header.is_empty() || header == b"SQLite format 3\0" {
        true => Ok(()),
        false => Err(StoreError::Foreign(path.to_owned())),
    }
}

/// Makes an empty file that only this user can read, unless there is one. The other files of SQLite
/// get the same rights.
fn make_private(path: &Path) -> std::io::Result<()> {
    match new_private(path) {
        Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => Ok(()),
        created => created.map(drop),
    }
}

fn new_private(path: &Path) -> std::io::Result<File> {
    let mut options = File::options();
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.write(true).create_new(true).open(path)
}

/// Takes the lock, which the system gives back at the end of this process, however it ends. It is a
/// file of its own, because closing a second handle of the store would give SQLite's locks back.
fn lock(path: &Path) -> Result<File, StoreError> {
    let mut name = path.as_os_str().to_owned();
    name.push(".lock");
    // A link that lies there makes no file elsewhere.
    let file = match new_private(Path::new(&name)) {
        Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {
            File::options().write(true).open(&name)
        }
        created => created,
    };
    let file =
        file.map_err(|error| StoreError::Io { path: path.to_owned(), reason: error.to_string() })?;
    file.try_lock().map_err(|error| match error {
        std::fs::TryLockError::WouldBlock => StoreError::InUse(path.to_owned()),
        std::fs::TryLockError::Error(error) => {
            StoreError::Io { path: path.to_owned(), reason: error.to_string() }
        }
    })?;
    Ok(file)
}

/// Refuses a database of another program, of a later version, or that is damaged.
fn check_content(connection: &Connection, path: &Path) -> Result<(), StoreError> {
    let pages: i32 = pragma(connection, path, "page_count")?;
    if pages > 0 && pragma::<i32>(connection, path, "application_id")? != APPLICATION_ID {
        return Err(StoreError::Foreign(path.to_owned()));
    }
    let version = pragma(connection, path, "user_version")?;
    if version > VERSION {
        return Err(StoreError::Newer { path: path.to_owned(), version });
    }
    let check: String = pragma(connection, path, "quick_check")?;
    if check == "ok" {
        Ok(())
    } else {
        Err(StoreError::Corrupt { path: path.to_owned(), reason: check.replace('\n', "; ") })
    }
}

fn pragma<T: FromSql>(connection: &Connection, path: &Path, name: &str) -> Result<T, StoreError> {
    let value = connection.pragma_query_value(None, name, |row| row.get(0));
    value.map_err(|error| sqlite_error(path, &error))
}

fn prepare(connection: &Connection) -> rusqlite::Result<()> {
    connection.execute_batch(
        "PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL; PRAGMA busy_timeout = 5000;",
    )?;
    migrate(connection)
}

fn migrate(connection: &Connection) -> rusqlite::Result<()> {
    let version: i32 = connection.pragma_query_value(None, "user_version", |row| row.get(0))?;
    if version == VERSION {
        return Ok(());
    }
    let steps = [SCHEMA, INTENDED_ROBOT, ROBOT_TYPES];
    let missing = steps.get(version.max(0) as usize..).unwrap_or_default().concat();
    connection.execute_batch(&format!(
        "BEGIN IMMEDIATE; PRAGMA application_id = {APPLICATION_ID}; PRAGMA user_version = {VERSION};
         {missing} COMMIT;"
    ))
}

fn sqlite_error(path: &Path, error: &rusqlite::Error) -> StoreError {
    let path = path.to_owned();
    match error.sqlite_error_code() {
        Some(ErrorCode::DatabaseCorrupt) => StoreError::Corrupt { path, reason: error.to_string() },
        Some(ErrorCode::NotADatabase) => StoreError::Foreign(path),
        Some(ErrorCode::DatabaseBusy | ErrorCode::DatabaseLocked) => StoreError::InUse(path),
        _ => StoreError::Io { path, reason: error.to_string() },
    }
}

#[cfg(test)]
mod tests;
