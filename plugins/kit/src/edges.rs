//! Edges as a person gives them: by an id, a name, or the nodes at their ends.

use regatta_plugin::World;
use regatta_plugin::command::RouteLeg;

use super::way::{WayError, find_node};

/// The text between the two nodes of an edge.
const BETWEEN_NODES: &str = "..";

/// The error of looking for an edge.
#[derive(Debug, thiserror::Error)]
pub enum EdgeError {
    /// No edge has this id or name.
    #[error(
        "there is no edge {0}: give the id or the name of one, or the nodes at its ends as FROM..TO"
    )]
    Unknown(String),
    /// No edge leads from a node to another one.
    #[error("no edge leads from node {from} to node {to}")]
    NotBetween {
        /// The node at the begin.
        from: String,
        /// The node at the end.
        to: String,
    },
    /// Several edges have this name, or these nodes.
    #[error("'{edge}' stands for {count} edges, such as {example}; give the id of one")]
    Ambiguous {
        /// The name or the nodes.
        edge: String,
        /// The number of edges.
        count: usize,
        /// The id of the first one.
        example: u32,
    },
    /// One of the nodes isn't there.
    #[error(transparent)]
    Node(#[from] WayError),
}

/// Returns the id of an edge, given by its id, else by its name, else by the nodes at its ends as
/// `FROM..TO`, each by id or name, else by `e12`, as the search of the window takes it.
///
/// # Errors
/// See [`EdgeError`].
pub fn find_edge(world: &World<'_>, edge: &str) -> Result<u32, EdgeError> {
    let edge = edge.trim();
    if let Some(id) = find_id(world, edge) {
        return Ok(id);
    }
    let named = world.edges().iter().filter(|other| world.text(other.name) == edge);
    let named: Vec<u32> = named.filter(|_| !edge.is_empty()).map(|other| other.id).collect();
    match (only(edge, &named)?, edge.split_once(BETWEEN_NODES)) {
        (Some(id), _) => Ok(id),
        (None, Some((from, to))) => between(world, edge, [from.trim(), to.trim()]),
        (None, None) => {
            let lettered = edge.strip_prefix('e').and_then(|id| find_id(world, id));
            lettered.ok_or_else(|| EdgeError::Unknown(edge.to_owned()))
        }
    }
}

/// Returns the leg on an edge, given as for [`find_edge`]; `-` before it is reverse gear.
///
/// # Errors
/// See [`EdgeError`].
pub fn find_leg(world: &World<'_>, leg: &str) -> Result<RouteLeg, EdgeError> {
    let forward = find_edge(world, leg);
    match leg.trim().strip_prefix('-') {
        Some(edge) if forward.is_err() => find_edge(world, edge).map(RouteLeg::reverse),
        _ => forward.map(RouteLeg::forward),
    }
}

fn find_id(world: &World<'_>, id: &str) -> Option<u32> {
    let id = id.parse().ok()?;
    world.edges().iter().any(|edge| edge.id == id).then_some(id)
}

/// Returns the edge from a node to another one.
fn between(world: &World<'_>, edge: &str, [from, to]: [&str; 2]) -> Result<u32, EdgeError> {
    let [origin, destination] = [find_node(world, from)?, find_node(world, to)?];
    let joining = world.edges().iter().filter(|other| {
        [other.origin as usize, other.destination as usize] == [origin, destination]
    });
    let joining: Vec<u32> = joining.map(|other| other.id).collect();
    only(edge, &joining)?
        .ok_or_else(|| EdgeError::NotBetween { from: from.to_owned(), to: to.to_owned() })
}

/// Returns the only edge of a list; `None` if there is none.
fn only(edge: &str, found: &[u32]) -> Result<Option<u32>, EdgeError> {
    match *found {
        [] => Ok(None),
        [id] => Ok(Some(id)),
        [example, ..] => {
            let (edge, count) = (edge.to_owned(), found.len());
            Err(EdgeError::Ambiguous { edge, count, example })
        }
    }
}

#[cfg(test)]
mod tests {
    use regatta_plugin::world::{CurveRecord, EdgeRecord, NodeRecord, WorldData};

    use super::*;

    /// Returns a world with nodes `A`, `B` and `C`, and an edge for each name and ends.
    fn world(edges: &[(&str, [u32; 2])]) -> WorldData {
        let mut world = WorldData::default();
        for (id, name) in (10..).zip(["A", "B", "C"]) {
            let name = world.texts.add(name);
            world.nodes.push(NodeRecord { id, name, ..NodeRecord::default() });
        }
        for (id, (name, [origin, destination])) in (100..).zip(edges) {
            let (name, origin, destination) = (world.texts.add(name), *origin, *destination);
            let edge = EdgeRecord { id, name, origin, destination, ..EdgeRecord::default() };
            world.add_edge(edge, [CurveRecord::default()]);
        }
        world
    }

    #[test]
    fn edges_are_found_by_id_name_and_nodes() {
        let edges = [
            ("A --- B", [0, 1]),
            ("", [1, 0]),
            ("twice", [1, 2]),
            ("twice", [1, 2]),
            ("-", [2, 0]),
        ];
        let world = world(&edges);
        let world = world.view(1, 1);
        let edge = |text| find_edge(&world, text).map_err(|error| error.to_string());
        assert_eq!((edge("e101"), edge("n10..n11")), (Ok(101), Ok(100)), "as the search has them");
        for text in ["100", "A --- B", "A..B", "10..11", " A .. 11 "] {
            assert_eq!(edge(text), Ok(100), "{text}");
        }
        assert_eq!(edge("B..A"), Ok(101));
        for (text, reason) in [
            ("99", "there is no edge 99"),
            ("", "there is no edge"),
            ("A..X", "no node has the id or the name 'X'"),
            ("A..C", "no edge leads from node A to node C"),
            ("twice", "stands for 2 edges, such as 102"),
            ("B..C", "stands for 2 edges"),
        ] {
            assert!(edge(text).is_err_and(|error| error.contains(reason)), "{text}");
        }
        let leg = |text| find_leg(&world, text).ok();
        assert_eq!(leg("A --- B"), Some(RouteLeg::forward(100)));
        assert_eq!(leg("-A..B"), Some(RouteLeg::reverse(100)));
        assert_eq!(leg("-100"), Some(RouteLeg::reverse(100)));
        assert_eq!(leg("-"), Some(RouteLeg::forward(104)), "it is a name");
    }
}
