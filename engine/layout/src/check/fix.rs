//! Repairs errors that have one obvious correction: angles in degrees, duplicate edges, edges
//! without length, ends that nearly meet.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec2;
use regatta_base::bezier::CubicBezier;

use super::validate::{MAX_GAP, SUSPICIOUS_ANGLE, to_radians};
use crate::model::angle::normalize_angle;
use crate::model::raw::{RawCurve, RawEdge, RawGraph, RawNode};
use crate::model::tags::Tags;
use crate::model::value::shorten;

/// The distance in metres up to which ends that don't meet are joined.
pub const MAX_JOINED_GAP: f64 = 0.05;

/// The difference of headings in radians up to which nodes are joined: 5°.
const MAX_JOINED_TURN: f64 = regatta_base::graph::SMOOTH_TURN;

/// Repairs a graph. Returns the repairs, one line each.
pub(crate) fn fix(raw: &mut RawGraph) -> Vec<String> {
    let mut fixes = Vec::new();
    fixes.extend(fix_angle_unit(raw));
    fixes.extend(remove_duplicate_edges(raw));
    fixes.extend(remove_loops(raw));
    fixes.extend(join_ends(raw));
    fixes.extend(move_curve_ends(raw));
    fixes
}

/// Removes straight edges from a node to itself, which have no length.
fn remove_loops(raw: &mut RawGraph) -> Vec<String> {
    let loops = raw.edges.extract_if(.., |edge| {
        edge.origin.is_some()
            && edge.origin == edge.destination
            && matches!(edge.curve, None | Some(RawCurve::Linear))
    });
    loops.map(|edge| format!("{}: removed, it leads from a node to itself", name(&edge))).collect()
}

/// Moves the ends of curves, with their handles, to the nodes that they nearly meet.
fn move_curve_ends(raw: &mut RawGraph) -> Vec<String> {
    let nodes = raw.nodes.iter().filter_map(|node| Some((node.id?, position(node)?)));
    let positions: BTreeMap<u32, DVec2> = nodes.collect();
    let mut fixes = Vec::new();
    for edge in &mut raw.edges {
        let [from, to] =
            [edge.origin, edge.destination].map(|id| id.and_then(|id| positions.get(&id)).copied());
        let Some(RawCurve::Cubics(cubics)) = &mut edge.curve else { continue };
        let mut gap: f64 = 0.0;
        if let (Some(node), Some(CubicBezier { control_points: [end, handle, ..] })) =
            (from, cubics.first_mut())
        {
            gap = gap.max(move_end(end, handle, node));
        }
        if let (Some(node), Some(CubicBezier { control_points: [.., handle, end] })) =
            (to, cubics.last_mut())
        {
            gap = gap.max(move_end(end, handle, node));
        }
        if gap > 0.0 {
            fixes.push(format!("{}: its curve ends at its nodes now, {gap:.3} m away", name(edge)));
        }
    }
    fixes
}

/// Moves an end of a curve to a node that it nearly meets. Returns the distance; 0 if it stays.
fn move_end(end: &mut DVec2, handle: &mut DVec2, node: DVec2) -> f64 {
    let shift = node - *end;
    let gap = shift.length();
    if !(MAX_GAP..=MAX_JOINED_GAP).contains(&gap) {
        return 0.0;
    }
    *end = node;
    *handle += shift;
    gap
}

fn fix_angle_unit(raw: &mut RawGraph) -> Option<String> {
    let of_nodes = raw.nodes.iter().filter_map(|node| node.theta);
    let mut angles = of_nodes.chain(raw.edges.iter().filter_map(|edge| edge.orientation.angle()));
    if raw.degrees || !angles.any(|angle| angle.abs() > SUSPICIOUS_ANGLE) {
        return None;
    }
    if !raw.is_imported {
        raw.degrees = true;
        return Some("the headings are in degrees: `AngleUnit: deg`".to_owned());
    }
    // Headings that the file doesn't give are computed from edges, in radians.
    for node in raw.nodes.iter_mut().filter(|node| node.has_heading) {
        node.theta = node.theta.map(f64::to_radians);
    }
    for edge in &mut raw.edges {
        edge.orientation = edge.orientation.map(f64::to_radians);
    }
    Some("the headings of nodes and edges are in degrees: converted to radians".to_owned())
}

