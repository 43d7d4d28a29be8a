//! The verdicts of certificates against the search of all states.

use std::collections::BTreeSet;

use proptest::prelude::*;

use super::layouts::{layout, robot};
use super::model::{Model, bits, members};
use crate::model::route_graph::RouteGraph;
use crate::traffic::conflicts::{Conflicts, Sweeps};
use crate::traffic::network::Network;
use crate::traffic::passing::Passing;
use crate::traffic::stations::station_names;
use crate::traffic::tracks::{TrackKind, Tracks};
use crate::traffic::{
    Certainty, Certificate, CutOff, Effect, Exchange, MOST_RINGS, Others, RobotType, Section,
};
use crate::{NodeIndex, Role};

/// The number of random layouts.
const LAYOUTS: u32 = 2_500;

fn set(nodes: &[NodeIndex]) -> u32 {
    bits(nodes.iter().map(|node| node.0 as usize))
}

/// The nodes of the main part, and of all other ones: nodes that reach each other. The main one has
/// the most pairs of a node to pick at and another one to drop at, and then the most nodes.
fn parts(graph: &RouteGraph, model: &Model) -> (u32, Vec<u32>) {
    let reach = model.reach();
    let mut parts: Vec<u32> = Vec::new();
    for node in 0..model.nodes {
        let both = members(reach[node]).filter(|&other| reach[other] >> node & 1 == 1);
        let part = bits(both);
        if !parts.contains(&part) {
            parts.push(part);
        }
    }
    let roles = graph.purposes();
    let worth = |part: u32| {
        let pairs = members(part).flat_map(|from| members(part).map(move |to| (from, to)));
        let pairs = pairs.filter(|(from, to)| {
            from != to && roles[*from] == Role::Pick && roles[*to] == Role::Drop
        });
        (pairs.count(), part.count_ones())
    };
    let most = parts.iter().map(|part| worth(*part)).max();
    let main = parts.iter().position(|part| Some(worth(*part)) == most).unwrap_or(0);
    (parts.remove(main), parts)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(LAYOUTS))]

    /// All verdicts of one certificate: to make it takes longer than to check it.
    #[test]
    fn certificates_agree_with_the_search_of_all_states(graph in layout(), robot in robot()) {
        let model = Model::new(&graph, &robot);
        let certificate = Certificate::new(&graph, &robot);
        let case = Case { graph, robot, model, certificate };
        check_parts(&case)?;
        check_rings(&case)?;
        check_under_way(&case)?;
        check_stations(&case)?;
        check_sections(&case)?;
    }
}

/// A random layout, with its certificate and the search of all states.
struct Case {
    graph: RouteGraph,
    robot: RobotType,
    model: Model,
    certificate: Certificate,
}

/// Parts: one robot alone can drive between all nodes of a part, and between no two nodes of
/// different parts both ways.
fn check_parts(case: &Case) -> Result<(), TestCaseError> {
    let Case { graph, model, certificate, .. } = case;
    let (main, others) = parts(graph, model);
    let found: Vec<u32> = certificate.parts.iter().map(|part| set(&part.nodes)).collect();
    prop_assert_eq!(&found, &others);
    let reach = model.reach();
    let stations = bits(station_names(graph).keys().map(|node| *node as usize));
    for part in &certificate.parts {
        let nodes = set(&part.nodes);
        prop_assert_eq!(set(&part.stations), nodes & stations);
        let is_entered = members(main).any(|node| reach[node] & nodes != 0);
        let is_left = members(nodes).any(|node| reach[node] & main != 0);
        let expected = match (is_entered, is_left) {
            (true, false) => CutOff::CannotBeLeft,
            (false, true) => CutOff::CannotBeReached,
            (false, false) => CutOff::Apart,
            (true, true) => unreachable!("a part of the main one"),
        };
        prop_assert_eq!(part.cut_off, expected);
    }
    Ok(())
}

