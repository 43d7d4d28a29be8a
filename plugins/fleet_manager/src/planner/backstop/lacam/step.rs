//! From a configuration to the next one: priority inheritance with backtracking.
//!
//! K. Okumura, M. Machida, X. Défago, Y. Tamura: Priority Inheritance with Backtracking for
//! Iterative Multi-agent Path Finding, 2022. An agent whose way others block has them go first; an
//! agent that has gone doesn't come back within the step.

use regatta_base::random::mix;

use super::problem::{Hop, Problem, Way};

/// Index of the way that an agent takes; none to stay.
pub(super) type Choice = Option<u16>;

const NO_AGENT: u16 = u16::MAX;

/// A step in the making.
pub(super) struct Step<'a> {
    problem: &'a Problem,
    secs: &'a [Vec<f32>],
    /// By agent: the choice that it is bound to.
    bound: Vec<Option<Choice>>,
    /// By agent: its stand.
    pub at: Vec<u16>,
    /// By stand: the agent that is there, or [`NO_AGENT`].
    occupants: Vec<u16>,
    is_decided: Vec<bool>,
    /// Ways that agents wait for to become free.
    pending: Vec<&'a Way>,
    /// One after the other.
    pub hops: Vec<Hop>,
    /// The seed of the order of equal choices.
    salt: u64,
    /// Choices tried.
    pub work: u64,
}

impl<'a> Step<'a> {
    pub(super) fn new(problem: &'a Problem, secs: &'a [Vec<f32>], at: &[u16], salt: u64) -> Self {
        let mut occupants = vec![NO_AGENT; problem.ways.len()];
        for (agent, &stand) in (0..).zip(at) {
            occupants[usize::from(stand)] = agent;
        }
        let agents = at.len();
        Self {
            problem,
            secs,
            bound: vec![None; agents],
            at: at.to_vec(),
            occupants,
            is_decided: vec![false; agents],
            pending: Vec::new(),
            hops: Vec::new(),
            salt,
            work: 1,
        }
    }

    /// Binds an agent to a choice.
    pub(super) fn bind(&mut self, agent: u16, choice: Choice) {
        self.bound[usize::from(agent)] = Some(choice);
    }

    /// Lets agents choose in their order. Returns `false` if one can't do what it is bound to.
    pub(super) fn run(&mut self, order: &[u16]) -> bool {
        for &agent in order {
            let index = usize::from(agent);
            if self.bound[index].is_some() && !self.is_decided[index] && !self.decide(agent, false)
            {
                return false;
            }
        }
        for &agent in order {
            if !self.is_decided[usize::from(agent)] {
                self.decide(agent, false);
            }
        }
        // A robot that couldn't get out of another one's way has stayed, whatever its constraint.
        (0..).zip(&self.bound).all(|(agent, bound)| {
            !matches!(bound, Some(Some(_))) || self.hops.iter().any(|hop| hop.agent == agent)
        })
    }

    /// Lets an agent choose. An agent that blocks another one can't stay. Returns whether it
    /// complies.
    fn decide(&mut self, agent: u16, is_in_way: bool) -> bool {
        self.is_decided[usize::from(agent)] = true;
        let from = self.at[usize::from(agent)];
        for choice in self.choices(agent, is_in_way) {
            self.work += 1;
            let Some(way) = choice else {
                return true;
            };
            if self.clear(agent, from, way) {
                let to = self.problem.ways[usize::from(from)][usize::from(way)].to;
                self.occupants[usize::from(from)] = NO_AGENT;
                self.occupants[usize::from(to)] = agent;
                self.at[usize::from(agent)] = to;
                self.hops.push(Hop { agent, from, way });
                return true;
            }
        }
        false
    }

    /// Has others leave that are in the way of an agent. Returns whether the way is free then.
    fn clear(&mut self, agent: u16, from: u16, way: u16) -> bool {
        let problem = self.problem;
        let wanted = &problem.ways[usize::from(from)][usize::from(way)];
        if self.pending.iter().any(|pending| pending.is_blocked_by(wanted.to)) {
            return false;
        }
        self.pending.push(wanted);
        let is_free = wanted.blocked_by.iter().all(|&stand| {
            let other = self.occupants[usize::from(stand)];
            other == NO_AGENT
                || other == agent
                || (!self.is_decided[usize::from(other)] && self.decide(other, true))
        });
        self.pending.pop();
        is_free
            && wanted.blocked_by.iter().all(|&stand| {
                let occupant = self.occupants[usize::from(stand)];
                occupant == NO_AGENT || occupant == agent
            })
    }

    /// The choices of an agent, best first.
    fn choices(&self, agent: u16, is_in_way: bool) -> Vec<Choice> {
        let (secs, from) = (&self.secs[usize::from(agent)], self.at[usize::from(agent)]);
        if let Some(choice) = self.bound[usize::from(agent)] {
            return if is_in_way && choice.is_none() { Vec::new() } else { vec![choice] };
        }
        let is_free = secs.is_empty();
        if is_free && !is_in_way {
            return vec![None];
        }
        let mut choices: Vec<(Wish, Choice)> = Vec::new();
        if !is_in_way {
            choices.push((Wish { class: 1, ..Wish::default() }, None));
        }
        for (index, way) in (0..).zip(&self.problem.ways[usize::from(from)]) {
            let others = way
                .blocked_by
                .iter()
                .filter(|&&stand| self.occupants[usize::from(stand)] != NO_AGENT)
                .count();
            let tie = mix(self.salt ^ u64::from(agent) << 32 ^ u64::from(way.to) << 16);
            // Without a target, it goes where it pushes the fewest.
            let to_go = to_go(secs, way.to);
            let is_farther = to_go >= self::to_go(secs, from);
            let class = if is_free { 2 + others } else { 2 * usize::from(is_farther) };
            let secs = way.secs + to_go;
            if secs.is_finite() {
                choices.push((Wish { class, secs, others, tie }, Some(index)));
            }
        }
        choices.sort_by(|(a, _), (b, _)| a.order(b));
        choices.into_iter().map(|(_, choice)| choice).collect()
    }
}

/// The seconds from a stand to the target; 0 without a target.
pub(super) fn to_go(secs: &[f32], stand: u16) -> f32 {
    secs.get(usize::from(stand)).copied().unwrap_or(0.0)
}

/// The cost of a choice, compared lexicographically.
#[derive(Clone, Copy, Debug, Default)]
struct Wish {
    /// Nearer to the target comes before staying, and that before all other ways.
    class: usize,
    /// Seconds to the target.
    secs: f32,
    /// Others in the way.
    others: usize,
    /// Makes an order of equal ones, another one in each step.
    tie: u64,
}

impl Wish {
    fn order(&self, other: &Self) -> std::cmp::Ordering {
        let by_secs = self.class.cmp(&other.class).then(self.secs.total_cmp(&other.secs));
        by_secs.then(self.others.cmp(&other.others)).then(self.tie.cmp(&other.tie))
    }
}
