//! The tables of events, commands, orders and contacts: a row per record of a message.

use std::time::Duration;

use regatta_plugin::command::CommandRecord;
use regatta_plugin::contact::{ContactEvent, ContactHeader, ContactRecord};
use regatta_plugin::event::{EventHeader, EventKind, EventRecord};
use regatta_plugin::order::{NO_ROBOT, OrderHeader, OrderRecord};
use regatta_plugin::world::EdgeRecord;

use super::super::ExportError;
use super::super::options::{ExportArgs, Table};
use super::names::{ACTIONS, CAUSES, CHANGES, COMMANDS, EVENTS, LEVELS, ORDERS, REFUSALS, name};
use super::{Column, Kind, Take, Value, topics};
use crate::arguments::RobotIds;
use crate::contacts::ContactDecoder;
use crate::decode;
use crate::reading::{Entry, Recording, Selection};
use crate::schema::Topic;
use crate::table::Span;

/// Returns the columns of a table.
pub(super) fn columns(table: Table) -> Vec<Column> {
    use Kind::{F32, F64, Text, U32, U64};
    let column = Column::new;
    let common = [column("time_s", F64), column("run", U32), column("tick", U64)];
    let pair = [column("robot", U32), column("other_robot", U32), column("level", Text)];
    let place = [
        Column::optional("edge", U32),
        column("x_m", F32),
        column("y_m", F32),
        column("relative_speed_m_per_s", F32),
    ];
    let own = match table {
        Table::Frames => Vec::new(),
        Table::Events => vec![
            column("robot", U32),
            column("kind", Text),
            Column::optional("id", U32),
            column("token", U64),
            Column::optional("refusal", Text),
            Column::optional("cause", Text),
        ],
        Table::Commands => vec![
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
        Table::Orders => vec![
            column("order", U64),
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
            pair.into_iter().chain(since).chain(place).collect()
        }
        Table::ContactEvents => {
            pair.into_iter().chain([column("change", Text)]).chain(place).collect()
        }
    };
    common.into_iter().chain(own).collect()
}

/// The writer of the rows of messages.
struct Rows<'a> {
    recording: &'a Recording,
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

/// The values that the rows of a message share.
#[derive(Clone, Copy)]
struct Moment {
    /// The progress from 0 to 1.
    done: f64,
    time: Duration,
    run_id: u64,
    tick: u64,
}

/// The robot of a row, and the other one of a pair.
type Robots = (u32, Option<u32>);

/// Calls `take` with the rows of a table, and returns their number.
pub(super) fn for_each<'a>(
    recording: &'a Recording,
    table: Table,
    args: &ExportArgs,
    take: &'a mut Take<'a>,
) -> Result<u64, ExportError> {
    let span = Span::of(recording, args.from, args.to);
    let mut rows = Rows {
        recording,
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
        rows.take_world(time, &world)?;
    }
    let topics = [Topic::World].into_iter().chain(topics(table)).collect();
    let mut reader = recording.read(&Selection { from: span.from, to: span.to, topics })?;
    while let Some(entry) = reader.next()? {
        rows.take_entry(&entry, span.done(Duration::from_nanos(entry.log_time)))?;
    }
    Ok(rows.count)
}

