//! `regatta doctor`: checks that this machine can run fleets, and gives advice where it can't.

use std::fmt;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::Args;
use regatta_plugin::frame::CONTRACT_VERSION;
use regatta_plugin::health::{self, Cleaned, Occupant};
use regatta_plugin::{FleetName, ProducerPorts, RUNTIME_DIR_VARIABLE, Subscriber};

use crate::failure::Failure;

#[derive(Args)]
pub struct DoctorArgs {
    /// Remove what dead processes left in shared memory.
    #[arg(long)]
    pub clean: bool,
    /// Print a line of JSON for each check.
    #[arg(long)]
    pub json: bool,
}

/// Less available shared memory than this gives a warning: the frames of a million robots take
/// about 75 MB.
const LOW_MEMORY: u64 = 128 << 20;
/// Less memory than this that others use is not worth a warning.
const WORTH_TELLING: u64 = 1 << 20;
/// The longest time that the trial's frame may take.
const TRIAL_TIMEOUT: Duration = Duration::from_secs(5);

/// The result of a check: one line of the output.
enum CheckResult {
    Passed(String),
    Warning { problem: String, advice: String },
    Failed { problem: String, advice: String },
}

use CheckResult::{Failed, Passed, Warning};

impl CheckResult {
    fn to_json(&self) -> serde_json::Value {
        match self {
            Passed(message) => serde_json::json!({"result": "ok", "message": message}),
            Warning { problem, advice } => {
                serde_json::json!({"result": "warn", "message": problem, "advice": advice})
            }
            Failed { problem, advice } => {
                serde_json::json!({"result": "fail", "message": problem, "advice": advice})
            }
        }
    }
}

impl fmt::Display for CheckResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Passed(message) => write!(f, "ok    {message}"),
            Warning { problem, advice } => write!(f, "warn  {problem} -> {advice}"),
            Failed { problem, advice } => write!(f, "fail  {problem} -> {advice}"),
        }
    }
}

