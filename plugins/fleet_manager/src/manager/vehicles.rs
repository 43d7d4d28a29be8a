//! The state of robots, for the web API, columns and figures.

use crate::run_figures::Doing;
use regatta_plugin::activity::Activity;
use std::time::{Duration, Instant};

use glam::vec2;
use regatta_plugin::frame::{Columns, NO_EDGE, RobotState};

use super::{Manager, Progress};
use regatta_orders::{Held, Vehicle};

/// The number of cycles in which every robot is shown once, so that a large fleet costs each cycle
/// little.
const ROUND: usize = 10;
/// The shortest wall-clock time between two of these cycles. The manager has ten a second in real
/// time, and many more in lockstep.
const PERIOD: Duration = Duration::from_millis(90);
/// The distance from the end of a leg at which a robot counts as being there, in metres.
const AT_END: f32 = 2e-3;

impl Manager {
    /// Shows a tenth of the robots to the web API, if there is one and [`PERIOD`] has passed, in
    /// turn. The first time it shows all of them, because a paused fleet has no further cycle.
    pub fn show_vehicles(&mut self, columns: &Columns<'_>, charges: &[f32]) {
        let is_soon = self.vehicles_shown.is_some_and(|shown| shown.elapsed() < PERIOD);
        if is_soon || !self.orders.is_served() {
            return;
        }
        self.vehicles_shown = Some(Instant::now());
        let (first, step) = match self.vehicle_cycles {
            0 => (0, 1),
            cycle => (cycle % ROUND, ROUND),
        };
        self.vehicle_cycles += 1;
        for robot in (first..columns.state.len()).step_by(step) {
            let vehicle = self.vehicle(robot, columns, charges);
            self.orders.show_vehicle(vehicle);
        }
    }

    fn vehicle(&self, robot: usize, columns: &Columns<'_>, charges: &[f32]) -> Vehicle {
        let state = RobotState::from_number(columns.state[robot]);
        let edge = Some(columns.edge[robot])
            .filter(|edge| *edge != NO_EDGE && state != RobotState::Absent);
        let charge = charges.get(robot).filter(|charge| charge.is_finite());
        Vehicle {
            robot: robot as u32,
            state: state.name(),
            activity: Activity::of(state, Some(self.activity(robot as u32)))
                .map_or(state.name(), Activity::name),
            node: self.last_node(robot as u32),
            edge: edge.map(|edge| self.steering.roads().edge(edge).id),
            position: vec2(columns.x[robot], columns.y[robot]),
            energy_level: charge.map(|charge| charge.round().clamp(0.0, 100.0) as u8),
            transport_order: None,
        }
    }

    /// The node that a robot reached last; where that is unknown, one at an end of its edge.
    fn last_node(&self, robot: u32) -> Option<u32> {
        let roads = self.steering.roads();
        let claim = self.steering.claims().of(robot);
        let (leg, from) = claim.iter().find_map(|stretch| Some((stretch.leg?, stretch.from)))?;
        let is_at_end = from >= roads.edge(leg.edge()).length - AT_END;
        Some(if is_at_end { roads.end(leg) } else { roads.start(leg) })
    }
}

impl Manager {
    /// The activity of a robot, as far as its state doesn't say otherwise.
    pub fn activity(&self, robot: u32) -> Activity {
        self.activity_with(robot, self.orders.held(robot))
    }

    fn activity_with(&self, robot: u32, order: Option<Held>) -> Activity {
        let Some(state) = self.steering.robot(robot) else { return Activity::Idle };
        match self.progress.get(robot as usize) {
            Some(Progress::AtStop(service)) if self.steering.now() < service.begin_secs => {
                Activity::Waiting
            }
            Some(Progress::AtStop(_)) => Activity::Handling,
            Some(Progress::Queueing { place: None, .. }) => Activity::Queued,
            _ if state.is_held || self.waits_in_queue(robot) => Activity::Queued,
            _ if state.waiting_since.is_finite() => Activity::Waiting,
            _ if self.charging.is_charging(robot) => Activity::Charging,
            // At a door or a lift, or for a route: until roads are open, or there is room.
            _ if matches!(state.state, RobotState::Idle | RobotState::Waiting)
                && order.is_some() =>
            {
                Activity::Waiting
            }
            _ => match order {
                Some(order) if order.is_bound => Activity::Carrying,
                Some(_) => Activity::Fetching,
                None => Activity::Idle,
            },
        }
    }

    /// The activity of a robot in a state, for figures.
    pub(crate) fn doing(&self, robot: u32, state: RobotState, speed: f32) -> Doing {
        let order = self.orders.held(robot);
        let is_loaded = order.is_some_and(|order| order.is_bound);
        Doing {
            activity: Activity::of(state, Some(self.activity_with(robot, order)))
                .unwrap_or_default(),
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
