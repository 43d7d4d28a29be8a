//! The activities of a fleet's robots, while a fleet manager publishes them.

use std::time::{Duration, Instant};

use regatta_plugin::activity::Activity;
use regatta_plugin::column::ACTIVITY;
use regatta_plugin::{ColumnReader, FleetName, Participant};
use serde_json::Value;

use crate::failure::Failure;

/// The time within which a manager gives a reader that joins its newest activities.
const JOIN_TIMEOUT: Duration = Duration::from_millis(500);
/// The interval at which they are polled.
const POLL: Duration = Duration::from_millis(5);

/// A reader of the activities of a fleet's robots.
pub struct Activities {
    column: ColumnReader,
}

/// The number of robots of each activity, in the order of [`Activity::ALL`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RobotCounts([u32; Activity::COUNT]);

impl Activities {
    /// Joins a fleet for a status.
    ///
    /// # Errors
    /// As [`join_as`](Self::join_as).
    pub fn join(fleet: &FleetName) -> Result<Self, Failure> {
        Self::join_as(fleet, &format!("status-{}", std::process::id()))
    }

    /// Joins a fleet under the name that its lists of processes show.
    ///
    /// # Errors
    /// If shared memory can't be used, or the fleet uses another version of the contract.
    pub fn join_as(fleet: &FleetName, name: &str) -> Result<Self, Failure> {
        let participant = Participant::join(fleet, name)?;
        Ok(Self { column: ColumnReader::open_on(&participant, ACTIVITY.name())? })
    }

    /// Returns the numbers of robots in a run; `None` if no process publishes activities.
    ///
    /// # Errors
    /// If the column can't be read.
    pub fn of_run(&mut self, run_id: u64) -> Result<Option<RobotCounts>, Failure> {
        let values = self.column.newest_of_run(run_id)?;
        Ok((!values.is_empty()).then(|| RobotCounts::of(values)))
    }

    /// Returns the numbers of robots in a run. Waits for them for a short time if a process
    /// publishes activities.
    ///
    /// # Errors
    /// As [`of_run`](Self::of_run).
    pub fn wait_for_run(&mut self, run_id: u64) -> Result<Option<RobotCounts>, Failure> {
        let start = Instant::now();
        loop {
            let robots = self.of_run(run_id)?;
            let is_over = !self.column.has_publisher() || start.elapsed() >= JOIN_TIMEOUT;
            if robots.is_some() || is_over {
                return Ok(robots);
            }
            std::thread::sleep(POLL);
        }
    }
}

impl RobotCounts {
    /// Counts the values of the column `activity`.
    fn of(values: &[f32]) -> Self {
        let mut robots = Self::default();
        for activity in values.iter().filter_map(|value| Activity::from_value(*value)) {
            robots.0[activity as usize] += 1;
        }
        robots
    }

    /// Returns the number of robots of every activity by its name.
    pub fn to_json(self) -> Value {
        let counts = Activity::ALL.into_iter().zip(self.0);
        counts.map(|(activity, robots)| (activity.name().to_owned(), Value::from(robots))).collect()
    }

    /// Formats the activities of any robots: `idle 3, carrying 12`.
    pub fn in_words(&self) -> String {
        let counts = Activity::ALL.into_iter().zip(self.0).filter(|(_, robots)| *robots > 0);
        let words: Vec<_> =
            counts.map(|(activity, robots)| format!("{} {robots}", activity.name())).collect();
        words.join(", ")
    }
}
