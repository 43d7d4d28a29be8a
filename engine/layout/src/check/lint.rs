//! Warns about suspicious parts of a valid graph: headings that jump, nodes that can't be reached
//! or left, handles that look swapped.

use std::f64::consts::PI;

use regatta_base::graph::{Ends, Gear, Leg, NodeIndex, Rotation, SMOOTH_TURN};

use super::gaps::{MAX_JOINED_GAP, gaps_to_tell, obstacle};
use super::{coincident, copies, facilities};
use crate::model::angle::normalize_angle;
use crate::model::components::Components;
use crate::model::finding::{FindingKind, Report, Severity, Subject};
use crate::model::raw::{RawCurve, RawGraph};
use crate::model::route_graph::{RouteGraph, legs};
use crate::model::spline::{HandleLengths, Handles, spline};
use crate::model::tags::Orientation;
use crate::model::value::{duration, plural, shorten};

/// The largest number of nodes that a warning lists.
const MAX_EXAMPLES: usize = 5;

/// The largest number of nodes with a warning of their own about headings that jump there.
const MAX_JUMPS: usize = 10;

/// The other handle convention is suggested if it shortens the curves to less than this fraction of
/// their length.
const CLEARLY_SHORTER: f64 = 0.95;

/// The longest time in seconds that robots take for an edge without a warning.
const LONGEST_DRIVE: f64 = 3600.0;

/// Reports warnings about `graph`, which was made from `raw` with the convention `handles`.
pub(crate) fn lint(graph: &RouteGraph, raw: &RawGraph, handles: Handles, report: &mut Report<'_>) {
    warn_of_swapped_handles(graph, raw, handles, report);
    warn_of_reverse_zero(graph, raw, report);
    warn_of_corners(graph, raw, report);
    warn_of_crawling(graph, raw, report);
    copies::warn_of_copies(graph, raw, report);
    facilities::lint(graph, raw, report);
    let mut linter = NodeLinter { graph, raw, report };
    linter.warn_of_jumps();
    linter.warn_of_forbidden_turns();
    linter.warn_of_missing_ways();
    linter.warn_of_unreachable();
    linter.warn_once(
        &coincident::nodes(graph),
        "it is at the same place as another node: robots can't stand at both; join them if they \
         are one",
    );
    linter.warn_of_gaps();
    linter.warn_of_ids_as_names();
    linter.warn_of_repeated_names();
    linter.warn_of_chargers_with_loads();
}

/// Compares the total length of the splines with unequal handles under both conventions.
fn warn_of_swapped_handles(
    graph: &RouteGraph,
    raw: &RawGraph,
    handles: Handles,
    report: &mut Report<'_>,
) {
    let (mut length, mut other_length) = (0.0, 0.0);
    for (edge, raw_edge) in graph.edges().iter().zip(&raw.edges) {
        let (Some(RawCurve::Spline), Some(forward), Some(backward)) =
            (&raw_edge.curve, raw_edge.forward, raw_edge.backward)
        else {
            continue;
        };
        if forward == backward {
            continue;
        }
        let (from, to) = (graph.node(edge.origin), graph.node(edge.destination));
        length += edge.path.length();
        other_length +=
            spline(from, to, HandleLengths { forward, backward }, handles.other()).length();
    }
    if other_length < CLEARLY_SHORTER * length {
        let message = format!(
            "the curves with unequal handles are {length:.1} m long with `Handles: {}`, and \
             {other_length:.1} m with `Handles: {}`: if the latter is meant, add it to the file",
            handles.name(),
            handles.other().name()
        );
        report.warning(0, Subject::File, message);
    }
}

/// Warns if edge 0 may be driven in reverse gear: a route can't distinguish -0 from 0.
fn warn_of_reverse_zero(graph: &RouteGraph, raw: &RawGraph, report: &mut Report<'_>) {
    let Some(index) = graph.edge_by_id(0) else { return };
    if graph.edge(index).reverse_speed.is_some() {
        let message = "routes refer to an edge in reverse gear as -Id, which is impossible for 0: \
                       give it another Id";
        report.warning(raw.edges[index.0 as usize].at, Subject::Edge(Some(0)), message);
    }
}

