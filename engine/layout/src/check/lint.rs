//! Warns about suspicious parts of a valid graph: headings that jump, nodes that can't be reached
//! or left, handles that look swapped.

use std::f64::consts::PI;

use regatta_base::graph::{EdgeIndex, Gear, Leg, NodeIndex, SMOOTH_TURN};

use crate::model::angle::normalize_angle;
use crate::model::components::Components;
use crate::model::finding::{Report, Subject};
use crate::model::raw::{RawCurve, RawGraph};
use crate::model::route_graph::{Edge, RouteGraph};
use crate::model::spline::{HandleLengths, Handles, spline};
use crate::model::tags::Orientation;
use crate::model::value::{plural, shorten};

/// The largest number of nodes that a warning lists.
const MAX_EXAMPLES: usize = 5;

/// Part of the warning of turns at nodes, which is of no use where all robots turn.
pub const TURNS_IF: &str = "robots turn there if their type has a max_rotation_speed";

/// The other handle convention is suggested if it makes the curves shorter than this fraction of
/// their length.
const CLEARLY_SHORTER: f64 = 0.95;

/// Reports warnings about `graph`, which was made from `raw` with the convention `handles`.
pub(crate) fn lint(graph: &RouteGraph, raw: &RawGraph, handles: Handles, report: &mut Report<'_>) {
    warn_of_swapped_handles(graph, raw, handles, report);
    warn_of_reverse_zero(graph, raw, report);
    warn_of_corners(graph, raw, report);
    let mut linter = NodeLinter { graph, raw, report };
    if raw.is_imported {
        linter.count_jumps();
    } else {
        linter.warn_of_jumps();
    }
    linter.warn_of_dead_ends();
    linter.warn_of_unreachable();
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
            "the curves with unequal handles are {length:.1} m long with `Handles: {}`, and {other_length:.1} m with \
             `Handles: {}`: if the latter is meant, add it to the file",
            handles.name(),
            handles.other().name()
        );
        report.warning(0, Subject::File, message);
    }
}

/// A route can't distinguish -0 from 0.
fn warn_of_reverse_zero(graph: &RouteGraph, raw: &RawGraph, report: &mut Report<'_>) {
    let Some(index) = graph.edge_by_id(0) else { return };
    if graph.edge(index).reverse_speed.is_some() {
        let message = "routes refer to an edge in reverse gear as -Id, which is impossible for 0: give it another Id";
        report.warning(raw.edges[index.0 as usize].at, Subject::Edge(Some(0)), message);
    }
}

/// Robots turn at nodes only.
fn warn_of_corners(graph: &RouteGraph, raw: &RawGraph, report: &mut Report<'_>) {
    let corner = |edge: &Edge| match edge.orientation {
        Orientation::Fixed(_) => 0.0,
        Orientation::Tangential | Orientation::Offset(_) => edge.path.largest_corner(),
    };
    let corners = graph.edges().iter().zip(&raw.edges).map(|(edge, raw)| (corner(edge), raw));
    let corners: Vec<_> = corners.filter(|(angle, _)| *angle > SMOOTH_TURN).collect();
    let Some((angle, worst)) = corners.iter().max_by(|a, b| a.0.total_cmp(&b.0)) else { return };
    let count = match corners.len() {
        1 => String::new(),
        count => format!(" (and in {})", plural(count - 1, "more edge")),
    };
    let message = format!(
        "the curve has a corner of {:.1}° within{count}: robots turn at nodes only, so that their heading jumps there; \
         divide the edge at the corner with a node",
        angle.to_degrees()
    );
    let (subject, message) = worst.finding(message);
    report.warning(worst.at, subject, message);
}

/// Reports the warnings about single nodes.
struct NodeLinter<'a, 'r, 'text> {
    graph: &'a RouteGraph,
    raw: &'a RawGraph,
    report: &'r mut Report<'text>,
}

