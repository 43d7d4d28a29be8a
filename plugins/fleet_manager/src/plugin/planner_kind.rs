//! The planners of the command line.

use clap::ValueEnum;

use crate::planner::{Lanes, LanesSettings, Pibt, PibtSettings, Planner, Tea, TeaSettings};
use crate::roads::Roads;
use crate::steering::{AdmissionSettings, Settings};

/// The planner that decides which way robots go.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum PlannerKind {
    /// The fastest way, with the time added that others lose on it; for roads whose lanes are
    /// driven one way
    #[default]
    Lanes,
    /// Time-enhanced A*: whole paths in time layers; for some tens of robots
    Tea,
    /// Priority inheritance with backtracking: from place to place; where opposing traffic shares
    /// one track
    Pibt,
}

impl PlannerKind {
    /// Makes the planner for some roads.
    pub fn planner(self, roads: &Roads) -> Box<dyn Planner> {
        match self {
            Self::Lanes => Box::new(Lanes::new(roads, LanesSettings::default())),
            Self::Tea => Box::new(Tea::new(roads, TeaSettings::default())),
            Self::Pibt => Box::new(Pibt::new(roads, PibtSettings::default())),
        }
    }

    /// The settings of steering for it.
    pub(super) fn settings(self) -> Settings {
        match self {
            Self::Lanes => Settings::default(),
            // They decide themselves in which order robots drive: a robot that isn't admitted would
            // hold up all that are to follow it.
            Self::Tea | Self::Pibt => Settings {
                admission: AdmissionSettings::unlimited(),
                stub_guard: false,
                ..Settings::default()
            },
        }
    }
}