/// Warns of edges with corners within their curves: robots turn at nodes only.
fn warn_of_corners(graph: &RouteGraph, raw: &RawGraph, report: &mut Report<'_>) {
    let tangential = graph
        .edges()
        .iter()
        .zip(&raw.edges)
        .filter(|(edge, _)| !matches!(edge.orientation, Orientation::Fixed(_)));
    let corners: Vec<_> = tangential
        .map(|(edge, raw)| (edge.path.largest_corner(), raw))
        .filter(|(angle, _)| *angle > SMOOTH_TURN)
        .collect();
    let Some((angle, worst)) = corners.iter().max_by(|a, b| a.0.total_cmp(&b.0)) else { return };
    let others = match corners.len() {
        1 => String::new(),
        count => format!(" (and in {})", plural(count - 1, "more edge")),
    };
    let message = format!(
        "the curve has a corner of {:.1}° within{others}: robots turn at nodes only, so that their \
         heading jumps there; divide the edge at the corner with a node",
        angle.to_degrees()
    );
    worst.report(Severity::Warning, &message, report);
}

/// Warns of edges that take robots more than an hour: their speeds are in another unit, mostly.
fn warn_of_crawling(graph: &RouteGraph, raw: &RawGraph, report: &mut Report<'_>) {
    let timed = legs(graph.edges()).filter_map(|leg| {
        let speed = graph.leg_speed(leg)?;
        Some((leg, speed, graph.edge(leg.edge).path.length() / speed))
    });
    let slow: Vec<_> = timed.filter(|(.., seconds)| *seconds > LONGEST_DRIVE).collect();
    let Some(&(leg, speed, seconds)) = slow.iter().max_by(|a, b| a.2.total_cmp(&b.2)) else {
        return;
    };
    let gear = match leg.gear {
        Gear::Forward => "",
        Gear::Reverse => " in reverse gear",
    };
    let others = match slow.len() - 1 {
        0 => String::new(),
        more => format!(" (and over an hour for {})", plural(more, "more edge")),
    };
    let message = format!(
        "robots take {} to drive it{gear}, at {speed} m/s{others}: check the speed and its unit",
        duration(seconds)
    );
    raw.edges[leg.edge.0 as usize].report(Severity::Warning, &message, report);
}

/// Reports the warnings about single nodes.
struct NodeLinter<'a, 'r, 'text> {
    graph: &'a RouteGraph,
    raw: &'a RawGraph,
    report: &'r mut Report<'text>,
}

