//! Parts of a layout that can't be reached or left.

use regatta_base::graph::{CRAWL, EdgeIndex, Leg, NodeIndex};
use regatta_base::rows::Rows;

use super::network::{Network, Search};
use super::stations::StationNames;

/// The way in which a part is cut off from the main part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CutOff {
    /// Robots of the main part can drive there, but not back.
    CannotBeLeft,
    /// Robots there can drive to the main part, but not back.
    CannotBeReached,
    /// Neither.
    Apart,
}

impl CutOff {
    /// Returns the missing way, in words: `no way leads to it from the main part`.
    pub const fn missing_way(self) -> &'static str {
        match self {
            Self::CannotBeLeft => "no way leads back from it",
            Self::CannotBeReached => "no way leads to it from the main part",
            Self::Apart => "no way joins it with the main part",
        }
    }
}

/// The reason why a part is cut off.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Cause {
    /// Edges are missing.
    Missing,
    /// Edges are too slow to count as ways: under a [crawl](CRAWL). Those that would lead into the
    /// part, or out of it, in ascending order.
    TooSlow(Vec<EdgeIndex>),
}

/// A part: nodes that all can be reached from each other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Its nodes, in ascending order.
    pub nodes: Vec<NodeIndex>,
    /// Its nodes with stations, in ascending order.
    pub stations: Vec<NodeIndex>,
    /// The way in which it is cut off.
    pub cut_off: CutOff,
    /// The reason.
    pub cause: Cause,
}

/// Returns all parts other than the main one, in the order of their first nodes.
pub fn parts(network: &Network<'_>, stations: &StationNames) -> Vec<Part> {
    let main = network.main_nodes();
    let [after, after_slowly] =
        [CRAWL, 0.0].map(|slowest| network.reached(&main, Search::Forwards, slowest));
    let [before, before_slowly] =
        [CRAWL, 0.0].map(|slowest| network.reached(&main, Search::Backwards, slowest));
    let components = &network.parts;
    let nodes = (0..).zip(&components.of_node).map(|(node, part)| (*part, node));
    let members: Rows<u32> = Rows::new(components.sizes.len(), nodes.collect());
    let others = (0..members.len() as u32).filter(|part| *part != network.main);
    let found = others.map(|part| {
        let nodes = members.row(part);
        let stations = nodes.iter().copied().filter(|node| stations.contains_key(node));
        let first = nodes[0] as usize;
        let cut_off = match (after[first], before[first]) {
            (true, _) => CutOff::CannotBeLeft,
            (false, true) => CutOff::CannotBeReached,
            (false, false) => CutOff::Apart,
        };
        Part {
            stations: stations.map(NodeIndex).collect(),
            nodes: nodes.iter().copied().map(NodeIndex).collect(),
            cut_off,
            cause: match after_slowly[first] && before_slowly[first] {
                true => Cause::TooSlow(crawling(network, nodes, cut_off)),
                false => Cause::Missing,
            },
        }
    });
    found.collect()
}

/// The edges with legs that are slower than a crawl, and lead between the nodes of a part and
/// others in the direction that it lacks.
fn crawling(network: &Network<'_>, nodes: &[u32], cut_off: CutOff) -> Vec<EdgeIndex> {
    let mut edges = Vec::new();
    for &node in nodes {
        let out = network.departures(node).iter().filter(|leg| !has(nodes, network.end(**leg)));
        let into = network.arrivals(node).iter().filter(|leg| !has(nodes, network.start(**leg)));
        let legs: Vec<&Leg> = match cut_off {
            CutOff::CannotBeLeft => out.collect(),
            CutOff::CannotBeReached => into.collect(),
            CutOff::Apart => out.chain(into).collect(),
        };
        edges.extend(legs.into_iter().filter(|leg| !network.is_way(**leg)).map(|leg| leg.edge));
    }
    edges.sort_unstable();
    edges.dedup();
    edges
}

fn has(nodes: &[u32], node: u32) -> bool {
    nodes.binary_search(&node).is_ok()
}
