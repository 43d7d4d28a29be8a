//! The thread that polls the fleet for the interface: the order of the fleet list, columns, values
//! and routes.

use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, TryRecvError};
use std::time::{Duration, Instant};

use regatta_interface::orders::OpenOrders;
use regatta_interface::robot_filter::{Filter, FilterColumns};
use regatta_interface::rows::{RowQuery, Rows};
use regatta_plugin::column::{ACTIVITY, TYPE};
use regatta_plugin::work::WorkFigures;
use regatta_plugin::{
    ColumnName, ColumnReader, FleetName, OrderReader, Participant, ReadError, Result, Subscriber,
    WorkReader, WorldReader, column_names,
};

use super::{Fact, Report};
use crate::link::routes::RoutePoller;

/// The time between two sorts of the fleet list.
const SORT_EVERY: Duration = Duration::from_millis(700);
/// The time between two lists of the columns, each of which goes through all services of the
/// machine.
const LIST_EVERY: Duration = Duration::from_secs(2);
/// The time between two looks at which robots match the filter.
const FILTER_EVERY: Duration = Duration::from_millis(200);
/// The time between two reads of the selected robot's values.
const VALUES_EVERY: Duration = Duration::from_millis(200);
/// The time between two looks at the order log, which keeps some tens of ticks for a reader.
const ORDERS_EVERY: Duration = Duration::from_millis(100);
/// The time between two reads of the figures of work.
const WORK_EVERY: Duration = Duration::from_millis(500);
/// The timeout of a request for routes, which delays all other polls.
const ROUTE_TIMEOUT: Duration = Duration::from_millis(100);
/// The maximum number of columns that are read for the selected robot. Each occupies a reader's
/// place at the column.
const MAX_COLUMNS: usize = 16;

/// A change of the polled data.
#[derive(Debug)]
pub enum Query {
    Rows(RowQuery),
    Filters(Vec<Filter>),
    Robot(Option<u32>),
    Routes(Vec<u32>),
}

