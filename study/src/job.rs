//! A job: one run, as a self-contained file. The same job gives the same result on any machine.

use std::fmt;

use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_128;

use crate::plan::RunScenario;

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
        Job { program: "0.1.0".to_owned(), scenario, secs: 600, rate_hz: 10, manager }
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
}
