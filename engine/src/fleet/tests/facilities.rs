//! Doors and lifts: nobody is ever in a closed door, or in a shaft without the cabin.

use std::sync::Arc;

use proptest::prelude::*;
use regatta_layout::{EdgeIndex, Lift, NodeIndex, ReadOptions, RouteGraph, parse};
use regatta_plugin::command::{CommandKind, CommandRecord};
use regatta_plugin::event::{EventKind, Refusal};
use regatta_plugin::facility::{DoorState, FacilityState};
use regatta_plugin::frame::RobotState;
use regatta_plugin::order::NO_ROBOT;
use regatta_scenario::Repeat;

use super::support::*;
use crate::fleet::{EventBuffer, Fleet, Placement, RouteSource};

/// The ticks per second of [`config`].
const RATE: u64 = 50;

fn plant() -> Arc<RouteGraph> {
    let text = include_str!("../../../../graphs/two-levels.yaml");
    Arc::new(parse(text, "two-levels.yaml", &ReadOptions::default()).expect("a plant").0)
}

/// A fleet on a plant, tick by tick.
struct Run {
    graph: Arc<RouteGraph>,
    fleet: Fleet,
    events: EventBuffer,
    tick: u64,
}

impl Run {
    fn new(accelerations: &[f32]) -> Self {
        let graph = plant();
        let types = accelerations.iter().map(|acceleration| robot_type(1.5, *acceleration));
        let fleet = fleet(&graph, config(types.collect()));
        Self { graph, fleet, events: events(), tick: 0 }
    }

    fn node(&self, id: u32) -> NodeIndex {
        self.graph.node_by_id(id).expect("a node")
    }

    fn spawn(&mut self, placement: Placement, source: RouteSource) -> Result<u32, Refusal> {
        self.fleet.spawn(placement, 0, source, 0, &mut self.events)
    }

    /// Spawns a robot at a node that drives a loop of edges, by their ids.
    fn loops(&mut self, node: u32, edges: &[u32]) {
        let edges = edges.iter().map(|id| self.graph.edge_by_id(*id).expect("an edge").0);
        let legs: Arc<[_]> = edges.map(forward).collect();
        let source = RouteSource::Listed(legs, Repeat::Loop);
        self.spawn(Placement::Node(self.node(node)), source).expect("a place");
    }

    fn command(&mut self, kind: CommandKind, robot: u32, id: u32) -> Option<Refusal> {
        self.events.clear();
        let record = CommandRecord { kind: kind as u32, robot, id, ..CommandRecord::default() };
        self.fleet.apply(&[record], &mut self.events);
        let answer = self.events.records()[0];
        (answer.kind == EventKind::Refused as u32)
            .then(|| Refusal::ALL.into_iter().find(|r| *r as u32 == answer.detail).expect("known"))
    }

    /// Makes ticks, and checks each; returns the kinds and ids of their events of facilities.
    fn ticks(&mut self, count: u64) -> Vec<(EventKind, u32)> {
        let mut found = Vec::new();
        for _ in 0..count {
            self.tick += 1;
            self.events.clear();
            self.fleet.step_facilities(self.tick, &mut self.events);
            self.fleet.step(None, &mut self.events);
            self.check();
            let kinds = [EventKind::DoorOpened, EventKind::DoorClosed, EventKind::LiftArrived];
            let events = self.events.records().iter();
            found.extend(events.filter_map(|event| {
                let kind = kinds.into_iter().find(|kind| *kind as u32 == event.kind)?;
                Some((kind, event.id))
            }));
        }
        found
    }

    fn door(&self, index: usize) -> DoorState {
        self.fleet.facility_states()[index].door()
    }

    fn lift(&self) -> FacilityState {
        self.fleet.facility_states()[self.graph.doors().len()]
    }

    /// Checks that each robot is where doors and cabins allow it.
    fn check(&self) {
        for robot in 0..self.fleet.robots() as u32 {
            let at = self.fleet.standing_at(robot);
            let (edge, _) = self.fleet.place(robot).expect("a robot");
            match (at, edge) {
                (Some(node), _) => self.check_at(robot, node),
                (None, Some(edge)) => self.check_on(robot, edge),
                (None, None) => panic!("robot {robot} is nowhere"),
            }
        }
    }

