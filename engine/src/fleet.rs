//! The state of all robots as private columns, and everything that changes it: spawns, commands and
//! time.
//!
//! The parts of a fleet (`ahead`, `batteries`, `closures`, `facilities`, `impairment`, `commands`,
//! `release`, `spawn`) are methods of [`Fleet`] by topic.

mod ahead;
mod batteries;
mod closures;
mod columns;
mod commands;
mod events;
mod facilities;
mod graph_size;
mod impairment;
mod release;
mod spawn;
mod step_pool;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use regatta_layout::{EdgeIndex, NodeIndex, Orientation, RouteGraph};
use regatta_motion::{
    EdgeHeading, EdgeHeadings, HeadingRule, Isa, KinematicLimits, LegTable, Motion, Plans,
    PoseColumns, Route, SpeedVariation, SupportedIsa, TimeStep, TooManyPieces, Tracks, leg_of,
};
use regatta_plugin::frame::{BYTES_PER_LINE, ColumnsMut, RobotState, WORDS_PER_LINE, stride_lines};
use regatta_scenario::RobotType;

pub use self::ahead::Ahead;
use self::batteries::Batteries;
use self::columns::FleetColumns;
pub use self::events::EventBuffer;
use self::facilities::Facilities;
pub use self::graph_size::check_size;
use self::impairment::Impairment;
pub use self::spawn::{Placement, RouteSource};
use self::step_pool::StepPool;

/// The error of setting up a fleet.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FleetError {
    /// A robot could drive more than [`Fleet::LONGEST_STEP`] in a tick.
    #[error(
        "a robot would drive {metres:.1} m in one tick of {tick:?}, more than {} m; use a higher \
         rate",
        Fleet::LONGEST_STEP
    )]
    StepTooLong {
        /// Metres per tick.
        metres: f64,
        /// The tick period.
        tick: Duration,
    },
    /// A robot type has a limit that is not a positive number.
    #[error(
        "robot type {name:?}: limits of speed and acceleration must be more than 0; leave them out \
         for no limit"
    )]
    BadLimit {
        /// Name of the type.
        name: String,
    },
    /// There are more robot types than fit the column.
    #[error("{0} robot types are more than 65535; merge some")]
    TooManyTypes(usize),
    /// The route graph has more pieces than the fleet can index.
    #[error(
        "the route graph compiles to {pieces} pieces (of 8 m at most), more than {max}: its edges \
         are too long in total, or too many; are the positions in metres?"
    )]
    TooManyPieces {
        /// Number of pieces, or fewer.
        pieces: usize,
        /// The maximum number of pieces that a fleet can index.
        max: usize,
    },
    /// The route graph needs more memory than this machine has left.
    #[error(
        "the route graph compiles to {pieces} pieces (of 8 m at most), which need {needed_mb} MB \
         of memory; {available_mb} MB are left: use a smaller graph; are the positions in metres?"
    )]
    GraphTooLarge {
        /// Number of pieces, or fewer.
        pieces: u64,
        /// Memory that they need, in MB.
        needed_mb: u64,
        /// Memory that is left, in MB.
        available_mb: u64,
    },
    /// This machine doesn't have that instruction set.
    #[error("this machine can't run {0} instructions; use {best}", best = Isa::detect())]
    Unsupported(Isa),
    /// The threads could not be started.
    #[error("can't start {0} threads; use fewer")]
    Threads(usize),
}

impl From<TooManyPieces> for FleetError {
    fn from(TooManyPieces { pieces, max }: TooManyPieces) -> Self {
        Self::TooManyPieces { pieces, max }
    }
}

