//! A model of robots that drive from node to node without disturbing each other, with random orders
//! and small batteries.

use proptest::prelude::*;
use regatta_plugin::world::{CurveRecord, EdgeRecord, NodeRecord, WorldData};

use super::*;
use crate::model::Random;
use crate::roads::Roads;

/// The nodes of a ring road of edges of 10 m, which are driven in 10 s.
const RING: u32 = 40;
/// The seconds from node to node.
const EDGE_SECS: f64 = 10.0;
const CAPACITY_WH: f32 = 40.0;
const DRAIN_MOVING: f32 = 120.0;
const DRAIN_STANDING: f32 = 20.0;
const CHARGE_RATE: f32 = 900.0;

/// Returns the ring road, with bays from a node of it to the next.
fn ring(chargers: u32) -> WorldData {
    let mut world = WorldData::default();
    let angle = |node: f32| std::f32::consts::TAU * node / RING as f32;
    let node = |id: u32, at: f32, radius: f32| NodeRecord {
        id,
        x: radius * angle(at).cos(),
        y: radius * angle(at).sin(),
        ..NodeRecord::default()
    };
    world.nodes = (0..RING).map(|id| node(id, id as f32, 64.0)).collect();
    let bays: Vec<u32> = (0..chargers).map(|charger| charger * RING / chargers).collect();
    let charger = |(id, at): (u32, &u32)| NodeRecord {
        role: Role::Charge as u32,
        ..node(RING + id, *at as f32 + 0.5, 70.0)
    };
    world.nodes.extend((0..).zip(&bays).map(charger));
    let ring = (0..RING).map(|node| [node, (node + 1) % RING]);
    let bays =
        (0..).zip(&bays).flat_map(|(id, &at)| [[at, RING + id], [RING + id, (at + 1) % RING]]);
    for (id, [origin, destination]) in (0..).zip(ring.chain(bays)) {
        let ends = [origin, destination]
            .map(|node| [world.nodes[node as usize].x, world.nodes[node as usize].y]);
        let length = (ends[0][0] - ends[1][0]).hypot(ends[0][1] - ends[1][1]);
        let edge =
            EdgeRecord { id, origin, destination, length, speed: 1.0, ..EdgeRecord::default() };
        world.add_edge(edge, [CurveRecord::straight(ends[0], ends[1])]);
    }
    let robot_type = RobotTypeRecord {
        battery_capacity: CAPACITY_WH,
        drain_moving: DRAIN_MOVING,
        drain_standing: DRAIN_STANDING,
        charge_rate: CHARGE_RATE,
        ..RobotTypeRecord::new("amr", 0.9, 0.6)
    };
    world.robot_types = vec![robot_type];
    world
}

/// Seconds from each node to each other one, by the number of edges.
fn distances(roads: &Roads) -> Vec<Vec<f64>> {
    let distances = |start: u32| {
        let mut secs = vec![f64::INFINITY; roads.nodes() as usize];
        secs[start as usize] = 0.0;
        let mut open = std::collections::VecDeque::from([start]);
        while let Some(node) = open.pop_front() {
            for &leg in roads.exits(node) {
                let end = roads.end(leg) as usize;
                if secs[end].is_infinite() {
                    secs[end] = secs[node as usize] + EDGE_SECS;
                    open.push_back(end as u32);
                }
            }
        }
        secs
    };
    (0..roads.nodes()).map(distances).collect()
}

/// A robot of the model.
#[derive(Clone, Copy, Debug)]
struct Body {
    node: u32,
    /// The node that it drives to, and the time of its arrival.
    way: Option<(u32, f64)>,
    /// The stops of its order that are left, the next one last.
    order: Option<[u32; 2]>,
    stops_left: usize,
    charge: f32,
}

/// Lets robots arrive, and lets a second pass for their batteries.
fn drive_and_charge(bodies: &mut [Body], now: f64) {
    for body in bodies {
        if body.way.is_some_and(|(_, at)| at <= now) {
            body.node = body.way.take().map_or(body.node, |(goal, _)| goal);
        }
        let per_second = match (body.way, body.node >= RING) {
            (Some(_), _) => -DRAIN_MOVING,
            (None, true) => CHARGE_RATE,
            (None, false) => -DRAIN_STANDING,
        };
        body.charge = (body.charge + per_second / 36.0 / CAPACITY_WH).clamp(0.0, 100.0);
    }
}

