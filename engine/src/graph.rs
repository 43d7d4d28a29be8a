//! Route graphs: nodes with poses, and directed Bézier edges between them.
//!
//! [`read()`] turns a file into a validated [`RouteGraph`]; [`arc_length`] compiles the graph into
//! the polynomials that robots move along.

pub mod arc_length;
pub mod bezier;
mod body_heading;
pub mod change;
pub mod components;
pub mod diff;
pub mod draw;
pub mod finding;
pub mod fix;
pub mod format;
pub mod generate;
pub mod info;
mod item;
mod layout;
mod line_index;
pub(crate) mod lint;
pub mod nurbs;
pub mod path;
mod read;
mod route_graph;
pub mod spline;
pub mod tags;
pub mod validate;
mod value;
mod yaml;

pub use bezier::CubicBezier;
pub use change::{ChangeError, EdgeChange};
pub use finding::{Finding, Findings, Severity, Subject};
pub use format::Format;
pub use lint::SMOOTH_TURN;
pub use path::Path;
pub use read::{
    GraphError, LengthUnit, MAX_FILE_BYTES, Millimetres, ReadOptions, parse, parse_fixed, read,
    read_file, read_stream,
};
pub use route_graph::{Edge, EdgeIndex, Gear, Leg, Node, NodeIndex, RouteGraph};
pub use spline::Handles;
pub use tags::{Orientation, Role, Rotation, Station, Tags};
