//! What counts as a possible collision.

/// A pair keeps its level until it is this much farther apart than where it came to it, in metres: so none flickers
/// at the boundary.
pub const HYSTERESIS: f64 = 0.02;

/// Largest safety margin, in metres.
pub const MAX_MARGIN: f32 = 100.0;
/// Largest horizon, in seconds.
pub const MAX_HORIZON: f32 = 60.0;

/// What counts as a possible collision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    margin: f32,
    horizon: f32,
}

/// Settings that make no sense.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SettingsError {
    /// The margin.
    #[error("a margin of {0} m makes no sense; give 0 to {MAX_MARGIN} metres")]
    Margin(f32),
    /// The horizon.
    #[error("a horizon of {0} s makes no sense; give 0 (no prediction) to {MAX_HORIZON} seconds")]
    Horizon(f32),
}

impl Settings {
    /// Robots that are at most `margin` metres apart may collide, and those that will touch within `horizon` seconds if
    /// both go on as they do. With 0 for both, only touching counts.
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

    /// Metres.
    pub fn margin(&self) -> f32 {
        self.margin
    }

    /// Seconds.
    pub fn horizon(&self) -> f32 {
        self.horizon
    }
}
