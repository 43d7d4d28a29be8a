//! The picture on the GPU: uploads, and a pass or two for each thing that is drawn.

mod chosen;
mod columns;
pub mod device;
mod floor;
pub mod frame;
mod graph;
pub mod layout;
pub mod painter;
pub mod pick;
mod robots;
mod routes;
mod splats;
mod timer;
mod view;

pub use layout::{SHADERS, TargetKind};
