//! The troubles of a vehicle, for which a master keeps others away from it.

use core::fmt;

use crate::message::{ConnectionState, EmergencyStop, ErrorLevel, OperatingMode, State};

/// The reason why a vehicle can't be steered.
#[derive(Clone, Debug, PartialEq)]
pub enum Trouble {
    /// It isn't connected to the broker.
    Gone(ConnectionState),
    /// Nothing came from it for so many seconds.
    Silent(u64),
    /// Somebody else steers it.
    Operated(OperatingMode),
    /// Its emergency stop is active.
    Stopped,
    /// It reports an error that stops it.
    Failed(String),
    /// It doesn't know its position.
    Unlocalized,
    /// It is at no place of the roads.
    OffRoads,
    /// It is so many metres off the way that it was given.
    Astray(f64),
    /// It still has the load of an order that has failed.
    Loaded,
    /// It rejects its order.
    Rejects(String),
    /// It doesn't answer.
    Mute,
    /// It is larger than all robot types: metres of its length and width.
    TooLarge([f64; 2]),
}

impl Trouble {
    /// Whether the vehicle may be elsewhere than on the way that it was given. Then the edges
    /// around it are closed.
    pub const fn is_loose(&self) -> bool {
        matches!(
            self,
            Self::Operated(_)
                | Self::Unlocalized
                | Self::OffRoads
                | Self::Astray(_)
                | Self::TooLarge(_)
        )
    }

    /// Whether the vehicle may be told what to do.
    pub const fn may_be_told(&self) -> bool {
        matches!(self, Self::Rejects(_) | Self::Mute)
    }

    /// Whether this is the same trouble, with other figures maybe.
    pub fn is_like(&self, other: &Self) -> bool {
        core::mem::discriminant(self) == core::mem::discriminant(other)
    }

    /// The trouble that a state tells of.
    pub fn of_state(state: &State) -> Option<Self> {
        let mode = state.operating_mode;
        if !matches!(mode, OperatingMode::Automatic | OperatingMode::SemiAutomatic) {
            return Some(Self::Operated(mode));
        }
        if state.safety_state.active_emergency_stop != EmergencyStop::None {
            return Some(Self::Stopped);
        }
        let mut errors = state.errors.iter();
        if let Some(error) = errors.find(|error| error.error_level >= ErrorLevel::Critical) {
            let text = error.error_description.as_deref().unwrap_or_default();
            return Some(Self::Failed(
                format!("{} {text}", error.error_type).trim_end().to_owned(),
            ));
        }
        let is_lost = state.mobile_robot_position.as_ref().is_some_and(|it| !it.localized);
        is_lost.then_some(Self::Unlocalized)
    }
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Gone(ConnectionState::Offline) => f.write_str("it went offline"),
            Self::Gone(ConnectionState::Hibernating) => f.write_str("it hibernates"),
            Self::Gone(_) => f.write_str("its connection is broken"),
            Self::Silent(seconds) => write!(f, "it has sent nothing for {seconds} s"),
            Self::Operated(mode) => write!(f, "its operating mode is {mode:?}"),
            Self::Stopped => f.write_str("its emergency stop is active"),
            Self::Failed(error) => write!(f, "it reports an error: {error}"),
            Self::Unlocalized => f.write_str("it doesn't know its position"),
            Self::OffRoads => f.write_str("it is at no node or edge of the layout"),
            Self::Astray(metres) => write!(f, "it is {metres:.1} m off its path"),
            Self::Loaded => f.write_str("it still has the load of an order that has failed"),
            Self::Rejects(reason) => write!(f, "it rejects its order: {reason}"),
            Self::Mute => f.write_str("it doesn't answer its order"),
            Self::TooLarge([length, width]) => {
                write!(f, "its {length} m x {width} m are more than those of every robot type")
            }
        }
    }
}
