//! Background threads for everything that takes time: requests to the engine, commands, the order
//! of the fleet list, the names of columns, routes and plans. None of it delays a picture. An
//! iceoryx2 port stays on the thread that created it, so each thread opens its own ports.

mod commands;
mod control;
mod orders;
mod poller;
pub mod routes;

use std::sync::mpsc::{self, Receiver, Sender};
use std::thread::JoinHandle;

use regatta_interface::commands::UserCommand;
use regatta_interface::log::LogReport;
use regatta_interface::orders::{NamedOrder, RobotOrder};
use regatta_interface::robot_filter::{Filter, Matches};
use regatta_interface::rows::{RowQuery, Rows};
use regatta_plugin::control::{ControlRequest, ControlResponse};
use regatta_plugin::ports::error::RequestError;
use regatta_plugin::route::RouteResponse;
use regatta_plugin::work::WorkFigures;
use regatta_plugin::{ColumnName, ControlError, FleetName, Result};
use regatta_scene::plans::PlanReport;

use crate::jams::{JamQuery, JamReport};
use crate::log::LogQuery;
use crate::plans::PlanQuery;
use crate::worker::{Query as WorkerQuery, Worker};
use orders::OrderQuery;
use poller::Query;

/// A handle to the background threads. Dropping it ends them.
#[derive(Debug)]
pub struct Link {
    requests: Sender<ControlRequest>,
    queries: Option<Sender<Query>>,
    commands: Sender<UserCommand>,
    orders: Sender<OrderQuery>,
    reports: Receiver<Report>,
    poller: Option<JoinHandle<()>>,
    plans: Worker<PlanQuery>,
    jams: Worker<JamQuery>,
    /// Collects as long as it lives.
    _log: Worker<LogQuery>,
}

impl Link {
    /// Starts the threads for a fleet, whether or not it has an engine.
    ///
    /// # Errors
    /// If the system can't start a thread.
    pub fn open(fleet: &FleetName) -> std::io::Result<Self> {
        let (report, reports) = mpsc::channel();
        // These threads are not joined at the end: the engine may take long to answer, and a
        // command may wait for the world of a fleet that ends.
        let (requests, _) = spawn("control", fleet, &report, control::run)?;
        let (commands, _) = spawn("commands", fleet, &report, commands::run)?;
        let (orders, _) = spawn("orders", fleet, &report, orders::run)?;
        let (queries, poller) = spawn("poller", fleet, &report, poller::run)?;
        let log = worker(fleet, &report, Report::Log)?;
        log.ask(LogQuery);
        Ok(Self {
            requests,
            commands,
            orders,
            queries: Some(queries),
            plans: worker(fleet, &report, Report::Plans)?,
            jams: worker(fleet, &report, Report::Jams)?,
            reports,
            poller: Some(poller),
            _log: log,
        })
    }

    /// Queues a request to the engine. Requests are sent one after the other.
    pub fn request(&self, request: ControlRequest) {
        // Fails only after the thread has ended and reported its error.
        let _ = self.requests.send(request);
    }

    /// Queues a command to the fleet. Its answer comes as a notice.
    pub fn command(&self, command: UserCommand) {
        let _ = self.commands.send(command);
    }

    /// Sets the query of the fleet list's rows.
    pub fn rows(&self, query: RowQuery) {
        self.query(Query::Rows(query));
    }

    /// Sets the filters whose matches are polled.
    pub fn filters(&self, filters: Vec<Filter>) {
        self.query(Query::Filters(filters));
    }

    /// Sets the robot whose values are polled.
    pub fn robot(&self, robot: Option<u32>) {
        self.query(Query::Robot(robot));
        let _ = self.orders.send(OrderQuery::OfRobot(robot));
    }

    /// Looks for the robot with the order of a name.
    pub fn find_order(&self, name: String) {
        let _ = self.orders.send(OrderQuery::Named(name));
    }

    /// Sets the robots whose routes are polled.
    pub fn routes(&self, robots: Vec<u32>) {
        self.query(Query::Routes(robots));
    }

    /// Sets the plans that are collected.
    pub fn plans(&self, query: PlanQuery) {
        self.plans.ask(query);
    }

