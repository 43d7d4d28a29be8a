//! A door's leaf: it opens and closes within its times.

use regatta_layout::DoorTimes;
use regatta_plugin::facility::{DoorState, FacilityState};

/// A leaf that is open, closed, or moves evenly between the two.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf {
    state: DoorState,
    /// The tick in which its motion or its rest began.
    since: u64,
    /// In ticks; at least 1.
    opening: u32,
    closing: u32,
}

impl Leaf {
    /// Makes a closed leaf.
    pub fn new(times: DoorTimes, tick_secs: f64) -> Self {
        let [opening, closing] =
            [times.opening_secs, times.closing_secs].map(|secs| whole_ticks(secs, tick_secs));
        Self { state: DoorState::Closed, since: 0, opening, closing }
    }

    pub fn state(&self) -> DoorState {
        self.state
    }

    pub fn is_open(&self) -> bool {
        self.state == DoorState::Open
    }

    /// Opens it without motion, before the first tick.
    pub fn set_open(&mut self) {
        self.state = DoorState::Open;
    }

    /// Lets it open, unless it is open or opening.
    pub fn open(&mut self, tick: u64) {
        let part_open = match self.state {
            DoorState::Open | DoorState::Opening => return,
            DoorState::Closed => 0.0,
            DoorState::Closing => 1.0 - self.progress(tick),
        };
        self.turn(DoorState::Opening, tick, part_open);
    }

    /// Lets it close, unless it is closed or closing.
    pub fn close(&mut self, tick: u64) {
        let part_closed = match self.state {
            DoorState::Closed | DoorState::Closing => return,
            DoorState::Open => 0.0,
            DoorState::Opening => 1.0 - self.progress(tick),
        };
        self.turn(DoorState::Closing, tick, part_closed);
    }

    /// Ends a motion that is over. Returns whether one was.
    pub fn step(&mut self, tick: u64) -> bool {
        let is_over = self.duration() > 0 && tick >= self.since + u64::from(self.duration());
        if is_over {
            self.state = match self.state {
                DoorState::Opening => DoorState::Open,
                _ => DoorState::Closed,
            };
            self.since = tick;
        }
        is_over
    }

    /// Writes its state to a record.
    pub fn describe(&self, state: FacilityState) -> FacilityState {
        let (since_tick, ticks) = (self.since, self.duration());
        FacilityState { since_tick, ticks, door: self.state as u32, ..state }
    }

    /// Begins a motion of which a part is done already.
    fn turn(&mut self, state: DoorState, tick: u64, done: f64) {
        self.state = state;
        self.since = tick.saturating_sub((f64::from(self.duration()) * done) as u64);
    }

    fn progress(&self, tick: u64) -> f64 {
        let passed = tick.saturating_sub(self.since) as f64;
        (passed / f64::from(self.duration().max(1))).min(1.0)
    }

    /// Returns the ticks of its motion; 0 at rest.
    fn duration(&self) -> u32 {
        match self.state {
            DoorState::Closed | DoorState::Open => 0,
            DoorState::Opening => self.opening,
            DoorState::Closing => self.closing,
        }
    }
}

/// Returns a time in ticks, at least 1.
pub(super) fn whole_ticks(secs: f64, tick_secs: f64) -> u32 {
    (secs / tick_secs).round().max(1.0) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn leaf() -> Leaf {
        Leaf::new(DoorTimes { opening_secs: 1.0, closing_secs: 2.0 }, 0.1)
    }

    #[test]
    fn it_takes_its_times() {
        let mut leaf = leaf();
        leaf.open(5);
        let opened = (5..100).find(|tick| leaf.step(*tick));
        assert_eq!((opened, leaf.state()), (Some(15), DoorState::Open));
        leaf.close(20);
        assert_eq!((20..100).find(|tick| leaf.step(*tick)), Some(40));
        assert_eq!(leaf.state(), DoorState::Closed);
    }

    #[test]
    fn a_leaf_that_turns_back_needs_only_the_way_that_it_has_come() {
        let mut leaf = leaf();
        leaf.open(0);
        assert_eq!((0..=10).find(|tick| leaf.step(*tick)), Some(10));
        leaf.close(10);
        leaf.open(15);
        assert_eq!((15..100).find(|tick| leaf.step(*tick)), Some(18), "a quarter of the way");
        leaf.close(20);
        leaf.open(20);
        assert!(leaf.step(20), "it hasn't moved");
    }
}
