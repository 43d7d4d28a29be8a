//! `regatta study`: finds the number of robots that a plant holds, by many runs, on this machine or
//! a cluster, and writes a page with the answer.

mod export;
mod master;
pub mod observers;
mod output;
mod pdf;
mod request;
mod single_run;
mod watch;

use std::path::PathBuf;
use std::process::{Command, ExitCode};

use clap::Args;
use regatta_plugin::Termination;
use regatta_study::answer::{Answer, VariantAnswer};
use regatta_study::conduct::{Conductor, StudyError, Watcher};
use regatta_study::plan::{Axis, Plan, Robots, Target};
use regatta_study::seal::Key;
use regatta_study::store::{Accepted, Store};
use regatta_study::workers::{Adapter, Local, Workers, WorkersError};

pub use self::observers::{ObserverArgs, run as run_observers};
use self::pdf::Browser;
pub use self::single_run::{StudyRunArgs, run as run_single};
use self::watch::Terminal;
use crate::arguments::{LayoutArgs, Time};
use crate::day::DayArgs;
use crate::failure::{Failure, plugin_failure};
use crate::trust::TrustArgs;
use crate::{user_files, version};

/// Groups of options in the help.
const QUESTION: &str = "Question";
const PRECISION: &str = "Precision";
const RUNS: &str = "Runs";
const OUTPUT: &str = "Results";

/// Exit code of a study that found contacts, whose runs failed in part, or that has no answer for
/// its first variant.
const FOUND: u8 = 1;

#[derive(Args)]
pub struct StudyArgs {
    /// Layout of any format, scenario, or study file (YAML with the key `plant`)
    #[arg(value_name = "PLANT", value_hint = clap::ValueHint::FilePath)]
    plant: PathBuf,
    /// Numbers of robots: a range, doubled and then refined around the answer, or a list [default:
    /// 1..1000; with targets, up to the largest number that can drive on the layout]
    #[arg(long, value_name = "FROM..TO", help_heading = QUESTION)]
    robots: Option<Robots>,
    /// Find the least number of robots with 'p99 service < 6min', 'late < 1%', '400 orders/h' …;
    /// may be repeated: then all must be met
    #[arg(long, value_name = "TARGET", help_heading = QUESTION)]
    target: Vec<Target>,
    /// Simulated time of a run [default: 30min; for a day, until an hour after its last order]
    #[arg(long, value_name = "TIME", help_heading = QUESTION)]
    duration: Option<Time>,
    /// Smallest and largest number of seeds for a point [default: 3..10]
    #[arg(long, value_name = "LEAST..MOST", value_parser = parse_seeds, help_heading = PRECISION)]
    seeds: Option<(u64, u64)>,
    /// Setting and the values to compare, such as max_speed=1,1.5 or layout=a.yaml,b.yaml; may be
    /// repeated
    #[arg(long, value_name = "NAME=VALUES", help_heading = QUESTION)]
    vary: Vec<Axis>,
    /// Command line of your own manager, which also gets --fleet; it is compared with Regatta's and
    /// the bound. With --vda5050, that of a master, with the placeholders {broker}, {host}, {port},
    /// {user} and {vehicles}
    #[arg(long, value_name = "COMMAND", help_heading = QUESTION)]
    manager: Option<String>,
    /// Also simulate the bound: the same robots, driving through each other
    #[arg(long, help_heading = QUESTION)]
    bound: bool,
    /// Number of changes to the plant to try, in a race [default: 6; with targets, 0]
    #[arg(long, value_name = "N", help_heading = QUESTION)]
    reliefs: Option<usize>,
    /// Ticks and frames per simulated second
    #[arg(
        long,
        value_name = "HZ",
        default_value_t = 10,
        value_parser = clap::value_parser!(u32).range(10..=1000),
        help_heading = PRECISION
    )]
    rate: u32,
    /// Folder of the study; an interrupted study continues there [default: study-NAME]
    #[arg(short, long, value_name = "FOLDER", help_heading = OUTPUT)]
    output: Option<PathBuf>,
    /// Runs side by side on this machine [default: the number of cores]
    #[arg(short, long, value_name = "N", conflicts_with = "on", help_heading = RUNS)]
    jobs: Option<std::num::NonZeroUsize>,
    /// Run the engine, manager and observers of each run as separate processes, not in one
    #[arg(long, conflicts_with_all = ["on", "export_jobs"], help_heading = RUNS)]
    processes: bool,
    /// Cluster that executes the runs: tcp://HOST:PORT of a Dask scheduler, or ray://HOST:PORT
    #[arg(long, value_name = "ADDRESS", value_parser = parse_address, help_heading = RUNS)]
    on: Option<String>,
    /// Only write the first runs as a job array to this folder, for Slurm or a shell
    #[arg(
        long,
        value_name = "FOLDER",
        conflicts_with_all = ["on", "jobs", "output"],
        help_heading = RUNS
    )]
    export_jobs: Option<PathBuf>,
    /// Record one run of the first variant with the number of robots of the answer
    #[arg(long, help_heading = OUTPUT)]
    record: bool,
    /// Also print the page to study.pdf with Chromium, Chrome or Edge, or with the program that the
    /// environment variable REGATTA_BROWSER names
    #[arg(long, conflicts_with = "export_jobs", help_heading = OUTPUT)]
    pdf: bool,
    /// Use results in the folder that other users or machines made
    #[arg(long, help_heading = OUTPUT)]
    foreign_results: bool,
    #[command(flatten)]
    master: master::MasterArgs,
    #[command(flatten)]
    trust: TrustArgs,
    #[command(flatten)]
    day: DayArgs,
    #[command(flatten)]
    layout: LayoutArgs,
}

