//! The meter: orders and effort by period.

use regatta_plugin::activity::Activity;
use regatta_plugin::column::ACTIVITY;
use regatta_plugin::frame::{Columns, RobotState};
use regatta_plugin::order::OrderRecord;
use serde::{Deserialize, Serialize};

use crate::orders::{
    Finished, Hindrance, Now, Orders, Robot, RobotWork, StopWait, Unfinished, Unplaced,
};

/// The length of a period, in simulated seconds.
pub const PERIOD_SECS: f64 = 10.0;

/// The effort of all robots in a period.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Effort {
    /// Robot seconds.
    pub robot_secs: f64,
    /// Robot seconds with an order.
    pub ordered_secs: f64,
    /// Robot seconds in which robots stand and wait for room to drive on, for a route, a door or a
    /// lift.
    pub waiting_secs: f64,
    /// Robot seconds of robots with an order and without a load that don't wait.
    #[serde(default)]
    pub empty_secs: f64,
    /// Those with a load.
    #[serde(default)]
    pub loaded_secs: f64,
    /// Those at a stop, where they wait for an operator, for a place, or until it opens, and those
    /// in queues before stops.
    #[serde(default)]
    pub station_secs: f64,
    /// Those at a stop, where they are served.
    #[serde(default)]
    pub handling_secs: f64,
    /// Robot seconds without an order at a charger, or on the way to one.
    #[serde(default)]
    pub charging_secs: f64,
    /// Robot seconds without an order in which robots wait off the roads until there is room.
    #[serde(default)]
    pub parked_secs: f64,
    /// Robot seconds in which robots are held, broken, faulted or stalled.
    #[serde(default)]
    pub down_secs: f64,
    /// All other robot seconds: nothing was to be done, or robots drove without an order.
    #[serde(default)]
    pub idle_secs: f64,
    /// Metres driven with a load.
    pub loaded_metres: f64,
    /// Metres driven without a load.
    pub empty_metres: f64,
}

impl Effort {
    /// Adds another one.
    pub fn add(&mut self, other: &Self) {
        self.robot_secs += other.robot_secs;
        self.ordered_secs += other.ordered_secs;
        self.waiting_secs += other.waiting_secs;
        self.empty_secs += other.empty_secs;
        self.loaded_secs += other.loaded_secs;
        self.station_secs += other.station_secs;
        self.handling_secs += other.handling_secs;
        self.charging_secs += other.charging_secs;
        self.parked_secs += other.parked_secs;
        self.down_secs += other.down_secs;
        self.idle_secs += other.idle_secs;
        self.loaded_metres += other.loaded_metres;
        self.empty_metres += other.empty_metres;
    }

    /// Returns the part that the time of a robot up to a tick belongs to.
    fn part(
        &mut self,
        hindrance: Hindrance,
        work: RobotWork,
        activity: Option<Activity>,
        tick: u64,
    ) -> &mut f64 {
        match (work.orders > 0, activity) {
            _ if hindrance == Hindrance::Traffic && work.is_queued => &mut self.station_secs,
            _ if hindrance == Hindrance::Traffic => &mut self.waiting_secs,
            _ if hindrance == Hindrance::Down => &mut self.down_secs,
            (true, _) if work.at_stops > 0 && tick <= work.served_from => &mut self.station_secs,
            (true, _) if work.at_stops > 0 => &mut self.handling_secs,
            (true, _) if work.loads > 0 => &mut self.loaded_secs,
            (true, _) => &mut self.empty_secs,
            (false, Some(Activity::Charging)) => &mut self.charging_secs,
            (false, Some(Activity::Queued)) => &mut self.parked_secs,
            (false, _) => &mut self.idle_secs,
        }
    }
}

/// The figures of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// Simulated time of the last frame, in seconds.
    pub secs: f64,
    /// Robots in the last frame.
    pub robots: u64,
    /// The length of a period, in simulated seconds.
    pub period_secs: f64,
    /// The length of a tick, in simulated seconds.
    #[serde(default)]
    pub tick_secs: f64,
    /// By period.
    pub effort: Vec<Effort>,
    /// Finished orders, in the order in which they were finished.
    pub finished: Vec<Finished>,
    /// The waiting at stops, by ascending node; none in figures of an earlier version.
    #[serde(default)]
    pub stops: Vec<StopWait>,
    /// Orders that aren't over.
    pub open: u64,
    /// These orders; none in figures of an earlier version.
    #[serde(default)]
    pub unfinished: Vec<Unfinished>,
    /// Those that wait for a place of a storage, by storage.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unplaced: Vec<Unplaced>,
    /// Orders that the fleet manager has given up.
    pub failed: u64,
    /// Orders that were cancelled.
    pub cancelled: u64,
    /// Samples of the order log that were missed: then orders are missing.
    pub samples_missed: u64,
}

