//! Orders as rows of the store.

use rusqlite::Row;
use serde::{Deserialize, Serialize};

use crate::order::{Action, NewOrder, Order, OrderId, OrderName, State, Stop};
use crate::places::Places;

/// A stop in the column `stops`.
#[derive(Serialize, Deserialize)]
pub(super) struct StopRow {
    pub(super) node: u32,
    /// The name of the storage of which the stop has no place yet.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) storage: Option<String>,
    pub(super) action: Action,
    pub(super) dwell: f64,
}

impl StopRow {
    fn new(stop: &Stop, places: &Places) -> Self {
        Self {
            node: places.place(stop.node).id,
            storage: places.storage(stop.node).map(|_| places.label(stop.node)),
            action: stop.action,
            dwell: stop.dwell_secs,
        }
    }

    /// Returns the stop; `None` if the world doesn't have its node, or its time is none.
    fn stop(&self, places: &Places) -> Option<Stop> {
        let node = match &self.storage {
            Some(name) => places.find(name)?,
            None => places.with_id(self.node)?,
        };
        let is_time = self.dwell.is_finite() && self.dwell >= 0.0;
        is_time.then_some(Stop { node, action: self.action, dwell_secs: self.dwell })
    }
}

pub(super) fn stop_rows(stops: &[Stop], places: &Places) -> String {
    let rows: Vec<_> = stops.iter().map(|stop| StopRow::new(stop, places)).collect();
    // Numbers and fixed words: this can't fail.
    serde_json::to_string(&rows).unwrap_or_default()
}

/// The robot types of an order in the column `robot_types`.
pub(super) fn types_column(types: &[u32], places: &Places) -> Option<String> {
    let names = places.robot_type_names(types);
    (!names.is_empty()).then(|| serde_json::to_string(&names).unwrap_or_default())
}

/// The names in the column `robot_types`.
pub(super) fn type_names(column: Option<String>) -> Vec<String> {
    column.and_then(|text| serde_json::from_str(&text).ok()).unwrap_or_default()
}

/// Returns a row as an order; `None` if it names nodes or robot types that the world doesn't have,
/// or is invalid.
pub(super) fn order_of(
    row: &Row,
    places: &Places,
    is_same_run: bool,
    now_secs: f64,
    next_id: u64,
) -> rusqlite::Result<Option<Order>> {
    let rows: Vec<StopRow> = serde_json::from_str(row.get_ref(9)?.as_str()?).unwrap_or_default();
    let stops: Option<Vec<_>> = rows.iter().map(|row| row.stop(places)).collect();
    let name = OrderName::stored(row.get_ref(0)?.as_str()?);
    let types = places.robot_types(&type_names(row.get(12)?));
    let (Some(stops), Ok(name), Ok(robot_types)) =
        (stops.filter(|stops| !stops.is_empty()), name, types)
    else {
        return Ok(None);
    };
    let created_secs = row.get::<_, Option<f64>>(4)?.unwrap_or(now_secs);
    let deadline: Option<f64> = row.get(6)?;
    let mut content = NewOrder {
        name,
        priority: row.get(3)?,
        earliest_secs: row.get::<_, f64>(5)?.max(0.0),
        deadline_secs: deadline,
        intended_robot: row.get(11)?,
        robot_types,
        stops,
    };
    let mut order = Order {
        id: OrderId(row.get::<_, Option<u64>>(1)?.unwrap_or(next_id)),
        created_secs,
        state: state_of(row.get_ref(2)?.as_str()?, row.get(7)?),
        handled_stops: row.get::<_, usize>(8)?.min(content.stops.len() - 1),
        reason: String::new(),
        history: serde_json::from_str(row.get_ref(10)?.as_str()?).unwrap_or_default(),
        content: content.clone(),
    };
    if !is_same_run {
        content.earliest_secs = 0.0;
        content.deadline_secs =
            deadline.map(|deadline| now_secs + (deadline - created_secs).max(0.0));
        order = Order {
            content,
            created_secs: now_secs,
            state: State::Waiting,
            handled_stops: 0,
            history: Vec::new(),
            ..order
        };
    }
    Ok(Some(order))
}

fn state_of(name: &str, robot: Option<u32>) -> State {
    match (name, robot) {
        ("travelling", Some(robot)) => State::Travelling(robot),
        ("handling", Some(robot)) => State::Handling(robot),
        ("created", _) => State::Created,
        ("unroutable", _) => State::Unroutable,
        ("unplaced", _) => State::Unplaced,
        _ => State::Waiting,
    }
}
