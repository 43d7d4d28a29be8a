//! The contract between the processes that write a fleet into shared memory and those that read it.
//!
//! ```text
//!              frames, world, events                  frames, columns
//!  producer ─────────────────────────▶ shared memory ─────────────────▶ readers
//!  engine, replay, UDP source,         one service     ◀─────────────── plugins, viewer,
//!  your own            ◀────────────── for each record     columns      your own
//!                commands, control
//! ```
//!
//! A *producer* (the engine, a replay, a UDP source) publishes [`frame`]s, the [`world`] and
//! [`event`]s, and takes [`command`]s and [`control`] requests. A *reader* is a [`Plugin`] started
//! with [`run`], or any program that opens a [`Subscriber`] itself. A producer of your own is a
//! [`Producer`](producer::Producer) started with [`produce`].
//!
//! # A plugin
//!
//! `run` adds the options `--fleet`, `--rate` and `--help`. It waits for a producer, and ends on
//! Ctrl-C.
//!
//! ```no_run
//! use regatta_plugin::{Frame, Plugin, Result};
//!
//! struct Centre;
//!
//! impl Plugin for Centre {
//!     fn on_frame(&mut self, frame: &Frame) -> Result {
//!         let mean = |column: &[f32]| column.iter().sum::<f32>() / frame.len() as f32;
//!         println!("tick {}: ({:.2}, {:.2}) m", frame.tick(), mean(frame.x()), mean(frame.y()));
//!         Ok(())
//!     }
//! }
//!
//! fn main() -> Result {
//!     regatta_plugin::run(Centre)
//! }
//! ```
//!
//! # A loop of your own
//!
//! A program that has a loop already joins the fleet and reads frames itself. This one publishes
//! the distance of each robot from the origin as the column `distance`, by which a viewer can tint
//! robots.
//!
//! ```no_run
//! use std::time::Duration;
//!
//! use regatta_plugin::{ColumnPublisher, Participant, Result, Subscriber, Termination};
//!
//! fn main() -> Result {
//!     let fleet = Participant::join(&"default".parse()?, "distance")?;
//!     let mut frames = Subscriber::open_on(&fleet)?;
//!     let mut column = ColumnPublisher::open_on(&fleet, "distance")?;
//!     let termination = Termination::watch()?;
//!     while !termination.requested() {
//!         if let Some(frame) = frames.wait(Duration::from_millis(100))? {
//!             let positions = frame.x().iter().zip(frame.y());
//!             let distances: Vec<f32> = positions.map(|(x, y)| x.hypot(*y)).collect();
//!             column.publish(&frame, &distances)?;
//!         }
//!     }
//!     Ok(())
//! }
//! ```
//!
//! # A producer
//!
//! `produce` adds the clock, the options `--fleet` and `--rate`, and answers to [`control`]
//! requests. This producer has a single robot, which drives east for ever.
//!
//! ```no_run
//! use regatta_plugin::frame::{NO_EDGE, RobotState};
//! use regatta_plugin::producer::{Producer, Session};
//! use regatta_plugin::world::{RobotTypeRecord, WorldData};
//! use regatta_plugin::{Error, Result};
//!
//! struct OneRobot;
//!
//! impl Producer for OneRobot {
//!     type Error = Error;
//!
//!     fn start(&mut self, session: &mut Session) -> Result {
//!         let robot_types = vec![RobotTypeRecord::new("cart", 1.2, 0.8)];
//!         session.ports().publish_world(&WorldData { robot_types, ..WorldData::default() })?;
//!         self.tick(session)
//!     }
//!
//!     fn tick(&mut self, session: &mut Session) -> Result {
//!         self.show(session)
//!     }
//!
//!     fn show(&mut self, session: &mut Session) -> Result {
//!         let time = session.sim_time().as_secs_f32();
//!         Ok(session.publish(1, |columns| {
//!             (columns.x[0], columns.y[0], columns.theta[0]) = (1.5 * time, 0.0, 0.0);
//!             (columns.speed[0], columns.s[0], columns.edge[0]) = (1.5, 0.0, NO_EDGE);
//!             columns.state[0] = RobotState::Driving as u8;
//!         })?)
//!     }
//!
//!     fn robots_by_state(&self) -> [u32; RobotState::COUNT] {
//!         let mut robots = [0; RobotState::COUNT];
//!         robots[RobotState::Driving as usize] = 1;
//!         robots
//!     }
//! }
//!
//! fn main() -> Result {
//!     regatta_plugin::produce(OneRobot)
//! }
//! ```
//!
//! # Modules
//!
//! | module | |
//! |---|---|
//! | [`records`] | plain data that crosses processes |
//! | [`ports`] | who sends and who takes each record |
//! | [`process`] | joining a fleet, running a plugin, ending, the health of shared memory |
//! | [`producer`] | clock, figures and control for any producer |
//!
//! Imports lead from the records up, through ports and processes, to producers. Below the ports,
//! the transport connects them: by shared memory between processes, or by calls within one (see
//! [`LocalFleet`]).
//!
//! Without the default feature `shared-memory` there are local fleets alone. That compiles for any
//! target of Rust, for example `wasm32-unknown-unknown`.