    fn check_on(&self, robot: u32, edge: EdgeIndex) {
        let tick = self.tick;
        for (index, door) in self.graph.doors().iter().enumerate() {
            let state = self.door(index);
            let is_in = door.edges.contains(&edge);
            assert!(!is_in || state == DoorState::Open, "tick {tick}: {robot} in {state:?} door");
        }
        let (lift, state) = (&self.graph.lifts()[0], self.lift());
        let record = self.graph.edge(edge);
        let [from, to] = [record.origin, record.destination].map(|node| level(lift, node));
        let is_there = match (from, to) {
            (Some(from), Some(to)) => {
                let way = [state.level.min(state.next_level), state.level.max(state.next_level)];
                state.is_moving() && way == [from.min(to), from.max(to)]
            }
            (Some(level), None) | (None, Some(level)) => {
                state.level == level && !state.is_moving() && state.door() == DoorState::Open
            }
            (None, None) => true,
        };
        assert!(is_there, "tick {tick}: {robot} on {}: {state:?}", record.id);
    }

    fn check_at(&self, robot: u32, node: NodeIndex) {
        let (lift, state) = (&self.graph.lifts()[0], self.lift());
        let Some(level) = level(lift, node) else { return };
        // A rider drives off and arrives within the cabin's way.
        let is_there = level == state.level || level == state.next_level;
        assert!(is_there, "tick {}: {robot} at {node:?} without a cabin: {state:?}", self.tick);
    }
}

fn level(lift: &Lift, node: NodeIndex) -> Option<u32> {
    lift.level_of(node).map(|level| level as u32)
}

#[test]
fn a_robot_rides_to_the_level_above_and_back() {
    let mut run = Run::new(&[0.8]);
    run.loops(
        4,
        &[4, 9, 10, 13, 15, 16, 19, 20, 21, 22, 23, 24, 25, 17, 18, 14, 11, 12, 6, 7, 8, 1, 2, 3],
    );
    let events = run.ticks(400 * RATE);
    let count = |wanted| events.iter().filter(|event| **event == wanted).count();
    // It takes about two minutes to get round.
    for wanted in [
        (EventKind::DoorOpened, 7),
        (EventKind::DoorClosed, 7),
        (EventKind::DoorOpened, 20),
        (EventKind::LiftArrived, 11),
        (EventKind::LiftArrived, 21),
    ] {
        assert!(count(wanted) >= 2, "{wanted:?} in {events:?}");
    }
}

#[test]
fn a_ride_takes_as_long_as_the_cabin_and_its_doors() {
    let mut run = Run::new(&[f32::INFINITY]);
    run.spawn(Placement::Node(run.node(11)), RouteSource::None).expect("in the cabin");
    let assign = |id: u32| CommandRecord { id, released: 1, ..CommandRecord::default() };
    let head =
        CommandRecord { kind: CommandKind::Assign as u32, legs: 2, ..CommandRecord::default() };
    run.fleet.apply(&[head, assign(13), assign(15)], &mut run.events);
    assert_eq!(run.command(CommandKind::CallLift, 0, 21), None);
    let mut arrived = None;
    while arrived.is_none() && run.tick < 60 * RATE {
        let events = run.ticks(1);
        let is_above = events.contains(&(EventKind::LiftArrived, 21));
        arrived = is_above.then_some(run.tick);
    }
    // It stands there with closed doors: 8 s for the cabin, 3 s to open above.
    let secs = arrived.expect("it arrives") as f64 / RATE as f64;
    assert!((11.0..12.5).contains(&secs), "{secs} s");
    run.ticks(10 * RATE);
    assert_eq!(run.fleet.standing_at(0), Some(run.node(22)), "it has left the cabin");
}

#[test]
fn a_cabin_waits_for_who_stays_in_it() {
    let mut run = Run::new(&[0.8]);
    run.spawn(Placement::Node(run.node(11)), RouteSource::None).expect("in the cabin");
    assert_eq!(run.command(CommandKind::CallLift, NO_ROBOT, 21), None);
    run.ticks(30 * RATE);
    assert_eq!((run.lift().level, run.lift().is_moving()), (0, false), "a robot stands in it");
    assert_eq!(run.lift().door(), DoorState::Open, "it isn't shut in");
}

