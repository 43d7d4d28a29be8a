//! Joins nodes at one place to one node, such as the nodes of a rotation table, or a charger at the
//! place of another vertex.
//!
//! Robots can't drive an edge without length. Its nodes become one node: that which comes first in
//! the file. The ids and names of the others are its aliases, by which scenarios find it.

use std::collections::{BTreeMap, BTreeSet};

use super::{EndIndices, Layout, LayoutEdge, LayoutNode, Shape};
use crate::check::validate::MIN_LENGTH;
use crate::model::finding::Report;
use crate::model::tags::Role;
use crate::model::value::{plural, shorten};

/// The largest number of nodes that the warning names.
const MAX_EXAMPLES: usize = 5;

/// The nodes and edges that are kept, by index.
pub(super) struct Kept {
    pub nodes: Vec<bool>,
    pub edges: Vec<bool>,
}

/// Joins the nodes of edges without length, and leaves these edges out. `ends` and `stations` are
/// the indices of the nodes of edges and stations.
pub(super) fn join(
    layout: &mut Layout,
    ends: &mut [EndIndices],
    stations: &mut [Vec<Option<usize>>],
    report: &mut Report<'_>,
) -> Kept {
    let mut kept =
        Kept { nodes: vec![true; layout.nodes.len()], edges: vec![true; layout.edges.len()] };
    let [joining, between_levels] = edges_without_length(layout, ends);
    leave_out(&between_levels, BETWEEN_LEVELS, layout, &mut kept, report);
    if let Some(&first) = joining.first() {
        let joins = Joins::new(&joining, ends);
        joins.report(layout, layout.edges[first].at, report);
        joins.apply(layout, ends, stations, &mut kept);
    }
    for edge in joining {
        kept.edges[edge] = false;
    }
    let loops = (0..ends.len()).filter(|&edge| kept.edges[edge] && is_loop(ends[edge])).collect();
    leave_out(&loops, LOOP, layout, &mut kept, report);
    for (ends, _) in ends.iter_mut().zip(&kept.edges).filter(|(_, is_kept)| !**is_kept) {
        *ends = [None, None];
    }
    let of_zones = layout.zones.iter_mut().map(|zone| &mut zone.edges);
    for edges in of_zones.chain(layout.doors.iter_mut().map(|door| &mut door.edges)) {
        edges.retain(|&edge| kept.edges[edge]);
    }
    layout.doors.retain(|door| !door.edges.is_empty());
    kept
}

const BETWEEN_LEVELS: &str = "joins two levels at one place, where it has no length";
const LOOP: &str = "starts and ends at the same node";

/// Returns the edges that lead from one node to another at the same place, and those of them that
/// join two levels.
fn edges_without_length(layout: &Layout, ends: &[EndIndices]) -> [Vec<usize>; 2] {
    let mut found = [Vec::new(), Vec::new()];
    for (index, (edge, ends)) in layout.edges.iter().zip(ends).enumerate() {
        let &[Some(origin), Some(destination)] = ends else { continue };
        let [from, to] = [origin, destination].map(|node| &layout.nodes[node]);
        let Some((start, end)) = from.position.zip(to.position) else { continue };
        let gap = start.distance(end);
        if origin != destination && gap < MIN_LENGTH && !is_curve(&edge.shape) {
            found[usize::from(from.tags.level != to.tags.level)].push(index);
        }
    }
    found
}

/// Whether a shape has a length of its own, besides the distance of its nodes.
fn is_curve(shape: &Shape) -> bool {
    match shape {
        Shape::Straight => false,
        Shape::Cubics(cubics) => {
            cubics.iter().map(|cubic| cubic.polyline_length(4)).sum::<f64>() >= MIN_LENGTH
        }
    }
}

fn is_loop([origin, destination]: EndIndices) -> bool {
    origin.is_some() && origin == destination
}

/// Leaves edges out, with one warning.
fn leave_out(
    edges: &Vec<usize>,
    reason: &str,
    layout: &Layout,
    kept: &mut Kept,
    report: &mut Report<'_>,
) {
    let Some(&first) = edges.first() else { return };
    for &edge in edges {
        kept.edges[edge] = false;
    }
    let more = match edges.len() - 1 {
        0 => String::new(),
        more => format!(" (and {})", plural(more, "more edge")),
    };
    let LayoutEdge { at, id, .. } = &layout.edges[first];
    report.assumption(*at, format!("edge `{}` {reason}{more}: left out", shorten(id)));
}

