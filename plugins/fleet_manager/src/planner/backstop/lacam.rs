//! LaCAM: lazy constraints addition search, for the ways of a few robots that block each other.
//!
//! K. Okumura: LaCAM: Search-Based Algorithm for Quick Multi-Agent Pathfinding, 2023; Improving
//! LaCAM for Scalable Eventually Optimal Multi-Agent Pathfinding, 2023.
//!
//! A configuration is the stand of each robot. The search goes from configuration to
//! configuration, depth first. The next one comes from priority inheritance ([`step`]); each time
//! that a configuration is visited again, another robot is bound to a choice of its own, until all
//! that can follow has been tried. So a solution is found if there is one, given the time.
//!
//! Unlike in the publication, within a step robots hop one after the other, each onto
//! stands that are free then. So there are neither swaps nor full rotations, which claims wouldn't
//! allow either.

mod problem;
mod step;
#[cfg(test)]
pub mod tests;

use std::collections::BTreeMap;

pub use self::problem::{Hop, Problem, Way, shorten};
use self::step::{Choice, Step};

/// The state of a search.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// It isn't over.
    Open,
    /// These hops, one after the other, lead all robots to their targets.
    Found(Vec<Hop>),
    /// There is no solution.
    None,
}

/// The constraints on some robots in a step: a linked list, from its end.
#[derive(Clone, Copy, Debug)]
struct Bond {
    /// Index of the bond before; itself if there is none.
    before: u32,
    /// Robots bound.
    count: u16,
    agent: u16,
    choice: Choice,
}

/// A configuration that was reached.
#[derive(Debug)]
struct Node {
    /// By agent: its stand.
    at: Vec<u16>,
    parent: Option<u32>,
    /// From the parent's configuration to this one.
    hops: Vec<Hop>,
    /// Agents, in the order in which they choose.
    order: Vec<u16>,
    /// By agent: configurations since it was at its target.
    away: Vec<u16>,
    bonds: Vec<Bond>,
    /// Index of the next bond to try; the first binds no robot.
    next: usize,
}

/// A search.
#[derive(Debug)]
pub struct Search {
    problem: Problem,
    /// By agent and stand: seconds to its target; infinity from where it can't be reached. Empty
    /// without a target.
    secs: Vec<Vec<f32>>,
    nodes: Vec<Node>,
    known: BTreeMap<Vec<u16>, u32>,
    /// Nodes to visit, the next one at the end.
    open: Vec<u32>,
    work: u64,
    steps: u64,
}

impl Search {
    /// Begins a search.
    pub fn new(problem: Problem) -> Self {
        let secs: Vec<Vec<f32>> =
            problem.targets.iter().map(|target| problem.secs_to(target)).collect();
        let mut search = Self {
            secs,
            nodes: Vec::new(),
            known: BTreeMap::new(),
            open: Vec::new(),
            work: 0,
            steps: 0,
            problem,
        };
        let starts = search.problem.starts.clone();
        if (0..starts.len()).all(|agent| search.to_go(agent, starts[agent]).is_finite()) {
            search.add(starts, None, Vec::new());
        }
        search
    }

    /// The problem that is searched.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// Choices that were tried so far: a measure of the time spent.
    pub fn work(&self) -> u64 {
        self.work
    }

    /// Configurations that were computed so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Searches on, until about as many more choices were tried.
    pub fn advance(&mut self, work: u64) -> Outcome {
        let until = self.work + work;
        while let Some(&top) = self.open.last() {
            if self.is_goal(top) {
                return Outcome::Found(self.hops_to(top));
            }
            if self.work >= until {
                return Outcome::Open;
            }
            let node = &mut self.nodes[top as usize];
            if node.next == node.bonds.len() + 1 {
                self.open.pop();
                continue;
            }
            let bond = node.next.checked_sub(1);
            node.next += 1;
            self.bind_next(top, bond);
            self.step(top, bond);
        }
        Outcome::None
    }

    fn to_go(&self, agent: usize, stand: u16) -> f32 {
        step::to_go(&self.secs[agent], stand)
    }

    fn is_goal(&self, node: u32) -> bool {
        let at = &self.nodes[node as usize].at;
        at.iter().enumerate().all(|(agent, &stand)| self.to_go(agent, stand) == 0.0)
    }

    /// Adds the bonds that follow one: those of the next agent to each of its choices.
    fn bind_next(&mut self, node: u32, bond: Option<usize>) {
        let node = &mut self.nodes[node as usize];
        let count = bond.map_or(0, |bond| node.bonds[bond].count);
        let Some(&agent) = node.order.get(usize::from(count)) else { return };
        let before = bond.unwrap_or(node.bonds.len()) as u32;
        let ways = self.problem.ways[usize::from(node.at[usize::from(agent)])].len() as u16;
        for choice in (0..ways).map(Some).chain([None]) {
            // The first bond of a list refers to itself.
            let before = if bond.is_some() { before } else { node.bonds.len() as u32 };
            node.bonds.push(Bond { before, count: count + 1, agent, choice });
        }
    }

    /// Computes the configuration that follows a node under a bond.
    fn step(&mut self, top: u32, bond: Option<usize>) {
        self.steps += 1;
        let node = &self.nodes[top as usize];
        let mut step = Step::new(&self.problem, &self.secs, &node.at, self.steps);
        let mut index = bond;
        while let Some(bond) = index.map(|index| node.bonds[index]) {
            step.bind(bond.agent, bond.choice);
            index = Some(bond.before as usize).filter(|before| Some(*before) != index);
        }
        let is_possible = step.run(&node.order);
        self.work += step.work;
        let (at, hops) = (step.at, step.hops);
        if !is_possible {
            return;
        }
        match self.known.get(&at) {
            Some(&known) if known == top => {}
            // It is looked at again at once: with another bond, it leads on elsewhere.
            Some(&known) => self.open.push(known),
            None => self.add(at, Some(top), hops),
        }
    }

    fn add(&mut self, at: Vec<u16>, parent: Option<u32>, hops: Vec<Hop>) {
        let agents = 0..at.len();
        let before = parent.map(|parent| &self.nodes[parent as usize].away);
        let away: Vec<u16> = agents
            .clone()
            .map(|agent| match self.to_go(agent, at[agent]) {
                0.0 => 0,
                _ => before.map_or(1, |before| before[agent].saturating_add(1)),
            })
            .collect();
        let mut order: Vec<u16> = agents.map(|agent| agent as u16).collect();
        // The robot that has been away from its target the longest chooses first; at the start, the
        // one with the longest way.
        order.sort_by(|&a, &b| {
            let [a, b] = [a, b].map(usize::from);
            away[b].cmp(&away[a]).then(self.to_go(b, at[b]).total_cmp(&self.to_go(a, at[a])))
        });
        let number = self.nodes.len() as u32;
        self.known.insert(at.clone(), number);
        self.open.push(number);
        self.nodes.push(Node { at, parent, hops, order, away, bonds: Vec::new(), next: 0 });
    }

    fn hops_to(&self, node: u32) -> Vec<Hop> {
        let mut parts = Vec::new();
        let mut next = Some(node);
        while let Some(node) = next.map(|node| &self.nodes[node as usize]) {
            parts.push(&node.hops);
            next = node.parent;
        }
        parts.into_iter().rev().flatten().copied().collect()
    }
}