/// Polls until the link is dropped.
pub fn run(fleet: &FleetName, queried: &Receiver<Query>, report: &Sender<Report>) -> Result {
    let participant = Participant::join(fleet, "viewer-poller")?;
    let mut poller = Poller::new(participant)?;
    loop {
        match queried.recv_timeout(poller.idle_time()) {
            Ok(query) => poller.set_query(query),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
        loop {
            match queried.try_recv() {
                Ok(query) => poller.set_query(query),
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => return Ok(()),
            }
        }
        for found in poller.poll()? {
            if report.send(found).is_err() {
                return Ok(());
            }
        }
    }
}

struct Poller {
    participant: Participant,
    query: RowQuery,
    /// Open only while rows are polled, because a reader holds a frame.
    frames: Option<Subscriber>,
    activities: Option<ColumnReader>,
    /// Those that don't match all robots.
    filters: Vec<Filter>,
    /// Open only while a filter is set.
    filtered: Option<Filtered>,
    filter_at: Instant,
    robot: Option<u32>,
    names: Vec<ColumnName>,
    columns: Vec<(ColumnName, ColumnReader)>,
    routes: RoutePoller,
    order_log: OrderReader,
    orders: OpenOrders,
    orders_at: Instant,
    work: WorkReader,
    work_at: Instant,
    sort_at: Instant,
    list_at: Instant,
    values_at: Instant,
}

/// The ports that a filter reads.
struct Filtered {
    frames: Subscriber,
    worlds: WorldReader,
    types: ColumnReader,
    activities: ColumnReader,
}

impl Poller {
    fn new(participant: Participant) -> Result<Self> {
        let now = Instant::now();
        Ok(Self {
            order_log: OrderReader::open_on(&participant)?,
            orders: OpenOrders::default(),
            orders_at: now,
            work: WorkReader::open_on(&participant)?,
            work_at: now,
            participant,
            query: RowQuery::default(),
            frames: None,
            activities: None,
            filters: Vec::new(),
            filtered: None,
            filter_at: now,
            robot: None,
            names: Vec::new(),
            columns: Vec::new(),
            routes: RoutePoller::default(),
            sort_at: now,
            list_at: now,
            values_at: now,
        })
    }

    fn set_query(&mut self, query: Query) {
        match query {
            Query::Rows(query) => (self.query, self.sort_at) = (query, Instant::now()),
            Query::Filters(mut filters) => {
                filters.retain(|filter| !filter.is_empty());
                (self.filters, self.filter_at) = (filters, Instant::now());
            }
            Query::Robot(robot) => (self.robot, self.values_at) = (robot, Instant::now()),
            Query::Routes(robots) => self.routes.watch(robots, Instant::now()),
        }
    }

    /// The time until the next poll is due.
    fn idle_time(&self) -> Duration {
        let rows = (!self.query.is_plain()).then_some(self.sort_at);
        let values = self.robot.map(|_| self.values_at);
        let filter = (!self.filters.is_empty()).then_some(self.filter_at);
        let always = [self.list_at, self.orders_at, self.work_at].map(Some);
        let next =
            always.into_iter().chain([filter, rows, values, self.routes.due()]).flatten().min();
        next.map_or(LIST_EVERY, |next| next.saturating_duration_since(Instant::now()))
    }

    fn poll(&mut self) -> Result<Vec<Report>> {
        let mut found = Vec::new();
        if Instant::now() >= self.list_at {
            self.names = column_names(self.participant.fleet());
            found.push(Fact::Columns(self.names.clone()).into());
            self.list_at = Instant::now() + LIST_EVERY;
        }
        if Instant::now() >= self.orders_at {
            self.take_orders()?;
            self.orders_at = Instant::now() + ORDERS_EVERY;
        }
        if Instant::now() >= self.work_at {
            found.push(Fact::Work(self.work()?).into());
            self.work_at = Instant::now() + WORK_EVERY;
        }
        if self.query.is_plain() {
            self.frames = None;
        } else if Instant::now() >= self.sort_at {
            found.extend(self.sort()?.map(Fact::Rows).map(Report::from));
            self.sort_at = Instant::now() + SORT_EVERY;
        }
        if self.filters.is_empty() {
            self.filtered = None;
        } else if Instant::now() >= self.filter_at {
            let start = Instant::now();
            found.extend(self.matches()?);
            self.filter_at = Instant::now() + FILTER_EVERY.max(start.elapsed() * 4);
        }
        if self.robot.is_none() {
            self.columns.clear();
        } else if Instant::now() >= self.values_at {
            found.push(Fact::Values(self.values()?).into());
            found
                .push(Fact::Order(self.robot.and_then(|robot| self.orders.of_robot(robot))).into());
            self.values_at = Instant::now() + VALUES_EVERY;
        }
        match self.routes.poll(&self.participant, ROUTE_TIMEOUT) {
            Ok(routes) => found.extend(routes.map(Report::Routes)),
            Err(error) => found.push(Report::Notice(error.to_string())),
        }
        Ok(found)
    }

    fn matches(&mut self) -> Result<Vec<Report>> {
        let ports = match &mut self.filtered {
            Some(ports) => ports,
            none => none.insert(Filtered {
                frames: Subscriber::open_on(&self.participant)?,
                worlds: WorldReader::open_on(&self.participant)?,
                types: ColumnReader::open_on(&self.participant, TYPE.name())?,
                activities: ColumnReader::open_on(&self.participant, ACTIVITY.name())?,
            }),
        };
        ports.frames.latest()?;
        ports.worlds.latest()?;
        ports.types.latest()?;
        let (Some(frame), Some(world)) = (ports.frames.current()?, ports.worlds.current()?) else {
            return Ok(Vec::new());
        };
        let types = ports.types.current()?.map(|column| column.values);
        let activities = ports.activities.newest_of_run(frame.run_id())?;
        let columns = FilterColumns { types, activities };
        let reports = self.filters.iter().map(|filter| {
            Report::Matches(filter.clone(), filter.matches(&frame, &world, columns, &self.orders))
        });
        Ok(reports.collect())
    }

    /// Returns the figures of work with their run, if a living process publishes them.
    fn work(&mut self) -> Result<Option<(u64, WorkFigures)>, ReadError> {
        self.work.take()?;
        let newest = self.work.newest().filter(|_| self.work.has_publisher());
        Ok(newest.map(|(header, figures)| (header.run_id, *figures)))
    }

    fn take_orders(&mut self) -> Result<(), ReadError> {
        let Self { order_log, orders, .. } = self;
        order_log.take(|tick| {
            orders.take(tick.header.run_id, tick.records);
            Ok(())
        })
    }

    fn sort(&mut self) -> Result<Option<Rows>> {
        let frames = match &mut self.frames {
            Some(frames) => frames,
            none => none.insert(Subscriber::open_on(&self.participant)?),
        };
        let activities = match &mut self.activities {
            Some(activities) => activities,
            none => none.insert(ColumnReader::open_on(&self.participant, ACTIVITY.name())?),
        };
        // A paused engine sends no new frame.
        frames.latest()?;
        let Some(frame) = frames.current()? else { return Ok(None) };
        let activities = activities.newest_of_run(frame.run_id())?;
        Ok(Some(self.query.rows(frame.columns(), activities)))
    }

    fn values(&mut self) -> Result<Vec<(ColumnName, f32)>> {
        let Some(robot) = self.robot else { return Ok(Vec::new()) };
        self.columns.retain(|(name, _)| self.names.contains(name));
        for name in self.names.iter().filter(|name| name.as_str() != TYPE.name()).take(MAX_COLUMNS)
        {
            if !self.columns.iter().any(|(open, _)| open == name) {
                self.columns
                    .push((name.clone(), ColumnReader::open_on(&self.participant, name.as_str())?));
            }
        }
        let mut values = Vec::new();
        for (name, reader) in &mut self.columns {
            reader.latest()?;
            let value =
                reader.current()?.and_then(|column| column.values.get(robot as usize).copied());
            // The name is listed as long as this reader is open, so the publisher is checked too.
            values.extend(
                value.filter(|_| reader.has_publisher()).map(|value| (name.clone(), value)),
            );
        }
        Ok(values)
    }
}