/// The configuration of a fleet.
#[derive(Clone, Debug)]
pub struct FleetConfig {
    /// Robot types; at most 65,535.
    pub types: Vec<RobotType>,
    /// Simulated time per tick.
    pub tick_period: Duration,
    /// Seed of the random walks.
    pub seed: u64,
    /// Instruction set. All give the same bits.
    pub isa: Isa,
    /// Number of threads that share a step; ≥ 1. Any number gives the same bits.
    pub threads: usize,
    /// The maximum number of rows. A spawn beyond is refused with
    /// [`Refusal::FleetFull`](regatta_plugin::event::Refusal::FleetFull).
    pub most_robots: u32,
}

/// All robots of a route graph.
///
/// A robot's id is its row. Rows of removed robots are [`RobotState::Absent`] until a spawn uses
/// them again; a frame has [`Fleet::robots`] rows.
#[derive(Debug)]
pub struct Fleet {
    graph: Arc<RouteGraph>,
    motion: Motion,
    types: Vec<RobotType>,
    columns: FleetColumns,
    /// Number of rows in use.
    robots: u32,
    /// Rows among them that hold no robot.
    free: BTreeSet<u32>,
    most_robots: u32,
    /// Robots that stall or are broken.
    impairments: BTreeMap<u32, Impairment>,
    /// `None` if no type has a battery.
    batteries: Option<Batteries>,
    /// `None` if the graph has neither doors nor lifts.
    facilities: Option<Box<Facilities>>,
    /// The number of closures and openings of edges.
    closure_changes: u64,
    /// None if a step runs on the calling thread alone.
    pool: Option<StepPool>,
}

impl Fleet {
    /// The longest distance in metres that a robot may drive in one tick.
    pub const LONGEST_STEP: f64 = 8.0;

    /// Makes an empty fleet.
    ///
    /// # Errors
    /// See [`FleetError`].
    pub fn new(
        graph: Arc<RouteGraph>,
        tracks: Arc<Tracks>,
        config: FleetConfig,
    ) -> Result<Self, FleetError> {
        check_config(&graph, &config)?;
        let FleetConfig { types, tick_period, seed, isa, threads, most_robots } = config;
        let limits: Vec<_> = types.iter().map(kinematic_limits).collect();
        let limited = limits.iter().any(|limits| limits.max_acceleration.is_finite());
        let isa = SupportedIsa::detect(isa).ok_or(FleetError::Unsupported(isa))?;
        let pool = match threads {
            0 | 1 => None,
            _ => Some(StepPool::new(threads).ok_or(FleetError::Threads(threads))?),
        };
        let batteries = Batteries::new(&types, &graph, (tick_period, seed));
        let node_ids = graph.nodes().iter().map(|node| node.id).collect();
        let mut legs = LegTable::new(node_ids, &motion_edges(&graph), tracks)?;
        let facilities = Facilities::new(&graph, tick_period, &mut legs);
        let oriented = limits.iter().any(KinematicLimits::can_turn)
            || graph.edges().iter().any(|edge| edge.orientation != Orientation::Tangential);
        let columns = FleetColumns::new(legs.pieces().len(), limited, oriented);
        let time_step = TimeStep::new(tick_period.as_secs_f64());
        let headings = oriented.then(|| EdgeHeadings::new(&legs, &edge_headings(&graph)));
        let variation = SpeedVariation::default();
        let motion =
            Motion { legs, plans: Plans::new(seed), headings, limits, variation, time_step, isa };
        Ok(Self {
            graph,
            motion,
            types,
            columns,
            robots: 0,
            free: BTreeSet::new(),
            most_robots,
            impairments: BTreeMap::new(),
            batteries,
            facilities,
            closure_changes: 0,
            pool,
        })
    }

    /// Makes each robot drive each leg up to `most` (0 to 1) slower, by a seed.
    pub fn vary_speeds(&mut self, most: f32, seed: u64) {
        self.motion.variation = SpeedVariation { most: most.clamp(0.0, 1.0), seed };
    }

    /// Reserves memory for that many robots. Otherwise spawning allocates it step by step, and more
    /// of it.
    pub fn reserve(&mut self, robots: usize) {
        self.columns.reserve(robots.min(self.most_robots as usize));
    }

