//! A fleet of any size in 3D, live, in a window or into a picture. It knows the fleet only from the contract.
//!
//! Data flows one way: [`feed`] reads the contract, [`stage`] takes what is new to the [`gpu`], which draws it as the
//! [`scene`] and the [`camera`] say, into a window's surface or a [`picture`].

mod bench;
pub mod camera;
pub mod feed;
pub mod floor_picture;
pub mod gpu;
mod headless;
pub mod interface;
mod link;
pub mod mesh;
pub mod model;
pub mod options;
pub mod palette;
pub mod picture;
mod record;
pub mod scene;
pub mod stage;
mod window;

use regatta_plugin::Result;

pub use options::Options;

/// Runs the viewer until it is closed, Ctrl-C, or the pictures are drawn.
///
/// # Errors
/// One line that says what is wrong: no adapter, no fleet to be read, a file that can't be written.
pub fn run(options: &Options) -> Result {
    if !options.bench.is_empty() {
        return bench::run(options);
    }
    if options.headless {
        return headless::run(options);
    }
    window::run(options)
}
