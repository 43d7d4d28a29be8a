//! Robots that stall, are broken or have a flat battery: they stop as for a hold, keep their
//! routes, and go on afterwards.

use regatta_plugin::event::{BreakdownCause, EventKind, EventRecord};
use regatta_plugin::frame::RobotState;

use super::{EventBuffer, Fleet, Route};

/// The reasons besides its commands for which a robot doesn't drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Impairment {
    is_stalled: bool,
    is_broken: bool,
    is_flat: bool,
    /// Whether it is held, too.
    pub is_held: bool,
}

impl Fleet {
    /// Makes a robot stall until it [recovers](Self::recover). Nothing happens to a robot that
    /// isn't there.
    pub fn stall(&mut self, robot: u32, events: &mut EventBuffer) {
        self.impair(robot, event(EventKind::Stalled, robot), events, |impairment| {
            &mut impairment.is_stalled
        });
    }

    /// Ends a stall.
    pub fn recover(&mut self, robot: u32, events: &mut EventBuffer) {
        self.restore(robot, EventKind::Recovered, events, |impairment| &mut impairment.is_stalled);
    }

    /// Makes a robot break down until it is [repaired](Self::repair). Nothing happens to a robot
    /// that isn't there.
    pub fn break_down(&mut self, robot: u32, events: &mut EventBuffer) {
        self.impair(robot, event(EventKind::BrokenDown, robot), events, |impairment| {
            &mut impairment.is_broken
        });
    }

    /// Repairs a robot that is broken.
    pub fn repair(&mut self, robot: u32, events: &mut EventBuffer) {
        self.restore(robot, EventKind::Repaired, events, |impairment| &mut impairment.is_broken);
    }

    /// Stops a robot because its battery is flat. It is broken until it has
    /// [energy](Self::end_flat) again.
    pub(super) fn run_flat(&mut self, robot: u32, events: &mut EventBuffer) {
        let detail = BreakdownCause::FlatBattery as u32;
        let event = EventRecord { detail, ..event(EventKind::BrokenDown, robot) };
        self.impair(robot, event, events, |impairment| &mut impairment.is_flat);
    }

    /// Lets a robot go on that was flat.
    pub(super) fn end_flat(&mut self, robot: u32, events: &mut EventBuffer) {
        self.restore(robot, EventKind::Repaired, events, |impairment| &mut impairment.is_flat);
    }

    /// Whether a robot is broken because its battery is flat.
    pub(super) fn is_flat(&self, robot: u32) -> bool {
        self.impairments.get(&robot).is_some_and(|impairment| impairment.is_flat)
    }

    fn impair(
        &mut self,
        robot: u32,
        event: EventRecord,
        events: &mut EventBuffer,
        flag: fn(&mut Impairment) -> &mut bool,
    ) {
        let Ok(row) = self.row(robot) else { return };
        let is_held = self.is(row, RobotState::Held);
        let impairment = self
            .impairments
            .entry(robot)
            .or_insert(Impairment { is_held, ..Impairment::default() });
        if std::mem::replace(flag(impairment), true) {
            return;
        }
        let state = impairment.state();
        self.keep_idle(row);
        events.push_record(event);
        self.motion.impair(&mut self.columns.all_rows(), row, state);
    }

    fn restore(
        &mut self,
        robot: u32,
        event: EventKind,
        events: &mut EventBuffer,
        flag: fn(&mut Impairment) -> &mut bool,
    ) {
        let (Ok(row), Some(impairment)) = (self.row(robot), self.impairments.get_mut(&robot))
        else {
            return;
        };
        if !std::mem::replace(flag(impairment), false) {
            return;
        }
        let impairment = *impairment;
        events.push_kind(event, robot, 0);
        if impairment.is_stalled || impairment.is_broken || impairment.is_flat {
            return self.motion.impair(&mut self.columns.all_rows(), row, impairment.state());
        }
        self.impairments.remove(&robot);
        if impairment.is_held {
            self.motion.hold(&mut self.columns.all_rows(), row, events);
        } else {
            self.go_on(row, events);
        }
    }

    /// Makes a robot that was held or impaired follow its route again.
    pub(super) fn go_on(&mut self, row: usize, events: &mut EventBuffer) {
        if self.columns.route[row] == Route::PARKED {
            self.columns.state[row] = RobotState::Idle as u8;
        } else {
            self.motion.start_driving(&mut self.columns.all_rows(), row, events);
        }
    }

    /// An idle robot that is held or impaired is idle afterwards.
    pub(super) fn keep_idle(&mut self, row: usize) {
        if self.is(row, RobotState::Idle) {
            self.set_route(row, |_| Route::PARKED);
        }
    }

    /// Whether a robot may not drive: it is held, stalled or broken.
    pub(super) fn is_stopped(&self, row: usize) -> bool {
        RobotState::from_number(self.columns.state[row]).is_stopped()
    }
}

impl Impairment {
    fn state(self) -> regatta_motion::RobotState {
        use regatta_motion::RobotState;
        if self.is_broken || self.is_flat { RobotState::Broken } else { RobotState::Stalled }
    }
}

fn event(kind: EventKind, robot: u32) -> EventRecord {
    EventRecord { kind: kind as u32, robot, ..EventRecord::default() }
}
