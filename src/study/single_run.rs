//! `regatta study-run`: does one job of a study. The engine, the manager and the observers (traffic, meter and validator)
//! run in lockstep as processes of their own.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

use clap::Args;
use regatta_meter::Figures;
use regatta_plugin::{AFTER_VARIABLE, FleetName, LOAD_VARIABLE, Termination};
use regatta_study::job::{Job, Manager};
use regatta_study::outcome::{EdgeOutcome, Outcome};
use regatta_study::workers::UNWRITABLE;
use serde_json::Value;

use crate::failure::{Failure, plugin_failure, print_failure};
use crate::output::{Force, write_file};
use crate::supervisor::{EndedChild, Supervisor};
use crate::version;

const ENGINE: &str = "engine";
const MANAGER: &str = "fleet-manager";
const OBSERVERS: &str = "observers";
const RECORDER: &str = "record";
/// Files of the observers.
const TRAFFIC: &str = "traffic";
const METER: &str = "meter";
const VALIDATOR: &str = "validator";
/// The time between two checks of the processes.
const POLL_INTERVAL: Duration = Duration::from_millis(5);
/// The longest time that the engine waits for a tick of the others: the first ones of a large fleet take seconds.
const LOCKSTEP_TIMEOUT_SECS: &str = "120";

#[derive(Args)]
pub struct StudyRunArgs {
    /// File of the job
    job: PathBuf,
    /// File of its layout; the one that the job names in the folder `files` beside the job's if not given
    #[arg(long, value_name = "FILE")]
    layout: Option<PathBuf>,
    /// File for the result; the job's in the folder `results` beside the job's if not given
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Record the run to this file, too
    #[arg(long, value_name = "FILE.mcap")]
    record: Option<PathBuf>,
}

/// Runs `regatta study-run`.
pub fn run(args: &StudyRunArgs) -> Result<ExitCode, Failure> {
    let text = fs::read_to_string(&args.job).map_err(|error| format!("{}: {error}", args.job.display()))?;
    let job: Job =
        serde_json::from_str(&text).map_err(|error| format!("{}: not a job: {error}", args.job.display()))?;
    let program = version::short();
    if job.program != program {
        let wanted = &job.program;
        return Err(format!("the job is of Regatta {wanted}, and this is {program}: install the same version").into());
    }
    let beside = args.job.parent().and_then(Path::parent).unwrap_or(Path::new("."));
    let layout = args.layout.clone().unwrap_or_else(|| beside.join("files").join(job.layout()));
    let output = args.output.clone().unwrap_or_else(|| beside.join("results").join(format!("{}.json", job.id())));
    let outcome = Processes::start(&job, &layout, args.record.as_deref()).and_then(Processes::finish);
    let outcome = match outcome {
        Err(failure) if is_of_full_disk(&*failure) => return Ok(unwritable(&*failure)),
        outcome => outcome?,
    };
    let text = serde_json::to_string(&outcome)?;
    match write_file(&output, text.as_bytes(), Force { force: true }) {
        Ok(()) => Ok(ExitCode::SUCCESS),
        Err(failure) => Ok(unwritable(&*failure)),
    }
}

