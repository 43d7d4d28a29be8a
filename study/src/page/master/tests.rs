//! Tests of the page with made-up answers.

use super::*;
use crate::master::{Base, MasterPoint, RawFigures, Transport};
use crate::page::markdown;

/// A run whose bases take so many seconds at a node, one of ten of them.
fn run(vehicles: u32, slow_secs: f64) -> MasterRun {
    let bases = (0..100).map(|index| Base {
        vehicle: "7".to_owned(),
        node: "N37".to_owned(),
        next_node: Some("N38".to_owned()),
        edges: [None, None],
        secs: if index % 10 == 0 { slow_secs } else { 0.1 },
        standing_secs: 0.0,
        is_of_master: true,
        is_missing: false,
    });
    let transports = vec![Transport { at_secs: 30.0, service_secs: Some(20.0) }];
    let raw =
        RawFigures { secs: 60.0, bases: bases.collect(), transports, ..RawFigures::default() };
    MasterRun::new(vehicles, 1, raw, 1.0)
}

fn point(vehicles: u32, runs: Vec<MasterRun>, failure: Option<&str>) -> MasterPoint {
    MasterPoint::new(vehicles, runs, failure.map(str::to_owned), 1.0, true)
}

fn answer(points: Vec<MasterPoint>) -> MasterAnswer {
    let failing = points.iter().find(|point| point.verdict == Verdict::Fails);
    let fails = failing.map(|point| point.vehicles);
    let coping = points.iter().take_while(|point| point.verdict == Verdict::Copes);
    MasterAnswer {
        title: "plant".to_owned(),
        program: "0".to_owned(),
        master: "m".to_owned(),
        orders: "o".to_owned(),
        asked: "1 to 8 robots".to_owned(),
        repeats: 1,
        secs: 60,
        late_secs: 1.0,
        left_out: Vec::new(),
        is_interrupted: false,
        copes: coping.last().map(|point| point.vehicles),
        fails,
        points,
    }
}

#[test]
fn the_answer_has_the_number_and_the_place() {
    let points = vec![point(140, vec![run(140, 0.5)], None), point(160, vec![run(160, 2.3)], None)];
    assert_eq!(
        verdict(&answer(points)),
        "The master copes with **140 vehicles** on this layout; from 160 on, bases come 2.3 s late \
         at node `N37`."
    );
}

#[test]
fn an_answer_that_is_not_known_says_why() {
    let silent = "the master sent no order within 60 s";
    let unknown = answer(vec![point(1, Vec::new(), Some(silent))]);
    assert_eq!(verdict(&unknown), format!("**Not known**: {silent}."));
    assert_eq!(verdict(&answer(Vec::new())), "**Not known**: no run has ended.");
    let part =
        answer(vec![point(4, vec![run(4, 0.1)], None), point(8, Vec::new(), Some("no room"))]);
    assert_eq!(
        verdict(&part),
        "The master copes with **4 vehicles** on this layout, and nothing is known about larger \
         numbers: with 8, no room."
    );
    assert!(!answer(vec![point(1, vec![run(1, 5.0)], None)]).is_good());
}

#[test]
fn faults_come_before_late_bases() {
    let mut bad = run(4, 2.0);
    bad.contacts = 1;
    bad.never_ordered = 3;
    bad.breaches = vec![Breach {
        rule: "head-on".to_owned(),
        requirement: "r".to_owned(),
        side: "master".to_owned(),
        severity: "warning".to_owned(),
        clause: "5".to_owned(),
        count: 2,
        example: "edge 'A' is released against '1'".to_owned(),
    }];
    let text = verdict(&answer(vec![point(4, vec![bad], None)]));
    assert_eq!(
        text,
        "The master **doesn't cope** with 4 vehicles on this layout, the least that was tried: \
         vehicles touch once; the master lets orders meet head-on 2 times (edge 'A' is released \
         against '1')."
    );
}

#[test]
fn the_page_has_its_parts() {
    let graph = "id,x,y\nA,0,0\nB,10,0\n\nfrom,to\nA,B\nB,A\n";
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("plant.csv");
    std::fs::write(&path, graph).expect("written");
    let variant = Variant::read(&path, &Default::default()).expect("a plant");
    let points = vec![point(1, vec![run(1, 0.5)], None), point(2, vec![run(2, 2.3)], None)];
    let page = markdown(&master_content(&answer(points), &variant));
    for part in [
        "| **1** | yes |",
        "| 2 | no |",
        "**In real time**",
        "With 2 vehicles: bases come 2.3 s late at node `N37`.",
        "| N37 | 100 | 10 | 2.3 s |",
        "No breach of VDA 5050",
        "## Method",
    ] {
        assert!(page.contains(part), "{part}: {page}");
    }
}
