//! Background threads for everything that takes time: requests to the engine, commands, the order
//! of the fleet list, the names of columns, routes and plans. None of it delays a picture. An
//! iceoryx2 port stays on the thread that created it, so each thread opens its own ports.

mod commands;
mod control;
mod poller;
mod report;
pub mod routes;
mod steps;

use std::sync::mpsc::{self, Receiver, Sender};
use std::thread::JoinHandle;

use regatta_interface::commands::UserCommand;
use regatta_interface::robot_filter::Filter;
use regatta_interface::rows::RowQuery;
use regatta_plugin::control::ControlRequest;
use regatta_plugin::{FleetName, Result};

use crate::jams::Watch as JamWatched;
use crate::log::watch::LogWatch;
use crate::plans::Watch;
use crate::watching::Watching;
use poller::Query;
pub use report::{Fact, Report};

/// A handle to the background threads. Dropping it ends them.
#[derive(Debug)]
pub struct Link {
    requests: Option<Sender<ControlRequest>>,
    queries: Option<Sender<Query>>,
    commands: Option<Sender<UserCommand>>,
    reports: Receiver<Report>,
    poller: Option<JoinHandle<()>>,
    plans: Watching<Watch>,
    jams: Watching<JamWatched>,
    /// Collects as long as it lives.
    _log: LogWatch,
}

impl Link {
    /// Starts the threads for a fleet, whether or not it has an engine.
    ///
    /// # Errors
    /// If the system can't start a thread.
    pub fn open(fleet: &FleetName) -> std::io::Result<Self> {
        let (report, reports) = mpsc::channel();
        let (requests, requested) = mpsc::channel();
        let (queries, queried) = mpsc::channel();
        let (name, control_report) = (fleet.clone(), report.clone());
        // This thread is not joined at the end, because the engine may take long to answer.
        std::thread::Builder::new().name("control".into()).spawn(move || {
            report_error(&control_report, control::run(&name, &requested, &control_report));
        })?;
        let (commands, commanded) = mpsc::channel();
        let (name, command_report) = (fleet.clone(), report.clone());
        // Not joined either: it may wait for the world of a fleet that ends.
        std::thread::Builder::new().name("commands".into()).spawn(move || {
            report_error(&command_report, commands::run(&name, &commanded, &command_report));
        })?;
        let plan_report = report.clone();
        let plans = Watching::start(fleet, move |found| {
            let found = found.map_or_else(
                |error| Report::Notice(error.to_string()),
                |found| Report::Plans(Box::new(found)),
            );
            plan_report.send(found).is_ok()
        })?;
        let jam_report = report.clone();
        let jams = Watching::start(fleet, move |found| {
            let found = found.map_or_else(
                |error| Report::Notice(error.to_string()),
                |found| Report::Jams(Box::new(found)),
            );
            jam_report.send(found).is_ok()
        })?;
        let log_report = report.clone();
        let log = LogWatch::start(fleet, move |found| {
            let found = found.map_or_else(
                |error| Report::Notice(error.to_string()),
                |found| Report::Log(Box::new(found)),
            );
            log_report.send(found).is_ok()
        })?;
        let name = fleet.clone();
        let poller = std::thread::Builder::new().name("poller".into()).spawn(move || {
            report_error(&report, poller::run(&name, &queried, &report));
        })?;
        Ok(Self {
            requests: Some(requests),
            queries: Some(queries),
            commands: Some(commands),
            reports,
            poller: Some(poller),
            plans,
            jams,
            _log: log,
        })
    }

    /// Queues a request to the engine. Requests are sent one after the other.
    pub fn request(&self, request: ControlRequest) {
        if let Some(requests) = &self.requests {
            // Fails only after the thread has ended and reported its error.
            let _ = requests.send(request);
        }
    }

    /// Queues a command to the fleet. Its answer comes as a notice.
    pub fn command(&self, command: UserCommand) {
        if let Some(commands) = &self.commands {
            let _ = commands.send(command);
        }
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
    }

    /// Sets the robots whose routes are polled.
    pub fn routes(&self, robots: Vec<u32>) {
        self.query(Query::Routes(robots));
    }

    /// Sets which plans are watched.
    pub fn plans(&self, watch: Watch) {
        self.plans.watch(watch);
    }

    /// Sets what is watched of where it jams.
    pub fn jams(&self, watch: JamWatched) {
        self.jams.watch(watch);
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
        (self.requests, self.queries, self.commands) = (None, None, None);
        if let Some(poller) = self.poller.take() {
            // The result is an error only if the thread panicked, and the panic has been printed.
            let _ = poller.join();
        }
    }
}

fn report_error(report: &Sender<Report>, result: Result) {
    if let Err(error) = result {
        // The receiver is gone only while the viewer exits.
        let _ = report.send(Report::Notice(error.to_string()));
    }
}