/// Measures a run.
#[derive(Clone, Debug, Default)]
pub struct Meter {
    run_id: u64,
    tick_secs: f64,
    /// The last frame.
    now: Now,
    robots: u64,
    effort: Vec<Effort>,
    orders: Orders,
    /// By robot: whether it stood in the last frame.
    stood: Vec<bool>,
    /// The robots whose hindrances change in a frame.
    turns: Vec<(u32, Hindrance)>,
    samples_missed: u64,
    /// Whether a sample of the order log has come.
    has_begun: bool,
}

impl Meter {
    /// Begins a run with ticks of a length in seconds, unless it is the present one.
    pub fn begin(&mut self, run_id: u64, tick_secs: f64) {
        if self.run_id != run_id {
            *self = Self { run_id, tick_secs, ..Self::default() };
        }
    }

    fn now(&self, tick: u64) -> Now {
        Now { tick, secs: tick as f64 * self.tick_secs }
    }

    /// Takes the records of a tick, and the number of samples that are missing before them.
    /// `sequence` is the number of the sample in the run, from 1.
    pub fn take_orders(&mut self, records: &[OrderRecord], sequence: u64, missed: u64, tick: u64) {
        let now = self.now(tick);
        // Samples published before the meter joined the log don't count as missing, but are
        // unknown.
        let joined_late = !std::mem::replace(&mut self.has_begun, true) && missed == 0;
        self.samples_missed += if joined_late { sequence.saturating_sub(1) } else { missed };
        for record in records {
            self.orders.take(record, now);
        }
    }

    /// Takes the frame of a tick. It covers the time since the previous frame. `activities` are
    /// those of robots by id, as far as their manager publishes them.
    pub fn take_frame(&mut self, columns: &Columns<'_>, activities: &[f32], tick: u64) {
        let now = self.now(tick);
        let before = std::mem::replace(&mut self.now, now);
        let secs = (now.secs - before.secs).max(0.0);
        let effort = self.effort(columns, activities, secs);
        for (robot, hindrance) in self.turns.drain(..) {
            self.orders.hinder(robot, hindrance, before.tick);
        }
        self.add(&effort, now.secs);
    }

    /// Returns the effort of a frame that stands for some seconds. Counts the robots, and notes
    /// those whose hindrances change.
    fn effort(&mut self, columns: &Columns<'_>, activities: &[f32], secs: f64) -> Effort {
        let mut effort = Effort::default();
        self.robots = 0;
        self.stood.resize(columns.state.len(), false);
        let mut robot_of = self.orders.robots_in_turn();
        for (robot, (&state, &speed)) in (0..).zip(columns.state.iter().zip(columns.speed)) {
            let Robot { work, hindrance: before } = robot_of(robot);
            let stands = stands(state, speed);
            // In the time of a frame in which it comes to stand, it has driven.
            let has_stood = std::mem::replace(&mut self.stood[robot as usize], stands);
            let waits = stands && has_stood && waits(state, work);
            let activity = activities.get(robot as usize).and_then(|it| ACTIVITY.element(*it));
            let hindrance = hindrance(waits, state, activity);
            if hindrance != before {
                self.turns.push((robot, hindrance));
            }
            if state == RobotState::Absent as u8 {
                continue;
            }
            self.robots += 1;
            *effort.part(hindrance, work, activity, self.now.tick) += secs;
            effort.ordered_secs += if work.orders > 0 { secs } else { 0.0 };
            let metres = f64::from(speed.abs()) * secs;
            if work.loads > 0 {
                effort.loaded_metres += metres;
            } else {
                effort.empty_metres += metres;
            }
        }
        effort.robot_secs = self.robots as f64 * secs;
        effort
    }

    /// Adds an effort to the period in which it ends.
    fn add(&mut self, effort: &Effort, now_secs: f64) {
        // A frame at the end of a period belongs to it.
        let period = ((now_secs / PERIOD_SECS).ceil() as usize).saturating_sub(1);
        self.effort.resize(self.effort.len().max(period + 1), Effort::default());
        self.effort[period].add(effort);
    }

    /// Returns the figures so far.
    pub fn figures(&self) -> Figures {
        let Orders { finished, failed, cancelled, .. } = &self.orders;
        Figures {
            secs: self.now.secs,
            robots: self.robots,
            period_secs: PERIOD_SECS,
            tick_secs: self.tick_secs,
            effort: self.effort.clone(),
            finished: finished.clone(),
            stops: self.orders.waits(),
            open: self.orders.open() as u64,
            unfinished: self.orders.unfinished(self.now.secs),
            unplaced: self.orders.unplaced(),
            failed: *failed,
            cancelled: *cancelled,
            samples_missed: self.samples_missed,
        }
    }
}

