//! Batteries: energy is conserved, flat robots stop, and chargers charge.

use std::sync::Arc;

use regatta_layout::{NodeIndex, Role, RouteGraph};
use regatta_plugin::command::{CommandKind, CommandRecord};
use regatta_plugin::event::{BreakdownCause, EventKind};
use regatta_plugin::frame::RobotState;
use regatta_scenario::{Battery, ChargeRange, Repeat, RobotType};

use super::support::*;
use crate::fleet::{EventBuffer, Fleet, FleetConfig, Placement, RouteSource};

/// 1 Wh: 3600 J last a minute of driving.
const BATTERY: Battery = Battery {
    capacity: 1.0,
    drain_moving: 60.0,
    drain_standing: 12.0,
    charge_rate: 600.0,
    charge: ChargeRange { min: 100.0, max: 100.0 },
};

fn with_battery(battery: Battery, acceleration: f32) -> RobotType {
    RobotType { battery: Some(battery), ..robot_type(f32::INFINITY, acceleration) }
}

/// Returns an edge of that many metres at 1 m/s, with a charger at its end, and another edge of 5
/// m.
fn road_to_charger(metres: f64) -> Arc<RouteGraph> {
    let mut graph = Arc::unwrap_or_clone(chain(&[(metres, 1.0), (5.0, 1.0)]));
    graph.override_node(NodeIndex(1), Some(Role::Charge), None);
    Arc::new(graph)
}

/// Returns a fleet of one robot at the start of the road, which drives to the charger.
fn driving(metres: f64, battery: Battery, acceleration: f32) -> Fleet {
    let mut fleet =
        fleet(&road_to_charger(metres), config(vec![with_battery(battery, acceleration)]));
    let route = RouteSource::Listed([forward(0)].into(), Repeat::Once);
    fleet.spawn(Placement::Node(NodeIndex(0)), 0, route, 0, &mut events()).expect("a route");
    fleet
}

/// Lets seconds pass, from a tick on; returns the charge in per cent.
fn pass(fleet: &mut Fleet, tick: &mut u64, seconds: u64, events: &mut EventBuffer) -> f32 {
    for _ in 0..50 * seconds {
        *tick += 1;
        fleet.drain_batteries(*tick, events);
        fleet.step(None, events);
    }
    fleet.battery_charges().expect("batteries")[0]
}

fn state(fleet: &Fleet) -> RobotState {
    RobotState::from_number(fleet.states()[0])
}

#[test]
fn energy_is_taken_and_given_as_the_type_says() {
    for acceleration in [f32::INFINITY, 0.8] {
        let mut fleet = driving(20.0, Battery { charge_rate: 60.0, ..BATTERY }, acceleration);
        let (tick, events) = (&mut 0, &mut events());
        assert_eq!(fleet.battery_charges(), Some(vec![100.0]));
        // 60 W for 10 s of 3600 J.
        let charge = pass(&mut fleet, tick, 10, events);
        assert!((charge - (100.0 - 100.0 / 6.0)).abs() < 0.4, "{charge}");
        while state(&fleet) != RobotState::Idle {
            pass(&mut fleet, tick, 1, events);
        }
        let at_charger = pass(&mut fleet, tick, 1, events);
        // 60 W for 1 s.
        let later = pass(&mut fleet, tick, 1, events);
        assert!((later - at_charger - 10.0 / 6.0).abs() < 1e-3, "{at_charger} to {later}");
        assert_eq!(
            pass(&mut fleet, tick, 60, events),
            100.0,
            "no battery holds more than its capacity"
        );
    }
}

#[test]
fn robots_that_stand_elsewhere_take_energy_and_do_not_charge() {
    let mut fleet = fleet(&road_to_charger(20.0), config(vec![with_battery(BATTERY, 0.8)]));
    fleet
        .spawn(Placement::Node(NodeIndex(0)), 0, RouteSource::None, 0, &mut events())
        .expect("a node");
    // 12 W for 30 s.
    let charge = pass(&mut fleet, &mut 0, 30, &mut events());
    assert!((charge - 90.0).abs() < 1e-3, "{charge}");
}

#[test]
fn a_robot_on_a_charger_charges_only_while_it_is_idle() {
    let battery = Battery { charge: ChargeRange { min: 50.0, max: 50.0 }, ..BATTERY };
    let mut fleet = fleet(&road_to_charger(20.0), config(vec![with_battery(battery, 0.8)]));
    fleet
        .spawn(Placement::Node(NodeIndex(1)), 0, RouteSource::None, 0, &mut events())
        .expect("a node");
    fleet.stall(0, &mut events());
    let tick = &mut 0;
    assert!(pass(&mut fleet, tick, 1, &mut events()) < 50.0);
    fleet.recover(0, &mut events());
    assert!(pass(&mut fleet, tick, 1, &mut events()) > 60.0);
}

