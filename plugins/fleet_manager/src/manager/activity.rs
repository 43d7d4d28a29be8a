//! The activity of robots, for columns.

use regatta_plugin::activity::Activity;

use super::{Manager, Progress};
use crate::run_figures::Doing;
use regatta_orders::Order;

impl Manager {
    /// The activity of a robot.
    pub fn activity(&self, robot: u32) -> Activity {
        self.activity_with(robot, self.order_of(robot))
    }

    fn order_of(&self, robot: u32) -> Option<&Order> {
        self.orders.order_of(robot).and_then(|id| self.orders.order(id))
    }

    fn activity_with(&self, robot: u32, order: Option<&Order>) -> Activity {
        let Some(state) = self.steering.robot(robot) else { return Activity::Idle };
        match self.progress.get(robot as usize) {
            _ if self.steering.is_out_of_service(robot) => Activity::OutOfService,
            Some(Progress::Handling(_)) => Activity::Handling,
            _ if state.is_held => Activity::Parked,
            _ if state.waiting_since.is_finite() => Activity::Waiting,
            _ if self.charging.goal(robot).is_some() => Activity::Charging,
            _ => match order {
                Some(order) if order.handled_stops > 0 => Activity::Carrying,
                Some(_) => Activity::ToPick,
                None => Activity::Idle,
            },
        }
    }

    /// The activity of a robot, for figures.
    pub(crate) fn doing(&self, robot: u32, speed: f32) -> Doing {
        let order = self.order_of(robot);
        let is_loaded = order.is_some_and(|order| order.handled_stops > 0);
        Doing {
            activity: self.activity_with(robot, order),
            has_order: order.is_some(),
            is_loaded,
            speed,
        }
    }

    /// The robot that a robot waits for.
    pub fn waits_for(&self, robot: u32) -> Option<u32> {
        self.steering
            .robot(robot)
            .filter(|state| state.waiting_since.is_finite())?
            .blocker
            .map(|blocker| blocker.robot)
    }

    /// The id of the node to which a robot was sent.
    pub fn goal_id(&self, robot: u32) -> Option<u32> {
        let goal = self.steering.robot(robot)?.goal()?;
        Some(self.steering.roads().node_id(goal))
    }
}
