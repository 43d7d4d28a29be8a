//! Nodes and edges by the ids and names that a scenario gives.

use std::cell::OnceCell;
use std::collections::BTreeMap;

use regatta_layout::{EdgeIndex, Gear, Leg, NodeIndex, RouteGraph};

use super::explain::did_you_mean;
use super::yaml::{Key, LegKey};

/// The text between the two nodes of an edge.
const BETWEEN_NODES: &str = "..";

/// Returns the edge of a graph with an id or a name, or from a node to another as `FROM..TO`.
///
/// # Errors
/// The reason, if there is none, or if there are several.
pub fn find_edge(graph: &RouteGraph, edge: &Key) -> Result<EdgeIndex, String> {
    Names::new(graph).edge(edge)
}

/// The names of a graph, which are indexed when the first one is looked up.
pub(super) struct Names<'graph> {
    graph: &'graph RouteGraph,
    nodes: OnceCell<Index<NodeIndex>>,
    edges: OnceCell<Index<EdgeIndex>>,
}

/// The nodes or edges that have a name, by name.
type Index<T> = BTreeMap<String, Vec<T>>;

impl<'graph> Names<'graph> {
    pub fn new(graph: &'graph RouteGraph) -> Self {
        Self { graph, nodes: OnceCell::new(), edges: OnceCell::new() }
    }

    /// Returns the node with an id or a name: for a number first the id, for a text first the name.
    pub fn node(&self, key: &Key) -> Result<NodeIndex, String> {
        find(key, "node", |id| self.graph.node_by_id(id), || self.nodes())
    }

    /// Returns the leg on the edge with an id or a name; `-` before it is reverse gear.
    pub fn leg(&self, key: &LegKey) -> Result<Leg, String> {
        let (edge, gear) = match key {
            LegKey::Id { id, is_reverse: false } => (self.edge(&Key::Id(*id))?, Gear::Forward),
            LegKey::Id { id, is_reverse: true } => (self.edge(&Key::Id(*id))?, Gear::Reverse),
            LegKey::Name(name) => self.leg_named(name)?,
        };
        let leg = Leg { edge, gear };
        match self.graph.leg_speed(leg) {
            Some(_) => Ok(leg),
            None => Err(format!(
                "edge {} can't be driven in reverse gear: its VelocityBackwards is 0",
                self.graph.edge(edge).id
            )),
        }
    }

    fn edge(&self, key: &Key) -> Result<EdgeIndex, String> {
        let found = find(key, "edge", |id| self.graph.edge_by_id(id), || self.edges());
        let Key::Name(name) = key else { return found };
        let nodes = name.split_once(BETWEEN_NODES).filter(|_| !self.edges().contains_key(name));
        nodes.map_or(found, |(from, to)| self.between(name, [from, to]))
    }

    /// Returns the edge from a node to another one.
    fn between(&self, name: &str, nodes: [&str; 2]) -> Result<EdgeIndex, String> {
        let [from, to] = nodes.map(|node| self.node(&key_of(node.trim())));
        let (from, to) = (from?, to?);
        let edges = (0..).map(EdgeIndex).zip(self.graph.edges());
        let edges = edges.filter(|(_, edge)| (edge.origin, edge.destination) == (from, to));
        match edges.map(|(index, _)| index).collect::<Vec<_>>()[..] {
            [edge] => Ok(edge),
            [] => Err(format!("no edge of the graph leads from {} to {}", nodes[0], nodes[1])),
            [first, ..] => Err(format!(
                "several edges lead along '{name}', such as {}: give the id of one",
                self.graph.edge(first).id
            )),
        }
    }

    fn leg_named(&self, name: &str) -> Result<(EdgeIndex, Gear), String> {
        let reverse = name.strip_prefix('-').filter(|_| !self.edges().contains_key(name));
        let (name, gear) = reverse.map_or((name, Gear::Forward), |name| (name, Gear::Reverse));
        Ok((self.edge(&Key::Name(name.to_owned()))?, gear))
    }

    fn nodes(&self) -> &Index<NodeIndex> {
        self.nodes.get_or_init(|| {
            let mut index = Index::new();
            for (node, content) in (0..).map(NodeIndex).zip(self.graph.nodes()) {
                if let Some(name) = content.name() {
                    index.entry(name.to_owned()).or_default().push(node);
                }
            }
            let mut others = Index::new();
            for (node, content) in (0..).map(NodeIndex).zip(self.graph.nodes()) {
                for name in content.other_names() {
                    others.entry(name).or_default().push(node);
                }
            }
            for (name, nodes) in others {
                index.entry(name).or_insert(nodes);
            }
            index
        })
    }

    fn edges(&self) -> &Index<EdgeIndex> {
        self.edges.get_or_init(|| {
            let mut index = Index::new();
            for (edge, content) in (0..).map(EdgeIndex).zip(self.graph.edges()) {
                if let Some(name) = content.name() {
                    index.entry(name.to_owned()).or_default().push(edge);
                }
            }
            index
        })
    }
}

/// Returns the key of a text: a number is an id first.
fn key_of(text: &str) -> Key {
    text.parse().map_or_else(|_| Key::Name(text.to_owned()), Key::Id)
}

/// Returns the only thing of a kind that a key stands for.
fn find<'index, T: Copy + 'index>(
    key: &Key,
    kind: &str,
    with_id: impl Fn(u32) -> Option<T>,
    names: impl FnOnce() -> &'index Index<T>,
) -> Result<T, String> {
    let name = key.to_string();
    let by_id = name.parse().ok().and_then(with_id);
    if let (Key::Id(_), Some(found)) = (key, by_id) {
        return Ok(found);
    }
    let names = names();
    match (names.get(&name).map(Vec::as_slice).unwrap_or_default(), by_id) {
        (&[found], _) | ([], Some(found)) => Ok(found),
        ([], None) if matches!(key, Key::Id(_)) => Err(format!("the graph has no {kind} {name}")),
        ([], None) => {
            let suggestion = did_you_mean(&name, names.keys().map(String::as_str));
            Err(format!("the graph has no {kind} with the id or the name '{name}'{suggestion}"))
        }
        (several, _) => {
            Err(format!("{} {kind}s are called '{name}': give the id of one", several.len()))
        }
    }
}
