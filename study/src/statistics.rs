//! Statistics of simulation output: intervals over replications, the end of the warm-up, and the
//! knee of a curve.

mod interval;
mod knee;
mod warm_up;

pub use interval::{Interval, percentile};
pub use knee::{Knee, knee};
pub use warm_up::{BATCH, warm_up};
