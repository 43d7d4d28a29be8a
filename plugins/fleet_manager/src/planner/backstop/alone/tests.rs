//! The search for the way of one robot against breadth-first search.

use proptest::prelude::*;

use super::Search;
use crate::planner::backstop::lacam::tests::{is_solvable, problem};
use crate::planner::backstop::lacam::{Outcome, Problem, Way};

/// Ways between neighbours on a line of stands.
fn line(stands: u16) -> Vec<Vec<Way>> {
    let way = |to: u16| Way { to, blocked_by: vec![to], secs: 1.0 };
    let neighbours = |stand: u16| [stand.checked_sub(1), Some(stand + 1).filter(|to| *to < stands)];
    (0..stands).map(|stand| neighbours(stand).into_iter().flatten().map(way).collect()).collect()
}

/// A line of seven stands, from the middle one of which a bay leads off.
fn line_with_bay() -> Vec<Vec<Way>> {
    let mut ways = line(7);
    ways[3].push(Way { to: 7, blocked_by: vec![7], secs: 1.0 });
    ways.push(vec![Way { to: 3, blocked_by: vec![3], secs: 1.0 }]);
    ways
}

fn solve(problem: Problem) -> Outcome {
    Search::new(problem).advance(1_000_000)
}

#[test]
fn robots_pass_each_other_at_a_bay_and_never_on_a_line() {
    let problem = |ways| Problem {
        ways,
        starts: vec![1, 5, 4],
        targets: vec![vec![6], Vec::new(), Vec::new()],
    };
    let Outcome::Found(hops) = solve(problem(line_with_bay())) else { panic!("a way") };
    assert_eq!(problem(line_with_bay()).follow(&hops).map(|at| at[0]), Some(6));
    assert_eq!(solve(problem(line(7))), Outcome::None);
}

proptest! {
    #[test]
    fn it_finds_a_way_if_there_is_one(mut problem in problem(), agent in 0_usize..2) {
        let targets = problem.targets[agent].clone();
        prop_assume!(!targets.is_empty());
        problem.targets.iter_mut().for_each(Vec::clear);
        problem.targets[agent] = targets.clone();
        match solve(problem.clone()) {
            Outcome::Found(hops) => {
                let at = problem.follow(&hops).expect("possible hops");
                prop_assert!(targets.contains(&at[agent]));
            }
            outcome => {
                prop_assert_eq!(outcome, Outcome::None);
                prop_assert!(!is_solvable(&problem));
            }
        }
    }
}
