//! Mathematics and text that the layout crate and plugins share: it knows neither layouts nor the
//! contract. The validator keeps implementations of its own on purpose, for its independence.
//!
//! ```
//! use regatta_base::graph::{EdgeIndex, Gear, Leg};
//! use regatta_base::random;
//!
//! // A random walk: the leg after a node depends on the seed and the number of choices so far.
//! let (seed, choices, exits) = (7, 3, [EdgeIndex(4), EdgeIndex(9)]);
//! let random = random::mix(seed ^ random::mix(choices)) >> 32;
//! let exit = exits[(random * exits.len() as u64 >> 32) as usize];
//! let leg = Leg { edge: exit, gear: Gear::Forward };
//! assert!(exits.contains(&leg.edge));
//! ```

pub mod badge;
pub mod bezier;
pub mod components;
pub mod cores;
mod decimals;
pub mod file;
pub mod graph;
mod ln;
pub mod name;
pub mod outline;
mod packing;
pub mod parts;
pub mod random;
pub mod round;
pub mod rows;
pub mod svg;
pub mod sweep;
mod thousands;
pub mod yaml;

pub use decimals::Decimal;
pub use ln::ln;
pub use packing::most_apart;
pub use thousands::{grouped, thousands};
