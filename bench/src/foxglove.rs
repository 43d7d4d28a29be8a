//! `regatta-bench foxglove`: a fleet live to one client of Foxglove's protocol, over loopback: its
//! frames, their age at the client, and the processor time of the plugin. The bar is a fleet of
//! 100,000 robots at 20 Hz with all frames.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::net::TcpStream;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use clap::Args;
use regatta::experiment::report::{Output, Report, environment};
use regatta::experiment::{Experiment, check_interrupt, seconds_parser, temporary_folder, write};
use regatta::failure::Failure;
use regatta::program::Program;
use regatta::supervisor::Supervisor;
use regatta_layout::generate::Warehouse;
use serde_json::{Value, json};
use tokio_tungstenite::tungstenite::client::IntoClientRequest;
use tokio_tungstenite::tungstenite::{Message, WebSocket, client};

use crate::reading::processor_secs_of;

/// The loads: number of robots, channel.
const LOADS: [(u32, &str); 4] =
    [(10_000, "/robots"), (100_000, "/robots"), (100_000, "/frames"), (100_000, "/poses")];
/// Frames per second.
const HZ: u32 = 20;
/// The warehouse in which the robots drive.
const WAREHOUSE: Warehouse = Warehouse { aisles: 24, rows: 18, bays: 6 };
const SCENARIO: &str = "foxglove.yaml";
/// The time before the measurement.
const WARM_UP: Duration = Duration::from_secs(2);
/// The longest time until the plugin listens, and between two messages.
const LONGEST: Duration = Duration::from_secs(60);
/// The byte that messages of channels begin with, and the bytes of their times.
const MESSAGE_DATA: u8 = 1;
const TIME: std::ops::Range<usize> = 5..13;

#[derive(Args)]
pub struct FoxgloveArgs {
    #[command(flatten)]
    output: Output,
    /// Seconds for which each load is measured.
    #[arg(long, default_value_t = 10, value_parser = seconds_parser())]
    secs: u64,
}

/// A message at the client.
#[derive(Clone, Copy)]
struct Arrival {
    /// Simulated time, in nanoseconds.
    time: u64,
    /// Wall time, in nanoseconds since the Unix epoch.
    at: u64,
    bytes: usize,
}

/// The figures of a load.
struct Figures {
    robots: u32,
    channel: &'static str,
    /// The part of the frames that arrived.
    arrived: f64,
    megabytes_per_sec: f64,
    /// Milliseconds, from the smallest on.
    ages: Vec<f64>,
    /// Processor time of the plugin by wall time.
    cores: f64,
    late_ticks: u64,
}

impl Figures {
    fn age(&self, part: f64) -> f64 {
        let last = self.ages.len().saturating_sub(1);
        self.ages.get((last as f64 * part).round() as usize).copied().unwrap_or(f64::NAN)
    }

    fn json(&self) -> Value {
        json!({
            "robots": self.robots, "channel": self.channel, "hz": HZ, "arrived": self.arrived,
            "megabytes_per_sec": self.megabytes_per_sec, "age_p50_ms": self.age(0.5),
            "age_p99_ms": self.age(0.99), "cores": self.cores, "late_ticks": self.late_ticks,
        })
    }
}

pub fn run(program: &Program, args: &FoxgloveArgs) -> Result<ExitCode, Failure> {
    args.output.check("foxglove")?;
    let folder = temporary_folder()?;
    write(&folder.path().join("warehouse.yaml"), &WAREHOUSE.generate()?)?;
    write(
        &folder.path().join(SCENARIO),
        "graph: warehouse.yaml\nseed: 1\nrobots: [{count: 1, routes: random}]\n",
    )?;
    let time = Duration::from_secs(args.secs);
    let mut figures = Vec::new();
    for load in LOADS {
        figures.push(measure(program, folder.path(), load, time)?);
    }
    let (line, machine) = environment(program);
    let loads: Vec<Value> = figures.iter().map(Figures::json).collect();
    let json = json!({"machine": machine, "secs": args.secs, "loads": loads});
    let markdown = markdown(&figures, &line);
    args.output.write(&Report { name: "foxglove", markdown, json, plot: None })?;
    Ok(ExitCode::SUCCESS)
}

