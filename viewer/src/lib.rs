//! The 3D viewer: shows a fleet of any size live in a window, or renders it into pictures. It reads
//! the fleet only through the contract.
//!
//! Data flows one way: [`feed`] reads shared memory, [`stage`] uploads new data to the [`gpu`],
//! which draws it according to the [`scene`] and its camera into a window's surface or a
//! [`picture`]. The [`interface`] shows panels over it.

mod bench;
mod caption;
pub mod feed;
mod files;
pub mod floor_picture;
pub mod frame_history;
mod headless;
pub mod jams;
mod link;
pub mod log;
pub mod mesh_file;
pub mod notes;
pub mod options;
pub mod picture;
pub mod plans;
pub mod playhead;
pub mod sections;
pub mod stage;
pub mod svg;
mod video;
mod window;
pub mod worker;

use regatta_plugin::Result;
pub use {regatta_gpu as gpu, regatta_interface as interface, regatta_scene as scene};

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
