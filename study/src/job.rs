//! A job: one run, as a self-contained file. The same job gives the same result on any machine.
//!
//! A job's file may come from somebody else. [`Job::read`] takes only jobs that a study could have
//! made: named by their content, with a layout that is named by its own, and with no arguments of
//! the manager that write files or listen on a network.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use regatta_base::file;
use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_128;

use crate::plan::{Load, RunScenario};

/// Arguments of the fleet manager that a study may give it, with their values.
pub const OPTIONS: [&str; 2] = [PLANNER, "--seed"];
/// The planner.
pub const PLANNER: &str = "--planner";
/// Gives orders in turn. Without it, robots pick the nearest of an endless load, and far ones are
/// never served.
pub const IN_TURN: &str = "--in-turn";
/// The size of the largest job's file: a load may list each node of a large layout.
const MAX_JOB_BYTES: u64 = 64 << 20;
/// The size of the largest layout's file, as that of layouts of any format.
const MAX_LAYOUT_BYTES: u64 = regatta_layout::MAX_FILE_BYTES;
/// The hexadecimal digits of a hash of content, and the ending of layouts.
const HASH_DIGITS: usize = 32;
const LAYOUT_ENDING: &str = ".yaml";

/// The error of reading a job or its layout.
#[derive(Debug, thiserror::Error)]
pub enum JobError {
    /// The file can't be read.
    #[error("{}: can't be read: {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The reason.
        reason: io::Error,
    },
    /// The file is no job.
    #[error("{}: not a job: {reason}", path.display())]
    NotAJob {
        /// The file.
        path: PathBuf,
        /// The reason.
        reason: serde_json::Error,
    },
    /// The name of a file isn't the hash of its content.
    #[error(
        "{}: it was changed: its name isn't the hash of its content; run its study again to \
         rewrite it",
        path.display()
    )]
    Changed {
        /// The file.
        path: PathBuf,
    },
    /// No study makes such a job.
    #[error("{}: no study makes such a job: {reason}", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// The part that doesn't belong there.
        reason: String,
    },
}

/// The manager of a run.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Manager {
    /// Regatta's fleet manager with these arguments.
    BuiltIn(Vec<String>),
    /// A program and its arguments. It finds the fleet's name in `--fleet`, which is appended.
    Command(Vec<String>),
    /// Regatta's fleet manager with these arguments, whose robots drive through each other: the
    /// upper bound of any management. The validator doesn't judge such a run.
    Bound(Vec<String>),
}

/// The end of what a run measures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ending {
    /// The time of the run: orders come without an end.
    #[default]
    AtTime,
    /// The end of the last order: all orders are known from the beginning.
    AfterOrders,
}

impl Ending {
    fn is_at_time(&self) -> bool {
        *self == Self::AtTime
    }
}

/// One run of engine, manager, traffic, validator and meter in lockstep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Job {
    /// The version of the program that runs it. Others may give other results.
    pub program: String,
    /// The scenario. Its `graph` is the name of the layout's file.
    pub scenario: RunScenario,
    /// Simulated seconds.
    pub secs: u64,
    /// Ticks and frames per simulated second.
    pub rate_hz: u32,
    /// The end of what it measures.
    #[serde(default, skip_serializing_if = "Ending::is_at_time")]
    pub ending: Ending,
    /// The program that steers the robots.
    pub manager: Manager,
}

/// The id of a job: a hash of all of it. Layouts are named by hashes of their content.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct JobId(String);

impl JobId {
    /// Returns the id as text: 32 hexadecimal digits.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for JobId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl Job {
    /// Reads a job's file.
    ///
    /// # Errors
    /// [`JobError`] if it can't be read, or isn't a job as studies make them.
    pub fn read(path: &Path) -> Result<Self, JobError> {
        let text = file::read_text(path, MAX_JOB_BYTES)
            .map_err(|reason| JobError::Read { path: path.to_owned(), reason })?;
        let job: Self = serde_json::from_str(&text)
            .map_err(|reason| JobError::NotAJob { path: path.to_owned(), reason })?;
        let is_named = path.file_stem().is_some_and(|stem| *stem == *job.id().as_str());
        if job.text() != text || !is_named {
            return Err(JobError::Changed { path: path.to_owned() });
        }
        match job.foreign_part() {
            Some(reason) => Err(JobError::Foreign { path: path.to_owned(), reason }),
            None => Ok(job),
        }
    }

    /// Returns the part that no study gives a job.
    fn foreign_part(&self) -> Option<String> {
        let graph = &self.scenario.graph;
        if !is_layout_name(graph) {
            return Some(format!("its layout is '{}'", graph.escape_debug()));
        }
        if self.scenario.setup.load.as_ref().is_some_and(Load::names_a_file) {
            return Some("its load names a file of orders".to_owned());
        }
        let (Manager::BuiltIn(args) | Manager::Bound(args)) = &self.manager else { return None };
        let mut args = args.iter();
        while let Some(arg) = args.next() {
            let is_known = match arg.as_str() {
                IN_TURN => true,
                arg if OPTIONS.contains(&arg) => {
                    args.next().is_some_and(|value| !value.starts_with('-'))
                }
                _ => false,
            };
            if !is_known {
                return Some(format!("its manager has the argument '{}'", arg.escape_debug()));
            }
        }
        None
    }

    /// Reads the layout of the job, whose name is the hash of its content.
    ///
    /// # Errors
    /// [`JobError`] if it can't be read, or has another content.
    pub fn read_layout(&self, path: &Path) -> Result<String, JobError> {
        let text = file::read_text(path, MAX_LAYOUT_BYTES)
            .map_err(|reason| JobError::Read { path: path.to_owned(), reason })?;
        if layout_name(&text) == self.scenario.graph {
            Ok(text)
        } else {
            Err(JobError::Changed { path: path.to_owned() })
        }
    }

