//! Repairs errors that have one obvious correction: angles in degrees, duplicate edges, edges
//! without length, ends that nearly meet.

mod joins;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec2;
use regatta_base::bezier::CubicBezier;

use super::angles::are_degrees;
use super::gaps::MAX_JOINED_GAP;
use super::validate::MAX_GAP;
use crate::model::raw::{RawCurve, RawEdge, RawGraph, RawNode};
use crate::model::tags::Tags;
use crate::model::value::shorten;

/// Repairs a graph. Returns the repairs, one line each.
pub(crate) fn fix(raw: &mut RawGraph) -> Vec<String> {
    let mut fixes = Vec::new();
    fixes.extend(fix_angle_unit(raw));
    fixes.extend(remove_duplicate_edges(raw));
    fixes.extend(remove_loops(raw));
    fixes.extend(joins::join_ends(raw));
    fixes.extend(move_curve_ends(raw));
    fixes
}

/// Removes straight edges from a node to itself, which have no length.
fn remove_loops(raw: &mut RawGraph) -> Vec<String> {
    let loops = raw.edges.extract_if(.., |edge| {
        edge.origin.is_some()
            && edge.origin == edge.destination
            && matches!(edge.curve, None | Some(RawCurve::Linear))
    });
    let loops: Vec<RawEdge> = loops.collect();
    let ids = loops.iter().filter_map(|edge| Some((edge.id?, None)));
    let mut fixes: Vec<String> = loops
        .iter()
        .map(|edge| format!("{}: removed, it leads from a node to itself", name(edge)))
        .collect();
    fixes.extend(replace_edges(raw, ids.collect()));
    fixes
}

/// Replaces removed edges, by their ids, in zones and at doors by those that are kept in their
/// places. Removes doors across removed edges only. Returns the repairs.
fn replace_edges(raw: &mut RawGraph, mut by: BTreeMap<u32, Option<u32>>) -> Vec<String> {
    for id in raw.edges.iter().filter_map(|edge| edge.id) {
        by.remove(&id);
    }
    if by.is_empty() {
        return Vec::new();
    }
    for zone in &mut raw.zones {
        zone.edges = replaced(&zone.edges, |id| by.get(&id).copied().unwrap_or(Some(id)));
    }
    let mut fixes = Vec::new();
    raw.doors.retain_mut(|door| {
        let edges = replaced(&door.edges, |id| by.get(&id).copied().unwrap_or(Some(id)));
        let is_lost = edges.is_empty() && !door.edges.is_empty();
        if is_lost {
            let door = shorten(&door.name);
            fixes.push(format!("door `{door}`: removed, it is across removed edges only"));
        }
        door.edges = edges;
        !is_lost
    });
    fixes
}

/// Replaces the ids of a list, and leaves repeated ones out.
fn replaced(ids: &[u32], by: impl Fn(u32) -> Option<u32>) -> Vec<u32> {
    let mut seen = BTreeSet::new();
    ids.iter().filter_map(|&id| by(id)).filter(|id| seen.insert(*id)).collect()
}

/// Moves the ends of curves, with their handles, to the nodes that they nearly meet.
fn move_curve_ends(raw: &mut RawGraph) -> Vec<String> {
    let nodes = raw.nodes.iter().filter_map(|node| Some((node.id?, position(node)?)));
    let positions: BTreeMap<u32, DVec2> = nodes.collect();
    let mut fixes = Vec::new();
    for edge in &mut raw.edges {
        let [from, to] =
            [edge.origin, edge.destination].map(|id| id.and_then(|id| positions.get(&id)).copied());
        let Some(RawCurve::Cubics(cubics)) = &mut edge.curve else { continue };
        let mut gap: f64 = 0.0;
        if let (Some(node), Some(CubicBezier { control_points: [end, handle, ..] })) =
            (from, cubics.first_mut())
        {
            gap = gap.max(move_end(end, handle, node));
        }
        if let (Some(node), Some(CubicBezier { control_points: [.., handle, end] })) =
            (to, cubics.last_mut())
        {
            gap = gap.max(move_end(end, handle, node));
        }
        if gap > 0.0 {
            fixes.push(format!("{}: its curve ends at its nodes now, {gap:.3} m away", name(edge)));
        }
    }
    fixes
}

/// Moves an end of a curve to a node that it nearly meets. Returns the distance; 0 if it stays.
fn move_end(end: &mut DVec2, handle: &mut DVec2, node: DVec2) -> f64 {
    let shift = node - *end;
    let gap = shift.length();
    if !(MAX_GAP..=MAX_JOINED_GAP).contains(&gap) {
        return 0.0;
    }
    *end = node;
    *handle += shift;
    gap
}

