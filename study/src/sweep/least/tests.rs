use regatta_base::random::Random;

use super::*;
use crate::plan::Question;
use crate::sweep::tests::measured;
use crate::workers::RunFailure;

/// A day in which 99 % of the orders take no longer than some seconds.
fn day(p99_secs: f64) -> Measured {
    let times = [p99_secs; 6];
    let [mean_secs, p50_secs, p90_secs, p95_secs, p99_secs, longest_secs] = times;
    let service = Service { mean_secs, p50_secs, p90_secs, p95_secs, p99_secs, longest_secs };
    Measured { end: RunEnd::Done, service: Some(service), late: Some(0.0), ..measured(60.0) }
}

/// Searches for the least number that meets some targets; returns the curve and the runs.
fn search(
    targets: &[&str],
    robots: &str,
    plant: impl Fn(u32, u64) -> Result<Measured, RunFailure>,
) -> (Curve, Known) {
    let targets = targets.iter().map(|target| target.parse().expect("a target")).collect();
    let (question, robots) = (Question::Least(targets), robots.parse().expect("robots"));
    let mut known = Known::new();
    for _ in 0..MAX_ROUNDS {
        match crate::sweep::next(&question, &robots, &Precision::default(), &known) {
            Step::Done(curve) => return (curve, known),
            Step::Needs(runs) => {
                assert!(!runs.is_empty());
                for run in runs {
                    let before = known.insert(run, plant(run.0, run.1));
                    assert!(before.is_none(), "asked twice for {run:?}");
                }
            }
        }
    }
    panic!("the search doesn't end");
}

fn found(curve: &Curve) -> Option<u32> {
    let least = curve.least.as_ref().expect("a search");
    least.found.map(|index| curve.points[index].robots)
}

const TARGET: &[&str] = &["p99 service < 360s", "late < 1%"];

#[test]
fn the_least_number_is_that_of_all_numbers() {
    for least in [1, 2, 3, 7, 64, 65, 100, 199, 200] {
        let secs = |robots: u32| if robots >= least { 300.0 } else { 400.0 };
        let (curve, known) =
            search(TARGET, "1..200", |robots, seed| Ok(day(secs(robots) + seed as f64)));
        assert_eq!(found(&curve), Some(least));
        assert!(known.len() <= 3 * 22, "{least}: {} runs", known.len());
        let tried: Vec<u32> = curve.points.iter().map(|point| point.robots).collect();
        let near = least.saturating_sub(2).max(1)..=(least + 2).min(200);
        assert!(near.clone().all(|robots| tried.contains(&robots)), "{least}: {tried:?}");
    }
}

/// A load that comes, whose figures are within the limits for as long as the runs take.
#[test]
fn robots_whose_backlog_grows_meet_no_target_of_orders() {
    let plant = |growth: f64| {
        move |robots: u32, seed: u64| {
            let backlog_growth = if robots < 3 { growth + 0.1 * seed as f64 } else { 0.0 };
            Ok(Measured { end: RunEnd::AtTime, backlog_growth, ..day(300.0 + seed as f64) })
        }
    };
    let (curve, _) = search(TARGET, "1..5", plant(5.5));
    assert_eq!(found(&curve), Some(3));
    assert!(matches!(curve.points[1].trend(), Trend::Growing(_)));
    let (curve, _) = search(TARGET, "1..5", plant(0.5));
    assert_eq!(found(&curve), Some(1), "some orders more are chance");
    let (curve, _) = search(&["30 orders/h"], "1..5", plant(5.5));
    assert_eq!(found(&curve), Some(1), "a throughput is what it is");
}

/// Few seeds say little: a backlog that may grow by a tenth of what comes gets more of them.
#[test]
fn a_backlog_that_may_grow_gets_more_seeds() {
    let plant = |robots: u32, seed: u64| {
        let backlog_growth = if robots < 3 { [1.0, 6.0, 11.0][seed as usize % 3] } else { 0.0 };
        Ok(Measured { end: RunEnd::AtTime, backlog_growth, ..day(300.0 + seed as f64) })
    };
    let (curve, known) = search(TARGET, "1..5", plant);
    assert_eq!(found(&curve), Some(3));
    assert!(known.contains_key(&(1, 5)) && !known.contains_key(&(3, 4)));
    assert!(matches!(curve.points[0].trend(), Trend::Growing(_)));
}

#[test]
fn robots_that_are_busy_all_the_time_while_orders_wait_meet_no_target_of_orders() {
    let plant = |open_orders: u64, unroutable_orders: u64| {
        move |robots: u32, seed: u64| {
            let utilisation = if robots < 3 { 0.99 } else { 0.7 };
            let run = Measured { end: RunEnd::AtTime, utilisation, ..day(300.0 + seed as f64) };
            Ok(Measured { open_orders, unroutable_orders, ..run })
        }
    };
    assert_eq!(found(&search(TARGET, "1..5", plant(12, 0)).0), Some(3));
    assert_eq!(found(&search(TARGET, "1..5", plant(2, 0)).0), Some(1), "robots carry them");
    assert_eq!(found(&search(TARGET, "1..5", plant(12, 11)).0), Some(1), "nobody can carry them");
}

