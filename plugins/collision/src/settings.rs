//! The settings that define a possible collision.

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
