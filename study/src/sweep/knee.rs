//! The sweep for the knee: first the grid with the least number of seeds, then the middles between
//! the knee and its neighbours, then seeds at the knee until its interval is narrow enough.

use std::collections::BTreeMap;

use super::{Curve, Known, MAX_ROUNDS, Run, Step, missing, points};
use crate::plan::{Precision, Robots};
use crate::statistics::knee;

/// The largest half of an interval of a value that is known, as a part of the value.
const WIDEST: f64 = 1.0;

/// Returns the next step of the sweep for the knee.
pub(super) fn next(robots: &Robots, precision: &Precision, known: &Known) -> Step {
    let mut wanted: BTreeMap<u32, u64> =
        robots.grid().into_iter().map(|robots| (robots, precision.least_seeds)).collect();
    for _ in 0..MAX_ROUNDS {
        let missing = missing(&wanted, known);
        if !missing.is_empty() {
            return Step::Needs(missing);
        }
        let curve = curve(&wanted, precision, known);
        let more =
            if robots.is_refined() { refined(&curve, precision, &wanted) } else { Vec::new() };
        if !more.is_empty() {
            wanted.extend(more.into_iter().map(|robots| (robots, precision.least_seeds)));
        } else {
            let more = more_seeds(&curve, precision);
            if more.is_empty() {
                return Step::Done(curve);
            }
            wanted.extend(more);
        }
    }
    Step::Done(curve(&wanted, precision, known))
}

fn curve(wanted: &BTreeMap<u32, u64>, precision: &Precision, known: &Known) -> Curve {
    let mut curve = points(wanted, known);
    // A run with a stall isn't traffic, and a larger fleet isn't safer.
    let (mut points, mut indices) = (Vec::new(), Vec::new());
    let moving = curve.points.iter().enumerate().take_while(|(_, point)| !point.is_stalled());
    for (index, point) in moving {
        if let Some(throughput) = point.throughput() {
            points.push((f64::from(point.robots), throughput.mean));
            indices.push(index);
        }
    }
    curve.half = knee(&points, 0.5).map(|half| indices[half.index]);
    curve.most_of = knee(&points, 0.9).map(|part| indices[part.index]);
    // Of equal ones, the first.
    let most = points.iter().enumerate().rev().max_by(|(_, a), (_, b)| a.1.total_cmp(&b.1));
    curve.most = most.filter(|(_, point)| point.1 > 0.0).map(|(index, _)| indices[index]);
    if let Some(found) = knee(&points, precision.knee) {
        let index = indices[found.index];
        (curve.knee, curve.is_open) = (Some(index), index + 1 == curve.points.len());
    }
    curve
}

/// Returns the numbers of robots halfway from the knee to its neighbours, unless these are near
/// enough, or the knee is beyond the range.
fn refined(curve: &Curve, precision: &Precision, wanted: &BTreeMap<u32, u64>) -> Vec<u32> {
    // Beyond the largest number there is nothing to find, and below it nothing that matters.
    let Some(knee) = curve.knee.filter(|_| !curve.is_open || !curve.failed.is_empty()) else {
        return Vec::new();
    };
    let knee = curve.points[knee].robots;
    let near = ((f64::from(knee) * precision.resolution) as u32).max(1);
    // A number of robots whose runs failed is a neighbour, too: the largest that can be is below
    // it.
    let before = wanted.range(..knee).next_back().map(|(robots, _)| *robots);
    let after = wanted.range(knee + 1..).next().map(|(robots, _)| *robots);
    let far = before.into_iter().chain(after).filter(|other| knee.abs_diff(*other) > near);
    far.map(|other| knee.midpoint(other)).filter(|robots| !wanted.contains_key(robots)).collect()
}

/// Returns the numbers of robots that need more seeds, with the numbers of these: the knee if its
/// interval isn't narrow enough, and others whose interval is wider than their value.
fn more_seeds(curve: &Curve, precision: &Precision) -> Vec<Run> {
    let mut more = Vec::new();
    for (index, point) in curve.points.iter().enumerate() {
        let has_failed = curve.failed.iter().any(|(robots, _)| *robots == point.robots);
        if has_failed || point.is_stalled() {
            continue;
        }
        let wanted = if curve.knee == Some(index) { precision.interval } else { WIDEST };
        let Some(interval) = point.throughput() else { continue };
        let seeds = interval.values as u64;
        if !interval.is_within(wanted) && seeds < precision.most_seeds {
            // Two at a time: one more hardly changes an interval, and there are two cores at least.
            more.push((point.robots, (seeds + 2).min(precision.most_seeds)));
        }
    }
    more
}
