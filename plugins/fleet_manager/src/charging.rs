//! Charging: assigns robots to chargers.
//!
//! A charger is a node with the role `charge`. It is promised to one robot at a time, and only when
//! no other robot is there or on the way there: so the way to it is free, too. The promise lasts
//! until the robot has left. Robots go while they have the energy for the way to the nearest
//! charger, and a reserve.

use regatta_plugin::World;
use regatta_plugin::world::{RobotTypeRecord, Role};

use crate::roads::Roads;

mod decide;
#[cfg(test)]
mod tests;

/// The settings of charging. Charges are in per cent, as in VDA 5050.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChargingSettings {
    /// Robots with less go to a charger as soon as they carry nothing.
    pub low: f32,
    /// Robots with less use the time in which they have nothing to do.
    pub top_up: f32,
    /// Robots with more leave the charger if others need one.
    pub enough: f32,
    /// Robots with more leave the charger.
    pub full: f32,
    /// The share of the battery that no plan may use.
    pub reserve: f32,
    /// The factor by which driving takes longer than on empty roads.
    pub delay: f64,
    /// The seconds without an order after which a robot has nothing to do.
    pub idle_secs: f64,
}

impl Default for ChargingSettings {
    fn default() -> Self {
        Self {
            low: 30.0,
            top_up: 90.0,
            enough: 70.0,
            full: 95.0,
            reserve: 10.0,
            delay: 2.0,
            idle_secs: 30.0,
        }
    }
}

/// Per cent: robots with less charge while an order waits that takes more than they usually have.
const ALL: f32 = 99.9;

/// The situation of a robot in a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Situation {
    /// The robot.
    pub robot: u32,
    /// The node at the end of its base, if it is steered.
    pub node: Option<u32>,
    /// The node of its order's next stop, if it has an order.
    pub stop: Option<u32>,
    /// Whether it carries something, or handles a stop: then it isn't sent away.
    pub is_bound: bool,
    /// Whether it stands at the [node that it was sent to](Charging::goal).
    pub has_arrived: bool,
    /// Whether no way leads there.
    pub is_unreachable: bool,
    /// Whether it is broken.
    pub is_broken: bool,
}

/// A charge that a robot may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Charge {
    /// All of its battery.
    Full,
    /// That with which it doesn't go to a charger though it has nothing to do.
    Usual,
}

/// A decision about a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decision {
    /// The robot.
    pub robot: u32,
    /// Its next action.
    pub action: ChargeAction,
}

/// The next action of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChargeAction {
    /// Drive to a node, a charger or a refuge, and give back the order that it hasn't begun.
    Go(u32),
    /// Stay where it is: it charges.
    Stay,
    /// Wait for a charger, and give back the order that it hasn't begun.
    Wait,
    /// Anything: it has charged, or has made room.
    Free,
    /// None: its battery is flat.
    Flat,
}

/// Decides which robots charge.
#[derive(Debug, Default)]
pub struct Charging {
    settings: ChargingSettings,
    /// By robot type.
    types: Vec<Option<Battery>>,
    /// In ascending order of their nodes.
    chargers: Vec<Charger>,
    /// By id.
    robots: Vec<Robot>,
    /// By node: seconds to the nearest of the chargers that have been measured; infinity if there
    /// is none.
    nearest_secs: Vec<f64>,
    /// The number of chargers that have been measured.
    measured: usize,
    /// Whether an order waits that takes more than robots usually charge.
    is_all_needed: bool,
    decisions: Vec<Decision>,
}

/// The battery of a robot type.
#[derive(Clone, Copy, Debug)]
struct Battery {
    /// Joules.
    capacity: f64,
    /// Watts: the larger of moving and standing.
    drain: f64,
}