#[test]
fn requests_hold_for_a_while_and_are_refused_where_there_is_nothing() {
    let mut run = Run::new(&[0.8]);
    run.spawn(Placement::Node(run.node(1)), RouteSource::None).expect("a robot");
    assert_eq!(run.command(CommandKind::RequestDoor, NO_ROBOT, 7), None);
    run.ticks(5 * RATE);
    assert_eq!((run.door(0), run.door(1)), (DoorState::Open, DoorState::Closed));
    run.ticks(4 * RATE);
    assert_eq!(run.command(CommandKind::RequestDoor, 0, 7), None);
    run.ticks(5 * RATE);
    assert_eq!(run.door(0), DoorState::Open, "it was requested again");
    assert_eq!(run.command(CommandKind::ReleaseDoor, 0, 7), None);
    run.ticks(4 * RATE);
    assert_eq!(run.door(0), DoorState::Closed);
    assert_eq!(run.command(CommandKind::CallLift, 0, 21), None);
    assert_eq!(run.command(CommandKind::CallLift, NO_ROBOT, 11), Some(Refusal::LiftInUse));
    assert_eq!(run.command(CommandKind::ReleaseLift, 0, 21), None);
    assert_eq!(run.command(CommandKind::CallLift, NO_ROBOT, 21), None);
    run.ticks(12 * RATE);
    assert_eq!((run.lift().level, run.lift().door()), (1, DoorState::Open));
    run.ticks(15 * RATE);
    assert_eq!(run.lift().door(), DoorState::Closed, "nobody needs it any more");
    for (kind, robot, id, refusal) in [
        (CommandKind::RequestDoor, 0, 1, Refusal::NoDoor),
        (CommandKind::RequestDoor, 0, 999, Refusal::UnknownEdge),
        (CommandKind::CallLift, 0, 1, Refusal::NoLift),
        (CommandKind::CallLift, 0, 999, Refusal::UnknownNode),
        (CommandKind::RequestDoor, 77, 7, Refusal::UnknownRobot),
        (CommandKind::SpawnAtNode, 0, 11, Refusal::NoCabin),
        (CommandKind::SpawnOnEdge, 0, 13, Refusal::NoCabin),
        (CommandKind::SpawnOnEdge, 0, 10, Refusal::NoCabin),
        (CommandKind::SpawnOnEdge, 0, 7, Refusal::EdgeClosed),
    ] {
        assert_eq!(run.command(kind, robot, id), Some(refusal), "{kind:?} {id}");
    }
}

#[test]
fn facilities_begin_where_robots_are() {
    let mut run = Run::new(&[0.8]);
    run.spawn(Placement::Node(run.node(21)), RouteSource::None).expect("the cabin comes");
    let below = run.spawn(Placement::Node(run.node(11)), RouteSource::None);
    assert_eq!(below, Err(Refusal::NoCabin), "there is one cabin");
    let door = run.graph.doors()[0].edges[0];
    run.spawn(Placement::Edge(door, 7.0), RouteSource::None).expect("in an open door");
    run.ticks(1);
    assert_eq!((run.lift().level, run.door(0)), (1, DoorState::Open));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Whatever robots do: random walks, breakdowns, and requests of an operator.
    #[test]
    fn nobody_is_in_a_closed_door_or_in_a_shaft_without_a_cabin(
        walkers in 1_u32..6,
        acceleration in prop::sample::select(vec![0.3, 1.0, f32::INFINITY]),
        deeds in prop::collection::vec((0_u32..6, 0_u32..6, 1_u64..400), 1..40),
    ) {
        let mut run = Run::new(&[acceleration]);
        for robot in 0..walkers {
            let node = run.node([1, 5, 7, 24, 27, 30][robot as usize]);
            run.spawn(Placement::Node(node), RouteSource::Random).expect("a place");
        }
        for (deed, robot, ticks) in deeds {
            let (stop, door) = ([11, 21][robot as usize % 2], [7, 20][robot as usize % 2]);
            let robot = robot % walkers;
            match deed {
                0 => drop(run.command(CommandKind::CallLift, NO_ROBOT, stop)),
                1 => drop(run.command(CommandKind::RequestDoor, NO_ROBOT, door)),
                2 => drop(run.command(CommandKind::Break, robot, 0)),
                3 => drop(run.command(CommandKind::Repair, robot, 0)),
                4 => drop(run.command(CommandKind::ReleaseLift, robot, 11)),
                _ => {}
            }
            run.ticks(ticks);
            let states = run.fleet.states();
            prop_assert!(states.iter().all(|state| *state != RobotState::Faulted as u8));
        }
    }
}
