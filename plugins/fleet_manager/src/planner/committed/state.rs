//! States of the traffic, and whether all robots can come to rest from there.
//!
//! A state is *completable* if the robots can drive to the ends of their committed ways one at a
//! time, each past the others as they stand. That is the Banker's algorithm: E. Dijkstra, 1965; for
//! vehicles on guidepaths, S. Reveliotis: Conflict resolution in AGV systems, 2000. A standstill
//! can't come about while every state is completable.

use super::blocks::{Blocks, Key, blocks_rest, disc_key, key_count};
use super::keys_of;
use crate::claims::Stretch;
use crate::roads::{Leg, Roads};

/// The largest number of orders in which robots are tried to drive in steps.
const MOST_ORDERS: usize = 8;

/// A robot in a state.
#[derive(Clone, Debug)]
pub struct Member {
    /// The robot.
    pub robot: u32,
    footprint: usize,
    turns: bool,
    /// The end of its base: it stands there until it drives on.
    place: Stretch,
    /// All that it blocks there.
    blocked: Vec<Key>,
    /// The legs of its committed way behind the leg that it is on; `None` if it has none, and
    /// stays.
    ahead: Option<Vec<Leg>>,
    /// All that it needs for that way, once each, in ascending order; empty until it is computed.
    needs: Vec<Key>,
}

/// The places of all robots, and their ways.
#[derive(Debug)]
pub struct State {
    members: Vec<Member>,
    /// By key: how many robots block it.
    counts: Vec<u16>,
    /// By key: how many robots need it for their ways.
    needed: Vec<u16>,
}

/// The attempts to complete a state: whether the first robot leads, and the preference.
const ATTEMPTS: [(bool, Preference); 4] = [
    (true, Preference::InOrder),
    (true, Preference::OutOfWay),
    (false, Preference::InOrder),
    (false, Preference::OutOfWay),
];

/// Which robots drive to their ends first.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Preference {
    /// As they come.
    InOrder,
    /// Those that are in nobody's way there.
    OutOfWay,
}

impl State {
    /// Makes the state without robots.
    pub fn new(roads: &Roads) -> Self {
        let keys = key_count(roads);
        Self { members: Vec::new(), counts: vec![0; keys], needed: vec![0; keys] }
    }

    /// Takes all robots away.
    pub fn clear(&mut self) {
        for member in self.members.drain(..) {
            for key in member.blocked {
                self.counts[key as usize] -= 1;
            }
        }
    }

    /// Adds a robot of a footprint, that turns on the spot or doesn't, at a place; with the legs of
    /// its committed way behind the leg that it is on, if it has one.
    pub fn add(
        &mut self,
        roads: &Roads,
        blocks: &mut Blocks,
        robot: u32,
        (footprint, turns): (usize, bool),
        place: Stretch,
        ahead: Option<Vec<Leg>>,
    ) {
        let blocked = blocks.of(roads, footprint, &place);
        for &key in &blocked {
            self.counts[key as usize] += 1;
        }
        let needs = Vec::new();
        self.members.push(Member { robot, footprint, turns, place, blocked, ahead, needs });
    }

    /// Lets the robots drive to their ends, one at a time. Returns those that can't, in ascending
    /// order: none if the state is completable. Afterwards each robot is where it came to.
    ///
    /// If none can drive all of its way, one of them drives on to where none of the others is to
    /// come towards it. Only some orders are tried: a state may be completable all the same. A
    /// robot that has driven a part of its way or of a step is to be the `first`, so that the order
    /// that was found before is found again.
    pub fn complete(&mut self, roads: &Roads, blocks: &mut Blocks, first: Option<u32>) -> Vec<u32> {
        let mut open: Vec<usize> = (0..self.members.len())
            .filter(|&index| !self.members[index].is_at_end(roads))
            .collect();
        let position = open.iter().position(|index| Some(self.members[*index].robot) == first);
        open.rotate_left(position.unwrap_or(0));
        let before = (self.members.clone(), self.counts.clone());
        let mut stuck = Vec::new();
        for (leads, preference) in ATTEMPTS {
            if leads && position.is_none() {
                continue;
            }
            self.members.clone_from(&before.0);
            self.counts.clone_from(&before.1);
            stuck = self.complete_by(roads, blocks, open.clone(), leads, preference);
            if stuck.is_empty() {
                break;
            }
        }
        stuck
    }

