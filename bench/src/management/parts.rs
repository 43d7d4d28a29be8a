//! The parts of the report: which runs each one needs.

use clap::ValueEnum;

use super::Plan;
use super::measurement::{Place, Setup};

/// A part of the report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Part {
    /// Goals a second over the number of robots, beside the bound
    Throughput,
    /// Robots that stop at random
    Stalls,
    /// Robots that break down
    Breakdowns,
    /// The speed of a run
    Hour,
    /// Ten thousand robots
    Large,
}

/// Robots that stall: per cent of the fleet.
pub const STALLING_PERCENT: [u32; 3] = [0, 10, 30];
/// Robots that break down.
pub const BROKEN: [u32; 4] = [0, 1, 5, 20];
/// The longest run of [`Part::Large`], in simulated seconds.
const LARGE_SECS: u64 = 600;

impl Part {
    pub const ALL: [Self; 5] =
        [Self::Throughput, Self::Stalls, Self::Breakdowns, Self::Hour, Self::Large];

    pub fn name(self) -> String {
        self.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
    }

    /// The fleet sizes.
    pub fn robots(self, plan: &Plan) -> Vec<u32> {
        let own: &[u32] = match (self, plan.quick) {
            (Self::Throughput, false) => &[100, 200, 300, 500, 800, 1000],
            (Self::Throughput, true) => &[200, 500, 1000],
            (Self::Stalls, false) => &[200, 300, 500, 1000],
            (Self::Stalls, true) => &[300],
            (Self::Breakdowns | Self::Hour, _) => &[300],
            (Self::Large, _) => &[10_000],
        };
        if plan.robots.is_empty() { own.to_vec() } else { plan.robots.clone() }
    }

    /// All runs of this part.
    pub fn setups(self, plan: &Plan) -> Vec<Setup> {
        let rows = match self {
            Self::Throughput => {
                let kinds = [(false, true), (false, false), (true, true), (true, false)];
                kinds
                    .into_iter()
                    .flat_map(|(limited, conflicts)| throughput_rows(plan, limited, conflicts))
                    .collect()
            }
            Self::Stalls => stall_rows(plan),
            Self::Breakdowns => breakdown_rows(plan),
            Self::Hour => hour_rows(plan),
            Self::Large => large_rows(plan),
        };
        rows.into_iter().flatten().collect()
    }
}

/// The runs of a row of a table: the same with every seed.
pub type Row = Vec<Setup>;

fn row(plan: &Plan, setup: Setup) -> Row {
    plan.seeds.iter().map(|&seed| Setup { seed, ..setup }).collect()
}

fn setup(plan: &Plan, robots: u32) -> Setup {
    Setup { secs: plan.secs, ..Setup::of(robots) }
}

pub fn throughput_rows(plan: &Plan, limited: bool, conflicts: bool) -> Vec<Row> {
    let robots = Part::Throughput.robots(plan).into_iter();
    robots.map(|robots| row(plan, Setup { limited, conflicts, ..setup(plan, robots) })).collect()
}

pub fn stall_rows(plan: &Plan) -> Vec<Row> {
    let mut rows = Vec::new();
    for robots in Part::Stalls.robots(plan) {
        for limited in [false, true] {
            for stalling_percent in STALLING_PERCENT {
                rows.push(row(plan, Setup { limited, stalling_percent, ..setup(plan, robots) }));
            }
        }
    }
    rows
}

pub fn breakdown_rows(plan: &Plan) -> Vec<Row> {
    let mut rows = Vec::new();
    for robots in Part::Breakdowns.robots(plan) {
        for broken in BROKEN {
            rows.push(row(plan, Setup { broken: broken.min(robots), ..setup(plan, robots) }));
        }
    }
    rows
}

pub fn hour_rows(plan: &Plan) -> Vec<Row> {
    Part::Hour.robots(plan).into_iter().map(|robots| row(plan, setup(plan, robots))).collect()
}

pub fn large_rows(plan: &Plan) -> Vec<Row> {
    let secs = plan.secs.min(if plan.quick { LARGE_SECS / 10 } else { LARGE_SECS });
    let robots = Part::Large.robots(plan).into_iter();
    robots
        .map(|robots| row(plan, Setup { place: Place::Large, secs, ..Setup::of(robots) }))
        .collect()
}
