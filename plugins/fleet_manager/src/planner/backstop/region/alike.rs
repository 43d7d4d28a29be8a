//! Stands that differ only by the leg that leads there are one for the search: it would else look
//! at each of them.

use super::super::lacam::{Problem, Way};
use super::super::ways::{Path, Stand, stretches};
use crate::claims::Stretch;
use crate::roads::{Leg, Roads};

/// The properties that are the same on stands that are alike: the node, the ways that leave it, and
/// the ways past it on which a robot there is in the way.
type Kind = (u32, Vec<(Vec<Stretch>, Leg)>, Vec<(u16, u16)>);

/// Returns for each stand the first one that is like it: it makes no difference by which leg a
/// robot got there.
pub fn alike(roads: &Roads, stands: &[Stand], paths: &[Vec<Path>], ways: &[Vec<Way>]) -> Vec<u16> {
    let node = |stand: u16| roads.end(stands[usize::from(stand)].leg);
    let mut past: Vec<Vec<(u16, u16)>> = vec![Vec::new(); stands.len()];
    for (from, ways) in (0..).zip(ways) {
        for (index, way) in (0..).zip(ways) {
            // A robot at an end of a way is in the way in any case.
            let ends = [node(from), node(way.to)];
            let others = way.blocked_by.iter().filter(|&&stand| !ends.contains(&node(stand)));
            others.for_each(|&stand| past[usize::from(stand)].push((from, index)));
        }
    }
    let mut kinds: Vec<(Kind, u16)> = Vec::new();
    let mut alike = Vec::new();
    for (number, past) in (0..).zip(past) {
        let (stand, paths) = (stands[usize::from(number)], &paths[usize::from(number)]);
        let leaving =
            paths.iter().map(|path| (stretches(roads, stand, &path.legs), path.to)).collect();
        let kind = (node(number), leaving, past);
        let known = kinds
            .iter()
            .find(|(known, _)| stand.is_at_end(roads) && *known == kind)
            .map(|(_, first)| *first);
        alike.push(known.unwrap_or(number));
        if known.is_none() && stand.is_at_end(roads) {
            kinds.push((kind, number));
        }
    }
    alike
}

/// Replaces stands by the first ones that are like them.
pub fn join(problem: &mut Problem, alike: &[u16]) {
    for (number, ways) in problem.ways.iter_mut().enumerate() {
        for way in ways {
            way.to = alike[usize::from(way.to)];
            way.blocked_by.iter_mut().for_each(|stand| *stand = alike[usize::from(*stand)]);
            way.blocked_by.sort_unstable();
            way.blocked_by.dedup();
            way.blocked_by.retain(|&stand| stand != alike[number]);
        }
    }
    problem.starts.iter_mut().for_each(|start| *start = alike[usize::from(*start)]);
}
