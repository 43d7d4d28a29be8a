//! The narrow phase: exact checks of the pairs whose boxes overlap.

use crate::body::{Body, nearest_point};
use crate::continuous::{ALWAYS, TimeWindow, closest_proximity};
use crate::criteria::{Criteria, HYSTERESIS, INFLATION, Settings};
use crate::frame_context::FrameContext;
use crate::overlap::overlap_centre;
use crate::strip_index::{PackedRobot, Strip};
use crate::sweep::Candidates;
use crate::swept_path::{Approach, straight_on};
use crate::tracker::PairObservation;

/// Distance beyond the margin, in metres, from which on no pair has a level now.
const MAX_GAP_BEYOND_MARGIN: f32 = HYSTERESIS as f32 + 0.01;

/// A robot of a strip, by its slot.
type InStrip<'strip> = (&'strip Strip, u32);

/// Checks two robots exactly, wherever they are.
pub(crate) fn check(
    context: &FrameContext,
    one: InStrip,
    other: InStrip,
    observations: &mut Vec<PairObservation>,
) {
    let is_first = one.0.robot(one.1).id < other.0.robot(other.1).id;
    let pair = if is_first { [one, other] } else { [other, one] };
    let [a, b] = pair.map(|(strip, slot)| strip.robot(slot));
    let [body_a, body_b] = [a, b].map(|robot| robot.body(context.world.footprints()));
    let mut criteria = Criteria::now(context.settings, &body_a, &body_b);
    if !criteria.is_possible_now() && context.settings.horizon() > 0.0 {
        criteria = criteria.or(predicted(context.settings, pair, [&body_a, &body_b], ALWAYS));
    }
    push(context, criteria, (a, &body_a), (b, &body_b), observations);
}

/// Checks the candidate pairs of a strip. `near` is scratch memory.
pub(crate) fn check_all(
    context: &FrameContext,
    strip: &Strip,
    candidates: Candidates,
    near: &mut Vec<[u32; 2]>,
    observations: &mut Vec<PairObservation>,
) {
    let footprints = context.world.footprints();
    if context.settings.horizon() == 0.0 {
        for slots in candidates {
            let [a, b] = in_order(strip, *slots).map(|slot| strip.robot(slot));
            if !a.is_first_with(b) {
                continue;
            }
            let [body_a, body_b] = [a, b].map(|robot| robot.body(footprints));
            let criteria = Criteria::now(context.settings, &body_a, &body_b);
            push(context, criteria, (a, &body_a), (b, &body_b), observations);
        }
        return;
    }
    keep_near(context, strip, candidates, near);
    for slots in &*near {
        let [a, b] = slots.map(|slot| strip.robot(slot));
        let [body_a, body_b] = [a, b].map(|robot| robot.body(footprints));
        let criteria = now_and_predicted(context.settings, strip, *slots, [&body_a, &body_b]);
        push(context, criteria, (a, &body_a), (b, &body_b), observations);
    }
}

/// Writes to `near` the candidates that the quick check with bounding circles doesn't exclude.
/// Every pair is written, and overwritten unless it is kept: a branch on the outcome would often be
/// mispredicted.
fn keep_near(
    context: &FrameContext,
    strip: &Strip,
    candidates: Candidates,
    near: &mut Vec<[u32; 2]>,
) {
    let (margin, horizon) = (context.settings.margin(), context.settings.horizon());
    let footprints = context.world.footprints();
    near.resize(candidates.len(), [0; 2]);
    let mut kept = 0;
    for slots in candidates {
        let slots = in_order(strip, *slots);
        let [a, b] = slots.map(|slot| strip.robot(slot));
        let [body_a, body_b] = [a, b].map(|robot| robot.body(footprints));
        let approach = approach(strip, slots, [&body_a, &body_b]);
        let is_near = approach.is_near(margin + MAX_GAP_BEYOND_MARGIN)
            | approach.comes_near(2.0 * INFLATION as f32, horizon);
        near[kept] = slots;
        // Two paths of the same robot aren't a pair.
        kept += usize::from(is_near & a.is_first_with(b) & (a.id != b.id));
    }
    near.truncate(kept);
}

/// Returns the criteria that two robots meet now or within the horizon.
fn now_and_predicted(
    settings: Settings,
    strip: &Strip,
    slots: [u32; 2],
    [a, b]: [&Body; 2],
) -> Criteria {
    let approach = approach(strip, slots, [a, b]);
    let is_near = approach.is_near(settings.margin() + MAX_GAP_BEYOND_MARGIN);
    let now = if is_near { Criteria::now(settings, a, b) } else { Criteria::default() };
    if now.is_possible_now() {
        return now;
    }
    let window = approach.when_near(2.0 * INFLATION as f32);
    now.or(predicted(settings, slots.map(|slot| (strip, slot)), [a, b], window))
}

/// Returns the criteria that the trajectories of two robots meet within a window of time.
fn predicted(
    settings: Settings,
    [a, b]: [InStrip; 2],
    bodies: [&Body; 2],
    window: TimeWindow,
) -> Criteria {
    let horizon = settings.horizon();
    let straight_a = straight_on(bodies[0], a.0.swept_path(a.1), horizon);
    let straight_b = straight_on(bodies[1], b.0.swept_path(b.1), horizon);
    Criteria::predicted(closest_proximity(
        (bodies[0], a.0.segments(a.1, &straight_a)),
        (bodies[1], b.0.segments(b.1, &straight_b)),
        window,
        INFLATION,
    ))
}

fn approach(strip: &Strip, slots: [u32; 2], [a, b]: [&Body; 2]) -> Approach {
    let [swept_a, swept_b] = slots.map(|slot| strip.swept_path(slot));
    Approach::of((a, swept_a), (b, swept_b))
}

/// Puts the robot with the lower id first, so that the result of a pair doesn't depend on the order
/// of its slots. Without a branch, because every other one would be mispredicted.
fn in_order(strip: &Strip, slots: [u32; 2]) -> [u32; 2] {
    let [a, b] = slots.map(|slot| u64::from(strip.robot(slot).id) << 32 | u64::from(slot));
    [a.min(b) as u32, a.max(b) as u32]
}

/// Adds a pair that may have a level.
fn push(
    context: &FrameContext,
    criteria: Criteria,
    (a, body_a): (&PackedRobot, &Body),
    (b, body_b): (&PackedRobot, &Body),
    observations: &mut Vec<PairObservation>,
) {
    if criteria.any() && context.may_meet(a, b) {
        observations.push(PairObservation {
            robots: [a.id, b.id],
            position: if criteria.may_touch() {
                overlap_centre(body_a, body_b)
            } else {
                nearest_point(body_a, body_b)
            },
            relative_speed: (context.velocity(b) - context.velocity(a)).length(),
            criteria,
        });
    }
}
