//! The columns and rows of tables.

mod frames;
mod messages;
mod names;

use regatta_plugin::ColumnName;

use super::ExportError;
use super::options::{ExportArgs, Table};
use crate::reading::Recording;
use crate::schema::Topic;

/// One value of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Value {
    Missing,
    U32(u32),
    U64(u64),
    F32(f32),
    F64(f64),
    Text(&'static str),
}

/// The type of a column's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    U32,
    U64,
    F32,
    F64,
    Text,
}

/// A column of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Column {
    /// The title names the unit.
    pub title: String,
    pub kind: Kind,
    /// Whether values may be missing.
    pub is_optional: bool,
}

impl Column {
    /// Returns a column that has a value in each row.
    pub fn new(title: &str, kind: Kind) -> Self {
        Self { title: title.to_owned(), kind, is_optional: false }
    }

    /// Returns a column in which values may be missing.
    pub fn optional(title: &str, kind: Kind) -> Self {
        Self { is_optional: true, ..Self::new(title, kind) }
    }
}

impl Value {
    /// Returns a time in seconds: the nearest number, which is written with the fewest digits.
    /// (A product with 1e-9 isn't the nearest one: 116.72 s would be 116.72000000000001.)
    pub fn secs(nanos: u128) -> Self {
        Self::F64(nanos as f64 / 1e9)
    }
}

impl From<Option<u32>> for Value {
    fn from(value: Option<u32>) -> Self {
        value.map_or(Self::Missing, Self::U32)
    }
}

impl From<Option<f32>> for Value {
    fn from(value: Option<f32>) -> Self {
        value.map_or(Self::Missing, Self::F32)
    }
}

/// Takes a row: the progress from 0 to 1, the robot that it belongs to, and the values.
pub(super) type Take<'t> = dyn FnMut(f64, usize, &[Value]) -> Result<(), ExportError> + 't;

/// Returns the columns of a table. `requested` are columns of plugins, for the table of frames.
pub(super) fn columns(
    recording: &Recording,
    table: Table,
    requested: Option<&[ColumnName]>,
) -> Result<Vec<Column>, ExportError> {
    let topics = topics(table);
    if topics.iter().all(|topic| recording.count(topic) == 0) {
        let recorded: Vec<_> = recording.topics().iter().map(Topic::name).collect();
        return Err(ExportError::NoTopic {
            table: table.file_stem(),
            recorded: recorded.join(", "),
        });
    }
    match table {
        Table::Frames => Ok(frames::columns(&frames::plugins(recording, requested)?)),
        table => Ok(messages::columns(table)),
    }
}

/// Calls `take` with the rows of a table in order of time, and returns their number.
pub(super) fn for_each(
    recording: &Recording,
    table: Table,
    args: &ExportArgs,
    take: &mut Take<'_>,
) -> Result<u64, ExportError> {
    match table {
        Table::Frames => frames::for_each(recording, args, take),
        table => messages::for_each(recording, table, args, take),
    }
}

/// Returns the topics of a table.
fn topics(table: Table) -> Vec<Topic> {
    match table {
        Table::Frames => vec![Topic::Frames],
        Table::Events => vec![Topic::Events],
        Table::Commands => vec![Topic::Commands],
        Table::Orders => vec![Topic::Orders],
        Table::Contacts => vec![Topic::Contacts, Topic::ContactUpdates],
        Table::ContactEvents => vec![Topic::ContactEvents],
    }
}

#[cfg(test)]
mod tests {
    use super::Value;

    #[test]
    fn times_have_no_digits_of_rounding() {
        for tick in 0..200_000_u64 {
            let Value::F64(secs) = Value::secs((tick * 10_000_000).into()) else { panic!() };
            let (whole, hundredths) = (tick / 100, tick % 100);
            let shortest = format!("{whole}.{hundredths:02}");
            assert_eq!(secs.to_string(), shortest.trim_end_matches('0').trim_end_matches('.'));
        }
    }
}
