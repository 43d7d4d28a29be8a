//! Workers: who turns jobs into results. They get files and leave files, so they may be anywhere.

mod adapter;
mod local;

use std::path::PathBuf;

pub use adapter::Adapter;
pub use local::Local;

use crate::job::JobId;

/// A job for a worker: its files here.
#[derive(Clone, Debug)]
pub struct Task {
    /// The job.
    pub id: JobId,
    /// Its file.
    pub job: PathBuf,
    /// The layout's file.
    pub layout: PathBuf,
    /// Where the result belongs.
    pub result: PathBuf,
}

/// What a worker says of a job.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// The job.
    pub id: JobId,
    /// Why there is no result.
    pub failure: Option<String>,
}

/// The error of workers as a whole: no job can be done.
#[derive(Debug, thiserror::Error)]
pub enum WorkersError {
    /// A program can't be started.
    #[error("can't start {program}: {reason}")]
    Start {
        /// The program.
        program: String,
        /// Why.
        reason: std::io::Error,
    },
    /// A result can't be written.
    #[error("{0}; finished runs are kept, and the same command goes on")]
    Output(String),
    /// The adapter to a cluster has ended.
    #[error("{0}; finished runs are kept")]
    Adapter(String),
    /// The user wants no more.
    #[error("interrupted; finished runs are kept, and the same command goes on")]
    Interrupted,
}

/// The exit code of a run whose result can't be written (`EX_IOERR` of sysexits.h): then no other
/// run's can, either.
pub const UNWRITABLE: u8 = 74;

/// Those who do jobs.
pub trait Workers {
    /// Does all of some tasks, and calls `on_report` for each as it ends. Tasks are begun in their
    /// order.
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

    /// Returns how many tasks are done side by side.
    fn size(&self) -> usize;
}