impl NodeLinter<'_, '_, '_> {
    fn warn(&mut self, node: NodeIndex, message: impl Into<String>) {
        let raw = &self.raw.nodes[node.0 as usize];
        let (subject, message) = raw.finding(message);
        self.report.warning(raw.at, subject, message);
    }

    /// Layouts of other systems have straight lanes, on which robots turn everywhere: that is worth
    /// one warning.
    fn count_jumps(&mut self) {
        let arrivals = sorted_arrivals(self.graph);
        let has_jump = |arrivals: &&[(NodeIndex, LegHeading)]| {
            let departures = sorted_departures(self.graph, arrivals[0].0);
            arrivals.iter().any(|&(_, arrival)| worst_jump(arrival, &departures).is_some())
        };
        let nodes = arrivals.chunk_by(|a, b| a.0 == b.0).filter(has_jump).count();
        if nodes > 0 {
            let message = format!(
                "the heading changes by more than {:.0}° at {}: {TURNS_IF}; otherwise their heading jumps",
                SMOOTH_TURN.to_degrees(),
                plural(nodes, "node")
            );
            self.report.warning(0, Subject::File, message);
        }
    }

    fn warn_of_jumps(&mut self) {
        for arrivals in sorted_arrivals(self.graph).chunk_by(|a, b| a.0 == b.0) {
            let node = arrivals[0].0;
            let departures = sorted_departures(self.graph, node);
            let jumps =
                || arrivals.iter().filter_map(|&(_, arrival)| worst_jump(arrival, &departures));
            let Some(worst) = jumps().max_by(|a, b| a.angle.total_cmp(&b.angle)) else { continue };
            let more = match jumps().count() {
                1 => String::new(),
                count => format!(" (and after {})", plural(count - 1, "more edge")),
            };
            let message = format!(
                "the heading jumps by {:.1}° from edge {} to edge {}{more}: make one of them a Spline, or turn the node",
                worst.angle.to_degrees(),
                leg_name(self.graph, worst.from),
                leg_name(self.graph, worst.to),
            );
            self.warn(node, message);
        }
    }

    fn warn_of_dead_ends(&mut self) {
        let mut connected = vec![false; self.graph.nodes().len()];
        for edge in self.graph.edges() {
            connected[edge.origin.0 as usize] = true;
            connected[edge.destination.0 as usize] = true;
        }
        let (connected, loose): (Vec<_>, Vec<_>) =
            (0..).map(NodeIndex).zip(connected).partition(|(_, connected)| *connected);
        let is_end = |(node, _): &(NodeIndex, bool)| self.graph.departures(*node).is_empty();
        let ends: Vec<NodeIndex> =
            connected.into_iter().filter(is_end).map(|(node, _)| node).collect();
        let loose: Vec<NodeIndex> = loose.into_iter().map(|(node, _)| node).collect();
        self.warn_once(&ends, "dead end: no edge leaves it, robots that arrive can't leave");
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
        self.warn(
            first,
            format!(
                "{message} (and {}: {}{dots})",
                plural(others.len(), "more node"),
                names.join(", ")
            ),
        );
    }

    fn name(&self, node: NodeIndex) -> String {
        let node = self.graph.node(node);
        node.name().map_or_else(|| node.id.to_string(), |name| format!("`{}`", shorten(name)))
    }

    /// Reports one warning for each strongly connected component that no leg enters, except the
    /// largest.
    fn warn_of_unreachable(&mut self) {
        let strong = Components::strong(self.graph);
        let main =
            Some(strong.largest()).filter(|&largest| strong.sizes.get(largest as usize) > Some(&1));
        let mut entered = vec![false; strong.sizes.len()];
        for (from, to) in
            legs(self.graph).map(|leg| (self.graph.leg_start(leg), self.graph.leg_end(leg)))
        {
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
            "unreachable: no edge leads from the rest of the graph to this part of {size} nodes{more}"
        );
        self.warn(node, message);
    }
}

/// Returns all legs.
fn legs(graph: &RouteGraph) -> impl Iterator<Item = Leg> + '_ {
    (0..).map(EdgeIndex).zip(graph.edges()).flat_map(|(edge, content)| {
        let reverse = content.reverse_speed.map(|_| Leg { edge, gear: Gear::Reverse });
        std::iter::once(Leg { edge, gear: Gear::Forward }).chain(reverse)
    })
}

/// The robot's heading in radians at one end of a leg, and the leg.
type LegHeading = (f64, Leg);

/// Returns every leg with its final node and its heading there.
fn arrivals(graph: &RouteGraph) -> Vec<(NodeIndex, LegHeading)> {
    legs(graph)
        .map(|leg| (graph.leg_end(leg), (heading(graph, leg, leg.gear == Gear::Forward), leg)))
        .collect()
}

/// Returns [`arrivals`] by node.
fn sorted_arrivals(graph: &RouteGraph) -> Vec<(NodeIndex, LegHeading)> {
    let mut arrivals = arrivals(graph);
    arrivals.sort_by_key(|&(node, _)| node);
    arrivals
}

/// Returns the legs that leave a node with their headings there, by ascending heading.
fn sorted_departures(graph: &RouteGraph, node: NodeIndex) -> Vec<LegHeading> {
    let mut departures: Vec<_> = graph
        .departures(node)
        .iter()
        .map(|&leg| (heading(graph, leg, leg.gear == Gear::Reverse), leg))
        .collect();
    departures.sort_by(|a, b| a.0.total_cmp(&b.0));
    departures
}

/// Returns the robot's heading at one end of an edge, which is the same in either gear.
fn heading(graph: &RouteGraph, leg: Leg, at_destination: bool) -> f64 {
    let edge = graph.edge(leg.edge);
    let tangent = if at_destination { edge.path.end_tangent() } else { edge.path.start_tangent() };
    edge.orientation.heading(tangent.to_angle())
}

struct Jump {
    angle: f64,
    from: Leg,
    to: Leg,
}

/// Returns the departure with the largest heading jump from an arrival, if that is too large. It is
/// one of the two departures next to the opposite heading, so that not every pair has to be
/// compared.
fn worst_jump((heading, from): LegHeading, departures: &[LegHeading]) -> Option<Jump> {
    let opposite = normalize_angle(heading + PI);
    let above = departures.partition_point(|departure| departure.0 < opposite);
    let neighbours = [above, above + departures.len().saturating_sub(1)];
    let jump = |at: usize| {
        let (departure, to) = *departures.get(at % departures.len().max(1))?;
        Some(Jump { angle: normalize_angle(departure - heading).abs(), from, to })
    };
    neighbours
        .into_iter()
        .filter_map(jump)
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
