//! GPU rendering with wgpu: uploads of the fleet's columns, and the compute and render passes that
//! draw a picture of a [`Scene`](regatta_scene::Scene). It needs no window and shows no panels. It
//! draws the meshes that egui makes of the interface.
//!
//! It asks an adapter for no feature and no limit beyond WebGPU's defaults: larger limits are used
//! where an adapter has them, and timestamps where it can write them.

pub mod attachments;
mod bindings;
mod columns;
pub mod copy;
mod density;
pub mod device;
pub mod floor;
mod graph;
mod heat;
mod highlights;
mod instances;
mod marks;
pub mod mesh;
pub mod painter;
pub mod pick;
mod pipeline;
pub mod renderer;
pub mod resources;
mod robots;
mod splats;
mod timer;
mod view;

pub use pipeline::{SHADERS, TargetConfig};
