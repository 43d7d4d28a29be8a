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
    assert_line(&lines, "ring: 1 robot alone is safe", &["2 or more may"]);
}

#[test]
fn a_spur_is_no_part_of_the_way_between_two_halls() {
    let lines = lines(
        "id,x,y\nW1,0,0\nW2,0,6\nW,3,3\nM,10,3\nS,10,3.4\nE,17,3\nE1,20,0\nE2,20,6\n\n\
         from,to,speed\nW1,W2,1\nW2,W,1\nW,W1,1\nW,M,1\nM,W,1\nM,S,1\nS,M,1\nM,E,1\nE,M,1\n\
         E,E1,1\nE1,E2,1\nE2,E,1\n",
    );
    assert_line(
        &lines,
        "section: single track of 14.0 m between `W`, `E`, and 0.4 m beside it: ",
        &["two robots can't pass each other on its tracks", "it holds 1 robot at its nodes; let"],
    );
}

#[test]
fn a_dock_on_the_road_cuts_the_end_off() {
    let lines = lines(
        "id,x,y,role\nA,0,0,\nB,5,0,pick\nC,10,0,\nD,15,0,\n\nfrom,to,speed\n\
         A,B,1\nB,A,1\nB,C,1\nC,B,1\nC,D,1\nD,C,0.001\n",
    );
    assert_line(&lines, "station: a robot at the station `B` blocks", &["no way leads from"]);
    assert_line(&lines, "slow: edge 6 is driven at 0.001 m/s", &["1 h 23 min", "check the speed"]);
    assert_line(&lines, "section: single track of 10.0 m without a passing place", &[]);
}

