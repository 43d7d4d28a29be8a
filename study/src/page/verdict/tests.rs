use regatta_layout::ReadOptions;

use super::*;
use crate::answer::Chosen;
use crate::outcome::{CHARGING, Measured, ROBOT_PARTS};
use crate::page::assumptions::robots;
use crate::page::caveats::caveats;
use crate::page::content::content;
use crate::plan::{Plan, Precision, Question, RunTime, Variant};
use crate::relief::{Candidate, Measure, Relief, Reliefs, Remedy, Verdict};
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
        inputs: Vec::new(),
        prices: None,
        program: "0".to_owned(),
        variants: vec![Variant::read(&path, &ReadOptions::default()).expect("a variant")],
    }
}

/// The plan of a scenario on the ring.
fn plan_of(robots: &str, scenario: &str) -> Plan {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("ring.csv"), RING).expect("written");
    let path = folder.path().join("scenario.yaml");
    std::fs::write(&path, format!("graph: ring.csv\n{scenario}")).expect("written");
    let variants = vec![Variant::read(&path, &ReadOptions::default()).expect("a variant")];
    Plan { variants, ..plan(robots) }
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
    Answer::new(&plan, &[curve], &[known], &[None], Chosen::default())
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
        seen_secs: None,
        waits_for: Default::default(),
        places: Default::default(),
        edges: Default::default(),
        out_of_service: Vec::new(),
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
        "the plant holds 2 robots, which carry 40.0 ± 1.0 orders an hour. With 4 robots, 1 of 2 runs \
         doesn't count: in it, one of 4 stood with an order from 17:00 min on while others drove, and 31 \
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
fn fewer_orders_within_chance_are_no_fact() {
    let said = |orders: [f64; 2]| {
        said(&answer("1,2,4", |robots, seed| match robots {
            4 => Ok(measured(orders[seed as usize - 1])),
            _ => Ok(measured(f64::from(robots) * 20.0)),
        }))
    };
    // 40.0 ± 1.0 with 2 robots; 19.9 and 20.1 are 20.0 ± 1.3, and 28 and 32 are 30.0 ± 25.4.
    let clear = said([19.9, 20.1]);
    assert!(clear.contains("With 4 robots, it is less: 20.0 ± 1."), "{clear}");
    let chance = said([28.0, 32.0]);
    assert!(chance.contains("With 4 robots, 30.0 ± 25.4 orders an hour were measured"), "{chance}");
    assert!(chance.contains("may be chance") && !chance.contains("it is less"), "{chance}");
}

