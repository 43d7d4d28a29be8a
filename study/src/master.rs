//! Studies of a master of VDA 5050: the number of vehicles that it copes with on a layout.
//!
//! A master is a program of its own that works in real time. So these runs take wall time, their
//! figures contain times of the machine, and no run repeats bit by bit. That is why they are a kind
//! of study of their own, without jobs, workers and seals: a [`MasterPlan`], a [`sweep`] over the
//! numbers of vehicles, [`MasterRun`]s, each several times, and a [`MasterAnswer`].

mod answer;
mod run;
pub mod sweep;

pub use answer::{Fault, MasterAnswer, MasterPoint, Verdict};
pub use run::{Base, Breach, MasterRun, RawFigures, Stuck, Times, Transport, Wait};

use crate::plan::{Robots, RunTime, Variant};

/// A study of a master.
#[derive(Clone, Debug)]
pub struct MasterPlan {
    /// The name of the plant, for the page's title.
    pub title: String,
    /// The master, in words: its command, or where it is.
    pub master: String,
    /// The way in which it gets transport orders, in words.
    pub orders: String,
    /// Whether transport orders are handed to it, so that each vehicle can have one at any time.
    pub is_load_endless: bool,
    /// The numbers of vehicles.
    pub vehicles: Robots,
    /// The number of runs of each of them.
    pub repeats: u64,
    /// The time of a run, from the master's first order on.
    pub time: RunTime,
    /// Seconds after which a base that the master could have sent at once is late.
    pub late_secs: f64,
    /// The distance between the number that it copes with and the next one that it doesn't, as a
    /// part of it.
    pub resolution: f64,
    /// The version of the program.
    pub program: String,
    /// The layout, the vehicles and the load.
    pub variant: Variant,
}
