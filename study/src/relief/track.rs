//! Two-way tracks, on which robots that meet wait for each other.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec2;
use regatta_layout::{Edge, EdgeIndex, NodeIndex, RouteGraph};

use super::roads::{CLEARANCE, Roads, room};
use super::{Candidate, Remedy, Site};
use crate::outcome::EdgeOutcome;

/// The parts of an edge between which its opposite is compared with it.
const SAMPLES: [f64; 3] = [0.25, 0.5, 0.75];

/// A two-way track between junctions.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// Its nodes, from an end to the other.
    pub nodes: Vec<NodeIndex>,
    /// Its edges there, and back, both from the first node on.
    pub edges: Vec<[EdgeIndex; 2]>,
}

/// Returns the edges that have an opposite on the same line, each with it.
fn opposites(graph: &RouteGraph, width: f64) -> BTreeMap<EdgeIndex, EdgeIndex> {
    let mut by_ends: BTreeMap<(NodeIndex, NodeIndex), Vec<EdgeIndex>> = BTreeMap::new();
    for (edge, index) in graph.edges().iter().zip((0..).map(EdgeIndex)) {
        by_ends.entry((edge.origin, edge.destination)).or_default().push(index);
    }
    let mut opposites = BTreeMap::new();
    for ((from, to), edges) in &by_ends {
        let back = by_ends.get(&(*to, *from));
        if let ([there], Some([back])) = (&edges[..], back.map(|back| &back[..]))
            && are_near(graph.edge(*there), graph.edge(*back), width)
        {
            opposites.insert(*there, *back);
        }
    }
    opposites
}

fn are_near(there: &Edge, back: &Edge, width: f64) -> bool {
    SAMPLES.iter().all(|part| there.path.at(*part).0.distance(back.path.at(1.0 - *part).0) < width)
}

/// Returns the neighbours of each node, in both directions.
fn neighbours(graph: &RouteGraph) -> Vec<BTreeSet<NodeIndex>> {
    let mut neighbours = vec![BTreeSet::new(); graph.nodes().len()];
    for edge in graph.edges() {
        neighbours[edge.origin.0 as usize].insert(edge.destination);
        neighbours[edge.destination.0 as usize].insert(edge.origin);
    }
    neighbours
}

/// Returns the two-way tracks of a layout between nodes where ways part. Those to a dead end lead
/// to places, where robots don't pass through.
pub fn tracks(graph: &RouteGraph, width: f64) -> Vec<Track> {
    let (opposites, neighbours) = (opposites(graph, width), neighbours(graph));
    let is_inner = |node: NodeIndex| {
        neighbours[node.0 as usize].len() == 2
            && graph.departures(node).len() == 2
            && graph.departures(node).iter().all(|leg| opposites.contains_key(&leg.edge))
    };
    let (mut tracks, mut seen) = (Vec::new(), BTreeSet::new());
    for (&first, &back) in &opposites {
        if is_inner(graph.edge(first).origin) || seen.contains(&first) {
            continue;
        }
        let mut track = Track { nodes: vec![graph.edge(first).origin], edges: Vec::new() };
        let (mut edge, mut opposite) = (first, back);
        loop {
            seen.extend([edge, opposite]);
            let node = graph.edge(edge).destination;
            track.nodes.push(node);
            track.edges.push([edge, opposite]);
            if !is_inner(node) || track.nodes.len() > graph.nodes().len() {
                break;
            }
            let next = graph.departures(node).iter().find(|leg| leg.edge != opposite);
            let Some((leg, back)) = next.and_then(|leg| Some((leg, opposites.get(&leg.edge)?)))
            else {
                break;
            };
            (edge, opposite) = (leg.edge, *back);
        }
        let ends = [track.nodes[0], track.nodes[track.nodes.len() - 1]];
        let is_dead = ends.iter().any(|end| neighbours[end.0 as usize].len() < 2);
        if !is_dead && ends[0] != ends[1] {
            tracks.push(track);
        }
    }
    tracks
}

/// Returns the tracks that robots wait for, with a second track or a place to pass.
pub fn candidates(site: &Site<'_>) -> Vec<Candidate> {
    let graph: &RouteGraph = &site.variant.graph;
    let mut candidates = Vec::new();
    for track in tracks(graph, site.variant.max_width()) {
        let of = |index: &EdgeIndex| site.edge(graph.edge(*index).id);
        let there: Vec<EdgeOutcome> = track.edges.iter().map(|[there, _]| of(there)).collect();
        let back: Vec<EdgeOutcome> = track.edges.iter().map(|[_, back]| of(back)).collect();
        let is_used = |edges: &[EdgeOutcome]| edges.iter().any(|it| it.entered_per_hour > 0.0);
        if !is_used(&there) || !is_used(&back) {
            continue;
        }
        let caused: f64 = there.iter().chain(&back).map(|edge| edge.caused_secs).sum();
        let ids = track.nodes.iter().map(|node| graph.node(*node).id).collect();
        let ends = [track.nodes[0], track.nodes[track.nodes.len() - 1]].map(|end| site.name(end));
        let between = format!("the two-way track from {} to {}", ends[0], ends[1]);
        let about = "waiting";
        let robots = caused / site.secs;
        candidates.push(Candidate {
            remedy: Remedy::SecondTrack(ids),
            words: format!("a track for each direction on {between}"),
            about,
            robots,
        });
        if let Some(edges) = middle(graph, &track, site.variant.max_length()) {
            candidates.push(Candidate {
                remedy: Remedy::PassingPlace(edges),
                words: format!("a passing place in the middle of {between}"),
                about,
                robots,
            });
        }
    }
    candidates
}