/// Rings: the smallest placements of robots that may all want a move that another one forbids.
/// Nothing is called impossible that the search of all placements finds.
fn check_rings(case: &Case) -> Result<(), TestCaseError> {
    let Case { model, certificate, .. } = case;
    let waiting: Vec<u32> =
        model.placements().filter(|set| *set != 0 && model.may_all_wait(*set)).collect();
    let minimal: Vec<u32> = waiting
        .iter()
        .copied()
        .filter(|set| waiting.iter().all(|other| other == set || other & set != *other))
        .collect();
    let pairs = minimal.iter().filter(|set| set.count_ones() == 2).count();
    let larger = minimal.iter().map(|set| set.count_ones() as usize).filter(|count| *count > 2);
    let mut larger: Vec<usize> = larger.collect();
    larger.sort_unstable();
    let rings = &certificate.rings;
    prop_assert_eq!(rings.certainty, Certainty::Exact);
    prop_assert_eq!(rings.pairs, pairs);
    let has_others = larger.len() > MOST_RINGS;
    prop_assert_eq!(rings.others, if has_others { Others::Some } else { Others::None });
    larger.truncate(MOST_RINGS);
    let listed: Vec<usize> = rings.smallest.iter().map(Vec::len).collect();
    prop_assert_eq!(listed, larger, "{:?}", rings);
    let sets: BTreeSet<u32> = rings.smallest.iter().map(|ring| set(ring)).collect();
    prop_assert_eq!(sets.len(), rings.smallest.len());
    prop_assert!(sets.iter().all(|set| minimal.contains(set)), "{:?}", rings);
    if let Some((a, b)) = rings.pair {
        prop_assert!(minimal.contains(&set(&[a, b])));
    }
    let fewest = waiting.iter().map(|set| set.count_ones() as usize).min();
    prop_assert_eq!(rings.fewest(), fewest);
    // Whatever robots stand where, and whichever moves they want, one of them can move.
    let safe = certificate.safe_robots();
    let with_roads = bits(model.moves.iter().flat_map(|step| [step.from, step.to]));
    for placement in model.placements().filter(|set| *set != 0 && set & !with_roads == 0) {
        let is_safe = safe.is_none_or(|safe| placement.count_ones() <= safe);
        prop_assert!(!is_safe || !model.may_be_stuck(placement), "{placement:b}");
    }
    if certificate.sinks.is_empty() {
        prop_assert_eq!(safe, fewest.map(|robots| robots as u32 - 1));
    }
    Ok(())
}

/// The largest number of robots that stand in the main part while one of them can move there.
fn check_under_way(case: &Case) -> Result<(), TestCaseError> {
    let Case { graph, model, certificate, .. } = case;
    let main = parts(graph, model).0;
    let moving = model.placements().filter(|&set| {
        set & !main == 0
            && members(set).any(|node| {
                model.free(node, set).any(|step| step.to != node && main >> step.to & 1 == 1)
            })
    });
    let most = certificate.under_way;
    prop_assert_eq!(most.at_nodes.certainty, Certainty::Exact);
    prop_assert_eq!(most.at_nodes.robots, moving.map(u32::count_ones).max().unwrap_or(0));
    prop_assert!(most.anywhere >= most.at_nodes.robots.into());
    Ok(())
}

/// Stations: which free nodes of the main part can still reach each other past a robot there.
fn check_stations(case: &Case) -> Result<(), TestCaseError> {
    let Case { graph, model, certificate, .. } = case;
    let main = parts(graph, model).0;
    for node in station_names(graph).keys().map(|node| *node as usize) {
        let found = certificate.stations.iter().find(|found| found.node.0 as usize == node);
        if main >> node & 1 == 0 {
            prop_assert!(found.is_none());
            continue;
        }
        let free = main & !(1 << node) & !model.touching[node];
        let reach = model.reach_past(1 << node, free);
        let is_whole = members(free).all(|from| free & !reach[from] == 0);
        match found.map(|found| found.effect) {
            Some(Effect::CutsOff(from, to)) => {
                prop_assert!(reach[from.0 as usize] >> to.0 & 1 == 0 && from != to);
                prop_assert!(free >> from.0 & 1 == 1 && free >> to.0 & 1 == 1);
            }
            Some(Effect::Detour) => {
                prop_assert!(is_whole && is_on_through_road(model, node, main, free));
            }
            Some(Effect::Unknown) => prop_assert!(false, "the search was stopped"),
            None => prop_assert!(is_whole && !is_on_through_road(model, node, main, free)),
        }
    }
    Ok(())
}

/// Sections: single tracks, joined where the search of all states of two robots finds no way to
/// exchange them around a node.
fn check_sections(case: &Case) -> Result<(), TestCaseError> {
    let certificate = &case.certificate;
    let oracle = Sections::new(case);
    let mut found: Vec<u32> =
        certificate.sections.iter().map(|section| set(&section.nodes)).collect();
    found.sort_unstable();
    prop_assert_eq!(found, oracle.node_sets());
    for section in &certificate.sections {
        oracle.check(section)?;
    }
    Ok(())
}
/// Whether robots drive between two free nodes by a move that a robot at a node forbids, or by way
/// of nodes that aren't free.
fn is_on_through_road(model: &Model, node: usize, main: u32, free: u32) -> bool {
    let taken = main & !free;
    let mut roads = BTreeSet::new();
    for step in &model.moves {
        let is_blocked = step.blockers >> node & 1 == 1 && free >> step.from & 1 == 1;
        if is_blocked && free >> step.to & 1 == 1 {
            roads.insert((step.from, step.to));
        } else if is_blocked && taken >> step.to & 1 == 1 {
            let inside = model.reach_past(0, taken)[step.to];
            let out = model.moves.iter().filter(|out| inside >> out.from & 1 == 1);
            let out = out.filter(|out| free >> out.to & 1 == 1);
            roads.extend(out.map(|out| (step.from, out.to)));
        }
    }
    roads.iter().any(|(from, to)| from != to)
}

