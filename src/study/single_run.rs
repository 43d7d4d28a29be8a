//! `regatta study-run`: does one job of a study. The engine, Regatta's manager and the observers
//! (traffic, meter and validator) call each other in this process. With a manager that is another
//! program, they run in lockstep as processes of their own, with the same figures.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use clap::{Args, Parser};
use regatta_meter::Figures;
use regatta_plugin::{AFTER_VARIABLE, LOAD_VARIABLE, Termination};
use regatta_run::{Run, RunError};
use regatta_scenario::{Overrides, Scenario};
use regatta_study::job::{Job, Manager};
use regatta_study::outcome::{
    EdgeOutcome, Example, Outcome, SeenStates, Stall, edges, examples, stalls,
};
use regatta_study::store::check_folder;
use regatta_study::workers::{NO_ROOM, UNWRITABLE};
use serde_json::Value;

use super::observers::{Observed, Observers};
use crate::failure::{Failure, plugin_failure, print_failure};
use crate::lockstep_run::{ENGINE, LockstepRun, POLL_INTERVAL, WriteError, findings};
use crate::output::write_inside;
use crate::program::Program;
use crate::trust::{self, TrustArgs};
use crate::version;

const MANAGER: &str = "fleet-manager";
const OBSERVERS: &str = "observers";
const RECORDER: &str = "record";
/// Files of the observers.
const TRAFFIC: &str = "traffic";
const QUEUES: &str = "queues";
const METER: &str = "meter";
const STATES: &str = "states";
const VALIDATOR: &str = "validator";
/// Words of the engine's error that there is no room for so many robots.
const NO_ROOM_WORDS: &str = " robots fit where ";

#[derive(Args)]
pub struct StudyRunArgs {
    /// File of the job
    job: PathBuf,
    /// File of its layout; if not given, the one that the job names in the folder `files` beside
    /// the job's folder
    #[arg(long, value_name = "FILE")]
    layout: Option<PathBuf>,
    /// File for the result; if not given, one in the folder `results` beside the job's folder
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Record the run to this file, too
    #[arg(long, value_name = "FILE.mcap")]
    record: Option<PathBuf>,
    /// Run the engine, the manager and the observers as separate processes
    #[arg(long)]
    processes: bool,
    #[command(flatten)]
    trust: TrustArgs,
}

/// Runs `regatta study-run`.
pub fn run(args: &StudyRunArgs) -> Result<ExitCode, Failure> {
    let job = Job::read(&args.job)?;
    check_version(&job)?;
    let beside = args.job.parent().and_then(Path::parent).unwrap_or(Path::new("."));
    require_trust(&job, beside, args)?;
    let layout =
        args.layout.clone().unwrap_or_else(|| beside.join("files").join(&job.scenario.graph));
    let layout = job.read_layout(&layout)?;
    let output = match &args.output {
        Some(output) => output.clone(),
        None => {
            check_folder(beside)?;
            beside.join("results").join(format!("{}.json", job.id()))
        }
    };
    let record = args.record.as_deref();
    let outcome = match &job.manager {
        Manager::BuiltIn(words) | Manager::Bound(words) if !args.processes => {
            run_in_process(&job, words, &layout, record)
        }
        _ => JobRun::start(&job, &layout, record).and_then(JobRun::finish),
    };
    let outcome = match outcome {
        Err(failure) if is_of_full_disk(&failure) => return Ok(unwritable(&*failure)),
        Err(failure) if is_of_no_room(&failure) => {
            print_failure(&*failure, false);
            return Ok(ExitCode::from(NO_ROOM));
        }
        outcome => outcome?,
    };
    let text = super::seal_key()?.sealed(&serde_json::to_string(&outcome)?);
    match write_inside(&output, text.as_bytes()) {
        Ok(()) => Ok(ExitCode::SUCCESS),
        Err(failure) => Ok(unwritable(&*failure)),
    }
}

fn check_version(job: &Job) -> Result<(), Failure> {
    let (wanted, program) = (&job.program, version::short());
    if *wanted == program {
        return Ok(());
    }
    Err(format!("the job is of Regatta {wanted}, and this is {program}: install the same version")
        .into())
}

/// Checks that the user trusts the folder of a job whose manager is a program.
fn require_trust(job: &Job, folder: &Path, args: &StudyRunArgs) -> Result<(), Failure> {
    let Manager::Command(words) = &job.manager else { return Ok(()) };
    let (name, wishes) = (args.job.display().to_string(), [words.join(" ")]);
    trust::require(&name, Some(folder), &wishes, args.trust)
}

/// Whether the robots of a run don't fit on its layout. The engine may be another process, whose
/// message is all that is known.
fn is_of_no_room(failure: &Failure) -> bool {
    failure.to_string().contains(NO_ROOM_WORDS)
}

