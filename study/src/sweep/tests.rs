use super::*;
use crate::outcome::{RunEnd, Stall, StallKind};

pub(crate) fn measured(orders_per_hour: f64) -> Measured {
    Measured {
        digest: String::new(),
        end: RunEnd::AtTime,
        warm_up_secs: 0.0,
        secs: 3600.0,
        orders_per_hour,
        stops_per_hour: orders_per_hour,
        service: None,
        late: None,
        utilisation: 1.0,
        waiting: 0.0,
        empty: None,
        order_time: None,
        robot_time: None,
        contacts: 0,
        stalls: Vec::new(),
        unserved: 0,
        other_findings: BTreeMap::new(),
        examples: BTreeMap::new(),
        finished_orders: orders_per_hour as u64,
        failed_orders: 0,
        open_orders: 0,
        unplaced: Vec::new(),
        unroutable_orders: 0,
        backlog_growth: 0.0,
    }
}

/// Sweeps with a plant whose throughput is a function of robots and seed; returns the curve and
/// the number of rounds.
fn sweep(robots: &str, plant: impl Fn(u32, u64) -> Result<f64, String>) -> (Curve, usize, Known) {
    let (robots, mut known) = (robots.parse().expect("robots"), Known::new());
    for round in 0..100 {
        match next(&Question::Knee, &robots, &Precision::default(), &known) {
            Step::Done(curve) => return (curve, round, known),
            Step::Needs(runs) => {
                assert!(!runs.is_empty());
                for (robots, seed) in runs {
                    let fate = plant(robots, seed).map(measured).map_err(RunFailure::Failed);
                    assert!(
                        known.insert((robots, seed), fate).is_none(),
                        "asked twice for {robots}, {seed}"
                    );
                }
            }
        }
    }
    panic!("the sweep doesn't end");
}

/// Saturates at 180 robots, with a spread of 1 %.
fn plant(robots: u32, seed: u64) -> Result<f64, String> {
    Ok(f64::from(robots.min(180)) * 20.0 * (1.0 + 0.01 * (seed as f64 - 2.0)))
}

#[test]
fn the_knee_is_found_within_the_resolution() {
    let (curve, rounds, known) = sweep("1..1000", plant);
    let knee = curve.knee.expect("a knee");
    let robots = curve.points[knee].robots;
    assert!((170..=192).contains(&robots), "{robots}");
    assert!(
        curve.points[knee + 1].robots - robots <= 12
            && robots - curve.points[knee - 1].robots <= 12
    );
    assert!(
        !curve.is_open && rounds <= 8 && known.len() < 90,
        "{rounds} rounds, {} runs",
        known.len()
    );
    assert!(curve.points[knee].runs.len() > 3, "its interval is wider than 2 % with three seeds");
}

#[test]
fn a_curve_that_still_rises_is_open_and_a_list_is_not_refined() {
    let (curve, ..) = sweep("1..100", plant);
    assert!(curve.is_open && curve.knee.is_some_and(|knee| curve.points[knee].robots == 100));
    assert_eq!(curve.points.len(), 8, "1, 2, 4 … 64, 100");
    let (curve, _, known) = sweep("50,100,150", |robots, _| Ok(f64::from(robots.min(100))));
    assert_eq!((curve.points.len(), known.len()), (3, 9));
    assert_eq!((curve.knee, curve.half), (Some(1), Some(1)));
    assert_eq!((curve.most_of, curve.most), (Some(1), Some(1)));
}

#[test]
fn what_does_not_fit_ends_the_range() {
    let (curve, ..) =
        sweep(
            "1..1000",
            |robots, seed| {
                if robots > 60 { Err("60 fit".to_owned()) } else { plant(robots, seed) }
            },
        );
    let last = curve.points.last().expect("points").robots;
    assert!((57..=60).contains(&last), "{last}");
    assert!(
        curve.failed.iter().all(|(robots, reason)| *robots > 60 && reason.to_string() == "60 fit")
    );
}

#[test]
fn nothing_carried_is_no_endless_sweep() {
    let (curve, ..) = sweep("1..8", |_, _| Ok(0.0));
    assert_eq!(curve.knee, None);
    let (curve, ..) = sweep("1..8", |_, _| Err("broken".to_owned()));
    assert_eq!((curve.points.len(), curve.failed.len()), (0, 4));
}

/// Robots up to `most` carry 10 orders an hour each; more come to a standstill.
fn stalling(most: u32) -> (Curve, Known) {
    let (robots, mut known) = ("1..64".parse().expect("robots"), Known::new());
    loop {
        match next(&Question::Knee, &robots, &Precision::default(), &known) {
            Step::Done(curve) => return (curve, known),
            Step::Needs(runs) => {
                for (robots, seed) in runs {
                    let mut run = measured(f64::from(robots) * 10.0);
                    if robots > most && seed == 2 {
                        run.stalls.push(Stall {
                            kind: StallKind::Standstill,
                            from_secs: 60.0,
                            until_secs: None,
                            robots: vec![0],
                            place: None,
                            seen_secs: None,
                            waits_for: BTreeMap::new(),
                            places: BTreeMap::new(),
                            out_of_service: Vec::new(),
                            edges: BTreeMap::new(),
                        });
                    }
                    known.insert((robots, seed), Ok(run));
                }
            }
        }
    }
}

#[test]
fn no_knee_is_computed_from_runs_that_stall() {
    let (curve, _) = stalling(11);
    let knee = curve.knee.expect("a knee");
    assert_eq!((curve.points[knee].robots, curve.is_open), (11, false));
    assert!(curve.points[knee + 1].robots == 12 && curve.points[knee + 1].is_stalled());
    let (curve, _) = stalling(0);
    assert_eq!((curve.knee, curve.points.len()), (None, 7));
}

#[test]
fn a_value_narrower_than_its_interval_gets_more_seeds() {
    let wild = |robots, seed: u64| match (robots, seed) {
        (2, 1) => Ok(100.0),
        (2, _) => Ok(0.0),
        _ => Ok(50.0),
    };
    let (curve, ..) = sweep("1,2,4", wild);
    let seeds: Vec<usize> = curve.points.iter().map(|point| point.runs.len()).collect();
    assert_eq!(seeds, [3, 10, 3]);
}

#[test]
fn the_outlook_is_near_the_runs_that_a_sweep_needs() {
    let (_, _, all) = sweep("1..1000", plant);
    let (question, robots) = (Question::Knee, "1..1000".parse().expect("robots"));
    let outlook = |known: &Known| outlook(&question, &robots, &Precision::default(), known);
    assert_eq!(outlook(&Known::new()), None, "nothing is known");
    let end = outlook(&all).expect("all is known");
    assert!(end.next.is_empty() && end.later.is_empty() && end.chosen.is_some(), "{end:?}");
    let Step::Needs(first) = next(&question, &robots, &Precision::default(), &Known::new()) else {
        panic!("it needs runs");
    };
    let mut known = all.clone();
    known.retain(|run, _| first.contains(run));
    let outlook = outlook(&known).expect("known");
    let (expected, left) = (outlook.next.len() + outlook.later.len(), all.len() - known.len());
    assert!(left > 0 && (left / 2..=2 * left).contains(&expected), "{expected}, {left}");
}
