//! Tests of the detector.

mod behaviour;
mod exact;
mod fleet;
mod oracle;