/// Whether a full disk is the reason of a failure, also of that of another process.
fn is_of_full_disk(failure: &Failure) -> bool {
    let error = failure.downcast_ref::<WriteError>();
    error.is_some_and(|error| error.reason.kind() == ErrorKind::StorageFull)
}

fn unwritable(failure: &(dyn std::error::Error + 'static)) -> ExitCode {
    print_failure(failure, false);
    ExitCode::from(UNWRITABLE)
}

/// A run of a job.
struct JobRun<'a> {
    job: &'a Job,
    run: LockstepRun,
    termination: Termination,
}

impl<'a> JobRun<'a> {
    fn start(job: &'a Job, layout: &str, record: Option<&Path>) -> Result<Self, Failure> {
        let termination = Termination::watch().map_err(plugin_failure)?;
        let mut run = Self { job, run: LockstepRun::new("study", Program::this()?)?, termination };
        let scenario = run.write_scenario(layout)?;
        let members: Vec<_> =
            [MANAGER, OBSERVERS].into_iter().chain(record.map(|_| RECORDER)).collect();
        run.run.start_engine(
            &scenario,
            job.secs * u64::from(job.rate_hz),
            &members,
            &["--digest"],
        )?;
        // The order log has no history: a reader that joins it after the manager's first tick
        // misses the beginning of orders.
        run.start_observers()?;
        run.start_manager(&scenario)?;
        if let Some(file) = record {
            let mut recorder = run.run.command(RECORDER, &["plugin", RECORDER, "--force"])?;
            recorder.arg("--output").arg(std::path::absolute(file)?).env(AFTER_VARIABLE, MANAGER);
            run.run.start(RECORDER, &mut recorder)?;
        }
        Ok(run)
    }

    /// Whether the validator judges the run: not if robots drive through each other.
    fn is_judged(&self) -> bool {
        is_judged(self.job)
    }

    fn write_scenario(&self, layout: &str) -> Result<PathBuf, Failure> {
        write_scenario(self.job, layout, self.run.folder())
    }

    fn start_manager(&mut self, scenario: &Path) -> Result<(), Failure> {
        let mut manager = match &self.job.manager {
            Manager::BuiltIn(args) | Manager::Bound(args) => {
                let mut command = self.run.command(MANAGER, &["plugin", MANAGER])?;
                command.args(args).arg("--load").arg(scenario);
                command.args(
                    matches!(self.job.manager, Manager::Bound(_)).then_some("--no-conflicts"),
                );
                command
            }
            Manager::Command(words) => {
                let (program, args) =
                    words.split_first().ok_or("the job's manager has no program")?;
                let mut command = Command::new(program);
                command.args(args);
                self.run.joined(MANAGER, command)?
            }
        };
        manager.env(LOAD_VARIABLE, scenario);
        self.run.start(MANAGER, &mut manager)?;
        Ok(())
    }

    /// Starts the meters and the validator, which write figures at their end.
    fn start_observers(&mut self) -> Result<(), Failure> {
        let mut observers = self.run.command(OBSERVERS, &["study-observe", "--after", MANAGER])?;
        let files = [TRAFFIC, QUEUES, METER, STATES]
            .into_iter()
            .chain(self.is_judged().then_some(VALIDATOR));
        for name in files {
            observers.arg(format!("--{name}")).arg(self.run.json_file(name));
        }
        let ready = self.run.folder().join("ready");
        observers.arg("--ready").arg(&ready);
        self.run.start(OBSERVERS, &mut observers)?;
        while !ready.exists() {
            if self.run.engine_has_ended()? || self.termination.requested() {
                return Err("interrupted".into());
            }
            std::thread::sleep(POLL_INTERVAL);
        }
        Ok(())
    }

    /// Returns the figures in a file of the observers.
    fn json(&self, name: &str) -> Result<Value, Failure> {
        self.run.json(name, OBSERVERS)
    }

    /// Waits for the end of the run, and returns its outcome.
    fn finish(mut self) -> Result<Outcome, Failure> {
        while !self.run.engine_has_ended()? {
            if self.termination.requested() {
                return Err("interrupted".into());
            }
            std::thread::sleep(POLL_INTERVAL);
        }
        let failures = self.run.stop();
        if let Some(failure) = failures.first() {
            let name = failure.split_whitespace().next().unwrap_or(MANAGER);
            return Err(self.run.failure(failure, name));
        }
        let log = self.run.log(ENGINE);
        let digest = log
            .lines()
            .find(|line| line.len() == 32 && line.bytes().all(|byte| byte.is_ascii_hexdigit()))
            .ok_or("the engine gave no digest")?
            .to_owned();
        let validator = if self.is_judged() { Some(self.json(VALIDATOR)?) } else { None };
        let seen = serde_json::from_value(self.json(STATES)?)?;
        outcome(
            self.job,
            digest,
            serde_json::from_value(self.json(METER)?)?,
            Judged::new(self.job, validator, &seen)?,
            edges(
                serde_json::from_value(self.json(TRAFFIC)?)?,
                serde_json::from_value(self.json(QUEUES)?)?,
            ),
        )
    }
}

