//! Adds edges between the vertices in the cabin of a lift, which join the levels.

use std::collections::BTreeMap;

use super::model::{Level, Vertex};
use crate::check::validate::MIN_LENGTH;
use crate::model::finding::Report;
use crate::model::tags::Tags;
use crate::model::value::shorten;
use crate::read::layout::{Layout, LayoutEdge};

/// A vertex in the cabin of a lift.
struct Stop<'a> {
    level: &'a Level,
    vertex: &'a Vertex,
    id: &'a str,
}

/// Adds edges in both directions between the stops of each lift on consecutive levels.
pub(super) fn connect(
    levels: &[(Level, Vec<String>)],
    layout: &mut Layout,
    report: &mut Report<'_>,
) {
    // Each fleet has its own graph, and its own vertices in a cabin.
    let mut stops: BTreeMap<(&str, &str), Vec<Stop<'_>>> = BTreeMap::new();
    for (level, ids) in levels {
        for ((vertex, id), graph) in level.vertices.iter().zip(ids).zip(graphs(level)) {
            if let (Some(lift), Some(graph)) = (vertex.lift(), graph) {
                stops.entry((lift, graph)).or_default().push(Stop { level, vertex, id });
            }
        }
    }
    for ((lift, _), stops) in stops {
        connect_stops(lift, &stops, layout, report);
    }
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

fn connect_stops(lift: &str, stops: &[Stop<'_>], layout: &mut Layout, report: &mut Report<'_>) {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for stop in stops {
        *counts.entry(&stop.level.name).or_default() += 1;
    }
    for pair in stops.windows(2) {
        let [from, to] = pair else { continue };
        if from.level.name == to.level.name {
            continue;
        }
        let Some((start, end)) = from.vertex.position.zip(to.vertex.position) else { continue };
        let distance = start.distance(end);
        // With several vertices in one cabin, the pairs are ambiguous.
        let reason = if [from, to].iter().any(|stop| counts[stop.level.name.as_str()] > 1) {
            "it has several vertices on a level"
        } else if distance.is_nan() || distance < MIN_LENGTH {
            "its vertices are at the same place"
        } else {
            layout.edges.push(edge(lift, from, to));
            layout.edges.push(edge(lift, to, from));
            continue;
        };
        let [from_name, to_name] = [from, to].map(|stop| shorten(&stop.level.name));
        let message = format!(
            "lift `{}` doesn't join the levels {from_name} and {to_name}: {reason}",
            shorten(lift)
        );
        report.file_warning(from.vertex.at, message);
    }
}

fn edge(lift: &str, from: &Stop<'_>, to: &Stop<'_>) -> LayoutEdge {
    let mut tags = Tags { zone: Some(format!("lift {lift}").into()), ..Tags::default() };
    tags.set("lift", lift);
    LayoutEdge {
        at: from.vertex.at,
        id: format!("lift {lift}/{}/{}", from.id, to.id),
        origin: from.id.to_owned(),
        destination: to.id.to_owned(),
        tags,
        ..LayoutEdge::default()
    }
}
