//! Parts of a layout that can't be reached or left.

use regatta_base::graph::NodeIndex;
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

/// A part: nodes that all can be reached from each other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Its nodes, in ascending order.
    pub nodes: Vec<NodeIndex>,
    /// Its nodes with stations, in ascending order.
    pub stations: Vec<NodeIndex>,
    /// The way in which it is cut off.
    pub cut_off: CutOff,
}

/// Returns all parts other than the main one, in the order of their first nodes.
pub fn parts(network: &Network<'_>, stations: &StationNames) -> Vec<Part> {
    let main = network.main_nodes();
    let after = network.reached(&main, Search::Forwards);
    let before = network.reached(&main, Search::Backwards);
    let components = &network.parts;
    let nodes = (0..).zip(&components.of_node).map(|(node, part)| (*part, node));
    let members: Rows<u32> = Rows::new(components.sizes.len(), nodes.collect());
    let others = (0..members.len() as u32).filter(|part| *part != network.main);
    let found = others.map(|part| {
        let nodes = members.row(part);
        let stations = nodes.iter().copied().filter(|node| stations.contains_key(node));
        let first = nodes[0] as usize;
        Part {
            stations: stations.map(NodeIndex).collect(),
            nodes: nodes.iter().copied().map(NodeIndex).collect(),
            cut_off: match (after[first], before[first]) {
                (true, _) => CutOff::CannotBeLeft,
                (false, true) => CutOff::CannotBeReached,
                (false, false) => CutOff::Apart,
            },
        }
    });
    found.collect()
}
