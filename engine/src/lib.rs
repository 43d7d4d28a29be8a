//! The simulation engine: it turns a layout and a scenario into frames.
//!
//! Data flows in one direction: layout → [`fleet`] → frame. [`arc_length`] compiles the validated
//! layout into the pieces that the motion kernel (`regatta-motion`) moves every robot along; the
//! kernel writes each pose directly into the frame in shared memory that subscribers read.
//! [`engine`] connects them to the services of the fleet.

pub mod arc_length;
pub mod digest;
pub mod engine;
pub mod fleet;
