//! Activities of robots, as a fleet manager sees them: the values of the column
//! [`ACTIVITY`](super::column::ACTIVITY).

numbered! {
    /// The activity of a robot.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum Activity: u8 {
        /// None.
        #[default]
        Idle = 0,
        /// It drives to the first stop of an order.
        ToPick = 1,
        /// It has begun an order, and drives to its next stop.
        Carrying = 2,
        /// It stands at a stop, and loads or unloads.
        Handling = 3,
        /// It waits for another robot.
        Waiting = 4,
        /// It waits until there is room on the roads.
        Parked = 5,
        /// It charges, or drives to a charger.
        Charging = 6,
        /// It is held, broken or faulted.
        OutOfService = 7,
    }
}

impl Activity {
    /// The name, for people.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Idle => "idle",
            Self::ToPick => "to pick",
            Self::Carrying => "carrying",
            Self::Handling => "handling",
            Self::Waiting => "waiting",
            Self::Parked => "parked",
            Self::Charging => "charging",
            Self::OutOfService => "out of service",
        }
    }

    /// Whether a robot of this activity has an order. (One that is out of service may have one,
    /// too.)
    pub const fn has_order(self) -> bool {
        matches!(self, Self::ToPick | Self::Carrying | Self::Handling | Self::Waiting)
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
}
