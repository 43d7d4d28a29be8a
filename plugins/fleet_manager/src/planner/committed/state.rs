//! States of the traffic, and whether all robots can come to rest from there.
//!
//! A state is *completable* if the robots can drive to the ends of their committed ways one at a
//! time, each past the others as they stand. That is the Banker's algorithm: E. Dijkstra, 1965; for
//! vehicles on guidepaths, S. Reveliotis: Conflict resolution in AGV systems, 2000. A standstill
//! can't come about while every state is completable.

use super::blocks::{Blocks, EndId, Key, blocks_rest, disc_key, key_count};
use super::keys_of;
use crate::claims::Stretch;
use crate::roads::{Leg, Roads};

/// The largest number of orders in which robots are tried to drive in steps.
const MOST_ORDERS: usize = 8;
/// The number of legs looked at from which on no other order is tried.
const MOST_WORK: u64 = 20_000;

/// A robot in a state.
#[derive(Debug)]
struct Member {
    robot: u32,
    footprint: usize,
    turns: bool,
    /// All that it blocks at its first place, in ascending order.
    first_blocked: Vec<Key>,
    /// The legs of its committed way behind the leg that it is on at first; `None` if it has none,
    /// and stays.
    way: Option<Vec<Leg>>,
    at: At,
    /// The key that another robot blocked when it was last found that this one can't drive to its
    /// end from here: it can't as long as that is so.
    obstacle: Option<Key>,
    /// All that it needs for the rest of its way, once each, in ascending order.
    needs: Vec<Key>,
    /// The number of legs that were driven when `needs` was computed; `None` if it wasn't.
    needs_after: Option<usize>,
}

/// The place of a robot in a state: it stands there until it drives on.
#[derive(Clone, Copy, Debug, PartialEq)]
struct At {
    place: Stretch,
    /// The legs of its way that it has driven.
    driven: usize,
    /// The end of the leg at which it stands; `None` at its first place.
    end: Option<EndId>,
}

/// The places of all robots, and their ways.
#[derive(Debug)]
pub struct State {
    members: Vec<Member>,
    /// By key: how many robots block it.
    counts: Vec<u16>,
    /// By key: how many robots need it for their ways.
    needed: Vec<u16>,
    /// By leg: how many robots are to drive it.
    ahead: Vec<u16>,
    /// The legs and nodes looked at so far: a measure of the time spent.
    work: u64,
}

/// The attempts to complete a state: whether the first robot leads, and the preference.
const ATTEMPTS: [(bool, Preference); 4] = [
    (true, Preference::InOrder),
    (true, Preference::OutOfWay),
    (false, Preference::InOrder),
    (false, Preference::OutOfWay),
];

