use std::collections::BTreeMap;
use std::path::Path;

use regatta_layout::{NodeIndex, ReadOptions, RouteGraph};
use serde_json::{Value, json};

use super::candidates::Wait;
use super::*;
use crate::outcome::EdgeOutcome;
use crate::plan::{RunTime, Variant};

/// Returns a plant of the examples with a fault.
fn plant(name: &str) -> Variant {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../graphs/faults/{name}.yaml"));
    Variant::read(&path, &ReadOptions::default()).expect(name)
}

/// Returns a site with 10 robots and 100 orders an hour, in which nothing was measured.
fn site(variant: &Variant) -> Site<'_> {
    Site {
        variant,
        robots: 10,
        secs: 3600.0,
        orders_per_hour: 100.0,
        charging: 0.0,
        idle: 0.0,
        down: 0.0,
        unassigned: 0.0,
        stops: BTreeMap::new(),
        relations: BTreeMap::new(),
        bottlenecks: &[],
        edges: BTreeMap::new(),
    }
}

fn node(graph: &RouteGraph, name: &str) -> NodeIndex {
    graph.nodes_named(name)[0]
}

fn id(graph: &RouteGraph, name: &str) -> u32 {
    graph.node(node(graph, name)).id
}

/// Returns a variant with a remedy, which the engine takes.
fn with(variant: &Variant, remedy: Remedy) -> Variant {
    let candidate = Candidate { remedy, words: "it".to_owned(), about: "", robots: 0.0 };
    let relieved = candidate.applied(variant).expect("it is possible");
    relieved.check(10).expect("a variant");
    relieved
}

/// Returns the load of a run.
fn load(variant: &Variant) -> Value {
    let job = variant.job("x.yaml", 5, 1, RunTime { secs: 600, rate_hz: 10 }, "");
    serde_json::to_value(&job.scenario.setup.load).expect("JSON")
}

#[test]
fn a_two_way_track_leads_from_junction_to_junction() {
    let plant = plant("track");
    let tracks = track::tracks(&plant.graph, 0.6);
    let names: Vec<Vec<_>> = tracks
        .iter()
        .map(|track| track.nodes.iter().filter_map(|it| plant.graph.node(*it).name()).collect())
        .collect();
    assert_eq!(names, [["A0", "T1", "T2", "B0"]]);
    let ids: Vec<u32> = tracks[0].nodes.iter().map(|it| plant.graph.node(*it).id).collect();
    let second = with(&plant, Remedy::SecondTrack(ids));
    assert!(track::tracks(&second.graph, 0.6).is_empty(), "each direction has its own track");
    assert_eq!(second.graph.edges().len(), plant.graph.edges().len() + 2);
    let middle = tracks[0].edges[1].map(|edge| plant.graph.edge(edge).id);
    let passing = with(&plant, Remedy::PassingPlace(middle));
    assert_eq!(track::tracks(&passing.graph, 0.6).len(), 2, "a track on either side of it");
}

#[test]
fn an_aisle_is_turned_round_if_that_makes_the_ways_of_orders_shorter() {
    let plant = plant("aisle");
    let graph = &plant.graph;
    let [pick, drop] = ["P1", "D1"].map(|name| id(graph, name));
    let relations = BTreeMap::from([([pick, drop], 7.0)]);
    let found = aisle::candidates(&Site { relations, ..site(&plant) });
    let edges: Vec<&Remedy> = found.iter().map(|candidate| &candidate.remedy).collect();
    assert_eq!(edges, [&Remedy::Reversed(vec![29, 30])]);
    // Back by the aisle: 24 m west, 12 m south and 24 m east fewer, and 12 m through the aisle.
    let saved_secs = found[0].robots * 3600.0 / 100.0;
    assert!((saved_secs - 48.0 / 1.5).abs() < 1e-6, "{saved_secs}");
    let turned = with(&plant, found[0].remedy.clone());
    assert!(
        aisle::candidates(&Site {
            relations: BTreeMap::from([([pick, drop], 7.0)]),
            ..site(&turned)
        })
        .is_empty()
    );
}

