//! Stops that robots wait at, and wait for: stations and chargers.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec2;
use regatta_layout::{Edge, NodeIndex, Role, RouteGraph};

use super::load::{Labels, StationEntry, entry};
use super::roads::{CLEARANCE, Roads, arrivals, exits, room};
use super::{Candidate, QUEUE_PLACES, Remedy, Site};
use crate::plan::Load;

/// The part of the time in which a charger is taken from which on there may be too few.
const TAKEN: f64 = 0.5;
/// The distance of a queue from the road, as a part of its distance from the station, below which
/// the station is on the road.
const BESIDE: f64 = 0.3;

/// The distances of a new place from the one beside it, as parts of the least one.
const DISTANCES: [f64; 3] = [1.0, 1.5, 2.0];
/// The parts of ways at which distances are measured.
const SAMPLES: [f64; 9] = [0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0];

/// The stops that an entry of the load describes, with the robots that wait there and for them.
#[derive(Default)]
struct Described {
    nodes: Vec<NodeIndex>,
    robots: f64,
}

/// Returns changes of the stops of orders.
pub fn stations(site: &Site<'_>) -> Vec<Candidate> {
    let graph: &RouteGraph = &site.variant.graph;
    let mut candidates = Vec::new();
    let Some(load) = site.variant.load_entry() else { return candidates };
    let mut described: BTreeMap<usize, Described> = BTreeMap::new();
    for (&id, wait) in &site.stops {
        let Some(node) = graph.node_by_id(id) else { continue };
        let entry = entry(load, &Labels::of(load, graph, node));
        let kept_out = site.kept_out(node);
        let has_operators = entry.is_some_and(|entry| entry.operators().is_some());
        if let Some(entry) = entry {
            let of = described.entry(entry.index()).or_default();
            of.nodes.push(node);
            of.robots += wait.robots + kept_out;
        }
        let name = site.name(node);
        if !has_operators || wait.robots < kept_out {
            candidates.push(Candidate {
                remedy: Remedy::Place(id),
                words: format!("a second place at {name}"),
                about: "waiting for a place at a station",
                robots: kept_out + wait.queued,
            });
        }
        if !entry.is_some_and(|entry| entry.has_queue()) {
            candidates.push(Candidate {
                remedy: Remedy::Queue(id),
                words: format!("{QUEUE_PLACES} places of a queue off the road before {name}"),
                about: "waiting before a station",
                robots: kept_out,
            });
        }
    }
    candidates.extend(described.values().filter_map(|stops| station(site, load, stops)));
    candidates
}

/// Returns one more operator for a station, or a faster way out of its buffer.
fn station(site: &Site<'_>, load: &Load, stops: &Described) -> Option<Candidate> {
    let graph: &RouteGraph = &site.variant.graph;
    let first = *stops.nodes.first()?;
    let described: StationEntry<'_> = entry(load, &Labels::of(load, graph, first))?;
    let ids: Vec<u32> = stops.nodes.iter().map(|node| graph.node(*node).id).collect();
    let mut names: Vec<String> = stops.nodes.iter().map(|node| site.name(*node)).collect();
    names.dedup();
    let names = names.join(", ");
    let (remedy, words) = match (described.operators(), described.cycle()) {
        (Some(_), _) => (Remedy::Operator(ids), format!("one more operator at {names}")),
        (None, Some(_)) => (
            Remedy::Buffer(ids[0]),
            format!("loads taken out of the buffer of {names} half as fast again"),
        ),
        (None, None) => return None,
    };
    let about = "waiting at and before a station";
    Some(Candidate { remedy, words, about, robots: stops.robots })
}

/// Returns a further charger beside the one that most robots came to, if robots wait while chargers
/// are taken.
pub fn charger(site: &Site<'_>) -> Option<Candidate> {
    let graph: &RouteGraph = &site.variant.graph;
    let purposes = graph.purposes();
    let chargers = purposes.iter().filter(|role| **role == Role::Charge).count();
    if chargers == 0 || site.charging < TAKEN * chargers as f64 {
        return None;
    }
    let nodes = (0..).map(NodeIndex).zip(&purposes).filter(|(_, role)| **role == Role::Charge);
    let came = |node: &NodeIndex| -> f64 {
        arrivals(graph, *node).map(|edge| site.edge(edge.id).entered_per_hour).sum()
    };
    let busiest = nodes.map(|(node, _)| node).max_by(|a, b| came(a).total_cmp(&came(b)))?;
    Some(Candidate {
        remedy: Remedy::Charger(graph.node(busiest).id),
        words: format!("a further charger beside {}", site.name(busiest)),
        about: "waiting for a robot, while robots wait for chargers",
        robots: site.idle.min(site.unassigned),
    })
}

