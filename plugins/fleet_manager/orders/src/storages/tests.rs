use std::sync::Arc;

use glam::Vec2;

use super::*;
use crate::file::parse_yaml;
use crate::load::Load;
use crate::order::{Change, OrderId};
use crate::places::Place;
use crate::pool::OrderPool;
use crate::{Candidate, State};

/// Places 10 m apart from west to east: `in`, `R1` to `R4` and `out`; the first two of the four are
/// in the zone `front`, and the others in `back`.
fn plant() -> Places {
    let names = ["in", "R1", "R2", "R3", "R4", "out"];
    let zones = ["", "front", "front", "back", "back", ""];
    let place = |id: u32| Place {
        id: 10 + id,
        name: names[id as usize].to_owned(),
        zone: zones[id as usize].to_owned(),
        position: Vec2::X * 10.0 * id as f32,
        ..Place::default()
    };
    Places::new((0..6).map(place).collect())
}

fn load(storages: &str) -> Result<Load, String> {
    Load::parse(&format!("load: {{seed: 3, per_hour: 0, storages: {storages}}}"), &plant())
        .map_err(|error| error.to_string())
}

/// A pool with storages and orders, at time 0.
fn pool(storages: &str, orders: &str) -> OrderPool {
    let mut pool = OrderPool::new(Arc::new(plant()));
    pool.add_load(&load(storages).expect("a load"));
    pool.add_orders(&parse_yaml(orders).expect("orders")).expect("valid orders");
    pool.generate_until(0.0, 9);
    pool
}

/// The nodes of an order's stops.
fn nodes(pool: &OrderPool, id: u64) -> Vec<u32> {
    let order = pool.order(OrderId(id)).expect("an order");
    order.content.stops.iter().map(|stop| stop.node).collect()
}

fn state(pool: &OrderPool, id: u64) -> State {
    pool.order(OrderId(id)).expect("an order").state
}

/// Lets a robot carry out all stops of an order that waits, at a time.
fn carry_out(pool: &mut OrderPool, id: u64, now_secs: f64) {
    let robot = id as u32;
    let robots = [Candidate { robot, ..Candidate::default() }];
    let stop = pool.order(OrderId(id)).expect("an order").content.stops[0].node;
    let able = move |_: u32, node: u32| (node == stop).then_some(1.0);
    assert_eq!(pool.assign(now_secs, &robots, &able).assigned, [(OrderId(id), robot)]);
    while pool.arrived(robot, now_secs).is_some() {
        pool.handled(robot, now_secs);
    }
}

const PUT: &str = "stops: [{at: in, action: pick}, {at: rack, action: drop}]";
const GET: &str = "stops: [{at: rack, action: pick}, {at: out, action: drop}]";

/// Three places: the nearest to the dock are 1, 2, 3. The fourth order waits until the retrieval of
/// order 5 has emptied place 2, which is the full one nearest to the exit.
#[test]
fn a_put_away_takes_the_nearest_place_and_waits_while_all_are_full() {
    let orders =
        format!("- {{{PUT}}}\n- {{{PUT}}}\n- {{{PUT}}}\n- {{{PUT}}}\n- {{time: 20, {GET}}}\n");
    let mut pool = pool("[{name: rack, at: [R3, R2, R1]}]", &orders);
    assert_eq!([1, 2, 3].map(|id| nodes(&pool, id)), [[0, 1], [0, 2], [0, 3]]);
    let figures = pool.figures(0.0);
    assert_eq!((state(&pool, 4), figures.orders.unplaced), (State::Unplaced, 1));
    assert_eq!(figures.unserved, 3, "an order is told as unplaced or as not begun");
    assert_eq!(
        pool.storages()[0].to_string(),
        "rack: 0 of 3 places full, 1 order waits for an empty place"
    );
    carry_out(&mut pool, 1, 10.0);
    carry_out(&mut pool, 2, 11.0);
    pool.generate_until(20.0, 9);
    assert_eq!((nodes(&pool, 5), state(&pool, 4)), (vec![2, 5], State::Unplaced));
    let picked = |pool: &mut OrderPool| pool.storages()[0].full;
    assert_eq!(picked(&mut pool), 2, "the load is there until it is picked");
    carry_out(&mut pool, 5, 30.0);
    assert_eq!(picked(&mut pool), 1);
    pool.generate_until(30.0, 9);
    assert_eq!((nodes(&pool, 4), state(&pool, 4)), (vec![0, 2], State::Waiting));
    assert_eq!(pool.figures(30.0).orders.unplaced, 0);
}