    /// Robot types, by index.
    pub fn types(&self) -> &[RobotType] {
        &self.types
    }

    /// Robot type of every row in use, as an index into [`types`](Self::types); meaningless for
    /// absent robots.
    pub fn robot_types(&self) -> &[u16] {
        &self.columns.robot_type[..self.robots()]
    }

    /// Number of rows in use, including those of absent robots between others.
    pub fn robots(&self) -> usize {
        self.robots as usize
    }

    /// Number of robots that are not absent.
    pub fn present(&self) -> usize {
        self.robots() - self.free.len()
    }

    /// Whether there is a robot with this id.
    pub fn contains(&self, robot: u32) -> bool {
        self.row(robot).is_ok()
    }

    /// The [`RobotState`] of every row in use.
    pub fn states(&self) -> &[u8] {
        &self.columns.state[..self.robots()]
    }

    /// Returns x, y and heading of a robot as in frames; `None` if there is no such robot.
    pub fn pose(&self, robot: u32) -> Option<[f32; 3]> {
        let row = self.row(robot).ok()?;
        let columns = &self.columns;
        Some(self.motion.pose(columns.piece.get(row), columns.w[row], columns.heading_rule(row)))
    }

    /// Returns the edge that a robot is on and the node ahead of it, or just the node that it stands
    /// on; `None` if there is no such robot.
    pub fn place(&self, robot: u32) -> Option<(Option<EdgeIndex>, NodeIndex)> {
        let row = self.row(robot).ok()?;
        let leg = leg_of(self.columns.piece.get(row), self.columns.edge[row]);
        Some((leg.map(|leg| leg.edge), self.node_ahead(row)))
    }

    /// Number of robots by [`RobotState`]; absent ones aren't counted. Reads one byte per robot.
    pub fn robots_by_state(&self) -> [u32; RobotState::COUNT] {
        let mut by_state = [0; 256];
        for &state in self.states() {
            by_state[usize::from(state)] += 1;
        }
        std::array::from_fn(|state| by_state[state])
    }

    /// Bytes of memory per robot, without frames and commanded routes.
    pub fn bytes_per_robot(&self) -> usize {
        self.columns.bytes_per_row()
    }

    /// Moves every robot by one tick and writes its pose straight into the frame, if there is one.
    ///
    /// # Panics
    /// If the columns are not those of a frame for [`Fleet::robots`] robots, each of which starts
    /// on a cache line.
    pub fn step(&mut self, columns: Option<ColumnsMut>, events: &mut EventBuffer) {
        if let Some(columns) = &columns {
            check_frame(columns, self.robots());
        }
        let rows = self.columns.rows(self.robots as usize);
        match &mut self.pool {
            None => self.motion.step(rows, columns.map(pose_columns), events),
            Some(pool) => pool.step(&self.motion, rows, columns.map(pose_columns), events),
        }
    }

    /// Writes the poses into a frame as they are.
    ///
    /// # Panics
    /// If the columns are not those of a frame for [`Fleet::robots`] robots, each of which starts
    /// on a cache line.
    pub fn write(&mut self, columns: ColumnsMut) {
        check_frame(&columns, self.robots());
        self.motion.write(self.columns.rows(self.robots as usize), pose_columns(columns));
    }
}

/// The states of the contract have the numbers of those of the motion kernel.
const _: () = {
    use regatta_motion::RobotState as Kernel;
    assert!(Kernel::Idle as u8 == RobotState::Idle as u8);
    assert!(Kernel::Driving as u8 == RobotState::Driving as u8);
    assert!(Kernel::Waiting as u8 == RobotState::Waiting as u8);
    assert!(Kernel::Held as u8 == RobotState::Held as u8);
    assert!(Kernel::Faulted as u8 == RobotState::Faulted as u8);
    assert!(Kernel::Turning as u8 == RobotState::Turning as u8);
    assert!(Kernel::Stalled as u8 == RobotState::Stalled as u8);
    assert!(Kernel::Broken as u8 == RobotState::Broken as u8);
    assert!(Kernel::Absent as u8 == RobotState::Absent as u8);
    assert!(regatta_motion::NO_EDGE == regatta_plugin::frame::NO_EDGE);
};

