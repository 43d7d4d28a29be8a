//! From robots whose boxes overlap to pairs that may have a level.

use crate::body::{Body, meeting_place, relative_speed};
use crate::crowd::Crowd;
use crate::ledger::Found;
use crate::meeting::{ALWAYS, meet};
use crate::pair::{GROWN, Signs};
use crate::settings::{HYSTERESIS, Settings};
use crate::strips::{Mover, Strip};
use crate::sweep::Candidates;
use crate::way::{Approach, straight_on};

/// Farther apart than this beyond the margin, in metres, no pair has a level now.
const FAR: f32 = HYSTERESIS as f32 + 0.01;

/// Looks closely at two robots, wherever they are.
pub(crate) fn check(crowd: &Crowd, one: (&Strip, u32), other: (&Strip, u32), found: &mut Vec<Found>) {
    let mover = |(strip, place): (&Strip, u32)| *strip.mover(place);
    let [a, b] = if mover(one).robot < mover(other).robot { [one, other] } else { [other, one] };
    let [body_a, body_b] = [a, b].map(|robot| mover(robot).body(crowd.roads.footprints()));
    let mut signs = Signs::now(crowd.settings, &body_a, &body_b);
    if !signs.may() && crowd.settings.horizon() > 0.0 {
        signs = signs.or(later(crowd.settings, [a, b], [&body_a, &body_b], ALWAYS));
    }
    note(signs, (&mover(a), &body_a), (&mover(b), &body_b), found);
}

/// Looks at robots of a strip whose boxes overlap. `near` is memory for it.
pub(crate) fn check_all(
    crowd: &Crowd,
    strip: &Strip,
    candidates: Candidates,
    near: &mut Vec<[u32; 2]>,
    found: &mut Vec<Found>,
) {
    let footprints = crowd.roads.footprints();
    if crowd.settings.horizon() == 0.0 {
        for places in candidates {
            let [a, b] = in_order(strip, *places).map(|place| strip.mover(place));
            if !a.is_first_with(b) {
                continue;
            }
            let [body_a, body_b] = [a, b].map(|mover| mover.body(footprints));
            note(Signs::now(crowd.settings, &body_a, &body_b), (a, &body_a), (b, &body_b), found);
        }
        return;
    }
    keep_near(crowd, strip, candidates, near);
    for places in &*near {
        let [a, b] = places.map(|place| strip.mover(place));
        let [body_a, body_b] = [a, b].map(|mover| mover.body(footprints));
        let signs = predicted(crowd.settings, strip, *places, [&body_a, &body_b]);
        note(signs, (a, &body_a), (b, &body_b), found);
    }
}

/// Keeps those of which a quick look doesn't say that they stay apart. All are written, as a guess which are kept would
/// often be wrong.
fn keep_near(crowd: &Crowd, strip: &Strip, candidates: Candidates, near: &mut Vec<[u32; 2]>) {
    let (margin, horizon) = (crowd.settings.margin(), crowd.settings.horizon());
    let footprints = crowd.roads.footprints();
    near.resize(candidates.len(), [0; 2]);
    let mut kept = 0;
    for places in candidates {
        let places = in_order(strip, *places);
        let [a, b] = places.map(|place| strip.mover(place));
        let [body_a, body_b] = [a, b].map(|mover| mover.body(footprints));
        let approach = approach(strip, places, [&body_a, &body_b]);
        let is_near = approach.is_near(margin + FAR) | approach.comes_near(2.0 * GROWN as f32, horizon);
        near[kept] = places;
        kept += usize::from(is_near & a.is_first_with(b));
    }
    near.truncate(kept);
}

/// What the present and the prediction say of two robots.
fn predicted(settings: Settings, strip: &Strip, places: [u32; 2], [a, b]: [&Body; 2]) -> Signs {
    let approach = approach(strip, places, [a, b]);
    let now = if approach.is_near(settings.margin() + FAR) { Signs::now(settings, a, b) } else { Signs::default() };
    if now.may() {
        return now;
    }
    let when = approach.when_near(2.0 * GROWN as f32);
    now.or(later(settings, places.map(|place| (strip, place)), [a, b], when))
}

/// What the ways of two robots say, between these seconds from now.
fn later(settings: Settings, [a, b]: [(&Strip, u32); 2], bodies: [&Body; 2], when: [f32; 2]) -> Signs {
    let straight = |(strip, place): (&Strip, u32), body| straight_on(body, strip.way(place), settings.horizon());
    let (straight_a, straight_b) = (straight(a, bodies[0]), straight(b, bodies[1]));
    let (pieces_a, pieces_b) = (a.0.pieces(a.1, &straight_a), b.0.pieces(b.1, &straight_b));
    Signs::later(meet((bodies[0], pieces_a), (bodies[1], pieces_b), when, GROWN))
}

fn approach(strip: &Strip, places: [u32; 2], [a, b]: [&Body; 2]) -> Approach {
    let [way_a, way_b] = places.map(|place| strip.way(place));
    Approach::of((a, way_a), (b, way_b))
}

/// The robot with the lower id first: so that two always come out the same. Without a branch, as every other guess would
/// be wrong.
fn in_order(strip: &Strip, places: [u32; 2]) -> [u32; 2] {
    let [a, b] = places.map(|place| u64::from(strip.mover(place).robot) << 32 | u64::from(place));
    [a.min(b) as u32, a.max(b) as u32]
}

/// Adds two robots that may have a level.
fn note(signs: Signs, (a, body_a): (&Mover, &Body), (b, body_b): (&Mover, &Body), found: &mut Vec<Found>) {
    if signs.any() {
        found.push(Found {
            robots: [a.robot, b.robot],
            place: meeting_place(body_a, body_b),
            relative_speed: relative_speed((body_a, a.speed), (body_b, b.speed)),
            signs,
        });
    }
}
