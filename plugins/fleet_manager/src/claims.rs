//! Claims: the parts of the roads that are reserved for one robot each.
//!
//! A robot's claim reaches from where it was last seen to the end of its released base. The claims
//! of two robots never conflict, whatever the times at which they drive: so robots never touch. A
//! claim enters a zone only if the zone's rule allows it.

mod occupancy;

use std::collections::VecDeque;

use regatta_base::sweep::Span;

use self::occupancy::Occupancy;
use crate::roads::{Leg, RESOLUTION, Relation, Roads};

/// A stretch of a track that a robot claims, in driving order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// The edge, or the place of a node at which the robot turns on the spot.
    pub track: u32,
    /// The leg, of an edge.
    pub leg: Option<Leg>,
    /// Metres from where the leg is entered: the rear of the claim and its end.
    pub from: f32,
    /// Its end.
    pub to: f32,
}

impl Stretch {
    /// All of a leg.
    pub fn whole(roads: &Roads, leg: Leg) -> Self {
        let to = roads.edge(leg.edge()).length;
        Self { track: leg.edge(), leg: Some(leg), from: 0.0, to }
    }

    /// One place on a leg, in metres from where it is entered.
    pub fn at(leg: Leg, place: f32) -> Self {
        Self { track: leg.edge(), leg: Some(leg), from: place, to: place }
    }

    /// The place of a node at which a robot turns on the spot.
    pub fn disc(roads: &Roads, node: u32) -> Self {
        Self { track: roads.disc(node), leg: None, from: 0.0, to: 0.0 }
    }
}

/// The part of a track that a robot holds, in metres from the edge's origin.
#[derive(Clone, Copy, Debug)]
struct Holder {
    robot: u32,
    footprint: u16,
    span: Span,
}

/// The distance that a robot may drive on a leg, and the robot that limits it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Metres from where the leg is entered; less than where it wants to go on from if it must not
    /// go there at all.
    pub metres: f32,
    /// The robot that is in the way, if that is less than was asked for.
    pub blocker: Option<u32>,
}

/// All claims of a fleet.
#[derive(Debug)]
pub struct Claims {
    /// By track.
    holders: Vec<Vec<Holder>>,
    /// By robot.
    stretches: Vec<VecDeque<Stretch>>,
    footprints: Vec<u16>,
    /// By robot: how often its claim has changed.
    versions: Vec<u64>,
    occupancy: Occupancy,
    /// Whether conflicts are ignored.
    is_free: bool,
}

/// Two stretches that just meet don't conflict: positions are rounded to this, in metres.
const ROUNDING: f32 = 1e-3;

impl Claims {
    /// Makes the claims of a fleet without robots. Without `conflicts`, no claim limits another.
    pub fn new(roads: &Roads, conflicts: bool) -> Self {
        Self {
            holders: vec![Vec::new(); roads.conflicts().tracks()],
            occupancy: Occupancy::new(roads),
            is_free: !conflicts,
            stretches: Vec::new(),
            footprints: Vec::new(),
            versions: Vec::new(),
        }
    }

    /// The claim of a robot, in driving order; empty if it has none.
    pub fn of(&self, robot: u32) -> &VecDeque<Stretch> {
        const NONE: &VecDeque<Stretch> = &VecDeque::new();
        self.stretches.get(robot as usize).unwrap_or(NONE)
    }

    /// A number that changes whenever a robot's claim does.
    pub fn version(&self, robot: u32) -> u64 {
        self.versions.get(robot as usize).copied().unwrap_or(0)
    }

    /// The end of a robot's claim: where its base ends.
    pub fn end(&self, robot: u32) -> Option<&Stretch> {
        self.of(robot).back()
    }

    /// Whether a robot claims a part of a track.
    pub fn holds(&self, robot: u32, track: u32) -> bool {
        self.of(robot).iter().any(|stretch| stretch.track == track)
    }

    /// Returns another robot that claims a part of one of some tracks.
    pub fn occupant(&self, tracks: &[u32], robot: u32) -> Option<u32> {
        let holders = tracks
            .iter()
            .filter(|_| !self.is_free)
            .flat_map(|&track| &self.holders[track as usize]);
        holders.map(|holder| holder.robot).find(|&other| other != robot)
    }

