//! The weakly and strongly connected components of a route graph.

use regatta_base::components::strong_components;
use regatta_base::graph::{CRAWL, NodeIndex};
use regatta_base::rows::Rows;

use super::route_graph::RouteGraph;
use super::tags::Role;

/// A partition of the nodes into components.
#[derive(Clone, Debug)]
pub struct Components {
    /// The component of each node, counted from 0.
    pub of_node: Vec<u32>,
    /// The number of nodes of each component.
    pub sizes: Vec<u32>,
}

/// The numbers of a component's nodes with stations.
#[derive(Clone, Copy, Debug, Default)]
struct Stations {
    picks: u64,
    drops: u64,
    /// Those that are counted as both.
    transfers: u64,
    others: u64,
}

impl Stations {
    fn add(&mut self, role: Role) {
        self.picks += u64::from(role.is_pick());
        self.drops += u64::from(role.is_drop());
        self.transfers += u64::from(role == Role::Transfer);
    }

    /// The number of pairs of a node to pick at and another node to drop at.
    fn pairs(self) -> u64 {
        self.picks * self.drops - self.transfers
    }
}

impl Components {
    /// Returns the weakly connected components: the direction of edges doesn't matter.
    pub fn weak(graph: &RouteGraph) -> Self {
        let mut parent: Vec<u32> = (0..graph.nodes().len() as u32).collect();
        for edge in graph.edges() {
            let (a, b) = (root(&mut parent, edge.origin.0), root(&mut parent, edge.destination.0));
            parent[a.max(b) as usize] = a.min(b);
        }
        let roots: Vec<u32> =
            (0..parent.len() as u32).map(|node| root(&mut parent, node)).collect();
        Self::numbered(&roots)
    }

    /// Returns the strongly connected components: all nodes of a component can reach each other
    /// along legs, reverse gear included. Legs that are slower than a [crawl](CRAWL) don't count.
    ///
    /// ```
    /// use regatta_layout::model::components::Components;
    /// use regatta_layout::{ReadOptions, parse};
    ///
    /// let text = "id,x,y\nA,0,0\nB,10,0\nC,20,0\n\nfrom,to,speed\nA,B,1\nB,A,1\nB,C,1\n";
    /// let (graph, _) = parse(text, "road.csv", &ReadOptions::default())?;
    /// assert_eq!(Components::strong(&graph).sizes, [2, 1]);
    /// # Ok::<(), regatta_layout::GraphError>(())
    /// ```
    pub fn strong(graph: &RouteGraph) -> Self {
        let nodes = graph.nodes().len();
        let departures = (0..nodes as u32).flat_map(|node| {
            let legs = graph.departures(NodeIndex(node)).iter();
            let legs = legs.filter(|leg| graph.leg_speed(**leg) >= Some(CRAWL));
            legs.map(move |leg| (node, graph.leg_end(*leg).0))
        });
        Self::numbered(&strong_components(&Rows::of_sorted(nodes, departures)))
    }

    /// Returns the component in which a fleet can carry the most: the one with the most pairs of a
    /// node to pick at and another to drop at; among equal ones, that with the most nodes of
    /// stations without a role, and then of any nodes; the first of those. 0 if there is none.
    pub fn main(&self, graph: &RouteGraph) -> u32 {
        let mut stations = vec![Stations::default(); self.sizes.len()];
        for (role, &component) in graph.purposes().into_iter().zip(&self.of_node) {
            stations[component as usize].add(role);
        }
        for station in graph.stations().iter().filter(|station| station.role == Role::None) {
            for node in &station.nodes {
                stations[self.of_node[node.0 as usize] as usize].others += 1;
            }
        }
        let mut main = 0;
        let mut most = (0, 0, 0);
        for ((stations, &nodes), component) in stations.iter().zip(&self.sizes).zip(0..) {
            let worth = (stations.pairs(), stations.others, nodes);
            if worth > most {
                (main, most) = (component, worth);
            }
        }
        main
    }

