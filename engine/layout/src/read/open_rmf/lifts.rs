//! The lifts of a building: edges between the vertices in a cabin, which join the levels.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use glam::DVec2;

use super::model::{Lane, Level, Vertex};
use crate::model::facilities::Cabin;
use crate::model::finding::Report;
use crate::model::raw::RawDoorTimes;
use crate::model::tags::{Orientation, Tags};
use crate::model::value::shorten;
use crate::read::layout::{Layout, LayoutEdge, LayoutLift};

/// The distance in metres by which a vertex in a cabin is moved that is at the same place as that
/// of the level below: an edge between them needs a length, of more than the few millimetres within
/// which a robot counts as standing at a node.
const SHIFT: f64 = 0.02;
/// The distance in metres below which vertices in a cabin count as at the same place.
const SAME_PLACE: f64 = 0.01;

/// A lift as the file describes it.
#[derive(Debug, Default)]
pub(super) struct LiftPlan {
    pub at: u32,
    pub cabin: Option<Cabin>,
    pub door_times: RawDoorTimes,
    /// Seconds from a level to the next.
    pub level_secs: Option<f64>,
    /// The name of the level where it stands at the beginning.
    pub home: Option<String>,
}

/// A vertex in the cabin of a lift: the indices of its level and of the vertex.
#[derive(Clone, Copy)]
struct Stop {
    level: usize,
    vertex: usize,
}

/// The levels of a building, and the ids of their vertices.
type Levels = [(Level, Vec<String>)];

/// The stops of lifts, by the lift and the graph. Each fleet has its own graph, and its own
/// vertices in a cabin.
type Stops = BTreeMap<(String, String), Vec<Stop>>;

/// Adds edges in both directions between the stops of each lift on consecutive levels.
pub(super) fn connect(
    levels: &mut Levels,
    plans: &BTreeMap<String, LiftPlan>,
    layout: &mut Layout,
    report: &mut Report<'_>,
) {
    for ((lift, _), stops) in stops(levels) {
        part(&stops, levels);
        warn_of_single_level(&lift, &stops, levels, report);
        // Known heights give the time from one stop to the next.
        if plans.get(&lift).is_none_or(|plan| plan.level_secs.is_none()) {
            warn_of_passed_levels(&lift, &stops, levels, report);
        }
        connect_stops(&lift, &stops, levels, layout, report);
    }
}

/// Adds the lifts that join levels at some elevations, when the layout has all of its nodes and
/// edges.
pub(super) fn add(
    plans: &BTreeMap<String, LiftPlan>,
    elevations: &BTreeMap<String, f64>,
    layout: &mut Layout,
) {
    let mut nodes: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (index, node) in layout.nodes.iter().enumerate() {
        let tags = &node.tags.properties;
        if let Some(lift) = tags.get("lift").or(tags.get("lift_cabin")) {
            nodes.entry(lift).or_default().push(index);
        }
    }
    let mut lifts = Vec::new();
    for (name, mut nodes) in nodes {
        let level = |node: &usize| &layout.nodes[*node].tags.level;
        if name.is_empty() || nodes.iter().all(|node| level(node) == level(&nodes[0])) {
            continue;
        }
        // From the lowest level up; levels without elevations stay in the order of the file.
        nodes.sort_by(|a, b| {
            let [a, b] = [a, b].map(|node| elevations.get(level(node).as_deref()?));
            a.partial_cmp(&b).unwrap_or(Ordering::Equal)
        });
        let none = LiftPlan { at: layout.nodes[nodes[0]].at, ..LiftPlan::default() };
        let plan = plans.get(name).unwrap_or(&none);
        let is_served =
            |home: &&String| nodes.iter().any(|node| level(node).as_deref() == Some(home.as_str()));
        lifts.push(LayoutLift {
            at: plan.at,
            name: name.to_owned(),
            cabin: plan.cabin,
            door_times: plan.door_times,
            level_secs: plan.level_secs,
            home: plan.home.as_ref().filter(is_served).cloned(),
            nodes,
        });
    }
    layout.lifts = lifts;
}

/// Returns the stops of each lift, from the lowest level up.
fn stops(levels: &Levels) -> Stops {
    let mut stops = Stops::new();
    for (index, (level, _)) in levels.iter().enumerate() {
        for (vertex, graph) in graphs(level).into_iter().enumerate() {
            if let (Some(lift), Some(graph)) = (level.vertices[vertex].lift(), graph) {
                let stop = Stop { level: index, vertex };
                stops.entry((lift.to_owned(), graph.to_owned())).or_default().push(stop);
            }
        }
    }
    for stops in stops.values_mut() {
        // The sort is stable: levels without elevations stay in the order of the file.
        stops.sort_by(|a, b| levels[a.level].0.elevation.total_cmp(&levels[b.level].0.elevation));
    }
    stops
}

