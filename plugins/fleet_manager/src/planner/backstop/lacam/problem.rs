//! The problem that LaCAM searches: stands, ways between them, and the targets of robots.

use crate::roads::lower_costs;
/// A way from a stand to another one.
#[derive(Clone, Debug, PartialEq)]
pub struct Way {
    /// The stand to which it leads.
    pub to: u16,
    /// Stands on which a robot would be in the way, in ascending order: its end, and those that it
    /// passes too near.
    pub blocked_by: Vec<u16>,
    /// Driving time, in seconds.
    pub secs: f32,
}

impl Way {
    /// Whether a robot on a stand is in the way.
    pub fn is_blocked_by(&self, stand: u16) -> bool {
        self.blocked_by.binary_search(&stand).is_ok()
    }
}

/// Some robots, here agents, and where they may go.
#[derive(Clone, Debug, Default)]
pub struct Problem {
    /// By stand: the ways that leave it.
    pub ways: Vec<Vec<Way>>,
    /// By agent: its stand.
    pub starts: Vec<u16>,
    /// By agent: its target stands, of which it must reach one; empty if any stand will do.
    pub targets: Vec<Vec<u16>>,
}

/// An agent takes a way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hop {
    /// The agent.
    pub agent: u16,
    /// The stand that it leaves.
    pub from: u16,
    /// Index of the way among those that leave the stand.
    pub way: u16,
}

impl Problem {
    /// The way of a hop.
    pub fn way(&self, hop: Hop) -> &Way {
        &self.ways[usize::from(hop.from)][usize::from(hop.way)]
    }

    /// Follows hops from the starts. Returns where agents are then; `None` if a hop doesn't start
    /// where its agent is, or another one is in its way.
    pub fn follow(&self, hops: &[Hop]) -> Option<Vec<u16>> {
        hops.iter().try_fold(self.starts.clone(), |at, &hop| self.after(&at, hop))
    }

    /// Returns where agents are after a hop; `None` if it doesn't start where its agent is, or
    /// another one is in its way.
    pub fn after(&self, at: &[u16], hop: Hop) -> Option<Vec<u16>> {
        let (agent, way) = (usize::from(hop.agent), self.way(hop));
        let mut others = at.iter().enumerate().filter(|(other, _)| *other != agent);
        if at[agent] != hop.from || others.any(|(_, &stand)| way.is_blocked_by(stand)) {
            return None;
        }
        let mut after = at.to_vec();
        after[agent] = way.to;
        Some(after)
    }

    /// Returns the seconds from each stand to the nearest of some targets, without other robots;
    /// nothing without targets.
    pub fn secs_to(&self, targets: &[u16]) -> Vec<f32> {
        if targets.is_empty() {
            return Vec::new();
        }
        let mut into: Vec<Vec<(u32, f32)>> = vec![Vec::new(); self.ways.len()];
        for (from, ways) in (0..).zip(&self.ways) {
            for way in ways {
                into[usize::from(way.to)].push((from, way.secs.max(1e-3)));
            }
        }
        // Seconds aren't negative: their bits are in their order.
        let mut bits = vec![f32::INFINITY.to_bits(); self.ways.len()];
        let starts = targets.iter().map(|&target| (target.into(), 0));
        lower_costs(&mut bits, starts, |stand, so_far| {
            let so_far = f32::from_bits(so_far);
            into[stand as usize].iter().map(move |(from, secs)| (*from, (so_far + secs).to_bits()))
        });
        bits.into_iter().map(f32::from_bits).collect()
    }
}

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
