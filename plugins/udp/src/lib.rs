//! The dissertation's UDP protocol, both ways: [`run`] sends a fleet's poses as text lines and checks the answers,
//! [`source::run`] makes a fleet of the lines that somebody else sends.
//!
//! ```text
//! program to visualiser:   id,x,y,theta       metres; degrees, or radians with --radians
//! visualiser to program:   id x y theta       positions as drawn
//! ```

mod answer_thread;
pub mod echo;
pub mod fixed;
pub mod line;
mod options;
mod outlet;
mod pacer;
pub mod packer;
mod sender;
pub mod socket;
pub mod source;
pub mod tally;

pub use sender::run;
