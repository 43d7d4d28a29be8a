//! The simulation engine: it reads a route graph and a scenario, and publishes frames.
//!
//! Data flows in one direction: [`graph`] → [`fleet`] → frame. The graph is parsed and validated
//! once and is valid from then on. [`motion`] moves every robot of the fleet by one tick and writes
//! its pose directly into the frame in shared memory that subscribers read. [`engine`] connects
//! them to the services of the fleet.

pub mod digest;
pub mod engine;
pub mod fleet;
pub mod graph;
pub mod motion;
pub mod scenario;
