//! The fleet's truth as private columns, and what changes it: orders and time.

mod ahead;
mod columns;
mod crew;
mod events;
mod orders;
mod routes;
mod spawn;

#[cfg(test)]
mod drive_tests;
#[cfg(test)]
mod equality_tests;
#[cfg(test)]
mod limit_tests;
#[cfg(test)]
mod order_tests;
#[cfg(test)]
pub(crate) mod testing;

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use regatta_plugin::frame::{BYTES_PER_LINE, ColumnsMut, RobotState, WORDS_PER_LINE, stride_lines};
use regatta_plugin::world::Shape;

pub use self::ahead::Ahead;
use self::columns::FleetColumns;
use self::crew::Crew;
pub use self::events::Events;
pub(crate) use self::routes::{Ending, Plans, Route};
pub use self::routes::{Repeat, RouteSource};
pub use self::spawn::Placement;
use crate::graph::RouteGraph;
use crate::graph::arc_length::Tracks;
use crate::motion::{Isa, Motion, Pace, Roads};

/// What robots have in common.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotType {
    /// Name, for people.
    pub name: String,
    /// Footprint.
    pub shape: Shape,
    /// Metres along the heading; of a circle, its diameter.
    pub length: f32,
    /// Metres across it.
    pub width: f32,
    /// Metres per second, > 0; infinity for no limit but the edges'.
    pub max_speed: f32,
    /// Metres per second squared, > 0; infinity if speed changes at once.
    pub max_acceleration: f32,
}

/// A fleet can't be set up like that.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FleetError {
    /// A robot could drive more than [`Fleet::LONGEST_STEP`] in a tick.
    #[error(
        "a robot would drive {metres:.1} m in one tick of {tick:?}, more than {} m; use a higher rate",
        Fleet::LONGEST_STEP
    )]
    StepTooLong {
        /// How far.
        metres: f64,
        /// The tick period.
        tick: Duration,
    },
    /// A robot type has a limit that is not a positive number.
    #[error("robot type {name:?}: max speed and max acceleration must be more than 0; leave them out for no limit")]
    BadLimit {
        /// The type.
        name: String,
    },
    /// More types than fit the column.
    #[error("{0} robot types are more than 65535; merge some")]
    TooManyTypes(usize),
    /// This machine can't run that kernel.
    #[error("this machine can't run {0} instructions; use {best}", best = Isa::detect())]
    Unsupported(Isa),
    /// The threads could not be started.
    #[error("can't start {0} threads; use fewer")]
    Threads(usize),
}

/// How a fleet is set up.
#[derive(Clone, Debug)]
pub struct FleetConfig {
    /// What kinds of robots there are; at most 65,535.
    pub types: Vec<RobotType>,
    /// Simulated time a tick.
    pub tick_period: Duration,
    /// Of the random walks.
    pub seed: u64,
    /// Instruction set. All give the same bits.
    pub isa: Isa,
    /// Threads that share a step; ≥ 1. Any number gives the same bits.
    pub threads: usize,
    /// Rows there may be: [`Refusal::FleetFull`](regatta_plugin::event::Refusal::FleetFull) beyond.
    pub most_robots: u32,
}

/// All robots of a route graph.
///
/// A robot's id is its row. Rows of removed robots are [`RobotState::Absent`] until a spawn takes them again; a
/// frame has [`Fleet::robots`] rows.
#[derive(Debug)]
pub struct Fleet {
    motion: Motion,
    columns: FleetColumns,
    /// Rows in use.
    robots: u32,
    /// Rows among them that hold no robot.
    free: BTreeSet<u32>,
    most_robots: u32,
    crew: Option<Crew>,
}

impl Fleet {
    /// Metres that a robot may drive in one tick.
    pub const LONGEST_STEP: f64 = 8.0;

    /// An empty fleet.
    ///
    /// # Errors
    /// See [`FleetError`].
    pub fn new(graph: Arc<RouteGraph>, tracks: Arc<Tracks>, config: FleetConfig) -> Result<Self, FleetError> {
        check(&graph, &config)?;
        let limited = config.types.iter().any(|kind| kind.max_acceleration.is_finite());
        let crew = if config.threads > 1 { Some(Crew::new(config.threads)?) } else { None };
        let motion = Motion {
            roads: Roads::new(graph, tracks),
            plans: Plans::new(config.seed),
            types: config.types,
            pace: Pace::new(config.tick_period.as_secs_f64()),
            isa: config.isa,
        };
        Ok(Self {
            motion,
            columns: FleetColumns::new(limited),
            robots: 0,
            free: BTreeSet::new(),
            most_robots: config.most_robots,
            crew,
        })
    }