/// The nodes that are joined with others: by index, with the node that is kept.
struct Joins(BTreeMap<usize, usize>);

impl Joins {
    /// Joins the nodes of edges.
    fn new(edges: &[usize], ends: &[EndIndices]) -> Self {
        let mut joins = Self(BTreeMap::new());
        for &edge in edges {
            let [Some(origin), Some(destination)] = ends[edge] else { continue };
            let [one, other] = [origin, destination].map(|node| joins.find(node));
            if one != other {
                joins.0.insert(one.max(other), one.min(other));
            }
        }
        let joined: Vec<usize> = joins.0.keys().copied().collect();
        for node in joined {
            joins.find(node);
        }
        joins
    }

    /// Returns the node that a node is joined with, and shortens the way there.
    fn find(&mut self, node: usize) -> usize {
        let mut last = node;
        while let Some(&next) = self.0.get(&last) {
            last = next;
        }
        let mut at = node;
        while at != last {
            at = self.0.insert(at, last).unwrap_or(last);
        }
        last
    }

    /// Moves all references to the nodes that are kept, which take over what the others have.
    fn apply(
        &self,
        layout: &mut Layout,
        ends: &mut [EndIndices],
        stations: &mut [Vec<Option<usize>>],
        kept: &mut Kept,
    ) {
        let references = ends.iter_mut().flatten().chain(stations.iter_mut().flatten()).flatten();
        let of_zones = layout.zones.iter_mut().flat_map(|zone| &mut zone.nodes);
        let of_lifts = layout.lifts.iter_mut().flat_map(|lift| &mut lift.nodes);
        for node in references.chain(of_zones).chain(of_lifts) {
            *node = self.0.get(node).copied().unwrap_or(*node);
        }
        stations.iter_mut().for_each(remove_repeated);
        layout.zones.iter_mut().for_each(|zone| remove_repeated(&mut zone.nodes));
        layout.lifts.iter_mut().for_each(|lift| remove_repeated(&mut lift.nodes));
        let mut aliases: BTreeMap<usize, Vec<String>> = BTreeMap::new();
        for (&node, &target) in &self.0 {
            kept.nodes[node] = false;
            let joined = std::mem::take(&mut layout.nodes[node]);
            layout.nodes[target].absorb(joined, aliases.entry(target).or_default());
        }
        for (target, aliases) in aliases {
            layout.nodes[target].tags.set_aliases(&aliases);
        }
    }

    fn report(&self, layout: &Layout, at: u32, report: &mut Report<'_>) {
        let mut pairs = Vec::new();
        for (&node, &target) in self.0.iter().take(MAX_EXAMPLES) {
            let [node, target] = [node, target].map(|node| &layout.nodes[node]);
            let kept = target.role.and(node.role);
            let lost = if kept == node.role { target.role } else { node.role };
            let lost = match lost == Role::None || kept == lost || kept == Role::Transfer {
                true => String::new(),
                false => format!(" (the role {} is lost)", lost.name()),
            };
            let [node, target] = [node, target].map(|node| shorten(&node.id));
            pairs.push(format!("`{node}` with `{target}`{lost}"));
        }
        let more = match self.0.len() - pairs.len() {
            0 => String::new(),
            more => format!(" and {}", plural(more, "more node")),
        };
        let message = format!(
            "nodes at one place that an edge without length joins are read as one node: {}{more}",
            pairs.join(", ")
        );
        report.file_warning(at, message);
    }
}

fn remove_repeated<Id: Ord + Copy>(list: &mut Vec<Id>) {
    let mut seen = BTreeSet::new();
    list.retain(|id| seen.insert(*id));
}

impl LayoutNode {
    /// Takes over what another node at the same place has and this one lacks. Its names are added
    /// to `aliases`.
    fn absorb(&mut self, other: LayoutNode, aliases: &mut Vec<String>) {
        let LayoutNode { id, heading, role, tags, .. } = other;
        self.heading = self.heading.or(heading);
        self.role = self.role.and(role);
        self.tags.zone = self.tags.zone.take().or(tags.zone);
        aliases.extend(tags.name.filter(|name| **name != *id).map(String::from));
        aliases.push(id);
        for (key, value) in tags.properties {
            self.tags.properties.entry(key).or_insert(value);
        }
    }
}