    /// Completes the state with a preference; if the first robot `leads`, it drives to its end
    /// before all others, and none drives in steps.
    fn complete_by(
        &mut self,
        roads: &Roads,
        blocks: &mut Blocks,
        mut open: Vec<usize>,
        leads: bool,
        preference: Preference,
    ) -> Vec<u32> {
        if leads {
            if !self.complete_way(roads, blocks, open[0], Preference::InOrder) {
                return vec![self.members[open[0]].robot];
            }
            open.remove(0);
        }
        self.complete_ways(roads, blocks, &mut open, preference);
        if leads || open.is_empty() {
            return self.robots(&open);
        }
        let (members, counts) = (self.members.clone(), self.counts.clone());
        let mut stuck = self.complete_in_steps(roads, blocks, open.clone(), preference);
        for _ in 1..open.len().min(MOST_ORDERS) {
            if stuck.is_empty() {
                break;
            }
            open.rotate_left(1);
            self.members.clone_from(&members);
            self.counts.clone_from(&counts);
            stuck = self.complete_in_steps(roads, blocks, open.clone(), preference);
        }
        stuck
    }

    /// The robots at some indices, in ascending order.
    fn robots(&self, open: &[usize]) -> Vec<u32> {
        let mut robots: Vec<u32> = open.iter().map(|&index| self.members[index].robot).collect();
        robots.sort_unstable();
        robots
    }

    /// Completes the state with robots that drive in steps where none can drive all of its way:
    /// the first ones first. Returns those that can't come to their ends, in ascending order.
    fn complete_in_steps(
        &mut self,
        roads: &Roads,
        blocks: &mut Blocks,
        mut open: Vec<usize>,
        preference: Preference,
    ) -> Vec<u32> {
        while !open.is_empty() && self.step(roads, blocks, &open) {
            self.complete_ways(roads, blocks, &mut open, preference);
        }
        self.robots(&open)
    }

    /// Puts all robots at their ends that can drive there past the others, again and again.
    fn complete_ways(
        &mut self,
        roads: &Roads,
        blocks: &mut Blocks,
        open: &mut Vec<usize>,
        preference: Preference,
    ) {
        if preference == Preference::OutOfWay {
            self.count_needed(roads, open);
        }
        while !open.is_empty() {
            let before = open.len();
            open.retain(|&index| !self.complete_way(roads, blocks, index, preference));
            if open.len() < before {
                continue;
            }
            if preference == Preference::InOrder {
                return;
            }
            let mut in_way = open.iter();
            let found = in_way
                .position(|&index| self.complete_way(roads, blocks, index, Preference::InOrder));
            let Some(position) = found else { return };
            open.remove(position);
        }
    }

    /// Puts a robot at its end if it can drive there past the others. Returns whether it can.
    fn complete_way(
        &mut self,
        roads: &Roads,
        blocks: &mut Blocks,
        index: usize,
        preference: Preference,
    ) -> bool {
        let ahead = self.members[index].ahead.as_deref().unwrap_or_default();
        let count = ahead.len();
        let is_free = self.is_free(roads, index, ahead);
        let stays = preference == Preference::OutOfWay;
        if !is_free || (stays && self.is_end_needed(roads, blocks, index)) {
            return false;
        }
        for &key in &self.members[index].needs {
            self.needed[key as usize] -= 1;
        }
        self.drive(roads, blocks, index, count);
        true
    }

    /// Counts the robots whose ways need each key.
    fn count_needed(&mut self, roads: &Roads, open: &[usize]) {
        self.needed.fill(0);
        for &index in open {
            let member = &mut self.members[index];
            if member.needs.is_empty() {
                member.needs = keys_ahead(roads, member.ahead.as_deref().unwrap_or_default());
            }
            for &key in &member.needs {
                self.needed[key as usize] += 1;
            }
        }
    }

    /// Whether a robot at the end of its way stands in that of another one.
    fn is_end_needed(&self, roads: &Roads, blocks: &mut Blocks, index: usize) -> bool {
        let member = &self.members[index];
        let Some(&last) = member.ahead.as_ref().and_then(|ahead| ahead.last()) else {
            return false;
        };
        blocks.at_end(roads, member.footprint, last).iter().any(|key| {
            let needs = u16::from(member.needs.binary_search(key).is_ok());
            self.needed[*key as usize] > needs
        })
    }

