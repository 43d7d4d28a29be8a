//! GPU rendering: uploads of the fleet's columns, and the compute and render passes that draw a
//! picture.

pub(crate) mod attachments;
mod bindings;
mod closures;
mod columns;
mod copy;
mod density;
pub mod device;
mod floor;
mod graph;
mod ground;
mod heat;
mod highlights;
pub mod insets;
mod instances;
mod marked;
pub mod painter;
pub mod pick;
mod pipeline;
mod plans;
pub mod renderer;
pub mod resources;
mod robots;
mod routes;
mod shaders;
mod splats;
mod stations;
mod timer;
mod view;

pub use pipeline::TargetConfig;
pub use shaders::SHADERS;
