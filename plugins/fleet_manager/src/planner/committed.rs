//! The planner `committed`: committed ways to rest places, for roads that are driven both ways.
//!
//! A *rest place* is a node where a robot may stand for any time: with robots on all of them, the
//! rest of the roads stays in one piece. Every robot that drives has a committed way: over its goal
//! to a rest place that no other robot's way ends at. A state of the traffic is *completable* if
//! the robots can drive to the ends of their ways one at a time, each past the others as they
//! stand. A base is extended only if the state stays completable, so that robots never come to
//! stand head-on, nor in a dead end behind each other.
//!
//! | module | |
//! |---|---|
//! | `blocks` | the legs that a standing robot blocks |
//! | `rests`, `lay_bys` | the places where robots may wait |
//! | `state` | whether the state of the traffic is completable |
//! | `scene` | what a search for a way has to respect |
//! | `commit`, `joint` | ways for one robot, and for several at the same time |
//! | `round` | who gets a way when, and who makes room |

mod blocks;
mod commit;
mod commitment;
mod joint;
mod lay_bys;
mod rests;
mod round;
mod scene;
mod state;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use self::blocks::{Blocks, Key, disc_key, key_count};
use self::commitment::Commitment;
use self::lay_bys::LayBys;
use self::rests::Rests;
use self::state::State;
use super::{DrivingTimes, Planner, Plans, Router};
use crate::claims::Stretch;
use crate::roads::{Leg, Roads};
use crate::traffic::{Robot, Traffic};

/// The planner.
#[derive(Debug)]
pub struct Committed {
    blocks: Blocks,
    rests: Rests,
    lay_bys: LayBys,
    router: Router,
    times: DrivingTimes,
    state: State,
    /// By robot.
    commitments: Vec<Option<Commitment>>,
    /// By robot that is in the way of one without a way: the nodes of that one's way.
    asked: BTreeMap<u32, Vec<u32>>,
    /// The robot that asked them: the one that was sent the longest ago.
    asks: Option<u32>,
    /// By robot that waits for a way to its goal: the keys of that way.
    wished: BTreeMap<u32, Vec<Key>>,
    /// By robot without an errand: since when, in simulated seconds.
    idle_since: BTreeMap<u32, f64>,
    /// By robot: when it was last tried to commit it to a way to its goal.
    tried: BTreeMap<u32, f64>,
    /// By key: how many committed ways lead over it.
    wanted: Vec<u16>,
    /// By robot whose base wasn't extended, as others couldn't come to rest then: the last refusal.
    refused: BTreeMap<u32, Refusal>,
    next_round: f64,
    counts: Counts,
}

/// A base isn't extended, as others couldn't come to rest then.
#[derive(Clone, Copy, Debug)]
struct Refusal {
    /// One of them.
    other: u32,
    /// The time from which on it is tried again, in simulated seconds.
    until: f64,
}

/// The number of legs that may be looked at for a refusal in each second until it is tried again.
const WORK_PER_SEC: f64 = 50e3;

/// Figures of the run.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    commitments: u64,
    detours: u64,
    refusals: u64,
    dropped: u64,
}

impl Committed {
    /// Makes the planner for some roads.
    pub fn new(roads: &Roads) -> Self {
        let mut blocks = Blocks::default();
        Self {
            rests: Rests::new(roads, &mut blocks),
            lay_bys: LayBys::new(roads, &mut blocks),
            blocks,
            router: Router::new(roads),
            times: DrivingTimes::default(),
            state: State::new(roads),
            commitments: Vec::new(),
            asked: BTreeMap::new(),
            asks: None,
            wished: BTreeMap::new(),
            idle_since: BTreeMap::new(),
            tried: BTreeMap::new(),
            wanted: vec![0; key_count(roads)],
            refused: BTreeMap::new(),
            next_round: 0.0,
            counts: Counts::default(),
        }
    }

    fn commitment(&self, robot: u32) -> Option<&Commitment> {
        self.commitments.get(robot as usize)?.as_ref()
    }

    /// Whether a robot is committed to drive on from the end of its base.
    fn goes_on(&self, traffic: &Traffic<'_>, robot: u32) -> bool {
        let (Some(commitment), Some(end)) = (self.commitment(robot), traffic.claims.end(robot))
        else {
            return false;
        };
        !commitment.way.is_empty() || end.to < traffic.roads.conflicts().length(end.track)
    }

    /// Brings the commitments up to date. Returns whether some can't be kept.
    fn follow(&mut self, traffic: &Traffic<'_>) -> bool {
        let before = self.counts.dropped;
        self.commitments.resize(traffic.robots.len(), None);
        for (robot, commitment) in (0..).zip(&mut self.commitments) {
            let Some(some) = commitment else { continue };
            let is_kept = match (traffic.robot(robot), traffic.base_end(robot)) {
                (Some(state), Some((last, node))) => {
                    let is_on = some.advance(last);
                    let next = some.way.first().map_or(some.end, |&leg| traffic.roads.start(leg));
                    let is_open = !some.way.iter().any(|&leg| traffic.is_closed(leg));
                    is_on && is_open && next == node && is_able(state)
                }
                _ => false,
            };
            if !is_kept {
                *commitment = None;
                self.counts.dropped += 1;
            }
        }
        self.counts.dropped > before
    }

