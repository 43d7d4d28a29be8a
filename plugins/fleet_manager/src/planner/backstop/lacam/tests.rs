//! LaCAM against breadth-first search over all configurations.

use std::collections::{BTreeSet, VecDeque};

use proptest::prelude::*;

use super::{Hop, Outcome, Problem, Search, Way, shorten};

/// Whether all agents can get to their targets, one hop after the other.
pub fn is_solvable(problem: &Problem) -> bool {
    let is_goal = |at: &[u16]| {
        at.iter()
            .zip(&problem.targets)
            .all(|(stand, targets)| targets.is_empty() || targets.contains(stand))
    };
    let mut known = BTreeSet::from([problem.starts.clone()]);
    let mut open = VecDeque::from([problem.starts.clone()]);
    while let Some(at) = open.pop_front() {
        if is_goal(&at) {
            return true;
        }
        for agent in 0..at.len() {
            let from = Problem { starts: at.clone(), ..problem.clone() };
            for way in 0..problem.ways[usize::from(at[agent])].len() as u16 {
                let hop = Hop { agent: agent as u16, from: at[agent], way };
                if let Some(next) = from.follow(&[hop])
                    && known.insert(next.clone())
                {
                    open.push_back(next);
                }
            }
        }
    }
    false
}

/// A problem on a few stands: ways from some to others, some of which pass near a third one.
pub fn problem() -> impl Strategy<Value = Problem> {
    let ways = prop::collection::vec(
        (0_u16..7, 0_u16..7, prop::option::weighted(0.3, 0_u16..7), 1_u8..5),
        4..18,
    );
    let agents = Just((0_u16..7).collect::<Vec<u16>>()).prop_shuffle();
    let targets = prop::collection::vec(prop::option::weighted(0.8, 0_u16..7), 4);
    (ways, 2_usize..5, agents, targets).prop_map(|(list, count, starts, targets)| {
        let mut ways = vec![Vec::new(); 7];
        for (from, to, near, secs) in list {
            let mut blocked_by: Vec<u16> =
                near.into_iter().filter(|near| *near != from).chain([to]).collect();
            blocked_by.sort_unstable();
            blocked_by.dedup();
            if from != to {
                ways[usize::from(from)].push(Way { to, blocked_by, secs: f32::from(secs) });
            }
        }
        let targets =
            targets.into_iter().take(count).map(|target| target.into_iter().collect()).collect();
        Problem { ways, starts: starts[..count].to_vec(), targets }
    })
}

fn solve(problem: &Problem) -> (Outcome, u64) {
    let mut search = Search::new(problem.clone());
    // In parts, as between frames.
    let mut outcome = Outcome::Open;
    while outcome == Outcome::Open && search.work() < 5_000_000 {
        outcome = search.advance(1_000);
    }
    (outcome, search.work())
}

fn is_solution(problem: &Problem, hops: &[Hop]) -> bool {
    let Some(at) = problem.follow(hops) else { return false };
    at.iter()
        .zip(&problem.targets)
        .all(|(stand, targets)| targets.is_empty() || targets.contains(stand))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn a_solution_is_found_whenever_there_is_one(problem in problem()) {
        match solve(&problem).0 {
            Outcome::Found(hops) => {
                prop_assert!(is_solution(&problem, &hops), "{:?}", hops);
                let shorter = shorten(&problem, hops.clone());
                prop_assert!(shorter.len() <= hops.len() && is_solution(&problem, &shorter), "{:?}", shorter);
            }
            Outcome::None => prop_assert!(!is_solvable(&problem)),
            Outcome::Open => prop_assert!(false, "it takes too long"),
        }
    }
}

/// A grid on which each cell is a stand, with ways to its neighbours.
fn grid(side: u16) -> Vec<Vec<Way>> {
    let way = |to: u16| Way { to, blocked_by: vec![to], secs: 1.0 };
    let cell = |column: u16, row: u16| row * side + column;
    let ways = |stand: u16| {
        let (column, row) = (stand % side, stand / side);
        let columns = [column.checked_sub(1), Some(column + 1).filter(|&next| next < side)];
        let rows = [row.checked_sub(1), Some(row + 1).filter(|&next| next < side)];
        let across = columns.into_iter().flatten().map(|next| way(cell(next, row)));
        across.chain(rows.into_iter().flatten().map(|next| way(cell(column, next)))).collect()
    };
    (0..side * side).map(ways).collect()
}

#[test]
fn forty_robots_on_a_grid_of_64_cells_all_get_to_the_opposite_side() {
    let starts: Vec<u16> = (0..40).collect();
    let targets = starts.iter().map(|start| vec![63 - start]).collect();
    let problem = Problem { ways: grid(8), starts, targets };
    let (outcome, work) = solve(&problem);
    let Outcome::Found(hops) = outcome else { panic!("{work} choices: {outcome:?}") };
    assert!(is_solution(&problem, &hops));
    println!(
        "{} hops, {} in short; {work} choices",
        hops.len(),
        shorten(&problem, hops.clone()).len()
    );
}

#[test]
fn a_loop_that_nobody_needs_is_left_out() {
    let problem = Problem { ways: grid(3), starts: vec![0, 8], targets: vec![vec![0], vec![7]] };
    let hop = |agent: u16, from: u16, to: u16| {
        let way =
            problem.ways[usize::from(from)].iter().position(|way| way.to == to).expect("a way");
        Hop { agent, from, way: way as u16 }
    };
    let hops = vec![hop(0, 0, 1), hop(1, 8, 7), hop(0, 1, 4), hop(0, 4, 1), hop(0, 1, 0)];
    assert_eq!(shorten(&problem, hops), [hop(1, 8, 7)]);
}
