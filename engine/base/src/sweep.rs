//! The space that robots sweep along curves, and the stretches of two curves on which they touch.
//!
//! ```
//! use glam::DVec2;
//! use regatta_base::bezier::CubicBezier;
//! use regatta_base::sweep::{BodyHeading, Footprint, Outlines, Sweep, touching};
//!
//! let east = CubicBezier::straight(DVec2::new(-5.0, 0.0), DVec2::new(5.0, 0.0));
//! let north = CubicBezier::straight(DVec2::new(0.0, -5.0), DVec2::new(0.0, 5.0));
//! let sweeps = [east, north]
//!     .map(|curve| Sweep::new(BodyHeading::Tangential, [curve.control_points]));
//! let robot = Footprint::rectangle(0.9, 0.6);
//! let outlines = sweeps.each_ref().map(|sweep| Outlines::new(sweep.boxes(), &robot));
//! let crossing = touching(&outlines[0], &outlines[1]).expect("the roads cross");
//! assert!(crossing.own.contains(5.0) && !crossing.own.contains(3.0));
//! ```

mod cubic;
mod grid;
mod rectangle;
mod swept_box;
mod touching;

pub use grid::Grid;
pub use rectangle::{Rectangle, Span};
pub use swept_box::{BodyHeading, Footprint, MARGIN, Sweep, SweptBox};
pub use touching::{Outlines, Touching, touching};

/// Returns the absolute difference of two headings, in radians, 0 to π.
pub fn angle_between(a: f32, b: f32) -> f32 {
    let difference = (a - b).abs();
    // Headings are in (-π, π]: a remainder is rarely needed, and takes longer than all else here.
    let difference = if difference < core::f32::consts::TAU {
        difference
    } else {
        difference % core::f32::consts::TAU
    };
    difference.min(core::f32::consts::TAU - difference)
}
