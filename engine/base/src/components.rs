//! The strongly connected components of a directed graph.

use crate::rows::Rows;

/// Returns for each node a node of its strongly connected component, the same for all of them: the
/// nodes that it can reach, and that can reach it (Tarjan, "Depth-first search and linear graph
/// algorithms", SIAM Journal on Computing 1, 1972).
///
/// ```
/// use regatta_base::components::strong_components;
/// use regatta_base::rows::Rows;
///
/// let successors = Rows::new(3, vec![(0, 1), (1, 0), (1, 2)]);
/// let of_node = strong_components(&successors);
/// assert!(of_node[0] == of_node[1] && of_node[1] != of_node[2]);
/// ```
pub fn strong_components(successors: &Rows<u32>) -> Vec<u32> {
    Tarjan::new(successors).run()
}

/// Returns a node of the largest component, of the nodes that
/// [`strong_components`] returns; 0 if there are none.
///
/// ```
/// use regatta_base::components::largest;
///
/// assert_eq!(largest(&[0, 2, 2]), 2);
/// ```
pub fn largest(of_node: &[u32]) -> u32 {
    let mut sizes = vec![0_u32; of_node.len()];
    for &node in of_node {
        sizes[node as usize] += 1;
    }
    (0..).zip(sizes).max_by_key(|(_, size)| *size).map_or(0, |(node, _)| node)
}

/// Tarjan's algorithm with an explicit stack. Recursion would overflow the call stack on a long
/// chain of nodes.
struct Tarjan<'a> {
    successors: &'a Rows<u32>,
    /// For each node: the order in which it was discovered, from 1; 0 if it isn't discovered yet.
    discovery: Vec<u32>,
    /// For each node: the least `discovery` of an open node known to be reachable from it.
    low: Vec<u32>,
    /// For each node: a node of its component once that is complete, else `u32::MAX`.
    representative: Vec<u32>,
    discovered: u32,
    /// The discovered nodes whose components aren't complete.
    open: Vec<u32>,
    /// The path of the depth-first search: nodes, and the number of their successors that have been
    /// visited.
    path: Vec<(u32, usize)>,
}

impl<'a> Tarjan<'a> {
    fn new(successors: &'a Rows<u32>) -> Self {
        let nodes = successors.len();
        Self {
            successors,
            discovery: vec![0; nodes],
            low: vec![0; nodes],
            representative: vec![u32::MAX; nodes],
            discovered: 0,
            open: Vec::new(),
            path: Vec::new(),
        }
    }

    fn run(mut self) -> Vec<u32> {
        for node in 0..self.discovery.len() as u32 {
            if self.discovery[node as usize] == 0 {
                self.discover(node);
                while let Some((node, next)) = self.path.pop() {
                    self.visit(node, next);
                }
            }
        }
        self.representative
    }

    fn discover(&mut self, node: u32) {
        self.discovered += 1;
        self.discovery[node as usize] = self.discovered;
        self.low[node as usize] = self.discovered;
        self.open.push(node);
        self.path.push((node, 0));
    }

    /// Visits successor `next` of `node`, or finishes the node if there are no more.
    fn visit(&mut self, node: u32, next: usize) {
        let Some(&to) = self.successors.row(node).get(next) else { return self.finish(node) };
        self.path.push((node, next + 1));
        if self.discovery[to as usize] == 0 {
            self.discover(to);
        } else if self.representative[to as usize] == u32::MAX {
            self.low[node as usize] = self.low[node as usize].min(self.discovery[to as usize]);
        }
    }

    fn finish(&mut self, node: u32) {
        let low = self.low[node as usize];
        if let Some(&(parent, _)) = self.path.last() {
            self.low[parent as usize] = self.low[parent as usize].min(low);
        }
        if low < self.discovery[node as usize] {
            return;
        }
        while let Some(member) = self.open.pop() {
            self.representative[member as usize] = node;
            if member == node {
                break;
            }
        }
    }
}
