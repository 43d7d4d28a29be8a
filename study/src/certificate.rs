//! The traffic that the layout of a study allows its robots, before any run.

use regatta_layout::traffic::{Certificate, most_under_way};

use crate::plan::Variant;

/// The largest number of remarks about one topic.
const MOST_REMARKS: usize = 3;
/// The most edges of a layout that is examined, which takes some seconds then.
const MOST_EDGES: usize = 150_000;

/// Returns sentences about what the roads of a variant allow its robots, the most important topics
/// first; none for large layouts. Of several robot types, those of the largest one come first, and
/// each sentence that isn't true of all types names its own.
pub fn certificate(variant: &Variant) -> Vec<String> {
    if variant.graph.edges().len() > MOST_EDGES {
        return Vec::new();
    }
    let mut of_types: Vec<(String, Vec<String>)> = Vec::new();
    for (name, robot) in variant.robots() {
        let certificate = Certificate::new(&variant.graph, &robot);
        of_types.push((name, certificate.sentences(&variant.graph, MOST_REMARKS)));
    }
    let mut told: Vec<String> = Vec::new();
    for (name, sentences) in &of_types {
        for sentence in sentences {
            let is_of_all = of_types.iter().all(|(_, others)| others.contains(sentence));
            let text = match is_of_all {
                true => sentence.clone(),
                false => format!("For robots of type `{name}`: {sentence}"),
            };
            if !told.contains(&text) {
                told.push(text);
            }
        }
    }
    told
}

/// Returns the largest number of robots that the roads of a variant let under way at once; `None`
/// for large layouts. Of several robot types, it is the one of which most can be under way.
pub fn most_robots(variant: &Variant) -> Option<u32> {
    let is_small = variant.graph.edges().len() <= MOST_EDGES;
    let robots = variant.robots().into_iter().filter(|_| is_small);
    let most = robots.map(|(_, robot)| most_under_way(&variant.graph, &robot).at_nodes.robots);
    most.max().filter(|most| *most > 0)
}