#[derive(Clone, Copy, Debug)]
struct Charger {
    node: u32,
    /// The robot that may be there.
    promised: Option<u32>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Robot {
    battery: Option<Battery>,
    /// Per cent.
    charge: f32,
    phase: Phase,
    /// Since when it has no order, in simulated seconds.
    idle_since: Option<f64>,
    is_low: bool,
}

/// The phase of a robot's charging, with the index of its charger.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Phase {
    /// Nothing.
    #[default]
    Free,
    /// It needs a charger, and none is free.
    Waiting,
    /// It drives to its charger.
    Going(usize),
    Charging(usize),
    /// It has charged, and is still there.
    Resting(usize),
    /// It makes room, on the way to a node.
    Leaving(usize, u32),
    Flat,
}

impl Charging {
    /// Takes the chargers and the batteries of a world.
    pub fn new(world: &World<'_>, settings: ChargingSettings) -> Self {
        let chargers = (0..).zip(world.nodes()).filter(|(_, node)| node.role() == Role::Charge);
        Self {
            settings,
            types: world.robot_types().iter().map(Battery::of).collect(),
            chargers: chargers.map(|(node, _)| Charger { node, promised: None }).collect(),
            nearest_secs: vec![f64::INFINITY; world.nodes().len()],
            ..Self::default()
        }
    }

    /// Whether there are batteries and chargers; without both, nothing is to be decided.
    pub fn is_needed(&self) -> bool {
        !self.chargers.is_empty() && self.types.iter().any(Option::is_some)
    }

    /// The nodes of the chargers.
    pub fn chargers(&self) -> impl Iterator<Item = u32> {
        self.chargers.iter().map(|charger| charger.node)
    }

    /// Takes the column `battery`, in per cent, and the column `type`, which is empty if all robots
    /// are of the first type.
    pub fn see(&mut self, robots: usize, charges: &[f32], robot_types: &[f32]) {
        if !self.is_needed() {
            return;
        }
        self.robots.resize(robots, Robot::default());
        for (index, robot) in self.robots.iter_mut().enumerate() {
            let robot_type = robot_types.get(index).map_or(0, |number| *number as usize);
            let charge = charges.get(index).copied().filter(|charge| charge.is_finite());
            robot.battery =
                self.types.get(robot_type).copied().flatten().filter(|_| charge.is_some());
            robot.charge = charge.unwrap_or_default();
        }
    }

    /// Measures how far it is to the chargers: one in each call. `secs` returns the driving time
    /// between two nodes.
    pub fn measure(&mut self, secs: &dyn Fn(u32, u32) -> Option<f64>) {
        let Some(charger) = self.chargers.get(self.measured) else { return };
        self.measured += 1;
        for (node, nearest) in (0..).zip(&mut self.nearest_secs) {
            *nearest = nearest.min(secs(node, charger.node).unwrap_or(f64::INFINITY));
        }
    }

    /// Whether it is known how far it is to the chargers.
    pub fn is_measured(&self) -> bool {
        self.measured == self.chargers.len()
    }

    /// The node that charging has sent a robot to.
    pub fn goal(&self, robot: u32) -> Option<u32> {
        match self.robots.get(robot as usize)?.phase {
            Phase::Going(charger) => Some(self.chargers[charger].node),
            Phase::Leaving(_, refuge) => Some(refuge),
            _ => None,
        }
    }

    /// Whether a robot charges, or drives to a charger.
    pub fn is_charging(&self, robot: u32) -> bool {
        let robot = self.robots.get(robot as usize);
        robot.is_some_and(|robot| matches!(robot.phase, Phase::Going(_) | Phase::Charging(_)))
    }

    /// Whether a robot may get an order.
    pub fn may_work(&self, robot: u32) -> bool {
        let Some(robot) = self.robots.get(robot as usize) else { return true };
        !robot.is_low && matches!(robot.phase, Phase::Free | Phase::Resting(_) | Phase::Leaving(..))
    }

    /// Whether a robot has the energy to drive for some seconds on empty roads, to stand for
    /// others, and to get from a node to a charger then.
    pub fn suffices(&self, robot: u32, driving_secs: f64, standing_secs: f64, last: u32) -> bool {
        let Some(robot) = self.robots.get(robot as usize) else { return true };
        let secs = self.secs_of(driving_secs, standing_secs, last);
        robot.has_energy_for(secs, self.settings.reserve)
    }

