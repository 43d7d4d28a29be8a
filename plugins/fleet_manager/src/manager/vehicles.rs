//! The state of robots, for the web API.

use std::time::{Duration, Instant};

use regatta_plugin::frame::{Columns, NO_EDGE, RobotState};

use super::Manager;
use regatta_orders::Vehicle;

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
            activity: self.activity(robot as u32).name(),
            node: self.last_node(robot as u32),
            edge: edge.map(|edge| self.steering.roads().edge(edge).id),
            position: [columns.x[robot], columns.y[robot]],
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
