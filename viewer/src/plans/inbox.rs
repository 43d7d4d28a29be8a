//! Plans for pictures without a window: the newest report is taken when a picture is drawn.

use std::sync::mpsc::{self, Receiver};

use regatta_plugin::{FleetName, Result};

use super::{PlanReport, PlanWatch, Watch};

/// A watch with the reports that have not been taken yet.
#[derive(Debug)]
pub struct PlanInbox {
    reports: Receiver<Result<PlanReport>>,
    /// Ends the thread when it is dropped.
    _watch: PlanWatch,
}

impl PlanInbox {
    /// Starts to watch; `None` if there is nothing to watch.
    ///
    /// # Errors
    /// If the system can't start a thread.
    pub fn open(fleet: &FleetName, watch: Watch) -> Result<Option<Self>> {
        if watch.is_idle() {
            return Ok(None);
        }
        let (report, reports) = mpsc::channel();
        let running = PlanWatch::start(fleet, move |found| report.send(found).is_ok())?;
        running.watch(watch);
        Ok(Some(Self { reports, _watch: running }))
    }

    /// Returns the newest report, if there is one since the last call.
    ///
    /// # Errors
    /// If the fleet can't be read.
    pub fn newest(&self) -> Result<Option<PlanReport>> {
        self.reports.try_iter().last().transpose()
    }
}
