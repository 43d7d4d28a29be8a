//! Stands, where robots may be for a while, and the ways between them.

use crate::claims::Stretch;
use crate::planner::route::join_secs;
use crate::roads::{Leg, Roads};
use crate::traffic::Traffic;

/// The largest number of legs of a way.
const MOST_LEGS: usize = 6;
/// The largest number of ways that leave a stand.
const MOST_WAYS: usize = 12;
/// The largest number of ways that are searched for a stand.
const MOST_TRIES: usize = 200;
/// The distance from the end of a leg at which a base counts as whole, in metres.
const AT_END: f32 = 1e-3;

/// The ends of legs at which robots stand for a while.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stops {
    /// Those where a robot is only in the way of edges that meet there.
    Places,
    /// All of them.
    All,
}

impl Stops {
    fn contain(self, roads: &Roads, leg: Leg) -> bool {
        self == Self::All || roads.is_place(leg)
    }
}

/// A place on a leg where a robot is for a while: usually its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stand {
    /// The leg by which it got there.
    pub leg: Leg,
    /// Metres from where the leg is entered.
    pub to: f32,
}

/// A way from a stand to the end of a leg.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// Legs after the one of the stand; none if it leads to the end of that one.
    pub legs: Vec<Leg>,
    /// The leg at whose end it ends.
    pub to: Leg,
    /// Driving time, in seconds.
    pub secs: f32,
}

impl Stand {
    /// The stand at the end of a leg.
    pub fn at_end(roads: &Roads, leg: Leg) -> Self {
        Self { leg, to: roads.edge(leg.edge()).length }
    }

    /// The end of a robot's base.
    pub fn of(traffic: &Traffic<'_>, robot: u32) -> Option<Self> {
        let (leg, _) = traffic.base_end(robot)?;
        let end = traffic.claims.end(robot).filter(|end| end.leg == Some(leg))?;
        let length = traffic.roads.edge(leg.edge()).length;
        Some(Self { leg, to: if end.to >= length - AT_END { length } else { end.to } })
    }

    /// Whether it is at the end of its leg.
    pub fn is_at_end(&self, roads: &Roads) -> bool {
        self.to >= roads.edge(self.leg.edge()).length
    }

    /// Whether robots may stand there for long.
    pub fn is_stop(&self, roads: &Roads, stops: Stops) -> bool {
        self.is_at_end(roads) && stops.contain(roads, self.leg)
    }

    /// The claim of a robot that stands there.
    pub fn stretch(&self) -> Stretch {
        Stretch::at(self.leg, self.to)
    }
}

/// Whether some robots turn on the spot.
fn are_turning(roads: &Roads) -> bool {
    roads.classes().iter().any(|class| class.turns)
}

/// Returns the ways from a stand to the nearest stops, by driving time.
pub fn paths(traffic: &Traffic<'_>, stand: Stand, stops: Stops) -> Vec<Path> {
    let roads = traffic.roads;
    let mut paths: Vec<Path> = Vec::new();
    let rest = roads.edge(stand.leg.edge()).length - stand.to;
    let mut open =
        vec![Path { legs: Vec::new(), to: stand.leg, secs: driving_secs(roads, stand.leg, rest) }];
    if !stand.is_at_end(roads) && stops.contain(roads, stand.leg) {
        return open;
    }
    for _ in 0..MOST_TRIES {
        let Some(path) = open.pop() else { break };
        for &next in roads.exits(roads.end(path.to)) {
            if !may_follow(traffic, stand, &path, next) {
                continue;
            }
            let more = join_secs(roads, are_turning(roads), path.to, next)
                + driving_secs(roads, next, roads.edge(next.edge()).length);
            let mut legs = path.legs.clone();
            legs.push(next);
            let path = Path { legs, to: next, secs: path.secs + more };
            match stops.contain(roads, next) {
                true => paths.push(path),
                false if path.legs.len() < MOST_LEGS => open.push(path),
                false => {}
            }
        }
    }
    paths.sort_by(|a, b| a.secs.total_cmp(&b.secs).then(a.legs.cmp(&b.legs)));
    let mut ends: Vec<Leg> = Vec::new();
    paths.retain(|path| {
        let is_new = ends.len() < MOST_WAYS && !ends.contains(&path.to);
        ends.push(path.to);
        is_new
    });
    paths
}

/// Whether a leg may follow on a path. Robots change gear only where they may stand, and drive no
/// edge twice.
fn may_follow(traffic: &Traffic<'_>, stand: Stand, path: &Path, next: Leg) -> bool {
    let roads = traffic.roads;
    let starts = path.legs.is_empty() && stand.is_at_end(roads);
    let is_driven = path.legs.iter().chain([&stand.leg]).any(|leg| leg.edge() == next.edge());
    let is_same_gear = path.to.is_reverse() == next.is_reverse();
    let goes_back = stand.is_at_end(roads) && roads.end(next) == roads.end(stand.leg);
    (starts || (is_same_gear && !is_driven)) && !goes_back && !traffic.is_closed(next)
}

fn driving_secs(roads: &Roads, leg: Leg, metres: f32) -> f32 {
    metres / roads.allowed_speed(leg).max(1e-2)
}

/// Returns the stretches that a robot claims on a way from a stand.
pub fn stretches(roads: &Roads, stand: Stand, legs: &[Leg]) -> Vec<Stretch> {
    let mut stretches = Vec::new();
    if !stand.is_at_end(roads) {
        stretches.push(Stretch { from: stand.to, ..Stretch::whole(roads, stand.leg) });
    }
    let mut last = stand.leg;
    for &leg in legs {
        if are_turning(roads) && roads.is_turn(last, leg) {
            stretches.push(Stretch::disc(roads, roads.end(last)));
        }
        stretches.push(Stretch::whole(roads, leg));
        last = leg;
    }
    stretches
}
