//! A region that is helped.

use super::course::Course;
use super::lacam::{self, Hop, Outcome, Problem};
use super::region::{Region, Size};
use super::standing::is_movable;
use super::ways::Stops;
use super::{alone, lacam::shorten};
use crate::traffic::Traffic;

/// The largest number of stands of the roads that are searched as a whole.
const MOST_STANDS: usize = 1_000;

/// The largest number of hops of a solution on all roads, for each robot with a target: beyond it,
/// robots are helped sooner one after the other.
const MOST_HOPS: usize = 10;

/// A search for a solution.
#[derive(Debug)]
pub enum Search {
    /// For all robots that have targets.
    Joint(lacam::Search),
    /// For a robot that is the only one with a target.
    Alone(alone::Search),
}

impl Search {
    /// The problem that is searched.
    fn problem(&self) -> &Problem {
        match self {
            Self::Joint(search) => search.problem(),
            Self::Alone(search) => search.problem(),
        }
    }

    /// Choices that were tried so far: a measure of the time spent.
    pub fn work(&self) -> u64 {
        match self {
            Self::Joint(search) => search.work(),
            Self::Alone(search) => search.work(),
        }
    }

    /// Configurations that were computed so far.
    pub fn steps(&self) -> u64 {
        match self {
            Self::Joint(search) => search.steps(),
            Self::Alone(search) => search.steps(),
        }
    }

    /// Searches on, until about as many more choices were tried.
    pub fn advance(&mut self, work: u64) -> Outcome {
        match self {
            Self::Joint(search) => search.advance(work),
            Self::Alone(search) => search.advance(work),
        }
    }

    /// Returns the hops of a solution without those that help nobody; `None` if there are too many
    /// where all ends of legs are stands.
    pub fn shortened(&self, hops: Vec<Hop>, stops: Stops) -> Option<Vec<Hop>> {
        let targets = self.problem().targets.iter().filter(|targets| !targets.is_empty()).count();
        let most = match (self, stops) {
            (Self::Joint(_), Stops::All) => MOST_HOPS * targets,
            _ => usize::MAX,
        };
        if hops.len() / 4 > most {
            return None;
        }
        Some(shorten(self.problem(), hops)).filter(|hops| hops.len() <= most)
    }
}

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
    /// A solution is searched, in one of several attempts.
    Search(Box<Search>, usize),
    Drive(Course),
    /// All are released.
    Over,
}

impl Case {
    /// Begins to help the robots of a region; `None` if none of them has a target.
    pub fn new(region: Region, seeds: Vec<u32>, size: Size) -> Option<Self> {
        let search = Box::new(region.search(0)?);
        let phase = Phase::Search(search, 0);
        Some(Self { seeds, size, is_enlarged: false, region, phase })
    }

    /// Begins to help all robots at the same time, where each may stand at all ends of legs; `None`
    /// if the roads are too large, or none of the robots has a target.
    pub fn of_all(traffic: &Traffic<'_>, members: usize) -> Option<Self> {
        let robots = traffic.robots().filter(|(_, state)| is_movable(state));
        let seeds: Vec<u32> = robots.map(|(robot, _)| robot).collect();
        let size = Size { ways: u32::MAX, stands: MOST_STANDS, members, stops: Stops::All };
        let region = Region::around(traffic, &seeds, size)?;
        let is_whole = region.stands.len() < MOST_STANDS;
        is_whole.then(|| Self::new(region, seeds, size))?
    }

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
