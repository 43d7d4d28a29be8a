//! The engine: a route graph and a scenario in, frames out.
//!
//! Data flows one way: [`graph`] → [`fleet`] → frame. The graph is parsed and validated once; after that it
//! can't be wrong. [`motion`] moves every robot of the fleet by one tick and writes its pose straight into
//! the frame that readers will see. [`engine`] ties them to the contract.

pub mod digest;
pub mod engine;
pub mod fleet;
pub mod graph;
pub mod motion;
pub mod scenario;