/// Returns a layout with a node beside another one, with the same neighbours; and its id. `None` if
/// there is no room where robots at both are out of each other's way.
pub fn with_place(graph: &RouteGraph, id: u32, size: [f64; 2]) -> Option<(RouteGraph, u32)> {
    let node = graph.node_by_id(id)?;
    let along = arrivals(graph, node).next()?.path.end_tangent().normalize_or_zero();
    let place = free_place(graph, node, along, size)?;
    let mut roads = Roads::new(graph);
    let new = roads.node_like(place, along, node);
    for edge in arrivals(graph, node) {
        roads.edge(edge.origin, new, edge);
    }
    for edge in exits(graph, node) {
        roads.edge(new, edge.destination, edge);
    }
    let id = roads.id(new);
    Some((roads.done()?, id))
}

/// Returns the place round a node with the most room, the nearer of those with enough.
fn free_place(
    graph: &RouteGraph,
    node: NodeIndex,
    along: DVec2,
    [length, width]: [f64; 2],
) -> Option<DVec2> {
    let at = graph.node(node).position;
    let enough = width + CLEARANCE;
    let mut best: Option<(f64, DVec2)> = None;
    for part in DISTANCES {
        for eighth in 0..8 {
            let way = DVec2::from_angle(f64::from(eighth) * std::f64::consts::FRAC_PI_4);
            let place = at + way.rotate(along) * (length.max(width) + CLEARANCE) * part;
            let room = clearance(graph, node, place).min(enough);
            if best.is_none_or(|(most, _)| room > most + 1e-9) {
                best = Some((room, place));
            }
        }
    }
    best.filter(|(room, _)| *room >= width.midpoint(enough)).map(|(_, place)| place)
}

/// Returns the distance in metres between a new place beside a node, with its ways from and to the
/// same neighbours, and the node, its ways and all other roads.
fn clearance(graph: &RouteGraph, node: NodeIndex, place: DVec2) -> f64 {
    let at = graph.node(node).position;
    let (mut clearance, mut neighbours) = (place.distance(at), vec![node]);
    for edge in arrivals(graph, node).chain(exits(graph, node)) {
        let other = if edge.origin == node { edge.destination } else { edge.origin };
        let from = graph.node(other).position;
        neighbours.push(other);
        // A robot at the one leaves the way to the other free, but for the part that both share.
        for part in SAMPLES {
            clearance = clearance.min(from.lerp(place, part).distance(at));
            clearance = clearance.min(from.lerp(at, part).distance(place));
        }
    }
    clearance.min(room(graph, place, &neighbours)).min(beside_road(graph, node, place))
}

/// Returns the distance from a point to the edges that don't lead to or from a node.
fn beside_road(graph: &RouteGraph, node: NodeIndex, point: DVec2) -> f64 {
    let mut distance = f64::INFINITY;
    let ends = |edge: &Edge| [edge.origin, edge.destination];
    for edge in graph.edges().iter().filter(|edge| !ends(edge).contains(&node)) {
        for part in SAMPLES {
            distance = distance.min(edge.path.at(part).0.distance(point));
        }
    }
    distance
}

/// Returns a layout with places of a queue before a station that lies beside a road, and their ids,
/// the nearest first. Robots leave the road before it, and drive along it from place to place.
pub fn with_queue(
    graph: &RouteGraph,
    id: u32,
    [length, _]: [f64; 2],
) -> Option<(RouteGraph, Vec<u32>)> {
    let station = graph.node_by_id(id)?;
    let at = graph.node(station).position;
    let spacing = length + CLEARANCE;
    let (access, before) = arrivals(graph, station).find_map(|access| {
        let mut before = arrivals(graph, access.origin);
        Some((access, before.find(|edge| edge.origin != station)?))
    })?;
    let junction = graph.node(access.origin).position;
    let along = before.path.end_tangent().normalize_or_zero();
    let side = (at - junction) - along * (at - junction).dot(along);
    if side.length() < BESIDE * (at - junction).length() || side.length() < spacing / 2.0 {
        return None;
    }
    let needed = spacing * (QUEUE_PLACES as f64 + 1.0) - (at - junction).dot(along);
    let branch = upstream(graph, before, junction, along, needed)?;
    let mut roads = Roads::new(graph);
    let (mut ids, mut ahead) = (Vec::new(), station);
    for index in 1..=QUEUE_PLACES {
        let place = roads.node(at - along * (spacing * index as f64), along, station);
        ids.push(roads.id(place));
        roads.edge(place, ahead, access);
        ahead = place;
    }
    roads.edge(branch, ahead, before);
    Some((roads.done()?, ids))
}

/// Returns the last node on the way along an edge and those before it that lies so many metres
/// before its end.
fn upstream(
    graph: &RouteGraph,
    last: &Edge,
    end: DVec2,
    along: DVec2,
    metres: f64,
) -> Option<NodeIndex> {
    let (mut edge, mut seen) = (last, BTreeSet::new());
    while seen.insert(edge.origin) {
        if (end - graph.node(edge.origin).position).dot(along) >= metres {
            return Some(edge.origin);
        }
        edge = arrivals(graph, edge.origin).find(|before| before.origin != edge.destination)?;
    }
    None
}