    /// Takes memory for that many robots at once. Spawning takes it bit by bit otherwise, and more of it.
    pub fn reserve(&mut self, robots: usize) {
        self.columns.reserve(robots.min(self.most_robots as usize));
    }

    /// Robot types, by index.
    pub fn types(&self) -> &[RobotType] {
        &self.motion.types
    }

    /// Type index of every row in use; means nothing for absent robots.
    pub fn kinds(&self) -> &[u16] {
        &self.columns.kind[..self.robots()]
    }

    /// Rows in use, those of absent robots between others included.
    pub fn robots(&self) -> usize {
        self.robots as usize
    }

    /// Robots that are there.
    pub fn present(&self) -> usize {
        self.robots() - self.free.len()
    }

    /// Whether the robot is there.
    pub fn contains(&self, robot: u32) -> bool {
        self.row(robot).is_ok()
    }

    /// A [`RobotState`] for every row in use.
    pub fn states(&self) -> &[u8] {
        &self.columns.state[..self.robots()]
    }

    /// Robots by state: idle, driving, waiting, held, faulted. Reads a byte a robot.
    pub fn robots_by_state(&self) -> [u32; 5] {
        let mut by_state = [0; 256];
        self.states().iter().for_each(|&state| by_state[usize::from(state)] += 1);
        [RobotState::Idle, RobotState::Driving, RobotState::Waiting, RobotState::Held, RobotState::Faulted]
            .map(|state| by_state[state as usize])
    }

    /// Bytes of memory that each robot takes, frames and ordered routes not counted.
    pub fn bytes_per_robot(&self) -> usize {
        self.columns.bytes_per_row()
    }

    /// One tick for every robot. Poses go straight into the frame, if there is one.
    ///
    /// # Panics
    /// If the columns are not those of a frame for [`Fleet::robots`] robots.
    pub fn step(&mut self, columns: Option<ColumnsMut>, events: &mut Events) {
        if let Some(columns) = &columns {
            check_frame(columns, self.robots());
        }
        let rows = self.columns.rows(self.robots as usize);
        match &mut self.crew {
            None => self.motion.step(rows, columns, events),
            Some(crew) => crew.step(&self.motion, rows, columns, events),
        }
    }

    /// Writes the poses as they are.
    ///
    /// # Panics
    /// If the columns are not those of a frame for [`Fleet::robots`] robots.
    pub fn write(&mut self, columns: ColumnsMut) {
        check_frame(&columns, self.robots());
        self.motion.write(self.columns.rows(self.robots as usize), columns);
    }
}

fn check_frame(columns: &ColumnsMut, robots: usize) {
    let words = stride_lines(robots) * WORDS_PER_LINE;
    let bytes = stride_lines(robots).div_ceil(4) * BYTES_PER_LINE;
    let lengths = [&columns.x, &columns.y, &columns.theta, &columns.speed, &columns.s].map(|column| column.len());
    assert_eq!(lengths, [words; 5], "a frame of {robots} robots");
    assert_eq!((columns.edge.len(), columns.state.len()), (words, bytes), "a frame of {robots} robots");
}

fn check(graph: &RouteGraph, config: &FleetConfig) -> Result<(), FleetError> {
    if config.types.len() > usize::from(u16::MAX) {
        return Err(FleetError::TooManyTypes(config.types.len()));
    }
    if let Some(bad) = config.types.iter().find(|kind| !(kind.max_speed > 0.0 && kind.max_acceleration > 0.0)) {
        return Err(FleetError::BadLimit { name: bad.name.clone() });
    }
    if !config.isa.is_supported() {
        return Err(FleetError::Unsupported(config.isa));
    }
    let speeds = graph.edges().iter().flat_map(|edge| [edge.velocity_forward, edge.velocity_backwards.unwrap_or(0.0)]);
    let metres = speeds.fold(0.0, f64::max) * config.tick_period.as_secs_f64();
    if metres > Fleet::LONGEST_STEP {
        return Err(FleetError::StepTooLong { metres, tick: config.tick_period });
    }
    Ok(())
}
