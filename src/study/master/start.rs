//! The places of vehicles at the start of a run: nodes, so that they take orders at once, and so
//! far apart that none touches another one.

use regatta_base::most_apart;
use regatta_base::random::Random;
use regatta_layout::{Node, RouteGraph};
use regatta_study::plan::{RobotGroup, Variant};
use regatta_study::workers::NOT_ALL_PLACED;
use serde_json::{Value, json};

use crate::failure::Failure;

/// Metres between the circles around two vehicles.
const CLEARANCE: f64 = 0.1;

/// Returns the robots of a scenario, each at a node of its own, which the seed chooses.
///
/// # Errors
/// If not all find a place.
pub fn robots(variant: &Variant, groups: &[RobotGroup], seed: u64) -> Result<Value, Failure> {
    let wanted: u32 = groups.iter().map(|group| group.count).sum();
    let mut nodes = places(&variant.graph, wanted as usize, apart(variant), seed).into_iter();
    let room = nodes.len();
    let others = match room < most(&variant.graph, apart(variant)) {
        true => "taken in the random order of the seed: another seed may place more",
        false => "which are all taken then, with any seed",
    };
    let mut robots = Vec::new();
    for group in groups {
        for _ in 0..group.count {
            let node = nodes.next().ok_or_else(|| {
                format!(
                    "{NOT_ALL_PLACED}: {room} of {wanted} vehicles fit at nodes, {CLEARANCE} m \
                     from each other however they turn, {others}; use fewer, or a larger layout"
                )
            })?;
            let mut robot = json!({ "node": node });
            if let Some(name) = &group.robot_type {
                robot["type"] = name.clone().into();
            }
            robots.push(robot);
        }
    }
    Ok(robots.into())
}

/// The number of vehicles that find places at nodes, up to `most`.
pub fn room(variant: &Variant, most: u32) -> u32 {
    places(&variant.graph, most as usize, apart(variant), 1).len() as u32
}

/// Metres between two vehicles, however they are turned.
fn apart(variant: &Variant) -> f64 {
    variant.max_diameter() + CLEARANCE
}

/// A number of vehicles that never finds more places, whatever the seed.
fn most(graph: &RouteGraph, apart: f64) -> usize {
    let positions: Vec<_> = graph.nodes().iter().map(|node| node.position).collect();
    most_apart(&positions, apart, |one, other| positions[one].distance(positions[other]) < apart)
}

/// Returns so many nodes, or all that there are, so far apart; the seed chooses them.
fn places(graph: &RouteGraph, wanted: usize, apart: f64, seed: u64) -> Vec<u32> {
    let random = Random::new(seed);
    let draw = |node: &Node| random.unit(node.id.into());
    let mut nodes: Vec<&Node> = graph.nodes().iter().collect();
    nodes.sort_by(|one, other| draw(one).total_cmp(&draw(other)));
    let mut chosen: Vec<&Node> = Vec::new();
    for node in nodes {
        let is_far = |other: &&Node| other.position.distance(node.position) >= apart;
        if chosen.len() < wanted && chosen.iter().all(is_far) {
            chosen.push(node);
        }
    }
    chosen.into_iter().map(|node| node.id).collect()
}

#[cfg(test)]
mod tests {
    use regatta_layout::{ReadOptions, parse};

    use super::*;

    #[test]
    fn vehicles_begin_at_nodes_of_their_own_and_apart() {
        let text = "id,x,y\nA,0,0\nB,10,0\nC,10,0.5\n\nfrom,to\nA,B\nB,C\nC,A\n";
        let graph = parse(text, "t.csv", &ReadOptions::default()).expect("a graph").0;
        let chosen = |seed| places(&graph, 9, 1.0, seed);
        assert!((0..9).all(|seed| chosen(seed).len() == 2), "{:?}", chosen(0));
        assert!((0..9).any(|seed| chosen(seed) != chosen(0)), "the seed chooses them");
        assert_eq!(places(&graph, 1, 1.0, 0).len(), 1);
    }

    #[test]
    fn vehicles_without_a_place_are_told_as_in_other_studies() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("t.csv");
        let text = "id,x,y\nA,0,0\nB,10,0\nC,10,0.5\n\nfrom,to\nA,B\nB,C\nC,A\n";
        std::fs::write(&path, text).expect("written");
        let variant = Variant::read(&path, &ReadOptions::default()).expect("a variant");
        let time = regatta_study::plan::RunTime { secs: 60, rate_hz: 10 };
        let groups = variant.job("t.csv", 3, 1, time, "").scenario.robots;
        let error = robots(&variant, &groups, 1).expect_err("two places").to_string();
        assert!(error.starts_with("not all found a place: 2 of 3 vehicles fit"), "{error}");
        assert!(error.contains("all taken then, with any seed"), "{error}");
        let row = text.replace("10,0.5", "2,0").replace("10,0", "1,0");
        std::fs::write(&path, row).expect("written");
        let row = Variant::read(&path, &ReadOptions::default()).expect("a variant");
        for seed in 0..20 {
            let error = robots(&row, &groups, seed).expect_err("too near").to_string();
            let words = match error.contains("1 of 3") {
                true => "another seed may place more",
                false => "2 of 3 vehicles fit",
            };
            assert!(error.contains(words), "{error}");
            assert_eq!(error.contains("1 of 3"), !error.contains("with any seed"), "{error}");
        }
    }
}
