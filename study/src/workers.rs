//! Workers turn jobs into results. They get files and leave files, so they may be on any machine.

mod adapter;
mod local;

use std::path::PathBuf;

pub use adapter::Adapter;
pub use local::Local;

use serde::Serialize;

use crate::job::JobId;

/// A job for a worker, with its files on this machine.
#[derive(Clone, Debug, Serialize)]
pub struct Task {
    /// The job.
    pub id: JobId,
    /// Its file.
    pub job: PathBuf,
    /// The layout's file.
    pub layout: PathBuf,
    /// The path for the result.
    pub result: PathBuf,
}

/// A worker's report on a job.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// The job.
    pub id: JobId,
    /// The reason why there is no result.
    pub failure: Option<RunFailure>,
    /// The wall-clock time from the start of the worker's process to its end, in seconds, where it
    /// is known.
    pub wall_secs: Option<f64>,
}

/// The words for robots of which some have no place at the beginning of a run.
pub const NOT_ALL_PLACED: &str = "not all found a place";

/// The reason why a run has no result.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RunFailure {
    /// The layout has no room for so many robots, which is an answer.
    #[error("{0}")]
    NoRoom(String),
    /// The run has failed, and nothing is known.
    #[error("{0}")]
    Failed(String),
}

/// The error of workers as a whole: no job can be done.
#[derive(Debug, thiserror::Error)]
pub enum WorkersError {
    /// A program can't be started.
    #[error("can't start {program}: {reason}")]
    Start {
        /// The program.
        program: String,
        /// The reason.
        reason: std::io::Error,
    },
    /// A result can't be written.
    #[error("{0}; finished runs are kept; repeat the command to continue")]
    Output(String),
    /// The adapter to a cluster has ended.
    #[error("{0}; finished runs are kept")]
    Adapter(String),
    /// The user has interrupted the study.
    #[error("interrupted; finished runs are kept; repeat the command to continue")]
    Interrupted,
}

/// The exit code of a run whose result can't be written (`EX_IOERR` of sysexits.h). The results of
/// other runs can't be written then, either.
pub const UNWRITABLE: u8 = 74;

/// The exit code of a run whose robots don't fit on the layout (`EX_DATAERR` of sysexits.h).
pub const NO_ROOM: u8 = 65;

/// A pool of workers.
pub trait Workers {
    /// Does tasks, which begin in their order, and calls `on_report` for each as it ends.
    ///
    /// # Errors
    /// [`WorkersError`] if no more tasks can be done, or `is_interrupted` says so. Tasks that are
    /// under way are stopped then.
    fn run(
        &mut self,
        tasks: &[Task],
        is_interrupted: &dyn Fn() -> bool,
        on_report: &mut dyn FnMut(Report),
    ) -> Result<(), WorkersError>;

    /// Returns the number of tasks that are done side by side.
    fn size(&self) -> usize;
}