    /// Lets the first robot that can drive on to where none of the others is to come towards it.
    /// Returns whether one could.
    fn step(&mut self, roads: &Roads, blocks: &mut Blocks, open: &[usize]) -> bool {
        let mut is_driven = vec![false; 2 * roads.edges().len()];
        for &index in open {
            for leg in self.members[index].ahead.iter().flatten() {
                is_driven[leg.index()] = true;
            }
        }
        let is_opposed = |leg: &Leg| {
            let (start, end) = (roads.start(*leg), roads.end(*leg));
            let mut back = roads.exits(end).iter().filter(|&&leg| roads.end(leg) == start);
            back.any(|leg| is_driven[leg.index()])
        };
        for &index in open {
            let Some(ahead) = self.members[index].ahead.as_deref() else { continue };
            // A robot on a leg may stop at its end; another one has to drive at least one leg.
            let least = usize::from(!self.members[index].is_on_leg(roads));
            let after = ahead.iter().skip(least).position(|leg| !is_opposed(leg));
            let Some(count) = after.map(|count| count + least) else { continue };
            if self.is_free(roads, index, &ahead[..count]) {
                self.drive(roads, blocks, index, count);
                return true;
            }
        }
        false
    }

    /// Whether no other robot stands on these legs of a robot's way, nor on the leg before.
    fn is_free(&self, roads: &Roads, index: usize, legs: &[Leg]) -> bool {
        let member = &self.members[index];
        let is_free = |key: Key| match self.counts[key as usize] {
            0 => true,
            1 => member.blocked.binary_search(&key).is_ok(),
            _ => false,
        };
        let mut before = member.place.leg;
        for &leg in legs {
            let turn = before.filter(|&before| member.turns && roads.is_turn(before, leg));
            let turns_freely = turn.is_none() || is_free(disc_key(roads, roads.start(leg)));
            if !turns_freely || !is_free(leg.index() as Key) {
                return false;
            }
            before = Some(leg);
        }
        self.is_rest_free(roads, index)
    }

    /// Whether no other robot stands on the rest of the leg that a robot is on.
    fn is_rest_free(&self, roads: &Roads, index: usize) -> bool {
        let member = &self.members[index];
        let Some(leg) = member.place.leg else { return true };
        let from = member.place.to;
        if from >= roads.edge(leg.edge()).length || self.counts[leg.index()] <= 1 {
            return true;
        }
        let mut others = self.members.iter().filter(|other| other.robot != member.robot);
        !others.any(|other| {
            other.blocked.binary_search(&(leg.index() as Key)).is_ok()
                && blocks_rest(
                    roads,
                    (member.footprint, leg, from),
                    (other.footprint, &other.place),
                )
        })
    }

    /// Lets a robot drive along the next legs of its way.
    fn drive(&mut self, roads: &Roads, blocks: &mut Blocks, index: usize, count: usize) {
        let member = &mut self.members[index];
        let driven = member.ahead.as_mut().map(|ahead| ahead.drain(..count).next_back());
        let Some(last) = driven.flatten().or(member.place.leg) else { return };
        for &key in &member.blocked {
            self.counts[key as usize] -= 1;
        }
        member.needs.clear();
        member.place = Stretch::at(last, roads.edge(last.edge()).length);
        member.blocked = blocks.at_end(roads, member.footprint, last).to_vec();
        for &key in &member.blocked {
            self.counts[key as usize] += 1;
        }
    }
}

/// Returns the keys that a robot needs to drive along some legs, once each, in ascending order.
fn keys_ahead(roads: &Roads, ahead: &[Leg]) -> Vec<Key> {
    let mut keys: Vec<Key> = ahead.iter().flat_map(|&leg| keys_of(roads, leg)).collect();
    keys.sort_unstable();
    keys.dedup();
    keys
}

impl Member {
    fn is_at_end(&self, roads: &Roads) -> bool {
        let ahead = self.ahead.as_ref();
        ahead.is_none_or(|ahead| ahead.is_empty() && !self.is_on_leg(roads))
    }

    /// Whether it stands on a leg, and not at its end.
    fn is_on_leg(&self, roads: &Roads) -> bool {
        self.place.leg.is_some_and(|leg| self.place.to < roads.edge(leg.edge()).length)
    }
}
