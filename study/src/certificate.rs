//! The traffic that the layout of a study allows its robots, before any run.

use regatta_layout::traffic::{Certificate, most_under_way};

use crate::plan::Variant;

/// The largest number of remarks about one topic.
const MOST_REMARKS: usize = 3;
/// The most edges of a layout that is examined, which takes some seconds then.
const MOST_EDGES: usize = 150_000;

/// Returns sentences about what the roads of a variant allow its robots, the most important
/// topics first; none for large layouts.
pub fn certificate(variant: &Variant) -> Vec<String> {
    if variant.graph.edges().len() > MOST_EDGES {
        return Vec::new();
    }
    Certificate::new(&variant.graph, &variant.robot()).sentences(&variant.graph, MOST_REMARKS)
}

/// Returns the largest number of robots that the roads of a variant let under way at once; `None`
/// for large layouts.
pub fn most_robots(variant: &Variant) -> Option<u32> {
    let is_small = variant.graph.edges().len() <= MOST_EDGES;
    is_small
        .then(|| most_under_way(&variant.graph, &variant.robot()).at_nodes.robots)
        .filter(|most| *most > 0)
}