/// Whether a robot stands, at the end of its released base or without a route.
fn stands(state: u8, speed: f32) -> bool {
    state == RobotState::Waiting as u8 || (state == RobotState::Idle as u8 && speed == 0.0)
}

/// The hindrance of a robot; `waits` tells whether it waits for room. `published` is its activity
/// as its manager tells it.
fn hindrance(waits: bool, state: u8, published: Option<Activity>) -> Hindrance {
    let own = Activity::of_state(RobotState::from_number(state));
    match own {
        _ if waits => Hindrance::Traffic,
        None => Hindrance::None,
        Some(own) if !own.can_move() => Hindrance::Down,
        Some(_) if published.is_some_and(|known| !known.can_move()) => Hindrance::Down,
        Some(_) => Hindrance::None,
    }
}

/// Whether a robot that stands waits for room: for the release of its route, or for a route
/// although it has an order and isn't at a stop.
fn waits(state: u8, work: RobotWork) -> bool {
    state == RobotState::Waiting as u8 || (work.orders > 0 && work.at_stops == 0)
}

#[cfg(test)]
mod tests {
    use regatta_plugin::order::{OrderKind, StopAction};

    use super::*;

    fn columns<'a>(speed: &'a [f32], state: &'a [u8]) -> Columns<'a> {
        Columns { x: speed, y: speed, theta: speed, speed, s: speed, edge: &[], state }
    }

    #[test]
    fn effort_is_kept_by_period_and_by_load() {
        let mut meter = Meter::default();
        meter.begin(1, 0.5);
        let states =
            [RobotState::Driving as u8, RobotState::Waiting as u8, RobotState::Absent as u8];
        let speeds = [2.0, 0.0, 9.0];
        meter.take_frame(&columns(&speeds, &states), &[], 0);
        let of = |kind| OrderRecord::new(1, kind).of_robot(0);
        meter.take_orders(&[of(OrderKind::Created), of(OrderKind::Assigned)], 1, 0, 0);
        meter.take_frame(&columns(&speeds, &states), &[], 10);
        meter.take_orders(&[of(OrderKind::Handled).at_stop(0, 1, StopAction::Pick)], 2, 0, 10);
        meter.take_frame(&columns(&speeds, &states), &[], 20);
        meter.take_frame(&columns(&speeds, &states), &[], 24);
        let first = Effort {
            robot_secs: 20.0,
            ordered_secs: 10.0,
            waiting_secs: 10.0,
            empty_secs: 5.0,
            loaded_secs: 5.0,
            loaded_metres: 10.0,
            empty_metres: 10.0,
            ..Effort::default()
        };
        let second = Effort {
            robot_secs: 4.0,
            ordered_secs: 2.0,
            waiting_secs: 2.0,
            loaded_secs: 2.0,
            loaded_metres: 4.0,
            ..Effort::default()
        };
        let figures = meter.figures();
        assert_eq!(figures.effort, [first, second]);
        assert_eq!((figures.robots, figures.open, figures.secs), (2, 1, 12.0));
        assert_eq!(figures.samples_missed, 0);
        meter.begin(2, 0.5);
        assert_eq!(meter.figures().effort, []);
        meter.take_orders(&[of(OrderKind::Assigned)], 4, 0, 2);
        assert_eq!(meter.figures().samples_missed, 3, "it came too late for three");
    }

    #[test]
    fn a_robot_that_arrives_and_goes_on_at_once_never_waits() {
        let mut meter = Meter::default();
        meter.begin(1, 0.1);
        let of = |kind| OrderRecord::new(1, kind).of_robot(0);
        meter.take_orders(&[of(OrderKind::Created), of(OrderKind::Assigned)], 1, 0, 0);
        let (drives, idle, waits) = (RobotState::Driving, RobotState::Idle, RobotState::Waiting);
        // It comes to a stop, drives on, and then waits from tick 3 to tick 5.
        let frames = [drives, idle, drives, waits, waits, waits, drives];
        for (tick, state) in (0..).zip(frames) {
            let speed = if state == drives { 1.0 } else { 0.0 };
            meter.take_frame(&columns(&[speed], &[state as u8]), &[], tick);
        }
        let waiting_secs = meter.figures().effort[0].waiting_secs;
        assert!((waiting_secs - 0.2).abs() < 1e-9, "{waiting_secs}");
    }

    #[test]
    fn figures_are_the_same_after_a_file() {
        let finished = vec![Finished {
            at_secs: 1.1,
            service_secs: 0.3,
            due_secs: Some(0.2),
            ..Finished::default()
        }];
        let figures = Figures {
            finished,
            effort: vec![Effort { robot_secs: 0.1, ..Effort::default() }],
            ..Figures::default()
        };
        let text = serde_json::to_string(&figures).expect("JSON");
        assert_eq!(serde_json::from_str::<Figures>(&text).expect("figures"), figures);
    }
}