impl NodeLinter<'_, '_, '_> {
    fn warn(&mut self, node: NodeIndex, message: &str) {
        self.raw.nodes[node.0 as usize].report(Severity::Warning, message, self.report);
    }

    /// Reports one warning for all nodes in layouts of other systems, and in those made of them:
    /// their lanes are straight, so that robots turn at nearly all nodes. Otherwise there is one
    /// for each node.
    fn warn_of_jumps(&mut self) {
        let jumps = jumps(self.graph);
        if jumps.is_empty() {
            return;
        }
        if self.raw.is_imported || jumps.len() > MAX_JUMPS {
            return self.count_jumps(jumps.len());
        }
        for (node, jump, count) in jumps {
            self.warn_of_jump(node, jump, count);
        }
    }

    /// Reports one warning for all nodes where robots would have to turn, but an edge forbids it.
    fn warn_of_forbidden_turns(&mut self) {
        let nodes = forbidden_turns(self.graph);
        let message = "the rotation `none` of an edge forbids turns here, and so robots drive on \
                       at full speed while their heading jumps: allow turns, or make the edges \
                       meet smoothly";
        self.warn_once(&nodes, message);
    }

    fn count_jumps(&mut self, nodes: usize) {
        let message = format!(
            "the heading changes by more than {:.0}° at {}: robots turn there if their type has a \
             max_rotation_speed; otherwise their heading jumps",
            SMOOTH_TURN.to_degrees(),
            plural(nodes, "node")
        );
        let kind = FindingKind::TurnsAtNodes;
        self.report.add_kind(kind, Severity::Warning, 0, Subject::File, message);
    }

    fn warn_of_jump(&mut self, node: NodeIndex, Jump { angle, from, to }: Jump, count: usize) {
        let others = match count {
            1 => String::new(),
            count => format!(" (and after {})", plural(count - 1, "more edge")),
        };
        let message = format!(
            "the heading changes by {:.1}° from edge {} to edge {}{others}: robots turn there if \
             their type has a max_rotation_speed; otherwise their heading jumps; to drive on \
             smoothly, make one of them a Spline, or turn the node",
            angle.to_degrees(),
            leg_name(self.graph, from),
            leg_name(self.graph, to),
        );
        self.warn(node, &message);
    }

    fn warn_of_missing_ways(&mut self) {
        let mut connected = vec![false; self.graph.nodes().len()];
        for edge in self.graph.edges() {
            connected[edge.origin.0 as usize] = true;
            connected[edge.destination.0 as usize] = true;
        }
        let (mut ends, mut loose) = (Vec::new(), Vec::new());
        for (node, is_connected) in (0..).map(NodeIndex).zip(connected) {
            if !is_connected {
                loose.push(node);
            } else if self.graph.departures(node).is_empty() {
                ends.push(node);
            }
        }
        self.warn_once(&ends, "no way out: no edge leaves it, robots that arrive can't leave");
        self.warn_once(&loose, "unreachable: no edge starts or ends here; connect it or remove it");
    }

    /// Reports one warning for all nodes of a kind, at the first of them.
    fn warn_once(&mut self, nodes: &[NodeIndex], message: &str) {
        let Some((&first, others)) = nodes.split_first() else { return };
        if others.is_empty() {
            return self.warn(first, message);
        }
        let names: Vec<_> = others.iter().take(MAX_EXAMPLES).map(|&node| self.name(node)).collect();
        let dots = if others.len() > MAX_EXAMPLES { ", …" } else { "" };
        let count = plural(others.len(), "more node");
        self.warn(first, &format!("{message} (and {count}: {}{dots})", names.join(", ")));
    }

    fn name(&self, node: NodeIndex) -> String {
        let node = self.graph.node(node);
        node.name().map_or_else(|| node.id.to_string(), |name| format!("`{}`", shorten(name)))
    }

    /// Warns of ends of roads that nearly meet another node.
    fn warn_of_gaps(&mut self) {
        let gaps = gaps_to_tell(self.raw);
        let Some(first) = gaps.first() else { return };
        let other = self.name(NodeIndex(first.other as u32));
        let [node, other_node] = [first.end, first.other].map(|index| &self.raw.nodes[index]);
        let remedy = match obstacle(self.raw, node, other_node) {
            None if first.distance > MAX_JOINED_GAP => {
                format!("`graph check --fix` joins ends up to {MAX_JOINED_GAP:.2} m apart only")
            }
            None => "`graph check --fix` joins them".to_owned(),
            Some(reason) => format!("`graph check --fix` doesn't join them, as {reason}"),
        };
        let message = format!(
            "a road ends here, {:.3} m from node {other}, and no edge joins them: if they are one \
             place, make them one node; {remedy}",
            first.distance
        );
        let ends: Vec<NodeIndex> = gaps.iter().map(|gap| NodeIndex(gap.end as u32)).collect();
        self.warn_once(&ends, &message);
    }

    /// Warns of nodes whose name is the id of another one: which of both is meant depends on where
    /// it is written.
    fn warn_of_ids_as_names(&mut self) {
        let nodes = (0..).map(NodeIndex).zip(self.graph.nodes());
        let confusing = nodes.filter(|(index, node)| {
            let id = node.name().and_then(|name| name.parse().ok());
            id.and_then(|id| self.graph.node_by_id(id)).is_some_and(|other| other != *index)
        });
        let confusing: Vec<NodeIndex> = confusing.map(|(index, _)| index).collect();
        self.warn_once(
            &confusing,
            "its name is the id of another node: orders, loads and commands mean the node with \
             the name, and `node: ID` of a scenario's robots the one with the id; rename it",
        );
    }

    /// Warns of chargers at which loads are handled.
    fn warn_of_chargers_with_loads(&mut self) {
        let places = self.graph.chargers().into_iter().zip(self.graph.purposes());
        let places = (0..).map(NodeIndex).zip(places);
        let both: Vec<NodeIndex> = places
            .filter(|(_, (is_charger, role))| *is_charger && role.handles_loads())
            .map(|(node, _)| node)
            .collect();
        self.warn_once(
            &both,
            "it is a charger and a station for loads: robots charge while they handle loads there, \
             and aren't sent there to charge",
        );
    }

    /// Warns of names beside ids that several nodes have, so that none of them can be found by it.
    /// A repeated name that is the only one of its nodes, such as a label of our own format, is
    /// told when it is used.
    fn warn_of_repeated_names(&mut self) {
        for (name, nodes) in self.graph.repeated_names() {
            if nodes.iter().all(|node| self.graph.node(*node).name() == Some(&name)) {
                continue;
            }
            let message = format!(
                "several nodes have the name `{}`: orders and commands can't name one of them so; \
                 use its id, or rename it",
                shorten(&name)
            );
            self.warn_once(&nodes, &message);
        }
    }

    /// Reports one warning for each strongly connected component that no leg enters, except the
    /// main one.
    fn warn_of_unreachable(&mut self) {
        let strong = Components::strong(self.graph);
        let main = Some(strong.main(self.graph));
        let main = main.filter(|&main| strong.sizes.get(main as usize) > Some(&1));
        let mut entered = vec![false; strong.sizes.len()];
        for leg in legs(self.graph.edges()) {
            let (from, to) = (self.graph.leg_start(leg), self.graph.leg_end(leg));
            let (from, to) = (strong.of_node[from.0 as usize], strong.of_node[to.0 as usize]);
            entered[to as usize] |= from != to;
        }
        let (mut starts, mut parts) = (Vec::new(), Vec::new());
        for (node, &component) in (0..).map(NodeIndex).zip(&strong.of_node) {
            let isolated =
                strong.sizes[component as usize] == 1 && self.graph.departures(node).is_empty();
            // Marked as entered, so that the other nodes of the component aren't reported.
            if !std::mem::replace(&mut entered[component as usize], true)
                && Some(component) != main
                && !isolated
            {
                let size = strong.sizes[component as usize];
                if size == 1 { starts.push(node) } else { parts.push((node, size)) }
            }
        }
        self.warn_once(&starts, "unreachable: no edge leads to it, robots can only start here");
        let Some((&(node, size), others)) = parts.split_first() else { return };
        let more = match others.len() {
            0 => String::new(),
            count => format!(" (and to {} of two or more)", plural(count, "more part")),
        };
        let message = format!(
            "unreachable: no edge leads from the rest of the graph to this part of {size} \
             nodes{more}"
        );
        self.warn(node, &message);
    }
}

