//! The messages from the background threads to the window.

use regatta_plugin::ColumnName;
use regatta_plugin::control::ControlResponse;
use regatta_plugin::route::RouteResponse;

use crate::interface::rows::Rows;

/// A report of the background threads.
#[derive(Debug)]
pub enum Report {
    /// New data of the fleet.
    Facts(Fact),
    /// A message for the user.
    Notice(String),
    /// The selected robots' routes; empty if no process answers.
    Routes(Vec<RouteResponse>),
}

/// New data of the fleet.
#[derive(Debug)]
pub enum Fact {
    /// The engine's status; `None` if there is no engine.
    Status(Option<Box<ControlResponse>>),
    /// The rows of the fleet list.
    Rows(Rows),
    /// The columns that are published.
    Columns(Vec<ColumnName>),
    /// The selected robot's value in each column.
    Values(Vec<(ColumnName, f32)>),
}

impl From<Fact> for Report {
    fn from(fact: Fact) -> Self {
        Self::Facts(fact)
    }
}
