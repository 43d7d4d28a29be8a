//! Where it jams, for pictures without a window: the newest report is taken when a picture is drawn.

use std::sync::mpsc::{self, Receiver};

use regatta_plugin::{FleetName, Result};

use super::{JamReport, JamWatch, Watch};

/// A watch with the reports that have not been taken yet.
#[derive(Debug)]
pub struct JamInbox {
    reports: Receiver<Result<JamReport>>,
    /// Ends the thread when it is dropped.
    _watch: JamWatch,
}

impl JamInbox {
    /// Starts to watch; `None` if there is nothing to watch.
    ///
    /// # Errors
    /// If the system can't start a thread.
    pub fn open(fleet: &FleetName, watch: Watch) -> Result<Option<Self>> {
        if watch.is_idle() {
            return Ok(None);
        }
        let (report, reports) = mpsc::channel();
        let running = JamWatch::start(fleet, move |found| report.send(found).is_ok())?;
        running.watch(watch);
        Ok(Some(Self { reports, _watch: running }))
    }

    /// Returns the reports since the last call, the oldest first.
    ///
    /// # Errors
    /// If the fleet can't be read.
    pub fn take(&self) -> Result<Vec<JamReport>> {
        self.reports.try_iter().collect()
    }
}