/// A leg with the heading of robots at one of its ends, in radians.
#[derive(Clone, Copy)]
struct LegHeading {
    heading: f64,
    leg: Leg,
}

/// A change of the heading from one leg to the next, in radians.
struct Jump {
    angle: f64,
    from: Leg,
    to: Leg,
}

/// Returns the nodes where the heading jumps. Each has its largest jump, and the number of arriving
/// legs with a jump.
fn jumps(graph: &RouteGraph) -> Vec<(NodeIndex, Jump, usize)> {
    let mut arrivals: Vec<(NodeIndex, LegHeading)> = legs(graph.edges())
        .map(|leg| (graph.leg_end(leg), leg_heading(graph, leg, leg.gear == Gear::Forward)))
        .collect();
    arrivals.sort_by_key(|&(node, _)| node);
    let mut found = Vec::new();
    for arrivals in arrivals.chunk_by(|a, b| a.0 == b.0) {
        let node = arrivals[0].0;
        let departures = sorted_departures(graph, node);
        let jumps: Vec<Jump> =
            arrivals.iter().filter_map(|&(_, arrival)| worst_jump(arrival, &departures)).collect();
        let count = jumps.len();
        if let Some(worst) = jumps.into_iter().max_by(|a, b| a.angle.total_cmp(&b.angle)) {
            found.push((node, worst, count));
        }
    }
    found
}

