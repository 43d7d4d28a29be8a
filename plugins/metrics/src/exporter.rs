//! The plugin: reads every frame, serves the page and writes the CSV file.

use std::ffi::OsString;

use std::net::{IpAddr, Ipv4Addr, SocketAddr, ToSocketAddrs};
use std::path::PathBuf;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use clap::Parser;
use parking_lot::Mutex;
use regatta_kit::server::{Access, Place, Server, socket_path};
use regatta_kit::{CsvFile, private};
use regatta_plugin::{Error, FleetName, Frame, Options, Participant, Plugin, Result};

use crate::aggregator::wall_time_nanos;
use crate::exposition::Format;
use crate::fleet::{FleetReader, FleetState};
use crate::page::{ExporterState, page};
use crate::processes::ProcessMonitor;
use crate::row::{header, row};
use crate::server::{self, PageSource};
use crate::snapshot::{IntervalStats, Snapshot};

/// Time between two rows of the CSV file.
const ROW_PERIOD: Duration = Duration::from_secs(1);

/// The command line of `regatta plugin metrics`.
#[derive(Clone, Debug, Parser)]
#[command(max_term_width = 100)]
#[command(about = "Export metrics to Prometheus, and write them as CSV")]
pub struct Cli {
    /// Serve http://IP:PORT/metrics to clients with the token; port 0 is any free one [default: at
    /// a Unix socket of this user]
    #[arg(long, value_name = "IP:PORT", value_parser = address)]
    pub listen: Option<SocketAddr>,
    /// File with the token; addresses other than loopback need one [default: this user's token]
    #[arg(long, value_name = "FILE", requires = "listen")]
    pub token_file: Option<PathBuf>,
    /// Append a row of metrics to this file every second
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Options of every plugin.
    #[command(flatten)]
    pub options: Options,
}

fn address(text: &str) -> Result<SocketAddr, String> {
    let mut addresses = text
        .to_socket_addrs()
        .map_err(|_| "give IP:PORT, for example 127.0.0.1:9464".to_owned())?;
    addresses.next().ok_or_else(|| "this host name has no address".to_owned())
}

/// The default address on systems without Unix sockets.
const WITHOUT_SOCKETS: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 9464);
/// The error of an address that other machines can reach, without a token for them.
const NEEDS_TOKEN: &str = "other machines can reach this address: give a token with --token-file, \
                           or listen on 127.0.0.1";

/// Runs the plugin with a command line, whose first argument is the name of the program. `commit`
/// is the commit of the program, if it is known.
///
/// # Errors
/// Fails if an option is invalid, if the address can't be listened on, if the CSV file can't be
/// opened or is something else, or as [`regatta_plugin::run`] does.
pub fn run_from<A: Into<OsString> + Clone>(
    args: impl IntoIterator<Item = A>,
    commit: Option<&'static str>,
) -> Result {
    regatta_kit::run_from(args, |cli: Cli| cli.run(commit))
}

impl Cli {
    /// The place that it serves at, and the token over TCP.
    fn place(&self) -> Result<(Place, Access)> {
        let without = (!cfg!(unix)).then_some(WITHOUT_SOCKETS);
        let Some(address) = self.listen.or(without) else {
            let socket = socket_path(&self.options.fleet, "metrics")?;
            return Ok((Place::Socket(socket), Access::default()));
        };
        let token = match &self.token_file {
            Some(file) => private::read_token(file)?,
            None if address.ip().is_loopback() => private::token()?,
            None => return Err(Error::new(NEEDS_TOKEN)),
        };
        Ok((Place::Tcp(address), Access::with_token(Some(token))))
    }

    /// The address of its page, and the file with the token that it needs.
    fn address_of(&self, server: &Server) -> Result<String> {
        let Some(address) = server.address() else {
            let sockets: Vec<_> = server.places().iter().map(Place::to_string).collect();
            return Ok(format!("the Unix socket {}", sockets.join(", ")));
        };
        let own = private::token_file()?;
        let token = self.token_file.as_deref().unwrap_or(&own).display();
        Ok(format!("http://{address}/metrics, with the token of {token}"))
    }

    fn run(&self, commit: Option<&'static str>) -> Result {
        let fleet = &self.options.fleet;
        let csv_file =
            self.csv.as_deref().map(|path| CsvFile::open(path, &header())).transpose()?;
        let shared = Arc::new(Shared {
            fleet: fleet.clone(),
            state: Mutex::default(),
            processes: ProcessMonitor::start(fleet)?,
            exporter: Mutex::new(ExporterState {
                rows: csv_file.as_ref().map(CsvFile::rows),
                commit,
            }),
        });
        let (place, access) = self.place()?;
        let server = server::start(place, access, Arc::clone(&shared))?;
        report(format_args!("fleet '{fleet}' at {}", self.address_of(&server)?));
        if let Some(csv_file) = csv_file {
            write_rows(csv_file, Arc::clone(&shared))?;
        }
        self.options.run(Exporter { shared, reader: None }, "metrics")
    }
}

/// Prints a line to standard error. A closed standard error isn't a reason to stop.
fn report(line: impl std::fmt::Display) {
    regatta_plugin::tell!("metrics: {line}");
}

/// The state that the threads share: the one that reads frames, the one that serves pages, and the
/// one that writes rows.
struct Shared {
    fleet: FleetName,
    state: Mutex<FleetState>,
    processes: ProcessMonitor,
    exporter: Mutex<ExporterState>,
}

impl Shared {
    fn snapshot(&self) -> Snapshot {
        // Processes that can't be listed are left out; `regatta doctor` reports why.
        let processes = self.processes.newest().unwrap_or_default();
        self.state.lock().snapshot(&self.fleet, processes)
    }

    fn interval(&self) -> IntervalStats {
        self.state.lock().aggregator.take_interval()
    }
}

impl PageSource for Shared {
    fn metrics(&self, format: Format) -> String {
        page(&self.snapshot(), &self.exporter.lock(), format)
    }
}

struct Exporter {
    shared: Arc<Shared>,
    reader: Option<FleetReader>,
}

impl Plugin for Exporter {
    fn on_start(&mut self, fleet: &Participant) -> Result {
        self.reader = Some(FleetReader::open_on(fleet)?);
        Ok(())
    }

    fn on_frame(&mut self, frame: &Frame<'_>) -> Result {
        if let Some(reader) = &mut self.reader {
            let (now, mut state) = (wall_time_nanos(), self.shared.state.lock());
            reader.add_frame(&mut state, frame, now);
            reader.update(&mut state, now);
        }
        Ok(())
    }

    fn on_idle(&mut self, has_producer: bool) -> Result {
        let mut state = self.shared.state.lock();
        state.aggregator.note_idle(has_producer);
        if let Some(reader) = &mut self.reader {
            reader.update(&mut state, wall_time_nanos());
        }
        Ok(())
    }
}

/// Starts to append a row per second to a file, on a thread of its own because a disk may hang.
fn write_rows(mut csv_file: CsvFile, shared: Arc<Shared>) -> Result {
    thread::Builder::new().name("csv".to_owned()).spawn(move || {
        let mut next = Instant::now();
        loop {
            // After a hanging disk, missed rows are skipped.
            next = (next + ROW_PERIOD).max(Instant::now());
            thread::sleep(next.saturating_duration_since(Instant::now()));
            let now = Duration::from_nanos(wall_time_nanos());
            let row = row(now, &shared.snapshot(), &shared.interval());
            if let Some(change) = csv_file.append(&format!("{row}\n")) {
                report(change);
            }
            shared.exporter.lock().rows = Some(csv_file.rows());
        }
    })?;
    Ok(())
}