/// The stops of an order that waits are told when it has its places, after `Reopened`.
#[test]
fn a_waiting_order_is_told_in_the_events() {
    let mut pool = pool("[{name: rack, at: R1}]", &format!("- {{{GET}}}\n- {{time: 5, {PUT}}}\n"));
    let lack = Some(Lack { storage: 0, is_full: false });
    let waits = pool.events().any(
        |event| matches!(&event.change, Change::Unroutable { lack: found, .. } if *found == lack),
    );
    assert!(waits);
    pool.generate_until(5.0, 9);
    carry_out(&mut pool, 2, 6.0);
    pool.events();
    pool.generate_until(7.0, 9);
    let changes: Vec<Change> = pool.events().map(|event| event.change).collect();
    assert!(
        matches!(
            changes[..],
            [Change::Reopened, Change::Stop { node: 1, .. }, Change::Stop { node: 5, .. }]
        ),
        "{changes:?}"
    );
}

#[test]
fn an_order_that_is_over_gives_its_places_back() {
    let mut pool = pool(
        "[{name: rack, at: [R1, R2], full: [R1]}]",
        &format!(
            "- {{name: a, {GET}}}\n- {{name: b, {PUT}}}\n\
             - {{name: c, {GET}}}\n- {{name: d, {PUT}}}\n"
        ),
    );
    assert_eq!([3, 4].map(|id| state(&pool, id)), [State::Unplaced; 2]);
    for name in ["a", "b"] {
        let name = crate::OrderName::parse(name).expect("a name");
        pool.cancel(&name, false, 1.0).expect("cancelled");
    }
    pool.generate_until(1.0, 9);
    assert_eq!([3, 4].map(|id| nodes(&pool, id)), [[1, 5], [0, 2]]);
}

/// Both storages or none: an order holds no place while it waits for the other one.
#[test]
fn an_order_between_storages_reserves_both_places_or_none() {
    let relocation = "stops: [{at: rack, action: pick}, {at: hall, action: drop}]";
    let storages = "[{name: rack, at: R1, full: 1}, {name: hall, at: R4, full: 1}]";
    let mut pool = pool(storages, &format!("- {{{relocation}}}\n- {{{GET}}}\n"));
    assert_eq!(state(&pool, 1), State::Unplaced);
    assert_eq!(nodes(&pool, 2), [1, 5], "the place wasn't held");
    pool.generate_until(1.0, 9);
    assert_eq!(pool.storages()[1].waiting_drops, 1);
}

#[test]
fn a_higher_priority_gets_a_place_first() {
    let orders = format!("- {{{GET}}}\n- {{priority: 3, {GET}}}\n");
    let pool = pool("[{name: rack, at: [R1], full: 1}]", &orders);
    assert_eq!([1, 2].map(|id| state(&pool, id)), [State::Unplaced, State::Waiting]);
}

#[test]
fn zones_are_used_in_their_order() {
    let storages = "[{name: rack, at: 'R*', strategy: zones, zones: [back, front]}]";
    let orders = format!("- {{{PUT}}}\n").repeat(4);
    let found = pool(storages, &orders);
    assert_eq!([1, 2, 3, 4].map(|id| nodes(&found, id)[1]), [3, 4, 1, 2]);
}

#[test]
fn random_places_depend_on_the_seed_alone() {
    let storages = "[{name: rack, at: 'R*', strategy: random}]";
    let orders = format!("- {{{PUT}}}\n").repeat(4);
    let [one, other] = [0; 2].map(|_| {
        let found = pool(storages, &orders);
        [1, 2, 3, 4].map(|id| nodes(&found, id)[1])
    });
    assert_eq!(one, other);
    let mut sorted = one;
    sorted.sort_unstable();
    assert_eq!(sorted, [1, 2, 3, 4], "each place once");
}

