//! The plugin: reads every frame, serves the page and writes the CSV file.

use std::ffi::OsString;
use std::io::{self, Write};
use std::net::{SocketAddr, ToSocketAddrs};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use clap::Parser;
use regatta_plugin::{Error, FleetName, Frame, Options, Participant, Plugin, Result};

use crate::collisions::CollisionReader;
use crate::fold::{Fold, wall_time_nanos};
use crate::page::page;
use crate::processes::ProcessWatch;
use crate::row::row;
use crate::server::{self, Pages};
use crate::sheet::{Change, Rows, Sheet};
use crate::snapshot::{Collisions, Lap, Snapshot};

/// Between two rows of the CSV file.
const ROW_PERIOD: Duration = Duration::from_secs(1);

/// The command line of `regatta plugin metrics`.
#[derive(Clone, Debug, Parser)]
#[command(bin_name = "regatta plugin metrics", max_term_width = 100)]
#[command(about = "Shows a fleet's figures to Prometheus, and writes them as CSV")]
pub struct Cli {
    /// Where to serve http://IP:PORT/metrics; port 0 takes a free one
    #[arg(long, value_name = "IP:PORT", default_value = "127.0.0.1:9464", value_parser = address)]
    pub listen: SocketAddr,
    /// Add a row of figures a second to this file
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// What every plugin takes.
    #[command(flatten)]
    pub options: Options,
}

fn address(text: &str) -> Result<SocketAddr, String> {
    let mut addresses = text.to_socket_addrs().map_err(|_| "give IP:PORT, 127.0.0.1:9464 say".to_owned())?;
    addresses.next().ok_or_else(|| "that name has no address".to_owned())
}

/// Runs the plugin with a command line, whose first argument is the program.
///
/// # Errors
/// If an option is wrong, the address can't be listened on, or as [`regatta_plugin::run`].
pub fn run_from<A: Into<OsString> + Clone>(args: impl IntoIterator<Item = A>) -> Result {
    match Cli::try_parse_from(args) {
        Ok(cli) => cli.run(),
        Err(error) if !error.use_stderr() => Ok(error.print()?),
        Err(error) => Err(first_line(&error)),
    }
}

/// What is wrong; the usage that clap adds fits no single line.
fn first_line(error: &clap::Error) -> Error {
    let text = error.to_string();
    let first = text.lines().next().unwrap_or_default().trim_start_matches("error: ");
    Error::new(format_args!("{first}; --help lists the options"))
}

impl Cli {
    fn run(&self) -> Result {
        let fleet = &self.options.fleet;
        let shared = Arc::new(Shared {
            fleet: fleet.clone(),
            state: Mutex::default(),
            processes: ProcessWatch::start(fleet)?,
            rows: Mutex::new(self.csv.is_some().then(Rows::default)),
        });
        let address = server::start(self.listen, Arc::clone(&shared))?;
        tell(format_args!("fleet '{fleet}' at http://{address}/metrics"));
        if let Some(path) = &self.csv {
            write_rows(path, Arc::clone(&shared))?;
        }
        self.options.run(Exporter { shared, collisions: None }, "metrics")
    }
}

/// A line to standard error. Nobody reads it: no reason to end.
fn tell(line: impl std::fmt::Display) {
    let _ = writeln!(io::stderr(), "metrics: {line}");
}

/// What the threads share: the one that reads frames, those that serve pages, and the one that writes rows.
struct Shared {
    fleet: FleetName,
    state: Mutex<State>,
    processes: ProcessWatch,
    rows: Mutex<Option<Rows>>,
}

#[derive(Default)]
struct State {
    fold: Fold,
    collisions: Collisions,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shared {
    fn snapshot(&self) -> Snapshot {
        // What can't be told isn't there; `regatta doctor` says why.
        let processes = self.processes.newest().unwrap_or_default();
        let state = lock(&self.state);
        state.fold.snapshot(self.fleet.clone(), state.collisions.clone(), processes, wall_time_nanos())
    }

    fn lap(&self) -> Lap {
        lock(&self.state).fold.lap()
    }
}

impl Pages for Shared {
    fn metrics(&self) -> String {
        page(&self.snapshot(), *lock(&self.rows))
    }
}

struct Exporter {
    shared: Arc<Shared>,
    collisions: Option<CollisionReader>,
}

impl Plugin for Exporter {
    fn on_start(&mut self, fleet: &Participant) -> Result {
        self.collisions = Some(CollisionReader::open_on(fleet)?);
        Ok(())
    }

    fn on_frame(&mut self, frame: &Frame<'_>) -> Result {
        let now = wall_time_nanos();
        lock(&self.shared.state).fold.frame(frame, now);
        self.read_collisions(now);
        Ok(())
    }

    fn on_idle(&mut self, has_producer: bool) -> Result {
        lock(&self.shared.state).fold.idle(has_producer);
        self.read_collisions(wall_time_nanos());
        Ok(())
    }
}

impl Exporter {
    fn read_collisions(&mut self, now: u64) {
        if let Some(reader) = &mut self.collisions {
            let mut state = lock(&self.shared.state);
            reader.update(&mut state.fold, now);
            state.collisions = reader.collisions(state.fold.newest());
        }
    }
}

/// Starts to add a row a second to a file. On a thread of its own: a disk may hang.
fn write_rows(path: &Path, shared: Arc<Shared>) -> Result {
    let mut sheet = Sheet::new(path);
    let path = path.to_owned();
    thread::Builder::new().name("csv".to_owned()).spawn(move || {
        let mut next = Instant::now();
        loop {
            // Behind, after a hanging disk: don't hurry to catch up.
            next = (next + ROW_PERIOD).max(Instant::now());
            thread::sleep(next.saturating_duration_since(Instant::now()));
            let now = Duration::from_nanos(wall_time_nanos());
            match sheet.add(&row(now, &shared.snapshot(), &shared.lap())) {
                Some(Change::Failed(error)) => tell(error),
                Some(Change::Recovered(lost)) => {
                    tell(format_args!("writes {} again; {lost} rows were lost", path.display()));
                }
                None => {}
            }
            *lock(&shared.rows) = Some(sheet.rows());
        }
    })?;
    Ok(())
}
