//! Validates the zones of a file.

use std::collections::{BTreeMap, BTreeSet};

use regatta_base::graph::{EdgeIndex, NodeIndex};

use crate::model::finding::{Report, Subject};
use crate::model::raw::RawZone;
use crate::model::route_graph::RouteGraph;
use crate::model::tags::Tags;
use crate::model::value::shorten;
use crate::model::zones::{Zone, ZoneRule, inner_nodes};

/// The members of zones, by name.
#[derive(Default)]
struct Members {
    nodes: BTreeSet<NodeIndex>,
    edges: BTreeSet<EdgeIndex>,
}

/// Returns the zones with all of their members, or reports every error.
pub(super) fn check_zones(
    raw: &[RawZone],
    graph: &RouteGraph,
    report: &mut Report<'_>,
) -> Option<Vec<Zone>> {
    let mut tagged = tagged(raw, graph);
    let mut zones = Vec::with_capacity(raw.len());
    for zone in raw {
        let Some(mut members) = tagged.remove(zone.name.as_str()) else {
            let message =
                format!("zone `{}` is given twice: merge both into one", shorten(&zone.name));
            report.error(zone.at, Subject::File, message);
            continue;
        };
        for &id in &zone.nodes {
            match graph.node_by_id(id) {
                Some(node) => drop(members.nodes.insert(node)),
                None => report_unknown(zone, &format!("node {id}"), report),
            }
        }
        for &id in &zone.edges {
            match graph.edge_by_id(id) {
                Some(edge) => drop(members.edges.insert(edge)),
                None => report_unknown(zone, &format!("edge {id}"), report),
            }
        }
        let edges: Vec<EdgeIndex> = members.edges.into_iter().collect();
        let mut inner = Vec::new();
        if zone.rule == ZoneRule::SameDirection {
            inner.extend(inner_nodes(&edges, graph).difference(&members.nodes).copied());
        }
        let nodes: BTreeSet<NodeIndex> = members.nodes.iter().chain(&inner).copied().collect();
        if nodes.is_empty() && edges.is_empty() {
            let message = format!(
                "zone `{}` has no nodes and no edges: list some, or give them this Zone",
                shorten(&zone.name)
            );
            report.file_warning(zone.at, message);
        }
        zones.push(Zone {
            name: zone.name.as_str().into(),
            rule: zone.rule,
            nodes: nodes.into_iter().collect(),
            edges,
            inner,
        });
    }
    (!report.has_errors()).then_some(zones)
}

/// Returns the nodes and edges whose tags name a zone with a rule, by zone.
fn tagged<'raw>(raw: &'raw [RawZone], graph: &RouteGraph) -> BTreeMap<&'raw str, Members> {
    let mut tagged: BTreeMap<&str, Members> =
        raw.iter().map(|zone| (zone.name.as_str(), Members::default())).collect();
    if tagged.is_empty() {
        return tagged;
    }
    for (index, node) in (0..).map(NodeIndex).zip(graph.nodes()) {
        if let Some(members) = zone_of(node.tags.as_deref()).and_then(|zone| tagged.get_mut(zone)) {
            members.nodes.insert(index);
        }
    }
    for (index, edge) in (0..).map(EdgeIndex).zip(graph.edges()) {
        if let Some(members) = zone_of(edge.tags.as_deref()).and_then(|zone| tagged.get_mut(zone)) {
            members.edges.insert(index);
        }
    }
    tagged
}

fn zone_of(tags: Option<&Tags>) -> Option<&str> {
    tags?.zone.as_deref()
}

fn report_unknown(zone: &RawZone, member: &str, report: &mut Report<'_>) {
    let message = format!(
        "zone `{}` names {member}, which doesn't exist: add it or correct the id",
        shorten(&zone.name)
    );
    report.error(zone.at, Subject::File, message);
}

#[cfg(test)]
mod tests {
    use crate::model::options::ReadOptions;
    use crate::{ZoneRule, parse};

    const ROADS: &str = "Edges:
- {Id: 1, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, VelocityForward: 1, Zone: a}
- {Id: 2, Origin_ID: 2, Destination_ID: 3, CurveType: Linear, VelocityForward: 1}
Vertices:
- {Id: 1, X: 0, Y: 0, Theta: 0}
- {Id: 2, X: 4, Y: 0, Theta: 0, Zone: b}
- {Id: 3, X: 8, Y: 0, Theta: 0, Zone: a}
Zones:
";

