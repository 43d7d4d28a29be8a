//! Shortens solutions.

use super::problem::{Hop, Problem};

/// The largest number of hops of shorter solutions that are followed, times the number of agents.
const MOST_WORK: usize = 1_000_000;

/// Leaves out the loops of agents that make room for no other: an agent comes back to a stand, and
/// could have stayed. Returns hops that lead to the same end.
pub fn shorten(problem: &Problem, mut hops: Vec<Hop>) -> Vec<Hop> {
    let mut work = 0;
    for agent in 0..problem.starts.len() as u16 {
        let mut first = 0;
        while let Some(shorter) = without_loop(problem, &hops, agent, first, &mut work) {
            match shorter {
                Some(shorter) => hops = shorter,
                None => first += 1,
            }
        }
    }
    hops
}

/// Leaves out the longest loop of an agent from its `first` hop on; `Some(None)` if there is none,
/// `None` beyond its last hop.
fn without_loop(
    problem: &Problem,
    hops: &[Hop],
    agent: u16,
    first: usize,
    work: &mut usize,
) -> Option<Option<Vec<Hop>>> {
    let own: Vec<usize> = (0..hops.len()).filter(|&index| hops[index].agent == agent).collect();
    let from = hops[*own.get(first)?].from;
    for last in (first..own.len()).rev() {
        if problem.way(hops[own[last]]).to != from {
            continue;
        }
        *work += hops.len() * problem.starts.len();
        if *work > MOST_WORK {
            return None;
        }
        let left_out = &own[first..=last];
        let rest: Vec<Hop> = (0..hops.len())
            .filter(|index| left_out.binary_search(index).is_err())
            .map(|index| hops[index])
            .collect();
        if problem.follow(&rest).is_some() {
            return Some(Some(rest));
        }
    }
    Some(None)
}
