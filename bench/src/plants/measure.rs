//! The study of a plant, and the figures of its runs.

use std::fs::{self, File};
use std::io::{Read, Seek};
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::time::Duration;

use regatta::experiment::{check_interrupt, temporary_folder, wait};
use regatta::failure::Failure;
use regatta::program::Program;
use regatta::supervisor::Supervisor;
use regatta_layout::ReadOptions;
use regatta_layout::traffic::MainPart;
use regatta_study::job::{Job, Manager};
use regatta_study::outcome::Outcome;

use super::manifest::{Source, probe};
use super::tables::shortened;
use super::{Limit, Plan};

/// The time between two looks at a running study.
const POLL: Duration = Duration::from_millis(20);
/// The setting by which robots stand at each stop for a while, in seconds.
const DWELL: &str = r#"dwell={"min": 4, "max": 12}"#;
/// The end of a run's name in the message that it has failed.
const FAILED: &str = " failed: ";
/// Words in the message of a study of which a planner has carried nothing, or had no room.
const NO_SUCCESS: &str = "no run has succeeded";
/// The beginning of the message of a study that has failed.
const ERROR: &str = "regatta: ";
/// The longest reason in a report, in characters.
const REASON: usize = 240;

/// A run of a study that has ended.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Run {
    pub planner: String,
    pub robots: u32,
    pub seed: u64,
    /// Finished orders an hour after the warm-up.
    pub orders_per_hour: f64,
    /// The part of the robots' time in which they waited for room, from 0 to 1.
    pub waiting: f64,
    pub contacts: u64,
    /// Times in which robots with orders made no progress.
    pub stalls: usize,
    /// Orders that waited for 20 minutes.
    pub unserved: u64,
    pub other_findings: u64,
    /// Orders that the fleet manager gave up.
    pub failed_orders: u64,
    /// Orders that were open at the end.
    pub open_orders: u64,
    /// The longest time in which no order was finished, in simulated seconds.
    pub longest_gap_secs: f64,
    pub wall_secs: f64,
}

/// The study of a plant.
#[derive(Debug)]
pub struct Study {
    pub runs: Vec<Run>,
    /// Messages of runs that failed for another reason than a lack of room, and of a study that
    /// broke off.
    pub failures: Vec<String>,
}

/// A study that has ended.
struct Ended {
    status: ExitStatus,
    messages: String,
}

pub enum Answer {
    Measured(Study),
    /// The program doesn't take the layout, for this reason.
    Refused(String),
}

/// Checks the options on a shipped plant, so that an error in them isn't taken for one in a layout.
///
/// # Errors
/// If the program refuses them.
pub fn check(program: &Program, plan: &Plan, folder: &Path) -> Result<(), Failure> {
    let mut command = study(program, plan, &probe(folder), &plan.robots[..1]);
    let output = command.arg("--export-jobs").arg(folder.join("check")).output()?;
    check_interrupt()?;
    if output.status.success() {
        return Ok(());
    }
    let messages = String::from_utf8_lossy(&output.stderr).into_owned();
    Err(format!("the program refuses these options: {}", last_line(&messages)).into())
}

/// Studies a plant in a temporary folder.
///
/// # Errors
/// If the study can't be run, or its results can't be read.
pub fn measure(program: &Program, plan: &Plan, source: &Source) -> Result<Answer, Failure> {
    let folder = temporary_folder()?;
    let robots = match plan.limit {
        Limit::Room => plan.robots.clone(),
        Limit::HalfOfNodes => up_to_half(&plan.robots, &source.path),
    };
    let mut command = study(program, plan, &source.path, &robots);
    command.arg("--output").arg(folder.path());
    if let Some(jobs) = plan.jobs {
        command.arg("--jobs").arg(jobs.to_string());
    }
    let ended = run(&mut command)?;
    // A study of which a planner carries nothing fails, and its results are there.
    let runs = read(folder.path())?;
    if runs.is_empty() {
        return Ok(Answer::Refused(reason(last_line(&ended.messages), source)));
    }
    let mut failures = failures(&ended.messages);
    failures.extend(ended.failure());
    Ok(Answer::Measured(Study { runs, failures }))
}

/// Returns the numbers of robots up to half of the nodes of a plant's main part, and the first one;
/// all if it can't be read, so that the study tells the reason.
fn up_to_half(robots: &[u32], plant: &Path) -> Vec<u32> {
    let Ok((graph, _)) = regatta_layout::read(plant, &ReadOptions::default()) else {
        return robots.to_vec();
    };
    let nodes = MainPart::of(&graph).map_or(0, |main| main.graph.nodes().len());
    let rest = robots.iter().skip(1).filter(|robots| 2 * **robots as usize <= nodes);
    robots.iter().take(1).chain(rest).copied().collect()
}

