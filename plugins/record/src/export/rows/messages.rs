//! The tables of events, orders, tasks and contacts: a row per record of a message.

use std::time::Duration;

use regatta_plugin::contact::{ContactEvent, ContactHeader, ContactRecord};
use regatta_plugin::event::{EventKind, EventRecord};
use regatta_plugin::order::OrderRecord;
use regatta_plugin::task::{NO_ROBOT, TaskRecord};
use regatta_plugin::world::EdgeRecord;

use super::super::ExportError;
use super::super::options::{ExportArgs, Table};
use super::super::value::{Column, Kind, Value};
use super::names::{ACTIONS, CHANGES, EVENTS, LEVELS, ORDERS, REFUSALS, TASKS, name};
use super::{Take, topics};
use crate::contacts::ContactDecoder;
use crate::decode::{self, MessageError};
use crate::reading::{Entry, Recording, Selection};
use crate::robot_ids::RobotIds;
use crate::schema::Topic;
use crate::table::Span;

/// Returns the columns of a table.
pub(super) fn columns(table: Table) -> Vec<Column> {
    use Kind::{F32, F64, Text, U32, U64};
    let column = Column::new;
    let common = [column("time_s", F64), column("run", U32), column("tick", U64)];
    let pair = || [column("robot", U32), column("other_robot", U32), column("level", Text)];
    let place = || {
        let edge = Column::optional("edge", U32);
        [edge, column("x_m", F32), column("y_m", F32), column("relative_speed_m_per_s", F32)]
    };
    let own = match table {
        Table::Frames => Vec::new(),
        Table::Events => {
            let id = Column::optional("id", U32);
            let refusal = Column::optional("refusal", Text);
            vec![column("robot", U32), column("kind", Text), id, column("token", U64), refusal]
        }
        Table::Orders => vec![
            column("robot", U32),
            column("kind", Text),
            column("id", U32),
            column("s_m", F32),
            column("reverse", U32),
            column("released", U32),
            column("robot_type", U32),
            column("legs", U32),
            column("token", U64),
        ],
        Table::Tasks => vec![
            column("task", U64),
            column("kind", Text),
            Column::optional("robot", U32),
            column("stop", U32),
            column("node", U32),
            column("action", Text),
            column("dwell_s", F32),
            column("detail", U32),
        ],
        Table::Contacts => {
            let since = [column("since_tick", U64), column("since_s", F64)];
            pair().into_iter().chain(since).chain(place()).collect()
        }
        Table::ContactEvents => {
            pair().into_iter().chain([column("change", Text)]).chain(place()).collect()
        }
    };
    common.into_iter().chain(own).collect()
}

/// The rows of messages.
struct Rows<'a> {
    table: Table,
    robots: RobotIds,
    /// The ids of the runs so far.
    runs: Vec<u64>,
    edges: Vec<EdgeRecord>,
    contacts: ContactDecoder,
    row: Vec<Value>,
    count: u64,
    take: &'a mut Take<'a>,
}

/// What the rows of a message have in common.
#[derive(Clone, Copy)]
struct Moment {
    done: f64,
    time: Duration,
    run_id: u64,
    tick: u64,
}

/// Calls `take` with the rows of a table, and returns their number.
pub(super) fn for_each<'a>(
    recording: &Recording,
    table: Table,
    args: &ExportArgs,
    take: &'a mut Take<'a>,
) -> Result<u64, ExportError> {
    let span = Span::of(recording, args.from, args.to);
    let mut rows = Rows {
        table,
        robots: args.robots.clone().unwrap_or_else(RobotIds::all),
        runs: Vec::new(),
        edges: Vec::new(),
        contacts: recording.contacts_before(span.from)?,
        row: Vec::new(),
        count: 0,
        take,
    };
    if let Some((time, world)) = recording.state_before(&Topic::World, span.from)? {
        rows.take_world(&world)
            .map_err(|reason| recording.malformed(&Topic::World, time, reason))?;
    }
    let topics = [Topic::World].into_iter().chain(topics(table)).collect();
    let mut reader = recording.read(&Selection { from: span.from, to: span.to, topics })?;
    while let Some(entry) = reader.next()? {
        let (topic, log_time) = (entry.topic, entry.log_time);
        let taken = rows.take_entry(&entry, span.done(Duration::from_nanos(log_time)));
        taken.map_err(|reason| recording.malformed(topic, log_time, reason))??;
    }
    Ok(rows.count)
}