    /// Sets the figures of jams that are worked out.
    pub fn jams(&self, query: JamQuery) {
        self.jams.ask(query);
    }

    fn query(&self, query: Query) {
        if let Some(queries) = &self.queries {
            let _ = queries.send(query);
        }
    }

    /// The reports since the last call.
    pub fn reports(&self) -> impl Iterator<Item = Report> {
        self.reports.try_iter()
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        self.queries = None;
        if let Some(poller) = self.poller.take() {
            // The result is an error only if the thread panicked, and the panic has been printed.
            let _ = poller.join();
        }
    }
}

/// Starts a thread that runs until the returned sender is dropped, and reports its error.
fn spawn<T: Send + 'static>(
    name: &str,
    fleet: &FleetName,
    report: &Sender<Report>,
    run: fn(&FleetName, &Receiver<T>, &Sender<Report>) -> Result,
) -> std::io::Result<(Sender<T>, JoinHandle<()>)> {
    let (sender, receiver) = mpsc::channel();
    let (fleet, report) = (fleet.clone(), report.clone());
    let thread = std::thread::Builder::new().name(name.into()).spawn(move || {
        if let Err(error) = run(&fleet, &receiver, &report) {
            // The receiver is gone only while the viewer exits.
            let _ = report.send(Report::Notice(error.to_string()));
        }
    })?;
    Ok((sender, thread))
}

/// Starts a worker whose answers are wrapped into reports.
fn worker<Q: WorkerQuery>(
    fleet: &FleetName,
    report: &Sender<Report>,
    wrap: fn(Box<Q::Report>) -> Report,
) -> std::io::Result<Worker<Q>> {
    let report = report.clone();
    Worker::start(fleet, move |found| {
        let found = match found {
            Ok(found) => wrap(Box::new(found)),
            Err(error) => Report::Notice(error.to_string()),
        };
        report.send(found).is_ok()
    })
}

/// A report of the background threads.
#[derive(Debug)]
pub enum Report {
    /// New data of the fleet.
    Facts(Fact),
    /// A message for the user.
    Notice(String),
    /// A command or a request of the user that came to nothing, and why. The fleet has no event of
    /// it.
    Refused(UserCommand, String),
    /// The selected robots' routes; empty if no process answers.
    Routes(Vec<RouteResponse>),
    /// The robot with the order that was looked for.
    Holder(u32),
    /// The robots that match a filter.
    Matches(Filter, Matches),
    /// The plans of robots.
    Plans(Box<PlanReport>),
    /// The figures of jams.
    Jams(Box<JamReport>),
    /// News of the log.
    Log(Box<LogReport>),
}

/// New data of the fleet.
#[derive(Debug)]
pub enum Fact {
    /// The engine's status; `None` if there is no engine.
    Status(Option<Box<ControlResponse>>),
    /// The rows of the fleet list.
    Rows(Rows),
    /// The columns that are published.
    Columns(Vec<ColumnName>),
    /// The selected robot's value in each column.
    Values(Vec<(ColumnName, f32)>),
    /// The selected robot's order.
    Order(Option<RobotOrder>),
    /// The selected robot's order, as the fleet manager names it.
    NamedOrder(Option<NamedOrder>),
    /// The figures of the fleet's work, with their run; `None` if nobody publishes them.
    Work(Option<(u64, WorkFigures)>),
}

impl Report {
    /// Returns the report of the engine's answer to a request of the user, or to a poll of the
    /// status.
    pub fn of_answer(answer: Result<ControlResponse, ControlError>, is_requested: bool) -> Self {
        match answer {
            Ok(status) => Fact::Status(Some(Box::new(status))).into(),
            Err(ControlError::Request(RequestError::Gone { .. })) => Fact::Status(None).into(),
            Err(error) if is_requested => Self::Notice(error.to_string()),
            Err(ControlError::NoEngine { .. }) => Fact::Status(None).into(),
            Err(error) => {
                tracing::debug!(%error, "polling the status");
                Fact::Status(None).into()
            }
        }
    }
}

impl From<Fact> for Report {
    fn from(fact: Fact) -> Self {
        Self::Facts(fact)
    }
}
