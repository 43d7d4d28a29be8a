//! The settings that define a possible collision, and the criteria by which a pair enters and
//! leaves a level.

use regatta_plugin::contact::ContactLevel;

use crate::body::{Body, gap};
use crate::relative_motion::Proximity;

/// The hysteresis, in metres: a pair keeps its level until it is this much farther apart than where
/// it reached the level, so that it doesn't flicker at the boundary.
pub const HYSTERESIS: f64 = 0.02;

/// The largest safety margin, in metres.
pub const MAX_MARGIN: f32 = 100.0;
/// The largest horizon, in seconds.
pub const MAX_HORIZON: f32 = 60.0;

/// The settings that define a possible collision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    margin: f32,
    horizon: f32,
}

/// The error of creating [`Settings`].
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SettingsError {
    /// The margin is out of range.
    #[error("invalid margin {0} m; give 0 to {MAX_MARGIN} metres")]
    Margin(f32),
    /// The horizon is out of range.
    #[error("invalid horizon {0} s; give 0 (no prediction) to {MAX_HORIZON} seconds")]
    Horizon(f32),
}

impl Settings {
    /// Creates settings. Robots that are at most `margin` metres apart may collide, as may those
    /// that will touch within `horizon` seconds if both continue along their routes. With 0 for
    /// both, only touching counts.
    ///
    /// # Errors
    /// [`SettingsError`] unless they are from 0 to [`MAX_MARGIN`] and [`MAX_HORIZON`].
    pub fn new(margin: f32, horizon: f32) -> Result<Self, SettingsError> {
        if !(0.0..=MAX_MARGIN).contains(&margin) {
            return Err(SettingsError::Margin(margin));
        }
        if !(0.0..=MAX_HORIZON).contains(&horizon) {
            return Err(SettingsError::Horizon(horizon));
        }
        Ok(Self { margin, horizon })
    }

    /// Returns the margin, in metres.
    pub fn margin(&self) -> f32 {
        self.margin
    }

    /// Returns the horizon, in seconds.
    pub fn horizon(&self) -> f32 {
        self.horizon
    }
}

/// The inflation of both footprints, on all sides, at which a predicted pair stays possible, in
/// metres.
pub(crate) const INFLATION: f64 = 0.5 * HYSTERESIS;

/// The criteria that a pair meets in a frame by itself, as bit flags.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Criteria(u8);

impl Criteria {
    /// The footprints overlap: the pair enters the level touching.
    const ENTERS_TOUCHING: u8 = 1;
    /// The footprints overlap but for the hysteresis: the pair keeps the level touching.
    const KEEPS_TOUCHING: u8 = 2;
    /// The footprints are within the margin, or will overlap within the horizon: the pair enters
    /// the level possible.
    const ENTERS_POSSIBLE: u8 = 4;
    /// The same but for the hysteresis: the pair keeps the level possible.
    const KEEPS_POSSIBLE: u8 = 8;

    /// Whether the pair may have a level at all.
    pub(crate) fn any(self) -> bool {
        self.0 != 0
    }

    /// Whether the pair touches, but for the hysteresis.
    pub(crate) fn may_touch(self) -> bool {
        self.has(Self::KEEPS_TOUCHING)
    }

    fn has(self, flag: u8) -> bool {
        self.0 & flag != 0
    }

    /// Returns the level of a pair, given its level in the frame before.
    pub(crate) fn level(self, before: Option<ContactLevel>) -> Option<ContactLevel> {
        let was_touching = before == Some(ContactLevel::Touching);
        if self.has(Self::ENTERS_TOUCHING) || was_touching && self.has(Self::KEEPS_TOUCHING) {
            Some(ContactLevel::Touching)
        } else if self.has(Self::ENTERS_POSSIBLE)
            || before.is_some() && self.has(Self::KEEPS_POSSIBLE)
        {
            Some(ContactLevel::Possible)
        } else {
            None
        }
    }

    /// Whether the present alone makes a collision possible, so that the prediction doesn't matter.
    pub(crate) fn is_possible_now(self) -> bool {
        self.has(Self::ENTERS_POSSIBLE)
    }

    pub(crate) fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Returns the criteria that the present footprints of two robots meet. The robot with the
    /// lower id comes first, so that the result doesn't depend on the order.
    pub(crate) fn now(settings: Settings, a: &Body, b: &Body) -> Self {
        let margin = f64::from(settings.margin());
        let gap = gap(a, b, margin + HYSTERESIS);
        let limits = [
            (0.0, Self::ENTERS_TOUCHING),
            (HYSTERESIS, Self::KEEPS_TOUCHING),
            (margin, Self::ENTERS_POSSIBLE),
            (margin + HYSTERESIS, Self::KEEPS_POSSIBLE),
        ];
        let mut criteria = Self::default();
        for (limit, flag) in limits {
            criteria.0 |= u8::from(gap <= limit) * flag;
        }
        criteria
    }

    /// Returns the criteria that a predicted proximity meets, with an inflation of [`INFLATION`].
    pub(crate) fn predicted(proximity: Proximity) -> Self {
        match proximity {
            Proximity::Apart => Self(0),
            Proximity::Near => Self(Self::KEEPS_POSSIBLE),
            Proximity::Overlap => Self(Self::KEEPS_POSSIBLE | Self::ENTERS_POSSIBLE),
        }
    }
}
