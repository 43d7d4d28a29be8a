//! A job: one run, as a file that says all of it. The same job gives the same result wherever it
//! runs.

use std::fmt;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use xxhash_rust::xxh3::xxh3_128;

/// The manager of a run.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Manager {
    /// Regatta's fleet manager with these arguments.
    BuiltIn(Vec<String>),
    /// A program and its arguments. It finds the fleet's name in `--fleet`, which is appended.
    Command(Vec<String>),
    /// Regatta's fleet manager with these arguments, whose robots drive through each other: the
    /// bound of what any management can reach. Nobody judges such a run.
    Bound(Vec<String>),
}

/// One run of engine, manager, traffic, validator and meter in lockstep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Job {
    /// The version of the program that runs it. Others may give other results.
    pub program: String,
    /// The scenario. Its `graph` is the name of the layout's file.
    pub scenario: Value,
    /// Simulated seconds.
    pub secs: u64,
    /// Ticks and frames per simulated second.
    pub rate_hz: u32,
    /// Who steers the robots.
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
        // Text, numbers and lists: nothing that JSON can't hold.
        format!("{:#}\n", serde_json::to_value(self).unwrap_or_default())
    }

    /// Returns the job's id.
    pub fn id(&self) -> JobId {
        JobId(content_hash(self.text().as_bytes()))
    }

    /// Returns the name of the layout's file.
    pub fn layout(&self) -> &str {
        self.scenario["graph"].as_str().unwrap_or_default()
    }
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
        let scenario =
            json!({"graph": "a.yaml", "seed": seed, "robots": [{"count": 3, "routes": "none"}]});
        let manager = Manager::BuiltIn(vec!["--in-turn".to_owned()]);
        Job { program: "0.1.0".to_owned(), scenario, secs: 600, rate_hz: 10, manager }
    }

    #[test]
    fn the_id_tells_jobs_apart_and_survives_a_file() {
        let job = job(1);
        let read: Job = serde_json::from_str(&job.text()).expect("a job");
        assert_eq!((&read, read.id()), (&job, job.id()));
        assert_ne!(job.id(), self::job(2).id());
        assert_eq!((job.id().as_str().len(), job.layout()), (32, "a.yaml"));
    }
}
