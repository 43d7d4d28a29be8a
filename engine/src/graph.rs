//! Route graphs: nodes with poses, and directed Bézier edges between them.
//!
//! [`read()`] turns a file into a validated [`RouteGraph`]; [`arc_length`] compiles the graph into the polynomials that
//! robots move along.

pub mod arc_length;
pub mod bezier;
pub mod components;
pub mod draw;
pub mod finding;
pub mod generate;
pub mod info;
mod item;
mod line_index;
mod lint;
mod read;
mod route_graph;
pub mod spline;
pub mod validate;
mod value;
mod yaml;

pub use bezier::CubicBezier;
pub use finding::{Finding, Findings, Severity, Subject};
pub use read::{GraphError, MAX_FILE_BYTES, ReadOptions, parse, read, read_file, read_stream};
pub use route_graph::{Edge, EdgeIndex, Gear, Leg, Node, NodeIndex, RouteGraph};
pub use spline::Handles;
