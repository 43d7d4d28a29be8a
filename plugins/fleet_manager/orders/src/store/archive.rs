//! Orders that only the store has: those that are over and forgotten by the pool, of this run or an
//! earlier one. They are read on demand.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use parking_lot::Mutex;
use rusqlite::{Connection, OpenFlags, OptionalExtension as _, Row, params};

use super::row::{StopRow, type_names};
use super::{StoreError, sqlite_error};
use crate::order::OrderName;
use crate::places::Places;
use crate::view::{Destination, Page, TransportOrder};

/// The columns of a row, in the order in which they are read.
const COLUMNS: &str = "name, state, reason, robot, priority, created, earliest, deadline, \
                       handled_stops, stops, history, intended_robot, robot_types";
/// The states of orders that aren't over, as the index `open_order` has them.
const IS_OPEN: &str = "state NOT IN ('finished', 'failed', 'cancelled')";

/// The longest wait for another connection's lock.
const LOCK_TIMEOUT: Duration = Duration::from_secs(5);

/// A second connection to an open store, to read.
pub(crate) struct Archive {
    connection: Mutex<Connection>,
    path: PathBuf,
    places: Arc<Places>,
}

impl Archive {
    /// Opens the store for reading, which this process has open for writing.
    pub(crate) fn open(path: &Path, places: Arc<Places>) -> Result<Self, StoreError> {
        let connection = Connection::open_with_flags(path, OpenFlags::SQLITE_OPEN_READ_ONLY)
            .and_then(|connection| connection.busy_timeout(LOCK_TIMEOUT).map(|()| connection))
            .map_err(|error| sqlite_error(path, &error))?;
        Ok(Self { connection: Mutex::new(connection), path: path.to_owned(), places })
    }

    /// Returns an order as the web API shows it.
    pub(crate) fn order(&self, name: &OrderName) -> Result<Option<TransportOrder>, StoreError> {
        let connection = self.connection.lock();
        let query = format!("SELECT {COLUMNS} FROM transport_order WHERE name = ?");
        let order = connection.prepare_cached(&query).and_then(|mut statement| {
            statement.query_row([name.as_str()], |row| self.view(row)).optional()
        });
        order.map_err(|error| sqlite_error(&self.path, &error))
    }

    /// Returns the names of the orders of a page, without those that are `known` elsewhere.
    pub(crate) fn names(
        &self,
        page: &Page,
        known: impl Fn(&OrderName) -> bool,
    ) -> Result<Vec<OrderName>, StoreError> {
        self.read_names(page, known).map_err(|error| sqlite_error(&self.path, &error))
    }

    fn read_names(
        &self,
        page: &Page,
        known: impl Fn(&OrderName) -> bool,
    ) -> rusqlite::Result<Vec<OrderName>> {
        let connection = self.connection.lock();
        // Few orders are open among millions that are over.
        let condition = match page.state.as_deref() {
            None => "WHERE ?2 IS NULL".to_owned(),
            Some("open") => format!("INDEXED BY open_order WHERE ?2 = 'open' AND {IS_OPEN}"),
            Some("finished" | "failed" | "cancelled") => "WHERE state = ?2".to_owned(),
            Some(_) => format!("INDEXED BY open_order WHERE state = ?2 AND {IS_OPEN}"),
        };
        let mut statement = connection.prepare_cached(&format!(
            "SELECT name FROM transport_order {condition} AND name > ?1 ORDER BY name"
        ))?;
        let after = page.after.as_ref().map_or("", OrderName::as_str);
        let mut rows = statement.query(params![after, page.state])?;
        let mut found = Vec::new();
        while found.len() < page.limit
            && let Some(row) = rows.next()?
        {
            // Another program may have written a name that isn't one.
            let name = OrderName::stored(row.get_ref(0)?.as_str()?).ok();
            found.extend(name.filter(|name| !known(name)));
        }
        Ok(found)
    }

    /// Returns the largest number N of an order `order-N`. Longer numbers than one ever comes to
    /// are names of users.
    pub(crate) fn last_number(&self) -> Result<u64, StoreError> {
        let query = "SELECT ifnull(max(CAST(substr(name, 7) AS INTEGER)), 0) FROM transport_order
                     WHERE name > 'order-' AND name < 'order.' AND length(name) <= 18";
        let number = self.connection.lock().query_row(query, [], |row| row.get(0));
        number
            .map(|number: i64| number.unsigned_abs())
            .map_err(|error| sqlite_error(&self.path, &error))
    }

    /// Returns a row as the web API shows it. Its nodes may not be in this world.
    fn view(&self, row: &Row) -> rusqlite::Result<TransportOrder> {
        let handled: usize = row.get(8)?;
        let stops: Vec<StopRow> =
            serde_json::from_str(&row.get::<_, String>(9)?).unwrap_or_default();
        let mut destinations = Vec::with_capacity(stops.len());
        for (index, stop) in stops.into_iter().enumerate() {
            let label = self.places.with_id(stop.node).map(|node| self.places.label(node));
            destinations.push(Destination {
                dwell: stop.dwell,
                location_name: label.unwrap_or_else(|| stop.node.to_string()),
                node: stop.node,
                operation: stop.action,
                state: if index < handled { "finished" } else { "pristine" },
            });
        }
        Ok(TransportOrder {
            created: row.get(5)?,
            deadline: row.get(7)?,
            destinations,
            earliest_start: row.get(6)?,
            history: serde_json::from_str(&row.get::<_, String>(10)?).unwrap_or_default(),
            intended_vehicle: row.get::<_, Option<u32>>(11)?.map(|robot| robot.to_string()),
            name: row.get(0)?,
            priority: row.get(4)?,
            processing_vehicle: row.get::<_, Option<u32>>(3)?.map(|robot| robot.to_string()),
            reason: row.get(2)?,
            robot_types: type_names(row.get(12)?),
            state: row.get(1)?,
        })
    }
}