fn measure(
    program: &Program,
    folder: &Path,
    (robots, channel): (u32, &'static str),
    time: Duration,
) -> Result<Figures, Failure> {
    let options = ["--robots", &robots.to_string(), "--rate", &HZ.to_string()].map(str::to_owned);
    let mut experiment = Experiment::start(program, "foxglove", &folder.join(SCENARIO), &options)?;
    let mut plugin = Supervisor::default();
    let log = folder.join(format!("{robots}{}.log", channel.replace('/', "-")));
    let mut command = program.command();
    command.args(["plugin", "foxglove", "--listen", "127.0.0.1:0", "--rate", "all", "--fleet"]);
    let pid = plugin.start(
        "foxglove",
        command.arg(experiment.fleet().to_string()).stderr(File::create(&log)?),
    )?;
    let socket = connect(&listening_address(&log)?, channel)?;
    let is_over = Arc::new(AtomicBool::new(false));
    let reader = read(socket, Arc::clone(&is_over));
    sent_for(&mut experiment, WARM_UP)?;
    let (late, cpu) = (experiment.status()?.late_ticks, processor_secs_of(pid)?);
    let started = Instant::now();
    let sent = sent_for(&mut experiment, time)?;
    let cores = (processor_secs_of(pid)? - cpu) / started.elapsed().as_secs_f64();
    let late_ticks = experiment.status()?.late_ticks - late;
    // The last frame arrives a while later.
    std::thread::sleep(Duration::from_millis(500));
    is_over.store(true, Ordering::Relaxed);
    let arrivals = reader.join().map_err(|_| "the client failed")?;
    plugin.stop();
    experiment.finish()?;
    let arrivals: Vec<(Arrival, u64)> = arrivals
        .into_iter()
        .filter_map(|arrival| Some((arrival, *sent.get(&arrival.time)?)))
        .collect();
    let bytes: usize = arrivals.iter().map(|(arrival, _)| arrival.bytes).sum();
    let ages = arrivals.iter().map(|(arrival, at)| arrival.at.saturating_sub(*at) as f64 * 1e-6);
    let mut ages: Vec<f64> = ages.collect();
    ages.sort_by(f64::total_cmp);
    Ok(Figures {
        robots,
        channel,
        arrived: arrivals.len() as f64 / sent.len().max(1) as f64,
        megabytes_per_sec: bytes as f64 * 1e-6 / time.as_secs_f64(),
        ages,
        cores,
        late_ticks,
    })
}

/// Waits until the plugin listens, and returns its address.
fn listening_address(log: &Path) -> Result<String, Failure> {
    let started = Instant::now();
    loop {
        check_interrupt()?;
        let text = fs::read_to_string(log)?;
        let address = text.split_once('\n').and_then(|(line, _)| line.split_once("ws://"));
        if let Some((address, _)) = address.and_then(|(_, rest)| rest.split_once(';')) {
            return Ok(address.to_owned());
        }
        if started.elapsed() > LONGEST {
            return Err(format!("foxglove did not start: {}", text.trim()).into());
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Connects a client, and subscribes to a channel.
fn connect(address: &str, channel: &str) -> Result<WebSocket<TcpStream>, Failure> {
    let mut request = format!("ws://{address}/").into_client_request()?;
    let protocol = "foxglove.sdk.v1".parse().map_err(|_| "the name of the protocol")?;
    request.headers_mut().insert("sec-websocket-protocol", protocol);
    let stream = TcpStream::connect(address)?;
    stream.set_read_timeout(Some(LONGEST))?;
    let (mut socket, _) = client(request, stream).map_err(|error| error.to_string())?;
    loop {
        let Message::Text(text) = socket.read()? else { continue };
        let message: Value = serde_json::from_str(&text)?;
        let mut channels = message["channels"].as_array().into_iter().flatten();
        if let Some(channel) = channels.find(|found| found["topic"] == channel) {
            let subscription = json!({"id": 0, "channelId": channel["id"]});
            let message = json!({"op": "subscribe", "subscriptions": [subscription]});
            socket.send(Message::text(message.to_string()))?;
            return Ok(socket);
        }
    }
}

/// Reads messages on a thread of its own, until it is over.
fn read(mut socket: WebSocket<TcpStream>, is_over: Arc<AtomicBool>) -> JoinHandle<Vec<Arrival>> {
    std::thread::spawn(move || {
        let mut arrivals = Vec::new();
        while !is_over.load(Ordering::Relaxed) {
            let Ok(message) = socket.read() else { break };
            let Message::Binary(bytes) = message else { continue };
            let time = bytes.get(TIME).and_then(|time| time.try_into().ok());
            if let (Some(&MESSAGE_DATA), Some(time)) = (bytes.first(), time) {
                let time = u64::from_le_bytes(time);
                arrivals.push(Arrival { time, at: now_nanos(), bytes: bytes.len() });
            }
        }
        arrivals
    })
}

fn now_nanos() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_nanos() as u64
}

/// Watches frames for a time. Returns the wall time of each by its simulated time.
fn sent_for(experiment: &mut Experiment, time: Duration) -> Result<BTreeMap<u64, u64>, Failure> {
    let (started, mut sent) = (Instant::now(), BTreeMap::new());
    experiment.watch(time + LONGEST, |frame| {
        let header = frame.header();
        sent.insert(header.sim_time_nanos, header.wall_time_nanos);
        started.elapsed() >= time
    })?;
    Ok(sent)
}

fn markdown(figures: &[Figures], environment: &str) -> String {
    let mut text = format!(
        "# Foxglove: a fleet live to one client\n\n{environment}\n\nEngine, plugin and client are \
         separate processes; frames come at {HZ} Hz. The age is the time from when the engine \
         sends a frame until the client has all of it. A core is one second of processor time \
         per second of wall time.\n\n| robots | channel | frames | MB/s | age p50 (ms) | age p99 (ms) | \
         plugin (cores) | late ticks |\n|---|---|---|---|---|---|---|---|\n"
    );
    for load in figures {
        let _ = writeln!(
            text,
            "| {} | `{}` | {:.1} % | {:.1} | {:.1} | {:.1} | {:.2} | {} |",
            load.robots,
            load.channel,
            load.arrived * 100.0,
            load.megabytes_per_sec,
            load.age(0.5),
            load.age(0.99),
            load.cores,
            load.late_ticks,
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ages_are_percentiles() {
        let figures = Figures {
            robots: 10,
            channel: "/robots",
            arrived: 0.5,
            megabytes_per_sec: 1.0,
            ages: (0..=100).map(f64::from).collect(),
            cores: 0.25,
            late_ticks: 0,
        };
        assert_eq!((figures.age(0.5), figures.age(0.99)), (50.0, 99.0));
        let row = "| 10 | `/robots` | 50.0 % | 1.0 | 50.0 | 99.0 | 0.25 | 0 |";
        assert!(markdown(&[figures], "here").contains(row));
    }
}
