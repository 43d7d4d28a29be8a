//! Tests of the detector.

mod behaviour;
mod fleet;
mod oracle;
