//! Threads that watch a fleet, so that no picture waits for what they find.

use std::sync::mpsc::{self, Receiver, Sender};
use std::thread::JoinHandle;

use regatta_plugin::{FleetName, Result};

/// What a thread watches.
pub trait Watched: Send + Sized + 'static {
    /// What it finds.
    type Report: Send + 'static;

    /// The name of the thread.
    const THREAD: &'static str;

    /// Whether there is nothing to watch.
    fn is_idle(&self) -> bool;

    /// Watches until the sender of changes is dropped, or `report` wants no more.
    ///
    /// # Errors
    /// If the fleet can't be read.
    fn run(
        fleet: &FleetName,
        changed: &Receiver<Self>,
        report: &mut dyn FnMut(Self::Report) -> bool,
    ) -> Result;
}

/// A running thread that watches a fleet. Dropping it ends the thread.
#[derive(Debug)]
pub struct Watching<W> {
    changes: Option<Sender<W>>,
    thread: Option<JoinHandle<()>>,
}

impl<W: Watched> Watching<W> {
    /// Starts the thread, which watches nothing at first. `report` gets what it finds, and returns
    /// whether it wants more.
    ///
    /// # Errors
    /// If the system can't start a thread.
    pub fn start(
        fleet: &FleetName,
        mut report: impl FnMut(Result<W::Report>) -> bool + Send + 'static,
    ) -> std::io::Result<Self> {
        let (changes, changed) = mpsc::channel();
        let fleet = fleet.clone();
        let thread = std::thread::Builder::new().name(W::THREAD.into()).spawn(move || {
            if let Err(error) = W::run(&fleet, &changed, &mut |found| report(Ok(found))) {
                report(Err(error));
            }
        })?;
        Ok(Self { changes: Some(changes), thread: Some(thread) })
    }

    /// Sets what is watched from now on.
    pub fn watch(&self, watch: W) {
        if let Some(changes) = &self.changes {
            // Fails only after the thread has reported its error.
            let _ = changes.send(watch);
        }
    }
}

impl<W> Drop for Watching<W> {
    fn drop(&mut self) {
        self.changes = None;
        if let Some(thread) = self.thread.take() {
            // The result is an error only if the thread panicked, and the panic has been printed.
            let _ = thread.join();
        }
    }
}

/// A watching thread with its reports that have not been taken yet, for pictures without a window.
#[derive(Debug)]
pub struct Inbox<W: Watched> {
    reports: Receiver<Result<W::Report>>,
    /// Ends the thread when it is dropped.
    _watching: Watching<W>,
}

impl<W: Watched> Inbox<W> {
    /// Starts to watch; `None` if there is nothing to watch.
    ///
    /// # Errors
    /// If the system can't start a thread.
    pub fn open(fleet: &FleetName, watch: W) -> Result<Option<Self>> {
        if watch.is_idle() {
            return Ok(None);
        }
        let (report, reports) = mpsc::channel();
        let watching = Watching::start(fleet, move |found| report.send(found).is_ok())?;
        watching.watch(watch);
        Ok(Some(Self { reports, _watching: watching }))
    }

    /// Returns the newest report, if there is one since the last call.
    ///
    /// # Errors
    /// If the fleet can't be read.
    pub fn newest(&self) -> Result<Option<W::Report>> {
        self.reports.try_iter().last().transpose()
    }

    /// Returns the reports since the last call, the oldest first.
    ///
    /// # Errors
    /// If the fleet can't be read.
    pub fn take(&self) -> Result<Vec<W::Report>> {
        self.reports.try_iter().collect()
    }
}