/// Returns the command of a study, without its folder.
fn study(program: &Program, plan: &Plan, plant: &Path, robots: &[u32]) -> Command {
    let robots: Vec<String> = robots.iter().map(u32::to_string).collect();
    let mut command = program.command();
    command.arg("study").arg(plant).args(["--robots", &robots.join(","), "--reliefs", "0"]);
    command.args(["--seeds", &format!("{0}..{0}", plan.seeds)]);
    command.args(["--duration", &format!("{}min", plan.minutes)]);
    command.args(["--vary", &format!("planner={}", plan.planners.join(",")), "--vary", DWELL]);
    command
}

/// Runs a command. It ends if this process is asked to.
fn run(command: &mut Command) -> Result<Ended, Failure> {
    check_interrupt()?;
    let mut file: File = tempfile::tempfile()?;
    let mut supervisor = Supervisor::default();
    supervisor.start("study", command.stdout(Stdio::null()).stderr(file.try_clone()?))?;
    let status = loop {
        if let Some(child) = supervisor.take_ended().first() {
            break child.status;
        }
        wait(POLL)?;
    };
    check_interrupt()?;
    let mut messages = Vec::new();
    file.rewind()?;
    file.read_to_end(&mut messages)?;
    Ok(Ended { status, messages: String::from_utf8_lossy(&messages).into_owned() })
}

impl Ended {
    /// Returns the reason if the study broke off. A study that found contacts, or a planner that
    /// carries nothing, was completed.
    fn failure(&self) -> Option<String> {
        if self.status.code().is_none() {
            return Some(format!("the study was ended ({})", self.status));
        }
        let last = self.messages.lines().last().and_then(|line| line.strip_prefix(ERROR))?;
        let broke_off = !self.status.success() && !last.contains(NO_SUCCESS);
        broke_off.then(|| shortened(last, REASON))
    }
}

/// Reads the runs of a study, in the order of planners, robots and seeds.
fn read(folder: &Path) -> Result<Vec<Run>, Failure> {
    let mut runs = Vec::new();
    let Ok(results) = fs::read_dir(folder.join("results")) else { return Ok(runs) };
    let times = regatta_study::store::times(folder);
    for entry in results {
        let result = entry?.path();
        let job = folder.join("jobs").join(result.file_name().unwrap_or_default());
        let job: Job = serde_json::from_slice(&fs::read(job)?)?;
        let outcome: Outcome = serde_json::from_slice(&fs::read(&result)?)?;
        let wall_secs = times.get(outcome.job.as_str()).copied().unwrap_or_default();
        runs.push(Run { wall_secs, ..figures(&job, &outcome)? });
    }
    runs.sort_by(|a, b| (&a.planner, a.robots, a.seed).cmp(&(&b.planner, b.robots, b.seed)));
    Ok(runs)
}

fn figures(job: &Job, outcome: &Outcome) -> Result<Run, Failure> {
    let measured = outcome.measured();
    Ok(Run {
        planner: planner(&job.manager).ok_or("a run of the study has no planner")?.to_owned(),
        robots: job.scenario.robots.iter().map(|group| group.count).sum(),
        seed: job.scenario.seed,
        orders_per_hour: measured.orders_per_hour,
        waiting: measured.waiting,
        contacts: measured.contacts,
        stalls: measured.stalls.len(),
        unserved: measured.unserved,
        other_findings: measured.other_findings.values().sum(),
        failed_orders: measured.failed_orders,
        open_orders: outcome.figures.open,
        longest_gap_secs: longest_gap(outcome),
        wall_secs: 0.0,
    })
}

/// Returns the planner of a job. The last one counts, as for the fleet manager.
fn planner(manager: &Manager) -> Option<&str> {
    let Manager::BuiltIn(args) = manager else { return None };
    let pair = args.windows(2).rev().find(|pair| pair[0] == "--planner")?;
    Some(&pair[1])
}

/// Returns the longest time in which no order was finished, from the start of a run to its end.
fn longest_gap(outcome: &Outcome) -> f64 {
    let (mut longest, mut last) = (0.0, 0.0);
    let times = outcome.figures.finished.iter().map(|order| order.at_secs);
    for at_secs in times.chain([outcome.figures.secs]) {
        longest = f64::max(longest, at_secs - last);
        last = at_secs;
    }
    longest
}

/// Returns the messages of runs that failed; those of plants that hold fewer robots say otherwise.
fn failures(messages: &str) -> Vec<String> {
    let lines = messages.lines().filter(|line| line.contains(FAILED));
    lines.map(|line| shortened(line, REASON)).collect()
}

fn last_line(messages: &str) -> &str {
    messages.lines().last().unwrap_or("no message").trim_start_matches(ERROR)
}