    /// Whether a robot would have the energy for that with another charge.
    pub fn would_suffice(
        &self,
        (robot, charge): (u32, Charge),
        driving_secs: f64,
        standing_secs: f64,
        last: u32,
    ) -> bool {
        let Some(robot) = self.robots.get(robot as usize) else { return true };
        let secs = self.secs_of(driving_secs, standing_secs, last);
        let charge = match charge {
            Charge::Full => 100.0,
            Charge::Usual => self.settings.top_up,
        };
        Robot { charge, ..*robot }.has_energy_for(secs, self.settings.reserve)
    }

    /// Takes whether an order waits that takes more than robots usually charge: until it has a
    /// robot, they charge completely.
    pub fn need_all(&mut self, is_all_needed: bool) {
        self.is_all_needed = is_all_needed;
    }

    /// A limit of the settings, or a full battery if an order needs one.
    fn or_all(&self, limit: f32) -> f32 {
        if self.is_all_needed { limit.max(ALL) } else { limit }
    }

    /// The seconds that are planned for driving and standing, and then the way to a charger.
    fn secs_of(&self, driving_secs: f64, standing_secs: f64, last: u32) -> f64 {
        let driving_secs = driving_secs + self.secs_to_charger(Some(last));
        driving_secs * self.settings.delay + standing_secs
    }

    /// Forgets a robot that is not there any more.
    pub fn lose(&mut self, robot: u32) {
        self.break_promises(robot);
        if let Some(robot) = self.robots.get_mut(robot as usize) {
            *robot = Robot::default();
        }
    }

    fn break_promises(&mut self, robot: u32) {
        for charger in &mut self.chargers {
            if charger.promised == Some(robot) {
                charger.promised = None;
            }
        }
    }

    /// Seconds on empty roads to the nearest charger; 0 if that isn't known.
    fn secs_to_charger(&self, node: Option<u32>) -> f64 {
        let secs = node.and_then(|node| self.nearest_secs.get(node as usize));
        secs.copied().filter(|secs| secs.is_finite()).unwrap_or(0.0)
    }

    fn is_charger(&self, node: u32) -> bool {
        self.chargers.binary_search_by_key(&node, |charger| charger.node).is_ok()
    }

    /// Returns a free node near a charger, where a robot leaves room for the next one.
    fn refuge(&self, roads: &Roads, charger: u32, taken: &[u32]) -> Option<u32> {
        /// The largest number of nodes that are searched.
        const MOST_NODES: usize = 200;
        let mut seen = vec![charger];
        let mut next = 0;
        while let Some(&node) = seen.get(next).filter(|_| next < MOST_NODES) {
            next += 1;
            // The nodes just before and after a charger may be part of its bay.
            if next > 2
                && !self.is_charger(node)
                && !roads.exits(node).iter().any(|&leg| self.is_charger(roads.end(leg)))
                && taken.binary_search(&node).is_err()
            {
                return Some(node);
            }
            for &leg in roads.exits(node) {
                let end = roads.end(leg);
                if !seen.contains(&end) {
                    seen.push(end);
                }
            }
        }
        None
    }
}

impl Battery {
    fn of(robot_type: &RobotTypeRecord) -> Option<Self> {
        let capacity = f64::from(robot_type.battery_capacity) * 3600.0;
        let drain = f64::from(robot_type.drain_moving.max(robot_type.drain_standing));
        (capacity > 0.0).then_some(Self { capacity, drain })
    }
}

impl Robot {
    /// Whether its battery lasts for some seconds, with a reserve in per cent. A robot without a
    /// battery lasts for ever.
    fn has_energy_for(&self, secs: f64, reserve: f32) -> bool {
        self.battery.is_none_or(|battery| self.left(battery, reserve) >= secs * battery.drain)
    }

    /// Joules above a reserve.
    fn left(&self, battery: Battery, reserve: f32) -> f64 {
        f64::from(self.charge - reserve) / 100.0 * battery.capacity
    }
}