/// The sections by definition: the relation between single tracks, closed.
struct Sections<'a> {
    model: &'a Model,
    tracks: Tracks,
    /// By node.
    is_passing: Vec<bool>,
}

impl<'a> Sections<'a> {
    fn new(Case { graph, robot, model, .. }: &'a Case) -> Self {
        let (network, sweeps) = (Network::new(graph), Sweeps::new(graph));
        let conflicts = Conflicts::new(&network, &sweeps, robot);
        let tracks = Tracks::new(&network, &sweeps, robot);
        let passing = Passing { network: &network, conflicts: &conflicts, tracks: &tracks };
        let is_passing = (0..network.nodes()).map(|node| {
            let around = bits(passing.surroundings(node).into_iter().map(|node| node as usize));
            let kinds = tracks.at(node).iter().map(|&track| tracks.get(track).kind);
            kinds.clone().any(|kind| kind == TrackKind::Double)
                || kinds.count() >= 3 && model.can_exchange(around)
        });
        let is_passing = is_passing.collect();
        Self { model, tracks, is_passing }
    }

    fn singles(&self) -> Vec<u32> {
        let tracks = (0_u32..).zip(&self.tracks.all);
        let single = tracks.filter(|(_, track)| track.kind == TrackKind::Single);
        single.map(|(_, track)| 1 << track.low | 1 << track.high).collect()
    }

    /// The nodes of each section, in ascending order of the numbers.
    fn node_sets(&self) -> Vec<u32> {
        let singles = self.singles();
        let mut label: Vec<usize> = (0..singles.len()).collect();
        for _ in 0..singles.len() {
            for (a, b) in (0..singles.len()).flat_map(|a| (0..a).map(move |b| (a, b))) {
                if members(singles[a] & singles[b]).any(|node| !self.is_passing[node]) {
                    let least = label[a].min(label[b]);
                    (label[a], label[b]) = (least, least);
                }
            }
        }
        let labels: BTreeSet<usize> = label.iter().copied().collect();
        let mut sets: Vec<u32> = labels
            .into_iter()
            .map(|of| label.iter().zip(&singles).filter(move |(label, _)| **label == of))
            .map(|tracks| tracks.fold(0, |all, (_, nodes)| all | nodes))
            .collect();
        sets.sort_unstable();
        sets
    }

    /// Checks the ends of a section and its capacity; and that two robots on a section without
    /// branches never exchange their places while they stay on it.
    fn check(&self, section: &Section) -> Result<(), TestCaseError> {
        let nodes = set(&section.nodes);
        let inside = nodes & !set(&section.ends);
        let standing = self.model.placements().filter(|set| set & !inside == 0);
        prop_assert_eq!(Some(section.at_nodes.robots), standing.map(u32::count_ones).max());
        prop_assert_eq!(section.at_nodes.certainty, Certainty::Exact);
        let count = |node: usize| self.tracks.at(node as u32).len();
        let dead_ends = bits(members(inside).filter(|&node| count(node) == 1));
        prop_assert_eq!(set(&section.dead_ends), dead_ends);
        if self.is_path(nodes) {
            prop_assert!(!self.model.can_exchange(nodes), "{:?}", section);
        }
        match section.exchange {
            Exchange::Never => prop_assert!(!self.model.can_exchange(nodes), "{:?}", section),
            Exchange::Possible => prop_assert!(self.model.can_exchange(nodes), "{:?}", section),
            Exchange::Unknown => prop_assert!(!section.ends.is_empty(), "{:?}", section),
        }
        Ok(())
    }

    /// Whether single tracks join the nodes of a set to a path, and no other tracks do.
    fn is_path(&self, nodes: u32) -> bool {
        let tracks = self.tracks.all.iter();
        let inside = tracks.filter(|track| (1 << track.low | 1 << track.high) & !nodes == 0);
        let singles: Vec<u32> =
            self.singles().into_iter().filter(|track| track & !nodes == 0).collect();
        let mut degrees = members(nodes)
            .map(|node| singles.iter().filter(|track| *track >> node & 1 == 1).count());
        inside.count() == singles.len()
            && singles.len() + 1 == nodes.count_ones() as usize
            && degrees.all(|degree| degree <= 2)
    }
}
