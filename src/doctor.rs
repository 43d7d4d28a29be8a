//! `regatta doctor`: checks that this machine can run fleets, and gives advice if it can't.

use std::fmt;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::Args;
use regatta_plugin::frame::CONTRACT_VERSION;
use regatta_plugin::health::{self, Cleaned, Occupant};
use regatta_plugin::{FleetName, ProducerPorts, RUNTIME_DIR_VARIABLE, Subscriber};
use serde_json::json;

use crate::failure::Failure;

#[derive(Args)]
pub struct DoctorArgs {
    /// Remove the remains of dead processes from shared memory.
    #[arg(long)]
    pub clean: bool,
    /// Print a line of JSON for each check.
    #[arg(long)]
    pub json: bool,
}

/// Less available shared memory than this gives a warning: the frames of a million robots take
/// about 75 MB.
const LOW_MEMORY: u64 = 128 << 20;
/// Less memory than this in other directories is not worth a warning.
const WORTH_A_WARNING: u64 = 1 << 20;
/// The longest time that the trial's frame may take.
const TRIAL_TIMEOUT: Duration = Duration::from_secs(5);

/// The outcome of a check.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Outcome {
    Ok,
    Warn,
    Fail,
}

impl Outcome {
    fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Warn => "warn",
            Self::Fail => "fail",
        }
    }
}

/// The result of a check: one line of the output.
struct CheckResult {
    outcome: Outcome,
    message: String,
    /// The way to correct a problem.
    advice: Option<String>,
}

impl CheckResult {
    fn to_json(&self) -> serde_json::Value {
        let mut json = json!({"result": self.outcome.name(), "message": self.message});
        if let Some(advice) = &self.advice {
            json["advice"] = json!(advice);
        }
        json
    }
}

impl fmt::Display for CheckResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:<4}  {}", self.outcome.name(), self.message)?;
        match &self.advice {
            Some(advice) => write!(f, " -> {advice}"),
            None => Ok(()),
        }
    }
}

/// Runs `regatta doctor`.
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
    let any_failed = results.iter().any(|result| result.outcome == Outcome::Fail);
    Ok(if any_failed { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

fn passed(message: impl fmt::Display) -> CheckResult {
    CheckResult { outcome: Outcome::Ok, message: message.to_string(), advice: None }
}

fn warning(problem: impl fmt::Display, advice: impl fmt::Display) -> CheckResult {
    let (message, advice) = (problem.to_string(), Some(advice.to_string()));
    CheckResult { outcome: Outcome::Warn, message, advice }
}

fn failed(problem: impl fmt::Display, advice: impl fmt::Display) -> CheckResult {
    CheckResult { outcome: Outcome::Fail, ..warning(problem, advice) }
}

fn cleanup_result(cleaned: Cleaned) -> CheckResult {
    let Cleaned { occupants, failed, orphans, bytes, repaired } = cleaned;
    let freed = megabytes(bytes);
    let repaired = if repaired { "; removed the damaged management segment" } else { "" };
    let message = format!(
        "cleaned up after {occupants} dead processes and {orphans} orphaned segments: \
         {freed} freed{repaired}"
    );
    if health::damage().is_some() {
        return warning(message, "what is named below can't be removed by this user");
    }
    if failed == 0 {
        return passed(message);
    }
    warning(
        format_args!("{message}; can't clean up after {failed} dead processes"),
        "another process may be cleaning up: run `regatta doctor --clean` again",
    )
}

fn megabytes(bytes: u64) -> String {
    format!("{:.1} MB", bytes as f64 / 1e6)
}

fn memory() -> CheckResult {
    let folder = health::SHARED_MEMORY;
    let space = match health::space() {
        Ok(space) => space,
        Err(error) => return failed(error, "mount a tmpfs there"),
    };
    let (available, total) = (megabytes(space.available), megabytes(space.total));
    if space.available >= LOW_MEMORY {
        return passed(format_args!("shared memory: {available} of {total} left in {folder}"));
    }
    warning(
        format_args!("shared memory: only {available} of {total} left in {folder}"),
        format_args!(
            "enough for small fleets; for more, `mount -o remount,size=1g {folder}` \
             (Docker: --shm-size=1g)"
        ),
    )
}

fn rights() -> CheckResult {
    let folder = health::SHARED_MEMORY;
    match health::check_rights() {
        Ok(()) => {
            passed("rights: this user can create shared memory (other users can't read its fleets)")
        }
        Err(error) => failed(error, format_args!("let this user write to {folder}: `chmod 1777`")),
    }
}

/// The advice if iceoryx2's files can't be listed.
const CHECK_OWNER: &str = "check the directory above, and who owns it";

/// Checks the location of this user's shared memory.
fn directory() -> Vec<CheckResult> {
    let folder = health::SHARED_MEMORY;
    let mut results = Vec::new();
    results.push(match health::location() {
        Ok((root, prefix)) => {
            passed(format_args!("directory: {root} (segments {folder}/{prefix}*)"))
        }
        Err(error) => failed(error, "other users may not control it"),
    });
    if let Some(damage) = health::damage() {
        results.push(failed(damage, "no process of this user can join a fleet until then"));
    }
    if let Ok(bytes) = health::bytes_elsewhere()
        && bytes >= WORTH_A_WARNING
    {
        results.push(warning(
            format_args!("{} of segments belong to another directory", megabytes(bytes)),
            format_args!(
                "a container or another {RUNTIME_DIR_VARIABLE} may use them; if none does, remove \
                 {folder}/regatta_* that don't have the prefix above"
            ),
        ));
    }
    results
}

fn processes() -> Vec<CheckResult> {
    let occupants = match health::occupants() {
        Ok(occupants) => occupants,
        Err(error) => return vec![failed(error, CHECK_OWNER)],
    };
    let (alive, dead): (Vec<_>, Vec<_>) = occupants.iter().partition(|occupant| occupant.alive);
    let mut results = vec![passed(format_args!("processes in shared memory: {}", list(&alive)))];
    if !dead.is_empty() {
        results.push(warning(
            format_args!("left by dead processes: {}", list(&dead)),
            "run `regatta doctor --clean`, or start any fleet or plugin: it cleans up too",
        ));
    }
    match health::orphans() {
        Ok(orphans) if orphans.is_empty() => {}
        Ok(orphans) => {
            let (count, bytes) = (orphans.len(), orphans.iter().map(|orphan| orphan.bytes).sum());
            results.push(warning(
                format_args!("{count} segments without an owner: {}", megabytes(bytes)),
                "run `regatta doctor --clean`",
            ));
        }
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
    let versions = match health::versions() {
        Ok(versions) => versions,
        Err(error) => return failed(error, CHECK_OWNER),
    };
    let ours = CONTRACT_VERSION.to_string();
    let others: Vec<_> = versions.keys().filter(|version| **version != ours).collect();
    if others.is_empty() {
        return passed(format_args!("contract: version {ours}, and no fleet here has another"));
    }
    warning(
        format_args!(
            "contract: this program has version {ours}, but there are fleets with version \
             {others:?}"
        ),
        "stop them, or use the programs of their release for them",
    )
}

/// Publishes a frame and receives it.
fn trial() -> CheckResult {
    match send_a_frame() {
        Ok(time) => passed(format_args!(
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
    passed(format_args!(
        "processor: {cores} cores, motion kernel for {}",
        regatta_motion::Isa::detect()
    ))
}
