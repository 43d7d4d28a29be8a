//! Leaves out of a solution what isn't needed.

use super::problem::{Hop, Problem};

/// The most hops of shorter solutions that are followed, times the number of agents.
const MOST_WORK: usize = 1_000_000;

/// Leaves out ways there and back that make room for nobody: where an agent comes back to a stand,
/// and may as well have stayed. Returns hops that lead to the same end.
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
    let back = |last: &usize| problem.way(hops[own[*last]]).to == from;
    for last in (first..own.len()).rev().filter(back) {
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
