//! The 3D viewer: shows a fleet of any size live in a window, or renders it into pictures. It reads
//! the fleet only through the contract.
//!
//! Data flows one way: [`feed`] reads shared memory, [`stage`] uploads new data to the [`gpu`],
//! which draws it according to the [`scene`] and the [`camera`] into a window's surface or a
//! [`picture`].

mod bench;
pub mod camera;
mod caption;
pub mod curves;
mod density;
pub mod feed;
mod files;
pub mod filter;
pub mod floor_picture;
pub mod footprint;
pub mod gpu;
mod headless;
pub mod interface;
pub mod jams;
mod link;
pub mod log;
mod memory;
pub mod mesh;
pub mod mesh_file;
pub mod notes;
pub mod options;
pub mod orders;
pub mod palette;
pub mod past;
pub mod picture;
pub mod plans;
pub mod playhead;
pub mod route;
pub mod scene;
pub mod stage;
pub mod svg;
pub mod tasks;
pub mod text;
mod video;
pub mod watching;
mod window;

use regatta_plugin::Result;

pub use options::Options;

/// Runs the viewer until its window is closed, it is interrupted by Ctrl-C, or all pictures are
/// written.
///
/// # Errors
/// A one-line message, for example if there is no graphics adapter, the fleet can't be read, or a
/// file can't be written.
pub fn run(options: &Options) -> Result {
    if !options.bench.is_empty() && options.recording.is_none() {
        return bench::run(options);
    }
    if options.has_window() { window::run(options) } else { headless::run(options) }
}
