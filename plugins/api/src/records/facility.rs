//! The states of facilities: the doors and lifts of the world. The producer publishes all of them
//! on `regatta/F/facilities` with every change, so that a process that joins later knows them, too.

use bytemuck::{Pod, Zeroable};
#[cfg(feature = "shared-memory")]
use iceoryx2::prelude::ZeroCopySend;

use super::order::NO_ROBOT;
use super::sequence::Sequenced;

/// The iceoryx2 user header of `regatta/F/facilities`. The payload is a [`FacilityState`] for each
/// door of the world, then one for each lift.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_FacilityHeader"))]
pub struct FacilityHeader {
    /// The run that the tick belongs to.
    pub run_id: u64,
    /// The tick in which they changed.
    pub tick: u64,
    /// Counts the samples of the run, from 1. The publisher fills it in.
    pub sequence: u64,
}

/// The state of a door or a lift.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_FacilityState"))]
pub struct FacilityState {
    /// The tick in which its present motion, or its rest, began.
    pub since_tick: u64,
    /// The ticks that the motion takes; 0 at rest.
    pub ticks: u32,
    /// A [`FacilityKind`].
    pub kind: u32,
    /// Index among the doors or the lifts of the world.
    pub index: u32,
    /// A [`DoorState`]: that of the door, or of the doors of the lift.
    pub door: u32,
    /// Lift: the level where the cabin is or which it is leaving, as an index of the lift's levels.
    pub level: u32,
    /// Lift: the level that the cabin is coming to; `level` while it stands.
    pub next_level: u32,
    /// Lift: the level that it was called to; `level` if it wasn't called elsewhere.
    pub called_level: u32,
    /// The robot for which it was requested; [`NO_ROBOT`] without a request, and for that of an
    /// operator. A door may be requested for several: one of them.
    pub robot: u32,
    /// Number of requests.
    pub requests: u32,
    /// Zero.
    pub reserved: u32,
}

impl Default for FacilityState {
    fn default() -> Self {
        Self { robot: NO_ROBOT, ..Self::zeroed() }
    }
}

numbered! {
    /// Kinds of [`FacilityState`].
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
    pub enum FacilityKind: u32 {
        /// A door.
        Door = 0,
        /// A lift.
        Lift = 1,
    }
}

numbered! {
    /// The state of a door. Robots pass open doors only.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum DoorState: u32 {
        /// It is closed.
        #[default]
        Closed = 0,
        /// It is opening.
        Opening = 1,
        /// It is open.
        Open = 2,
        /// It is closing.
        Closing = 3,
    }
}

impl DoorState {
    /// The word, in lower case.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Closed => "closed",
            Self::Opening => "opening",
            Self::Open => "open",
            Self::Closing => "closing",
        }
    }
}

impl FacilityState {
    /// Its kind; `None` if a later version of the contract has added it.
    pub fn kind(&self) -> Option<FacilityKind> {
        FacilityKind::from_number(self.kind)
    }

    /// The state of its door. An unknown number counts as closed.
    pub fn door(&self) -> DoorState {
        DoorState::from_number(self.door).unwrap_or_default()
    }

    /// Whether the cabin is between two levels.
    pub const fn is_moving(&self) -> bool {
        self.level != self.next_level
    }

    /// The part of its present motion that is done at a tick, from 0 to 1; 1 at rest.
    pub fn progress(&self, tick: u64) -> f32 {
        if self.ticks == 0 {
            return 1.0;
        }
        let passed = tick.saturating_sub(self.since_tick);
        (passed as f32 / self.ticks as f32).min(1.0)
    }

    /// The part by which its door is open at a tick, from 0 to 1.
    pub fn openness(&self, tick: u64) -> f32 {
        match self.door() {
            DoorState::Closed => 0.0,
            DoorState::Opening => self.progress(tick),
            DoorState::Open => 1.0,
            DoorState::Closing => 1.0 - self.progress(tick),
        }
    }

    /// The state in words: `open`, `at L1, closing`, `from L1 to L2`. `level` names a level.
    pub fn words<'name>(&self, level: impl Fn(u32) -> &'name str) -> String {
        let door = self.door().name();
        match self.kind() {
            Some(FacilityKind::Lift) if self.is_moving() => {
                format!("from {} to {}", level(self.level), level(self.next_level))
            }
            Some(FacilityKind::Lift) => format!("at {}, {door}", level(self.level)),
            _ => door.to_owned(),
        }
    }
}

super::sequence::sequenced!(FacilityHeader: sequence);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_door_opens_and_closes_evenly() {
        let at = |door: DoorState, tick| {
            let state = FacilityState { since_tick: 100, ticks: 50, ..FacilityState::default() };
            FacilityState { door: door as u32, ..state }.openness(tick)
        };
        assert_eq!(
            [100, 125, 150, 999].map(|tick| at(DoorState::Opening, tick)),
            [0.0, 0.5, 1.0, 1.0]
        );
        assert_eq!([100, 125, 150].map(|tick| at(DoorState::Closing, tick)), [1.0, 0.5, 0.0]);
        assert_eq!([at(DoorState::Closed, 120), at(DoorState::Open, 120)], [0.0, 1.0]);
    }

    #[test]
    fn states_have_words() {
        let level = |index: u32| ["L1", "L2"][index as usize];
        let lift = FacilityState { kind: FacilityKind::Lift as u32, ..FacilityState::default() };
        assert_eq!(lift.words(level), "at L1, closed");
        assert_eq!(FacilityState { next_level: 1, ..lift }.words(level), "from L1 to L2");
        let door = FacilityState { door: DoorState::Open as u32, ..FacilityState::default() };
        assert_eq!(door.words(level), "open");
    }
}