/// Returns the nodes where the heading jumps from a leg to a next one, and one of them forbids
/// turns.
fn forbidden_turns(graph: &RouteGraph) -> Vec<NodeIndex> {
    let ends = graph.edges().iter().flat_map(|edge| {
        let Ends { origin, destination } = edge.rotation;
        [(edge.origin, origin), (edge.destination, destination)]
    });
    let mut nodes: Vec<NodeIndex> =
        ends.filter(|(_, rotation)| *rotation == Rotation::None).map(|(node, _)| node).collect();
    nodes.sort_unstable();
    nodes.dedup();
    let mut found: Vec<NodeIndex> = Vec::new();
    for leg in legs(graph.edges()) {
        let node = graph.leg_end(leg);
        if nodes.binary_search(&node).is_err() || found.last() == Some(&node) {
            continue;
        }
        let arrival = leg_heading(graph, leg, leg.gear == Gear::Forward);
        let departures = sorted_departures(graph, node);
        let has_jump = departures.iter().any(|departure| {
            let angle = normalize_angle(departure.heading - arrival.heading).abs();
            angle > SMOOTH_TURN
                && (forbids_turns(graph, leg, node) || forbids_turns(graph, departure.leg, node))
        });
        if has_jump {
            found.push(node);
        }
    }
    found.sort_unstable();
    found.dedup();
    found
}

/// Whether the edge of a leg forbids turns at one of its ends.
fn forbids_turns(graph: &RouteGraph, leg: Leg, node: NodeIndex) -> bool {
    let edge = graph.edge(leg.edge);
    let Ends { origin, destination } = edge.rotation;
    let rotation = if edge.destination == node { destination } else { origin };
    rotation == Rotation::None
}

/// Returns the legs that leave a node with their headings there, by ascending heading.
fn sorted_departures(graph: &RouteGraph, node: NodeIndex) -> Vec<LegHeading> {
    let legs = graph.departures(node).iter();
    let mut departures: Vec<LegHeading> =
        legs.map(|&leg| leg_heading(graph, leg, leg.gear == Gear::Reverse)).collect();
    departures.sort_by(|a, b| a.heading.total_cmp(&b.heading));
    departures
}

/// Returns a leg with the heading at one end of its edge, which is the same in either gear.
fn leg_heading(graph: &RouteGraph, leg: Leg, at_destination: bool) -> LegHeading {
    let edge = graph.edge(leg.edge);
    let tangent = if at_destination { edge.path.end_tangent() } else { edge.path.start_tangent() };
    LegHeading { heading: edge.orientation.heading(tangent.to_angle()), leg }
}

/// Returns the departure with the largest heading jump from an arrival, if that jump is too large.
/// It is one of the two departures next to the opposite heading, so not every pair is compared.
fn worst_jump(arrival: LegHeading, departures: &[LegHeading]) -> Option<Jump> {
    let opposite = normalize_angle(arrival.heading + PI);
    let above = departures.partition_point(|departure| departure.heading < opposite);
    let below = above.checked_sub(1).or(departures.len().checked_sub(1))?;
    [departures[above % departures.len()], departures[below]]
        .map(|departure| Jump {
            angle: normalize_angle(departure.heading - arrival.heading).abs(),
            from: arrival.leg,
            to: departure.leg,
        })
        .into_iter()
        .max_by(|a, b| a.angle.total_cmp(&b.angle))
        .filter(|jump| jump.angle > SMOOTH_TURN)
}

fn leg_name(graph: &RouteGraph, leg: Leg) -> String {
    let id = graph.edge(leg.edge).id;
    match leg.gear {
        Gear::Forward => id.to_string(),
        Gear::Reverse => format!("-{id}"),
    }
}
