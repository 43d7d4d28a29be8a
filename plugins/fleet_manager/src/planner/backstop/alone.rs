//! The way of one robot past all others, which go anywhere: best-first search over states.
//!
//! A state is the stand of the robot and the set of the stands of the others, whoever is where. So
//! there are few states where stands are few, and a search that ends without a way has proved that
//! there is none.

#[cfg(test)]
mod tests;

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use super::lacam::{Hop, Outcome, Problem};
use crate::roads::lower_costs;

/// The factor of the estimated remaining time: more leads to the goal sooner, by longer ways.
const GREED: f32 = 3.0;
/// The estimated time until another robot is out of the way, in seconds.
const IN_WAY_SECS: f32 = 10.0;
/// The number of choices of another search that take as long as a state of this one.
const WORK: u64 = 10;

/// A state that was reached.
#[derive(Debug)]
struct State {
    /// By agent: its stand.
    at: Vec<u16>,
    /// The state before, and the hop from there.
    before: Option<(u32, Hop)>,
    /// Seconds of all hops so far, one after the other.
    secs: f32,
}

/// A search.
#[derive(Debug)]
pub struct Search {
    problem: Problem,
    /// The agent with the target.
    agent: u16,
    /// By stand: the ways that lead there, as the stand that they leave and their index.
    into: Vec<Vec<(u16, u16)>>,
    states: Vec<State>,
    /// By the stand of the agent and those of the others in ascending order: the fewest seconds.
    known: BTreeMap<Vec<u16>, f32>,
    /// Estimated seconds in all, as bits, and states; the best one first.
    open: BinaryHeap<Reverse<(u32, u32)>>,
    work: u64,
}

impl Search {
    /// Begins a search for the first agent that has a target.
    pub fn new(problem: Problem) -> Self {
        let agent = problem.targets.iter().position(|targets| !targets.is_empty()).unwrap_or(0);
        let mut into = vec![Vec::new(); problem.ways.len()];
        for (from, ways) in (0..).zip(&problem.ways) {
            for (index, way) in (0..).zip(ways) {
                into[usize::from(way.to)].push((from, index));
            }
        }
        let mut search = Self {
            agent: agent as u16,
            into,
            states: Vec::new(),
            known: BTreeMap::new(),
            open: BinaryHeap::new(),
            work: 0,
            problem,
        };
        search.add(search.problem.starts.clone(), None);
        search
    }

    /// The problem that is searched.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// The time spent, in choices of other searches.
    pub fn work(&self) -> u64 {
        self.work
    }

    /// States that were reached so far.
    pub fn steps(&self) -> u64 {
        self.states.len() as u64
    }

    /// Searches on, until about so much more work is done.
    pub fn advance(&mut self, work: u64) -> Outcome {
        let until = self.work + work;
        while let Some(&Reverse((_, best))) = self.open.peek() {
            let at = self.states[best as usize].at[usize::from(self.agent)];
            if self.problem.targets[usize::from(self.agent)].contains(&at) {
                return Outcome::Found(self.hops_to(best));
            }
            if self.work >= until {
                return Outcome::Open;
            }
            self.open.pop();
            self.expand(best);
        }
        Outcome::None
    }

    /// Adds the states after each hop of each agent.
    fn expand(&mut self, number: u32) {
        let at = self.states[number as usize].at.clone();
        for (agent, &from) in (0..).zip(&at) {
            for way in 0..self.problem.ways[usize::from(from)].len() as u16 {
                let hop = Hop { agent, from, way };
                if let Some(after) = self.problem.after(&at, hop) {
                    self.add(after, Some((number, hop)));
                }
            }
        }
    }

    /// Adds a state, unless it is known with as little time.
    fn add(&mut self, at: Vec<u16>, before: Option<(u32, Hop)>) {
        self.work += WORK;
        let secs = before.map_or(0.0, |(before, hop)| {
            self.states[before as usize].secs + self.problem.way(hop).secs
        });
        let key = self.key(&at);
        if self.known.get(&key).is_some_and(|known| *known <= secs) {
            return;
        }
        let to_go = self.secs_to_go(&at);
        if to_go.is_infinite() {
            return;
        }
        self.known.insert(key, secs);
        let number = self.states.len() as u32;
        self.open.push(Reverse(((secs + GREED * to_go).to_bits(), number)));
        self.states.push(State { at, before, secs });
    }

    fn key(&self, at: &[u16]) -> Vec<u16> {
        let mut key = at.to_vec();
        key.swap(0, usize::from(self.agent));
        key[1..].sort_unstable();
        key
    }

    /// Estimates the seconds that the agent needs to its target, past the others.
    fn secs_to_go(&self, at: &[u16]) -> f32 {
        let start = at[usize::from(self.agent)];
        let mut is_taken = vec![false; self.problem.ways.len()];
        for &stand in at.iter().filter(|stand| **stand != start) {
            is_taken[usize::from(stand)] = true;
        }
        let mut bits = vec![f32::INFINITY.to_bits(); self.problem.ways.len()];
        let targets = &self.problem.targets[usize::from(self.agent)];
        let starts = targets.iter().map(|&stand| (stand.into(), 0));
        let is_taken = &is_taken;
        lower_costs(&mut bits, starts, |stand, so_far| {
            let ways = self.into[stand as usize].iter();
            ways.map(move |&(from, way)| {
                let way = &self.problem.ways[usize::from(from)][usize::from(way)];
                let in_way = way.blocked_by.iter().filter(|stand| is_taken[usize::from(**stand)]);
                let secs = way.secs.max(1e-3) + IN_WAY_SECS * in_way.count() as f32;
                (from.into(), (f32::from_bits(so_far) + secs).to_bits())
            })
        });
        f32::from_bits(bits[usize::from(start)])
    }

    fn hops_to(&self, number: u32) -> Vec<Hop> {
        let mut hops = Vec::new();
        let mut next = self.states[number as usize].before;
        while let Some((before, hop)) = next {
            hops.push(hop);
            next = self.states[before as usize].before;
        }
        hops.reverse();
        hops
    }
}
