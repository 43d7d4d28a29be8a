//! The model of a layout: a route graph, before and after its validation.

pub mod angle;
pub mod apart;
pub mod change;
pub mod components;
pub mod drawn;
pub mod facilities;
pub mod finding;
pub mod format;
pub mod info;
pub(crate) mod keys;
pub mod nurbs;
pub mod options;
pub mod path;
pub(crate) mod raw;
pub(crate) mod route_graph;
pub mod spline;
pub mod tags;
pub(crate) mod told;
pub(crate) mod value;
pub(crate) mod values;
pub mod zones;
