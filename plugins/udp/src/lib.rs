//! The dissertation's UDP protocol in both directions: [`run`] sends a fleet's poses as text lines
//! and checks the answers; [`source::run`] publishes a fleet from the lines that another program
//! sends.
//!
//! ```text
//! program to visualiser:   id,x,y,theta       metres; degrees, or radians with --radians
//! visualiser to program:   id x y theta       positions as drawn
//! ```

pub mod echo;
mod echo_listener;
pub mod fixed;
pub mod line;
mod options;
mod outlet;
pub mod packer;
mod sender;
pub mod socket;
pub mod source;
pub mod tally;

pub use sender::run;