pub fn run(args: DoctorArgs) -> Result<ExitCode, Failure> {
    health::look_only();
    let mut results = Vec::new();
    if args.clean {
        results.push(cleanup_result(health::clean()?));
    }
    results.extend([memory(), rights()]);
    results.extend(directory());
    results.extend(processes());
    results.extend([versions(), trial(), processor()]);
    for result in &results {
        if args.json { println!("{}", result.to_json()) } else { println!("{result}") }
    }
    let any_failed = results.iter().any(|result| matches!(result, Failed { .. }));
    Ok(if any_failed { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

fn failed(error: impl fmt::Display, advice: &str) -> CheckResult {
    Failed { problem: error.to_string(), advice: advice.to_owned() }
}

fn cleanup_result(cleaned: Cleaned) -> CheckResult {
    let Cleaned { occupants, failed, orphans, bytes, repaired } = cleaned;
    let freed = megabytes(bytes);
    let repaired = if repaired { "; removed the damaged management segment" } else { "" };
    let message = format!(
        "cleaned up after {occupants} dead processes and {orphans} orphaned segments: {freed} freed{repaired}"
    );
    if failed == 0 {
        return Passed(message);
    }
    let problem = format!("{message}; can't clean up after {failed} dead processes");
    Warning {
        problem,
        advice: "another process may be cleaning up: run `regatta doctor --clean` again".to_owned(),
    }
}

fn megabytes(bytes: u64) -> String {
    format!("{:.1} MB", bytes as f64 / 1e6)
}

fn memory() -> CheckResult {
    let folder = health::SHARED_MEMORY;
    match health::space() {
        Ok(space) if space.available < LOW_MEMORY => Warning {
            problem: format!(
                "shared memory: only {} of {} left in {folder}",
                megabytes(space.available),
                megabytes(space.total)
            ),
            advice: format!(
                "enough for small fleets; for more, `mount -o remount,size=1g {folder}` (Docker: --shm-size=1g)"
            ),
        },
        Ok(space) => Passed(format!(
            "shared memory: {} of {} left in {folder}",
            megabytes(space.available),
            megabytes(space.total)
        )),
        Err(error) => failed(error, "mount a tmpfs there"),
    }
}

fn rights() -> CheckResult {
    match health::check_rights() {
        Ok(()) => Passed(
            "rights: this user can create shared memory (other users can't read its fleets)"
                .to_owned(),
        ),
        Err(error) => failed(
            error,
            &format!("let this user write to {}: `chmod 1777`", health::SHARED_MEMORY),
        ),
    }
}

/// The advice if iceoryx2's files can't be listed.
const CHECK_OWNER: &str = "check the directory above, and who owns it";

/// Checks where this user's shared memory is.
fn directory() -> Vec<CheckResult> {
    let mut results = Vec::new();
    match health::location() {
        Ok((root, prefix)) => {
            results.push(Passed(format!(
                "directory: {root} (segments {}/{prefix}*)",
                health::SHARED_MEMORY
            )));
        }
        Err(error) => results.push(failed(error, "other users may not control it")),
    }
    if let Some(damage) = health::damage() {
        results.push(failed(damage, "run `regatta doctor --clean`"));
    }
    match health::bytes_elsewhere() {
        Ok(bytes) if bytes >= WORTH_TELLING => results.push(Warning {
            problem: format!("{} of segments belong to another directory", megabytes(bytes)),
            advice: format!(
                "a container or another {RUNTIME_DIR_VARIABLE} may use them; if none does, remove {}/regatta_* that don't \
                 have the prefix above",
                health::SHARED_MEMORY
            ),
        }),
        _ => {}
    }
    results
}

fn processes() -> Vec<CheckResult> {
    let occupants = match health::occupants() {
        Ok(occupants) => occupants,
        Err(error) => return vec![failed(error, CHECK_OWNER)],
    };
    let (alive, dead): (Vec<_>, Vec<_>) = occupants.iter().partition(|occupant| occupant.alive);
    let mut results = vec![Passed(format!("processes in shared memory: {}", list(&alive)))];
    if !dead.is_empty() {
        results.push(Warning {
            problem: format!("left by dead processes: {}", list(&dead)),
            advice: "run `regatta doctor --clean`, or start any fleet or plugin: it cleans up too"
                .to_owned(),
        });
    }
    match health::orphans() {
        Ok(orphans) if orphans.is_empty() => {}
        Ok(orphans) => results.push(Warning {
            problem: format!(
                "{} segments without an owner: {}",
                orphans.len(),
                megabytes(orphans.iter().map(|orphan| orphan.bytes).sum())
            ),
            advice: "run `regatta doctor --clean`".to_owned(),
        }),
        Err(error) => results.push(failed(error, CHECK_OWNER)),
    }
    results
}

fn list(occupants: &[&Occupant]) -> String {
    if occupants.is_empty() {
        return "none".to_owned();
    }
    let (unnamed, named): (Vec<_>, Vec<_>) =
        occupants.iter().partition(|occupant| occupant.name.is_empty());
    let mut entries: Vec<_> = named.into_iter().copied().map(describe).collect();
    if !unnamed.is_empty() {
        // The files with their names are already deleted, or belong to another user.
        let bytes = unnamed.iter().map(|occupant| occupant.bytes).sum();
        entries.push(format!("{} without a name ({})", unnamed.len(), megabytes(bytes)));
    }
    entries.join(", ")
}

fn describe(occupant: &Occupant) -> String {
    let Occupant { name, executable, pid, bytes, .. } = occupant;
    format!("{name} ({executable} {pid}, {})", megabytes(*bytes))
}

fn versions() -> CheckResult {
    match health::versions() {
        Ok(versions) => {
            let others: Vec<_> = versions
                .keys()
                .filter(|version| **version != CONTRACT_VERSION.to_string())
                .collect();
            if others.is_empty() {
                return Passed(format!(
                    "contract: version {CONTRACT_VERSION}, and no fleet here has another"
                ));
            }
            Warning {
                problem: format!(
                    "contract: this program has version {CONTRACT_VERSION}, but there are fleets with version {others:?}"
                ),
                advice: "stop them, or use the programs of their release for them".to_owned(),
            }
        }
        Err(error) => failed(error, CHECK_OWNER),
    }
}

/// Publishes a frame and receives it.
fn trial() -> CheckResult {
    match send_a_frame() {
        Ok(time) => Passed(format!(
            "iceoryx2 0.10: a frame of 1000 robots was received after {:.0} µs",
            time.as_secs_f64() * 1e6
        )),
        Err(error) => failed(
            format_args!("iceoryx2 0.10: {error}"),
            "check the lines above; -vv shows iceoryx2's own log",
        ),
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
    match reader.wait(TRIAL_TIMEOUT)? {
        Some(_) => Ok(start.elapsed()),
        None => Err(format!("no frame was received within {} s", TRIAL_TIMEOUT.as_secs()).into()),
    }
}

fn processor() -> CheckResult {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    Passed(format!("processor: {cores} cores, motion kernel for {}", regatta_motion::Isa::detect()))
}