    /// Counts the ways that lead over each key.
    fn count_wanted(&mut self, traffic: &Traffic<'_>) {
        self.wanted.fill(0);
        for (robot, _) in traffic.robots() {
            for key in self.keys_wanted(traffic, robot) {
                self.wanted[key as usize] += 1;
            }
        }
    }

    /// The keys that have to be free for a robot to drive to the end of its way.
    fn keys_wanted(&self, traffic: &Traffic<'_>, robot: u32) -> Vec<Key> {
        let (Some(commitment), Some(end)) = (self.commitment(robot), traffic.claims.end(robot))
        else {
            return Vec::new();
        };
        let is_on_leg = end.to < traffic.roads.conflicts().length(end.track);
        let rest = end.leg.filter(|_| is_on_leg).map(|leg| leg.index() as Key);
        let ahead = commitment.way.iter().flat_map(|&leg| keys_of(traffic.roads, leg));
        ahead.chain(rest).collect()
    }

    /// Whether the committed way of another robot leads over what a robot blocks at the end of its
    /// base.
    fn is_in_way(&mut self, traffic: &Traffic<'_>, robot: u32) -> bool {
        let (Some(state), Some(&end)) = (traffic.robot(robot), traffic.claims.end(robot)) else {
            return false;
        };
        let blocked = self.blocks.of(traffic.roads, state.class.footprint, &end);
        let own = self.keys_wanted(traffic, robot);
        blocked.iter().any(|&key| {
            let own = own.iter().filter(|wanted| **wanted == key).count();
            usize::from(self.wanted[key as usize]) > own
        })
    }

    /// Puts all robots into the state, with `change` in place of one robot's commitment: its place
    /// and the way from there.
    fn set_state(&mut self, traffic: &Traffic<'_>, change: Option<(u32, Stretch, &[Leg])>) {
        let Self { state, blocks, commitments, .. } = self;
        state.clear(blocks);
        for (robot, known) in traffic.robots() {
            let (Some(&end), Some((last, _))) =
                (traffic.claims.end(robot), traffic.base_end(robot))
            else {
                continue;
            };
            let commitment = commitments.get(robot as usize).and_then(Option::as_ref);
            let (place, ahead) = match change.filter(|(changed, ..)| *changed == robot) {
                Some((_, place, ahead)) => (place, Some(ahead)),
                None => (
                    Stretch { from: end.to, ..end },
                    commitment.and_then(|commitment| commitment.ahead(last)),
                ),
            };
            let class = (known.class.footprint, known.class.turns);
            state.add(traffic.roads, blocks, robot, class, place, ahead.map(<[Leg]>::to_vec));
        }
    }

    /// Drops the commitments of robots that can't come to rest any more, because others have come,
    /// broken down or lost their ways: they have to find other ways.
    fn drop_stuck(&mut self, traffic: &Traffic<'_>) {
        self.set_state(traffic, None);
        for robot in self.state.complete(traffic.roads, &mut self.blocks, None) {
            self.commitments[robot as usize] = None;
            self.counts.dropped += 1;
        }
    }

    /// Permits each robot with a way one leg in each cycle.
    fn permit(&self, traffic: &Traffic<'_>, plans: &mut Plans) {
        for (robot, _) in traffic.robots() {
            let has_way = self.commitment(robot).is_some();
            let permit = plans.permit(robot);
            permit.max_legs = 1;
            permit.follows = true;
            permit.is_admitted = true;
            permit.is_frozen = !has_way;
        }
    }
}

impl Planner for Committed {
    fn plan(&mut self, traffic: &Traffic<'_>, plans: &mut Plans) {
        self.times.begin();
        let are_lost = self.follow(traffic);
        if are_lost || traffic.now >= self.next_round {
            self.drop_stuck(traffic);
        }
        if traffic.now >= self.next_round {
            self.commit_lost(traffic, plans);
            self.settle(traffic, plans);
        }
        self.commit_all(traffic, plans);
        self.count_wanted(traffic);
        self.permit(traffic, plans);
    }

    fn guards_rings(&self) -> bool {
        false
    }

    fn objection(&mut self, traffic: &Traffic<'_>, robot: u32) -> Option<u32> {
        let refusal = self.refused.get(&robot).filter(|refusal| traffic.now < refusal.until);
        if let Some(refusal) = refusal {
            return Some(refusal.other);
        }
        if !self.is_in_way(traffic, robot) {
            return None;
        }
        self.set_state(traffic, None);
        let before = self.state.work();
        let stuck = self.state.complete(traffic.roads, &mut self.blocks, Some(robot));
        let other = stuck.iter().copied().find(|other| *other != robot);
        let other = other.or(stuck.first().copied())?;
        let until = traffic.now + (self.state.work() - before) as f64 / WORK_PER_SEC;
        self.refused.insert(robot, Refusal { other, until });
        self.counts.refusals += 1;
        Some(other)
    }

    fn counts(&self) -> Vec<(&'static str, u64)> {
        let Counts { commitments, detours, refusals, dropped } = self.counts;
        vec![
            ("commitments", commitments),
            ("detours", detours),
            ("refusals", refusals),
            ("dropped", dropped),
        ]
    }
}

/// Whether a robot can drive.
fn is_able(state: &Robot) -> bool {
    !state.is_adopted() && state.stuck_since.is_infinite()
}

/// The keys that a robot needs free to drive a leg: with the node where it may turn before.
fn keys_of(roads: &Roads, leg: Leg) -> [Key; 2] {
    [leg.index() as Key, disc_key(roads, roads.start(leg))]
}
