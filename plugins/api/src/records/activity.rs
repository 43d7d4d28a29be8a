//! Activities of robots, in the words and the colours of all programs that show them: windows,
//! lists, `regatta top`, plots, reports. The words stand in `docs/glossary.md`.
//!
//! A fleet manager knows more of a robot than its state: it publishes activities in the column
//! [`ACTIVITY`](super::column::ACTIVITY). [`Activity::of`] makes one word of both.

use super::frame::RobotState;

numbered! {
    /// The activity of a robot.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
    pub enum Activity: u8 {
        /// It has nothing to do.
        #[default]
        Idle = 0,
        /// It drives to the first stop of an order.
        Fetching = 1,
        /// It has begun an order, and drives to its next stop.
        Carrying = 2,
        /// It stands at a stop, and loads or unloads.
        Handling = 3,
        /// It waits for another robot, for a release of its route, or before a closed edge.
        Waiting = 4,
        /// It waits until there is room on the roads, or in the queue before its stop.
        Queued = 5,
        /// It charges, or drives to a charger.
        Charging = 6,
        /// It was commanded to hold.
        Held = 7,
        /// It is broken, and stands until it is repaired.
        Broken = 8,
        /// It can't continue; an event gave the reason.
        Faulted = 9,
        /// It has stopped for a while of its own.
        Stalled = 10,
        /// It drives, without an order.
        Moving = 11,
        /// It turns on the spot, without an order.
        Rotating = 12,
    }
}

/// The ground that colours are seen on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ground {
    /// A dark one.
    Dark,
    /// A light one, such as paper.
    Light,
}

impl Activity {
    /// The number of activities.
    pub const COUNT: usize = Self::ALL.len();

    /// The activity of a robot as far as its state tells; `None` if it is absent.
    pub const fn of_state(state: RobotState) -> Option<Self> {
        Some(match state {
            RobotState::Idle => Self::Idle,
            RobotState::Driving => Self::Moving,
            RobotState::Waiting => Self::Waiting,
            RobotState::Held => Self::Held,
            RobotState::Faulted => Self::Faulted,
            RobotState::Turning => Self::Rotating,
            RobotState::Stalled => Self::Stalled,
            RobotState::Broken => Self::Broken,
            RobotState::Absent => return None,
        })
    }

    /// The activity of a robot by its state and by that which a fleet manager has published, if it
    /// has. A robot that can't move is what its state says, and so is one without work; of others,
    /// the manager knows more. `None` if it is absent.
    pub fn of(state: RobotState, published: Option<Self>) -> Option<Self> {
        let own = Self::of_state(state)?;
        Some(match published {
            Some(known) if own.can_move() && known.can_move() && known != Self::Idle => known,
            _ => own,
        })
    }

    /// Whether nothing but its work and the roads keeps the robot from moving.
    pub const fn can_move(self) -> bool {
        !matches!(self, Self::Held | Self::Broken | Self::Faulted | Self::Stalled)
    }

    /// The word, for people.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Idle => "idle",
            Self::Fetching => "fetching",
            Self::Carrying => "carrying",
            Self::Handling => "handling",
            Self::Waiting => "waiting",
            Self::Queued => "queued",
            Self::Charging => "charging",
            Self::Held => "held",
            Self::Broken => "broken",
            Self::Faulted => "faulted",
            Self::Stalled => "stalled",
            Self::Moving => "moving",
            Self::Rotating => "rotating",
        }
    }

    /// The colour, as 0xRRGGBB. The colours of a ground can be told apart with any colour vision,
    /// from each other, from the ground, from routes and from the ramps of heat maps.
    pub const fn colour(self, ground: Ground) -> u32 {
        let [dark, light] = match self {
            Self::Idle => [0x505860, 0x98a0a8],
            Self::Fetching => [0x5068f0, 0x2818a8],
            Self::Carrying => [0x48f8a8, 0x186858],
            Self::Handling => [0x709848, 0x78c820],
            Self::Waiting => [0xd0a838, 0xc07848],
            Self::Queued => [0x784830, 0xe0c890],
            Self::Charging => [0x7038a0, 0x9868b8],
            Self::Held => [0xc090f8, 0x681878],
            Self::Broken => [0xffffff, 0x102028],
            Self::Faulted => [0xc83000, 0x803800],
            Self::Stalled => [0xd8d810, 0x302000],
            Self::Moving => [0xb0d0f8, 0x2878f8],
            Self::Rotating => [0x28a0a0, 0x58d8f8],
        };
        match ground {
            Ground::Dark => dark,
            Ground::Light => light,
        }
    }

    /// The colour as red, green and blue, 0 to 255.
    pub const fn rgb(self, ground: Ground) -> [u8; 3] {
        let [_, red, green, blue] = self.colour(ground).to_be_bytes();
        [red, green, blue]
    }

    /// Whether a robot of this activity has an order. (One that can't move may have one, too.)
    pub const fn has_order(self) -> bool {
        matches!(self, Self::Fetching | Self::Carrying | Self::Handling | Self::Waiting)
    }

    /// Returns the activity of a column's value; `None` if it is none.
    pub fn from_value(value: f32) -> Option<Self> {
        // The conversion truncates and saturates, which the comparison finds out.
        let activity = Self::from_number(value as u8)?;
        (f32::from(activity as u8) == value).then_some(activity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_activities() {
        for (number, activity) in Activity::ALL.into_iter().enumerate() {
            assert_eq!(activity as usize, number);
            assert_eq!(Activity::from_value(number as f32), Some(activity));
        }
        assert_eq!(Activity::from_value(f32::NAN), None);
        assert_eq!(Activity::from_value(0.5), None);
    }

    #[test]
    fn a_state_has_the_word_of_its_activity() {
        for number in 0..RobotState::COUNT as u8 {
            let state = RobotState::from_number(number);
            let activity = Activity::of_state(state).expect("of a robot that is there");
            // A word of both means the same, but for a robot that stands while it works.
            let is_of_work = matches!(state, RobotState::Driving | RobotState::Turning);
            assert_eq!(activity.name() == state.name(), !is_of_work, "{state:?}");
        }
        assert_eq!(Activity::of_state(RobotState::Absent), None);
    }

    #[test]
    fn a_robot_has_one_activity() {
        let of = |state, published| Activity::of(state, Some(published)).expect("there");
        assert_eq!(of(RobotState::Idle, Activity::Handling), Activity::Handling);
        assert_eq!(of(RobotState::Driving, Activity::Carrying), Activity::Carrying);
        // It can't move, whatever its order.
        assert_eq!(of(RobotState::Broken, Activity::Carrying), Activity::Broken);
        // It can move again, and the manager doesn't know yet.
        assert_eq!(of(RobotState::Driving, Activity::Held), Activity::Moving);
        // It drives, without an order.
        assert_eq!(of(RobotState::Driving, Activity::Idle), Activity::Moving);
        assert_eq!(Activity::of(RobotState::Waiting, None), Some(Activity::Waiting));
        assert_eq!(Activity::of(RobotState::Absent, Some(Activity::Idle)), None);
    }
}
