//! Batteries: robots drain them, and chargers charge them.
//!
//! Charges are whole microjoules, so that their sums are exact. They change once in a period of
//! about a tenth of a second, by the robot's state at that time. A large fleet must not pay for
//! them in every tick.

use std::time::Duration;

use regatta_base::random::{mix, unit};
use regatta_layout::RouteGraph;
use regatta_plugin::frame::RobotState;
use regatta_scenario::{Battery, ChargeRange, RobotType};

use super::{EventBuffer, Fleet};

/// The time between two changes of charges, unless a tick is longer.
const PERIOD: Duration = Duration::from_millis(100);

/// A flat robot continues when it has been charged to this part of its capacity.
const ENOUGH_TO_GO_ON: u64 = 100;

const MICROJOULES_PER_WATT_HOUR: f64 = 3.6e9;

/// The charges of all robots.
#[derive(Debug)]
pub(super) struct Batteries {
    /// By robot type, in microjoules; `None` for types without a battery.
    types: Vec<Option<Amounts>>,
    /// By row: microjoules.
    charges: Vec<u64>,
    /// By node.
    is_charger: Vec<bool>,
    ticks_per_period: u64,
    seed: u64,
}

/// The capacity of a battery, and the changes of its charge in a period, in microjoules.
#[derive(Clone, Copy, Debug)]
struct Amounts {
    capacity: u64,
    moving: u64,
    standing: u64,
    charging: u64,
    /// The charge at the start.
    start: ChargeRange,
}

/// The charge of a battery and its capacity, in microjoules.
struct BatteryLevel {
    charge: u64,
    capacity: u64,
}

impl Amounts {
    fn new(battery: &Battery, period_secs: f64) -> Self {
        let capacity = f64::from(battery.capacity) * MICROJOULES_PER_WATT_HOUR;
        Self {
            capacity: capacity.round().max(1.0) as u64,
            moving: microjoules(battery.drain_moving, period_secs),
            standing: microjoules(battery.drain_standing, period_secs),
            charging: microjoules(battery.charge_rate, period_secs),
            start: battery.charge,
        }
    }
}

fn microjoules(watts: f32, seconds: f64) -> u64 {
    (f64::from(watts) * seconds * 1e6).round() as u64
}

impl Batteries {
    /// Returns the batteries of a fleet without robots; `None` if no type has one.
    pub fn new(
        types: &[RobotType],
        graph: &RouteGraph,
        (tick_period, seed): (Duration, u64),
    ) -> Option<Self> {
        types.iter().find(|robot_type| robot_type.battery.is_some())?;
        let tick_secs = tick_period.as_secs_f64();
        let ticks_per_period = (PERIOD.as_secs_f64() / tick_secs).round().max(1.0) as u64;
        let period_secs = tick_secs * ticks_per_period as f64;
        let batteries = types.iter().map(|robot_type| robot_type.battery.as_ref());
        Some(Self {
            types: batteries
                .map(|battery| battery.map(|battery| Amounts::new(battery, period_secs)))
                .collect(),
            charges: Vec::new(),
            is_charger: graph.chargers(),
            ticks_per_period,
            seed: mix(seed ^ 0x6261_7474_6572_7973),
        })
    }

    /// Gives a new robot the charge that it starts with.
    pub fn begin(&mut self, robot: u32, robot_type: u16) {
        let row = robot as usize;
        self.charges.resize(self.charges.len().max(row + 1), 0);
        let Some(amounts) = self.types[usize::from(robot_type)] else { return };
        let part = unit(mix(self.seed ^ mix(u64::from(robot))));
        let from = f64::from(amounts.start.min) / 100.0;
        let to = f64::from(amounts.start.max) / 100.0;
        self.charges[row] = ((from + part * (to - from)) * amounts.capacity as f64) as u64;
    }
}

impl Fleet {
    /// Lets robots take energy from their batteries, and chargers give it, if a period ends with
    /// this tick. Robots without energy stop; they are broken until a command repairs them, or
    /// until they have been charged.
    pub fn drain_batteries(&mut self, tick: u64, events: &mut EventBuffer) {
        match &self.batteries {
            Some(batteries) if tick.is_multiple_of(batteries.ticks_per_period) => {}
            _ => return,
        }
        for robot in 0..self.robots {
            let Some(level) = self.drain_battery(robot) else { continue };
            if level.charge == 0 {
                self.run_flat(robot, events);
            } else if level.charge > level.capacity / ENOUGH_TO_GO_ON && self.is_flat(robot) {
                self.end_flat(robot, events);
            }
        }
    }

    /// Changes the charge of a robot by one period in its state. Returns the level afterwards;
    /// `None` without a battery.
    fn drain_battery(&mut self, robot: u32) -> Option<BatteryLevel> {
        let row = robot as usize;
        let state = RobotState::from_number(self.columns.state[row]);
        let is_moving = self.columns.speed[row] != 0.0 || state == RobotState::Turning;
        let is_charging = !is_moving && self.is_at_charger(row, state);
        let batteries = self.batteries.as_mut().filter(|_| state != RobotState::Absent)?;
        let amounts = batteries.types[usize::from(self.columns.robot_type[row])]?;
        let charge = &mut batteries.charges[row];
        *charge = if is_charging {
            (*charge + amounts.charging).min(amounts.capacity)
        } else {
            charge.saturating_sub(if is_moving { amounts.moving } else { amounts.standing })
        };
        Some(BatteryLevel { charge: *charge, capacity: amounts.capacity })
    }

    /// Whether a robot that stands is at a node with the role `charge`, and has nothing else to do
    /// there.
    fn is_at_charger(&self, row: usize, state: RobotState) -> bool {
        let is_free =
            state == RobotState::Idle || (state == RobotState::Broken && self.is_flat(row as u32));
        let (piece, w) = (self.columns.piece.get(row), self.columns.w[row]);
        is_free
            && self.motion.legs.is_leg_end(piece, w)
            && self
                .batteries
                .as_ref()
                .is_some_and(|all| all.is_charger[self.node_ahead(row).0 as usize])
    }

    /// Puts a full battery into a robot that is flat, and lets it go on.
    pub(super) fn change_battery(&mut self, robot: u32, events: &mut EventBuffer) {
        let is_flat = self.is_flat(robot);
        let Some(batteries) = self.batteries.as_mut().filter(|_| is_flat) else { return };
        let row = robot as usize;
        if let Some(amounts) = batteries.types[usize::from(self.columns.robot_type[row])] {
            batteries.charges[row] = amounts.capacity;
            self.end_flat(robot, events);
        }
    }

    /// Returns the charge of every row in per cent, 0 to 100, and NaN for robots without a battery;
    /// `None` if no type has one.
    pub fn battery_charges(&self) -> Option<Vec<f32>> {
        let batteries = self.batteries.as_ref()?;
        let mut percent = Vec::with_capacity(self.robots());
        for (charge, robot_type) in batteries.charges.iter().zip(self.robot_types()) {
            percent.push(match batteries.types[usize::from(*robot_type)] {
                Some(amounts) => (*charge as f64 / amounts.capacity as f64 * 100.0) as f32,
                None => f32::NAN,
            });
        }
        Some(percent)
    }
}