    /// Returns the text of the job's file. Equal jobs have equal texts: keys are sorted.
    pub fn text(&self) -> String {
        json(self) + "\n"
    }

    /// Returns the scenario as a text of JSON, which is YAML, too.
    pub fn scenario_text(&self) -> String {
        json(&self.scenario)
    }

    /// Returns the job's id.
    pub fn id(&self) -> JobId {
        JobId(content_hash(self.text().as_bytes()))
    }
}

/// Returns text, numbers and lists as JSON with sorted keys.
fn json(value: &impl Serialize) -> String {
    // There is nothing in them that JSON can't hold.
    format!("{:#}", serde_json::to_value(value).unwrap_or_default())
}

/// Returns the name of a layout's file.
pub fn layout_name(text: &str) -> String {
    format!("{}{LAYOUT_ENDING}", content_hash(text.as_bytes()))
}

fn is_layout_name(name: &str) -> bool {
    name.strip_suffix(LAYOUT_ENDING).is_some_and(|hash| {
        hash.len() == HASH_DIGITS && hash.bytes().all(|byte| byte.is_ascii_hexdigit())
    })
}

/// Returns a hash of some bytes as 32 hexadecimal digits (XXH3, 128 bits): the name of a file with
/// this content.
pub fn content_hash(bytes: &[u8]) -> String {
    format!("{:032x}", xxh3_128(bytes))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn job(seed: u64) -> Job {
        let scenario = serde_json::from_value(json!({
            "graph": "a.yaml", "rate": 10, "seed": seed, "load": {"per_hour": 100, "seed": seed},
            "robots": [{"count": 3, "routes": "none"}],
            "robot_types": [{"name": "a", "length": 1.0, "max_speed": 2}],
        }))
        .expect("a scenario");
        let manager = Manager::BuiltIn(vec!["--in-turn".to_owned()]);
        let (program, ending) = ("0.1.0".to_owned(), Ending::AtTime);
        Job { program, scenario, secs: 600, rate_hz: 10, ending, manager }
    }

    #[test]
    fn the_id_tells_jobs_apart_and_survives_a_file() {
        let job = job(1);
        let read: Job = serde_json::from_str(&job.text()).expect("a job");
        assert_eq!((&read, read.id()), (&job, job.id()));
        assert_ne!(job.id(), self::job(2).id());
        assert_eq!((job.id().as_str().len(), &*job.scenario.graph), (32, "a.yaml"));
        assert!(job.text().contains("\"max_speed\": 2,"), "numbers stay as they are");
    }

    /// Writes a job under the name of its content, and reads it.
    fn read_back(job: &Job) -> Result<Job, String> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(format!("{}.json", job.id()));
        std::fs::write(&path, job.text()).expect("written");
        Job::read(&path).map_err(|error| error.to_string())
    }

    fn with_layout(manager: Manager, graph: &str) -> Job {
        let mut job = Job { manager, ..job(1) };
        job.scenario.graph = graph.to_owned();
        job
    }

    #[test]
    fn only_jobs_that_a_study_makes_are_read() {
        let name = layout_name("Edges: []\n");
        let words = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect();
        for args in [&["--in-turn"][..], &["--planner", "pibt", "--seed", "3"], &[]] {
            let job = with_layout(Manager::BuiltIn(words(args)), &name);
            assert_eq!(read_back(&job).as_ref(), Ok(&job), "{args:?}");
        }
        for args in [&["--json", "x"][..], &["--planner"], &["--planner", "--json"], &["x"]] {
            let error = read_back(&with_layout(Manager::Bound(words(args)), &name));
            let error = error.expect_err("refused");
            assert!(error.contains("its manager has the argument '"), "{args:?}: {error}");
        }
        let mut job = with_layout(Manager::BuiltIn(Vec::new()), &name);
        let load = json!({"generators": [{"per_hour": 3}, {"orders": "/etc/passwd"}]});
        job.scenario.setup.load = Some(serde_json::from_value(load).expect("a load"));
        assert!(read_back(&job).expect_err("refused").contains("names a file of orders"));
        for graph in ["/etc/passwd", "../a.yaml", "a.yaml", ""] {
            let error = read_back(&with_layout(Manager::BuiltIn(Vec::new()), graph));
            assert!(error.expect_err(graph).contains("its layout is '"), "{graph}");
        }
    }

    #[test]
    fn what_was_changed_is_told() {
        let folder = tempfile::tempdir().expect("a folder");
        let layout = "Edges: []\n";
        let job = with_layout(Manager::BuiltIn(Vec::new()), &layout_name(layout));
        let path = folder.path().join(format!("{}.json", job.id()));
        let other = Job { secs: 601, ..job.clone() };
        for text in [other.text(), job.text() + " ", job.text().replace("600", "6_0")] {
            std::fs::write(&path, text).expect("written");
            let error = Job::read(&path).expect_err("changed").to_string();
            assert!(error.contains("it was changed") || error.contains("not a job"), "{error}");
        }
        let path = folder.path().join("layout.yaml");
        std::fs::write(&path, layout).expect("written");
        assert_eq!(job.read_layout(&path).expect("the layout"), layout);
        std::fs::write(&path, "Edges: [1]\n").expect("written");
        assert!(matches!(job.read_layout(&path), Err(JobError::Changed { .. })));
    }
}
