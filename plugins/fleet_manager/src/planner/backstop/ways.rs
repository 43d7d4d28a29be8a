//! Stands, where robots may be for a while, and the ways between them.

use crate::claims::Stretch;
use crate::roads::{Leg, Roads};
use crate::traffic::Traffic;

/// The most legs of a way.
const MOST_LEGS: usize = 6;
/// The most ways that leave a stand.
const MOST_WAYS: usize = 12;
/// The most ways that are looked at for a stand.
const MOST_TRIES: usize = 200;
/// The costs of a change of gear, of a turn on the spot, and of a corner that the robot can't
/// drive, in seconds.
const GEAR_CHANGE_SECS: f32 = 2.0;
const TURN_SECS: f32 = 4.0;
const JUMP_SECS: f32 = 60.0;
/// The distance from the end of a leg at which a base counts as whole, in metres.
const AT_END: f32 = 1e-3;

/// A place on a leg where a robot is for a while: usually the end of a leg where it is only in the
/// way of edges that meet there.
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
    pub fn is_place(&self, roads: &Roads) -> bool {
        self.is_at_end(roads) && is_place(roads, self.leg)
    }

    /// The claim of a robot that stands there.
    pub fn stretch(&self) -> Stretch {
        Stretch { track: self.leg.edge(), leg: Some(self.leg), from: self.to, to: self.to }
    }
}

/// Whether robots may stand at the end of a leg.
pub fn is_place(roads: &Roads, leg: Leg) -> bool {
    (0..roads.footprints().len()).all(|footprint| roads.stops(footprint).is_siding(leg))
}

/// Whether some robots turn on the spot.
fn are_turning(roads: &Roads) -> bool {
    roads.classes().iter().any(|class| class.turns)
}

/// Returns the ways from a stand to the nearest places, by driving time.
pub fn paths(traffic: &Traffic<'_>, stand: Stand) -> Vec<Path> {
    let roads = traffic.roads;
    let mut paths: Vec<Path> = Vec::new();
    let rest = roads.edge(stand.leg.edge()).length - stand.to;
    let mut open =
        vec![Path { legs: Vec::new(), to: stand.leg, secs: driving_secs(roads, stand.leg, rest) }];
    if !stand.is_at_end(roads) && is_place(roads, stand.leg) {
        return open;
    }
    for _ in 0..MOST_TRIES {
        let Some(path) = open.pop() else { break };
        for &next in roads.exits(roads.end(path.to)) {
            if !may_follow(traffic, stand, &path, next) {
                continue;
            }
            let more = join_secs(roads, path.to, next)
                + driving_secs(roads, next, roads.edge(next.edge()).length);
            let mut legs = path.legs.clone();
            legs.push(next);
            let path = Path { legs, to: next, secs: path.secs + more };
            match is_place(roads, next) {
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
    metres / roads.edge(leg.edge()).speeds[usize::from(leg.is_reverse())].max(1e-2)
}

fn join_secs(roads: &Roads, from: Leg, to: Leg) -> f32 {
    let gear = if from.is_reverse() == to.is_reverse() { 0.0 } else { GEAR_CHANGE_SECS };
    match roads.is_turn(from, to) {
        false => gear,
        true if are_turning(roads) => gear + TURN_SECS,
        true => gear + JUMP_SECS,
    }
}

/// Returns what a robot claims on a way, beyond where it stands.
pub fn stretches(roads: &Roads, stand: Stand, legs: &[Leg]) -> Vec<Stretch> {
    let whole = |leg: Leg| Stretch {
        track: leg.edge(),
        leg: Some(leg),
        from: 0.0,
        to: roads.edge(leg.edge()).length,
    };
    let mut stretches = Vec::new();
    if !stand.is_at_end(roads) {
        stretches.push(Stretch { from: stand.to, ..whole(stand.leg) });
    }
    let mut last = stand.leg;
    for &leg in legs {
        if are_turning(roads) && roads.is_turn(last, leg) {
            stretches.push(Stretch {
                track: roads.disc(roads.end(last)),
                leg: None,
                from: 0.0,
                to: 0.0,
            });
        }
        stretches.push(whole(leg));
        last = leg;
    }
    stretches
}
