//! Tests of whole fleets: ticks, orders and frames.

mod batteries;
mod closures;
mod drive;
mod equality;
mod impairment;
mod limits;
mod orders;
mod portable;
mod release;
pub(super) mod support;
mod turning;
