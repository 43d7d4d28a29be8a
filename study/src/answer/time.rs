//! The time of orders and robots in an answer.

use regatta_layout::{NodeIndex, RouteGraph};
use serde::Serialize;

use crate::outcome::{Grouping, ORDER_PARTS, Outcome, ROBOT_PARTS, by_group};
use crate::statistics::Interval;
use crate::sweep::Point;

/// A part of a time.
#[derive(Clone, Debug, Serialize)]
pub struct PartAnswer {
    /// The part.
    pub name: &'static str,
    /// Seconds of an order's time, or the part of the robots' time from 0 to 1.
    pub value: Interval,
}

/// The mean times of the orders of a group.
#[derive(Clone, Debug, Serialize)]
pub struct GroupTime {
    /// The stations, or the hour of creation.
    pub name: String,
    /// The number of orders in a run.
    pub orders: f64,
    /// From creation to end, in seconds: the sum of the parts.
    pub service_secs: f64,
    /// The parts of that, in seconds, in the order of the points' `order_time`.
    pub parts_secs: [f64; ORDER_PARTS.len()],
}

/// The time of the orders of the first variant with the number of robots of the answer.
#[derive(Clone, Debug, Default, Serialize)]
pub struct TimeAnswer {
    /// By the station of the first stop, the most orders first.
    pub stations: Vec<GroupTime>,
    /// By the stations of the first and the last stop, the most orders first.
    pub relations: Vec<GroupTime>,
    /// By the hour of creation.
    pub hours: Vec<GroupTime>,
}

/// Returns the parts of the orders' time at a point.
pub(super) fn order_time(point: &Point) -> Vec<PartAnswer> {
    let mut parts = Vec::new();
    for (name, part) in ORDER_PARTS.into_iter().zip(0..) {
        let value = point.interval(|run| Some(run.order_time?[part]));
        parts.extend(value.map(|value: Interval| PartAnswer { name, value }));
    }
    parts
}

/// Returns the parts of the robots' time at a point.
pub(super) fn robot_time(point: &Point) -> Vec<PartAnswer> {
    let mut parts = Vec::new();
    for (name, part) in ROBOT_PARTS.into_iter().zip(0..) {
        let value = point.interval(|run| Some(run.robot_time?[part]));
        parts.extend(value.map(|value: Interval| PartAnswer { name, value }));
    }
    parts
}

impl TimeAnswer {
    /// Adds up the time of the orders of some runs.
    pub fn new(graph: &RouteGraph, outcomes: &[Outcome]) -> Self {
        let mut time = Self {
            stations: groups(graph, outcomes, Grouping::Station),
            relations: groups(graph, outcomes, Grouping::Relation),
            hours: groups(graph, outcomes, Grouping::Hour),
        };
        for groups in [&mut time.stations, &mut time.relations] {
            groups.sort_by(|a, b| b.orders.total_cmp(&a.orders));
        }
        time
    }
}

fn groups(graph: &RouteGraph, outcomes: &[Outcome], grouping: Grouping) -> Vec<GroupTime> {
    let mut groups = Vec::new();
    for (group, time) in by_group(outcomes, grouping) {
        let Some(parts_secs) = time.means() else { continue };
        let mut names: Vec<String> = match grouping {
            Grouping::Hour => group.iter().map(u32::to_string).collect(),
            _ => group.iter().map(|id| station(graph, *id)).collect(),
        };
        // An order with a single stop begins and ends there.
        names.dedup();
        groups.push(GroupTime {
            name: names.join(" → "),
            orders: time.orders / outcomes.len() as f64,
            service_secs: parts_secs.iter().sum(),
            parts_secs,
        });
    }
    groups
}

/// Returns the name of a node's station, or of the node, or its id.
pub(super) fn station(graph: &RouteGraph, id: u32) -> String {
    graph.node_by_id(id).map_or_else(|| id.to_string(), |node| node_name(graph, node))
}

/// Returns the name of a node's station, or of the node, or its id.
pub(crate) fn node_name(graph: &RouteGraph, node: NodeIndex) -> String {
    let mut stations = graph.stations().iter();
    let place = graph.node(node);
    match stations.find(|station| station.nodes.contains(&node)) {
        Some(station) => station.name.clone(),
        None => place.name().map_or_else(|| place.id.to_string(), str::to_owned),
    }
}