    /// Gives a robot its first stretch, even if it conflicts with other claims: the robot is there
    /// already.
    pub fn seize(&mut self, roads: &Roads, robot: u32, footprint: usize, stretch: Stretch) {
        self.release(robot);
        let count = self.stretches.len().max(robot as usize + 1);
        self.stretches.resize_with(count, VecDeque::new);
        self.footprints.resize(count, 0);
        self.versions.resize(count, 0);
        self.footprints[robot as usize] = footprint as u16;
        self.push(roads, robot, stretch);
    }

    /// Gives back everything that a robot claims.
    pub fn release(&mut self, robot: u32) {
        while let Some(stretch) =
            self.stretches.get_mut(robot as usize).and_then(VecDeque::pop_back)
        {
            self.drop_holder(stretch.track, robot);
            for other in self.occupancy.leave(robot, stretch.track) {
                self.versions[other as usize] += 1;
            }
        }
    }

    /// Adds a stretch behind the end of a robot's claim; the part of the same track that it
    /// continues becomes longer.
    ///
    /// # Panics
    /// In builds with debug assertions: if it conflicts with another robot's claim.
    pub fn grant(&mut self, roads: &Roads, robot: u32, stretch: Stretch) {
        debug_assert!(
            self.conflicting(roads, robot, &stretch).is_none(),
            "robot {robot} gets {stretch:?}, which conflicts with robot {:?}",
            self.conflicting(roads, robot, &stretch)
        );
        let last = self.stretches[robot as usize].back().copied();
        match last {
            Some(last) if last.track == stretch.track && last.leg == stretch.leg => {
                let whole = Stretch { to: stretch.to, ..last };
                self.replace(roads, robot, self.stretches[robot as usize].len() - 1, whole);
            }
            _ => self.push(roads, robot, stretch),
        }
    }

    /// Gives back the part of a claim behind a robot that was seen on a leg, `place` metres from
    /// where the leg is entered. Returns `false` if the robot doesn't claim that place.
    pub fn advance(
        &mut self,
        roads: &Roads,
        robot: u32,
        track: u32,
        place: impl FnOnce(&Stretch) -> f32,
    ) -> bool {
        let Some(index) = self.of(robot).iter().position(|stretch| stretch.track == track) else {
            return false;
        };
        for _ in 0..index {
            if let Some(stretch) = self.stretches[robot as usize].pop_front() {
                self.drop_holder(stretch.track, robot);
                self.update_zones(roads, robot, stretch.track);
            }
        }
        let stretch = self.stretches[robot as usize][0];
        let place = place(&stretch);
        if place > stretch.to + 0.01 {
            return false;
        }
        if place > stretch.from {
            self.replace(roads, robot, 0, Stretch { from: place.min(stretch.to), ..stretch });
        }
        true
    }

    /// Moves the end of a robot's claim back to an earlier one: to the first `stretches` stretches,
    /// the last of which ends at `to`.
    pub fn roll_back(&mut self, roads: &Roads, robot: u32, stretches: usize, to: f32) {
        while self.of(robot).len() > stretches.max(1) {
            if let Some(stretch) = self.stretches[robot as usize].pop_back() {
                self.drop_holder(stretch.track, robot);
                self.update_zones(roads, robot, stretch.track);
            }
        }
        if let Some(last) = self.end(robot).copied() {
            self.replace(
                roads,
                robot,
                self.of(robot).len() - 1,
                Stretch { to: to.max(last.from), ..last },
            );
        }
    }

    /// Returns how far a robot may go on a track within a span, in metres from where the leg is
    /// entered.
    pub fn reach(
        &self,
        roads: &Roads,
        robot: u32,
        footprint: usize,
        track: u32,
        leg: Option<Leg>,
        span: Span,
    ) -> Reach {
        if self.is_free {
            return Reach { metres: span.high, blocker: None };
        }
        let mut reach = self.reach_past(roads, footprint, track, leg, span, |other| other != robot);
        let stretch = Stretch { track, leg, from: span.low, to: span.high };
        if let Some((metres, blocker)) = self.occupancy.limit(roads, robot, &stretch)
            && metres - ROUNDING < reach.metres
        {
            reach = Reach { metres: metres - ROUNDING, blocker: Some(blocker) };
        }
        reach
    }

