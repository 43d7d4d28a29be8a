//! The columns that the manager publishes: the activity of robots, the robots that they wait for,
//! and their goals.

use std::time::Duration;

use regatta_plugin::column::{ACTIVITY, GOAL, WAITS_FOR};
use regatta_plugin::ports::columns::ColumnPublisher;
use regatta_plugin::{Frame, Participant, Result};

use crate::manager::Manager;
use crate::run_figures::Doing;

/// The publishers of the columns.
pub struct ManagerColumns {
    activity: ColumnPublisher,
    waits_for: ColumnPublisher,
    goal: ColumnPublisher,
    values: Vec<f32>,
}

impl ManagerColumns {
    /// Opens the columns of a fleet.
    pub fn open_on(fleet: &Participant) -> Result<Self> {
        Ok(Self {
            activity: ColumnPublisher::open_on(fleet, ACTIVITY.name())?,
            waits_for: ColumnPublisher::open_on(fleet, WAITS_FOR.name())?,
            goal: ColumnPublisher::open_on(fleet, GOAL.name())?,
            values: Vec::new(),
        })
    }

    /// Publishes the columns of a frame. `doing` is the activity of each robot of the frame, by id,
    /// and `cost` the duration of the cycle.
    pub(crate) fn publish(
        &mut self,
        frame: &Frame<'_>,
        manager: &Manager,
        doing: &[Doing],
        cost: Duration,
    ) -> Result {
        let Self { activity, waits_for, goal, values } = self;
        activity.set_cost(cost);
        Self::write(activity, frame, values, |robot| {
            doing.get(robot as usize).map_or(0.0, |doing| f32::from(doing.activity as u8))
        })?;
        Self::write(waits_for, frame, values, |robot| number(manager.waits_for(robot)))?;
        Self::write(goal, frame, values, |robot| number(manager.goal_id(robot)))
    }

    /// Keeps the columns known to readers that join later.
    pub fn update(&self) {
        for column in [&self.activity, &self.waits_for, &self.goal] {
            column.update();
        }
    }

    fn write(
        publisher: &mut ColumnPublisher,
        frame: &Frame<'_>,
        values: &mut Vec<f32>,
        value: impl Fn(u32) -> f32,
    ) -> Result {
        values.clear();
        values.extend((0..frame.len() as u32).map(value));
        Ok(publisher.publish(frame, values)?)
    }
}

/// An id as the value of a column; NaN for none.
fn number(id: Option<u32>) -> f32 {
    id.map_or(f32::NAN, |id| id as f32)
}