/// Returns the graph of each vertex, by one of its lanes; `None` for a vertex without lanes.
fn graphs(level: &Level) -> Vec<Option<&str>> {
    let mut graphs = vec![None; level.vertices.len()];
    for lane in &level.lanes {
        let graph = lane.properties.get("graph_idx").map_or("0", String::as_str);
        for end in lane.ends {
            if let Some(of_vertex) = graphs.get_mut(end) {
                *of_vertex = Some(graph);
            }
        }
    }
    graphs
}

/// Moves stops that are at the same place as the one on the level below.
fn part(stops: &[Stop], levels: &mut Levels) {
    for pair in stops.windows(2) {
        let [below, above] = [pair[0], pair[1]].map(|stop| vertex(levels, stop).position);
        let (Some(below), Some(above)) = (below, above) else { continue };
        if pair[0].level != pair[1].level && below.distance(above) < SAME_PLACE {
            let moved = &mut levels[pair[1].level].0.vertices[pair[1].vertex];
            moved.position = Some(below + DVec2::X * SHIFT);
        }
    }
}

/// Warns of a lift in a building of several levels that has vertices on one of them only.
fn warn_of_single_level(lift: &str, stops: &[Stop], levels: &Levels, report: &mut Report<'_>) {
    let Some(first) = stops.first().filter(|_| levels.len() > 1) else { return };
    if stops.iter().all(|stop| stop.level == first.level) {
        let (lift, level) = (shorten(lift), shorten(&levels[first.level].0.name));
        let message = format!("lift `{lift}` joins no levels: it has vertices on {level} only");
        report.file_warning(vertex(levels, *first).at, message);
    }
}

fn connect_stops(
    lift: &str,
    stops: &[Stop],
    levels: &Levels,
    layout: &mut Layout,
    report: &mut Report<'_>,
) {
    let mut counts = vec![0; levels.len()];
    for stop in stops {
        counts[stop.level] += 1;
    }
    for pair in stops.windows(2) {
        let [from, to] = [pair[0], pair[1]];
        if from.level == to.level {
            continue;
        }
        // With several vertices in one cabin, the pairs are ambiguous.
        let reason = if [from, to].iter().any(|stop| counts[stop.level] > 1) {
            "it has several vertices on a level"
        } else if [from, to].iter().any(|stop| vertex(levels, *stop).position.is_none()) {
            "its vertices have no positions"
        } else {
            layout.edges.push(edge(lift, from, to, levels));
            layout.edges.push(edge(lift, to, from, levels));
            continue;
        };
        let [from_name, to_name] = [from, to].map(|stop| shorten(&levels[stop.level].0.name));
        let message = format!(
            "lift `{}` doesn't join the levels {from_name} and {to_name}: {reason}",
            shorten(lift)
        );
        report.file_warning(vertex(levels, from).at, message);
    }
}

/// Warns of rides past levels where the lift has no vertex: they take the time of one level.
fn warn_of_passed_levels(lift: &str, stops: &[Stop], levels: &Levels, report: &mut Report<'_>) {
    for pair in stops.windows(2).filter(|pair| pair[0].level + 1 < pair[1].level) {
        let [from, to] = [pair[0], pair[1]];
        let passed = levels[from.level + 1..to.level].iter().map(|(level, _)| shorten(&level.name));
        let message = format!(
            "lift `{}` has no vertex on {}: its ride from {} to {} takes the time of one level",
            shorten(lift),
            passed.collect::<Vec<_>>().join(", "),
            shorten(&levels[from.level].0.name),
            shorten(&levels[to.level].0.name)
        );
        report.file_warning(vertex(levels, from).at, message);
    }
}

fn vertex(levels: &Levels, stop: Stop) -> &Vertex {
    &levels[stop.level].0.vertices[stop.vertex]
}

/// Returns a ride. The robot keeps the heading with which it has entered the cabin.
fn edge(lift: &str, from: Stop, to: Stop, levels: &Levels) -> LayoutEdge {
    let [from_id, to_id] = [from, to].map(|stop| &levels[stop.level].1[stop.vertex]);
    let mut tags = Tags { zone: Some(format!("lift {lift}").into()), ..Tags::default() };
    tags.set("lift", lift);
    let level = &levels[from.level].0;
    let entry = level.lanes.iter().find(|lane| lane.ends[1] == from.vertex);
    LayoutEdge {
        at: vertex(levels, from).at,
        id: format!("lift {lift}/{from_id}/{to_id}"),
        origin: from_id.clone(),
        destination: to_id.clone(),
        // The time of the cabin replaces it.
        speed: Some(1.0),
        orientation: entry.map_or(Orientation::Tangential, |lane| heading(lane, level)),
        tags,
        ..LayoutEdge::default()
    }
}

/// Returns the heading at the end of a lane.
fn heading(lane: &Lane, level: &Level) -> Orientation {
    let [Some(from), Some(to)] = lane.ends.map(|end| level.vertices[end].position) else {
        return Orientation::Tangential;
    };
    let along = if lane.is_backward() { from - to } else { to - from };
    match along == DVec2::ZERO {
        true => Orientation::Tangential,
        false => Orientation::Fixed(along.to_angle()),
    }
}