    /// Whether a robot of any footprint that drives along all of a leg touches none of these
    /// robots' claims.
    pub fn lets_pass(&self, roads: &Roads, leg: Leg, robots: &[u32]) -> bool {
        let length = roads.edge(leg.edge()).length;
        (0..roads.footprints().len()).all(|footprint| {
            let reach = self.reach_past(
                roads,
                footprint,
                leg.edge(),
                Some(leg),
                Span::new(0.0, length),
                |other| robots.contains(&other),
            );
            reach.metres >= length
        })
    }

    /// The edges on which some robots may be in the way of others, in ascending order.
    pub fn tracks_near(&self, roads: &Roads, robots: &[u32]) -> Vec<u32> {
        let mut tracks: Vec<u32> = Vec::new();
        for stretch in robots.iter().flat_map(|&robot| self.of(robot)) {
            tracks.push(stretch.track);
            for own in 0..roads.footprints().len() {
                for other in 0..=own {
                    let near = roads.conflicts().of(own, other, stretch.track);
                    tracks.extend(near.map(|(track, _)| track));
                }
            }
        }
        tracks.retain(|track| (*track as usize) < roads.edges().len());
        tracks.sort_unstable();
        tracks.dedup();
        tracks
    }

    /// Returns how far a robot may go past the claims of other robots that count.
    fn reach_past(
        &self,
        roads: &Roads,
        footprint: usize,
        track: u32,
        leg: Option<Leg>,
        span: Span,
        counts: impl Fn(u32) -> bool + Copy,
    ) -> Reach {
        let mut reach = Reach { metres: span.high, blocker: None };
        self.each_limit(roads, footprint, (track, leg, span.low), counts, |metres, blocker| {
            if metres < reach.metres {
                reach = Reach { metres, blocker: Some(blocker) };
            }
        });
        reach
    }

    /// Returns the robots whose claims conflict with a stretch, if a robot with a footprint claimed
    /// it; in ascending order.
    pub(crate) fn in_way(&self, roads: &Roads, footprint: usize, stretch: &Stretch) -> Vec<u32> {
        let mut robots = Vec::new();
        self.each_limit(
            roads,
            footprint,
            (stretch.track, stretch.leg, stretch.from),
            |_| true,
            |metres, robot| {
                if metres < stretch.to {
                    robots.push(robot);
                }
            },
        );
        robots.sort_unstable();
        robots.dedup();
        robots
    }

    /// Calls `limit` with the metres that a robot may go on a track for each claim of another robot
    /// that counts, and that robot.
    fn each_limit(
        &self,
        roads: &Roads,
        footprint: usize,
        (track, leg, from): (u32, Option<Leg>, f32),
        counts: impl Fn(u32) -> bool + Copy,
        mut limit: impl FnMut(f32, u32),
    ) {
        let length = roads.conflicts().length(track);
        let view = View { length, reverse: leg.is_some_and(Leg::is_reverse), from };
        for holder in self.others(counts, track) {
            let separation =
                roads.conflicts().table(footprint, holder.footprint.into()).separation(track);
            limit(view.same_track(separation, holder), holder.robot);
        }
        for other in 0..roads.footprints().len() {
            for (track, relation) in roads.conflicts().of(footprint, other, track) {
                for holder in self
                    .others(counts, track)
                    .filter(|holder| usize::from(holder.footprint) == other)
                {
                    limit(
                        view.limit(relation, roads.conflicts().length(track), holder),
                        holder.robot,
                    );
                }
            }
        }
    }

    /// Returns a robot whose claim conflicts with a stretch.
    pub fn conflicting(&self, roads: &Roads, robot: u32, stretch: &Stretch) -> Option<u32> {
        let footprint = self.footprints.get(robot as usize).copied().unwrap_or(0);
        let span = Span::new(stretch.from, stretch.to);
        let reach = self.reach(roads, robot, footprint.into(), stretch.track, stretch.leg, span);
        reach.blocker.filter(|_| reach.metres < stretch.to)
    }

