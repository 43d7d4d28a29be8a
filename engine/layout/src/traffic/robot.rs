//! The robots that a certificate is about.

use glam::DVec2;
use regatta_base::sweep::Footprint;
use serde::Serialize;

/// The smallest and the largest side of a robot, in metres.
const SIDES: std::ops::RangeInclusive<f64> = 0.001..=100.0;

/// Whether robots turn on the spot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Turning {
    /// They do, at nodes where the heading changes by more than 5°, and need the circle around
    /// them.
    OnTheSpot,
    /// They don't: they need no room beside that of their ways.
    Never,
}

/// A type of robots: rectangles about their poses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RobotType {
    length: f64,
    width: f64,
    turning: Turning,
}

/// The error of making a [`RobotType`].
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "a robot of {length} m × {width} m: its length and its width must be {} to {} m",
    SIDES.start(),
    SIDES.end()
)]
pub struct RobotTypeError {
    length: f64,
    width: f64,
}

impl Default for RobotType {
    /// The type of the default scenario: 0.9 m × 0.6 m, turning on the spot.
    fn default() -> Self {
        Self { length: 0.9, width: 0.6, turning: Turning::OnTheSpot }
    }
}

impl RobotType {
    /// Makes a type of a length along and a width across the heading, in metres.
    ///
    /// # Errors
    /// [`RobotTypeError`] if a side is no number from 0.001 to 100.
    pub fn new(length: f64, width: f64, turning: Turning) -> Result<Self, RobotTypeError> {
        match SIDES.contains(&length) && SIDES.contains(&width) {
            true => Ok(Self { length, width, turning }),
            false => Err(RobotTypeError { length, width }),
        }
    }

    /// Metres along the heading.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Metres across the heading.
    pub fn width(&self) -> f64 {
        self.width
    }

    /// Whether it turns on the spot.
    pub fn turning(&self) -> Turning {
        self.turning
    }

    pub(super) fn footprint(&self) -> Footprint {
        Footprint { half: (0.5 * DVec2::new(self.length, self.width)).as_vec2() }
    }
}
