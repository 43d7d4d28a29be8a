//! Workers elsewhere: an adapter program that gives tasks to a cluster.
//!
//! The adapter is a process that gets a line of JSON for each task, `{"id", "job", "layout",
//! "result"}` with the paths of files here, and writes `{"workers": N}` once and then `{"id",
//! "failure"}` for each task that has ended, after it has written the result's file; `"no_room"`
//! instead of `"failure"` is the reason if the robots don't fit on the layout.
//! `regatta.cluster` in the Python package is one, for Dask and for Ray.

use std::collections::BTreeSet;
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use serde::Deserialize;

use super::{Report, RunFailure, Task, Workers, WorkersError};
use crate::job::JobId;

/// The time between two checks for lines of the adapter.
const POLL_INTERVAL: Duration = Duration::from_millis(50);
/// The longest time until an adapter has reached its cluster.
const START_TIMEOUT: Duration = Duration::from_secs(120);
/// The longest time that an adapter may take to end when its input has ended.
const END_TIMEOUT: Duration = Duration::from_secs(5);

/// A line of an adapter.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Message {
    /// The cluster is reached.
    Ready { workers: usize },
    /// A task has ended.
    Ended(Ended),
}

/// The end of a task.
#[derive(Debug, Deserialize)]
struct Ended {
    id: JobId,
    failure: Option<String>,
    no_room: Option<String>,
}

impl From<Ended> for Report {
    fn from(Ended { id, failure, no_room }: Ended) -> Self {
        let failure = failure.map(RunFailure::Failed);
        let failure = no_room.map(RunFailure::NoRoom).or(failure);
        Self { id, failure, wall_secs: None }
    }
}

/// A running adapter.
#[derive(Debug)]
pub struct Adapter {
    child: Child,
    /// Dropped to end the adapter.
    stdin: Option<ChildStdin>,
    lines: Receiver<Message>,
    /// Reads its standard error, so that it never waits for a reader; returns the last line.
    errors: Option<JoinHandle<String>>,
    size: usize,
}

impl Adapter {
    /// Starts an adapter, and waits until it has reached its cluster.
    ///
    /// # Errors
    /// [`WorkersError`] if it can't be started, or can't reach the cluster.
    pub fn start(
        mut command: Command,
        is_interrupted: &dyn Fn() -> bool,
    ) -> Result<Self, WorkersError> {
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let program = command.get_program().to_string_lossy().into_owned();
        let mut child =
            command.spawn().map_err(|reason| WorkersError::Start { program, reason })?;
        let (stdin, stdout, stderr) =
            (child.stdin.take(), child.stdout.take(), child.stderr.take());
        let (sender, lines) = mpsc::channel();
        // The threads end with the adapter's output.
        std::thread::spawn(move || {
            for line in text_lines(stdout) {
                if let Ok(message) = serde_json::from_str::<Message>(&line)
                    && sender.send(message).is_err()
                {
                    break;
                }
            }
        });
        let errors = std::thread::spawn(move || {
            text_lines(stderr).filter(|line| !line.trim().is_empty()).last().unwrap_or_default()
        });
        let mut adapter = Self { child, stdin, lines, errors: Some(errors), size: 0 };
        let started = Instant::now();
        while adapter.size == 0 {
            match adapter.next(is_interrupted)? {
                Some(Message::Ready { workers }) => adapter.size = workers,
                Some(Message::Ended(_)) => {}
                None if started.elapsed() > START_TIMEOUT => {
                    return Err(WorkersError::Adapter("the cluster doesn't answer".to_owned()));
                }
                None => {}
            }
        }
        Ok(adapter)
    }

    /// Returns the next line, if one comes soon.
    fn next(&mut self, is_interrupted: &dyn Fn() -> bool) -> Result<Option<Message>, WorkersError> {
        if is_interrupted() {
            return Err(WorkersError::Interrupted);
        }
        match self.lines.recv_timeout(POLL_INTERVAL) {
            Ok(message) => Ok(Some(message)),
            Err(RecvTimeoutError::Timeout) => Ok(None),
            Err(RecvTimeoutError::Disconnected) => Err(self.ended()),
        }
    }

    /// Returns the error of an adapter that has ended: the last line that it wrote.
    fn ended(&mut self) -> WorkersError {
        let line = self.errors.take().and_then(|errors| errors.join().ok()).unwrap_or_default();
        WorkersError::Adapter(match &*line {
            "" => "the adapter to the cluster has ended".to_owned(),
            line if line.contains("No module named") || line.contains("finding module specification") => {
                "Python lacks Regatta's package: pip install 'regatta-sim[study]' (for Ray 'regatta-sim[study-ray]'), or set REGATTA_PYTHON".to_owned()
            }
            line => line.to_owned(),
        })
    }

    fn send(&mut self, task: &Task) -> Result<(), WorkersError> {
        let line = serde_json::to_string(task).unwrap_or_default();
        if let Some(stdin) = &mut self.stdin
            && writeln!(stdin, "{line}").is_ok()
        {
            return Ok(());
        }
        Err(self.ended())
    }
}

impl Workers for Adapter {
    fn run(
        &mut self,
        tasks: &[Task],
        is_interrupted: &dyn Fn() -> bool,
        on_report: &mut dyn FnMut(Report),
    ) -> Result<(), WorkersError> {
        for task in tasks {
            self.send(task)?;
        }
        let mut left: BTreeSet<JobId> = tasks.iter().map(|task| task.id.clone()).collect();
        while !left.is_empty() {
            if let Some(Message::Ended(ended)) = self.next(is_interrupted)?
                && left.remove(&ended.id)
            {
                on_report(ended.into());
            }
        }
        Ok(())
    }

    fn size(&self) -> usize {
        self.size
    }
}

/// Returns the lines of a pipe up to its end or the first that isn't text.
fn text_lines(pipe: Option<impl Read>) -> impl Iterator<Item = String> {
    pipe.into_iter().flat_map(|pipe| BufReader::new(pipe).lines()).map_while(Result::ok)
}

impl Drop for Adapter {
    fn drop(&mut self) {
        self.stdin = None;
        let deadline = Instant::now() + END_TIMEOUT;
        while Instant::now() < deadline {
            if !matches!(self.child.try_wait(), Ok(None)) {
                return;
            }
            std::thread::sleep(POLL_INTERVAL);
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
