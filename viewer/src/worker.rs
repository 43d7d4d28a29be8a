//! Threads that answer a query about a fleet again and again, so that no picture waits for the
//! answers.

use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::Instant;

use regatta_plugin::{FleetName, Participant, Result};

/// A query about a fleet.
pub trait Query: Clone + Default + Send + 'static {
    /// An answer.
    type Report: Send + 'static;
    /// The ports that are open while there is something to answer.
    type Ports;

    /// The name of the thread.
    const THREAD: &'static str;

    /// Whether nothing is asked for.
    fn is_idle(&self) -> bool;

    /// Whether a query that replaces `before` is to be answered before the next poll is due.
    fn is_urgent(&self, before: &Self) -> bool;

    /// Opens the ports.
    ///
    /// # Errors
    /// If the fleet can't be read.
    fn open(participant: &Participant) -> Result<Self::Ports>;

    /// The time of the next poll.
    fn due(ports: &Self::Ports) -> Instant;

    /// Reads the ports. Returns an answer if there is a new one, or in any case `at_once`.
    ///
    /// # Errors
    /// If the fleet can't be read.
    fn poll(&self, ports: &mut Self::Ports, at_once: bool) -> Result<Option<Self::Report>>;

    /// The answer to a query that asks for nothing.
    fn nothing() -> Self::Report;
}

/// Answers queries at once, with the newest frame, for programs that wait for the answers.
pub struct Reader<Q: Query>(Q::Ports);

impl<Q: Query> Reader<Q> {
    /// Joins a fleet.
    ///
    /// # Errors
    /// If the fleet can't be read.
    pub fn open(fleet: &FleetName) -> Result<Self> {
        Ok(Self(Q::open(&join::<Q>(fleet)?)?))
    }

    /// Returns the answer to a query.
    ///
    /// # Errors
    /// If the fleet can't be read.
    pub fn read(&mut self, query: &Q) -> Result<Q::Report> {
        Ok(query.poll(&mut self.0, true)?.unwrap_or_else(Q::nothing))
    }
}

fn join<Q: Query>(fleet: &FleetName) -> Result<Participant> {
    Ok(Participant::join(fleet, &format!("viewer-{}", Q::THREAD))?)
}

/// A running thread. Dropping it ends the thread.
#[derive(Debug)]
pub struct Worker<Q> {
    queries: Option<Sender<Q>>,
    thread: Option<JoinHandle<()>>,
}

impl<Q: Query> Worker<Q> {
    /// Starts the thread, which is idle at first. `report` gets the answers, and returns whether it
    /// wants more.
    ///
    /// # Errors
    /// If the system can't start a thread.
    pub fn start(
        fleet: &FleetName,
        mut report: impl FnMut(Result<Q::Report>) -> bool + Send + 'static,
    ) -> std::io::Result<Self> {
        let (queries, queried) = mpsc::channel();
        let fleet = fleet.clone();
        let thread = std::thread::Builder::new().name(Q::THREAD.into()).spawn(move || {
            if let Err(error) = run::<Q>(&fleet, &queried, &mut |found| report(Ok(found))) {
                report(Err(error));
            }
        })?;
        Ok(Self { queries: Some(queries), thread: Some(thread) })
    }

    /// Sets the query that is answered from now on.
    pub fn ask(&self, query: Q) {
        if let Some(queries) = &self.queries {
            // Fails only after the thread has reported its error.
            let _ = queries.send(query);
        }
    }
}

impl<Q> Drop for Worker<Q> {
    fn drop(&mut self) {
        self.queries = None;
        if let Some(thread) = self.thread.take() {
            // The result is an error only if the thread panicked, and the panic has been printed.
            let _ = thread.join();
        }
    }
}

/// Answers until the sender of queries is dropped, or `report` wants no more.
fn run<Q: Query>(
    fleet: &FleetName,
    queried: &Receiver<Q>,
    report: &mut dyn FnMut(Q::Report) -> bool,
) -> Result {
    let participant = join::<Q>(fleet)?;
    let mut query = Q::default();
    let mut ports: Option<Q::Ports> = None;
    loop {
        let received = match &ports {
            None => queried.recv().map_err(|_| RecvTimeoutError::Disconnected),
            Some(ports) => {
                queried.recv_timeout(Q::due(ports).saturating_duration_since(Instant::now()))
            }
        };
        let mut at_once = false;
        match received {
            Ok(newer) => {
                let newer = queried.try_iter().last().unwrap_or(newer);
                at_once = newer.is_urgent(&query);
                query = newer;
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
        let found = if query.is_idle() {
            ports.take().map(|_| Q::nothing())
        } else {
            let ports = match &mut ports {
                Some(ports) => ports,
                none => none.insert(Q::open(&participant)?),
            };
            query.poll(ports, at_once)?
        };
        if found.is_some_and(|found| !report(found)) {
            return Ok(());
        }
    }
}

/// A worker with its answers that have not been taken yet, for pictures without a window.
#[derive(Debug)]
pub struct Inbox<Q: Query> {
    reports: Receiver<Result<Q::Report>>,
    /// Ends the thread when it is dropped.
    _worker: Worker<Q>,
}

impl<Q: Query> Inbox<Q> {
    /// Starts a worker; `None` if nothing is asked for.
    ///
    /// # Errors
    /// If the system can't start a thread.
    pub fn open(fleet: &FleetName, query: Q) -> Result<Option<Self>> {
        if query.is_idle() {
            return Ok(None);
        }
        let (report, reports) = mpsc::channel();
        let worker = Worker::start(fleet, move |found| report.send(found).is_ok())?;
        worker.ask(query);
        Ok(Some(Self { reports, _worker: worker }))
    }

    /// Returns the newest answer, if there is one since the last call.
    ///
    /// # Errors
    /// If the fleet can't be read.
    pub fn newest(&self) -> Result<Option<Q::Report>> {
        self.reports.try_iter().last().transpose()
    }

    /// Returns the answers since the last call, the oldest first.
    ///
    /// # Errors
    /// If the fleet can't be read.
    pub fn take(&self) -> Result<Vec<Q::Report>> {
        self.reports.try_iter().collect()
    }
}
