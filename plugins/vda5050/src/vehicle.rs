//! A vehicle of the standard: a state machine without connections, threads and clocks.
//!
//! Orders, instant actions and what the engine tells go in; commands to the engine and the state of
//! the vehicle come out. The vehicle is one that follows lines: it drives the edges of the layout,
//! and stops at nodes only.
//!
//! ```text
//!   order, instant actions ──▶ Vehicle ──▶ commands to the engine
//!   pose, nodes reached    ──▶         ──▶ state, whether it has changed
//! ```

mod cancel;
mod catalogue;
mod check;
mod condition;
mod errors;
mod instant;
mod jobs;
mod order;
mod progress;
mod report;
#[cfg(test)]
mod tests;
mod work;

pub use catalogue::Catalogue;

use core::mem::{replace, take};

use regatta_plugin::command::RouteLeg;
use regatta_plugin::frame::RobotState;

use crate::disturb::{Disturbances, Fate};
use crate::map::Map;
use crate::message::{Load, Version};
use cancel::Cancelling;
use condition::Condition;
use errors::{Cause, Fault, MOST_FAULTS, Until};
use jobs::{Jobs, Paused};
use order::Held;
use progress::Progress;

/// The distance from an end of an edge at which a robot counts as being there, in metres.
const AT_END: f64 = 1e-3;

/// The layout and the abilities that all vehicles of a fleet share.
#[derive(Clone, Debug, Default)]
pub struct Site {
    /// The layout.
    pub map: Map,
    /// The actions that vehicles can carry out.
    pub catalogue: Catalogue,
}

/// The part of a frame about one robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Simulated seconds since the start of the run.
    pub time: f64,
    /// Metres on the map of the layout's file.
    pub x: f64,
    /// Metres on the map of the layout's file.
    pub y: f64,
    /// Radians in (-π, π].
    pub theta: f64,
    /// Metres per second along the edge; negative in reverse gear.
    pub speed: f64,
    /// Metres along the edge from its origin.
    pub s: f64,
    /// Index of the edge.
    pub edge: Option<u32>,
    /// The state of the robot.
    pub state: RobotState,
    /// The charge of its battery in per cent; `None` without a battery.
    pub charge: Option<f64>,
}

/// A command of a vehicle to the engine.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Drop the horizon, and append legs to the base.
    Extend(Vec<RouteLeg>),
    /// Drive to the end of the edge, which this leg leaves, and no further.
    FinishEdge(RouteLeg),
    /// Drop the route beyond the edge.
    Cancel,
    /// Stop, and keep the route.
    Hold,
    /// Go on.
    Resume,
}

/// The wishes of a vehicle: commands and messages.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outbox {
    /// The commands to the engine, in this order.
    pub commands: Vec<Command>,
    /// Whether the state is to be published: something has changed.
    pub state: bool,
    /// Whether the factsheet is to be published.
    pub factsheet: bool,
    /// The time for which its connection is to be lost, in seconds.
    pub silence_secs: Option<f64>,
}

/// A vehicle of the standard.
#[derive(Clone, Debug)]
pub struct Vehicle {
    version: Version,
    seen: Option<Seen>,
    /// The index of the node where it stands.
    here: Option<u32>,
    settling: Settling,
    order: Option<Held>,
    progress: Progress,
    jobs: Jobs,
    instants: Jobs,
    cancelling: Option<Cancelling>,
    paused: Paused,
    loads: Vec<Load>,
    charging: Charging,
    faults: Vec<Fault>,
    condition: Condition,
    fate: Fate,
    /// Whether it needed more base when it was seen last.
    needed_base: bool,
    outbox: Outbox,
}

/// Whether a vehicle has found a node to stand at since its start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Settling {
    #[default]
    Unseen,
    /// It was told to drive to the next node.
    Driving,
    Settled,
}

/// Whether a vehicle was told to charge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Charging {
    Yes,
    #[default]
    No,
}

impl Vehicle {
    /// Creates a vehicle that speaks a version, and that nothing disturbs.
    pub fn new(version: Version) -> Self {
        Self::with_fate(version, Fate::new(&Disturbances::default(), 0))
    }

    /// Creates a vehicle that speaks a version, and what will disturb it.
    pub fn with_fate(version: Version, fate: Fate) -> Self {
        Self {
            version,
            seen: None,
            here: None,
            settling: Settling::default(),
            order: None,
            progress: Progress::default(),
            jobs: Jobs::default(),
            instants: Jobs::default(),
            cancelling: None,
            paused: Paused::default(),
            loads: Vec::new(),
            charging: Charging::default(),
            faults: Vec::new(),
            condition: Condition::default(),
            fate,
            needed_base: false,
            outbox: Outbox::default(),
        }
    }

    /// The version that it speaks.
    pub fn version(&self) -> Version {
        self.version
    }

    /// Takes what it wants to be done since the last call.
    pub fn take_outbox(&mut self) -> Outbox {
        take(&mut self.outbox)
    }