/// Runs the model for some seconds; returns the lowest charge, and the number of stops served.
fn run(robots: u32, chargers: u32, seed: u64, seconds: u32) -> (f32, u32) {
    let data = ring(chargers);
    let world = data.view(1, 1);
    let roads = Roads::new(&world);
    let distances = distances(&roads);
    let secs = |node: u32, goal: u32| {
        Some(distances[node as usize][goal as usize]).filter(|secs| secs.is_finite())
    };
    let mut charging = Charging::new(&world, ChargingSettings::default());
    let mut random = Random(seed);
    let start = |robot: u32| Body {
        node: robot % RING,
        way: None,
        order: None,
        stops_left: 0,
        charge: 40.0 + (robot * 17 % 60) as f32,
    };
    let mut bodies: Vec<Body> = (0..robots).map(start).collect();
    let (mut lowest, mut served) = (100.0_f32, 0);
    for second in 0..seconds {
        let now = f64::from(second);
        drive_and_charge(&mut bodies, now);
        lowest = bodies.iter().fold(lowest, |lowest, body| lowest.min(body.charge));
        let at_chargers: Vec<u32> = bodies
            .iter()
            .filter(|body| body.way.is_none() && body.node >= RING)
            .map(|body| body.node)
            .collect();
        assert!(
            (RING..RING + chargers).all(|node| at_chargers
                .iter()
                .filter(|at| **at == node)
                .count()
                < 2)
        );
        let charges: Vec<f32> = bodies.iter().map(|body| body.charge).collect();
        charging.see(bodies.len(), &charges, &[]);
        charging.measure(&secs);
        let situation = |(robot, body): (u32, &Body)| Situation {
            robot,
            node: Some(body.way.map_or(body.node, |(goal, _)| goal)),
            stop: body.order.map(|stops| stops[body.stops_left - 1]),
            is_bound: body.order.is_some() && body.stops_left == 1,
            has_arrived: body.way.is_none() && charging.goal(robot) == Some(body.node),
            is_unreachable: false,
            is_broken: body.charge <= 0.0,
        };
        let situations: Vec<Situation> = (0..).zip(&bodies).map(situation).collect();
        for decision in charging.decide(now, &roads, &situations, &secs).to_vec() {
            match (decision.robot, decision.action) {
                (robot, ChargeAction::Go(node)) => {
                    let body = &mut bodies[robot as usize];
                    assert!(
                        body.order.is_none() || body.stops_left == 2,
                        "{body:?} has begun its order"
                    );
                    let from = body.way.take().map_or(body.node, |(goal, _)| goal);
                    (body.order, body.node) = (None, from);
                    body.way = Some((node, now + distances[from as usize][node as usize] * 1.3));
                }
                (robot, ChargeAction::Wait) => bodies[robot as usize].order = None,
                (_, ChargeAction::Stay | ChargeAction::Free) => {}
                (robot, ChargeAction::Flat) => panic!("robot {robot} is flat after {second} s"),
            }
        }
        for (robot, body) in (0..).zip(&mut bodies) {
            if body.way.is_some() {
                continue;
            }
            if body.order.is_some_and(|stops| stops[body.stops_left - 1] == body.node) {
                served += 1;
                body.stops_left -= 1;
                body.order = body.order.filter(|_| body.stops_left > 0);
            }
            let stops = [random.below(RING), random.below(RING)];
            let driving = distances[body.node as usize][stops[1] as usize]
                + distances[stops[1] as usize][stops[0] as usize];
            if body.order.is_none()
                && charging.may_work(robot)
                && charging.suffices(robot, driving, 0.0, stops[0])
            {
                (body.order, body.stops_left) = (Some(stops), 2);
            }
            if let Some(goal) = body.order.map(|stops| stops[body.stops_left - 1]) {
                // Traffic makes ways longer.
                let delay = 1.0 + f64::from(random.below(60)) / 100.0;
                body.way = Some((goal, now + distances[body.node as usize][goal as usize] * delay));
            }
        }
    }
    (lowest, served)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn nobody_runs_flat_and_chargers_have_one_robot_at_a_time(robots in 1_u32..24, chargers in 4_u32..8, seed: u64) {
        let (lowest, served) = run(robots, chargers, seed, 3_600);
        prop_assert!(lowest > 3.0, "{lowest} %");
        prop_assert!(served > 4 * robots, "{served} stops of {robots} robots");
    }
}

#[test]
fn a_robot_without_a_battery_works_for_ever() {
    let data = ring(4);
    let mut charging = Charging::new(&data.view(1, 1), ChargingSettings::default());
    charging.see(2, &[f32::NAN], &[]);
    assert!(charging.may_work(0) && charging.suffices(0, 1e9, 0.0, 0));
    assert!(
        charging.may_work(1) && charging.suffices(1, 1e9, 0.0, 0),
        "its charge isn't known yet"
    );
}

#[test]
fn orders_that_take_more_than_a_battery_has_are_not_taken() {
    let data = ring(4);
    let mut charging = Charging::new(&data.view(1, 1), ChargingSettings::default());
    charging.see(1, &[60.0], &[]);
    // 50 % of 144 kJ are 72 kJ; 120 W for twice the driving time.
    assert!(charging.suffices(0, 299.0, 0.0, 0) && !charging.suffices(0, 301.0, 0.0, 0));
    assert!(!charging.suffices(0, 200.0, 250.0, 0), "and for the time at stops");
}
