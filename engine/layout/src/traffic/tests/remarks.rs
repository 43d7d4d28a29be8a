//! The lines of certificates about layouts whose traffic is plain to see.

use crate::traffic::{Certificate, RobotType, Turning};
use crate::{ReadOptions, parse};

/// The lines about a layout in the format CSV.
fn lines(text: &str) -> Vec<String> {
    let (graph, _) = parse(text, "plant.csv", &ReadOptions::default()).expect("a layout");
    let certificate = Certificate::new(&graph, &RobotType::default());
    let remarks = certificate.remarks(&graph).into_iter();
    remarks.map(|remark| format!("{}: {}", remark.topic.name(), remark.message)).collect()
}

/// Asserts that one line begins with a text and has all others in it.
fn assert_line(lines: &[String], start: &str, others: &[&str]) {
    let found = lines
        .iter()
        .any(|line| line.starts_with(start) && others.iter().all(|other| line.contains(other)));
    assert!(found, "{start} … {others:?} in {lines:#?}");
}

#[test]
fn a_corridor_between_two_halls_is_a_section() {
    let lines = lines(
        "id,x,y\nW1,0,0\nW2,0,6\nW,3,3\nM,10,3\nE,17,3\nE1,20,0\nE2,20,6\n\nfrom,to,speed\n\
         W1,W2,1\nW2,W,1\nW,W1,1\nW,M,1\nM,W,1\nM,E,1\nE,M,1\nE,E1,1\nE1,E2,1\nE2,E,1\n",
    );
    assert_line(
        &lines,
        "section: single track of 14.0 m between `W`, `E`",
        &["1 robot at its nodes, 14 in line", "add a passing place"],
    );
    assert_line(&lines, "ring: 2 robots may wait for each other at", &["such as"]);
    assert_line(&lines, "ring: 3 robots at", &["each waits for the next one"]);
}

#[test]
fn a_dock_on_the_road_cuts_the_end_off() {
    let lines = lines(
        "id,x,y,role\nA,0,0,\nB,5,0,pick\nC,10,0,\nD,15,0,\n\nfrom,to,speed\n\
         A,B,1\nB,A,1\nB,C,1\nC,B,1\nC,D,1\nD,C,0.001\n",
    );
    assert_line(&lines, "station: a robot at the station `B` blocks", &["no way leads from"]);
    assert_line(&lines, "slow: edge 6 is driven at 0.001 m/s", &["1 h 23 min", "check the speed"]);
    assert_line(&lines, "section: single track of 15.0 m without a passing place", &[]);
}

#[test]
fn an_island_and_a_trap_are_named_with_their_stations() {
    let lines = lines(
        "id,x,y,role\nA,0,0,\nB,9,0,\nC,9,9,\nTrap,20,9,drop\nI,50,0,pick\nJ,60,0,\n\n\
         from,to,speed\nA,B,1\nB,C,1\nC,A,1\nC,Trap,1\nI,J,1\nJ,I,1\n",
    );
    assert_line(&lines, "part: 1 node (`Trap`), with the stations `Trap` can't be left", &[]);
    assert_line(&lines, "part: 2 nodes (`I`, `J`), with the stations `I` can't be reached", &[]);
    assert_line(&lines, "under-way: at most 2 robots of the main part can be", &["(a bound)"]);
}

#[test]
fn a_robot_beside_another_road_is_in_the_way() {
    let lines = lines(
        "id,x,y\nA,0,0\nB,10,0\nC,5,0.5\nD,5,8\n\nfrom,to,speed\n\
         A,B,1\nB,A,1\nC,D,1\nD,C,1\n",
    );
    assert_line(&lines, "in-the-way: a robot at node `C` touches robots on edges 1, 2", &[]);
}

#[test]
fn robots_have_sizes_within_a_range() {
    for (length, width) in [(0.0, 0.6), (0.9, f64::NAN), (f64::INFINITY, 0.6), (0.9, 21.0)] {
        let error = RobotType::new(length, width, Turning::Never).expect_err("out of range");
        assert!(error.to_string().contains("must be 0.01 to 20"), "{error}");
    }
    assert!(RobotType::new(0.01, 20.0, Turning::Never).is_ok());
}

#[test]
fn a_road_on_another_floor_is_in_nobodys_way() {
    let plant = |upper: &str| {
        format!(
            "id,x,y,level\nA,0,0,L1\nB,9,0,L1\nC,4.5,-5,{upper}\nD,4.5,0.2,{upper}\n\n\
             from,to,speed\nA,B,1\nB,A,1\nC,D,1\nD,C,1\n"
        )
    };
    let is_in_way = |line: &String| line.starts_with("in-the-way");
    assert!(lines(&plant("L1")).iter().any(is_in_way), "{:#?}", lines(&plant("L1")));
    assert!(!lines(&plant("L2")).iter().any(is_in_way), "{:#?}", lines(&plant("L2")));
}