#[test]
fn with_chance_the_answer_is_within_one_robot_of_the_truth() {
    // The p99 falls with the number of robots; 40 robots have 360 s, so that 41 are the least.
    let mut right = 0;
    for repeat in 0..50 {
        let (curve, _) = search(TARGET, "1..200", |robots, seed| {
            let random = Random::new(repeat).part(robots.into());
            let noise = (0..12).map(|draw| random.part(seed).unit(draw)).sum::<f64>() - 6.0;
            Ok(day(360.0 * 40.0 / f64::from(robots) + 1.5 * noise))
        });
        right += u32::from(found(&curve).is_some_and(|robots| (40..=42).contains(&robots)));
    }
    assert!(right >= 48, "{right} of 50");
}

#[test]
fn a_smaller_neighbour_that_meets_the_targets_is_the_answer() {
    // 16, 20 and 22 miss, 32, 24 and 23 meet; the neighbour 21 does, too.
    let (curve, _) = search(TARGET, "1..100", |robots, _| {
        Ok(day(if robots == 21 || robots >= 23 { 300.0 } else { 400.0 }))
    });
    assert_eq!(found(&curve), Some(21));
}

#[test]
fn a_target_that_no_fleet_meets_has_a_closest_one() {
    let (curve, _) =
        search(TARGET, "1..100", |robots, _| Ok(day(400.0 + (f64::from(robots) - 37.0).abs())));
    assert_eq!(found(&curve), None);
    let closest = curve.chosen().expect("the closest");
    assert!((35..=39).contains(&curve.points[closest].robots), "{:?}", curve.points[closest]);
}

/// One of four orders is late whatever the number of robots, and more robots finish a bit more an
/// hour.
#[test]
fn a_figure_that_is_exactly_at_its_limit_misses_it_and_the_fewest_robots_are_as_close() {
    let plant = |robots: u32, _| {
        let orders_per_hour = 40.0 + f64::from(robots);
        Ok(Measured { late: Some(0.25), orders_per_hour, ..day(60.0) })
    };
    for limit in ["late < 25%", "late < 20%"] {
        let (curve, _) = search(&[limit], "1..3", plant);
        assert_eq!((found(&curve), curve.chosen()), (None, Some(0)), "{limit}");
        let target = limit.parse().expect("a target");
        assert_eq!(standing(&target, &curve.points[0]), Standing::Missed, "{limit}");
    }
    assert_eq!(found(&search(&["late < 26%"], "1..3", plant).0), Some(1));
}

#[test]
fn robots_that_do_not_fit_end_the_search() {
    let plant = |limit: u32| {
        move |robots: u32, _| match robots {
            0..=60 => Ok(day(if robots >= limit { 300.0 } else { 400.0 })),
            _ => Err(RunFailure::NoRoom("60 fit".to_owned())),
        }
    };
    let (curve, _) = search(TARGET, "1..1000", plant(47));
    assert_eq!(found(&curve), Some(47));
    let (curve, _) = search(TARGET, "1..1000", plant(70));
    assert_eq!(found(&curve), None);
    let (curve, _) = search(TARGET, "1..8", |_, _| Err(RunFailure::Failed("broken".to_owned())));
    assert_eq!((curve.chosen(), curve.failed.len()), (None, 1));
}

#[test]
fn a_day_that_is_not_over_meets_nothing() {
    let (curve, _) = search(&["400 orders/h"], "4", |_, _| {
        Ok(Measured { end: RunEnd::Overdue, orders_per_hour: 500.0, ..day(1.0) })
    });
    assert_eq!(found(&curve), None);
    let (curve, _) =
        search(&["400 orders/h"], "4", |_, _| Ok(Measured { orders_per_hour: 500.0, ..day(1.0) }));
    assert_eq!(found(&curve), Some(4));
    let (curve, _) = search(TARGET, "4", |_, _| Ok(Measured { late: None, ..day(1.0) }));
    assert_eq!(found(&curve), None, "no order has a deadline");
}

#[test]
fn an_interval_that_contains_the_limit_gets_more_seeds() {
    let (curve, _) = search(TARGET, "5", |_, seed| Ok(day(355.0 + 10.0 * (seed % 2) as f64)));
    assert_eq!((found(&curve), curve.points[0].runs.len()), (None, 10));
    let (curve, _) = search(TARGET, "5", |_, seed| Ok(day(300.0 + seed as f64)));
    assert_eq!((found(&curve), curve.points[0].runs.len()), (Some(5), 3));
}