#[test]
fn a_range_says_what_larger_numbers_bring() {
    let said = said(&answer("1,2,3,4,8", |robots, _| match robots {
        8 => Ok(stalled(StallKind::Livelock, vec![0, 1], 5.0)),
        robots => Ok(measured(f64::from(robots.min(2)) * 20.0)),
    }));
    assert!(
        said.starts_with(
            "the plant holds 2 robots, which carry 40.0 ± 1.0 orders an hour. With 3 or 4, each further robot \
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
fn runs_keep_their_seeds_beside_seeds_without_room() {
    let answer = answer("8", |_, seed| match seed {
        1 => Err(RunFailure::NoRoom("7 of 8 robots fit".to_owned())),
        _ => Ok(stalled(StallKind::Standstill, vec![0], 1.0)),
    });
    let caveats = caveats(&answer).join("\n");
    assert!(caveats.contains("With 8 robots, seed 2: all robots"), "{caveats}");
    let texts: Vec<String> = blocks(&answer).into_iter().filter_map(text_of).collect();
    let room = "With 8 robots, not all found a place with seed 1: 7 of 8 robots fit.";
    assert!(texts.iter().any(|text| text == room), "{texts:?}");
}

#[test]
fn fewer_robots_than_those_that_stalled_have_a_reason() {
    let said = said(&answer("1,2", |robots, _| match robots {
        1 => Ok(Measured { finished_orders: 1, ..measured(0.0) }),
        _ => Ok(stalled(StallKind::Standstill, vec![0], 1.0)),
    }));
    let start = "the number of robots that the plant holds isn't known. 1 robot finished 2 orders in 2 \
                 runs, too few for a figure. With 2 robots, ";
    assert!(said.starts_with(start), "{said}");
}

#[test]
fn orders_of_the_warm_up_alone_are_no_throughput() {
    let fate = |finished_orders| {
        answer("1,2", move |robots, _| {
            let orders = f64::from(robots - 1) * 20.0;
            Ok(Measured { finished_orders, ..measured(orders) })
        })
    };
    let figure = |answer: &Answer| orders_in_words(&answer.variants[0].points[0]);
    assert_eq!(figure(&fate(1)).as_deref(), Some("not known"));
    assert_eq!(figure(&fate(0)).as_deref(), Some("0.0 ± 0.0"));
    let few = answer("1", |_, _| Ok(Measured { finished_orders: 2, ..measured(4.0) }));
    assert_eq!(figure(&few).as_deref(), Some("not known"), "as the answer says");
}

#[test]
fn the_words_of_another_program_end_no_sentence() {
    let failed = answer("1", |_, _| Err(RunFailure::Failed("see --help.".to_owned())));
    let said = verdict(&failed, &failed.variants[0]);
    assert_eq!(said, "no run has succeeded: see --help.");
}

#[test]
fn the_load_is_the_limit_only_if_all_of_it_is_carried() {
    let limit = |utilisation, open_orders, charging| {
        let plan = plan_of(
            "2",
            "robots: [{count: 1, routes: none}]\n\
             load: {per_hour: 60, from: pick, to: drop}\n",
        );
        let answer = answer_to(plan, |_, _| {
            let mut robot_time = [0.0; ROBOT_PARTS.len()];
            let rest = [(CHARGING, charging), ("idle", 1.0 - utilisation - charging)];
            for (time, name) in robot_time.iter_mut().zip(ROBOT_PARTS) {
                *time = rest.iter().find(|part| part.0 == name).map_or(0.0, |part| part.1);
            }
            let run = measured(60.0);
            let robot_time = Some(robot_time);
            Ok(Measured { utilisation, finished_orders: 18, open_orders, robot_time, ..run })
        });
        caveats(&answer).join("\n")
    };
    assert!(limit(0.31, 1, 0.42).contains("**The load is the limit**: 2 robots had an order 31 %"));
    assert!(limit(0.9, 1, 0.0).contains("**The load is the limit**: 2 robots had an order 90 %"));
    assert!(!limit(0.9, 2, 0.0).contains("is the limit"), "more orders wait than the robots carry");
    let charging = limit(0.31, 9, 0.42);
    assert!(
        charging.contains(
            "**Charging is the limit**: 2 robots had an order 31 % of the time and charged 42 %"
        ),
        "{charging}"
    );
    assert!(limit(0.31, 9, 0.0).contains("**Orders waited**: 2 robots"));
}

#[test]
fn what_the_layout_allows_names_its_robots_and_what_was_assumed_of_it() {
    let types = "robot_types: [{name: small, length: 0.5, width: 0.4, max_speed: 1}, {name: large, \
                 length: 1.2, width: 0.8, max_speed: 1}]\n";
    let page = |robots: &str| {
        let plan = plan_of("1,2", &format!("{types}robots: [{robots}]\n"));
        let answer = answer_to(plan, |robots, _| Ok(measured(f64::from(robots) * 20.0)));
        (crate::page::markdown(&blocks(&answer)), caveats(&answer).join("\n"))
    };
    let small = "{count: 1, type: small, routes: none}";
    let (both, assumed) = page(&format!("{small}, {{count: 1, type: large, routes: none}}"));
    let row = "3 nodes and 3 edges. For robots of type `large`: ";
    assert!(both.contains(row) && both.contains("For robots of type `small`: "), "{both}");
    assert!(!page(small).0.contains("For robots of type"), "{}", page(small).0);
    let speeds = "**Assumed about the layout**: 3 edges have no speed limit: 1 m/s is used";
    assert!(assumed.contains(speeds), "{assumed}");
}

#[test]
fn all_robot_types_are_named_with_their_numbers() {
    let plan = plan_of(
        "8",
        "robot_types:\n- {name: cart, length: 0.6, width: 0.4, max_speed: 1}\n\
         - {name: lorry, length: 1.6, width: 1}\n- {name: disc, shape: circle, length: 0.7}\n\
         robots:\n- {count: 2, routes: none, type: cart}\n\
         - {count: 1, routes: none, type: lorry}\n- {count: 1, routes: none, type: disc}\n",
    );
    let answer = answer_to(plan, |_, _| Ok(measured(200.0)));
    assert_eq!(
        robots(&answer.variants[0]),
        "4 `cart` (0.6 m × 0.4 m, up to 1 m/s), 2 `lorry` (1.6 m × 1 m, as fast as the roads \
         allow), 2 `disc` (round, 0.7 m, as fast as the roads allow), with 8 robots"
    );
}

/// The blocks of the page of an answer.
fn blocks(answer: &Answer) -> Vec<Block> {
    content(answer, &plan("1").variants[0], "regatta study ring.csv")
}

fn text_of(block: Block) -> Option<String> {
    match block {
        Block::Text(text) => Some(text),
        _ => None,
    }
}

#[test]
fn without_a_number_that_counts_there_is_no_answer() {
    let fate = |_, _| Ok(stalled(StallKind::Standstill, vec![0], 1.0));
    let said = said(&answer("1,2", fate));
    assert_eq!(
        said,
        "the number of robots that the plant holds isn't known. With 1 robot, 2 of 2 runs don't count: in the first of them, all robots with orders \
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
        "the plant holds at least 2 robots, which carry 40.0 ± 1.0 orders an hour. With 4 robots, not all found a place: \
         3 of 4 robots fit; 3 wasn't tried."
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
    assert!(said(&few).contains("isn't known: 1 robot finished 1.0 orders in a run"));
    assert_eq!(numbers(&few.variants[0], ""), None);
}

#[test]
fn runs_of_other_numbers_that_failed_were_tried() {
    let answer = answer("1,2,4", |robots, _| match robots {
        4 => Ok(measured(80.0)),
        _ => Err(RunFailure::Failed("no robot type has the name `slow`".to_owned())),
    });
    let said = said(&answer);
    assert!(said.ends_with("All runs with other numbers of robots failed."), "{said}");
    let caveats = caveats(&answer).join("\n");
    assert!(caveats.contains("with 1, 2 robots, runs failed, the first one because: no"));
}

#[test]
fn runs_of_the_bound_are_not_among_those_that_were_judged() {
    let plan = plan("1,2");
    let bound = plan.variants[0].clone().bound();
    let both = Plan { variants: vec![plan.variants[0].clone(), bound], ..plan };
    let mut known = Known::new();
    for run in [(1, 1), (1, 2), (2, 1), (2, 2)] {
        known.insert(run, Ok(measured(f64::from(run.0) * 20.0)));
    }
    let Step::Done(curve) = next(&both.question, &both.robots, &both.precision, &known) else {
        panic!("all runs are known");
    };
    let (curves, known) = ([curve.clone(), curve], [known.clone(), known]);
    let answer = Answer::new(&both, &curves, &known, &[None, None], Chosen::default());
    let said = crate::page::caveats::safety(&answer);
    assert!(said.contains("No robot touched another in 4 runs"), "{said}");
    assert!(said.contains("The 4 runs of the bound aren't judged"), "{said}");
}

#[test]
fn the_page_begins_with_a_sentence_that_tells_an_open_end_plainly() {
    let all_carry = |robots, _| Ok(measured(f64::from(robots) * 20.0));
    let first = blocks(&answer("1,2", all_carry)).into_iter().find_map(|block| match block {
        Block::Answer(text) => Some(text),
        _ => None,
    });
    let start = "The plant holds at least 2 robots, the largest number tried and the one that \
                 carries the most: 40.0 ";
    let first = first.expect("an answer");
    assert!(first.starts_with(start), "{first}");
}

#[test]
fn the_head_of_the_page_says_that_no_change_helps() {
    let tried = ["a second place at B", "a passing place"].map(|words| Relief {
        candidate: Candidate {
            remedy: Remedy::Repair,
            words: words.to_owned(),
            about: "waiting",
            robots: 1.0,
        },
        gain: None,
        verdict: Verdict::WithinChance,
        has_left: false,
        failure: None,
    });
    let mut answer = answer("1,2", |robots, _| Ok(measured(f64::from(robots) * 20.0)));
    answer.chosen.reliefs = Some(Reliefs {
        robots: 2,
        figure: "orders an hour".to_owned(),
        base: 40.0,
        tried: tried.to_vec(),
        others: Vec::new(),
        measure: Measure::Throughput,
    });
    let found = blocks(&answer).into_iter().any(|block| {
        matches!(block, Block::Finding(text) if text == "None of the 2 changes that were tried helps.")
    });
    assert!(found, "the terminal shows findings");
}
