//! Edges and robots that are slow: the time that robots lose by driving there.

use std::collections::BTreeMap;

use regatta_layout::{Edge, EdgeIndex, NodeIndex, RouteGraph};

use super::{Candidate, FASTER_ROBOTS, Remedy, Site};

/// The part of the usual speed under which an edge is slow.
const SLOW: f64 = 0.7;

/// Returns the edges that are slower than robots usually drive, in groups that touch.
pub fn slow_edges(site: &Site<'_>) -> Vec<Candidate> {
    let graph: &RouteGraph = &site.variant.graph;
    let Some(usual) = usual_speed(site) else { return Vec::new() };
    let is_slow = |(index, edge): &(EdgeIndex, &Edge)| {
        speed(site, edge) < SLOW * usual && !graph.is_ride(*index)
    };
    let edges = (0..).map(EdgeIndex).zip(graph.edges());
    let slow: Vec<&Edge> = edges.filter(is_slow).map(|(_, edge)| edge).collect();
    let mut candidates = Vec::new();
    for group in groups(&slow) {
        let ids: Vec<u32> = group.iter().map(|edge| edge.id).collect();
        let mut robots = 0.0;
        for edge in group {
            let traffic = site.edge(edge.id);
            let lost = time(edge, speed(site, edge)) - time(edge, usual);
            robots += traffic.entered_per_hour / 3600.0 * lost + traffic.caused_secs / site.secs;
        }
        candidates.push(Candidate {
            words: format!("{} as fast as others: {usual:.1} m/s", edges_in_words(&ids)),
            remedy: Remedy::UsualSpeed { edges: ids, speed: usual },
            about: "driving slowly, and waiting for it",
            robots,
        });
    }
    candidates
}

/// Returns faster robots, if edges let them drive faster.
pub fn faster_robots(site: &Site<'_>) -> Option<Candidate> {
    let max_speed = site.variant.max_speed();
    if !max_speed.is_finite() {
        return None;
    }
    let mut robots = 0.0;
    for edge in site.variant.graph.edges() {
        let [now, then] = [1.0, FASTER_ROBOTS].map(|factor| edge.speed.min(factor * max_speed));
        robots +=
            site.edge(edge.id).entered_per_hour / 3600.0 * (time(edge, now) - time(edge, then));
    }
    Some(Candidate {
        remedy: Remedy::FasterRobots,
        words: format!("robots that drive up to {:.2} m/s", FASTER_ROBOTS * max_speed),
        about: "driving",
        robots,
    })
}

/// The speed at which robots drive on an edge, in metres per second.
fn speed(site: &Site<'_>, edge: &Edge) -> f64 {
    edge.speed.min(site.variant.max_speed())
}

fn time(edge: &Edge, speed: f64) -> f64 {
    edge.path.length() / speed
}

/// Returns the speed below which robots drive half of their way, in metres per second; `None`
/// without traffic.
fn usual_speed(site: &Site<'_>) -> Option<f64> {
    let mut ways = Vec::new();
    for edge in site.variant.graph.edges() {
        let metres = site.edge(edge.id).entered_per_hour * edge.path.length();
        ways.push((speed(site, edge), metres));
    }
    ways.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = ways.iter().map(|(_, metres)| metres).sum::<f64>() / 2.0;
    let mut sum = 0.0;
    let usual = ways.iter().find(|(_, metres)| {
        sum += metres;
        sum >= half
    });
    usual.map(|(speed, _)| *speed).filter(|_| half > 0.0)
}

/// Returns edges in groups that have nodes in common, by their first edge.
fn groups<'e>(edges: &[&'e Edge]) -> Vec<Vec<&'e Edge>> {
    let mut group_of: BTreeMap<NodeIndex, usize> = BTreeMap::new();
    let mut groups: Vec<Vec<&Edge>> = Vec::new();
    for edge in edges {
        let mut own = vec![*edge];
        let ends = [edge.origin, edge.destination];
        for other in ends.map(|end| group_of.get(&end).copied()).into_iter().flatten() {
            own.append(&mut groups[other]);
        }
        for edge in &own {
            group_of.insert(edge.origin, groups.len());
            group_of.insert(edge.destination, groups.len());
        }
        groups.push(own);
    }
    groups.retain(|group| !group.is_empty());
    for group in &mut groups {
        group.sort_by_key(|edge| edge.id);
    }
    groups.sort_by_key(|group| group[0].id);
    groups
}

/// Names some edges by their ids.
pub fn edges_in_words(ids: &[u32]) -> String {
    const NAMED: usize = 5;
    let names: Vec<String> = ids.iter().take(NAMED).map(u32::to_string).collect();
    let more = match ids.len().saturating_sub(NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    format!("edge{} {}{more}", if ids.len() == 1 { "" } else { "s" }, names.join(", "))
}