impl Rows<'_> {
    /// Takes a message. The outer error is one of decoding it, the inner one of writing its rows.
    fn take_entry(
        &mut self,
        entry: &Entry<'_>,
        done: f64,
    ) -> Result<Result<(), ExportError>, MessageError> {
        let time = Duration::from_nanos(entry.log_time);
        let moment = |run_id, tick| Moment { done, time, run_id, tick };
        match entry.topic {
            Topic::World => self.take_world(entry.message)?,
            Topic::Events => {
                let (header, events) = decode::events(entry.message)?;
                return Ok(self.rows(moment(header.run_id, header.tick), &events, Self::event));
            }
            Topic::Orders => {
                let (run_id, tick, orders) = decode::orders(entry.message)?;
                return Ok(self.rows(moment(run_id, tick), &orders, Self::order));
            }
            Topic::Tasks => {
                let (header, tasks, _) = decode::tasks(entry.message)?;
                return Ok(self.rows(moment(header.run_id, header.tick), &tasks, Self::task));
            }
            Topic::ContactEvents => {
                let (run_id, tick, events) = decode::contact_events(entry.message)?;
                return Ok(self.rows(moment(run_id, tick), &events, Self::contact_event));
            }
            topic => {
                let is_new = self.contacts.decode(topic, entry.message)?;
                let list = self.contacts.list().filter(|_| is_new);
                if let Some((header, pairs)) = list.map(|(header, pairs)| (*header, pairs.to_vec()))
                {
                    let ContactHeader { run_id, tick, .. } = header;
                    return Ok(self.rows(moment(run_id, tick), &pairs, Self::contact));
                }
            }
        }
        Ok(Ok(()))
    }

    fn take_world(&mut self, message: &[u8]) -> Result<(), MessageError> {
        let world = decode::world(message)?;
        self.run(world.run_id);
        self.edges = world.data.edges;
        Ok(())
    }

    /// Returns the number of a run in the recording, from 0.
    fn run(&mut self, run_id: u64) -> u32 {
        let known = self.runs.iter().position(|known| *known == run_id);
        known.unwrap_or_else(|| {
            self.runs.push(run_id);
            self.runs.len() - 1
        }) as u32
    }

    /// Writes a row for each record of a message.
    fn rows<R>(
        &mut self,
        moment: Moment,
        records: &[R],
        fill: fn(&Self, &R, &mut Vec<Value>) -> [Option<u32>; 2],
    ) -> Result<(), ExportError> {
        let run = self.run(moment.run_id);
        for record in records {
            let mut row = std::mem::take(&mut self.row);
            row.clear();
            row.extend([
                Value::F64(moment.time.as_secs_f64()),
                Value::U32(run),
                Value::U64(moment.tick),
            ]);
            let robots = fill(self, record, &mut row);
            if robots.iter().flatten().any(|robot| self.robots.contains(*robot)) {
                debug_assert_eq!(row.len(), columns(self.table).len(), "a value per column");
                (self.take)(moment.done, robots[0].unwrap_or(0) as usize, &row)?;
                self.count += 1;
            }
            self.row = row;
        }
        Ok(())
    }

    /// Fills in an event, and returns its robot.
    fn event(&self, event: &EventRecord, row: &mut Vec<Value>) -> [Option<u32>; 2] {
        let is_refusal = event.kind() == Some(EventKind::Refused);
        // Other events have neither a node nor a refused id.
        let has_id = is_refusal || event.kind() == Some(EventKind::ReachedNode);
        let refusal = if is_refusal { name(&REFUSALS, event.detail) } else { Value::Missing };
        let (kind, id) = (name(&EVENTS, event.kind), has_id.then_some(event.id));
        row.extend([Value::U32(event.robot), kind, id.into(), Value::U64(event.token), refusal]);
        [Some(event.robot), None]
    }

    /// Fills in an order or one of its legs, and returns its robot.
    fn order(&self, order: &OrderRecord, row: &mut Vec<Value>) -> [Option<u32>; 2] {
        row.extend([
            Value::U32(order.robot),
            name(&ORDERS, order.kind),
            Value::U32(order.id),
            Value::F32(order.s),
            Value::U32(order.reverse),
            Value::U32(order.released),
            Value::U32(order.robot_type),
            Value::U32(order.legs),
            Value::U64(order.token),
        ]);
        [Some(order.robot), None]
    }

    /// Fills in what happened to a task, and returns its robot.
    fn task(&self, task: &TaskRecord, row: &mut Vec<Value>) -> [Option<u32>; 2] {
        let robot = Some(task.robot).filter(|robot| *robot != NO_ROBOT);
        row.extend([
            Value::U64(task.task),
            name(&TASKS, task.kind),
            robot.into(),
            Value::U32(task.stop),
            Value::U32(task.node),
            name(&ACTIONS, task.action),
            Value::F32(task.dwell_secs),
            Value::U32(task.detail),
        ]);
        // Without a robot, it belongs to all exports but those of some robots.
        [Some(task.robot), None]
    }

    fn contact(&self, pair: &ContactRecord, row: &mut Vec<Value>) -> [Option<u32>; 2] {
        let [robot, other] = pair.robots;
        let since = pair.since_nanos as f64 * 1e-9;
        let level = name(&LEVELS, pair.level);
        row.extend([
            Value::U32(robot),
            Value::U32(other),
            level,
            Value::U64(pair.since_tick),
            Value::F64(since),
        ]);
        row.extend(self.place(pair.edge, [pair.x, pair.y, pair.relative_speed]));
        [Some(robot), Some(other)]
    }

    fn contact_event(&self, event: &ContactEvent, row: &mut Vec<Value>) -> [Option<u32>; 2] {
        let [robot, other] = event.robots;
        row.extend([
            Value::U32(robot),
            Value::U32(other),
            name(&LEVELS, event.level),
            name(&CHANGES, event.change),
        ]);
        row.extend(self.place(event.edge, [event.x, event.y, event.relative_speed]));
        [Some(robot), Some(other)]
    }

    /// Returns the id of an edge, and where and how fast two robots meet.
    fn place(&self, edge: u32, [x, y, speed]: [f32; 3]) -> [Value; 4] {
        let edge = self.edges.get(edge as usize).map(|edge| edge.id);
        [edge.into(), Value::F32(x), Value::F32(y), Value::F32(speed)]
    }
}