#[test]
fn an_island_and_a_trap_are_named_with_their_stations() {
    let lines = lines(
        "id,x,y,role\nA,0,0,\nB,9,0,\nC,9,9,\nTrap,20,9,drop\nI,50,0,pick\nJ,60,0,\n\n\
         from,to,speed\nA,B,1\nB,C,1\nC,A,1\nC,Trap,1\nI,J,1\nJ,I,1\n",
    );
    assert_line(&lines, "part: 1 node (`Trap`), with the station `Trap`, without a way back", &[]);
    assert_line(
        &lines,
        "part: 2 nodes (`I`, `J`), with the station `I`, without a way from or to the main part",
        &[],
    );
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
fn a_robot_that_turns_beside_another_road_is_in_the_way() {
    // It stands 0.6 m from the road with half of its width, and turns with half of its diagonal.
    let plant = |end: &str| {
        format!(
            "id,x,y\nA,0,0\nB,10,0\nC,5,0.8\nD,0,0.8\nE,{end}\n\nfrom,to,speed\n\
             A,B,1\nB,A,1\nD,C,1\nC,E,1\n"
        )
    };
    let turning = lines(&plant("5,9"));
    assert_line(&turning, "in-the-way: a robot that turns at node `C` touches", &["edges 1, 2"]);
    let straight = lines(&plant("9,0.8"));
    assert!(!straight.iter().any(|line| line.contains("at node `C` touches")), "{straight:#?}");
}

#[test]
fn robots_have_sizes_within_a_range() {
    for (length, width) in [(0.0, 0.6), (0.9, f64::NAN), (f64::INFINITY, 0.6), (0.9, 101.0)] {
        let error = RobotType::new(length, width, Turning::Never).expect_err("out of range");
        assert!(error.to_string().contains("must be 0.001 to 100"), "{error}");
    }
    assert!(RobotType::new(0.001, 100.0, Turning::Never).is_ok());
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

/// A square of four nodes, driven in one direction, with a section `Zones`.
fn ring_with_zone(rule: &str) -> String {
    let node = |id: u32, x: f64, y: f64| format!("- {{Id: {id}, X: {x}, Y: {y}, Theta: 0}}\n");
    let edge = |id: u32, from: u32, to: u32| {
        format!(
            "- {{Id: {id}, Origin_ID: {from}, Destination_ID: {to}, CurveType: Linear, \
             VelocityForward: 1}}\n"
        )
    };
    format!(
        "Vertices:\n{}{}{}{}Edges:\n{}{}{}{}{rule}",
        node(1, 0.0, 0.0),
        node(2, 10.0, 0.0),
        node(3, 10.0, 10.0),
        node(4, 0.0, 10.0),
        edge(1, 1, 2),
        edge(2, 2, 3),
        edge(3, 3, 4),
        edge(4, 4, 1),
    )
}

#[test]
fn nothing_is_called_safe_that_a_zone_stops() {
    let said = |zones: &str| lines(&ring_with_zone(zones));
    assert_line(&said(""), "ring: up to 3 robots at nodes never all wait", &["nothing to fix"]);
    let block = said("Zones:\n- {Name: Block, Capacity: 1, Edges: [1, 2, 3, 4]}\n");
    assert_line(&block, "zone: 1 zone (`Block`: 1 robot) lets fewer robots in", &["bounds"]);
    assert_line(&block, "under-way: at most 3 robots", &["(a bound: zones may allow fewer)"]);
    assert!(!block.iter().any(|line| line.contains("never all wait")), "{block:#?}");
    let both =
        ["2 or more may wait for each other there; without zones, it takes 4 robots or more"];
    assert_line(&block, "ring: 1 robot alone is safe with the zones", &both);
    let block = said("Zones:\n- {Name: Block, Capacity: 2, Edges: [1, 2, 3, 4]}\n");
    assert_line(&block, "ring: up to 2 robots at nodes never all wait", &["more may wait at"]);
    assert!(!block.iter().any(|line| line.contains("nothing to fix")), "{block:#?}");
}

#[test]
fn a_ring_that_a_zone_never_lets_close_is_told_as_such() {
    let said = |zones: &str| lines(&ring_with_zone(zones));
    let nodes = said("Zones:\n- {Name: Block, Capacity: 3, Nodes: [1, 2, 3, 4]}\n");
    assert_line(&nodes, "ring: 4 robots at 1, 2, 3, 4 would close a ring", &["`Block`: 3 robots"]);
    assert!(!nodes.iter().any(|line| line.contains("each waits for")), "{nodes:#?}");
    let some = said("Zones:\n- {Name: Block, Capacity: 3, Nodes: [1, 2, 3]}\n");
    assert_line(&some, "ring: 4 robots at 1, 2, 3, 4 close a ring", &[]);
    assert!(!some.iter().any(|line| line.starts_with("zone")), "all fit: {some:#?}");
}

#[test]
fn robots_that_a_zone_keeps_apart_do_not_wait_for_each_other() {
    let road = "Vertices:\n- {Id: 1, X: 0, Y: 0, Theta: 0}\n- {Id: 2, X: 10, Y: 0, Theta: 0}\n\
                Edges:\n- {Id: 1, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, \
                VelocityForward: 1, VelocityBackwards: 1}\n";
    assert_line(&lines(road), "ring: 2 robots may wait for each other at 1 pair", &[]);
    let zoned = lines(&format!("{road}Zones:\n- {{Name: Z, Capacity: 1, Nodes: [1, 2]}}\n"));
    assert!(!zoned.iter().any(|line| line.contains("may wait for each other at")), "{zoned:#?}");
    assert_line(&zoned, "zone: 1 zone (`Z`: 1 robot)", &["at 1 pair of nodes two robots would"]);
}

#[test]
fn a_zone_makes_the_room_of_a_section_a_bound() {
    let node = |id: u32| format!("- {{Id: {id}, X: {}, Y: 0, Theta: 0}}\n", 10 * id);
    let edge = |id: u32| {
        format!(
            "- {{Id: {id}, Origin_ID: {id}, Destination_ID: {}, CurveType: Linear, \
             VelocityForward: 1, VelocityBackwards: 1}}\n",
            id + 1
        )
    };
    let road =
        format!("Vertices:\n{}{}{}Edges:\n{}{}", node(1), node(2), node(3), edge(1), edge(2));
    let zoned = format!("{road}Zones:\n- {{Name: Door, Rule: same_direction, Edges: [1, 2]}}\n");
    assert_line(&lines(&road), "section: ", &["it holds 3 robots at its nodes"]);
    assert_line(&lines(&zoned), "section: ", &["it holds at most 3 robots at its nodes"]);
    assert_line(&lines(&zoned), "zone: 1 zone (`Door`: one direction at a time)", &[]);
}

#[test]
fn on_a_ring_robots_exchange_places_by_going_round() {
    let ring = "id,x,y\n1,0,0\n2,10,0\n3,10,10\n4,0,10\n\nfrom,to,speed\n\
                1,2,1\n2,1,1\n2,3,1\n3,2,1\n3,4,1\n4,3,1\n4,1,1\n1,4,1\n";
    let said = lines(ring);
    assert_line(
        &said,
        "section: single track of 40.0 m in all",
        &["places only by driving round it"],
    );
    assert!(!said.iter().any(|line| line.contains("ever pass")), "{said:#?}");
    let path = lines("id,x,y\n1,0,0\n2,9,0\n3,18,0\n\nfrom,to,speed\n1,2,1\n2,1,1\n2,3,1\n3,2,1\n");
    assert_line(&path, "section: single track of 18.0 m", &["no two robots can ever pass"]);
}

#[test]
fn a_trap_beside_a_road_changes_no_section() {
    let road = "id,x,y\nA,0,0\nB,10,0\nC,20,0\nT,10,9\n\nfrom,to,speed\n\
                A,B,1\nB,A,1\nB,C,1\nC,B,1\n";
    let is_section = |line: &String| line.starts_with("section") || line.starts_with("dead-end");
    let sections =
        |text: &str| -> Vec<String> { lines(text).into_iter().filter(is_section).collect() };
    let alone = sections(road);
    assert_eq!(alone.len(), 1);
    assert!(alone[0].contains("no two robots can ever pass"), "{alone:?}");
    assert_eq!(sections(&format!("{road}B,T,1\n")), alone);
}

#[test]
fn a_loop_at_its_end_is_no_dead_end() {
    let said = lines(
        "id,x,y\nA,0,0\nB,6,0\nC,3,4\nD,10,0\nE,14,4\nF,14,-4\n\nfrom,to,speed\n\
         A,B,1\nB,C,1\nC,A,1\nB,D,1\nD,B,1\nD,E,1\nE,D,1\nE,F,1\nF,E,1\nF,D,1\nD,F,1\n",
    );
    assert!(!said.iter().any(|line| line.contains("is the first one out")), "{said:#?}");
    assert_line(&said, "section: single track of 19.3 m in all with a ring, from `D`", &[]);
}

#[test]
fn a_crawling_edge_is_too_slow_and_not_missing() {
    let said = lines(
        "id,x,y\nA,0,0\nB,9,0\nC,9,9\nSlow,20,9\nIsle,30,9\n\nfrom,to,speed\n\
         A,B,1\nB,C,1\nC,A,1\nC,Slow,1\nSlow,C,0.001\nSlow,Isle,0.002\nIsle,Slow,0.002\n",
    );
    assert_line(
        &said,
        "part: 1 node (`Slow`) without a way back",
        &["edges 5, 6 are too slow to count as ways (under 0.01 m/s): raise the speed"],
    );
    assert_line(
        &said,
        "part: 1 node (`Isle`) without a way from or to",
        &["edges 6, 7 are too slow"],
    );
    assert_line(&said, "slow: edge 5 is driven at 0.001 m/s, too slow to count as a way", &[]);
    let wrong = ["add an edge", "join the roads", "dead end"];
    let is_wrong = |line: &String| wrong.iter().any(|wrong| line.contains(wrong));
    assert!(!said.iter().any(is_wrong), "{said:#?}");
}

#[test]
fn without_a_way_back_no_robot_is_under_way() {
    let said = lines("id,x,y\nA,0,0\nB,9,0\n\nfrom,to,speed\nA,B,1\nB,A,0.001\n");
    assert_line(
        &said,
        "under-way: no robot of the main part can be",
        &["speeds that are too slow"],
    );
    assert_line(
        &said,
        "part: 1 node (`B`) without a way back",
        &["edge 2 is too slow to count as a way"],
    );
    let is_other = |line: &String| line.contains("it holds") || line.starts_with("ring");
    assert!(!said.iter().any(is_other), "{said:#?}");
}

#[test]
fn nodes_of_the_same_name_have_their_ids() {
    let node = |id: u32, name: &str| {
        format!("- {{Id: {id}, X: {}, Y: 0, Theta: 0, Name: {name}}}\n", 10 * id)
    };
    let edge = |id: u32, from: u32, to: u32| {
        format!(
            "- {{Id: {id}, Origin_ID: {from}, Destination_ID: {to}, CurveType: Linear, \
             VelocityForward: 1, VelocityBackwards: 1}}\n"
        )
    };
    let text = format!(
        "Vertices:\n{}{}{}Edges:\n{}{}",
        node(1, "Door"),
        node(2, "Hall"),
        node(3, "Door"),
        edge(1, 1, 2),
        edge(2, 2, 3),
    );
    assert_line(&lines(&text), "section: ", &["`Door` (1), `Hall`, `Door` (3)"]);
}

#[test]
fn sections_without_room_share_a_line() {
    let mut text = String::from("id,x,y\n");
    let mut roads = String::new();
    for (x, y) in (0..4).flat_map(|x| (0..4).map(move |y| (x, y))) {
        text += &format!("{x}-{y},{x},{y}\n");
        for (x2, y2) in [(x + 1, y), (x, y + 1)].into_iter().filter(|(x, y)| *x < 4 && *y < 4) {
            roads += &format!("{x}-{y},{x2}-{y2},1\n{x2}-{y2},{x}-{y},1\n");
        }
    }
    let text = format!("{text}\nfrom,to,speed\n{roads}");
    let said = lines(&text);
    assert_line(&said, "section: 16 single tracks of 1.0 m hold no robot between their ends", &[]);
    assert!(!said.iter().any(|line| line.contains(" 0 robots")), "{said:#?}");
}

#[test]
fn rings_that_share_a_road_are_all_told() {
    let said = lines(
        "id,x,y\nA,0,0\nB,10,0\nC,5,10\nD,5,-10\n\nfrom,to,speed\n\
         A,B,1\nB,C,1\nC,A,1\nB,D,1\nD,A,1\n",
    );
    assert_line(&said, "ring: 3 robots at `A`, `B`, `C` close a ring", &[]);
    assert_line(&said, "ring: 3 robots at `A`, `B`, `D` close a ring", &[]);
    assert!(!said.iter().any(|line| line.contains("more rings")), "{said:#?}");
}

#[test]
fn rings_beyond_those_listed_are_told() {
    let (mut nodes, mut roads) = (String::new(), String::new());
    for ring in 0..7 {
        for (corner, (x, y)) in (0..3).zip([(0, 0), (10, 0), (5, 10)]) {
            nodes += &format!("{ring}-{corner},{},{y}\n", 20 * ring + x);
            roads += &format!("{ring}-{corner},{ring}-{},1\n", (corner + 1) % 3);
        }
        if ring > 0 {
            roads += &format!("{}-1,{ring}-0,1\n{ring}-0,{}-1,1\n", ring - 1, ring - 1);
        }
    }
    let said = lines(&format!("id,x,y\n{nodes}\nfrom,to,speed\n{roads}"));
    let rings = said.iter().filter(|line| line.contains("close a ring")).count();
    assert_eq!(rings, 5, "{said:#?}");
    assert_line(&said, "ring: more rings, of 3 robots or more, aren't listed", &[]);
}

/// The cabin is at one level at a time.
#[test]
fn a_robot_in_a_cabin_is_not_in_the_way_of_rides_between_other_levels() {
    let node = |id: u32, x: f64, level: &str| {
        format!("- {{Id: {id}, X: {x}, Y: 0, Theta: 0, Level: {level}}}\n")
    };
    let edge = |id: u32, from: u32, to: u32| {
        format!(
            "- {{Id: {id}, Origin_ID: {from}, Destination_ID: {to}, CurveType: Linear, \
             VelocityForward: 1}}\n"
        )
    };
    let nodes = [node(1, 0.0, "G"), node(2, 0.05, "U"), node(3, 0.1, "V")].concat();
    let rides = [edge(1, 1, 2), edge(2, 2, 1), edge(3, 2, 3), edge(4, 3, 2)].concat();
    let shaft = format!("Vertices:\n{nodes}Edges:\n{rides}");
    let is_in_way = |line: &String| line.starts_with("in-the-way");
    assert!(lines(&shaft).iter().any(is_in_way), "without a lift: {:#?}", lines(&shaft));
    let lift = "Lifts:\n- {Name: L, Nodes: [1, 2, 3], X: 0, Y: 0, Width: 2, Depth: 2}\n";
    let with_lift = lines(&format!("{shaft}{lift}"));
    assert!(!with_lift.iter().any(is_in_way), "{with_lift:#?}");
}