/// Returns the reason of a refusal without the path of the plant, since the report names it.
fn reason(message: &str, source: &Source) -> String {
    let path = source.path.display().to_string();
    let reason = message.strip_prefix(&path).map_or(message, |rest| rest.trim_start_matches(": "));
    // A line number comes directly after the path.
    let reason = reason.strip_prefix(':').map_or(reason.to_owned(), |rest| format!("line {rest}"));
    shortened(&reason.replace(&path, &source.name), REASON)
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::super::manifest::Kind;
    use super::*;

    fn job(args: &[&str]) -> Value {
        json!({
            "program": "0.1.0", "secs": 600, "rate_hz": 10, "manager": {"built-in": args},
            "scenario": {
                "graph": "a.yaml", "rate": 10, "seed": 3,
                "robots": [{"count": 3, "routes": "none"}, {"count": 1, "routes": "none"}],
            },
        })
    }

    fn result(finished: &[f64]) -> Value {
        let finished: Vec<Value> = finished
            .iter()
            .map(|at_secs| json!({"at_secs": at_secs, "service_secs": 5.0, "stops": 2}))
            .collect();
        json!({
            "job": "0a", "digest": "d", "edges": [],
            "findings": {"contact": 2, "idle": 1},
            "stalls": [],
            "figures": {
                "secs": 600.0, "robots": 4, "period_secs": 10.0, "effort": [],
                "finished": finished, "open": 4, "failed": 1, "cancelled": 0, "samples_missed": 0,
            },
        })
    }

    fn write(folder: &Path, kind: &str, value: &Value) {
        fs::create_dir_all(folder.join(kind)).expect("a folder");
        fs::write(folder.join(kind).join("0a.json"), value.to_string()).expect("it is written");
    }

    #[test]
    fn a_result_is_read_with_its_job() {
        let folder = tempfile::tempdir().expect("a folder");
        assert_eq!(read(folder.path()).expect("no results"), []);
        write(folder.path(), "jobs", &job(&["--planner", "pibt", "--in-turn"]));
        let every_ten: Vec<f64> = (1..=60).map(|index| f64::from(index) * 10.0).collect();
        write(folder.path(), "results", &result(&every_ten));
        fs::write(folder.path().join("times.csv"), "job,wall_secs\n0a,0.5\n").expect("written");
        let expected = Run {
            planner: "pibt".to_owned(),
            robots: 4,
            seed: 3,
            orders_per_hour: 360.0,
            contacts: 2,
            other_findings: 1,
            failed_orders: 1,
            open_orders: 4,
            longest_gap_secs: 10.0,
            wall_secs: 0.5,
            ..Run::default()
        };
        assert_eq!(read(folder.path()).expect("a result"), [expected]);
    }

    #[test]
    fn the_end_of_a_run_ends_the_longest_time_without_an_order() {
        let outcome = serde_json::from_value(result(&[30.0, 50.0, 200.0])).expect("an outcome");
        assert_eq!(longest_gap(&outcome), 400.0);
    }

    #[test]
    fn a_reason_names_the_line_and_not_the_path() {
        let (name, kind) = ("b/a.yaml".to_owned(), Kind::File);
        let source = Source { name, path: "/tmp/b/a.yaml".into(), kind };
        let cases = [
            ("/tmp/b/a.yaml: no edges", "no edges"),
            ("/tmp/b/a.yaml:7: no edges", "line 7: no edges"),
            ("can't read /tmp/b/a.yaml", "can't read b/a.yaml"),
        ];
        for (message, expected) in cases {
            assert_eq!(reason(message, &source), expected);
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_study_that_broke_off_has_failed() {
        use std::os::unix::process::ExitStatusExt;
        let killed = Some("the study was ended (signal: 9 (SIGKILL))");
        for (status, message, expected) in [
            (0, "round 1: 0 of 10 runs done\n", None),
            (1 << 8, "regatta: lanes: no run has succeeded: nothing\n", None),
            (1 << 8, "round 1: 0 of 10 runs done\n", None),
            (1 << 8, "regatta: the disk is full\n", Some("the disk is full")),
            (9, "", killed),
        ] {
            let ended = Ended { status: ExitStatus::from_raw(status), messages: message.into() };
            assert_eq!(ended.failure().as_deref(), expected);
        }
    }

    #[test]
    fn a_lack_of_room_is_no_failure() {
        let messages = "round 1: 0 of 10 runs done\n\
                        16 robots, seed 1: not all found a place: 8 of 16 robots fit where they wait\n\
                        8 robots, seed 2 failed: the manager has ended\n\
                        regatta: a.yaml: no\n";
        assert_eq!(failures(messages), ["8 robots, seed 2 failed: the manager has ended"]);
        assert_eq!(last_line(messages), "a.yaml: no");
    }
}