#[test]
fn a_share_of_the_places_is_full_at_the_begin() {
    for (full, count) in [("0", 0), ("0.5", 2), ("1", 4), ("[R2, R3, R4]", 3)] {
        let pool = pool(&format!("[{{name: rack, at: 'R*', full: {full}}}]"), "[]");
        assert_eq!(pool.storages()[0].full, count, "{full}");
    }
}

#[test]
fn generators_and_files_name_storages() {
    let text = "load: {seed: 1, groups: {ins: [in]}, storages: [{name: rack, at: {zone: front}}], \
                stations: [{at: rack, operators: 1}], \
                generators: [{gaps: 10, batch: 3, from: ins, to: rack, dwell: 1}]}";
    let places = Arc::new(plant());
    let mut pool = OrderPool::new(places.clone());
    pool.add_load(&Load::parse(text, &places).expect("a load"));
    assert_eq!(pool.load_stops().last.into_iter().collect::<Vec<_>>(), [1, 2]);
    let mut pool = pool.for_rehearsal(0);
    pool.generate_until(30.0, 2);
    assert_eq!([1, 2].map(|id| nodes(&pool, id)), [[0, 1], [0, 2]]);
    assert_eq!(state(&pool, 3), State::Unplaced);
}

#[test]
fn patterns_stand_for_any_text() {
    for (pattern, name, expected) in [
        ("R*", "R12", true),
        ("*", "", true),
        ("R*-1", "R-1", true),
        ("R*-1*", "Rack 7-12", true),
        ("a*a", "a", false),
        ("a*b*c", "abbc", true),
        ("a*b*b", "ab", false),
        ("R*", "in", false),
    ] {
        assert_eq!(matches(pattern, name), expected, "{pattern} {name}");
    }
}

/// A station has the name, and not its node.
#[test]
fn patterns_are_of_the_names_of_stations_too() {
    let mut places = plant();
    places.add_name("Storage 01", 2);
    places.add_name("Storage 02", 1);
    places.add_name("Stairs", 0);
    assert_eq!(places.nodes_named(|name| matches("Storage *", name)), [1, 2]);
    assert_eq!(places.nodes_named(|name| matches("R*", name)), [1, 2, 3, 4], "those of nodes");
}

#[test]
fn bad_storages_are_refused_with_their_reason() {
    for (storages, reason) in [
        ("[{name: in, at: R1}]", "`in` is a group, a role or a node already"),
        ("[{name: pick, at: R1}]", "`pick` is a group, a role or a node already"),
        ("[{name: '', at: R1}]", "the name of a storage is empty"),
        ("[{name: a, at: 'X*'}]", "no node has a name like `X*`"),
        ("[{name: a, at: X}]", "`X` is neither a group"),
        ("[{name: a, at: []}]", "at least one place"),
        ("[{name: a, at: R1}, {name: a, at: R2}]", "two storages have the name `a`"),
        ("[{name: a, at: R1}, {name: b, at: 'R*'}]", "R1 is a place of this storage and of `a`"),
        ("[{name: a, at: R1, full: 1.5}]", "1.5: give a share from 0 to 1"),
        ("[{name: a, at: R1, full: [R2]}]", "R2 is no place of this storage"),
        ("[{name: a, at: R1, strategy: best}]", "unknown strategy `best`; use nearest"),
        ("[{name: a, at: R1, strategy: zones}]", "give `zones`"),
        ("[{name: a, at: R1, zones: [front]}]", "give `strategy: zones`, too"),
        ("[{name: a, at: R1, strategy: zones, zones: [x]}]", "in the zone `x`"),
    ] {
        let error = load(storages).expect_err(storages);
        assert!(error.contains(reason), "{storages}: {error}");
    }
    let via = "load: {gaps: 9, storages: [{name: rack, at: R1}], via: [rack]}";
    let error = Load::parse(via, &plant()).expect_err("via").to_string();
    assert!(error.contains("orders pick and drop at the storage `rack`"), "{error}");
    let places = Load::places("load: {storages: [{name: rack, at: R1}]}", &plant());
    let drafts = parse_yaml("- {stops: [rack]}").expect("orders");
    let error = crate::check_orders(&drafts, &places.expect("places")).expect_err("no action");
    assert!(error.to_string().contains("where robots pick or drop"), "{error}");
}