#[test]
fn slow_edges_count_the_time_that_is_lost_there_and_before_them() {
    let plant = plant("slow");
    let traffic = |id: u32| EdgeOutcome { entered_per_hour: 100.0, ..EdgeOutcome::new(id) };
    let mut edges: BTreeMap<u32, EdgeOutcome> =
        plant.graph.edges().iter().map(|edge| (edge.id, traffic(edge.id))).collect();
    edges.insert(8, EdgeOutcome { caused_secs: 1800.0, ..traffic(8) });
    let found = slow::slow_edges(&Site { edges, ..site(&plant) });
    let [slow] = &found[..] else { panic!("{found:?}") };
    assert_eq!(slow.remedy, Remedy::UsualSpeed { edges: vec![8], speed: 1.5 });
    // 6 m at 0.25 m/s in place of 1.5 m/s, a hundred times an hour; and half a robot that waits.
    assert!((slow.robots - (100.0 * 20.0 / 3600.0 + 0.5)).abs() < 1e-9, "{}", slow.robots);
}

#[test]
fn a_second_place_gets_orders_and_a_queue_is_before_its_station() {
    let plant = plant("queue");
    let graph = &plant.graph;
    let station = id(graph, "D1");
    let [place, queue] =
        [Remedy::Place(station), Remedy::Queue(station)].map(|remedy| with(&plant, remedy));
    let more = &place.graph.nodes()[graph.nodes().len()..];
    let [more] = more else { panic!("{more:?}") };
    let name = more.id.to_string();
    assert_eq!(load(&place)["flows"][0]["to"], json!(["D1", name]));
    assert_eq!(load(&place)["dwell"]["at"][&name], json!({"min": 60, "max": 70}));
    assert_eq!(load(&place)["stations"][0]["at"], json!(["D1", name]), "with the same operator");
    let places = &queue.graph.nodes()[graph.nodes().len()..];
    let ids: Vec<String> = places.iter().map(|place| place.id.to_string()).collect();
    assert_eq!(load(&queue)["stations"][0]["queue"], json!(ids));
    let at = graph.node(node(graph, "D1")).position;
    assert!(places.iter().all(|place| place.position.y == at.y), "off the road, in line");
    assert!(places[1].position.x < places[0].position.x && places[0].position.x < at.x);
}

#[test]
fn a_place_that_orders_name_by_role_needs_no_change_of_the_load() {
    let plant = plant("operator");
    let [first, second] = ["D1", "D2"].map(|name| id(&plant.graph, name));
    let place = with(&plant, Remedy::Place(first));
    assert_eq!(load(&place), load(&plant));
    let more = with(&plant, Remedy::Operator(vec![first, second]));
    assert_eq!(load(&more)["stations"][0]["operators"], 2);
    let queue =
        Candidate { remedy: Remedy::Queue(first), words: String::new(), about: "", robots: 0.0 };
    assert!(queue.applied(&plant).is_none(), "the entry is of several nodes");
}

#[test]
fn the_largest_of_each_kind_comes_first() {
    let plant = plant("operator");
    let stop = |name: &str| id(&plant.graph, name);
    let wait = |robots: f64| Wait { robots, queued: 0.0 };
    let stops = BTreeMap::from([(stop("D1"), wait(1.0)), (stop("D2"), wait(0.5))]);
    let into = |name: &str, secs: f64| {
        let node = node(&plant.graph, name);
        let edge = plant.graph.edges().iter().find(|edge| edge.destination == node);
        let id = edge.expect("an edge").id;
        (id, EdgeOutcome { caused_secs: secs, ..EdgeOutcome::new(id) })
    };
    let edges = BTreeMap::from([into("D1", 7200.0), into("D2", 5400.0)]);
    let found = candidates(&Site { stops, edges, down: 0.2, ..site(&plant) });
    let kinds: Vec<&str> = found.iter().map(|candidate| &*candidate.words).collect();
    assert_eq!(
        kinds,
        [
            "one more operator at D1, D2",
            "a second place at D1",
            "2 places of a queue off the road before D1",
            "robots that are repaired in half the time",
            "a second place at D2",
            "2 places of a queue off the road before D2",
        ]
    );
    assert_eq!(found[0].robots, 5.0);
}