    /// Takes what a frame tells of its robot.
    pub fn see(&mut self, seen: Seen, site: &Site) {
        let before = self.seen.replace(seen);
        if self.paused == Paused::Ending && seen.state != RobotState::Held {
            self.paused = Paused::No;
        }
        self.find_place(before, site);
        self.settle(site);
        if let Some(strike) = self.fate.strike(seen.time) {
            self.be_struck(strike, seen.time);
        }
        self.recover(seen.time, site);
        if before.map(|before| Outline::of(&before)) != Some(Outline::of(&seen)) {
            self.outbox.state = true;
        }
        self.watch_for_breakdown(seen.state);
        let needs_base = self.needs_base(site);
        if replace(&mut self.needed_base, needs_base) != needs_base {
            self.outbox.state = true;
        }
        let seconds = before.map_or(0.0, |before| (seen.time - before.time).max(0.0));
        self.let_time_pass(seconds, site);
        self.end_cancelling();
    }

    /// Finds the node where the robot stands.
    fn find_place(&mut self, before: Option<Seen>, site: &Site) {
        let Some(seen) = self.seen else { return };
        if seen.speed != 0.0 {
            self.here = None;
        } else if self.here.is_none() && seen.state == RobotState::Idle {
            let place = (seen.x, seen.y, seen.edge);
            let stood = before.is_some_and(|before| {
                before.speed == 0.0 && (before.x, before.y, before.edge) == place
            });
            if !stood || before.is_some_and(|before| before.state != RobotState::Idle) {
                self.here = seen.node(&site.map);
            }
        }
    }

    /// Sends a robot to a node if it stands elsewhere at the start: orders begin at nodes.
    fn settle(&mut self, site: &Site) {
        let Some(seen) = self.seen.filter(|_| self.settling != Settling::Settled) else { return };
        match (seen.state, self.here.and_then(|here| site.map.node(here))) {
            (RobotState::Idle, Some(node)) => {
                self.settling = Settling::Settled;
                self.progress.last_node_id.clone_from(&node.id);
                self.outbox.state = true;
            }
            _ if self.settling == Settling::Driving => {}
            (RobotState::Idle, None) => {
                self.settling = Settling::Driving;
                self.outbox.commands.extend(seen.way_out(&site.map).map(Command::FinishEdge));
            }
            _ => {
                self.settling = Settling::Driving;
                self.outbox.commands.push(Command::Cancel);
            }
        }
    }

    fn watch_for_breakdown(&mut self, state: RobotState) {
        let is_known = self.is_broken();
        let is_broken = matches!(state, RobotState::Broken | RobotState::Faulted);
        if is_broken && !is_known {
            self.report(Fault::new(Cause::BrokenDown, "the vehicle is broken"));
        } else if is_known && !is_broken {
            self.forget_faults(Until::Over);
        }
    }

    fn is_broken(&self) -> bool {
        self.faults.iter().any(|fault| fault.cause == Cause::BrokenDown)
    }

    /// Takes that its robot has reached a node, by the node's number in the contract.
    pub fn reached(&mut self, number: u32, site: &Site) {
        let Some(place) = site.map.node_with_number(number) else { return };
        let next = self.progress.steps.front();
        if self.progress.granted == 0 || next.is_none_or(|step| step.place != place) {
            return;
        }
        self.here = Some(place);
        self.progress.traverse(&mut self.jobs);
        self.outbox.state = true;
        self.advance(site);
    }

    /// Takes that the engine has refused to drive on, with the reason.
    pub fn refused(&mut self, reason: &str) {
        let mut fault = Fault::new(Cause::NodeUnreachable, reason);
        if let Some(step) = self.progress.steps.front() {
            fault = fault.about("nodeId", &step.node.node_id).about("edgeId", &step.edge.edge_id);
        }
        self.report(fault);
    }

    /// Whether a new order may begin (3.0: 6.6.8).
    pub fn is_idle(&self) -> bool {
        self.progress.steps.is_empty() && self.jobs.are_over() && self.cancelling.is_none()
    }

    fn is_standing(&self) -> bool {
        self.seen.is_none_or(|seen| seen.speed == 0.0)
    }

    /// Adds an error. One of the same kind about the same takes the place of the earlier one.
    fn report(&mut self, fault: Fault) {
        self.faults
            .retain(|known| (known.cause, &known.references) != (fault.cause, &fault.references));
        self.faults.push(fault);
        if self.faults.len() > MOST_FAULTS {
            self.faults.remove(0);
        }
        self.outbox.state = true;
    }

    fn forget_faults(&mut self, until: Until) {
        self.faults.retain(|fault| fault.until() != until);
        self.outbox.state = true;
    }
}

/// The parts of what is seen whose changes are published at once.
#[derive(PartialEq)]
struct Outline {
    driving: bool,
    held: bool,
}

impl Outline {
    fn of(seen: &Seen) -> Self {
        Self { driving: seen.is_driving(), held: seen.state == RobotState::Held }
    }
}

impl Seen {
    /// Whether the robot drives, or turns on the spot.
    fn is_driving(&self) -> bool {
        self.speed != 0.0 || self.state == RobotState::Turning
    }

    /// The node where a robot stands.
    fn node(&self, map: &Map) -> Option<u32> {
        let Some(road) = self.edge.and_then(|edge| map.edge(edge)) else {
            return map.node_at(self.x, self.y);
        };
        if self.s >= road.length - AT_END {
            Some(road.destination)
        } else {
            (self.s <= AT_END).then_some(road.origin)
        }
    }

    /// A leg that leaves the edge of a robot at its end.
    fn way_out(&self, map: &Map) -> Option<RouteLeg> {
        let road = map.edge(self.edge?)?;
        map.route_leg(map.exit(road.destination)?)
    }
}
