//! The traffic that the layout of a study allows its robots, before any run.

use regatta_layout::traffic::{Certificate, RobotType, Turning, most_under_way};

use crate::plan::Variant;

/// The largest number of remarks about one topic.
const MOST_REMARKS: usize = 3;
/// The most edges of a layout that is examined, which takes some seconds then.
const MOST_EDGES: usize = 150_000;

/// Returns sentences about what the roads of a variant allow its robots, the most important
/// topics first; none for large layouts, or robots that a certificate can't describe.
pub fn certificate(variant: &Variant) -> Vec<String> {
    let [length, width] = variant.size();
    let robot = RobotType::new(length, width, Turning::OnTheSpot);
    match (robot, variant.graph.edges().len()) {
        (Ok(robot), 0..=MOST_EDGES) => {
            Certificate::new(&variant.graph, &robot).sentences(&variant.graph, MOST_REMARKS)
        }
        _ => Vec::new(),
    }
}

/// Returns the largest number of robots that the roads of a variant let under way at once; `None`
/// for large layouts, or robots that a certificate can't describe.
pub fn most_robots(variant: &Variant) -> Option<u32> {
    let [length, width] = variant.size();
    let robot = RobotType::new(length, width, Turning::OnTheSpot).ok()?;
    let is_small = variant.graph.edges().len() <= MOST_EDGES;
    is_small
        .then(|| most_under_way(&variant.graph, &robot).at_nodes.robots)
        .filter(|most| *most > 0)
}
