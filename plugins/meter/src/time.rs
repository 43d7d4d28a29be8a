//! The time of orders and robots, by what it is spent on.
//!
//! Each tick of an order belongs to exactly one part, so that the parts add up to its time from its
//! creation to its end, to the tick.

use serde::{Deserialize, Serialize};

/// A part of an order's time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Phase {
    /// It has no robot.
    #[default]
    Assignment,
    /// Its robot drives or turns without its load.
    Empty,
    /// Its robot drives or turns with its load.
    Loaded,
    /// Its robot waits for room, a route, a door or a lift.
    Traffic,
    /// Its robot is at a stop, and waits to be served; or in a queue before it.
    Station,
    /// Its robot is at a stop, and is served.
    Handling,
    /// Its robot is held, broken, faulted or stalled.
    Down,
    /// It has no robot yet, because a storage has no place for it.
    Storage,
}

/// The number of the parts of an order's time.
pub const PARTS: usize = 8;

/// The parts of an order's time, in ticks. Files of earlier versions lack the last ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "Vec<u64>", into = "[u64; PARTS]")]
pub struct Parts {
    /// Without a robot.
    pub assignment: u64,
    /// On the way without the load.
    pub empty: u64,
    /// On the way with the load.
    pub loaded: u64,
    /// Waiting for room, a route, a door or a lift.
    pub traffic: u64,
    /// Waiting at stops for an operator, for a place, or until they open; or in queues before them.
    pub station: u64,
    /// At stops, served.
    pub handling: u64,
    /// With a robot that is held, broken, faulted or stalled.
    pub down: u64,
    /// Waiting for a place of a storage.
    pub storage: u64,
}

impl From<Vec<u64>> for Parts {
    fn from(ticks: Vec<u64>) -> Self {
        let mut parts = [0; PARTS];
        for (part, ticks) in parts.iter_mut().zip(ticks) {
            *part = ticks;
        }
        let [assignment, empty, loaded, traffic, station, handling, down, storage] = parts;
        Self { assignment, empty, loaded, traffic, station, handling, down, storage }
    }
}

impl From<Parts> for [u64; PARTS] {
    fn from(parts: Parts) -> Self {
        let Parts { assignment, empty, loaded, traffic, station, handling, down, storage } = parts;
        [assignment, empty, loaded, traffic, station, handling, down, storage]
    }
}

impl Parts {
    /// The sum.
    pub fn total(&self) -> u64 {
        <[u64; PARTS]>::from(*self).iter().sum()
    }

    fn of(&mut self, phase: Phase) -> &mut u64 {
        match phase {
            Phase::Assignment => &mut self.assignment,
            Phase::Empty => &mut self.empty,
            Phase::Loaded => &mut self.loaded,
            Phase::Traffic => &mut self.traffic,
            Phase::Station => &mut self.station,
            Phase::Handling => &mut self.handling,
            Phase::Down => &mut self.down,
            Phase::Storage => &mut self.storage,
        }
    }
}

/// The time of an order so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OrderClock {
    parts: Parts,
    /// The tick up to which it is counted.
    counted: u64,
    /// The phase since then.
    phase: Phase,
}

impl OrderClock {
    /// Starts at the tick of an order's creation.
    pub fn new(tick: u64) -> Self {
        Self { counted: tick, ..Self::default() }
    }

    /// Turns to a phase that began at a tick, or at the last event if that was later.
    pub fn turn(&mut self, phase: Phase, tick: u64) {
        *self.parts.of(self.phase) += tick.saturating_sub(self.counted);
        (self.counted, self.phase) = (self.counted.max(tick), phase);
    }

    /// Ends a phase at a tick and begins another one, if it is the present one.
    pub fn end(&mut self, phase: Phase, next: Phase, tick: u64) {
        if self.phase == phase {
            self.turn(next, tick);
        }
    }

    /// Counts the ticks up to an event as the present phase. An event before the present phase
    /// takes ticks back.
    pub fn stop_at(&mut self, tick: u64) -> Parts {
        self.turn(self.phase, tick);
        let part = self.parts.of(self.phase);
        *part = part.saturating_sub(self.counted - tick);
        self.counted = tick;
        self.parts
    }

    /// Begins a phase at an event.
    pub fn begin(&mut self, phase: Phase, tick: u64) {
        self.stop_at(tick);
        self.phase = phase;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_tick_belongs_to_one_part() {
        let mut clock = OrderClock::new(10);
        clock.begin(Phase::Empty, 14);
        clock.turn(Phase::Traffic, 15);
        clock.begin(Phase::Handling, 20);
        // The frame in which the robot waits no more has come later than the event.
        clock.turn(Phase::Handling, 18);
        let parts = clock.stop_at(27);
        let expected =
            Parts { assignment: 4, empty: 1, traffic: 5, handling: 7, ..Parts::default() };
        assert_eq!((parts, parts.total()), (expected, 17));
        let text = serde_json::to_string(&parts).expect("JSON");
        assert_eq!(text, "[4,1,0,5,0,7,0,0]");
        for text in [&*text, "[4,1,0,5,0,7,0]"] {
            assert_eq!(serde_json::from_str::<Parts>(text).expect("parts"), parts);
        }
    }

    #[test]
    fn an_event_before_the_present_phase_takes_ticks_back() {
        let mut clock = OrderClock::new(0);
        clock.begin(Phase::Empty, 2);
        clock.turn(Phase::Traffic, 6);
        clock.turn(Phase::Empty, 10);
        clock.turn(Phase::Traffic, 12);
        assert_eq!(
            clock.stop_at(11),
            Parts { assignment: 2, empty: 6, traffic: 3, ..Parts::default() }
        );
    }
}
