//! `regatta doctor`: what can keep a fleet from running on this machine, and what to do about it.

use std::fmt;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::Args;
use regatta_plugin::ProducerPorts;
use regatta_plugin::frame::CONTRACT_VERSION;
use regatta_plugin::health::{self, Cleaned, Occupant};
use regatta_plugin::{FleetName, Subscriber};

use crate::Failure;

#[derive(Args)]
pub struct DoctorArgs {
    /// Remove what dead processes left in shared memory.
    #[arg(long)]
    pub clean: bool,
}

/// Below this, say so: a million robots take about 75 MB in frames.
const LITTLE: u64 = 128 << 20;
/// A frame of the trial must come through in this time.
const TRIAL_PATIENCE: Duration = Duration::from_secs(5);

/// One line of the report.
enum Finding {
    Fine(String),
    Warning { what: String, advice: String },
    Fault { what: String, advice: String },
}

use Finding::{Fault, Fine, Warning};

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Fine(what) => write!(f, "ok    {what}"),
            Warning { what, advice } => write!(f, "warn  {what} -> {advice}"),
            Fault { what, advice } => write!(f, "fail  {what} -> {advice}"),
        }
    }
}

pub fn run(args: DoctorArgs) -> Result<ExitCode, Failure> {
    let mut findings = Vec::new();
    if args.clean {
        findings.push(describe_cleaning(health::clean()?));
    }
    // The trial joins a fleet, which cleans up after dead processes by itself: look at those first.
    findings.extend([memory(), rights()]);
    findings.extend(occupants());
    findings.extend([versions(), trial(), instruction_set()]);
    for finding in &findings {
        println!("{finding}");
    }
    let faulty = findings.iter().any(|finding| matches!(finding, Fault { .. }));
    Ok(if faulty { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

fn fault(error: impl fmt::Display, advice: &str) -> Finding {
    Fault { what: error.to_string(), advice: advice.to_owned() }
}

fn describe_cleaning(cleaned: Cleaned) -> Finding {
    let Cleaned { occupants, failed, orphans, bytes } = cleaned;
    let what =
        format!("cleaned up after {occupants} dead processes and {orphans} lost segments: {} freed", megabytes(bytes));
    if failed == 0 {
        return Fine(what);
    }
    let advice = "they may be another user's: run `regatta doctor --clean` as that user".to_owned();
    Warning { what: format!("{what}; {failed} dead processes can't be cleaned up after"), advice }
}

fn megabytes(bytes: u64) -> String {
    format!("{:.1} MB", bytes as f64 / 1e6)
}

fn memory() -> Finding {
    let place = health::SHARED_MEMORY;
    match health::space() {
        Ok(space) if space.available < LITTLE => Warning {
            what: format!(
                "shared memory: only {} of {} left in {place}",
                megabytes(space.available),
                megabytes(space.total)
            ),
            advice: format!(
                "enough for small fleets; for more, `mount -o remount,size=1g {place}` (Docker: --shm-size=1g)"
            ),
        },
        Ok(space) => {
            Fine(format!("shared memory: {} of {} left in {place}", megabytes(space.available), megabytes(space.total)))
        }
        Err(error) => fault(error, "mount a tmpfs there"),
    }
}

fn rights() -> Finding {
    match health::check_rights() {
        Ok(()) => Fine("rights: this user may create shared memory (other users can't read its fleets)".to_owned()),
        Err(error) => fault(error, &format!("let this user write to {}: `chmod 1777`", health::SHARED_MEMORY)),
    }
}

fn occupants() -> Vec<Finding> {
    let occupants = match health::occupants() {
        Ok(occupants) => occupants,
        Err(error) => return vec![fault(error, "see whether /tmp/iceoryx2 belongs to another user")],
    };
    let (alive, dead): (Vec<_>, Vec<_>) = occupants.iter().partition(|occupant| occupant.alive);
    let mut findings = vec![Fine(format!("processes in shared memory: {}", list(&alive)))];
    let clean = || "`regatta doctor --clean`, or start anything: it cleans up too".to_owned();
    if !dead.is_empty() {
        findings.push(Warning { what: format!("left by dead processes: {}", list(&dead)), advice: clean() });
    }
    match health::orphans() {
        Ok(orphans) if orphans.is_empty() => {}
        Ok(orphans) => findings.push(Warning {
            what: format!(
                "{} segments without an owner: {}",
                orphans.len(),
                megabytes(orphans.iter().map(|orphan| orphan.bytes).sum())
            ),
            advice: "`regatta doctor --clean`".to_owned(),
        }),
        Err(error) => findings.push(fault(error, "see whether /tmp/iceoryx2 belongs to another user")),
    }
    findings
}

fn list(occupants: &[&Occupant]) -> String {
    if occupants.is_empty() {
        return "none".to_owned();
    }
    occupants.iter().map(|occupant| describe(occupant)).collect::<Vec<_>>().join(", ")
}

fn describe(occupant: &Occupant) -> String {
    let Occupant { name, executable, pid, bytes, .. } = occupant;
    match name.is_empty() {
        // What it said about itself is gone already, or another user's.
        true => format!("a process without a name ({})", megabytes(*bytes)),
        false => format!("{name} ({executable} {pid}, {})", megabytes(*bytes)),
    }
}

fn versions() -> Finding {
    match health::versions() {
        Ok(versions) => {
            let others: Vec<_> = versions.keys().filter(|version| **version != CONTRACT_VERSION.to_string()).collect();
            if others.is_empty() {
                return Fine(format!("contract: version {CONTRACT_VERSION}, and no fleet here speaks another"));
            }
            Warning {
                what: format!(
                    "contract: this is version {CONTRACT_VERSION}, but there are fleets of version {others:?}"
                ),
                advice: "stop them, or use the programs of their release with them".to_owned(),
            }
        }
        Err(error) => fault(error, "see whether /tmp/iceoryx2 belongs to another user"),
    }
}

/// Sends a frame to itself.
fn trial() -> Finding {
    match send_a_frame() {
        Ok(time) => {
            Fine(format!("iceoryx2 0.10: a frame of 1000 robots came through in {:.0} µs", time.as_secs_f64() * 1e6))
        }
        Err(error) => fault(format_args!("iceoryx2 0.10: {error}"), "look at the lines above; -vv shows its own log"),
    }
}

fn send_a_frame() -> Result<Duration, Failure> {
    let fleet: FleetName = format!("doctor-{}", std::process::id()).parse()?;
    let producer = ProducerPorts::create(&fleet, 1000)?;
    let mut reader = Subscriber::open(&fleet)?;
    producer.update();
    let start = Instant::now();
    producer.loan(1000)?.send()?;
    producer.notify();
    match reader.wait(TRIAL_PATIENCE)? {
        Some(_) => Ok(start.elapsed()),
        None => Err(format!("no frame came through in {} s", TRIAL_PATIENCE.as_secs()).into()),
    }
}

fn instruction_set() -> Finding {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    Fine(format!("processor: {cores} cores, motion kernel for {}", regatta_engine::motion::Isa::detect()))
}
