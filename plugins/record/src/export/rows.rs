//! The rows of tables.

mod frames;
mod messages;
mod names;

use regatta_plugin::ColumnName;

use super::ExportError;
use super::options::{ExportArgs, Table};
use super::value::{Column, Value};
use crate::reading::Recording;
use crate::schema::Topic;

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
        Table::Orders => vec![Topic::Orders],
        Table::Tasks => vec![Topic::Tasks],
        Table::Contacts => vec![Topic::Contacts, Topic::ContactUpdates],
        Table::ContactEvents => vec![Topic::ContactEvents],
    }
}