/// Writes a line to standard error, as `eprintln!` does, but all at once, so that the lines of
/// several processes don't mix, and continues if it can't be read any more: a plugin whose terminal
/// or log was closed still serves its fleet. Nothing of the line controls the terminal: it may hold
/// texts of strangers.
#[macro_export]
macro_rules! tell {
    ($($line:tt)*) => {{
        use ::std::io::Write as _;
        let line = ::std::format!("{}\n", ::std::format_args!($($line)*));
        let _ = ::std::io::stderr().write_all($crate::visible(&line).as_bytes());
    }};
}

mod error;
pub mod ports;
#[cfg_attr(
    not(feature = "shared-memory"),
    allow(dead_code, reason = "the plugins of a local fleet aren't programs with options")
)]
pub mod process;
pub mod producer;
pub mod records;
mod transport;
mod visible;

/// The plugins' README has a whole plugin: it compiles.
#[cfg(all(doctest, feature = "shared-memory"))]
#[doc = include_str!("../../README.md")]
struct Readme;

pub use error::{Error, Result};
pub use ports::closures::ClosureReader;
#[cfg(feature = "shared-memory")]
pub use ports::columns::column_names;
pub use ports::columns::{ColumnPublisher, ColumnReader, ColumnValues};
pub use ports::command_log::{CommandLog, CommandLogReader};
pub use ports::commands::{CommandError, Commands};
pub use ports::contacts::{ContactEventReader, ContactEvents, ContactPublisher, ContactReader};
pub use ports::control::{Control, ControlError, TIMEOUT as CONTROL_TIMEOUT};
pub use ports::error::{LockstepError, OpenError, PublishError, ReadError};
pub use ports::events::{EventReader, Events};
pub use ports::facilities::FacilityReader;
pub use ports::frames::Subscriber;
pub use ports::history::{HistoryPublisher, HistoryReader};
#[cfg(feature = "shared-memory")]
pub use ports::lockstep::Reporter;
pub use ports::manager::{ManagerClient, ManagerError, ManagerServer};
pub use ports::orders::{OrderPublisher, OrderReader, Orders};
pub use ports::ownership::Ownership;
pub use ports::producer::{FrameLoan, ProducerPorts};
pub use ports::recording::{RecordingPublisher, RecordingReader, ReplayedRecording};
pub use ports::routes::{PendingRoute, RouteClient, RouteError, RouteServer};
pub use ports::services;
pub use ports::traffic::{TrafficPublisher, TrafficReader};
pub use ports::work::{WorkPublisher, WorkReader};
pub use ports::worlds::WorldReader;
#[cfg(feature = "shared-memory")]
pub use process::domain::{
    DomainError, RUNTIME_DIR_VARIABLE, config as iceoryx2_config, private_directory,
};
pub use process::finishing::{FINISHING_VARIABLE, Finishing};
pub use process::hangup::reopen_on_hangup;
#[cfg(feature = "shared-memory")]
pub use process::health;
pub use process::join::Participant;
#[cfg(feature = "shared-memory")]
pub use process::log::set_verbosity;
pub use process::options::{AFTER_VARIABLE, LOAD_VARIABLE, NAME_VARIABLE, Options};
pub use process::plugin::Plugin;
pub use process::rate::{Rate, RateError};
#[cfg(feature = "shared-memory")]
pub use process::run::{run, run_from};
pub use process::runner::LocalPlugin;
#[cfg(feature = "shared-memory")]
pub use process::scheduling::{Priority, SchedulingError, SchedulingOptions};
#[cfg(feature = "shared-memory")]
pub use process::termination::{PARENT_VARIABLE, Termination};
pub use process::usage::usage_line;
#[cfg(feature = "shared-memory")]
pub use producer::{produce, produce_from};
pub use records::contact::Contacts;
pub use records::frame::Frame;
pub use records::name::{ColumnName, FleetName, MAX_NAME_BYTES, NameError};
pub use records::traffic::Traffic;
pub use records::world::World;
pub use records::{
    activity, closure, column, command, command_log, contact, control, event, facility, frame,
    history, manager, order, recording, route, sequence, traffic, work, world,
};
pub use transport::local::LocalFleet;
pub use visible::visible;