/// Whether a full disk is the reason, also of what another process has said.
fn is_of_full_disk(failure: &(dyn std::error::Error + 'static)) -> bool {
    let text = failure.to_string();
    ["No space left on device", "disk is full", "os error 28"].iter().any(|sign| text.contains(sign))
}

fn unwritable(failure: &(dyn std::error::Error + 'static)) -> ExitCode {
    print_failure(failure, false);
    ExitCode::from(UNWRITABLE)
}

/// The processes of a run.
struct Processes<'a> {
    job: &'a Job,
    fleet: FleetName,
    /// Stopped before the folder is removed.
    supervisor: Supervisor,
    /// For what the processes write.
    folder: tempfile::TempDir,
    termination: Termination,
    started: Instant,
}

impl<'a> Processes<'a> {
    fn start(job: &'a Job, layout: &Path, record: Option<&Path>) -> Result<Self, Failure> {
        let termination = Termination::watch().map_err(plugin_failure)?;
        let folder = tempfile::tempdir().map_err(|error| format!("can't create a temporary folder: {error}"))?;
        let fleet = format!("study-{}", std::process::id()).parse()?;
        let (supervisor, started) = (Supervisor::default(), Instant::now());
        let mut run = Self { job, fleet, supervisor, folder, termination, started };
        let scenario = run.write_scenario(layout)?;
        let members: Vec<_> = [MANAGER, OBSERVERS].into_iter().chain(record.map(|_| RECORDER)).collect();
        run.start_engine(&scenario, &members)?;
        // The task log has no history: who joins it after the manager's first tick misses how orders began.
        run.start_observers()?;
        run.start_manager(&scenario)?;
        if let Some(file) = record {
            let mut recorder = run.command(RECORDER, &["plugin", RECORDER, "--force"])?;
            recorder.arg("--output").arg(std::path::absolute(file)?).env(AFTER_VARIABLE, MANAGER);
            run.supervisor.start(RECORDER, &mut recorder)?;
        }
        Ok(run)
    }

    /// Robots that drive through each other aren't judged.
    fn is_judged(&self) -> bool {
        !matches!(self.job.manager, Manager::Bound(_))
    }

    fn write_scenario(&self, layout: &Path) -> Result<PathBuf, Failure> {
        let mut scenario = self.job.scenario.clone();
        scenario["graph"] = std::path::absolute(layout)?.to_string_lossy().into();
        let path = self.folder.path().join("scenario.yaml");
        // JSON is YAML, too.
        fs::write(&path, format!("{scenario:#}"))
            .map_err(|error| format!("can't write {}: {error}", path.display()))?;
        Ok(path)
    }

    fn start_engine(&mut self, scenario: &Path, members: &[&str]) -> Result<(), Failure> {
        let ticks = self.job.secs * u64::from(self.job.rate_hz);
        let mut engine = self.command(ENGINE, &[ENGINE])?;
        engine.arg(scenario).args(["--speed", "max", "--digest", "--ticks", &ticks.to_string()]);
        engine.args(["--lockstep-timeout", LOCKSTEP_TIMEOUT_SECS]);
        engine.args(members.iter().flat_map(|member| ["--lockstep", member]));
        self.supervisor.start(ENGINE, &mut engine)?;
        Ok(())
    }

    fn start_manager(&mut self, scenario: &Path) -> Result<(), Failure> {
        let mut manager = match &self.job.manager {
            Manager::BuiltIn(args) | Manager::Bound(args) => {
                let mut command = self.command(MANAGER, &["plugin", MANAGER])?;
                command.args(args).arg("--load").arg(scenario);
                command.args(matches!(self.job.manager, Manager::Bound(_)).then_some("--no-conflicts"));
                command
            }
            Manager::Command(words) => {
                let (program, args) = words.split_first().ok_or("the job's manager has no program")?;
                self.with_log(MANAGER, Command::new(program), args)?
            }
        };
        manager.env(LOAD_VARIABLE, scenario);
        self.supervisor.start(MANAGER, &mut manager)?;
        Ok(())
    }

    /// Starts the meters and the validator, which write figures at their end.
    fn start_observers(&mut self) -> Result<(), Failure> {
        let mut observers = self.command(OBSERVERS, &["study-observe", "--after", MANAGER])?;
        observers.arg("--traffic").arg(self.json_file(TRAFFIC)).arg("--meter").arg(self.json_file(METER));
        if self.is_judged() {
            observers.arg("--validator").arg(self.json_file(VALIDATOR));
        }
        let ready = self.folder.path().join("ready");
        observers.arg("--ready").arg(&ready);
        self.supervisor.start(OBSERVERS, &mut observers)?;
        while !ready.exists() {
            if self.engine_has_ended()? || self.termination.requested() {
                return Err("interrupted".into());
            }
            std::thread::sleep(POLL_INTERVAL);
        }
        Ok(())
    }

    /// Returns a command of this program.
    fn command(&self, name: &str, args: &[&str]) -> Result<Command, Failure> {
        let args: Vec<String> = args.iter().map(|arg| (*arg).to_owned()).collect();
        self.with_log(name, Command::new(std::env::current_exe()?), &args)
    }

    /// Adds arguments and the fleet, and a file for messages: `NAME.log`.
    fn with_log(&self, name: &str, mut command: Command, args: &[String]) -> Result<Command, Failure> {
        let log = File::create(self.folder.path().join(format!("{name}.log")))?;
        command.args(args).args(["--fleet", self.fleet.as_str()]);
        command.stdin(Stdio::null()).stdout(log.try_clone()?).stderr(log);
        Ok(command)
    }

    fn json_file(&self, name: &str) -> PathBuf {
        self.folder.path().join(format!("{name}.json"))
    }

    /// Waits for the end of the run, and returns what came of it.
    fn finish(mut self) -> Result<Outcome, Failure> {
        while !self.engine_has_ended()? {
            if self.termination.requested() {
                return Err("interrupted".into());
            }
            std::thread::sleep(POLL_INTERVAL);
        }
        let failures = self.supervisor.stop();
        if let Some(failure) = failures.first() {
            let name = failure.split_whitespace().next().unwrap_or(MANAGER);
            return Err(self.failure(failure, name));
        }
        let log = self.log(ENGINE);
        let is_digest = |line: &&str| line.len() == 32 && line.bytes().all(|byte| byte.is_ascii_hexdigit());
        let digest = log.lines().find(is_digest).ok_or("the engine gave no digest")?.to_owned();
        let figures: Figures = serde_json::from_value(self.json(METER)?)?;
        if figures.samples_missed > 0 {
            return Err(format!("{} samples of the task log were lost; run it again", figures.samples_missed).into());
        }
        Ok(Outcome {
            job: self.job.id(),
            digest,
            figures,
            findings: if self.is_judged() { findings(&self.json(VALIDATOR)?) } else { BTreeMap::new() },
            edges: edges(&self.json(TRAFFIC)?),
            wall_secs: self.started.elapsed().as_secs_f64(),
        })
    }

    /// Whether the engine has made all ticks.
    ///
    /// # Errors
    /// If a process has ended too early.
    fn engine_has_ended(&mut self) -> Result<bool, Failure> {
        let ended = self.supervisor.take_ended();
        let is_fault = |child: &&EndedChild| child.name != ENGINE || !child.status.success();
        // If another one has failed, that is why the engine has.
        match ended.iter().filter(is_fault).max_by_key(|child| child.name != ENGINE) {
            Some(child) => {
                let failure = child.failure().unwrap_or_else(|| format!("{} ended early", child.name));
                Err(self.failure(&failure, &child.name))
            }
            None => Ok(!ended.is_empty()),
        }
    }

    /// A failure of a process with the last line that it wrote.
    fn failure(&self, failure: &str, name: &str) -> Failure {
        let log = self.log(name);
        let line = log.lines().rfind(|line| !line.trim().is_empty()).unwrap_or_default();
        format!("{failure}: {}", line.trim_start_matches("regatta: ")).into()
    }

    fn log(&self, name: &str) -> String {
        fs::read_to_string(self.folder.path().join(format!("{name}.log"))).unwrap_or_default()
    }

    fn json(&self, name: &str) -> Result<Value, Failure> {
        let text = fs::read_to_string(self.json_file(name)).unwrap_or_default();
        serde_json::from_str(&text).map_err(|_| self.failure(&format!("{name} wrote no figures"), OBSERVERS))
    }
}

/// The kinds of findings that there are, with their counts.
fn findings(validator: &Value) -> BTreeMap<String, u64> {
    let kinds = validator["kinds"].as_array().into_iter().flatten();
    let kinds = kinds.filter_map(|kind| Some((kind["kind"].as_str()?.to_owned(), kind["count"].as_u64()?)));
    kinds.filter(|(_, count)| *count > 0).collect()
}

/// The edges on which robots were.
fn edges(traffic: &Value) -> Vec<EdgeOutcome> {
    let edge = |edge: &Value| {
        let number = |key: &str| edge[key].as_f64();
        Some(EdgeOutcome {
            edge: u32::try_from(edge["edge"].as_u64()?).ok()?,
            waiting_secs: number("waiting_secs")?,
            entered_per_hour: number("entered_per_hour")?,
        })
    };
    let edges = traffic["edges"].as_array().into_iter().flatten().filter_map(edge);
    edges.filter(|edge| edge.waiting_secs > 0.0 || edge.entered_per_hour > 0.0).collect()
}