    #[test]
    fn members_are_those_listed_and_those_that_name_the_zone() {
        let text = format!(
            "{ROADS}- {{Name: a, Capacity: 2, Nodes: [2], Edges: [2, 2]}}\n\
             - {{Name: c, Rule: same_direction, Edges: [1]}}\n"
        );
        let (graph, findings) =
            parse(&text, "a.yaml", &ReadOptions::default()).expect("a valid graph");
        assert_eq!(findings.errors(), 0);
        let [first, second] = graph.zones() else { panic!("{:?}", graph.zones()) };
        let (nodes, edges): (Vec<u32>, Vec<u32>) = (
            first.nodes.iter().map(|node| graph.node(*node).id).collect(),
            first.edges.iter().map(|edge| graph.edge(*edge).id).collect(),
        );
        assert_eq!((nodes, edges), (vec![2, 3], vec![1, 2]));
        assert!(matches!(first.rule, ZoneRule::Capacity(count) if count.get() == 2));
        assert_eq!((second.rule, second.edges.len()), (ZoneRule::SameDirection, 1));
        let written = crate::write(&graph, crate::Format::Regatta).expect("a writer");
        let (again, _) = parse(&written.text, "b.yaml", &ReadOptions::default()).expect("valid");
        assert_eq!(again.zones(), graph.zones());
    }

    /// A corridor that is driven both ways: who stands at one of its ends is outside of it, unless
    /// no road leads on from there.
    #[test]
    fn the_ends_of_a_corridor_are_no_members() {
        let members = |roads: &str| {
            let text = format!(
                "Edges:\n{roads}Vertices:\n\
                 - {{Id: 1, X: 0, Y: 0, Theta: 0}}\n- {{Id: 2, X: 4, Y: 0, Theta: 0}}\n\
                 - {{Id: 3, X: 8, Y: 0, Theta: 0}}\n- {{Id: 4, X: 4, Y: 9, Theta: 0}}\n\
                 Zones:\n- {{Name: c, Rule: same_direction, Edges: [1, 2, 3, 4]}}\n"
            );
            let (graph, _) = parse(&text, "a.yaml", &ReadOptions::default()).expect("valid");
            let nodes = graph.zones()[0].nodes.iter();
            nodes.map(|node| graph.node(*node).id).collect::<Vec<u32>>()
        };
        let road = |id: u32, from: u32, to: u32| {
            format!(
                "- {{Id: {id}, Origin_ID: {from}, Destination_ID: {to}, CurveType: Linear, \
                 VelocityForward: 1}}\n"
            )
        };
        let corridor = [road(1, 1, 2), road(2, 2, 3), road(3, 3, 2), road(4, 2, 1)].concat();
        assert_eq!(members(&format!("{corridor}{}{}", road(5, 3, 4), road(6, 4, 1))), [2]);
        assert_eq!(members(&format!("{corridor}{}{}", road(5, 3, 4), road(6, 4, 3))), [1, 2]);
    }

    #[test]
    fn errors_name_the_zone_and_what_is_wrong() {
        for (zone, expected) in [
            ("{Capacity: 1}", "a zone has no Name: give one"),
            ("{Name: a}", "a zone has no rule: give a Capacity, or Rule"),
            ("{Name: a, Capacity: 0}", "Capacity is 0: it must be a whole number of robots"),
            ("{Name: a, Capacity: 1.5}", "Capacity is 1.5: it must be a whole number of robots"),
            ("{Name: a, Rule: alone}", "a zone has no rule"),
            ("{Name: a, Capacity: 1, Edges: [7]}", "zone `a` names edge 7, which doesn't exist"),
            ("{Name: a, Capacity: 1, Nodes: [0.5]}", "Nodes must list ids"),
            ("{Name: a, Rule: exclusive}\n- {Name: a, Capacity: 1}", "zone `a` is given twice"),
        ] {
            let text = format!("{ROADS}- {zone}\n");
            let error = parse(&text, "a.yaml", &ReadOptions::default()).expect_err(zone);
            assert!(error.to_string().contains(expected), "{zone}: {error}");
        }
    }
}