/// The robots that drive to their ends first.
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
        let (members, ahead) = (Vec::new(), vec![0; 2 * roads.edges().len()]);
        Self { members, counts: vec![0; keys], needed: vec![0; keys], ahead, work: 0 }
    }

    /// The legs and nodes that were looked at so far: a measure of the time spent.
    pub fn work(&self) -> u64 {
        self.work
    }

    /// Takes all robots away.
    pub fn clear(&mut self, blocks: &Blocks) {
        for member in self.members.drain(..) {
            for &key in member.blocked(blocks) {
                self.counts[key as usize] -= 1;
            }
            for leg in member.ahead() {
                self.ahead[leg.index()] -= 1;
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
        way: Option<Vec<Leg>>,
    ) {
        let first_blocked = blocks.of(roads, footprint, &place);
        for &key in &first_blocked {
            self.counts[key as usize] += 1;
        }
        for leg in way.iter().flatten() {
            self.ahead[leg.index()] += 1;
        }
        let at = At { place, driven: 0, end: None };
        let (needs, needs_after) = (Vec::new(), None);
        self.members.push(Member {
            robot,
            footprint,
            turns,
            first_blocked,
            way,
            at,
            obstacle: None,
            needs,
            needs_after,
        });
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
        let before = self.places();
        let mut stuck = Vec::new();
        for (leads, preference) in ATTEMPTS {
            if leads && position.is_none() {
                continue;
            }
            self.restore(blocks, &before);
            stuck = self.complete_by(roads, blocks, open.clone(), leads, preference);
            if stuck.is_empty() {
                break;
            }
        }
        stuck
    }

    fn places(&self) -> Vec<At> {
        self.members.iter().map(|member| member.at).collect()
    }

    /// Puts the robots back to where they were.
    fn restore(&mut self, blocks: &Blocks, places: &[At]) {
        for (index, at) in places.iter().enumerate() {
            if self.members[index].at != *at {
                self.put(blocks, index, *at);
            }
        }
    }

    /// Puts a robot at a place.
    fn put(&mut self, blocks: &Blocks, index: usize, at: At) {
        let member = &mut self.members[index];
        for &key in member.blocked(blocks) {
            self.counts[key as usize] -= 1;
        }
        for leg in member.ahead() {
            self.ahead[leg.index()] -= 1;
        }
        member.at = at;
        member.obstacle = None;
        for &key in member.blocked(blocks) {
            self.counts[key as usize] += 1;
        }
        for leg in member.ahead() {
            self.ahead[leg.index()] += 1;
        }
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
        if preference == Preference::OutOfWay {
            self.count_needed(roads, &open);
        }
        self.complete_ways(roads, blocks, &mut open, preference);
        if leads || open.is_empty() {
            return self.robots(&open);
        }
        let (before, until) = (self.places(), self.work + MOST_WORK);
        let mut stuck = self.complete_in_steps(roads, blocks, open.clone(), preference);
        for _ in 1..open.len().min(MOST_ORDERS) {
            if stuck.is_empty() || self.work > until {
                break;
            }
            open.rotate_left(1);
            self.restore(blocks, &before);
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
        if preference == Preference::OutOfWay {
            self.count_needed(roads, &open);
        }
        while let Some(index) = self.step(roads, blocks, &open) {
            if preference == Preference::OutOfWay {
                self.forget_needs(index);
                self.add_needs(roads, index);
            }
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
            let found = in_way.position(|&index| self.drive_way(roads, blocks, index));
            let Some(position) = found else { return };
            self.forget_needs(open.remove(position));
        }
    }

    /// Puts a robot at its end if it can drive there past the others, and is to do so by a
    /// preference. Returns whether it is.
    fn complete_way(
        &mut self,
        roads: &Roads,
        blocks: &mut Blocks,
        index: usize,
        preference: Preference,
    ) -> bool {
        if preference == Preference::InOrder {
            return self.drive_way(roads, blocks, index);
        }
        if self.is_end_needed(roads, blocks, index) || !self.drive_way(roads, blocks, index) {
            return false;
        }
        self.forget_needs(index);
        true
    }

    /// Puts a robot at its end if it can drive there past the others. Returns whether it can.
    fn drive_way(&mut self, roads: &Roads, blocks: &mut Blocks, index: usize) -> bool {
        let count = self.members[index].ahead().len();
        let is_free = self.is_free(roads, blocks, index);
        if is_free {
            self.drive(roads, blocks, index, count);
        }
        is_free
    }

    /// Counts the robots whose ways need each key.
    fn count_needed(&mut self, roads: &Roads, open: &[usize]) {
        self.needed.fill(0);
        for &index in open {
            self.add_needs(roads, index);
        }
    }

    /// Counts what a robot needs for the rest of its way.
    fn add_needs(&mut self, roads: &Roads, index: usize) {
        let member = &mut self.members[index];
        if member.needs_after != Some(member.at.driven) {
            member.needs = keys_ahead(roads, member.ahead());
            member.needs_after = Some(member.at.driven);
            self.work += member.needs.len() as u64;
        }
        for &key in &member.needs {
            self.needed[key as usize] += 1;
        }
    }

    /// A robot that has come to its end needs nothing that was counted for it.
    fn forget_needs(&mut self, index: usize) {
        for &key in &self.members[index].needs {
            self.needed[key as usize] -= 1;
        }
    }

    /// Whether a robot at the end of its way stands in that of another one.
    fn is_end_needed(&self, roads: &Roads, blocks: &mut Blocks, index: usize) -> bool {
        let member = &self.members[index];
        let Some(&last) = member.ahead().last() else { return false };
        blocks.at_end(roads, member.footprint, last).iter().any(|key| {
            let needs = u16::from(member.needs.binary_search(key).is_ok());
            self.needed[*key as usize] > needs
        })
    }

    /// Lets the first robot that can drive on to where none of the others is to come towards it.
    /// Returns its index, if one could.
    fn step(&mut self, roads: &Roads, blocks: &mut Blocks, open: &[usize]) -> Option<usize> {
        for &index in open {
            if let Some(count) = self.free_and_unopposed(roads, blocks, index) {
                self.drive(roads, blocks, index, count);
                return Some(index);
            }
        }
        None
    }

    /// Returns the number of legs that a robot can drive past the others to where none is to come
    /// towards it; `None` if it can't come so far.
    fn free_and_unopposed(
        &mut self,
        roads: &Roads,
        blocks: &Blocks,
        index: usize,
    ) -> Option<usize> {
        let member = &self.members[index];
        // A robot on a leg may stop at its end; another one has to drive at least one leg.
        let least = usize::from(!member.is_on_leg(roads));
        let mut before = member.at.place.leg;
        for (count, &leg) in member.ahead().iter().enumerate() {
            self.work += 1;
            if count >= least && !self.is_opposed(roads, leg) {
                return self.is_rest_free(roads, blocks, index).then_some(count);
            }
            if self.obstacle(roads, blocks, member, before, leg).is_some() {
                return None;
            }
            before = Some(leg);
        }
        None
    }

    /// Whether a robot is to drive back along a leg.
    fn is_opposed(&self, roads: &Roads, leg: Leg) -> bool {
        let (start, end) = (roads.start(leg), roads.end(leg));
        let mut back = roads.exits(end).iter().filter(|&&leg| roads.end(leg) == start);
        back.any(|leg| self.ahead[leg.index()] > 0)
    }

    /// Whether no other robot stands on a robot's way, nor on the leg before.
    fn is_free(&mut self, roads: &Roads, blocks: &Blocks, index: usize) -> bool {
        let member = &self.members[index];
        if member.obstacle.is_some_and(|key| !self.is_free_for(blocks, member, key)) {
            self.work += 1;
            return false;
        }
        let mut before = member.at.place.leg;
        for &leg in member.ahead() {
            self.work += 1;
            if let Some(key) = self.obstacle(roads, blocks, member, before, leg) {
                self.members[index].obstacle = Some(key);
                return false;
            }
            before = Some(leg);
        }
        self.is_rest_free(roads, blocks, index)
    }

    /// Returns a key that another robot blocks where a robot drives from one leg along the next.
    fn obstacle(
        &self,
        roads: &Roads,
        blocks: &Blocks,
        member: &Member,
        before: Option<Leg>,
        leg: Leg,
    ) -> Option<Key> {
        let key = leg.index() as Key;
        if !self.is_free_for(blocks, member, key) {
            return Some(key);
        }
        let turns = before.is_some_and(|before| member.turns && roads.is_turn(before, leg));
        let disc = disc_key(roads, roads.start(leg));
        (turns && !self.is_free_for(blocks, member, disc)).then_some(disc)
    }

    /// Whether no other robot than this one blocks a key.
    fn is_free_for(&self, blocks: &Blocks, member: &Member, key: Key) -> bool {
        match self.counts[key as usize] {
            0 => true,
            1 => member.blocked(blocks).binary_search(&key).is_ok(),
            _ => false,
        }
    }

    /// Whether no other robot stands on the rest of the leg that a robot is on.
    fn is_rest_free(&self, roads: &Roads, blocks: &Blocks, index: usize) -> bool {
        let member = &self.members[index];
        let Some(leg) = member.at.place.leg else { return true };
        let from = member.at.place.to;
        if from >= roads.edge(leg.edge()).length || self.counts[leg.index()] <= 1 {
            return true;
        }
        let mut others = self.members.iter().filter(|other| other.robot != member.robot);
        !others.any(|other| {
            other.blocked(blocks).binary_search(&(leg.index() as Key)).is_ok()
                && blocks_rest(
                    roads,
                    (member.footprint, leg, from),
                    (other.footprint, &other.at.place),
                )
        })
    }

    /// Lets a robot drive along the next legs of its way.
    fn drive(&mut self, roads: &Roads, blocks: &mut Blocks, index: usize, count: usize) {
        let member = &self.members[index];
        let driven = member.at.driven + count;
        let legs = member.ahead()[..count].last().copied();
        let Some(last) = legs.or(member.at.place.leg) else { return };
        let end = Some(blocks.end(roads, member.footprint, last));
        let place = Stretch::at(last, roads.edge(last.edge()).length);
        self.put(blocks, index, At { place, driven, end });
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
    /// The rest of its way.
    fn ahead(&self) -> &[Leg] {
        self.way.as_ref().map_or(&[], |way| &way[self.at.driven..])
    }

    /// All that it blocks where it is, in ascending order.
    fn blocked<'a>(&'a self, blocks: &'a Blocks) -> &'a [Key] {
        self.at.end.map_or(&self.first_blocked, |end| blocks.at(end))
    }

    fn is_at_end(&self, roads: &Roads) -> bool {
        self.way.is_none() || (self.ahead().is_empty() && !self.is_on_leg(roads))
    }

    /// Whether it stands on a leg, and not at its end.
    fn is_on_leg(&self, roads: &Roads) -> bool {
        let Stretch { leg, to, .. } = self.at.place;
        leg.is_some_and(|leg| to < roads.edge(leg.edge()).length)
    }
}
