//! Joins the stands that differ only by the leg that leads there, which makes the search smaller.

use super::super::lacam::{Problem, Way};
use super::super::ways::{Path, Stand, stretches};
use crate::claims::Stretch;
use crate::roads::{Leg, Roads};

/// The properties that stands share that are alike.
#[derive(PartialEq)]
struct Kind {
    node: u32,
    /// The ways that leave the stand: their stretches and last legs.
    leaving: Vec<(Vec<Stretch>, Leg)>,
    /// The ways past the stand that a robot there blocks: the stands that they leave and their
    /// indices.
    past: Vec<(u16, u16)>,
}

/// Returns for each stand the first one that is like it.
pub fn alike(roads: &Roads, stands: &[Stand], paths: &[Vec<Path>], ways: &[Vec<Way>]) -> Vec<u16> {
    let node = |stand: u16| roads.end(stands[usize::from(stand)].leg);
    let mut past: Vec<Vec<(u16, u16)>> = vec![Vec::new(); stands.len()];
    for (from, ways) in (0..).zip(ways) {
        for (index, way) in (0..).zip(ways) {
            // A robot at an end of a way blocks it in any case.
            let ends = [node(from), node(way.to)];
            let others = way.blocked_by.iter().filter(|&&stand| !ends.contains(&node(stand)));
            for &stand in others {
                past[usize::from(stand)].push((from, index));
            }
        }
    }
    let mut kinds: Vec<(Kind, u16)> = Vec::new();
    let mut alike = Vec::new();
    for (number, past) in (0..).zip(past) {
        let (stand, paths) = (stands[usize::from(number)], &paths[usize::from(number)]);
        let leaving =
            paths.iter().map(|path| (stretches(roads, stand, &path.legs), path.to)).collect();
        let kind = Kind { node: node(number), leaving, past };
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
            for stand in &mut way.blocked_by {
                *stand = alike[usize::from(*stand)];
            }
            way.blocked_by.sort_unstable();
            way.blocked_by.dedup();
            way.blocked_by.retain(|&stand| stand != alike[number]);
        }
    }
    for start in &mut problem.starts {
        *start = alike[usize::from(*start)];
    }
}
