//! Tests of whole fleets: ticks, commands and frames.

mod batteries;
mod closures;
mod commands;
mod drive;
mod equality;
mod facilities;
mod impairment;
mod limits;
mod portable;
mod release;
pub(super) mod support;
mod turning;
