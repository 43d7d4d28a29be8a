//! The columns that the manager publishes: what robots are about, whom they wait for, and where
//! they go.

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

    /// Publishes what the manager has made of a frame.
    ///
    /// `doing` is what each robot of the frame does, by id, and `cost` the time that the cycle
    /// took.
    pub(crate) fn publish(
        &mut self,
        frame: &Frame<'_>,
        manager: &Manager,
        doing: &[Doing],
        cost: Duration,
    ) -> Result {
        let id = |id: Option<u32>| id.map_or(f32::NAN, |id| id as f32);
        let Self { activity, waits_for, goal, values } = self;
        activity.set_cost(cost);
        Self::write(activity, frame, values, |robot| {
            doing.get(robot as usize).map_or(0.0, |doing| f32::from(doing.activity as u8))
        })?;
        Self::write(waits_for, frame, values, |robot| id(manager.waits_for(robot)))?;
        Self::write(goal, frame, values, |robot| id(manager.goal_id(robot)))
    }

    /// Keeps the columns known to readers that join later.
    pub fn update(&self) {
        [&self.activity, &self.waits_for, &self.goal].into_iter().for_each(ColumnPublisher::update);
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
