//! Joins ends that nearly meet to one node, which takes over what the others have.

use std::collections::{BTreeMap, BTreeSet};

use super::replaced;
use crate::check::gaps::{Gap, Neighbours, ends, gaps, obstacle};
use crate::check::validate::to_radians;
use crate::model::angle::normalize_angle;
use crate::model::raw::{RawCurve, RawGraph, RawNode};
use crate::model::tags::{ALIASES, NAME, Role, Tags};
use crate::model::value::shorten;

/// The difference of headings in radians up to which nodes are joined: 5°.
const MAX_JOINED_TURN: f64 = regatta_base::graph::SMOOTH_TURN;

/// Joins nodes at nearly the same place of a level, if a road ends at one of them, no edge leads
/// from one to the other, and both can be kept in one node.
pub(super) fn join_ends(raw: &mut RawGraph) -> Vec<String> {
    let neighbours = Neighbours::of(raw);
    let ends = ends(raw, &neighbours);
    let gaps = gaps(raw, &neighbours, &ends);
    let bent = ids_of_splines(raw);
    let mut joins =
        Joins { neighbours, ends, bent, index: index_of(raw), targets: BTreeMap::new() };
    let mut fixes = Vec::new();
    let mut joined_ends = BTreeSet::new();
    for gap in gaps {
        // The gaps of an end follow by distance: it is joined with the nearest node that it can.
        if !joined_ends.contains(&gap.end)
            && let Some(fix) = joins.join(raw, gap)
        {
            fixes.push(fix);
            joined_ends.insert(gap.end);
        }
    }
    let targets = joins.resolved();
    replace_nodes(raw, &targets);
    fixes
}

/// Returns the ids of nodes whose headings bend an edge. The curves of other formats don't depend
/// on the headings of their nodes.
fn ids_of_splines(raw: &RawGraph) -> BTreeSet<u32> {
    let splines = raw.edges.iter().filter(|edge| matches!(edge.curve, Some(RawCurve::Spline)));
    let ids = splines.flat_map(|edge| [edge.origin, edge.destination]).flatten();
    if raw.is_imported { BTreeSet::new() } else { ids.collect() }
}

/// Replaces joined nodes wherever they are named, and removes them.
fn replace_nodes(raw: &mut RawGraph, targets: &BTreeMap<u32, u32>) {
    let ends = raw.edges.iter_mut().flat_map(|edge| [&mut edge.origin, &mut edge.destination]);
    for id in ends.flatten() {
        *id = targets.get(id).copied().unwrap_or(*id);
    }
    let lists = (raw.stations.iter_mut().map(|station| &mut station.nodes))
        .chain(raw.zones.iter_mut().map(|zone| &mut zone.nodes))
        .chain(raw.lifts.iter_mut().map(|lift| &mut lift.nodes));
    for list in lists {
        *list = replaced(list, |id| Some(targets.get(&id).copied().unwrap_or(id)));
    }
    raw.nodes.retain(|node| node.id.is_none_or(|id| !targets.contains_key(&id)));
}

/// The nodes that are joined so far, by id.
struct Joins {
    neighbours: Neighbours,
    ends: BTreeSet<u32>,
    /// Nodes whose headings bend an edge.
    bent: BTreeSet<u32>,
    /// The index of each node.
    index: BTreeMap<u32, usize>,
    /// The node that each joined node is joined with, which may itself be joined with another one.
    targets: BTreeMap<u32, u32>,
}

impl Joins {
    /// Joins the nodes of a gap, or those that they are joined with. Returns the repair; `None` if
    /// they can't be one node.
    fn join(&mut self, raw: &mut RawGraph, gap: Gap) -> Option<String> {
        let [end, other] = [gap.end, gap.other].map(|index| raw.nodes[index].id);
        let [end, other] = [self.find(end?), self.find(other?)];
        let is_loop = end == other || self.neighbours.are_joined(end, other);
        let [end, other] = [end, other].map(|id| self.index.get(&id).copied());
        let (end, other) = (end?, other?);
        if is_loop || !self.can_join(raw, &raw.nodes[end], &raw.nodes[other]) {
            return None;
        }
        let (lost, kept) = self.order(raw, end, other);
        Some(self.merge(raw, lost, kept, gap.distance))
    }