    /// Returns the component with the most of some nodes; of equal ones, and without any node, as
    /// [`main`](Self::main).
    pub fn around(&self, graph: &RouteGraph, wanted: &[NodeIndex]) -> u32 {
        let mut counts = vec![0_u32; self.sizes.len()];
        for node in wanted {
            counts[self.of_node[node.0 as usize] as usize] += 1;
        }
        let main = self.main(graph);
        let most = counts.iter().copied().max().unwrap_or(0);
        if counts.get(main as usize).is_none_or(|count| *count == most) {
            return main;
        }
        counts.iter().zip(0..).find(|(count, _)| **count == most).map_or(main, |(_, part)| part)
    }

    /// Numbers components in the order of their first nodes. `representatives` has a node of each
    /// node's component.
    fn numbered(representatives: &[u32]) -> Self {
        let mut number = vec![u32::MAX; representatives.len()];
        let mut sizes = Vec::new();
        let mut of_node = Vec::with_capacity(representatives.len());
        for &representative in representatives {
            let component = &mut number[representative as usize];
            if *component == u32::MAX {
                *component = sizes.len() as u32;
                sizes.push(0);
            }
            sizes[*component as usize] += 1;
            of_node.push(*component);
        }
        Self { of_node, sizes }
    }
}

/// Finds the representative of a node's set, halving the path to it.
fn root(parent: &mut [u32], mut node: u32) -> u32 {
    while parent[node as usize] != node {
        parent[node as usize] = parent[parent[node as usize] as usize];
        node = parent[node as usize];
    }
    node
}

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use proptest::prelude::*;
    use regatta_base::bezier::CubicBezier;

    use super::*;
    use crate::model::route_graph::{Edge, Node};

    fn graph(nodes: u32, edges: &[(u32, u32, bool)]) -> RouteGraph {
        let nodes =
            (0..nodes).map(|id| Node::new(id, DVec2::new(f64::from(id), 0.0), 0.0)).collect();
        let curve = CubicBezier::straight(DVec2::ZERO, DVec2::X);
        let edge = |(id, &(from, to, reverse)): (u32, &(u32, u32, bool))| {
            let edge = Edge::new(id, NodeIndex(from), NodeIndex(to), curve, 1.0);
            Edge { reverse_speed: reverse.then_some(1.0), ..edge }
        };
        RouteGraph::from_valid_parts(nodes, (0..).zip(edges).map(edge).collect())
    }

    /// Returns for each node whether it can be reached, by definition.
    fn reachable_from(graph: &RouteGraph, from: u32) -> Vec<bool> {
        let mut reached = vec![false; graph.nodes().len()];
        let mut open = vec![from];
        while let Some(node) = open.pop() {
            if !std::mem::replace(&mut reached[node as usize], true) {
                open.extend(
                    graph.departures(NodeIndex(node)).iter().map(|&leg| graph.leg_end(leg).0),
                );
            }
        }
        reached
    }

    #[test]
    fn a_ring_with_a_tail_has_three_strong_components() {
        let graph = graph(5, &[(0, 1, false), (1, 2, false), (2, 0, false), (2, 3, false)]);
        let strong = Components::strong(&graph);
        assert_eq!(strong.sizes, [3, 1, 1]);
        assert_eq!(strong.main(&graph), 0);
        assert_eq!(Components::weak(&graph).sizes, [4, 1]);
    }

    #[test]
    fn a_chain_longer_than_the_call_stack_has_components() {
        let length = if cfg!(miri) { 2_000 } else { 500_000 };
        let edges: Vec<_> = (0..length).map(|node| (node, node + 1, false)).collect();
        assert_eq!(Components::strong(&graph(length + 1, &edges)).sizes.len(), length as usize + 1);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(if cfg!(miri) { 4 } else { 256 }))]

        #[test]
        fn nodes_of_a_strong_component_reach_each_other(
            edges in prop::collection::vec((0u32..9, 0u32..9, any::<bool>()), 0..20),
        ) {
            let graph = graph(9, &edges);
            let strong = Components::strong(&graph);
            let reach: Vec<_> = (0..9).map(|node| reachable_from(&graph, node)).collect();
            for (a, b) in (0..9).flat_map(|a| (0..9).map(move |b| (a, b))) {
                prop_assert_eq!(strong.of_node[a] == strong.of_node[b], reach[a][b] && reach[b][a]);
            }
        }
    }
}
