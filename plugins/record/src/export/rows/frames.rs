//! The table of frames: a row per robot and frame.

use regatta_plugin::ColumnName;
use regatta_plugin::column::ACTIVITY;
use regatta_plugin::frame::RobotState;

use super::super::ExportError;
use super::super::options::ExportArgs;
use super::{Column, Kind, Take, Value};
use crate::arguments::RobotIds;
use crate::reading::Recording;
use crate::table::{Snapshot, Span, for_each_snapshot};

/// Returns the columns of plugins to export: the requested ones, or all recorded ones.
pub(super) fn plugins(
    recording: &Recording,
    requested: Option<&[ColumnName]>,
) -> Result<Vec<ColumnName>, ExportError> {
    let recorded: Vec<_> =
        recording.topics().into_iter().filter_map(|topic| topic.column().cloned()).collect();
    let Some(requested) = requested else { return Ok(recorded) };
    if let Some(column) = requested.iter().find(|column| !recorded.contains(column)) {
        let recorded: Vec<_> = recorded.iter().map(ColumnName::as_str).collect();
        let recorded = recorded.join(", ");
        return Err(ExportError::NoColumn { column: column.clone(), recorded });
    }
    Ok(requested.to_vec())
}

/// Returns all columns. A plugin's column keeps its name, with underscores for hyphens as in the
/// names of other columns, or gets the prefix `column_` if another column has the name. Activities
/// are words.
pub(super) fn columns(plugins: &[ColumnName]) -> Vec<Column> {
    let mut columns = vec![
        Column::new("time_s", Kind::F64),
        Column::new("run", Kind::U32),
        Column::new("tick", Kind::U64),
        Column::new("sim_time_s", Kind::F64),
        Column::new("robot", Kind::U32),
        Column::new("x_m", Kind::F32),
        Column::new("y_m", Kind::F32),
        Column::new("theta_rad", Kind::F32),
        Column::new("speed_m_per_s", Kind::F32),
        Column::new("s_m", Kind::F32),
        Column::optional("edge", Kind::U32),
        Column::new("state", Kind::Text),
    ];
    let common = columns.len();
    for name in plugins {
        let mut title = name.as_str().replace('-', "_");
        if columns[..common].iter().any(|column| column.title == title) {
            title.insert_str(0, "column_");
        }
        // Two columns may differ only in that.
        if columns[common..].iter().any(|column| column.title == title) {
            title = name.to_string();
        }
        let kind = if is_activity(name) { Kind::Text } else { Kind::F32 };
        columns.push(Column::optional(&title, kind));
    }
    columns
}

/// Calls `take` with the rows of all requested robots, and returns their number.
pub(super) fn for_each(
    recording: &Recording,
    args: &ExportArgs,
    take: &mut Take<'_>,
) -> Result<u64, ExportError> {
    let plugins = plugins(recording, args.columns.as_deref())?;
    let robots = args.robots.clone().unwrap_or_else(RobotIds::all);
    let span = Span::of(recording, args.from, args.to);
    let (mut rows, mut most_robots, mut row) = (0, 0, Vec::new());
    for_each_snapshot(recording, &plugins, &span, |snapshot| -> Result<(), ExportError> {
        most_robots = most_robots.max(snapshot.len());
        let done = span.done(snapshot.time);
        for robot in robots.below(snapshot.len()) {
            if fill(&mut row, snapshot, robot, &plugins) {
                take(done, robot, &row)?;
                rows += 1;
            }
        }
        Ok(())
    })?;
    if rows == 0 && robots.first().is_some_and(|first| first as usize >= most_robots) {
        return Err(ExportError::NoRobots { last: most_robots.saturating_sub(1) });
    }
    Ok(rows)
}

/// Whether a column has the numbers of activities.
fn is_activity(column: &ColumnName) -> bool {
    column.as_str() == ACTIVITY.name()
}

/// Fills in the values of a robot in a frame. Returns `false` if the robot is absent.
fn fill(
    row: &mut Vec<Value>,
    snapshot: &Snapshot<'_>,
    robot: usize,
    plugins: &[ColumnName],
) -> bool {
    let Some(robot_row) = snapshot.row(robot) else { return false };
    let header = snapshot.header();
    row.clear();
    row.extend([
        Value::secs(snapshot.time.as_nanos()),
        Value::U32(snapshot.run),
        Value::U64(header.tick),
        Value::secs(header.sim_time_nanos.into()),
        Value::U32(robot as u32),
        Value::F32(robot_row.x),
        Value::F32(robot_row.y),
        Value::F32(robot_row.theta),
        Value::F32(robot_row.speed),
        Value::F32(robot_row.s),
        snapshot.edge(&robot_row).map(|edge| edge.id).into(),
        Value::Text(RobotState::from_number(robot_row.state).name()),
    ]);
    for (at, name) in plugins.iter().enumerate() {
        let value = snapshot.column(at, robot);
        row.push(if is_activity(name) { activity(value) } else { number(value) });
    }
    true
}

/// Returns the value of a column, which is missing if the robot has none: it is no number then.
fn number(value: Option<f32>) -> Value {
    value.filter(|value| !value.is_nan()).into()
}

/// Returns the word of an activity by its number; it is missing if no activity has the number.
fn activity(value: Option<f32>) -> Value {
    let activity = value.and_then(|value| ACTIVITY.element(value));
    activity.map_or(Value::Missing, |activity| Value::Text(activity.name()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn titles_have_underscores() {
        let titles = |names: &[&str]| -> Vec<String> {
            let names: Vec<ColumnName> = names.iter().map(|name| name.parse().unwrap()).collect();
            columns(&names).into_iter().skip(12).map(|column| column.title).collect()
        };
        assert_eq!(titles(&["waits-for", "sim-time_s"]), ["waits_for", "column_sim_time_s"]);
        assert_eq!(titles(&["my_load", "my-load"]), ["my_load", "my-load"]);
    }

    #[test]
    fn activities_are_words() {
        let names: Vec<ColumnName> = ["activity", "goal"].map(|name| name.parse().unwrap()).into();
        let kinds: Vec<_> =
            columns(&names).iter().rev().take(2).map(|column| column.kind).collect();
        assert_eq!(kinds, [Kind::F32, Kind::Text]);
        assert_eq!(activity(Some(2.0)), Value::Text("carrying"));
        assert_eq!(activity(Some(2.5)), Value::Missing);
        assert_eq!(activity(None), Value::Missing);
        assert_eq!([number(Some(f32::NAN)), number(None)], [Value::Missing; 2]);
    }
}
