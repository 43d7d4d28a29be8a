//! Edges that are the same road as another one.

use std::collections::{BTreeMap, BTreeSet};

use crate::model::finding::{Report, Severity};
use crate::model::raw::RawGraph;
use crate::model::route_graph::{Edge, RouteGraph};
use crate::model::tags::{OTHER_VEHICLE_TYPES, VEHICLE_TYPES};
use crate::model::value::plural;

/// Warns of edges that are the same road as an earlier one: robots on them are in each other's way.
pub(super) fn warn_of_copies(graph: &RouteGraph, raw: &RawGraph, report: &mut Report<'_>) {
    let mut by_ends: BTreeMap<_, Vec<&Edge>> = BTreeMap::new();
    let mut copies = Vec::new();
    for (edge, raw) in graph.edges().iter().zip(&raw.edges) {
        let earlier = by_ends.entry((edge.origin, edge.destination)).or_default();
        let same = earlier.iter().find(|other| {
            other.path == edge.path
                && other.orientation == edge.orientation
                && level(other) == level(edge)
                && share_vehicle_types(other, edge)
        });
        if let Some(other) = same {
            copies.push((raw, other.id));
        } else {
            earlier.push(edge);
        }
    }
    let Some((first, other)) = copies.first() else { return };
    let others = match copies.len() - 1 {
        0 => String::new(),
        more => format!(" (and so for {})", plural(more, "more edge")),
    };
    let message = format!(
        "it is the same road as edge {other}{others}: robots on both are in each other's way; \
         remove it"
    );
    first.report(Severity::Warning, &message, report);
}

/// Whether robots of a vehicle type drive on both of two edges: `false` only if each names its
/// types, and none is the same.
fn share_vehicle_types(a: &Edge, b: &Edge) -> bool {
    let [types, others] = [a, b].map(vehicle_types);
    types.is_empty() || others.is_empty() || !types.is_disjoint(&others)
}

fn vehicle_types(edge: &Edge) -> BTreeSet<&str> {
    let properties = edge.tags.iter().map(|tags| &tags.properties);
    let keys = properties
        .flat_map(|properties| [VEHICLE_TYPES, OTHER_VEHICLE_TYPES].map(|key| properties.get(key)));
    keys.flatten().flat_map(|types| types.split(", ")).collect()
}

fn level(edge: &Edge) -> Option<&str> {
    edge.tags.as_ref()?.level.as_deref()
}

#[cfg(test)]
mod tests {
    use crate::model::options::ReadOptions;
    use crate::parse;

    #[test]
    fn edges_of_different_vehicle_types_are_no_copies() {
        let told = |types: [&str; 2]| {
            let edges = [1, 2].map(|id| {
                format!(
                    "{{\"edgeId\": \"{id}\", \"startNodeId\": \"1\", \"endNodeId\": \"2\", \
                     \"vehicleTypeEdgeProperties\": [{{\"vehicleTypeId\": \"{}\", \
                     \"maxSpeed\": 1}}]}}",
                    types[id - 1]
                )
            });
            let nodes = [1, 2].map(|id| {
                format!("{{\"nodeId\": \"{id}\", \"nodePosition\": {{\"x\": {id}, \"y\": 0}}}}")
            });
            let text = format!(
                "{{\"layouts\": [{{\"nodes\": [{}], \"edges\": [{}]}}]}}",
                nodes.join(","),
                edges.join(",")
            );
            let (_, findings) = parse(&text, "p.json", &ReadOptions::default()).expect("a graph");
            findings.as_slice().iter().any(|found| found.message.contains("the same road"))
        };
        assert!(told(["fork", "fork"]), "robots of one type meet on both");
        assert!(!told(["fork", "tug"]), "each is for robots of another type");
    }
}
