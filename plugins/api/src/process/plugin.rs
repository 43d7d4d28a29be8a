//! The trait of plugins.

use super::join::Participant;
use super::rate::Rate;
use crate::error::Result;
use crate::ports::events::Events;
use crate::records::frame::Frame;
use crate::records::world::World;

/// A reader of frames that [`run`](crate::run) calls. Only [`on_frame`](Self::on_frame) is
/// required.
///
/// An error that one of these functions returns ends the plugin, and becomes the program's.
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
///         self.column = Some(ColumnPublisher::open_on(fleet, "distance")?);
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
    /// Called once, before anything else, with the joined fleet: to open columns, commands or
    /// control.
    fn on_start(&mut self, fleet: &Participant) -> Result {
        let _ = fleet;
        Ok(())
    }

    /// Called with the route graph and the robot types before the first frame, and again whenever
    /// they have changed (when the engine has restarted, for example).
    fn on_world(&mut self, world: &World<'_>) -> Result {
        let _ = world;
        Ok(())
    }

    /// Called with the newest frame, at the plugin's [rate](Self::rate). Frames in between are
    /// skipped if this takes longer than a tick; [`Frame::missed`] is their number. A frame is
    /// delivered again, with the same tick, if the clock or the number of robots has changed
    /// between two ticks (not in lockstep, where each tick comes once).
    fn on_frame(&mut self, frame: &Frame<'_>) -> Result;

    /// Called about ten times a second while no new frame comes: to give a column to readers that
    /// have joined since ([`ColumnPublisher::update`](crate::ColumnPublisher::update)), for
    /// example, or to read samples that other plugins publish after the last frame. `has_producer`
    /// is whether the fleet has a producer that could publish the next one.
    fn on_idle(&mut self, has_producer: bool) -> Result {
        let _ = has_producer;
        Ok(())
    }

    /// Called with the events of each tick, if the plugin [wants](Self::wants_events) them: before
    /// the frame of that tick, and as soon as they arrive, independent of the plugin's rate of
    /// frames. [`Events::missed`](crate::Events) is the number of ticks with events that were lost;
    /// [`run`](crate::run) reports them on stderr, too.
    fn on_events(&mut self, events: &Events<'_>) -> Result {
        let _ = events;
        Ok(())
    }

    /// Whether to call [`on_events`](Self::on_events). Events that no process wants are not even
    /// collected.
    fn wants_events(&self) -> bool {
        false
    }

    /// The plugins that this one comes after in lockstep, by name: with each frame, this one is
    /// called when they have finished it, so that it finds their columns of the same tick. They
    /// must run in lockstep, too. `--after` adds more. Without lockstep it has no effect.
    fn after(&self) -> Vec<String> {
        Vec::new()
    }

    /// Called once, at the end: on Ctrl-C, or after another function has returned an error.
    ///
    /// # Errors
    /// Any error of the end itself; reported unless there was an error before.
    fn on_stop(&mut self) -> Result {
        Ok(())
    }

    /// The rate at which [`on_frame`](Self::on_frame) is called, unless `--rate` gives another.
    fn rate(&self) -> Rate {
        Rate::EveryFrame
    }
}

/// Implements [`Plugin`] for a pointer to one.
macro_rules! forward_plugin {
    ($pointer:ty) => {
        impl<P: Plugin + ?Sized> Plugin for $pointer {
            fn on_start(&mut self, fleet: &Participant) -> Result {
                (**self).on_start(fleet)
            }

            fn on_world(&mut self, world: &World<'_>) -> Result {
                (**self).on_world(world)
            }

            fn on_frame(&mut self, frame: &Frame<'_>) -> Result {
                (**self).on_frame(frame)
            }

            fn on_idle(&mut self, has_producer: bool) -> Result {
                (**self).on_idle(has_producer)
            }

            fn on_events(&mut self, events: &Events<'_>) -> Result {
                (**self).on_events(events)
            }

            fn wants_events(&self) -> bool {
                (**self).wants_events()
            }

            fn after(&self) -> Vec<String> {
                (**self).after()
            }

            fn on_stop(&mut self) -> Result {
                (**self).on_stop()
            }

            fn rate(&self) -> Rate {
                (**self).rate()
            }
        }
    };
}

forward_plugin!(&mut P);
forward_plugin!(Box<P>);