/// Returns the longest edge of a track and its opposite, if robots have room to pass on it.
fn middle(graph: &RouteGraph, track: &Track, length: f64) -> Option<[u32; 2]> {
    let metres = |edges: &[EdgeIndex; 2]| graph.edge(edges[0]).path.length();
    let longest = track.edges.iter().max_by(|a, b| metres(a).total_cmp(&metres(b)))?;
    let has_room = metres(longest) >= 2.5 * siding(length);
    has_room.then(|| longest.map(|edge| graph.edge(edge).id))
}

/// The length of a place to pass, for robots of a length, in metres: one stands on it, and it
/// leaves the track and comes back.
fn siding(length: f64) -> f64 {
    2.0 * length + 4.0 * CLEARANCE
}

/// Returns a layout in which the way back on a track has a track of its own beside it.
pub fn with_second_track(graph: &RouteGraph, ids: &[u32], width: f64) -> Option<RouteGraph> {
    let mut nodes = Vec::new();
    for id in ids {
        nodes.push(graph.node_by_id(*id)?);
    }
    let mut roads = Roads::new(graph);
    let mut like = None;
    for pair in nodes.windows(2) {
        let back = graph.edges().iter();
        let back = back.filter(|edge| (edge.origin, edge.destination) == (pair[1], pair[0]));
        for edge in back {
            roads.close(edge.id);
            like = Some(edge);
        }
    }
    nodes.reverse();
    lane(&mut roads, graph, &nodes, width, like?);
    roads.done()
}

/// Returns a layout with a place to pass in the middle of an edge and of its opposite.
pub fn with_passing_place(
    graph: &RouteGraph,
    ids: [u32; 2],
    [length, width]: [f64; 2],
) -> Option<RouteGraph> {
    let [there, back] = ids.map(|id| graph.edge_by_id(id));
    let (there, back) = (graph.edge(there?), graph.edge(back?));
    let part = siding(length) / there.path.length();
    let mut roads = Roads::new(graph);
    let (first, tangent) = there.path.at(0.5 - part / 2.0);
    let first = roads.node(first, tangent, there.origin);
    let (second, tangent) = there.path.at(0.5 + part / 2.0);
    let second = roads.node(second, tangent, there.origin);
    for (from, to, like) in [
        (there.origin, first, there),
        (first, there.origin, back),
        (second, there.destination, there),
        (there.destination, second, back),
        (first, second, there),
    ] {
        roads.edge(from, to, like);
    }
    lane(&mut roads, graph, &[second, first], width, back);
    roads.close(there.id);
    roads.close(back.id);
    roads.done()
}

/// Adds a lane beside some nodes, from the first to the last: on the side with more room, to the
/// right if both have it.
fn lane(roads: &mut Roads<'_>, graph: &RouteGraph, nodes: &[NodeIndex], width: f64, like: &Edge) {
    let line: Vec<DVec2> = nodes.iter().map(|node| roads.position(*node)).collect();
    let offset = width + CLEARANCE;
    let near = like.origin;
    let sides = [-1.0, 1.0].map(|side| beside(&line, side * offset));
    let rooms = sides.each_ref().map(|points| {
        points.iter().map(|point| room(graph, *point, nodes)).fold(f64::INFINITY, f64::min)
    });
    let [right, left] = sides;
    let points = if rooms[1] > rooms[0] + CLEARANCE && rooms[0] < offset { left } else { right };
    let mut before = nodes[0];
    for pair in points.windows(2) {
        let next = roads.node(pair[0], pair[1] - pair[0], near);
        roads.edge(before, next, like);
        before = next;
    }
    if let [.., from, to] = points[..] {
        let last = roads.node(to, to - from, near);
        roads.edge(before, last, like);
        roads.edge(last, nodes[nodes.len() - 1], like);
    }
}

/// Returns the points of a lane to the left of a line, by a distance in metres. It leaves the line
/// at its first point and comes back at its last one, each at an angle of 45 degrees at most.
fn beside(line: &[DVec2], left: f64) -> Vec<DVec2> {
    let mut points = Vec::new();
    for (pair, index) in line.windows(2).zip(0..) {
        let way = pair[1] - pair[0];
        let (metres, along) = (way.length(), way.normalize_or_zero());
        let lead = left.abs().min(metres / 4.0);
        let side = along.perp() * left;
        if index == 0 {
            points.push(pair[0] + along * lead + side);
        }
        let is_last = index + 2 == line.len();
        points.push(if is_last { pair[1] - along * lead + side } else { pair[1] + side });
    }
    points
}
