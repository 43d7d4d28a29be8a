//! Transport orders: their sources, their assignment to robots, their states and their store.
//!
//! | module | |
//! |---|---|
//! | [`order`] | orders, their stops and states |
//! | [`places`], [`draft`] | the nodes that orders may name; orders as users write them |
//! | [`file`](mod@file), [`load`] | files of orders, descriptions of loads |
//! | [`pool`] | all open orders: the one place where their states change |
//! | [`assign`] | the assignment of orders to robots |
//! | [`figures`] | counts, durations and rates of orders |
//! | [`store`], [`web`], [`client`] | the store of orders; orders over HTTP, and a client of it |
//!
//! The store needs the feature `store`, and the web API and its client the feature `http`. A pool
//! without them has the same orders.
//!
//! A manager calls the [`OrderPool`] once a tick, like this. All times are in seconds of simulated
//! time; nodes are indices in the world's nodes.
//!
//! ```
//! use std::sync::Arc;
//! use glam::Vec2;
//! use regatta_orders::{Candidate, Load, Next, Place, Places, OrderPool};
//!
//! let places = (0..4).map(|id| Place { id, position: Vec2::X * id as f32, ..Place::default() });
//! let places = Arc::new(Places::new(places.collect()));
//! let mut orders = OrderPool::new(places.clone());
//! orders.add_load(&Load::parse("load: {per_hour: 600, seed: 7}", &places)?);
//!
//! let driving_secs = |robot: u32, node: u32| Some(f64::from(robot.abs_diff(node)));
//! let robots = [0, 3].map(|x| Candidate {
//!     robot: x / 3,
//!     position: Vec2::X * x as f32,
//!     ..Candidate::default()
//! });
//! for tick in 0..600 {
//!     let now = f64::from(tick);
//!     orders.generate_until(now, robots.len());
//!     let freed = orders.take_requests(now); // robots whose orders were withdrawn by somebody
//!     let changes = orders.assign(now, &robots, &driving_secs);
//!     for robot in changes.withdrawn.iter().map(|(_, robot)| *robot).chain(freed) {
//!         // cancel its route
//!     }
//!     for (_id, robot) in changes.assigned {
//!         let stop = orders.current_stop(robot).expect("a stop"); // plan a route to stop.node
//!     }
//!     for robot in [0, 1] {
//!         // When it stands at the node of its stop, and when the dwell time is over:
//!         if orders.arrived(robot, now).is_some() {
//!             match orders.handled(robot, now) {
//!                 Some(Next::Stop(_stop)) => { /* plan a route to _stop.node */ }
//!                 Some(Next::Done) | None => {}
//!             }
//!         }
//!     }
//!     for event in orders.events() { /* into the order log */ }
//!     orders.publish(now);
//! }
//! assert!(orders.figures(600.0).orders.finished > 50);
//! # Ok::<(), regatta_base::yaml::Error>(())
//! ```

#[cfg(not(all(feature = "http", feature = "store")))]
mod absent;
pub mod assign;
#[cfg(feature = "http")]
pub mod client;
mod distribution;
pub mod draft;
mod dwell;
pub mod figures;
pub mod file;
mod generator;
pub mod load;
mod open;
pub mod order;
pub mod places;
pub mod pool;
#[cfg(feature = "http")]
mod schema;
mod stations;
mod storages;
#[cfg(feature = "store")]
pub mod store;
#[cfg_attr(
    not(all(feature = "http", feature = "store")),
    allow(dead_code, reason = "some messages are those of the store and the web API alone")
)]
mod threads;
mod timetable;
#[cfg(feature = "http")]
mod view;
#[cfg(feature = "http")]
pub mod web;

#[cfg(not(feature = "store"))]
pub use absent::store;
#[cfg(not(feature = "http"))]
pub use absent::web;

pub use assign::{Assigner, Candidate, InTurn, Limits, Nearest, OpenOrder, Problem};
#[cfg(feature = "http")]
pub use client::{Client, ClientError};
pub use draft::{DraftError, Label, OrderDraft, StopDraft};
pub use figures::{ByState, Durations, Figures};
pub use file::{FileError, FileTime, Table, TimedDraft, read_orders, read_table, to_csv};
pub use generator::IsFeasible;
pub use load::Load;
pub use open::{OrderSettings, PoolError};
pub use order::{
    Action, Change, HistoryEntry, NameError, NewOrder, Order, OrderEvent, OrderId, OrderName,
    State, Stop, UnknownAction, Unroutable,
};
pub use places::{Place, PlaceError, Places};
pub use pool::{Assignments, Held, LoadStops, Next, OrderPool};
#[cfg(feature = "http")]
pub use regatta_kit::private::{TokenError, read_token};
pub use stations::Service;
pub use storages::{Lack, StorageFill};
pub use store::StoreError;
pub use threads::{Vehicle, WithdrawError};
pub use timetable::check_orders;
pub use web::WebError;