#[test]
fn a_flat_robot_is_broken_until_it_is_repaired() {
    let mut fleet =
        driving(200.0, Battery { charge: ChargeRange { min: 10.0, max: 10.0 }, ..BATTERY }, 0.8);
    let (tick, mut events) = (&mut 0, events());
    assert_eq!(pass(&mut fleet, tick, 20, &mut events), 0.0);
    assert_eq!(state(&fleet), RobotState::Broken);
    let causes = |events: &EventBuffer| {
        let breakdowns =
            events.records().iter().filter(|event| event.kind == EventKind::BrokenDown as u32);
        breakdowns.map(|event| (event.robot, event.detail)).collect::<Vec<_>>()
    };
    assert_eq!(causes(&events), [(0, BreakdownCause::FlatBattery as u32)]);
    let place = fleet.pose(0);
    pass(&mut fleet, tick, 60, &mut events);
    assert_eq!(
        (fleet.pose(0), causes(&events).len()),
        (place, 1),
        "it stands, and that is told once"
    );
    let repair = CommandRecord { kind: CommandKind::Repair as u32, ..CommandRecord::default() };
    fleet.apply(&[repair], &mut events);
    assert_eq!(fleet.battery_charges(), Some(vec![100.0]));
    assert_eq!(state(&fleet), RobotState::Driving);
    assert!(events.records().iter().any(|event| event.kind == EventKind::Repaired as u32));
}

#[test]
fn a_flat_robot_goes_on_when_it_has_been_charged() {
    let empty = Battery { charge: ChargeRange { min: 0.0, max: 0.0 }, ..BATTERY };
    let mut fleet = fleet(&road_to_charger(20.0), config(vec![with_battery(empty, 0.8)]));
    fleet
        .spawn(Placement::Node(NodeIndex(1)), 0, RouteSource::None, 0, &mut events())
        .expect("a node");
    let tick = &mut 0;
    fleet.drain_batteries(0, &mut events());
    pass(&mut fleet, tick, 1, &mut events());
    assert_eq!(state(&fleet), RobotState::Idle);
    fleet.break_down(0, &mut events());
    pass(&mut fleet, tick, 1, &mut events());
    assert_eq!(
        state(&fleet),
        RobotState::Broken,
        "what breaks otherwise isn't mended by a charger"
    );
}

#[test]
fn the_charge_at_the_start_is_in_its_range_and_new_robots_get_their_own() {
    let battery = Battery { charge: ChargeRange { min: 20.0, max: 60.0 }, ..BATTERY };
    let types = vec![with_battery(battery, 0.8), robot_type(f32::INFINITY, 0.8)];
    let mut fleet = fleet(&road_to_charger(20.0), config(types));
    for robot in 0..200 {
        let place = Placement::Node(NodeIndex(0));
        fleet
            .spawn(place, u16::from(robot == 7), RouteSource::None, 0, &mut events())
            .expect("a node");
    }
    let charges = fleet.battery_charges().expect("batteries");
    assert!(charges[7].is_nan(), "its type has no battery");
    let known: Vec<_> = charges.iter().copied().filter(|charge| !charge.is_nan()).collect();
    assert!(known.iter().all(|charge| (20.0..=60.0).contains(charge)));
    assert!(known.iter().any(|charge| *charge < 25.0) && known.iter().any(|charge| *charge > 55.0));
    pass(&mut fleet, &mut 0, 10, &mut events());
    fleet.remove(3, &mut events()).expect("a robot");
    fleet
        .spawn(Placement::Node(NodeIndex(0)), 0, RouteSource::None, 0, &mut events())
        .expect("a node");
    assert_eq!(fleet.battery_charges().expect("batteries")[3], charges[3]);
}

#[test]
fn charges_are_the_same_on_any_number_of_threads() {
    let run = |threads| {
        let battery = Battery { charge: ChargeRange { min: 1.0, max: 60.0 }, ..BATTERY };
        let types = vec![with_battery(battery, 0.8)];
        let mut fleet = fleet(&town(6, 12.0), FleetConfig { threads, ..config(types) });
        for robot in 0..3000 {
            let place = Placement::Node(NodeIndex(robot % 36));
            fleet.spawn(place, 0, RouteSource::Random, 0, &mut events()).expect("a node");
        }
        let mut events = events();
        pass(&mut fleet, &mut 0, 20, &mut events);
        let charges: Vec<_> = fleet
            .battery_charges()
            .expect("batteries")
            .iter()
            .map(|charge| charge.to_bits())
            .collect();
        (charges, events.records().to_vec(), bits(&poses(&mut fleet)).to_vec())
    };
    let (one, four) = (run(1), run(4));
    assert!(one.1.iter().any(|event| event.kind == EventKind::BrokenDown as u32));
    assert!(one == four);
}

#[test]
fn a_fleet_without_batteries_has_no_charges() {
    let mut fleet = fleet(&road_to_charger(20.0), config(vec![robot_type(1.0, 0.8)]));
    fleet.drain_batteries(5, &mut events());
    assert_eq!(fleet.battery_charges(), None);
}