/// Removes edges that equal an earlier one. Gives a new id to other edges that repeat an earlier
/// id.
fn remove_duplicate_edges(raw: &mut RawGraph) -> Vec<String> {
    let mut fixes = Vec::new();
    let mut next_id = raw.edges.iter().filter_map(|edge| edge.id).max().unwrap_or(0);
    let mut by_ends: BTreeMap<_, Vec<RawEdge>> = BTreeMap::new();
    let mut ids = BTreeSet::new();
    let mut kept = Vec::with_capacity(raw.edges.len());
    for mut edge in std::mem::take(&mut raw.edges) {
        let earlier = by_ends.entry((edge.origin, edge.destination)).or_default();
        if let Some(other) = earlier.iter().find(|other| is_same(other, &edge)) {
            fixes.push(format!("{}: removed, it is the same as {}", name(&edge), name(other)));
            continue;
        }
        if let Some(id) = edge.id.filter(|id| !ids.insert(*id))
            && let Some(free) = next_id.checked_add(1)
        {
            next_id = free;
            edge.id = Some(free);
            ids.insert(free);
            fixes.push(format!("edge {id}: the second one with this id is now edge {free}"));
        }
        earlier.push(edge.clone());
        kept.push(edge);
    }
    raw.edges = kept;
    fixes
}

/// Whether two edges are equal, apart from their ids and names.
fn is_same(a: &RawEdge, b: &RawEdge) -> bool {
    let [tags_a, tags_b] =
        [a, b].map(|edge| Tags { name: None, ..edge.tags.as_deref().cloned().unwrap_or_default() });
    a.origin.is_some()
        && (&a.curve, a.forward, a.backward) == (&b.curve, b.forward, b.backward)
        && (a.speed, a.reverse_speed) == (b.speed, b.reverse_speed)
        && (a.orientation, a.rotation) == (b.orientation, b.rotation)
        && tags_a == tags_b
}

fn name(edge: &RawEdge) -> String {
    let id = edge.id.map_or_else(|| "without id".to_owned(), |id| id.to_string());
    match edge.tags.as_ref().and_then(|tags| tags.name.as_deref()) {
        Some(name) => format!("edge {id} (`{}`)", shorten(name)),
        None => format!("edge {id}"),
    }
}

/// Joins nodes at nearly the same place and with nearly the same heading, if one of them is a loose
/// end: a node at which edges only end, or only start.
fn join_ends(raw: &mut RawGraph) -> Vec<String> {
    let loose = loose_ends(raw);
    let mut joined: BTreeMap<u32, u32> = BTreeMap::new();
    let mut fixes = Vec::new();
    let grid = cells(&raw.nodes);
    for node in &raw.nodes {
        let Some(id) = node.id.filter(|id| loose.contains(id)) else { continue };
        let Some((other, gap)) = nearest(id, node, raw, &grid, &joined) else { continue };
        joined.insert(id, other);
        fixes.push(format!("node {id}: joined with node {other}, {gap:.3} m away"));
    }
    let ends = raw.edges.iter_mut().flat_map(|edge| [&mut edge.origin, &mut edge.destination]);
    let stops = raw.stations.iter_mut().flat_map(|station| &mut station.nodes);
    for id in ends.flatten().chain(stops) {
        *id = joined.get(id).copied().unwrap_or(*id);
    }
    raw.nodes.retain(|node| node.id.is_none_or(|id| !joined.contains_key(&id)));
    fixes
}

/// Returns the ids of nodes at which edges only end, or only start.
fn loose_ends(raw: &RawGraph) -> BTreeSet<u32> {
    let (mut left, mut reached) = (BTreeSet::new(), BTreeSet::new());
    for edge in &raw.edges {
        left.extend(edge.origin);
        reached.extend(edge.destination);
        if edge.reverse_speed.is_some_and(|speed| speed > 0.0) {
            left.extend(edge.destination);
            reached.extend(edge.origin);
        }
    }
    left.symmetric_difference(&reached).copied().collect()
}

/// The nodes by squares of [`MAX_JOINED_GAP`].
type Cells = BTreeMap<(i64, i64), Vec<usize>>;

fn cell(position: DVec2) -> (i64, i64) {
    let index = (position / MAX_JOINED_GAP).floor();
    (index.x as i64, index.y as i64)
}

fn cells(nodes: &[RawNode]) -> Cells {
    let mut cells = Cells::new();
    for (index, node) in nodes.iter().enumerate() {
        if let Some(position) = position(node) {
            cells.entry(cell(position)).or_default().push(index);
        }
    }
    cells
}

fn position(node: &RawNode) -> Option<DVec2> {
    Some(DVec2::new(node.x?, node.y?)).filter(|position| position.is_finite())
}