    /// Returns the index of the node that is removed, and that of the one that stays: the one at
    /// which no road ends, or else the earlier one.
    fn order(&self, raw: &RawGraph, end: usize, other: usize) -> (usize, usize) {
        match (self.is_end(&raw.nodes[end]), self.is_end(&raw.nodes[other])) {
            (true, false) => (end, other),
            (false, true) => (other, end),
            _ => (end.max(other), end.min(other)),
        }
    }

    /// Whether a road ends at a node.
    fn is_end(&self, node: &RawNode) -> bool {
        node.id.is_some_and(|id| self.ends.contains(&id))
    }

    /// Whether each of two nodes keeps what it has, and has nearly the same heading if a curve
    /// depends on it.
    fn can_join(&self, raw: &RawGraph, a: &RawNode, b: &RawNode) -> bool {
        let (Some(theta), Some(other_theta)) = (a.theta, b.theta) else { return false };
        let turn = to_radians(other_theta, raw.degrees) - to_radians(theta, raw.degrees);
        let is_bent = [a.id, b.id].into_iter().flatten().any(|id| self.bent.contains(&id));
        obstacle(raw, a, b).is_none()
            && (!is_bent || normalize_angle(turn).abs() <= MAX_JOINED_TURN)
    }

    fn merge(&mut self, raw: &mut RawGraph, lost: usize, kept: usize, distance: f64) -> String {
        let [name, kept_name] = [lost, kept].map(|index| node_name(&raw.nodes[index]));
        if let (Some(id), Some(kept)) = (raw.nodes[lost].id, raw.nodes[kept].id) {
            self.targets.insert(id, kept);
            self.neighbours.replace(id, kept);
            if self.bent.contains(&id) {
                self.bent.insert(kept);
            }
        }
        let takings = absorb(raw, lost, kept);
        format!("{name}: joined with {kept_name}, {distance:.3} m away{takings}")
    }

    /// Returns the node that a node is joined with in the end.
    fn find(&self, mut id: u32) -> u32 {
        while let Some(&next) = self.targets.get(&id) {
            id = next;
        }
        id
    }

    fn resolved(&self) -> BTreeMap<u32, u32> {
        self.targets.keys().map(|&id| (id, self.find(id))).collect()
    }
}

fn index_of(raw: &RawGraph) -> BTreeMap<u32, usize> {
    raw.nodes.iter().enumerate().filter_map(|(index, node)| Some((node.id?, index))).collect()
}

fn node_name(node: &RawNode) -> String {
    let id = node.id.map_or_else(|| "without id".to_owned(), |id| id.to_string());
    match node.tags.as_ref().and_then(|tags| tags.name.as_deref()) {
        Some(name) => format!("node {id} (`{}`)", shorten(name)),
        None => format!("node {id}"),
    }
}

/// Gives what a node has to the node that it is joined with. Returns the words for its role and
/// its name.
fn absorb(raw: &mut RawGraph, lost: usize, kept: usize) -> String {
    let lost = &mut raw.nodes[lost];
    let (role, has_heading, theta) = (lost.role, lost.has_heading, lost.theta);
    let (body_heading, tags) = (lost.body_heading, lost.tags.take());
    let kept = &mut raw.nodes[kept];
    let mut words = String::new();
    if kept.role == Role::None && role != Role::None {
        kept.role = role;
        words += &format!("; its role {} is kept", role.name());
    }
    if !kept.has_heading && has_heading {
        (kept.has_heading, kept.theta) = (true, theta);
    }
    kept.body_heading = kept.body_heading.or(body_heading);
    if let Some(tags) = tags {
        let mut all = kept.tags.take().map_or_else(Tags::default, |tags| *tags);
        words += &absorb_tags(&mut all, *tags);
        kept.tags = all.boxed();
    }
    words
}

fn absorb_tags(kept: &mut Tags, lost: Tags) -> String {
    let mut others = lost.aliases();
    let mut words = String::new();
    match (&kept.name, lost.name) {
        (None, Some(name)) => {
            words = format!("; its name `{}` is kept", shorten(&name));
            kept.name = Some(name);
        }
        (Some(own), Some(name)) if *own != name => {
            words = format!("; `{}` is another name of it now", shorten(&name));
            others.insert(0, name.into());
        }
        _ => {}
    }
    kept.add_aliases(others);
    kept.zone = kept.zone.take().or(lost.zone);
    for (key, value) in lost.properties {
        if ![NAME, ALIASES].contains(&&*key) {
            kept.properties.entry(key).or_insert(value);
        }
    }
    words
}
