//! Conditions in which a vehicle doesn't do what its master wants.

use super::errors::{Cause, Fault, Until};
use super::jobs::Paused;
use super::order::End;
use super::{Command, Site, Vehicle};
use crate::disturb::{Kind, Strike};
use crate::message::{EmergencyStop, OperatingMode, SafetyState};

/// Whether a vehicle can do what its master wants.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Condition {
    #[default]
    Well,
    /// An operator drives it until a simulated time, and to a node.
    Operated { until: f64 },
    /// Its safety devices stop it until a simulated time.
    Stopped { until: f64 },
    /// It doesn't know where it is until a simulated time.
    Lost { until: f64 },
}

impl Condition {
    pub(super) fn operating_mode(self) -> OperatingMode {
        match self {
            Self::Operated { .. } => OperatingMode::Manual,
            _ => OperatingMode::Automatic,
        }
    }

    pub(super) fn safety_state(self) -> SafetyState {
        let active_emergency_stop = match self {
            Self::Stopped { .. } => EmergencyStop::AutoAcknowledged,
            _ => EmergencyStop::None,
        };
        SafetyState { active_emergency_stop, field_violation: false }
    }

    pub(super) fn is_localized(self) -> bool {
        !matches!(self, Self::Lost { .. })
    }

    /// Whether the vehicle must not move, whatever its master wants.
    pub(super) fn holds(self) -> bool {
        matches!(self, Self::Stopped { .. } | Self::Lost { .. })
    }

    /// The reason why no new order can begin.
    pub(super) fn refusal(self) -> Option<&'static str> {
        match self {
            Self::Operated { .. } => Some("an operator drives the vehicle"),
            Self::Lost { .. } => Some("the vehicle doesn't know where it is"),
            Self::Well | Self::Stopped { .. } => None,
        }
    }
}

impl Vehicle {
    /// Lets a disturbance begin at a simulated time, unless there is one already.
    pub(super) fn be_struck(&mut self, strike: Strike, time: f64) {
        if strike.kind == Kind::LostConnections {
            self.outbox.silence_secs = Some(strike.secs);
            return;
        }
        if self.condition != Condition::Well || self.cancelling.is_some() {
            return;
        }
        let until = time + strike.secs;
        self.condition = match strike.kind {
            Kind::ManualMode => Condition::Operated { until },
            Kind::EmergencyStops => Condition::Stopped { until },
            Kind::LostPositions => Condition::Lost { until },
            _ => return,
        };
        match self.condition {
            Condition::Operated { .. } => self.give_up_order(),
            Condition::Lost { .. } => {
                let reason = "the vehicle doesn't know where it is";
                self.report(Fault::new(Cause::NotLocalized, reason));
            }
            Condition::Well | Condition::Stopped { .. } => {}
        }
        if self.condition.holds() {
            self.outbox.commands.push(Command::Hold);
        }
        self.outbox.state = true;
    }

    /// Clears the order, as the standard has it for the mode MANUAL (2.x: 6.10.6; 3.0: 6.6.7). The
    /// operator drives on to the end of the edge.
    fn give_up_order(&mut self) {
        if self.paused == Paused::Yes {
            self.paused = Paused::Ending;
            self.outbox.commands.push(Command::Resume);
        }
        self.jobs.fail_all();
        if !self.progress.steps.is_empty() {
            self.outbox.commands.push(Command::Cancel);
        }
        self.progress.clear();
        if let Some(held) = &mut self.order {
            held.end = End::Cancelled;
        }
    }

    /// Ends a condition whose time is over.
    pub(super) fn recover(&mut self, time: f64, site: &Site) {
        let is_over = match self.condition {
            Condition::Well => return,
            // It is given back where it can begin an order.
            Condition::Operated { until } => time >= until && self.here.is_some(),
            Condition::Stopped { until } | Condition::Lost { until } => time >= until,
        };
        if !is_over {
            return;
        }
        if self.condition.holds() && self.paused != Paused::Yes {
            self.outbox.commands.push(Command::Resume);
        }
        if let Some(node) = self.here.and_then(|here| site.map.node(here)) {
            self.progress.last_node_id.clone_from(&node.id);
        }
        self.condition = Condition::Well;
        if !self.is_broken() {
            self.forget_faults(Until::Over);
        }
        self.faults.retain(|fault| fault.cause != Cause::NotLocalized);
        self.outbox.state = true;
    }
}
