//! Warnings about the places where robots start, from which they can't work or go on.

use regatta_base::graph::CRAWL;
use regatta_base::rows::Rows;
use regatta_layout::model::components::Components;
use regatta_layout::{Gear, Node, NodeIndex, RouteGraph};

use super::{RobotGroup, Start};

/// The largest number of places that a warning names.
const MOST_NAMED: usize = 6;

/// Returns a warning if robots on random walks will stop where no way leads out.
pub(super) fn no_way_out(groups: &[RobotGroup], graph: &RouteGraph) -> Option<String> {
    groups.iter().find(|group| matches!(group.start, Start::Random))?;
    let mut nodes = (0..).map(NodeIndex).zip(graph.nodes());
    // Random walks drive forwards only, so that a leg in reverse gear is no way out.
    let (_, node) = nodes
        .find(|(index, _)| graph.departures(*index).iter().all(|leg| leg.gear == Gear::Reverse))?;
    Some(format!(
        "robots on random walks will stop at nodes without a way out, such as node {}: add an edge \
         that leaves it, or give the robots routes",
        node.id
    ))
}

/// Returns a warning if robots wait for commands where no way leads to the layout's main part.
pub(super) fn cut_off(groups: &[RobotGroup], graph: &RouteGraph) -> Option<String> {
    groups.iter().find(|group| matches!(group.start, Start::Node(_)))?;
    let components = Components::strong(graph);
    let main = components.main(graph);
    if components.sizes.iter().all(|nodes| *nodes == 1) {
        return None;
    }
    let can_reach = can_reach(graph, &components, main);
    let mut names = Vec::new();
    let mut robot = 0;
    for group in groups {
        if let Start::Node(node) = group.start
            && !can_reach[node.0 as usize]
        {
            names.extend((robot..robot + group.count).map(|robot| (robot, node)));
        }
        robot += group.count;
    }
    let more = match names.len().saturating_sub(MOST_NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let named: Vec<String> = names
        .iter()
        .take(MOST_NAMED)
        .map(|(robot, node)| format!("{robot} (at {})", label(graph.node(*node))))
        .collect();
    if named.is_empty() {
        return None;
    }
    let (noun, verb) = if names.len() == 1 { ("robot", "starts") } else { ("robots", "start") };
    Some(format!(
        "{noun} {}{more} {verb} outside of the layout's main part: no way leads there and \
         back, so that only orders of the same part can be carried; start elsewhere, or \
         connect the roads (`regatta graph check --traffic` shows the parts)",
        named.join(", ")
    ))
}

/// Returns by node whether a way leads from there to a component.
fn can_reach(graph: &RouteGraph, components: &Components, goal: u32) -> Vec<bool> {
    let nodes = (0..graph.nodes().len() as u32).map(NodeIndex);
    let legs = nodes.flat_map(|node| {
        let legs = graph.departures(node).iter();
        legs.filter(|leg| graph.leg_speed(**leg) >= Some(CRAWL))
            .map(move |leg| (graph.leg_end(*leg).0, node.0))
    });
    let before = Rows::new(graph.nodes().len(), legs.collect());
    let mut can_reach: Vec<bool> = components.of_node.iter().map(|part| *part == goal).collect();
    let mut open: Vec<u32> = (0..).zip(&can_reach).filter(|(_, is)| **is).map(|(n, _)| n).collect();
    while let Some(node) = open.pop() {
        for &start in before.row(node) {
            if !std::mem::replace(&mut can_reach[start as usize], true) {
                open.push(start);
            }
        }
    }
    can_reach
}

fn label(node: &Node) -> String {
    node.name().map_or_else(|| format!("node {}", node.id), |name| format!("`{name}`"))
}
