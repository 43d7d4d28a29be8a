//! Layouts of plants: route graphs, their readers and writers, checks, drawings and generators.
//!
//! [`read()`] turns a file of any [`Format`] into a validated [`RouteGraph`]. From then on the
//! graph can't be wrong: every index and every number is in range.
//!
//! ```
//! use regatta_layout::{Gear, ReadOptions, parse};
//!
//! let text = "
//! Edges:
//! - {Id: 1, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, VelocityForward: 1.5}
//! Vertices:
//! - {Id: 1, X: 0.0, Y: 0.0, Theta: 0.0}
//! - {Id: 2, X: 4.0, Y: 0.0, Theta: 0.0}
//! ";
//! let (graph, findings) = parse(text, "road.yaml", &ReadOptions::default())?;
//! assert_eq!(findings.errors(), 0);
//! let first = graph.node_by_id(1).expect("node 1");
//! let leg = graph.departures(first)[0];
//! assert_eq!(leg.gear, Gear::Forward);
//! assert!((graph.edge(leg.edge).path.length() - 4.0).abs() < 1e-9);
//! # Ok::<(), regatta_layout::GraphError>(())
//! ```

pub mod check;
pub mod draw;
pub mod generate;
pub mod model;
pub mod read;
pub mod traffic;
pub mod write;

pub use model::apart::{Apart, DrawnCabin, DrawnLevel};
pub use model::change::{ChangeError, EdgeChange};
pub use model::drawn::DrawnStation;
pub use model::facilities::{Cabin, Door, DoorTimes, Lift, LiftLevel};
pub use model::finding::{Finding, FindingKind, Findings, Severity, Subject};
pub use model::format::{Format, Written};
pub use model::options::{LengthUnit, Millimetres, ReadOptions};
pub use model::path::Path;
pub use model::route_graph::{Edge, Node, RouteGraph};
pub use model::spline::Handles;
pub use model::tags::{
    BackgroundLine, OTHER_VEHICLE_TYPES, Orientation, Role, Station, Tags, VEHICLE_TYPES,
};
pub use model::told::Detail;
pub use model::zones::{Zone, ZoneRule};
pub use read::encoding::{FileText, SourceText};
pub use read::file::{BackgroundError, GraphError, MAX_FILE_BYTES, read_file, read_stream};
pub use read::{companions, parse, parse_fixed, read};
pub use regatta_base::bezier::CubicBezier;
pub use regatta_base::graph::{EdgeIndex, Ends, Gear, Leg, NodeIndex, Rotation, SMOOTH_TURN};
pub use write::{WRITTEN_FORMATS, write};
