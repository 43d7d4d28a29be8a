//! Regions that are helped, and the legs that others may drive outside of them.

use super::course::Course;
use super::lacam::Search;
use super::region::{Region, Size};
use super::ways::Stand;
use crate::roads::Leg;
use crate::traffic::Traffic;

/// A region that is helped.
#[derive(Debug)]
pub struct Case {
    /// The robots that stood.
    pub seeds: Vec<u32>,
    pub size: Size,
    pub is_enlarged: bool,
    pub region: Region,
    pub phase: Phase,
}

#[derive(Debug)]
pub enum Phase {
    /// A solution is searched, with the targets of so many members.
    Search(Box<Search>, usize),
    Drive(Course),
    /// All are released.
    Over,
}

impl Case {
    /// The robots that are led.
    pub fn robots(&self) -> Box<dyn Iterator<Item = u32> + '_> {
        match &self.phase {
            Phase::Search(..) => Box::new(self.region.members.iter().copied()),
            Phase::Drive(course) => Box::new(course.robots()),
            Phase::Over => Box::new(std::iter::empty()),
        }
    }

    /// Marks the tracks on which others would be in the way.
    pub fn mark(&self, traffic: &Traffic<'_>, kept: &mut [bool]) {
        match &self.phase {
            Phase::Search(..) => self.region.mark(traffic.roads, kept),
            Phase::Drive(course) => course.mark(kept),
            Phase::Over => {}
        }
    }

    /// The tracks on which others would be in the way: by track.
    pub fn kept(&self, traffic: &Traffic<'_>) -> Vec<bool> {
        let mut kept = vec![false; traffic.roads.conflicts().tracks()];
        self.mark(traffic, &mut kept);
        kept
    }
}

/// Returns the number of legs that a robot may drive without coming to kept tracks, up to the last
/// stand before them; `Some(None)` if it must stay, `None` if it comes to no kept track.
pub fn legs_outside(
    traffic: &Traffic<'_>,
    robot: u32,
    legs: &[Leg],
    kept: &[bool],
) -> Option<Option<usize>> {
    let roads = traffic.roads;
    let stand = Stand::of(traffic, robot)?;
    if kept[stand.leg.edge() as usize] && !stand.is_at_end(roads) {
        return Some(None);
    }
    let first = legs.iter().position(|leg| {
        kept[leg.edge() as usize] || kept[roads.disc(roads.start(*leg)) as usize]
    })?;
    let last = (1..=first).rev().find(|count| roads.is_place(legs[count - 1]));
    Some(Some(last.unwrap_or(0)))
}