/// Whether the validator judges a run: not if robots drive through each other.
fn is_judged(job: &Job) -> bool {
    !matches!(job.manager, Manager::Bound(_))
}

/// Writes the scenario of a job and its layout into a folder.
fn write_scenario(job: &Job, layout: &str, folder: &Path) -> Result<PathBuf, Failure> {
    let path = folder.join("scenario.yaml");
    // JSON is YAML, too.
    fs::write(&path, job.scenario_text())
        .and_then(|()| fs::write(folder.join(&job.scenario.graph), layout))
        .map_err(|reason| WriteError { path: std::env::temp_dir(), reason })?;
    Ok(path)
}

/// Returns the outcome of a run, unless figures are incomplete.
fn outcome(
    job: &Job,
    digest: String,
    figures: Figures,
    judged: Judged,
    edges: Vec<EdgeOutcome>,
) -> Result<Outcome, Failure> {
    if figures.samples_missed > 0 {
        let missed = figures.samples_missed;
        return Err(format!("{missed} samples of the order log were lost; run it again").into());
    }
    let Judged { findings, examples, stalls } = judged;
    Ok(Outcome {
        job: job.id(),
        digest,
        figures,
        findings,
        examples,
        stalls,
        edges,
        ending: job.ending,
    })
}

/// The validator's findings about a run; none if it isn't judged.
#[derive(Default)]
struct Judged {
    findings: BTreeMap<String, u64>,
    examples: BTreeMap<String, Example>,
    stalls: Vec<Stall>,
}

impl Judged {
    /// `seen` are the states of the fleet in which stalls were found, and the last one.
    fn new(job: &Job, validator: Option<Value>, seen: &SeenStates) -> Result<Self, Failure> {
        let Some(validator) = validator else {
            return Ok(Self::default());
        };
        let findings = findings(&validator).collect();
        let examples = examples(&validator)?;
        Ok(Self { findings, examples, stalls: stalls(validator, seen, job.secs as f64)? })
    }
}

/// Tells an error without the path of a job's scenario, which is of a temporary file.
fn of_scenario(error: &Failure, path: &Path) -> Failure {
    error.to_string().replace(&path.display().to_string(), "the scenario of the run").into()
}

/// Does a job in this process. `words` are arguments of the manager.
fn run_in_process(
    job: &Job,
    words: &[String],
    layout: &str,
    record: Option<&Path>,
) -> Result<Outcome, Failure> {
    let termination = Termination::watch().map_err(plugin_failure)?;
    let folder =
        tempfile::tempdir().map_err(|reason| WriteError { path: std::env::temp_dir(), reason })?;
    let path = write_scenario(job, layout, folder.path())?;
    let mut manager = vec![OsString::from(MANAGER)];
    manager.extend(words.iter().map(OsString::from));
    manager.extend([OsString::from("--load"), path.clone().into()]);
    manager.extend((!is_judged(job)).then(|| "--no-conflicts".into()));
    let manager = regatta_fleet_manager::Cli::try_parse_from(manager)?;
    let manager = regatta_fleet_manager::plugin(manager)
        .map_err(|error| of_scenario(&plugin_failure(error), &path))?;
    let mut observers = Observers::new(is_judged(job));
    let scenario = Scenario::read(&path, &Overrides::default())
        .map_err(|error| of_scenario(&error.into(), &path))?;
    let mut run = Run::new(scenario)
        .digested()
        .stopped_by(|| termination.requested())
        .with_named(MANAGER, &[], manager)
        .with_named(OBSERVERS, &[MANAGER], &mut observers);
    if let Some(file) = record {
        let words = ["record".as_ref(), "--force".as_ref(), "--output".as_ref(), file.as_os_str()];
        let recorder = regatta_record::plugin(words).map_err(plugin_failure)?;
        run = run.with_named(RECORDER, &[MANAGER], recorder);
    }
    let summary = match run.for_ticks(job.secs * u64::from(job.rate_hz)) {
        Err(RunError::Stopped(_)) => return Err("interrupted".into()),
        summary => summary.map_err(|error| of_scenario(&error.into(), &path))?,
    };
    let Observed { traffic, queues, meter, findings, seen } = observers.observed();
    let validator = findings.map(serde_json::to_value).transpose()?;
    outcome(
        job,
        summary.digest.map(|digest| format!("{digest:032x}")).unwrap_or_default(),
        meter,
        Judged::new(job, validator, &seen)?,
        edges(traffic, queues),
    )
}