/// Returns the id of the nearest node with which a node can be joined, and the distance in metres.
fn nearest(
    id: u32,
    node: &RawNode,
    raw: &RawGraph,
    cells: &Cells,
    joined: &BTreeMap<u32, u32>,
) -> Option<(u32, f64)> {
    let at = position(node)?;
    let (x, y) = cell(at);
    let mut best: Option<(u32, f64)> = None;
    for x in x.saturating_sub(1)..=x.saturating_add(1) {
        for y in y.saturating_sub(1)..=y.saturating_add(1) {
            for &index in cells.get(&(x, y)).into_iter().flatten() {
                let other = &raw.nodes[index];
                let Some(gap) = position(other).map(|position| position.distance(at)) else {
                    continue;
                };
                let Some(other_id) = other.id.filter(|other| !joined.contains_key(other)) else {
                    continue;
                };
                let is_nearer = best.is_none_or(|(_, least)| gap < least);
                if is_nearer
                    && gap <= MAX_JOINED_GAP
                    && can_join(raw, (id, node), (other_id, other))
                {
                    best = Some((other_id, gap));
                }
            }
        }
    }
    best
}

/// Whether two nodes have nearly the same heading, unless no curve depends on it, and no edge
/// between them. Such an edge would become a loop.
fn can_join(
    raw: &RawGraph,
    (id, node): (u32, &RawNode),
    (other_id, other): (u32, &RawNode),
) -> bool {
    let (Some(theta), Some(other_theta)) = (node.theta, other.theta) else { return false };
    let turn = to_radians(other_theta, raw.degrees) - to_radians(theta, raw.degrees);
    let ids = [Some(id), Some(other_id)];
    // The curves of other formats don't depend on the headings of their nodes.
    let has_spline = !raw.is_imported
        && raw.edges.iter().any(|edge| {
            matches!(edge.curve, Some(RawCurve::Spline))
                && (ids.contains(&edge.origin) || ids.contains(&edge.destination))
        });
    (!has_spline || normalize_angle(turn).abs() <= MAX_JOINED_TURN)
        && id != other_id
        && !raw
            .edges
            .iter()
            .any(|edge| ids.contains(&edge.origin) && ids.contains(&edge.destination))
}

#[cfg(test)]
mod tests {
    use crate::model::options::ReadOptions;
    use crate::model::tags::Orientation;
    use crate::{parse, parse_fixed};

    const EDGE: &str = "CurveType: Linear, VelocityForward: 1";

    fn fixed(text: &str) -> (crate::model::route_graph::RouteGraph, Vec<String>) {
        let (graph, _, fixes) =
            parse_fixed(text, "g", &ReadOptions::default()).expect("it can be mended");
        (graph, fixes)
    }

    #[test]
    fn a_good_graph_stays_as_it_is() {
        let text = include_str!("../../../../graphs/porto.yaml");
        let (graph, fixes) = fixed(text);
        let (same, _) = parse(text, "g", &ReadOptions::default()).expect("a graph");
        assert_eq!((graph.nodes(), graph.edges(), fixes.len()), (same.nodes(), same.edges(), 0));
    }