fn check_frame(columns: &ColumnsMut, robots: usize) {
    let words = stride_lines(robots) * WORDS_PER_LINE;
    let bytes = stride_lines(robots).div_ceil(4) * BYTES_PER_LINE;
    let lengths = [&columns.x, &columns.y, &columns.theta, &columns.speed, &columns.s]
        .map(|column| column.len());
    assert_eq!(lengths, [words; 5], "a frame of {robots} robots");
    assert_eq!(
        (columns.edge.len(), columns.state.len()),
        (words, bytes),
        "a frame of {robots} robots"
    );
    let starts = [&columns.x, &columns.y, &columns.theta, &columns.speed, &columns.s]
        .map(|column| column.as_ptr().addr());
    let starts =
        starts.into_iter().chain([columns.edge.as_ptr().addr(), columns.state.as_ptr().addr()]);
    let is_aligned = starts.into_iter().all(|start| start.is_multiple_of(BYTES_PER_LINE));
    assert!(robots == 0 || is_aligned, "the columns of a frame start on cache lines");
}

/// Returns the columns of a frame as the motion kernel takes them.
fn pose_columns(columns: ColumnsMut<'_>) -> PoseColumns<'_> {
    let ColumnsMut { x, y, theta, speed, s, edge, state } = columns;
    PoseColumns { x, y, theta, speed, s, edge, state }
}

/// Returns the edges of a graph as the motion kernel takes them.
fn motion_edges(graph: &RouteGraph) -> Vec<regatta_motion::Edge> {
    let edges = graph.edges().iter().map(|edge| regatta_motion::Edge {
        origin: edge.origin,
        destination: edge.destination,
        speed: edge.speed,
        reverse_speed: edge.reverse_speed,
    });
    edges.collect()
}

/// Returns the headings along the edges of a graph.
fn edge_headings(graph: &RouteGraph) -> Vec<EdgeHeading> {
    let headings = graph.edges().iter().map(|edge| {
        let rule = match edge.orientation {
            Orientation::Tangential => HeadingRule::TANGENT,
            Orientation::Offset(angle) => HeadingRule::at_angle(angle as f32),
            Orientation::Fixed(heading) => HeadingRule::fixed(heading as f32),
        };
        EdgeHeading { rule, rotation: edge.rotation }
    });
    headings.collect()
}

fn kinematic_limits(robot_type: &RobotType) -> KinematicLimits {
    KinematicLimits {
        max_speed: robot_type.max_speed,
        max_acceleration: robot_type.max_acceleration,
        max_rotation_speed: robot_type.max_rotation_speed,
        max_rotation_acceleration: robot_type.max_rotation_acceleration,
    }
}

fn check_config(graph: &RouteGraph, config: &FleetConfig) -> Result<(), FleetError> {
    if config.types.len() > usize::from(u16::MAX) {
        return Err(FleetError::TooManyTypes(config.types.len()));
    }
    for robot_type in &config.types {
        let is_valid = robot_type.max_speed > 0.0
            && robot_type.max_acceleration > 0.0
            && robot_type.max_rotation_speed >= 0.0
            && robot_type.max_rotation_acceleration > 0.0;
        if !is_valid {
            return Err(FleetError::BadLimit { name: robot_type.name.clone() });
        }
    }
    let speeds =
        graph.edges().iter().flat_map(|edge| [edge.speed, edge.reverse_speed.unwrap_or(0.0)]);
    let metres = speeds.fold(0.0, f64::max) * config.tick_period.as_secs_f64();
    if metres > Fleet::LONGEST_STEP {
        return Err(FleetError::StepTooLong { metres, tick: config.tick_period });
    }
    Ok(())
}