impl StudyArgs {
    /// The browser that prints the page, if it is wanted. One that is missing is told before the
    /// runs, not after them.
    fn browser(&self) -> Result<Option<Browser>, Failure> {
        if self.pdf { Browser::find().map(Some) } else { Ok(None) }
    }
}

fn parse_seeds(text: &str) -> Result<(u64, u64), String> {
    let (least, most) = text.split_once("..").unwrap_or((text, text));
    match (least.trim().parse(), most.trim().parse()) {
        (Ok(least), Ok(most)) if 2 <= least && least <= most && most <= 1000 => Ok((least, most)),
        _ => Err(format!("invalid seeds '{text}': give a range such as 3..10, from at least 2")),
    }
}

fn parse_address(text: &str) -> Result<String, String> {
    let is_known = ["tcp://", "tls://", "ray://"].iter().any(|scheme| text.starts_with(scheme));
    if is_known {
        Ok(text.to_owned())
    } else {
        Err("give tcp://HOST:PORT of a Dask scheduler, or ray://HOST:PORT".to_owned())
    }
}

/// Runs `regatta study`.
///
/// # Errors
/// Returns an error if the plant can't be studied, or if no run can be done. Finished runs are
/// kept.
pub fn run(args: &StudyArgs) -> Result<ExitCode, Failure> {
    if let Some(broker) = args.master.broker() {
        return master::run(args, broker);
    }
    let browser = args.browser()?;
    let plan = request::plan(args)?;
    let termination = Termination::watch().map_err(plugin_failure)?;
    if let Some(folder) = &args.export_jobs {
        let store = Store::open(folder, seal_key()?, Accepted::Sealed)?;
        return export::export(&plan, &store).map(|()| ExitCode::SUCCESS);
    }
    let folder =
        args.output.clone().unwrap_or_else(|| PathBuf::from(format!("study-{}", plan.title)));
    let accepted = if args.foreign_results { Accepted::Any } else { Accepted::Sealed };
    let store = Store::open(&folder, seal_key()?, accepted)?;
    let watcher = Terminal::new(termination);
    let mut workers = workers(args, &watcher)?;
    let answer = conduct(&plan, &store, &mut *workers, &watcher)?;
    drop(watcher);
    output::write(&answer, &plan.variants[0], &folder, browser.as_ref())?;
    if args.record {
        output::record(&plan, &store, &answer)?;
    }
    if let Some((name, reason)) =
        answer.variants.iter().find_map(|variant| Some((&variant.name, variant.failure()?)))
    {
        return Err(format!("{name}: no run has succeeded: {reason}").into());
    }
    let is_known = answer.variants.first().is_some_and(VariantAnswer::is_known);
    let contacts: u64 = answer.variants.iter().map(|variant| variant.contacts).sum();
    let is_whole = is_known && contacts == 0 && !answer.has_failures();
    Ok(if is_whole { ExitCode::SUCCESS } else { ExitCode::from(FOUND) })
}

/// Returns the key of this user's results. A user without a home folder, or with one that can't be
/// used, gets a key for this process: then no later study knows its results.
fn seal_key() -> Result<Key, Failure> {
    let Some(path) = user_files::path("study.key") else { return Ok(Key::random()?) };
    match Key::of_file(&path) {
        Ok(key) => Ok(key),
        Err(error) => {
            let path = path.display();
            regatta_plugin::tell!("study: {path}: {error}: a later study will do all runs again");
            Ok(Key::random()?)
        }
    }
}

fn conduct(
    plan: &Plan,
    store: &Store,
    workers: &mut dyn Workers,
    watcher: &Terminal,
) -> Result<Answer, Failure> {
    match Conductor::new(plan, store, workers, watcher).conduct() {
        Ok(answer) => Ok(answer),
        Err(StudyError::Workers(WorkersError::Interrupted)) => {
            let finished = watcher.finished();
            Err(format!(
                "interrupted after {finished} runs; they are kept; repeat the command to continue"
            )
            .into())
        }
        Err(error) => Err(error.into()),
    }
}

fn workers(args: &StudyArgs, watcher: &Terminal) -> Result<Box<dyn Workers>, Failure> {
    let Some(address) = &args.on else {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let size = args.jobs.map_or(cores, std::num::NonZeroUsize::get);
        let options = args.processes.then(|| "--processes".to_owned()).into_iter().collect();
        return Ok(Box::new(Local::new(std::env::current_exe()?, options, size)));
    };
    let python = std::env::var_os("REGATTA_PYTHON").unwrap_or_else(|| "python3".into());
    let mut command = Command::new(python);
    command.args(["-m", "regatta.cluster", address]).env("REGATTA_STUDY_VERSION", version::short());
    let adapter = Adapter::start(command, &|| watcher.is_interrupted())?;
    Ok(Box::new(adapter))
}
