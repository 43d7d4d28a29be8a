//! The ids of nodes and edges in the file.

use std::collections::BTreeSet;

use crate::model::route_graph::RouteGraph;

/// The ids of a file.
pub(super) struct Names {
    pub nodes: List,
    pub edges: List,
    /// All ids of edges, those of reverse gear included.
    used: BTreeSet<String>,
    /// The number after the last of an edge.
    next: u64,
}

/// The ids of the nodes or of the edges.
pub(super) struct List {
    pub ids: Vec<String>,
    /// Whether they are names; otherwise they are numbers.
    pub are_names: bool,
}

impl Names {
    /// Names nodes by their names if each has one of its own: those are the ids of the file that it
    /// was read from.
    pub fn new(graph: &RouteGraph) -> Self {
        let nodes = List::new(graph.nodes().iter().map(|node| (node.id, node.name())));
        let edges = List::new(graph.edges().iter().map(|edge| (edge.id, edge.name())));
        let used = edges.ids.iter().cloned().collect();
        let next = graph.edges().iter().map(|edge| u64::from(edge.id) + 1).max().unwrap_or(1);
        Self { nodes, edges, used, next }
    }

    /// Returns an id for the reverse gear of an edge; a number, if all other ids are numbers.
    pub fn reverse(&mut self, index: usize) -> String {
        let id = if self.edges.are_names {
            let mut id = format!("{}-reverse", self.edges.ids[index]);
            while self.used.contains(&id) {
                id.push('_');
            }
            id
        } else {
            self.next += 1;
            (self.next - 1).to_string()
        };
        self.used.insert(id.clone());
        id
    }
}

impl List {
    fn new<'n>(items: impl Iterator<Item = (u32, Option<&'n str>)> + Clone) -> Self {
        let mut used = BTreeSet::new();
        let are_names = items
            .clone()
            .all(|(_, name)| name.is_some_and(|name| !name.is_empty() && used.insert(name)));
        let id = |(number, name): (u32, Option<&str>)| match name {
            Some(name) if are_names => name.to_owned(),
            _ => number.to_string(),
        };
        Self { ids: items.map(id).collect(), are_names }
    }
}