impl Rows<'_> {
    /// Writes the rows of a message.
    fn take_entry(&mut self, entry: &Entry<'_>, done: f64) -> Result<(), ExportError> {
        let Entry { topic, log_time, message } = *entry;
        let time = Duration::from_nanos(log_time);
        match topic {
            Topic::World => self.take_world(log_time, message)?,
            Topic::Events => {
                let decoded = decode::events(message);
                let (header, events) = self.recording.located(topic, log_time, decoded)?;
                let EventHeader { run_id, tick, .. } = header;
                self.rows(Moment { done, time, run_id, tick }, &events, Self::event)?;
            }
            Topic::Commands => {
                let decoded = decode::commands(message);
                let (run_id, tick, commands) = self.recording.located(topic, log_time, decoded)?;
                self.rows(Moment { done, time, run_id, tick }, &commands, Self::command)?;
            }
            Topic::Orders => {
                let decoded = decode::orders(message);
                let (header, orders, _) = self.recording.located(topic, log_time, decoded)?;
                let OrderHeader { run_id, tick, .. } = header;
                self.rows(Moment { done, time, run_id, tick }, &orders, Self::order)?;
            }
            Topic::ContactEvents => {
                let decoded = decode::contact_events(message);
                let (run_id, tick, events) = self.recording.located(topic, log_time, decoded)?;
                self.rows(Moment { done, time, run_id, tick }, &events, Self::contact_event)?;
            }
            topic => {
                let decoded = self.contacts.decode(topic, message);
                let is_new = self.recording.located(topic, log_time, decoded)?;
                if let Some((header, pairs)) = self.contacts.list().filter(|_| is_new) {
                    let (ContactHeader { run_id, tick, .. }, pairs) = (*header, pairs.to_vec());
                    self.rows(Moment { done, time, run_id, tick }, &pairs, Self::contact)?;
                }
            }
        }
        Ok(())
    }

    fn take_world(&mut self, log_time: u64, message: &[u8]) -> Result<(), ExportError> {
        let world = self.recording.located(&Topic::World, log_time, decode::world(message))?;
        self.run(world.run_id);
        self.edges = world.data.edges;
        Ok(())
    }

    /// Returns the number of a run in the recording, from 0.
    fn run(&mut self, run_id: u64) -> u32 {
        let known = self.runs.iter().position(|known| *known == run_id);
        let run = known.unwrap_or(self.runs.len());
        if known.is_none() {
            self.runs.push(run_id);
        }
        run as u32
    }

    /// Writes a row for each record of a message.
    fn rows<R>(
        &mut self,
        moment: Moment,
        records: &[R],
        fill: fn(&Self, &R, &mut Vec<Value>) -> Robots,
    ) -> Result<(), ExportError> {
        let run = self.run(moment.run_id);
        for record in records {
            let mut row = std::mem::take(&mut self.row);
            row.clear();
            row.extend([
                Value::secs(moment.time.as_nanos()),
                Value::U32(run),
                Value::U64(moment.tick),
            ]);
            let (robot, other) = fill(self, record, &mut row);
            let is_requested = self.robots.contains(robot)
                || other.is_some_and(|other| self.robots.contains(other));
            if is_requested {
                debug_assert_eq!(row.len(), columns(self.table).len(), "a value per column");
                (self.take)(moment.done, robot as usize, &row)?;
                self.count += 1;
            }
            self.row = row;
        }
        Ok(())
    }

    /// Fills in an event, and returns its robot.
    fn event(&self, event: &EventRecord, row: &mut Vec<Value>) -> Robots {
        let [mut refusal, mut cause] = [Value::Missing; 2];
        match event.kind() {
            Some(EventKind::Refused) => refusal = name(&REFUSALS, event.detail),
            Some(EventKind::BrokenDown) => cause = name(&CAUSES, event.detail),
            _ => {}
        }
        let (kind, id) = (name(&EVENTS, event.kind), has_id(event).then_some(event.id));
        row.extend([Value::U32(event.robot), kind, id.into(), Value::U64(event.token)]);
        row.extend([refusal, cause]);
        (event.robot, None)
    }

    /// Fills in a command or one of its legs, and returns its robot.
    fn command(&self, command: &CommandRecord, row: &mut Vec<Value>) -> Robots {
        row.extend([
            Value::U32(command.robot),
            name(&COMMANDS, command.kind),
            Value::U32(command.id),
            Value::F32(command.s),
            Value::U32(command.reverse),
            Value::U32(command.released),
            Value::U32(command.robot_type),
            Value::U32(command.legs),
            Value::U64(command.token),
        ]);
        (command.robot, None)
    }

    /// Fills in a record of the order log, and returns its robot.
    fn order(&self, order: &OrderRecord, row: &mut Vec<Value>) -> Robots {
        let robot = Some(order.robot).filter(|robot| *robot != NO_ROBOT);
        row.extend([
            Value::U64(order.order),
            name(&ORDERS, order.kind),
            robot.into(),
            Value::U32(order.stop),
            Value::U32(order.node),
            name(&ACTIONS, order.action),
            Value::F32(order.dwell_secs),
            Value::U32(order.detail),
        ]);
        // A record without a robot belongs to all exports but those of some robots.
        (order.robot, None)
    }

    fn contact(&self, pair: &ContactRecord, row: &mut Vec<Value>) -> Robots {
        let [robot, other] = pair.robots;
        row.extend([
            Value::U32(robot),
            Value::U32(other),
            name(&LEVELS, pair.level),
            Value::U64(pair.since_tick),
            Value::secs(pair.since_nanos.into()),
            self.edge(pair.edge),
            Value::F32(pair.x),
            Value::F32(pair.y),
            Value::F32(pair.relative_speed),
        ]);
        (robot, Some(other))
    }

    fn contact_event(&self, event: &ContactEvent, row: &mut Vec<Value>) -> Robots {
        let [robot, other] = event.robots;
        row.extend([
            Value::U32(robot),
            Value::U32(other),
            name(&LEVELS, event.level),
            name(&CHANGES, event.change),
            self.edge(event.edge),
            Value::F32(event.x),
            Value::F32(event.y),
            Value::F32(event.relative_speed),
        ]);
        (robot, Some(other))
    }

    /// Returns the id of an edge of the world.
    fn edge(&self, index: u32) -> Value {
        self.edges.get(index as usize).map(|edge| edge.id).into()
    }
}

/// Whether an event has the id of a node or an edge, or of what was refused.
fn has_id(event: &EventRecord) -> bool {
    use EventKind::{
        DoorClosed, DoorOpened, EdgeClosed, EdgeOpened, LiftArrived, ReachedNode, Refused,
    };
    let places = [ReachedNode, EdgeClosed, EdgeOpened, DoorOpened, DoorClosed, LiftArrived];
    event.kind().is_some_and(|kind| kind == Refused || places.contains(&kind))
}
