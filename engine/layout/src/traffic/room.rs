//! The largest number of robots that stand at some nodes without touching each other.
//!
//! That is a maximum independent set of the nodes that touch. Nodes whose touching nodes all touch
//! each other are taken at once, which is exact; the rest is searched, and bounded by a cover of
//! groups that touch each other where the search takes too long.

use std::collections::{BTreeSet, VecDeque};

use serde::Serialize;

use super::conflicts::Conflicts;

/// Whether a number is exact in the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Certainty {
    /// It is.
    Exact,
    /// It is a bound on the exact number.
    Bound,
}

/// A number of robots.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Count {
    /// The number, or an upper bound on it.
    pub robots: u32,
    /// The certainty of the number.
    pub certainty: Certainty,
}

impl Certainty {
    /// Returns the certainty of a number that follows from two numbers.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        self.max(other)
    }
}

impl Count {
    /// No robot.
    pub const NONE: Self = Self { robots: 0, certainty: Certainty::Exact };

    /// Returns the sum of two numbers.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        let certainty = self.certainty.and(other.certainty);
        Self { robots: self.robots + other.robots, certainty }
    }
}

/// The largest number of choices in a search.
const MOST_CHOICES: u32 = 2_000;
/// The largest number of nodes that are searched.
const MOST_SEARCHED: usize = 200;
/// The largest number of touching nodes that are tested against each other.
const MOST_TOUCHING: usize = 40;

/// Returns the largest number of robots that stand at some nodes without touching each other.
pub fn most_standing(conflicts: &Conflicts, nodes: &[u32]) -> Count {
    let mut left: BTreeSet<u32> = nodes.iter().copied().collect();
    let mut sum = Count::NONE;
    while let Some(&first) = left.first() {
        let group = take_group(conflicts, &mut left, first);
        sum = sum.plus(Search { conflicts, choices: 0 }.most(group));
    }
    sum
}

/// Returns the groups of nodes that touch each other directly or by way of others.
pub fn groups(conflicts: &Conflicts, nodes: &[u32]) -> Vec<Vec<u32>> {
    let mut left: BTreeSet<u32> = nodes.iter().copied().collect();
    let mut groups = Vec::new();
    while let Some(&first) = left.first() {
        groups.push(take_group(conflicts, &mut left, first).into_iter().collect());
    }
    groups
}

/// Takes a node out of a set, with all that it touches directly or by way of others.
fn take_group(conflicts: &Conflicts, left: &mut BTreeSet<u32>, first: u32) -> BTreeSet<u32> {
    left.remove(&first);
    let mut group = BTreeSet::from([first]);
    let mut open = vec![first];
    while let Some(node) = open.pop() {
        for &other in conflicts.touching(node) {
            if left.remove(&other) {
                group.insert(other);
                open.push(other);
            }
        }
    }
    group
}

struct Search<'a> {
    conflicts: &'a Conflicts,
    choices: u32,
}

impl Search<'_> {
    fn most(&mut self, mut left: BTreeSet<u32>) -> Count {
        let taken = self.take_simple(&mut left);
        let taken = Count { robots: taken, certainty: Certainty::Exact };
        self.choices += 1;
        if self.choices > MOST_CHOICES || left.len() > MOST_SEARCHED {
            let robots = self.cover(left);
            return taken.plus(Count { robots, certainty: Certainty::Bound });
        }
        let degrees = left.iter().map(|&node| (self.touching(&left, node).len(), node));
        let Some((_, node)) = degrees.max() else { return taken };
        let mut with = left.clone();
        self.take(&mut with, node);
        left.remove(&node);
        let with = self.most(with).plus(Count { robots: 1, ..Count::NONE });
        let without = self.most(left);
        let certainty = with.certainty.and(without.certainty);
        taken.plus(Count { robots: with.robots.max(without.robots), certainty })
    }

    /// Takes nodes, one after the other, whose touching nodes all touch each other. Returns how
    /// many.
    fn take_simple(&self, left: &mut BTreeSet<u32>) -> u32 {
        let mut taken = 0;
        let mut open: VecDeque<u32> = left.iter().copied().collect();
        while let Some(node) = open.pop_front() {
            if left.contains(&node) && self.is_simple(left, node) {
                taken += 1;
                open.extend(self.take(left, node));
            }
        }
        taken
    }

    /// Removes a node and all that touch it. Returns the nodes left that touch one of these.
    fn take(&self, left: &mut BTreeSet<u32>, node: u32) -> Vec<u32> {
        let removed = self.touching(left, node);
        left.remove(&node);
        for other in &removed {
            left.remove(other);
        }
        removed.iter().flat_map(|&other| self.touching(left, other)).collect()
    }

    fn is_simple(&self, left: &BTreeSet<u32>, node: u32) -> bool {
        let touching = self.touching(left, node);
        let mut pairs = touching
            .iter()
            .enumerate()
            .flat_map(|(index, a)| touching[index + 1..].iter().map(move |b| (*a, *b)));
        touching.len() <= MOST_TOUCHING && pairs.all(|(a, b)| self.conflicts.is_touching(a, b))
    }

    fn touching(&self, left: &BTreeSet<u32>, node: u32) -> Vec<u32> {
        let touching = self.conflicts.touching(node).iter().copied();
        touching.filter(|other| left.contains(other)).collect()
    }

    /// Covers nodes with groups in which all touch each other: no more robots than groups stand
    /// there.
    fn cover(&self, mut left: BTreeSet<u32>) -> u32 {
        let mut groups = 0;
        while let Some(first) = left.pop_first() {
            groups += 1;
            let mut group = vec![first];
            for other in self.touching(&left, first) {
                if group.iter().all(|&member| self.conflicts.is_touching(member, other)) {
                    left.remove(&other);
                    group.push(other);
                }
            }
        }
        groups
    }
}
