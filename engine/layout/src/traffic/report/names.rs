//! The names of nodes, edges and stations in a certificate.

use std::collections::BTreeSet;

use regatta_base::graph::{EdgeIndex, NodeIndex};

use crate::model::route_graph::RouteGraph;
use crate::model::value::{plural, shorten};
use crate::traffic::Certificate;
use crate::traffic::room::{Certainty, Count};

/// The largest number of nodes or edges that a line names.
const MOST_NAMES: usize = 6;

/// The lines of a certificate about a graph.
pub struct Writer<'a> {
    pub graph: &'a RouteGraph,
    pub certificate: &'a Certificate,
    /// The names that several nodes have.
    of_several_nodes: BTreeSet<&'a str>,
    /// The names that several edges have.
    of_several_edges: BTreeSet<&'a str>,
}

impl<'a> Writer<'a> {
    pub fn new(graph: &'a RouteGraph, certificate: &'a Certificate) -> Self {
        Self {
            graph,
            certificate,
            of_several_nodes: repeated(graph.nodes().iter().filter_map(|node| node.name())),
            of_several_edges: repeated(graph.edges().iter().filter_map(|edge| edge.name())),
        }
    }

    /// The name of a node, or else its id; both if several nodes have this name.
    pub fn node(&self, node: NodeIndex) -> String {
        let node = self.graph.node(node);
        named(node.name(), node.id, &self.of_several_nodes)
    }

    /// As [`node`](Self::node).
    pub fn edge(&self, edge: EdgeIndex) -> String {
        let edge = self.graph.edge(edge);
        named(edge.name(), edge.id, &self.of_several_edges)
    }

    pub fn nodes(&self, nodes: &[NodeIndex]) -> String {
        listed(nodes.len(), nodes.iter().map(|&node| self.node(node)))
    }

    /// `edge 5`, or `edges 5, 6`.
    pub fn edges(&self, edges: &[EdgeIndex]) -> String {
        let noun = if edges.len() == 1 { "edge" } else { "edges" };
        format!("{noun} {}", listed(edges.len(), edges.iter().map(|&edge| self.edge(edge))))
    }

    /// `the station …`, or `the stations …`.
    pub fn stations(&self, nodes: &[NodeIndex]) -> String {
        let noun = if nodes.len() == 1 { "station" } else { "stations" };
        let names = listed(nodes.len(), nodes.iter().map(|&node| self.station_at(node)));
        format!("the {noun} {names}")
    }

    /// The names of the stations at a node; that of the node if they have none.
    pub fn station_at(&self, node: NodeIndex) -> String {
        match self.certificate.station_names.get(&node.0).map(Vec::as_slice) {
            None | Some([]) => self.node(node),
            Some(names) => {
                let quoted = names.iter().map(|name| format!("`{}`", shorten(name)));
                format!("{} (node {})", listed(names.len(), quoted), self.node(node))
            }
        }
    }
}

fn named(name: Option<&str>, id: u32, of_several: &BTreeSet<&str>) -> String {
    match name {
        None => id.to_string(),
        Some(name) if of_several.contains(name) => format!("`{}` ({id})", shorten(name)),
        Some(name) => format!("`{}`", shorten(name)),
    }
}

/// Returns the names that occur more than once.
fn repeated<'a>(names: impl Iterator<Item = &'a str>) -> BTreeSet<&'a str> {
    let mut seen = BTreeSet::new();
    names.filter(|name| !seen.insert(*name)).collect()
}

/// Joins the first names of a list.
pub fn listed(count: usize, names: impl Iterator<Item = String>) -> String {
    let names: Vec<String> = names.take(MOST_NAMES).collect();
    let more = match count.saturating_sub(MOST_NAMES) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    names.join(", ") + &more
}

/// A number of robots, `at most` if it is a bound.
pub fn robots(count: Count) -> String {
    let number = plural(count.robots as usize, "robot");
    match count.certainty {
        Certainty::Exact => number,
        Certainty::Bound => format!("at most {number}"),
    }
}