/// Tells the unit of angles beyond a full turn, unless the file gives it.
fn fix_angle_unit(raw: &mut RawGraph) -> Option<String> {
    if raw.is_angle_unit_known || !are_degrees(raw) {
        return None;
    }
    raw.is_angle_unit_known = true;
    if !raw.is_imported {
        raw.degrees = true;
        return Some("the headings are in degrees: `AngleUnit: deg`".to_owned());
    }
    // Headings that the file doesn't give are computed from edges, in radians.
    for node in raw.nodes.iter_mut().filter(|node| node.has_heading) {
        node.theta = node.theta.map(f64::to_radians);
    }
    for edge in &mut raw.edges {
        edge.orientation = edge.orientation.map(f64::to_radians);
    }
    Some("the headings of nodes and edges are in degrees: converted to radians".to_owned())
}

/// Removes edges that equal an earlier one. Gives a new id to other edges that repeat an earlier
/// id.
fn remove_duplicate_edges(raw: &mut RawGraph) -> Vec<String> {
    let (mut fixes, mut removed) = (Vec::new(), BTreeMap::new());
    let mut next_id = raw.edges.iter().filter_map(|edge| edge.id).max().unwrap_or(0);
    // The indices of kept edges.
    let mut by_ends: BTreeMap<_, Vec<usize>> = BTreeMap::new();
    let mut ids = BTreeSet::new();
    let mut kept: Vec<RawEdge> = Vec::with_capacity(raw.edges.len());
    for mut edge in std::mem::take(&mut raw.edges) {
        let earlier = by_ends.entry((edge.origin, edge.destination)).or_default();
        if let Some(same) = earlier.iter().copied().find(|other| is_same(&kept[*other], &edge)) {
            let other = &mut kept[same];
            let (removed_name, other_name) = (name(&edge), name(other));
            let words = keep_name(other, &edge);
            fixes.push(format!("{removed_name}: removed, it is the same as {other_name}{words}"));
            removed.extend(edge.id.map(|id| (id, other.id)));
            continue;
        }
        if let Some(id) = edge.id.filter(|id| !ids.insert(*id))
            && let Some(free) = next_id.checked_add(1)
        {
            next_id = free;
            edge.id = Some(free);
            ids.insert(free);
            fixes.push(format!("edge {id}: the second one with this id is now edge {free}"));
        }
        earlier.push(kept.len());
        kept.push(edge);
    }
    raw.edges = kept;
    fixes.extend(replace_edges(raw, removed));
    fixes
}

/// Gives the name of a removed edge to the one that is kept, if that has none. Returns what has
/// become of the name, in words.
fn keep_name(kept: &mut RawEdge, removed: &RawEdge) -> String {
    let name = removed.tags.as_ref().and_then(|tags| tags.name.as_deref());
    let own = kept.tags.as_ref().and_then(|tags| tags.name.as_deref());
    match (own, name) {
        (None, Some(name)) => {
            let words = format!("; its name `{}` is kept", shorten(name));
            let tags = kept.tags.take().map_or_else(Tags::default, |tags| *tags);
            kept.tags = Tags { name: Some(name.into()), ..tags }.boxed();
            words
        }
        (Some(own), Some(name)) if own != name => {
            format!("; no edge has the name `{}` now", shorten(name))
        }
        _ => String::new(),
    }
}

/// Whether two edges are equal, apart from their ids and names.
fn is_same(a: &RawEdge, b: &RawEdge) -> bool {
    let [tags_a, tags_b] =
        [a, b].map(|edge| Tags { name: None, ..edge.tags.as_deref().cloned().unwrap_or_default() });
    a.origin.is_some()
        && (&a.curve, a.forward, a.backward) == (&b.curve, b.forward, b.backward)
        && (a.speed, a.reverse_speed) == (b.speed, b.reverse_speed)
        && (a.orientation, a.rotation) == (b.orientation, b.rotation)
        && tags_a == tags_b
}

fn name(edge: &RawEdge) -> String {
    let id = edge.id.map_or_else(|| "without id".to_owned(), |id| id.to_string());
    match edge.tags.as_ref().and_then(|tags| tags.name.as_deref()) {
        Some(name) => format!("edge {id} (`{}`)", shorten(name)),
        None => format!("edge {id}"),
    }
}

fn position(node: &RawNode) -> Option<DVec2> {
    node.position().filter(|position| position.is_finite())
}
