//! Executes a solution: robots drive in its order, however long each takes.
//!
//! If two moves touch the same roads, the later one is commanded only when the earlier robot has
//! been granted all of its moves. So each robot waits only for robots that already drive, and no
//! deadlock can follow.

use std::collections::BTreeMap;

use super::lacam::Hop;
use super::region::Region;
use super::standing::{Extent, extent, is_movable};
use super::ways::{Stand, stretches};
use crate::planner::Plans;
use crate::roads::{Leg, Roads};
use crate::traffic::Traffic;

/// A move of a robot from a stand to the next.
#[derive(Debug)]
struct Move {
    from: Stand,
    legs: Vec<Leg>,
    to: Leg,
    /// Moves of others that have to be granted before.
    after: Vec<u32>,
    is_granted: bool,
    /// Tracks where others would be in the way, in ascending order.
    near: Vec<u32>,
}

/// A robot that is led.
#[derive(Debug)]
struct Led {
    robot: u32,
    /// Its moves, and how many of them are granted.
    moves: Vec<u32>,
    granted: usize,
    /// Its claim when it was last seen.
    extent: Extent,
}

/// A solution that is executed.
#[derive(Debug)]
pub struct Course {
    moves: Vec<Move>,
    led: Vec<Led>,
    /// When a robot last moved, in simulated seconds.
    moved: f64,
}

impl Course {
    /// Begins to execute hops of a region's members.
    pub fn new(traffic: &Traffic<'_>, region: &Region, hops: &[Hop]) -> Self {
        let mut led = Vec::with_capacity(region.members.len());
        for &robot in &region.members {
            let extent = extent(traffic, robot);
            led.push(Led { robot, moves: Vec::new(), granted: 0, extent });
        }
        // By track: the moves that it is near to, and their agents.
        let mut near_moves: BTreeMap<u32, Vec<(u32, u16)>> = BTreeMap::new();
        let (mut moves, mut at) = (Vec::new(), region.starts.clone());
        for (number, hop) in (0..).zip(hops) {
            let path = &region.paths[usize::from(hop.from)][usize::from(hop.way)];
            let from = std::mem::replace(
                &mut at[usize::from(hop.agent)],
                Stand::at_end(traffic.roads, path.to),
            );
            let tracks = tracks(traffic.roads, from, &path.legs);
            let before = tracks.iter().filter_map(|track| near_moves.get(track)).flatten();
            let mut after: Vec<u32> =
                before.filter(|(_, agent)| *agent != hop.agent).map(|(other, _)| *other).collect();
            after.sort_unstable();
            after.dedup();
            let near = traffic.roads.conflicts().near(&tracks);
            for track in &near {
                near_moves.entry(*track).or_default().push((number, hop.agent));
            }
            led[usize::from(hop.agent)].moves.push(number);
            moves.push(Move {
                from,
                legs: path.legs.clone(),
                to: path.to,
                after,
                is_granted: false,
                near,
            });
        }
        Self { moves, led, moved: traffic.now }
    }

    /// The robots that are led.
    pub fn robots(&self) -> impl Iterator<Item = u32> + '_ {
        self.led.iter().map(|led| led.robot)
    }

    /// Whether all have come to their ends.
    pub fn is_over(&self) -> bool {
        self.led.is_empty()
    }

    /// When a robot last moved, in simulated seconds.
    pub fn moved(&self) -> f64 {
        self.moved
    }

    /// Marks the tracks on which others would be in the way of moves to come.
    pub fn mark(&self, kept: &mut [bool]) {
        for step in self.moves.iter().filter(|step| !step.is_granted) {
            for &track in &step.near {
                kept[track as usize] = true;
            }
        }
    }

    /// Updates the granted moves. Returns the robots that have come to their ends; `None` if one
    /// has left its course.
    pub fn follow(&mut self, traffic: &Traffic<'_>) -> Option<Vec<u32>> {
        for led in &mut self.led {
            let stand = Stand::of(traffic, led.robot)?;
            let state =
                traffic.robot(led.robot).filter(|state| is_movable(state) || state.is_pinned())?;
            let extent = extent(traffic, led.robot);
            if extent != led.extent {
                (led.extent, self.moved) = (extent, traffic.now);
            }
            if let Some(&number) = led.moves.get(led.granted) {
                let step = &mut self.moves[number as usize];
                let is_whole = stand.leg == step.to && stand.is_at_end(traffic.roads);
                if is_whole
                    && (state.horizon.is_empty() || state.goal().is_none())
                    && stand != step.from
                {
                    step.is_granted = true;
                    led.granted += 1;
                } else {
                    step.rest(stand.leg)?;
                }
            }
        }
        let done = self.led.iter().filter(|led| led.is_done()).map(|led| led.robot).collect();
        self.led.retain(|led| !led.is_done());
        Some(done)
    }

    /// Gives robots the legs of their next moves, if it is their turn.
    pub fn command(&self, traffic: &Traffic<'_>, plans: &mut Plans) {
        for led in &self.led {
            let (Some(state), Some(stand)) =
                (traffic.robot(led.robot), Stand::of(traffic, led.robot))
            else {
                continue;
            };
            let Some(&number) = led.moves.get(led.granted) else { continue };
            let step = &self.moves[number as usize];
            let is_next = step.after.iter().all(|&other| self.moves[other as usize].is_granted);
            let legs = if is_next { step.rest(stand.leg).unwrap_or_default() } else { &[] };
            if state.is_pinned() {
                continue;
            }
            if state.goal().is_none() && is_next {
                let last = led.moves.last().map_or(step.to, |&last| self.moves[last as usize].to);
                plans.evicted.push((led.robot, traffic.roads.end(last)));
            }
            if (state.goal().is_none() && is_next)
                || state.needs_route()
                || !state.horizon.iter().eq(legs)
            {
                plans.route(led.robot, legs.to_vec());
            }
            let permit = plans.permit(led.robot);
            permit.is_admitted |= is_next;
            permit.is_frozen |= !is_next;
            permit.precedence = Some(FIRST + f64::from(number));
        }
    }
}

/// Robots that are led get their legs before others.
const FIRST: f64 = -1e12;

impl Led {
    fn is_done(&self) -> bool {
        self.granted == self.moves.len()
    }
}

impl Move {
    /// The legs that are left where a base ends on some leg; `None` if that isn't on the way.
    fn rest(&self, leg: Leg) -> Option<&[Leg]> {
        match self.legs.iter().position(|next| *next == leg) {
            Some(index) => Some(&self.legs[index + 1..]),
            None => (leg == self.from.leg).then_some(&self.legs),
        }
    }
}

/// Returns the tracks that a robot is on while it moves, in ascending order.
fn tracks(roads: &Roads, from: Stand, legs: &[Leg]) -> Vec<u32> {
    let mut tracks: Vec<u32> =
        stretches(roads, from, legs).iter().map(|stretch| stretch.track).collect();
    tracks.push(from.leg.edge());
    tracks.sort_unstable();
    tracks.dedup();
    tracks
}

impl Region {
    /// Marks the tracks on which others would be in the way of anything that members may do.
    pub fn mark(&self, roads: &Roads, kept: &mut [bool]) {
        let mut all: Vec<u32> = Vec::new();
        for (stand, paths) in self.stands.iter().zip(&self.paths) {
            all.extend(paths.iter().flat_map(|path| tracks(roads, *stand, &path.legs)));
            all.push(stand.leg.edge());
        }
        all.sort_unstable();
        all.dedup();
        for track in roads.conflicts().near(&all) {
            kept[track as usize] = true;
        }
    }
}