    #[test]
    fn degrees_duplicates_and_gaps_are_mended() {
        let text = format!(
            "Vertices:\n- {{Id: 1, X: 0, Y: 0, Theta: 90}}\n- {{Id: 2, X: 0, Y: 5, Theta: 90}}\n\
             - {{Id: 3, X: 0.02, Y: 5.01, Theta: 91}}\n- {{Id: 4, X: 0, Y: 9, Theta: 90}}\n\
             Edges:\n- {{Id: 1, Origin_ID: 1, Destination_ID: 2, {EDGE}}}\n- {{Id: 1, Origin_ID: 1, Destination_ID: 2, {EDGE}}}\n\
             - {{Id: 1, Origin_ID: 3, Destination_ID: 4, {EDGE}}}\n"
        );
        assert!(parse(&text, "g", &ReadOptions::default()).is_err(), "edges with the same id");
        let (graph, fixes) = fixed(&text);
        assert_eq!((graph.nodes().len(), graph.edges().len(), fixes.len()), (3, 2, 4), "{fixes:?}");
        assert!((graph.nodes()[0].theta - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert_eq!(graph.edges()[0].destination, graph.edges()[1].origin, "they meet now");
        assert_eq!(graph.edges()[1].id, 2);
    }

    #[test]
    fn degrees_of_other_formats_are_converted() {
        let node = |id: u32, x: u32| {
            format!(
                "{{\"nodeId\": \"{id}\", \"nodePosition\": {{\"x\": {x}, \"y\": 0}}, \
                 \"vehicleTypeNodeProperties\": [{{\"vehicleTypeId\": \"A\", \"theta\": 90}}]}}"
            )
        };
        let text = format!(
            "{{\"layouts\": [{{\"nodes\": [{}, {}], \"edges\": [{{\"edgeId\": \"1\", \
             \"startNodeId\": \"1\", \
             \"endNodeId\": \"2\", \"vehicleTypeEdgeProperties\": [{{\"vehicleTypeId\": \"A\", \"maxSpeed\": 1, \
             \"orientationType\": \"GLOBAL\", \"vehicleOrientation\": 180}}]}}]}}]}}",
            node(1, 0),
            node(2, 5)
        );
        let (graph, fixes) = fixed(&text);
        assert_eq!(
            (graph.edges()[0].orientation, fixes.len()),
            (Orientation::Fixed(std::f64::consts::PI), 1),
            "{fixes:?}"
        );
        assert!((graph.nodes()[1].theta - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    }

    #[test]
    fn edges_that_differ_in_anything_but_their_names_stay() {
        let edge = |id: u32, more: &str| {
            format!("- {{Id: {id}, Origin_ID: 1, Destination_ID: 2, {EDGE}{more}}}\n")
        };
        let text = format!(
            "Vertices:\n- {{Id: 1, X: 0, Y: 0, Theta: 0}}\n- {{Id: 2, X: 5, Y: 0, Theta: \
             0}}\nEdges:\n{}{}{}{}{}",
            edge(1, ""),
            edge(2, ", Zone: trolleys"),
            edge(3, ", RotationAtOrigin: cw"),
            edge(4, ", Name: again"),
            "- {Id: 5, Origin_ID: 2, Destination_ID: 2, CurveType: Linear, VelocityForward: 1}\n",
        );
        let (graph, fixes) = fixed(&text);
        assert_eq!(
            graph.edges().iter().map(|edge| edge.id).collect::<Vec<_>>(),
            [1, 2, 3],
            "{fixes:?}"
        );
        assert_eq!(
            fixes,
            [
                "edge 4 (`again`): removed, it is the same as edge 1",
                "edge 5: removed, it leads from a node to itself"
            ]
        );
    }

    #[test]
    fn ends_of_other_formats_are_joined_whatever_their_headings() {
        let text = "id,x,y\nA,0,0\nB,10,0\nB2,10.004,0.003\nC,20,0\n\nfrom,to\nA,B\nB,A\nB2,C\n";
        let (graph, fixes) = fixed(text);
        assert_eq!((graph.nodes().len(), fixes.len()), (3, 1), "{fixes:?}");
    }

    #[test]
    fn ends_of_straight_edges_are_joined_whatever_their_headings() {
        let nodes = "Vertices:\n- {Id: 1, X: 0, Y: 0, Theta: 0}\n- {Id: 2, X: 10, Y: 0, Theta: 0}\n\
                     - {Id: 3, X: 10.003, Y: 0, Theta: 1}\n- {Id: 4, X: 20, Y: 0, Theta: 0}\n";
        let edge = |id: u32, from: u32, to: u32, curve: &str| {
            format!(
                "- {{Id: {id}, Origin_ID: {from}, Destination_ID: {to}, CurveType: {curve}, \
                 VelocityForward: 1}}\n"
            )
        };
        let text = |curve: &str| {
            let edges = [edge(1, 1, 2, "Linear"), edge(2, 2, 1, "Linear"), edge(3, 3, 4, curve)];
            format!("{nodes}Edges:\n{}", edges.concat())
        };
        let (graph, fixes) = fixed(&text("Linear"));
        assert_eq!((graph.nodes().len(), fixes.len()), (3, 1), "{fixes:?}");
        let (graph, fixes) = fixed(&text("Spline, ParamF: 4, ParamB: 4"));
        assert_eq!((graph.nodes().len(), fixes.len()), (4, 0), "a spline would bend: {fixes:?}");
    }

    #[test]
    fn curves_that_nearly_meet_their_nodes_are_moved_to_them() {
        let text = "Vertices:\n- {Id: 1, X: 0, Y: 0, Theta: 0}\n- {Id: 2, X: 6, Y: 0, Theta: 0}\nEdges:\n\
                    - {Id: 7, Origin_ID: 1, Destination_ID: 2, CurveType: Bezier, VelocityForward: 1, \
                    ControlPoints: [[0.03, 0], [0, 4], [6, 4], [6, -0.04]]}\n";
        let (graph, fixes) = fixed(text);
        assert_eq!((graph.edges()[0].path.cubic_count(), fixes.len()), (1, 1), "{fixes:?}");
    }
}
