//! Orders that only the store has: those that are over and forgotten by the book, of this run or an
//! earlier one. They are read on demand.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use parking_lot::Mutex;
use rusqlite::{Connection, OpenFlags, Row, params};
use serde_json::{Value, json};

use super::{StopRow, StoreError, optional, sqlite_error};
use crate::tasks::order::OrderName;
use crate::tasks::places::Places;

/// What the columns of a row are, in the order in which they are read.
const COLUMNS: &str = "name, state, reason, robot, priority, created, earliest, deadline, handled_stops, stops, history, intended_robot";
/// The states of orders that aren't over, as the index `open_order` has them.
const IS_OPEN: &str = "state NOT IN ('finished', 'failed', 'cancelled')";

/// How long to wait for another connection's lock.
const LOCK_TIMEOUT: Duration = Duration::from_secs(5);

/// A second connection to an open store, to read.
pub(in crate::tasks) struct Archive {
    connection: Mutex<Connection>,
    path: PathBuf,
    places: Arc<Places>,
}

/// Which orders to read: so many, in the order of their names.
pub(in crate::tasks) struct Page {
    /// `open`, a state, or any.
    pub(in crate::tasks) state: Option<String>,
    /// Only names after this one.
    pub(in crate::tasks) after: Option<OrderName>,
    /// The largest number of orders.
    pub(in crate::tasks) limit: usize,
}

impl Archive {
    /// Opens the store for reading, which this process has open for writing.
    pub(in crate::tasks) fn open(path: &Path, places: Arc<Places>) -> Result<Self, StoreError> {
        let connection = Connection::open_with_flags(path, OpenFlags::SQLITE_OPEN_READ_ONLY)
            .and_then(|connection| connection.busy_timeout(LOCK_TIMEOUT).map(|()| connection))
            .map_err(|error| sqlite_error(path, &error))?;
        Ok(Self { connection: Mutex::new(connection), path: path.to_owned(), places })
    }

    /// Returns an order as the web API shows it.
    pub(in crate::tasks) fn order(&self, name: &OrderName) -> Result<Option<Value>, StoreError> {
        let connection = self.connection.lock();
        let query = format!("SELECT {COLUMNS} FROM transport_order WHERE name = ?");
        let order = connection.prepare_cached(&query).and_then(|mut statement| {
            optional(statement.query_row([name.as_str()], |row| self.json(row)))
        });
        order.map_err(|error| sqlite_error(&self.path, &error))
    }

    /// Returns orders with their names, without those that are `known` elsewhere.
    pub(in crate::tasks) fn page(
        &self,
        page: &Page,
        known: impl Fn(&str) -> bool,
    ) -> Result<Vec<(String, Value)>, StoreError> {
        let read = || {
            let connection = self.connection.lock();
            let is_final = |state: &str| ["finished", "failed", "cancelled"].contains(&state);
            // Few orders are open among millions that are over.
            let condition = match page.state.as_deref() {
                None => "WHERE ?2 IS NULL".to_owned(),
                Some("open") => format!("INDEXED BY open_order WHERE ?2 = 'open' AND {IS_OPEN}"),
                Some(state) if is_final(state) => "WHERE state = ?2".to_owned(),
                Some(_) => format!("INDEXED BY open_order WHERE state = ?2 AND {IS_OPEN}"),
            };
            let mut statement = connection.prepare_cached(&format!(
                "SELECT {COLUMNS} FROM transport_order {condition} AND name > ?1 ORDER BY name"
            ))?;
            let after = page.after.as_ref().map_or("", OrderName::as_str);
            let mut rows = statement.query(params![after, page.state])?;
            let mut found = Vec::new();
            while found.len() < page.limit
                && let Some(row) = rows.next()?
            {
                let name: String = row.get(0)?;
                if !known(&name) {
                    found.push((name, self.json(row)?));
                }
            }
            Ok(found)
        };
        read().map_err(|error| sqlite_error(&self.path, &error))
    }

    /// Returns the largest number N of an order `order-N`. Longer numbers than one ever comes to
    /// are names of users.
    pub(in crate::tasks) fn last_number(&self) -> Result<u64, StoreError> {
        let query = "SELECT ifnull(max(CAST(substr(name, 7) AS INTEGER)), 0) FROM transport_order
                     WHERE name > 'order-' AND name < 'order.' AND length(name) <= 18";
        let number = self.connection.lock().query_row(query, [], |row| row.get(0));
        number
            .map(|number: i64| number.unsigned_abs())
            .map_err(|error| sqlite_error(&self.path, &error))
    }

    /// Returns a row as [`json::order`](crate::tasks::web) returns an order. Its nodes may not be
    /// in this world.
    fn json(&self, row: &Row) -> rusqlite::Result<Value> {
        let handled: usize = row.get(8)?;
        let stops: Vec<StopRow> =
            serde_json::from_str(&row.get::<_, String>(9)?).unwrap_or_default();
        let destination = |(index, stop): (usize, &StopRow)| {
            let label = self.places.with_id(stop.node).map(|node| self.places.label(node));
            json!({
                "locationName": label.unwrap_or_else(|| stop.node.to_string()),
                "node": stop.node,
                "operation": stop.action,
                "dwell": stop.dwell,
                "state": if index < handled { "finished" } else { "pristine" },
            })
        };
        Ok(json!({
            "name": row.get::<_, String>(0)?,
            "state": row.get::<_, String>(1)?,
            "reason": row.get::<_, String>(2)?,
            "processingVehicle": row.get::<_, Option<u32>>(3)?.map(|robot| robot.to_string()),
            "intendedVehicle": row.get::<_, Option<u32>>(11)?.map(|robot| robot.to_string()),
            "priority": row.get::<_, u8>(4)?,
            "created": row.get::<_, Option<f64>>(5)?,
            "earliestStart": row.get::<_, f64>(6)?,
            "deadline": row.get::<_, Option<f64>>(7)?,
            "destinations": stops.iter().enumerate().map(destination).collect::<Vec<_>>(),
            "history": serde_json::from_str::<Value>(&row.get::<_, String>(10)?).unwrap_or_else(|_| json!([])),
        }))
    }
}
