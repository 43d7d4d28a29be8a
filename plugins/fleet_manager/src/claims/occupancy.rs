//! The robots in zones. A robot is in a zone while a part of its claim is: where it stands or
//! drives, or may drive.

use std::collections::VecDeque;
use std::sync::Arc;

use regatta_base::sweep::Span;

use super::Stretch;
use crate::roads::{Roads, Rule, ZonePart, Zones};
use crate::traffic::LEAST;

/// A robot in a zone.
#[derive(Clone, Copy, Debug)]
struct Inside {
    robot: u32,
    /// The node at which it entered.
    entry: u32,
}

/// The robots in all zones of some roads.
#[derive(Debug)]
pub(super) struct Occupancy {
    zones: Arc<Zones>,
    /// By zone: in the order in which they entered.
    inside: Vec<Vec<Inside>>,
}

impl Occupancy {
    pub fn new(roads: &Roads) -> Self {
        let zones = Arc::clone(roads.zones());
        Self { inside: vec![Vec::new(); zones.len()], zones }
    }

    /// Brings the zones of a track up to date for a robot whose claim has changed there. Returns
    /// the robots in zones that it has left.
    pub fn update(
        &mut self,
        roads: &Roads,
        robot: u32,
        track: u32,
        claim: &VecDeque<Stretch>,
    ) -> Vec<u32> {
        let mut left_behind = Vec::new();
        for &ZonePart { zone, .. } in self.zones.parts(track) {
            let inside = &mut self.inside[zone as usize];
            let before = inside.iter().position(|inside| inside.robot == robot);
            let entry = claim.iter().find_map(|stretch| entry(roads, zone, stretch));
            match (before, entry) {
                (None, Some(entry)) => inside.push(Inside { robot, entry }),
                (Some(index), None) => {
                    inside.remove(index);
                    left_behind.extend(inside.iter().map(|inside| inside.robot));
                }
                (None, None) | (Some(_), Some(_)) => {}
            }
        }
        left_behind
    }

    /// Takes a robot that has lost its claim out of the zones of a track.
    pub fn leave(&mut self, robot: u32, track: u32) -> Vec<u32> {
        let mut left_behind = Vec::new();
        for &ZonePart { zone, .. } in self.zones.parts(track) {
            let inside = &mut self.inside[zone as usize];
            inside.retain(|inside| inside.robot != robot);
            left_behind.extend(inside.iter().map(|inside| inside.robot));
        }
        left_behind
    }

    /// Returns how far a robot may go along a stretch before it would enter a zone whose rule
    /// forbids that, in metres from where the leg is entered, and a robot in that zone.
    pub fn limit(&self, roads: &Roads, robot: u32, stretch: &Stretch) -> Option<(f32, u32)> {
        let parts = self.zones.parts(stretch.track).iter();
        let limits = parts.filter_map(|part| {
            let Span { low, high } = part.driven(roads, stretch.leg);
            let is_ahead = stretch.from <= high && stretch.to >= low;
            let blocker =
                is_ahead.then(|| self.blocker(part.zone, robot, entry_of(roads, part, stretch)));
            // A robot that waits for an edge stays at the node before it.
            Some((if low < LEAST { 0.0 } else { low }, blocker??))
        });
        limits.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Returns a robot that keeps another one out of a zone, which would enter at a node.
    fn blocker(&self, zone: u32, robot: u32, entry: u32) -> Option<u32> {
        let inside = &self.inside[zone as usize];
        if inside.iter().any(|inside| inside.robot == robot) {
            return None;
        }
        match self.zones.rule(zone) {
            Rule::Capacity(robots) if inside.len() < robots as usize => None,
            Rule::Capacity(_) => inside.first().map(|inside| inside.robot),
            Rule::SameDirection => {
                inside.iter().find(|inside| inside.entry != entry).map(|inside| inside.robot)
            }
        }
    }
}

/// Returns the node at which a robot enters a zone by a stretch of its claim; `None` if the stretch
/// isn't in it.
fn entry(roads: &Roads, zone: u32, stretch: &Stretch) -> Option<u32> {
    let part = roads.zones().parts(stretch.track).iter().find(|part| {
        let Span { low, high } = part.driven(roads, stretch.leg);
        part.zone == zone && stretch.from <= high && stretch.to >= low
    })?;
    Some(entry_of(roads, part, stretch))
}

/// Returns the node at which a stretch enters a part of a zone on its track.
fn entry_of(roads: &Roads, part: &ZonePart, stretch: &Stretch) -> u32 {
    match stretch.leg {
        Some(leg) if part.driven(roads, stretch.leg).low > LEAST => roads.end(leg),
        Some(leg) => roads.start(leg),
        None => stretch.track - roads.edges().len() as u32,
    }
}
