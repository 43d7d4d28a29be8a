//! The runs that a sweep is expected to need yet: it is continued on guesses.

use std::collections::BTreeMap;

use super::{Known, Run, Step, next};
use crate::outcome::Measured;
use crate::plan::{Precision, Question, Robots};

/// The largest number of rounds that are guessed.
const MAX_ROUNDS: usize = 64;

/// The rest of a sweep, as it is expected.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outlook {
    /// The runs of the next step.
    pub next: Vec<Run>,
    /// The runs after these.
    pub later: Vec<Run>,
    /// The number of robots that the answer is expected to be about.
    pub chosen: Option<u32>,
}

/// Returns the expected rest of a sweep. Runs that aren't finished are taken to give what the
/// finished ones suggest; `None` if there are none.
pub fn outlook(
    question: &Question,
    robots: &Robots,
    precision: &Precision,
    known: &Known,
) -> Option<Outlook> {
    let means = means(known);
    let (mut guessed, mut outlook) = (known.clone(), Outlook::default());
    for _ in 0..MAX_ROUNDS {
        let runs = match next(question, robots, precision, &guessed) {
            Step::Needs(runs) => runs,
            Step::Done(curve) => {
                outlook.chosen = curve.robots(curve.chosen());
                break;
            }
        };
        for &run in &runs {
            guessed.insert(run, Ok(guess(known, &means, run)?));
        }
        if outlook.next.is_empty() {
            outlook.next = runs;
        } else {
            outlook.later.extend(runs);
        }
    }
    Some(outlook)
}

/// The mean throughput of the finished runs, by the number of robots.
fn means(known: &Known) -> BTreeMap<u32, f64> {
    let mut sums: BTreeMap<u32, (f64, f64)> = BTreeMap::new();
    for ((robots, _), result) in known {
        if let Ok(measured) = result {
            let (sum, runs) = sums.entry(*robots).or_default();
            (*sum, *runs) = (*sum + measured.orders_per_hour, *runs + 1.0);
        }
    }
    sums.into_iter().map(|(robots, (sum, runs))| (robots, sum / runs)).collect()
}

/// Guesses the figures of a run: those of the nearest number of robots, with the throughput between
/// its neighbours'.
fn guess(known: &Known, means: &BTreeMap<u32, f64>, (robots, seed): Run) -> Option<Measured> {
    let (nearest, mean) = means.iter().min_by_key(|(other, _)| other.abs_diff(robots))?;
    let finished = known.range((*nearest, 0)..=(*nearest, u64::MAX));
    let finished: Vec<&Measured> = finished.filter_map(|(_, run)| run.as_ref().ok()).collect();
    // The spread of the seeds goes on.
    let like = *finished.get(seed as usize % finished.len().max(1))?;
    let factor = if *mean > 0.0 { throughput(means, robots)? / mean } else { 1.0 };
    Some(Measured { orders_per_hour: like.orders_per_hour * factor, ..like.clone() })
}

/// Returns the throughput of a number of robots on the line between its neighbours.
fn throughput(means: &BTreeMap<u32, f64>, robots: u32) -> Option<f64> {
    let below = means.range(..=robots).next_back();
    let above = means.range(robots..).next();
    match (below, above) {
        (Some((low, from)), Some((high, to))) if low < high => {
            let part = f64::from(robots - low) / f64::from(high - low);
            Some(from + (to - from) * part)
        }
        (Some((_, mean)), _) | (None, Some((_, mean))) => Some(*mean),
        (None, None) => None,
    }
}
