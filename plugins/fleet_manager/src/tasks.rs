//! Transport orders: where they come from, which robot gets them, and what has become of them.
//!
//! | module | |
//! |---|---|
//! | [`order`] | orders, their stops and states |
//! | [`places`], [`draft`] | the nodes that orders may name; orders as users write them |
//! | [`file`](mod@file), [`load`] | files of orders, descriptions of loads |
//! | [`book`] | all open orders: the one place where their states change |
//! | [`assign`] | which robot gets which order |
//! | [`figures`] | how many, how long |
//! | [`store`], [`web`], [`client`] | where orders are kept; orders over HTTP, and a client of it |
//!
//! A manager calls the [`TaskBook`] once a tick, like this. All times are in seconds of simulated
//! time; nodes are indices in the world's nodes.
//!
//! ```
//! use std::sync::Arc;
//! use regatta_fleet_manager::tasks::{Candidate, Load, Next, Place, Places, TaskBook};
//!
//! let places = (0..4).map(|id| Place { id, position: [id as f32, 0.0], ..Place::default() });
//! let places = Arc::new(Places::new(places.collect()));
//! let mut tasks = TaskBook::new(places.clone());
//! tasks.add_load(&Load::parse("load: {per_hour: 600, seed: 7}", &places)?);
//!
//! let driving_secs = |robot: u32, node: u32| Some(f64::from(robot.abs_diff(node)));
//! let robots = [Candidate { robot: 0, position: [0.0, 0.0] }, Candidate { robot: 1, position: [3.0, 0.0] }];
//! for tick in 0..600 {
//!     let now = f64::from(tick);
//!     tasks.generate_until(now, robots.len());
//!     let freed = tasks.take_requests(now); // robots whose orders somebody has withdrawn: stop them
//!     let changes = tasks.assign(now, &robots, &driving_secs);
//!     for robot in changes.withdrawn.iter().map(|(_, robot)| *robot).chain(freed) { /* cancel its route */ }
//!     for (_task, robot) in changes.assigned {
//!         let stop = tasks.current_stop(robot).expect("a stop"); // plan a route to stop.node
//!     }
//!     for robot in [0, 1] {
//!         // When it stands at the node of its stop, and when the dwell time is over:
//!         if tasks.arrived(robot, now) {
//!             match tasks.handled(robot, now) {
//!                 Some(Next::Stop(_stop)) => { /* plan a route to _stop.node */ }
//!                 Some(Next::Done) | None => {}
//!             }
//!         }
//!     }
//!     for event in tasks.events() { /* into the task log */ }
//!     tasks.publish(now);
//! }
//! assert!(tasks.figures(600.0).orders.finished > 50);
//! # Ok::<(), regatta_fleet_manager::tasks::InputError>(())
//! ```

pub mod assign;
pub mod book;
pub mod client;
mod desk;
pub mod draft;
pub mod figures;
pub mod file;
mod generator;
pub mod load;
mod office;
pub mod order;
pub mod places;
mod random;
pub mod store;
pub mod web;
mod yaml;

pub use assign::{Assigner, Candidate, InTurn, Nearest, OpenTask, Problem};
pub use book::{Assignments, Next, TaskBook, Urgency};
pub use client::{Client, ClientError};
pub use desk::{Vehicle, WithdrawError};
pub use draft::{DraftError, Label, OrderDraft, StopDraft};
pub use figures::{ByState, Durations, Figures};
pub use file::{FileError, TimedDraft, read_orders};
pub use load::Load;
pub use office::{TaskSettings, TasksError};
pub use order::{
    Action, Change, HistoryEntry, NameError, NewOrder, Order, OrderName, State, Stop, TaskEvent,
    TaskId, UnknownAction,
};
pub use places::{Place, Places};
pub use store::StoreError;
pub use web::WebError;
pub use yaml::InputError;
