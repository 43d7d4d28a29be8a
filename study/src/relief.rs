//! Reliefs: changes of a plant that may help, and their effect.
//!
//! [`candidates`] come from where the time of robots goes at the answer. Each becomes a variant
//! ([`apply`]), and a [`race`] of paired runs tells those that help. A candidate names the robots
//! whose time it is about, on average: robot hours an hour.

mod aisle;
mod apply;
mod candidates;
mod load;
mod measure;
pub mod race;
mod roads;
mod slow;
mod stops;
mod track;

use serde::Serialize;

use crate::statistics::Interval;

pub use candidates::{Site, candidates};
pub use measure::Measure;

/// The factor of the speed on edges whose speed is raised.
pub const FASTER: f64 = 1.5;
/// The factor of the speed of robots that are faster.
pub const FASTER_ROBOTS: f64 = 1.25;
/// The factor of the time to repair.
pub const FASTER_REPAIR: f64 = 0.5;
/// The number of places of a new queue.
pub const QUEUE_PLACES: usize = 2;

/// A change that may help. Nodes and edges are ids of the layout.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Remedy {
    /// One more operator at the station of these nodes.
    Operator(Vec<u32>),
    /// Loads are taken out of the buffer of the station at this node half as fast again.
    Buffer(u32),
    /// A second place beside the one at this node.
    Place(u32),
    /// Two places of a queue before this node, off the road.
    Queue(u32),
    /// A second charger beside the one at this node.
    Charger(u32),
    /// A track for each direction between the ends of a two-way track, through these nodes.
    SecondTrack(Vec<u32>),
    /// A place to pass on a two-way track, in the middle of this edge and of its opposite.
    PassingPlace([u32; 2]),
    /// The direction of these edges, which are an aisle, is turned round.
    Reversed(Vec<u32>),
    /// Robots may drive on these edges as fast as on others, in metres per second.
    UsualSpeed {
        /// The edges.
        edges: Vec<u32>,
        /// The speed.
        speed: f64,
    },
    /// The speed limits of these edges are raised by half.
    Faster(Vec<u32>),
    /// A second edge beside this one.
    Second(u32),
    /// All robots drive a quarter faster where edges let them.
    FasterRobots,
    /// Broken robots are repaired in half the time.
    Repair,
}

/// A change that may help, and the time that it is about.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Candidate {
    /// The change.
    pub remedy: Remedy,
    /// The change in words.
    pub words: String,
    /// The part of the time that it is about.
    pub about: &'static str,
    /// The mean number of robots that this part takes.
    pub robots: f64,
}

/// A candidate that was tried.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Relief {
    /// The candidate.
    #[serde(flatten)]
    pub candidate: Candidate,
    /// The change of the figure, seed by seed, above 0 if it is better. The intervals of all
    /// reliefs hold together with 95 % confidence. `None` without a run.
    pub gain: Option<Interval>,
    /// The finding.
    pub verdict: Verdict,
    /// Whether it left the race before its end: another one is better, or it brings too little.
    pub has_left: bool,
    /// The failure of a run with it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
}

/// The finding about a relief, in the order in which reliefs are listed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The interval lies above 0.
    Helps,
    /// The interval contains 0.
    WithinChance,
    /// The interval lies below 0.
    Harms,
    /// Robots made no progress in a run with it, or a day had no end.
    Stalls,
    /// A run failed, or has no figure.
    NotKnown,
}

/// The reliefs of a number of robots.
#[derive(Clone, Debug, Serialize)]
pub struct Reliefs {
    /// The number of robots.
    pub robots: u32,
    /// The figure that they are compared by.
    pub figure: String,
    /// Its value without a relief, the mean over all seeds of the race.
    pub base: f64,
    /// Those that were tried, the best first.
    pub tried: Vec<Relief>,
    /// Other candidates that weren't tried, by falling number of robots.
    pub others: Vec<Candidate>,
    /// The figure.
    #[serde(skip)]
    pub measure: Measure,
}

impl Reliefs {
    /// Whether a run with a relief failed.
    pub fn has_failures(&self) -> bool {
        self.tried.iter().any(|relief| relief.failure.is_some())
    }

    /// The best relief, if one helps.
    pub fn best(&self) -> Option<&Relief> {
        self.tried.first().filter(|relief| relief.verdict == Verdict::Helps)
    }
}

#[cfg(test)]
mod tests;