    fn others(&self, counts: impl Fn(u32) -> bool, track: u32) -> impl Iterator<Item = &Holder> {
        self.holders[track as usize].iter().filter(move |holder| counts(holder.robot))
    }

    fn drop_holder(&mut self, track: u32, robot: u32) {
        self.versions[robot as usize] += 1;
        self.holders[track as usize].retain(|holder| holder.robot != robot);
    }

    /// Brings the zones of a track up to date after a robot's claim has changed there. Who waits
    /// for a robot in a zone asks again when any robot has left it.
    fn update_zones(&mut self, roads: &Roads, robot: u32, track: u32) {
        let claim = &self.stretches[robot as usize];
        for other in self.occupancy.update(roads, robot, track, claim) {
            self.versions[other as usize] += 1;
        }
    }

    fn push(&mut self, roads: &Roads, robot: u32, stretch: Stretch) {
        self.versions[robot as usize] += 1;
        self.stretches[robot as usize].push_back(stretch);
        let holder = self.holder(roads, robot, &stretch);
        self.holders[stretch.track as usize].push(holder);
        self.update_zones(roads, robot, stretch.track);
    }

    fn replace(&mut self, roads: &Roads, robot: u32, index: usize, stretch: Stretch) {
        self.versions[robot as usize] += 1;
        self.stretches[robot as usize][index] = stretch;
        let holder = self.holder(roads, robot, &stretch);
        let held = self.holders[stretch.track as usize].iter_mut().find(|held| held.robot == robot);
        if let Some(held) = held {
            *held = holder;
        }
        self.update_zones(roads, robot, stretch.track);
    }

    fn holder(&self, roads: &Roads, robot: u32, stretch: &Stretch) -> Holder {
        let footprint = self.footprints[robot as usize];
        let mut span = Span::new(stretch.from, stretch.to);
        if stretch.leg.is_some_and(Leg::is_reverse) {
            span = span.reversed(roads.conflicts().length(stretch.track));
        }
        Holder { robot, footprint, span }
    }
}

/// A track as a robot sees it that is to drive on along it.
struct View {
    length: f32,
    reverse: bool,
    /// Metres from where the leg is entered.
    from: f32,
}

impl View {
    /// Returns the limit, in metres from where the leg is entered, that a holder on the same track
    /// sets.
    fn same_track(&self, separation: f32, holder: &Holder) -> f32 {
        let Span { low, high } = self.driven(holder.span);
        let needed = separation - ROUNDING;
        if low >= self.from + needed {
            low - separation
        } else if high + needed <= self.from {
            f32::INFINITY
        } else {
            f32::NEG_INFINITY
        }
    }

    /// Returns the limit that a holder on another track sets.
    fn limit(&self, relation: Relation, other_length: f32, holder: &Holder) -> f32 {
        match relation {
            Relation::Crossing { own, other } => {
                let own = self.driven(own);
                let is_apart = holder.span.high < other.low
                    || holder.span.low > other.high
                    || self.from > own.high;
                if is_apart { f32::INFINITY } else { own.low - ROUNDING }
            }
            // The robot ahead is on the other track: this one may come as near as `apart`.
            Relation::Into(apart) => {
                self.following(f32::NEG_INFINITY, self.length + holder.span.low - apart)
            }
            // A robot that follows this one keeps that distance. The rounding of the table doesn't
            // count against this robot.
            Relation::From(apart) => self
                .following(apart - RESOLUTION - (other_length - holder.span.high), f32::INFINITY),
        }
    }

    /// Returns the limit of a robot that has to stay within these places, in metres from the edge's
    /// origin.
    fn following(&self, lowest: f32, highest: f32) -> f32 {
        let (ahead, behind) = if self.reverse {
            (self.length - lowest, self.length - highest)
        } else {
            (highest, lowest)
        };
        if self.from + ROUNDING < behind { f32::NEG_INFINITY } else { ahead }
    }

    /// Returns a stretch of the edge as it is driven.
    fn driven(&self, span: Span) -> Span {
        if self.reverse { span.reversed(self.length) } else { span }
    }
}
