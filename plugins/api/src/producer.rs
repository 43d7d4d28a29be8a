//! The kit for producers: all publishers of fleets (the engine, a replay, a UDP source, a gateway
//! to real robots) have the same clock, figures and control service, and the same rules of
//! lockstep.
//!
//! A producer implements [`Producer`], and a [`Session`] runs it: [`produce`] for a program of its
//! own, with a command line, or [`Session::run`] inside a larger one.

mod clock;
mod control;
mod figures;
mod options;
mod overload;
mod session;
mod speed;

use core::time::Duration;

pub use clock::{Clock, MAX_BACKLOG};
pub use figures::{Figures, resident_bytes};
pub use options::LockstepOptions;
#[cfg(feature = "shared-memory")]
pub use options::{ProducerOptions, produce, produce_from};
pub use session::{Moment, Session};
pub use speed::{ParseSpeedError, Speed};

use crate::ports::error::{LockstepError, PublishError, ReadError};
use crate::records::control::ControlKind;
use crate::records::frame::RobotState;

/// The reason why a request is refused, as one line.
pub type RefusalReason = String;

/// A source of frames that a [`Session`] runs.
///
/// The session decides when the next tick is due, answers control requests and waits for readers in
/// lockstep; the producer moves its robots and publishes them. Only [`tick`](Self::tick),
/// [`show`](Self::show) and [`robots_by_state`](Self::robots_by_state) are required.
///
/// ```
/// use regatta_plugin::frame::RobotState;
/// use regatta_plugin::producer::{Producer, Session};
/// use regatta_plugin::{Error, Result};
///
/// /// Two robots on a circle.
/// struct Orbit;
///
/// impl Producer for Orbit {
///     type Error = Error;
///
///     fn tick(&mut self, session: &mut Session) -> Result {
///         self.show(session)
///     }
///
///     fn show(&mut self, session: &mut Session) -> Result {
///         let angle = session.sim_time().as_secs_f32();
///         Ok(session.publish(2, |columns| {
///             for (robot, angle) in [angle, -angle].into_iter().enumerate() {
///                 (columns.x[robot], columns.y[robot]) = (angle.cos(), angle.sin());
///             }
///             columns.state[..2].fill(1);
///         })?)
///     }
///
///     fn robots_by_state(&self) -> [u32; RobotState::COUNT] {
///         [0, 2, 0, 0, 0, 0, 0, 0]
///     }
/// }
///
/// # if false {
/// regatta_plugin::produce(Orbit).unwrap();
/// # }
/// ```
pub trait Producer {
    /// The error of a producer's functions, which ends its session.
    type Error: From<PublishError> + From<ReadError> + From<LockstepError>;

    /// Publishes the world and the first frame.
    fn start(&mut self, session: &mut Session) -> Result<(), Self::Error> {
        self.show(session)
    }

    /// Returns the next moment, or `None` at the end. By default there is no end, and each moment
    /// is one tick later.
    fn next_moment(&mut self, session: &Session) -> Result<Option<Moment>, Self::Error> {
        Ok(Some(session.next_tick()))
    }

    /// Advances to the session's [moment](Session::tick), which is the one that
    /// [`next_moment`](Self::next_moment) returned, and publishes it: events, the command log and
    /// columns first, then the frame, if this tick has one.
    fn tick(&mut self, session: &mut Session) -> Result<(), Self::Error>;

    /// Publishes the newest frame, again if it was published before: the clock has changed, and
    /// readers show that.
    fn show(&mut self, session: &mut Session) -> Result<(), Self::Error>;

    /// The number of robots by [`RobotState`]: idle, driving, waiting, held, faulted, turning,
    /// stalled, broken.
    fn robots_by_state(&self) -> [u32; RobotState::COUNT];

    /// Called between two ticks, every few milliseconds. By default it refuses all commands.
    fn between_ticks(&mut self, session: &mut Session) -> Result<(), Self::Error> {
        Ok(session.refuse_commands()?)
    }

    /// Waits for `duration`. A producer that listens to something does so here; by default it
    /// sleeps.
    fn wait(&mut self, session: &mut Session, duration: Duration) -> Result<(), Self::Error> {
        let _ = session;
        std::thread::sleep(duration);
        Ok(())
    }

    /// Returns the reason if this producer can't carry out a kind of request at all. By default
    /// everything is possible but other numbers of robots and other times.
    fn refuses(&self, kind: ControlKind) -> Option<RefusalReason> {
        match kind {
            ControlKind::Robots => {
                Some("this producer can't change its number of robots".to_owned())
            }
            ControlKind::Seek => {
                Some("this producer can't go to another time; a replay can".to_owned())
            }
            _ => None,
        }
    }

    /// Changes the number of robots. The session shows the frame afterwards. The inner error is a
    /// refusal.
    fn set_robots(
        &mut self,
        session: &mut Session,
        robots: u64,
    ) -> Result<Result<(), RefusalReason>, Self::Error> {
        let _ = (session, robots);
        Ok(Ok(()))
    }

    /// Goes to a simulated time, and publishes its frame. The inner error is a refusal.
    fn seek(
        &mut self,
        session: &mut Session,
        sim_time: Duration,
    ) -> Result<Result<(), RefusalReason>, Self::Error> {
        let _ = (session, sim_time);
        Ok(Ok(()))
    }

    /// Called when there is no next moment. Returns whether the session ends; if not, this is
    /// called again after a few milliseconds, unless there is a next moment by then.
    fn at_end(&mut self, session: &mut Session) -> Result<bool, Self::Error> {
        let _ = session;
        Ok(true)
    }
}
