//! One measurement: an engine, the fleet manager and the validator in lockstep.

use std::fmt;
use std::path::{Path, PathBuf};

use regatta::experiment::{check_interrupt, temporary_folder, write};
use regatta::failure::Failure;
use regatta::program::Program;
use regatta_layout::generate::Warehouse;
use serde_json::{Value, json};

use super::processes::Run;

/// The warehouse of the largest fleet: 122,158 edges.
const LARGE_WAREHOUSE: Warehouse = Warehouse { aisles: 144, rows: 64, bays: 4 };
/// The stalls of a robot that stalls at random: how many an hour, and their mean duration.
pub const STALLS_PER_HOUR: u32 = 60;
pub const STALL_SECS: u32 = 10;
/// The acceleration limit of robots that have one.
pub const MAX_ACCELERATION: f32 = 0.8;
/// Finished stops before this time don't count.
const WARM_UP_SECS: u64 = 300;

/// The layout on which robots drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// On the layout of the report.
    Layout,
    /// In the [`LARGE_WAREHOUSE`].
    Large,
}

/// The setup of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Setup {
    pub place: Place,
    pub robots: u32,
    /// Whether robots have acceleration limits.
    pub limited: bool,
    /// Per cent of the robots that stall at random.
    pub stalling_percent: u32,
    /// The number of robots that break down at the end of the warm-up.
    pub broken: u32,
    /// Whether robots keep apart. If not, throughput is the bound, and no validator runs.
    pub conflicts: bool,
    pub seed: u64,
    /// Simulated time.
    pub secs: u64,
}

impl Setup {
    /// An undisturbed fleet.
    pub fn of(robots: u32) -> Self {
        Self {
            place: Place::Layout,
            robots,
            limited: false,
            stalling_percent: 0,
            broken: 0,
            conflicts: true,
            seed: 1,
            secs: 3600,
        }
    }

    /// The simulated seconds after which finished stops count: whole periods of ten seconds.
    pub fn warm_up_secs(&self) -> u64 {
        WARM_UP_SECS.min(self.secs / 4) / 10 * 10
    }

    pub fn json(&self) -> Value {
        json!({
            "layout": if self.place == Place::Large { "large" } else { "layout" },
            "robots": self.robots, "acceleration_limits": self.limited,
            "stalling_percent": self.stalling_percent,
            "broken": self.broken, "conflicts": self.conflicts, "seed": self.seed,
            "secs": self.secs,
            "warm_up_secs": self.warm_up_secs(),
        })
    }
}

impl fmt::Display for Setup {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} robots", self.robots)?;
        let parts = [
            (self.limited, format!(", {MAX_ACCELERATION} m/s²")),
            (self.stalling_percent > 0, format!(", {} % stall", self.stalling_percent)),
            (self.broken > 0, format!(", {} broken", self.broken)),
            (!self.conflicts, ", bound".to_owned()),
        ];
        parts.iter().filter(|(applies, _)| *applies).try_for_each(|(_, text)| f.write_str(text))?;
        write!(f, ", seed {}", self.seed)
    }
}

/// The figures of a run.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Finished stops a simulated second, after the warm-up.
    pub goals_per_sec: f64,
    /// The longest time that a robot has gone without finishing an order, in simulated seconds.
    pub longest_without_finish_secs: f64,
    /// The time that the manager took to work the roads out, in milliseconds.
    pub start_ms: f64,
    pub mean_cycle_ms: f64,
    pub longest_cycle_ms: f64,
    /// The part of a core that the manager's process takes at 10 Hz: processor time per simulated
    /// second, the start included. `None` where the system doesn't tell.
    pub manager_cores: Option<f64>,
    /// Simulated seconds per wall second, from the first tick on.
    pub real_time_factor: f64,
    pub contacts: u64,
    /// Other findings of the validator, by kind.
    pub other_findings: Vec<(String, u64)>,
}

impl Measured {
    pub fn json(&self, setup: &Setup) -> Value {
        let findings: serde_json::Map<_, _> = self
            .other_findings
            .iter()
            .map(|(kind, count)| (kind.clone(), (*count).into()))
            .collect();
        json!({
            "setup": setup.json(), "goals_per_sec": self.goals_per_sec,
            "longest_without_finish_secs": self.longest_without_finish_secs,
            "start_ms": self.start_ms,
            "mean_cycle_ms": self.mean_cycle_ms, "longest_cycle_ms": self.longest_cycle_ms,
            "manager_cores": self.manager_cores, "real_time_factor": self.real_time_factor,
            "contacts": self.contacts,
            "other_findings": findings,
        })
    }
}

/// The files of all measurements, in a temporary folder.
pub struct Site {
    folder: tempfile::TempDir,
    layout: PathBuf,
    rate_hz: u32,
}

impl Site {
    pub fn new(layout: Option<&Path>, rate_hz: u32) -> Result<Self, Failure> {
        let folder = temporary_folder()?;
        let built_in = folder.path().join("warehouse.yaml");
        write(&built_in, include_str!("../../../graphs/warehouse.yaml"))?;
        let layout = layout.map(std::path::absolute).transpose()?.unwrap_or(built_in);
        Ok(Self { folder, layout, rate_hz })
    }

    /// The layout and the rate, for the report.
    pub fn description(&self) -> String {
        let name = self.layout.file_name().unwrap_or_default().to_string_lossy();
        format!("`{name}`, {} ticks and frames a second", self.rate_hz)
    }

    fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Measures; the inner error says why the run failed.
    pub fn measure(
        &self,
        program: &Program,
        setup: &Setup,
    ) -> Result<Result<Measured, String>, Failure> {
        check_interrupt()?;
        let scenario = self.file("scenario.yaml");
        write(&scenario, &self.scenario(setup)?)?;
        let outcome = Run::start(program, setup, &scenario, self.rate_hz).and_then(Run::finish);
        // Whatever went wrong: if Ctrl-C has ended the processes, that is why.
        check_interrupt()?;
        Ok(outcome.map_err(|failure| failure.to_string()))
    }

    fn scenario(&self, setup: &Setup) -> Result<String, Failure> {
        let graph = match setup.place {
            Place::Layout => self.layout.clone(),
            Place::Large => self.file("large.yaml"),
        };
        if setup.place == Place::Large && !graph.exists() {
            write(&graph, &LARGE_WAREHOUSE.generate()?)?;
        }
        let (seed, robots, rate) = (setup.seed, setup.robots, self.rate_hz);
        let limit = if setup.limited {
            format!(", max_acceleration: {MAX_ACCELERATION}")
        } else {
            String::new()
        };
        let share = f64::from(setup.stalling_percent) / 100.0;
        let stalls = format!(
            "disturbances: {{stalls: {{per_hour: {STALLS_PER_HOUR}, mean_secs: {STALL_SECS}, \
             share: {share}}}}}\n"
        );
        // A path in quotation marks, as JSON has it, is YAML too.
        Ok(format!(
            "graph: {}\nrate: {rate}\nseed: {seed}\n\
             robot_types: [{{name: amr, length: 0.9, width: 0.6{limit}}}]\n\
             robots: [{{count: {robots}, routes: none}}]\n{}\
             load: {{seed: {seed}, endless: robots}}\n",
            json!(graph.to_string_lossy()),
            if setup.stalling_percent > 0 { &stalls } else { "" },
        ))
    }
}
