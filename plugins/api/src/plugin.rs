//! What a plugin is.

use core::str::FromStr;
use core::time::Duration;

use crate::error::Result;
use crate::event_reader::Events;
use crate::frame::Frame;
use crate::participant::Participant;
use crate::world::World;

/// A reader of frames that [`run`](crate::run) calls. Only [`on_frame`](Self::on_frame) has to be written.
///
/// An error that one of these returns ends the plugin, and becomes the program's.
///
/// ```
/// use regatta_plugin::{ColumnPublisher, Frame, Participant, Plugin, Result};
///
/// /// Publishes each robot's distance from the origin as the column `distance`.
/// #[derive(Default)]
/// struct Distance {
///     column: Option<ColumnPublisher>,
/// }
///
/// impl Plugin for Distance {
///     fn on_start(&mut self, fleet: &Participant) -> Result {
///         self.column = Some(fleet.column("distance")?);
///         Ok(())
///     }
///
///     fn on_frame(&mut self, frame: &Frame) -> Result {
///         let distances: Vec<f32> = frame.x().iter().zip(frame.y()).map(|(x, y)| x.hypot(*y)).collect();
///         if let Some(column) = &mut self.column {
///             column.publish(frame, &distances)?;
///         }
///         Ok(())
///     }
/// }
/// ```
pub trait Plugin {
    /// Called once, before anything else, with the plugin's place in the fleet: to open columns, orders or
    /// control on.
    ///
    /// # Errors
    /// Whatever keeps the plugin from starting.
    fn on_start(&mut self, fleet: &Participant) -> Result {
        let _ = fleet;
        Ok(())
    }

    /// Called with the route graph and the robot types before the first frame, and again whenever they have
    /// changed (when the engine has restarted, say).
    ///
    /// # Errors
    /// Whatever keeps the plugin from going on.
    fn on_world(&mut self, world: &World<'_>) -> Result {
        let _ = world;
        Ok(())
    }

    /// Called with the newest frame, at the plugin's [rate](Self::rate). Frames in between are skipped if this
    /// takes longer than a tick. A frame comes again, with the same tick, when the clock or the number of robots was
    /// changed between two ticks (not in lockstep).
    ///
    /// # Errors
    /// Whatever keeps the plugin from going on.
    fn on_frame(&mut self, frame: &Frame<'_>) -> Result;

    /// Called about ten times a second while no new frame comes: to give a column to readers that have joined since
    /// ([`ColumnPublisher::update`](crate::ColumnPublisher::update)), say, or to see what other plugins publish
    /// after the last frame. `has_producer` is whether there is somebody to publish a next one.
    ///
    /// # Errors
    /// Whatever keeps the plugin from going on.
    fn on_idle(&mut self, has_producer: bool) -> Result {
        let _ = has_producer;
        Ok(())
    }

    /// Called with each tick's events, before the next frame, if the plugin [wants](Self::wants_events) them.
    ///
    /// # Errors
    /// Whatever keeps the plugin from going on.
    fn on_events(&mut self, events: &Events<'_>) -> Result {
        let _ = events;
        Ok(())
    }

    /// Whether to call [`on_events`](Self::on_events). Events that nobody wants are not even collected.
    fn wants_events(&self) -> bool {
        false
    }

    /// Called once, at the end: on Ctrl-C, or after another function has returned an error.
    ///
    /// # Errors
    /// Whatever keeps the plugin from ending well; reported unless there was an error before.
    fn on_stop(&mut self) -> Result {
        Ok(())
    }

    /// How often to call [`on_frame`](Self::on_frame), unless `--rate` says otherwise.
    fn rate(&self) -> Rate {
        Rate::EveryFrame
    }
}

/// How often a plugin wants a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rate {
    /// Every frame, as soon as it is there.
    EveryFrame,
    /// So many per second of wall time (of simulated time in lockstep), or fewer if there are fewer.
    PerSecond(f64),
}

/// Why a text is no [`Rate`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{text:?} is no rate; give frames per second, greater than 0 and at most 1000000, or 'all'")]
pub struct RateError {
    /// The text.
    text: String,
}

impl Rate {
    /// Time between two frames.
    pub(crate) fn period(self) -> Duration {
        match self {
            Self::EveryFrame => Duration::ZERO,
            // A rate can be made by hand too: what makes no sense counts as every frame.
            Self::PerSecond(rate) => Duration::try_from_secs_f64(1.0 / rate).unwrap_or_default(),
        }
    }
}

impl FromStr for Rate {
    type Err = RateError;

    fn from_str(text: &str) -> Result<Self, RateError> {
        if text == "all" {
            return Ok(Self::EveryFrame);
        }
        match text.parse() {
            Ok(rate) if rate > 0.0 && rate <= 1e6 => Ok(Self::PerSecond(rate)),
            _ => Err(RateError { text: text.to_owned() }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_parsed() {
        assert_eq!("all".parse(), Ok(Rate::EveryFrame));
        assert_eq!("2.5".parse(), Ok(Rate::PerSecond(2.5)));
        for bad in ["", "0", "-1", "nan", "inf", "1e7", "fast"] {
            assert!(bad.parse::<Rate>().is_err(), "{bad}");
        }
        assert_eq!(Rate::PerSecond(4.0).period(), Duration::from_millis(250));
        assert_eq!(Rate::PerSecond(0.0).period(), Duration::ZERO);
    }
}
