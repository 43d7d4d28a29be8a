//! Writers of layouts: they turn a [`RouteGraph`] into a text, and list what the format can't say.

pub mod lif;
pub(crate) mod nav2;
mod open_tcs;
pub(crate) mod regatta;

use crate::model::format::{Format, Written};
use crate::model::route_graph::RouteGraph;

/// Writes a graph in a format; `None` if there is no writer for it.
pub fn write(graph: &RouteGraph, format: Format) -> Option<Written> {
    match format {
        Format::Regatta => Some(regatta::write(graph)),
        Format::Lif => Some(lif::write(graph)),
        Format::Nav2 => Some(nav2::write(graph)),
        Format::OpenTcs => Some(open_tcs::write(graph)),
        Format::OpenRmf
        | Format::OpenRmfBuilding
        | Format::MovingAi
        | Format::Dxf
        | Format::Csv
        | Format::RosMap => None,
    }
}
