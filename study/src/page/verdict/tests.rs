use regatta_layout::ReadOptions;

use super::*;
use crate::answer::TimeAnswer;
use crate::outcome::Measured;
use crate::page::caveats::caveats;
use crate::plan::{Plan, Precision, Question, RunTime, Variant};
use crate::sweep::tests::measured;
use crate::sweep::{Known, RunResult, Step, next};
use crate::workers::RunFailure;

const RING: &str = "id,x,y,role\nA,0,0,pick\nB,10,0,\nC,10,10,drop\n\nfrom,to\nA,B\nB,C\nC,A\n";

fn plan(robots: &str) -> Plan {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("ring.csv");
    std::fs::write(&path, RING).expect("written");
    Plan {
        title: "ring".to_owned(),
        robots: robots.parse().expect("robots"),
        question: Question::Knee,
        precision: Precision { least_seeds: 2, most_seeds: 2, ..Precision::default() },
        time: RunTime { secs: 1200, rate_hz: 10 },
        reliefs: 0,
        program: "0".to_owned(),
        variants: vec![Variant::read(&path, &ReadOptions::default()).expect("a variant")],
    }
}

/// The answer of a study of runs with a fate each.
fn answer(robots: &str, fate: impl Fn(u32, u64) -> RunResult) -> Answer {
    answer_to(plan(robots), fate)
}

fn answer_to(plan: Plan, fate: impl Fn(u32, u64) -> RunResult) -> Answer {
    let mut known = Known::new();
    let curve = loop {
        match next(&plan.question, &plan.robots, &plan.precision, &known) {
            Step::Done(curve) => break curve,
            Step::Needs(runs) => {
                known.extend(runs.into_iter().map(|run| (run, fate(run.0, run.1))))
            }
        }
    };
    let time = TimeAnswer::default();
    Answer::new(&plan, &[curve], &[known], &[None], Vec::new(), Vec::new(), time)
}

fn said(answer: &Answer) -> String {
    verdict(answer, &answer.variants[0])
}

/// A run with a stall.
fn stalled(kind: StallKind, robots: Vec<u32>, orders: f64) -> Measured {
    let stall = Stall {
        kind,
        from_secs: 1020.0,
        until_secs: None,
        robots,
        place: None,
        waits_for: Default::default(),
        places: Default::default(),
    };
    Measured { stalls: vec![stall], unserved: 9, ..measured(orders) }
}

#[test]
fn nothing_is_said_of_numbers_that_were_not_tried() {
    let said = said(&answer("1,2,4,8", |robots, seed| match (robots, seed) {
        (4, 1) => Ok(stalled(StallKind::Stuck, vec![3], 31.0)),
        (8, _) => Ok(stalled(StallKind::Standstill, (0..8).collect(), 0.0)),
        _ => Ok(measured(f64::from(robots) * 20.0)),
    }));
    assert_eq!(
        said,
        "2 robots, which carry 40.0 ± 1.0 orders an hour. With 4 robots, 1 of 2 runs doesn't \
         count: in it, one of 4 stood with an order from 17:00 min on while others drove, and 31 \
         orders were finished in 20 min. Neither this number nor a larger one that was tried is an \
         answer; 3 wasn't tried."
    );
    assert!(!said.contains("no larger fleet"));
}

#[test]
fn a_throughput_with_an_interval_beyond_it_is_not_known() {
    let said = said(&answer("1,2,4", |robots, seed| match (robots, seed) {
        (4, 1) => Ok(measured(40.0)),
        (4, _) => Ok(measured(4.0)),
        _ => Ok(measured(f64::from(robots) * 20.0)),
    }));
    let end = "With 4 robots, the orders an hour are not known (";
    assert!(said.contains(end) && !said.contains("it is less"), "{said}");
}

#[test]
fn a_range_says_what_larger_numbers_bring() {
    let said = said(&answer("1,2,3,4,8", |robots, _| match robots {
        8 => Ok(stalled(StallKind::Livelock, vec![0, 1], 5.0)),
        robots => Ok(measured(f64::from(robots.min(2)) * 20.0)),
    }));
    assert!(
        said.starts_with(
            "2 robots, which carry 40.0 ± 1.0 orders an hour. With 3 or 4, each further robot \
             brings on average less than 1 % of what one brings alone. With 8 robots, 2 of 2 runs \
             don't count: in the first of them, robots drove from 17:00 min on without any \
             arrival, and 5 orders"
        ),
        "{said}"
    );
    assert!(
        said.ends_with("This number isn't an answer; no number from 5 to 7 was tried."),
        "{said}"
    );
}

#[test]
fn without_a_number_that_counts_there_is_no_answer() {
    let fate = |_, _| Ok(stalled(StallKind::Standstill, vec![0], 1.0));
    let said = said(&answer("1,2", fate));
    assert_eq!(
        said,
        "not known. With 1 robot, 2 of 2 runs don't count: in the first of them, all robots with orders \
         stood from 17:00 min on, and 1 order was finished in 20 min. No number of robots that was \
         tried is an answer."
    );
}

#[test]
fn a_lack_of_room_is_no_failure() {
    let said = said(&answer("2,4", |robots, _| match robots {
        4 => Err(RunFailure::NoRoom("3 of 4 robots fit".to_owned())),
        robots => Ok(measured(f64::from(robots) * 20.0)),
    }));
    assert_eq!(
        said,
        "2 robots, which carry 40.0 ± 1.0 orders an hour. There is no room for 4 robots: 3 of 4 \
         robots fit."
    );
}

#[test]
fn the_least_of_a_list_is_that_of_the_list() {
    let said = |robots: &str| {
        let target = "40 orders/h".parse().expect("a target");
        let plan = Plan { question: Question::Least(vec![target]), ..plan(robots) };
        said(&answer_to(plan, |robots, _| Ok(measured(f64::from(robots) * 20.0))))
    };
    let (list, neighbours, none) = (said("1,4"), said("1,2,3"), said("1"));
    assert!(
        list.starts_with("4 robots: the least of the numbers that were tried that meet the"),
        "{list}"
    );
    assert!(neighbours.starts_with("3 robots: the least that meet the targets"), "{neighbours}");
    assert!(
        none.starts_with("none of the numbers that were tried, up to 1 robot, meets the targets"),
        "{none}"
    );
}

#[test]
fn late_orders_are_those_of_runs_that_count() {
    let late = answer("1,2,4", |robots, _| match robots {
        4 => Ok(stalled(StallKind::Standstill, vec![0], 0.0)),
        robots => Ok(Measured { unserved: 1, ..measured(f64::from(robots) * 20.0) }),
    });
    let late: Vec<String> =
        caveats(&late).into_iter().filter(|caveat| caveat.contains("Late")).collect();
    assert_eq!(
        late,
        ["**Late orders** waited for over 20 minutes, or weren't finished in that time: with 1 \
             robot, 2 orders; with 2 robots, 2 orders."]
    );
}

#[test]
fn an_unknown_throughput_has_no_table_of_numbers() {
    let few = answer("1", |_, _| Ok(measured(1.0)));
    assert!(said(&few).starts_with("not known: 1 robot finished 1.0 orders in a run"));
    assert_eq!(numbers(&few.variants[0]), None);
}
