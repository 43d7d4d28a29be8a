//! The messages from the background threads to the window.

use regatta_interface::commands::UserCommand;
use regatta_interface::log::LogReport;
use regatta_interface::orders::RobotOrder;
use regatta_interface::robot_filter::{Filter, Matches};
use regatta_interface::rows::Rows;
use regatta_plugin::control::ControlResponse;
use regatta_plugin::ports::error::RequestError;
use regatta_plugin::route::RouteResponse;
use regatta_plugin::{ColumnName, ControlError};
use regatta_scene::plans::PlanReport;

use crate::jams::JamReport;

/// A report of the background threads.
#[derive(Debug)]
pub enum Report {
    /// New data of the fleet.
    Facts(Fact),
    /// A message for the user.
    Notice(String),
    /// A command or a request of the user that came to nothing, and why. The fleet has no event of
    /// it.
    Refused(UserCommand, String),
    /// The selected robots' routes; empty if no process answers.
    Routes(Vec<RouteResponse>),
    /// The robots that match a filter.
    Matches(Filter, Matches),
    /// The plans of robots.
    Plans(Box<PlanReport>),
    /// The figures of jams.
    Jams(Box<JamReport>),
    /// News of the log.
    Log(Box<LogReport>),
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
    /// The selected robot's order.
    Order(Option<RobotOrder>),
}

impl Report {
    /// Returns the report of the engine's answer to a request of the user, or to a poll of the
    /// status.
    pub fn of_answer(answer: Result<ControlResponse, ControlError>, is_requested: bool) -> Self {
        match answer {
            Ok(status) => Fact::Status(Some(Box::new(status))).into(),
            Err(ControlError::Request(RequestError::Gone { .. })) => Fact::Status(None).into(),
            Err(error) if is_requested => Self::Notice(error.to_string()),
            Err(ControlError::NoEngine { .. }) => Fact::Status(None).into(),
            Err(error) => {
                tracing::debug!(%error, "polling the status");
                Fact::Status(None).into()
            }
        }
    }
}

impl From<Fact> for Report {
    fn from(fact: Fact) -> Self {
        Self::Facts(fact)
    }
}
