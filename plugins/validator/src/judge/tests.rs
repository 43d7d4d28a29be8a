//! Synthetic runs: a clean one without findings, and one for each fault, planted.

use regatta_plugin::event::{BreakdownCause, EventKind, EventRecord};
use regatta_plugin::frame::{
    ColumnsMut, FrameHeader, Line, NO_EDGE, RobotState, frame_lines, stride_lines,
};
use regatta_plugin::order::{Obstacle, OrderHeader, OrderKind, OrderRecord, StopAction};
use regatta_plugin::world::{
    CurveRecord, EdgeRecord, NodeRecord, RobotTypeRecord, WorldData, ZoneRecord,
};

use super::*;

/// Ten ticks a second.
const PERIOD: f32 = 0.1;

/// Three nodes on a line, 10 m apart, with ids 1 to 3, and node 4 beside the last. Edge 0 leads
/// from 1 to 2 and may be driven in reverse gear, edge 1 from 2 to 3, edge 2 from 4 to 1 far away.
/// All are for 1 m/s; the type brakes at 0.5 m/s².
fn world() -> WorldData {
    let at = [[0.0, 0.0], [10.0, 0.0], [20.0, 0.0], [0.0, 30.0]];
    let node = |(id, [x, y]): (u32, [f32; 2])| NodeRecord { id, x, y, ..NodeRecord::default() };
    let mut robot_type = RobotTypeRecord::new("cart", 1.0, 0.6);
    robot_type.max_acceleration = 0.5;
    robot_type.max_rotation_speed = 1.0;
    let nodes = (1..).zip(at).map(node).collect();
    let mut world = WorldData { nodes, robot_types: vec![robot_type], ..WorldData::default() };
    for (id, origin, destination, back) in [(10, 0, 1, 0.5), (11, 1, 2, 0.0), (12, 3, 0, 0.0)] {
        let (from, to): ([f32; 2], [f32; 2]) = (at[origin], at[destination]);
        let length = (to[0] - from[0]).hypot(to[1] - from[1]);
        let (origin, destination) = (origin as u32, destination as u32);
        let limits = EdgeRecord { speed: 1.0, reverse_speed: back, ..EdgeRecord::default() };
        let edge = EdgeRecord { id, origin, destination, length, ..limits };
        world.add_edge(edge, [CurveRecord::straight(from, to)]);
    }
    world
}

/// A robot on an edge of the line, at a distance along it and a speed.
fn on(edge: u32, s: f32, speed: f32) -> Row {
    let state = if speed == 0.0 { RobotState::Idle } else { RobotState::Driving };
    let position = Vec2::new(10.0 * edge as f32 + s, 0.0);
    Row { position, theta: 0.0, speed, s, edge, state }
}

fn show(judge: &mut Judge, tick: u64, rows: &[Row]) {
    let mut lines = vec![Line::default(); frame_lines(rows.len())];
    let columns = ColumnsMut::split(&mut lines, rows.len());
    for (robot, row) in rows.iter().enumerate() {
        (columns.x[robot], columns.y[robot]) = row.position.into();
        columns.theta[robot] = row.theta;
        (columns.speed[robot], columns.s[robot]) = (row.speed, row.s);
        (columns.edge[robot], columns.state[robot]) = (row.edge, row.state as u8);
    }
    let header = FrameHeader {
        run_id: 7,
        tick,
        sim_time_nanos: tick * 100_000_000,
        tick_period_nanos: 100_000_000,
        robots: rows.len() as u32,
        stride_lines: stride_lines(rows.len()) as u32,
        ..FrameHeader::default()
    };
    judge.take_frame(&Frame::new(&header, &lines).expect("it fits"));
}

fn judge() -> Judge {
    let settings = Settings {
        unserved_after_secs: 60.0,
        idle_after_secs: 30.0,
        standstill_after_secs: 20.0,
        stuck_after_secs: 40.0,
        examples: 3,
    };
    let mut judge = Judge::new(settings);
    judge.take_world(&world().view(7, 1));
    judge
}

/// The kinds and counts of a report.
fn found(judge: Judge) -> Vec<(Kind, u64)> {
    let report = judge.finish();
    Kind::all().map(|kind| (kind, report.count(kind))).filter(|(_, count)| *count > 0).collect()
}

/// Judges frames of one robot, one a tick.
fn judged(rows: &[Row]) -> Vec<(Kind, u64)> {
    let mut judge = judge();
    (0..).zip(rows).for_each(|(tick, row)| show(&mut judge, tick, std::slice::from_ref(row)));
    found(judge)
}

/// A drive over both edges of the line, from a stand to a stand.
fn drive() -> Vec<Row> {
    let (mut rows, mut way, mut speed) = (Vec::new(), 0.0_f32, 0.0_f32);
    while rows.len() < 400 {
        let edge = u32::from(way >= 10.0);
        rows.push(on(edge, way - 10.0 * edge as f32, speed));
        let brakes = 20.0 - way <= speed * speed + 0.1 * speed + 0.005;
        let next = if brakes { (speed - 0.05).max(0.0) } else { (speed + 0.05).min(1.0) };
        way = (way + 0.5 * (speed + next) * PERIOD).min(20.0);
        speed = next;
    }
    rows
}

#[test]
fn a_clean_drive_has_no_findings() {
    assert_eq!(judged(&drive()), []);
    let every_fifth: Vec<_> = (0..).zip(drive()).filter(|(tick, _)| tick % 5 == 0).collect();
    let mut judge = judge();
    every_fifth.iter().for_each(|(tick, row)| show(&mut judge, *tick, std::slice::from_ref(row)));
    assert_eq!(judge.report.ticks_between, 4 * 79);
    assert_eq!(found(judge), []);
}

#[test]
fn each_fault_of_motion_is_found_once() {
    use Kind::{
        Acceleration, BrokenRoute, HardBraking, Heading, InvalidPose, OffGraph, Rotation, Speed,
        Teleport, WrongDirection,
    };
    let stand = on(0, 5.0, 0.0);
    let turning = |theta| Row { theta, state: RobotState::Turning, ..on(0, 10.0, 0.0) };
    let cases: [(Kind, Vec<Row>); 13] = [
        (
            OffGraph,
            vec![
                stand,
                Row { position: Vec2::new(stand.position.x, 0.01), ..stand },
                Row { position: Vec2::new(stand.position.x, 0.01), ..stand },
            ],
        ),
        (OffGraph, vec![Row { s: 11.0, ..on(0, 10.0, 0.0) }]),
        (Heading, vec![Row { theta: 0.05, ..stand }]),
        (WrongDirection, vec![on(0, 5.0, 1.0), on(0, 4.95, 1.0)]),
        (WrongDirection, vec![on(1, 5.0, -0.3), on(1, 4.97, -0.3)]),
        (Teleport, vec![stand, on(0, 5.2, 0.0)]),
        (Teleport, vec![on(0, 9.9, 0.0), on(1, 0.1, 0.0)]),
        (Speed, vec![on(0, 5.0, 1.1)]),
        (Acceleration, vec![stand, on(0, 5.003, 0.06)]),
        (HardBraking, vec![on(0, 5.0, 1.0), on(0, 5.09, 0.9)]),
        (Rotation, vec![turning(0.0), turning(0.05), turning(0.2)]),
        (
            BrokenRoute,
            vec![
                on(0, 0.02, 0.0),
                Row {
                    position: Vec2::new(0.0, 0.02),
                    theta: -std::f32::consts::FRAC_PI_2,
                    s: 29.98,
                    ..on(2, 0.0, 0.0)
                },
            ],
        ),
        (InvalidPose, vec![stand, Row { position: Vec2::NAN, ..stand }, stand]),
    ];
    for (kind, rows) in cases {
        let found = judged(&rows);
        let expected: &[_] = &[(kind, 1)];
        assert_eq!(found, expected, "{rows:?}");
    }
}

#[test]
fn reverse_gear_and_turning_back_at_a_node_are_allowed() {
    let back: Vec<_> = (0..20)
        .map(|tick| on(0, 10.0 - 0.05 * tick as f32, if tick == 0 { 0.0 } else { -0.05 }))
        .collect();
    let slow: Vec<_> = (0..20)
        .map(|tick| on(0, 10.0 - 0.005 * tick as f32, if tick == 0 { 0.0 } else { -0.05 }))
        .collect();
    assert_eq!(judged(&slow), []);
    assert_eq!(judged(&back), [], "the judge doesn't compare speeds with distances");
}

#[test]
fn a_robot_that_was_spawned_elsewhere_has_not_jumped() {
    let mut judge = judge();
    show(&mut judge, 0, &[on(0, 5.0, 0.0)]);
    let spawned = EventRecord { kind: EventKind::Spawned as u32, ..EventRecord::default() };
    let header = |tick| EventHeader { run_id: 7, tick, ..EventHeader::default() };
    judge.take_events(&header(2), &[spawned], false);
    show(&mut judge, 1, &[on(0, 5.0, 0.0)]);
    show(&mut judge, 2, &[on(1, 5.0, 0.0)]);
    show(
        &mut judge,
        3,
        &[Row { state: RobotState::Absent, position: Vec2::splat(99.0), ..on(1, 5.0, 0.0) }],
    );
    show(
        &mut judge,
        4,
        &[Row { position: Vec2::new(20.0, 0.0), edge: NO_EDGE, ..on(1, 5.0, 0.0) }],
    );
    judge.take_events(&header(5), &[], true);
    show(&mut judge, 5, &[on(0, 2.0, 0.0)]);
    assert_eq!(found(judge), [], "a robot that the events, or lost ones, may have placed");
}

#[test]
fn a_robot_with_a_flat_battery_is_found_and_one_that_breaks_otherwise_is_not() {
    let mut judge = judge();
    show(&mut judge, 0, &[on(0, 5.0, 0.0)]);
    let broken = EventRecord { kind: EventKind::BrokenDown as u32, ..EventRecord::default() };
    let flat = EventRecord { detail: BreakdownCause::FlatBattery as u32, ..broken };
    let header = EventHeader { run_id: 7, tick: 1, ..EventHeader::default() };
    judge.take_events(&header, &[broken, flat], false);
    show(&mut judge, 1, &[Row { state: RobotState::Broken, ..on(0, 5.0, 0.0) }]);
    assert_eq!(found(judge), [(Kind::FlatBattery, 1)]);
}

#[test]
fn a_contact_counts_once_and_has_a_duration() {
    let mut judge = judge();
    for tick in 0..50 {
        let apart = if (10..30).contains(&tick) || tick == 40 { 0.99 } else { 1.01 };
        // On no edge: this is about contacts alone.
        let row = |x| Row { position: Vec2::new(x, 0.0), edge: NO_EDGE, ..on(0, 0.0, 0.0) };
        show(&mut judge, tick, &[row(5.0), row(5.0 + apart), row(9.0)]);
    }
    assert_eq!(judge.contacts(), 1);
    let report = judge.finish();
    let contact = &report.kinds[0];
    assert_eq!((contact.kind, contact.count), (Kind::Contact, 1));
    let example = &contact.examples[0];
    assert_eq!((example.tick, &example.robots[..]), (10, &[0, 1][..]));
    assert!((example.duration_secs.expect("it lasted") - 1.9).abs() < 1e-9);
    assert!((example.value.expect("a depth") - 0.01).abs() < 1e-4);
    assert!(
        report.to_markdown().contains("robots 0 and 1") && report.to_json().contains("\"contact\"")
    );
}

#[test]
fn robots_on_two_levels_are_never_in_contact() {
    let mut world = world();
    for (edge, name) in world.edges.iter_mut().zip(["L1", "L2", ""]) {
        edge.level = world.texts.add(name);
    }
    for (edges, contacts) in [([0, 0], 1), ([0, 1], 0), ([1, 2], 1), ([0, NO_EDGE], 1)] {
        let mut judge = judge();
        judge.take_world(&world.view(7, 1));
        let at = |edge| Row { position: Vec2::new(5.0, 0.0), edge, ..on(0, 5.0, 0.0) };
        show(&mut judge, 0, &edges.map(at));
        assert_eq!(judge.contacts(), contacts, "on the edges {edges:?}");
    }
}

#[test]
fn a_zone_has_room_for_so_many_robots() {
    let mut world = world();
    let name = world.texts.add("door");
    world.add_zone(ZoneRecord { name, capacity: 1, ..ZoneRecord::default() }, [1], [0]);
    let mut judge = judge();
    judge.take_world(&world.view(7, 1));
    // Node 2, the end of edge 10, is in the zone; edge 11, which leaves it, isn't.
    let places = [(0, 3.0), (1, 0.0), (1, 0.5), (1, 0.0), (1, 0.5)];
    for (tick, (edge, s)) in (0..).zip(places) {
        show(&mut judge, tick, &[on(0, 8.0, 0.0), on(edge, s, 0.0)]);
    }
    let report = judge.finish();
    let zone = report.found().find(|report| report.kind == Kind::Zone).expect("two breaches");
    assert_eq!((zone.count, zone.examples[1].tick), (2, 3));
    assert_eq!(
        (&*zone.examples[0].note, &zone.examples[0].robots[..]),
        ("2 in zone `door`, which has room for 1", &[0, 1][..])
    );
}

#[test]
fn robots_in_a_zone_of_one_direction_have_entered_at_one_node() {
    let mut world = world();
    world.add_zone(ZoneRecord { rule: 1, ..ZoneRecord::default() }, [], [0]);
    let count = |second: Row| {
        let mut judge = judge();
        judge.take_world(&world.view(7, 1));
        for tick in 0..3 {
            show(&mut judge, tick, &[on(0, 2.0, 0.0), second]);
        }
        judge.finish().count(Kind::Zone)
    };
    assert_eq!((count(on(0, 8.0, 0.0)), count(on(1, 0.5, 0.0))), (0, 0));
    assert_eq!(count(on(0, 8.0, -0.5)), 1, "it comes from the other end");
}

/// Records of one order: tick, and what happened.
type Log = Vec<(u64, OrderRecord)>;

/// A transport from node 2 to node 3 by robot 0, as it should be: it stands at node 2 from tick 10
/// to 40, drives, and stands at node 3 from tick 300 on.
fn transport() -> Log {
    let stop = |tick, kind, stop, node, action| {
        (tick, OrderRecord::new(5, kind).of_robot(0).at_stop(stop, node, action))
    };
    let plan = |index, node, action| {
        let record = OrderRecord::new(5, OrderKind::Stop).at_stop(index, node, action);
        (0, OrderRecord { dwell_secs: 2.0, ..record })
    };
    vec![
        (0, OrderRecord { detail: 2, ..OrderRecord::new(5, OrderKind::Created) }),
        plan(0, 2, StopAction::Pick),
        plan(1, 3, StopAction::Drop),
        (1, OrderRecord::new(5, OrderKind::Assigned).of_robot(0)),
        stop(10, OrderKind::Arrived, 0, 2, StopAction::Pick),
        stop(30, OrderKind::Handled, 0, 2, StopAction::Pick),
        stop(300, OrderKind::Arrived, 1, 3, StopAction::Drop),
        stop(320, OrderKind::Handled, 1, 3, StopAction::Drop),
        (320, OrderRecord::new(5, OrderKind::Finished).of_robot(0)),
    ]
}

/// Returns the row of robot 0 at a tick of the transport.
fn carrier(tick: u64) -> Row {
    match tick {
        0..10 => on(0, 10.0 - 0.01 * (10 - tick) as f32, 0.1),
        10..=40 => on(0, 10.0, 0.0),
        41..300 => on(1, 10.0 * (tick - 40) as f32 / 260.0, 10.0 / 26.0),
        _ => on(1, 10.0, 0.0),
    }
}

/// Judges an order log; records come `late` ticks after their frame.
fn judged_log(log: &[(u64, OrderRecord)], late: u64, last: u64) -> Vec<(Kind, u64)> {
    judged_log_without(log, late, last, 0..0)
}

/// Judges an order log without the frames of some ticks.
fn judged_log_without(
    log: &[(u64, OrderRecord)],
    late: u64,
    last: u64,
    missed: std::ops::Range<u64>,
) -> Vec<(Kind, u64)> {
    let mut judge = judge();
    // Another test checks the carrier's speed between stops.
    judge.world.robot_types[0].record.max_acceleration = f32::INFINITY;
    for tick in 0..=last {
        if !missed.contains(&tick) {
            show(&mut judge, tick, &[carrier(tick)]);
        }
        for (at, record) in log.iter().filter(|(at, _)| at + late == tick) {
            judge.take_orders(
                &OrderHeader { run_id: 7, tick: *at, ..OrderHeader::default() },
                0,
                &[*record],
            );
        }
    }
    found(judge)
}

#[test]
fn a_transport_as_it_should_be_has_no_findings() {
    assert_eq!(judged_log(&transport(), 0, 400), []);
    assert_eq!(judged_log(&transport(), 7, 400), [], "the log comes late");
}

#[test]
fn an_order_that_is_open_for_long_is_told_as_under_way_if_a_robot_has_it() {
    for (records, note) in [(3, "no robot has it"), (4, "under way")] {
        let mut judge = judge();
        for tick in 0..=700 {
            show(&mut judge, tick, &[carrier(tick)]);
            for (at, record) in transport()[..records].iter().filter(|(at, _)| *at == tick) {
                let header = OrderHeader { run_id: 7, tick: *at, ..OrderHeader::default() };
                judge.take_orders(&header, 0, &[*record]);
            }
        }
        let report = judge.finish();
        let unserved = report.found().find(|found| found.kind == Kind::Unserved);
        let notes = unserved.map(|found| found.examples[0].note.to_string());
        assert_eq!(notes.as_deref(), Some(note));
    }
}

#[test]
fn a_robot_that_leaves_in_a_missed_frame_has_handled_its_stop() {
    let mut log = transport();
    log[5].0 = 40;
    for missed in [38..41, 39..42, 30..60] {
        assert_eq!(judged_log_without(&log, 7, 400, missed.clone()), [], "{missed:?}");
    }
    // Frame 41 shows that it drives.
    log[5].0 = 41;
    let found = judged_log_without(&log, 7, 400, 37..41);
    assert_eq!(found, [(Kind::WrongPlace, 1), (Kind::MovedInDwell, 1)]);
}

/// The transport with a change.
fn changed(change: impl FnOnce(&mut Log)) -> Vec<(Kind, u64)> {
    let mut log = transport();
    change(&mut log);
    judged_log(&log, 0, 400)
}

#[test]
fn each_fault_of_an_order_is_found() {
    use Kind::{
        ContradictoryRecords, DoneTwice, DropWithoutPick, MovedInDwell, ShortDwell, SkippedStop,
        TwoOrders, Unserved, WrongPlace,
    };
    let has = |found: Vec<(Kind, u64)>, kind: Kind| {
        assert!(found.iter().any(|(other, _)| *other == kind), "{kind:?} not in {found:?}");
    };
    assert_eq!(changed(|log| log[5].0 = 28), [(ShortDwell, 1)]);
    assert_eq!(changed(|log| log[5].0 = 60), [(WrongPlace, 1), (MovedInDwell, 1)]);
    assert_eq!(
        changed(|log| log[6].0 = 290),
        [(WrongPlace, 1), (MovedInDwell, 1)],
        "arrives before it stands"
    );
    assert_eq!(
        changed(|log| (log[6].1.node, log[7].1.node, log[2].1.node) = (1, 1, 1)),
        [(WrongPlace, 2)]
    );
    assert_eq!(changed(|log| log[1].1.action = StopAction::None as u32), [(DropWithoutPick, 1)]);
    has(changed(|log| drop(log.drain(4..6))), SkippedStop);
    assert_eq!(changed(|log| drop(log.drain(6..8))), [(SkippedStop, 1)]);
    assert_eq!(changed(|log| log.push((330, log[8].1))), [(DoneTwice, 1)]);
    assert_eq!(
        changed(|log| log.push((330, log[0].1))),
        [(ContradictoryRecords, 1)],
        "created twice"
    );
    assert_eq!(
        changed(|log| drop(log.drain(4..5))),
        [(ContradictoryRecords, 1)],
        "handled without an arrival"
    );
    assert_eq!(
        changed(|log| drop(log.drain(3..4))),
        [(ContradictoryRecords, 5)],
        "no robot has it"
    );
    assert_eq!(
        changed(|log| log[5].1.kind = 99),
        [(DropWithoutPick, 1), (SkippedStop, 1), (ContradictoryRecords, 2)]
    );
    let second = |log: &mut Log| {
        log.push((50, OrderRecord::new(6, OrderKind::Created)));
        log.push((51, OrderRecord::new(6, OrderKind::Assigned).of_robot(0)));
        log.push((52, OrderRecord::new(6, OrderKind::Cancelled).of_robot(0)));
    };
    assert_eq!(changed(second), [(TwoOrders, 1)]);
    let withdrawn =
        |log: &mut Log| log.insert(6, (50, OrderRecord::new(5, OrderKind::Withdrawn).of_robot(0)));
    has(changed(withdrawn), ContradictoryRecords);
    assert_eq!(judged_log(&transport()[..3], 0, 700), [(Unserved, 1), (Kind::Idle, 1)]);
    assert_eq!(judged_log(&transport()[..3], 0, 280), [], "not yet");
}

#[test]
fn an_order_that_waits_for_a_storage_place_does_not_wait_for_a_robot() {
    let obstacle = Obstacle::NoPlace as u32;
    let blocked = OrderRecord { detail: obstacle, ..OrderRecord::new(5, OrderKind::Unroutable) };
    let mut log = transport()[..3].to_vec();
    log.push((2, blocked));
    assert_eq!(judged_log(&log, 0, 700), [(Kind::Unserved, 1)]);
    log.push((20, OrderRecord::new(5, OrderKind::Reopened)));
    assert_eq!(judged_log(&log, 0, 700), [(Kind::Unserved, 1), (Kind::Idle, 1)]);
    log.push((21, OrderRecord::new(5, OrderKind::Assigned).of_robot(0)));
    log.push((22, OrderRecord::new(5, OrderKind::Withdrawn).of_robot(0)));
    log.push((23, blocked));
    assert_eq!(judged_log(&log, 0, 700), [(Kind::Unserved, 1)]);
}

#[test]
fn a_robot_that_charges_is_not_idle() {
    let mut judge = judge();
    judge.world.robot_types[0].record.max_acceleration = f32::INFINITY;
    judge.take_orders(
        &OrderHeader { run_id: 7, ..OrderHeader::default() },
        0,
        &[OrderRecord::new(5, OrderKind::Created)],
    );
    for tick in 0..=1500 {
        show(&mut judge, tick, &[on(0, 2.0, 0.0), on(1, 2.0, 0.0)]);
        judge.take_activities(
            &[Activity::Charging, Activity::Idle].map(|activity| f32::from(activity as u8)),
        );
    }
    let idle = judge.findings.examples(Kind::Idle);
    assert_eq!(idle.iter().map(|found| &*found.robots).collect::<Vec<_>>(), [&[1]]);
}

#[test]
fn a_log_with_a_gap_is_judged_as_far_as_it_is_known() {
    let mut judge = judge();
    judge.world.robot_types[0].record.max_acceleration = f32::INFINITY;
    for tick in 0..=400 {
        show(&mut judge, tick, &[carrier(tick)]);
        for (number, (at, record)) in
            transport().iter().enumerate().filter(|(_, (at, _))| *at == tick)
        {
            if number != 5 {
                let header = OrderHeader { run_id: 7, tick: *at, ..OrderHeader::default() };
                judge.take_orders(&header, u64::from(number == 6), &[*record]);
            }
        }
    }
    assert_eq!(judge.report.order_samples_missed, 1);
    assert_eq!(found(judge), []);
}

/// Judges a transport without its sixth record. `sequence` numbers the samples.
fn judged_without_sixth(sequence: fn(u64) -> u64) -> Vec<(Kind, u64)> {
    let mut judge = judge();
    judge.world.robot_types[0].record.max_acceleration = f32::INFINITY;
    let log: Vec<_> = (0..).zip(transport()).filter(|(number, _)| *number != 5).collect();
    for tick in 0..=400 {
        show(&mut judge, tick, &[carrier(tick)]);
        for (number, (at, record)) in log.iter().filter(|(_, (at, _))| *at == tick) {
            let sequence = sequence(*number);
            let header = OrderHeader { run_id: 7, tick: *at, sequence, ..OrderHeader::default() };
            judge.take_orders(&header, 0, &[*record]);
        }
    }
    found(judge)
}

#[test]
fn a_killed_manager_may_have_told_less_than_the_next_one_knows() {
    assert_ne!(judged_without_sixth(|number| number + 1), []);
    let of_two_managers = |number| if number < 5 { number + 1 } else { number - 5 };
    assert_eq!(judged_without_sixth(of_two_managers), []);
}

/// Judges the transport as the log of run 7, whose samples have the numbers from `first` on. The
/// samples of the first ticks are there `early` ticks before their frame, and so before the run's
/// first one.
fn numbered(log: &[(u64, OrderRecord)], first: u64, early: u64) -> Vec<(Kind, u64)> {
    let mut judge = judge();
    judge.world.robot_types[0].record.max_acceleration = f32::INFINITY;
    let mut samples = log.iter().zip(first..).peekable();
    for tick in 0..=400 {
        while let Some(((at, record), sequence)) =
            samples.next_if(|((at, _), _)| *at <= tick + early)
        {
            judge.take_orders(
                &OrderHeader { run_id: 7, tick: *at, sequence, ..OrderHeader::default() },
                0,
                &[*record],
            );
        }
        show(&mut judge, tick, &[carrier(tick)]);
    }
    found(judge)
}

#[test]
fn what_was_logged_before_the_judge_joined_is_unknown() {
    assert_eq!(numbered(&transport(), 1, 0), []);
    assert_eq!(numbered(&transport()[3..], 4, 0), [], "joined after the stops were recorded");
    assert_eq!(
        numbered(&transport()[3..], 1, 0)[0].0,
        Kind::ContradictoryRecords,
        "nothing was before: they weren't told"
    );
}

#[test]
fn a_log_that_is_ahead_of_its_run_is_kept() {
    assert_eq!(numbered(&transport(), 1, 30), []);
    let mut judge = judge();
    judge.world.robot_types[0].record.max_acceleration = f32::INFINITY;
    show(&mut judge, 0, &[carrier(0)]);
    judge.take_orders(
        &OrderHeader { run_id: 8, tick: 1, ..OrderHeader::default() },
        0,
        &[transport()[0].1],
    );
    assert_eq!(judge.orders.len(), 0);
    assert_eq!(judge.next_orders.as_ref().map(|(run, _)| *run), Some(8));
}

/// Judges a robot with an order, a frame a second, and others without one. Returns the findings
/// about its progress.
fn progress(rows: impl Fn(u64) -> Row, secs: u64) -> Vec<(Kind, u64)> {
    let mut judge = judge();
    judge.world.robot_types[0].record.max_acceleration = f32::INFINITY;
    let log = [
        OrderRecord { detail: 1, ..OrderRecord::new(5, OrderKind::Created) },
        OrderRecord::new(5, OrderKind::Stop).at_stop(0, 3, StopAction::None),
        OrderRecord::new(5, OrderKind::Assigned).of_robot(0),
    ];
    let header = OrderHeader { run_id: 7, tick: 0, sequence: 1, ..OrderHeader::default() };
    judge.take_orders(&header, 0, &log);
    for second in 0..secs {
        show(&mut judge, 10 * second, &[rows(second), on(2, 1.0, 0.0)]);
    }
    let mut found = found(judge);
    found.retain(|(kind, _)| matches!(kind, Kind::Standstill | Kind::Livelock | Kind::Stuck));
    found
}

#[test]
fn a_fleet_that_stands_with_orders_is_found_once() {
    let waiting = Row { state: RobotState::Waiting, ..on(0, 5.0, 0.0) };
    assert_eq!(progress(|_| waiting, 7), [], "not yet");
    assert_eq!(progress(|_| waiting, 15), [(Kind::Standstill, 1)], "it lasts at the end");
    assert_eq!(progress(|_| waiting, 200), [(Kind::Standstill, 1)]);
    let on_its_way = |second: u64| match second {
        0..15 => waiting,
        _ => on(0, 5.0 + 0.5 * (second - 14) as f32, 0.5),
    };
    assert_eq!(progress(on_its_way, 20), [], "it has ended");
    let broken = Row { state: RobotState::Broken, ..waiting };
    assert_eq!(progress(|_| broken, 200), [], "it can't drive");
    let creeping = |second| Row { ..on(0, 0.05 * second as f32, 0.05) };
    assert_eq!(progress(creeping, 190), []);
}

#[test]
fn a_robot_that_drives_to_and_fro_without_arriving_is_found() {
    let to_and_fro = |second: u64| on(u32::from(second % 10 < 5), 0.5 * (second % 5) as f32, 0.5);
    assert_eq!(progress(to_and_fro, 35), [], "not yet");
    assert_eq!(progress(to_and_fro, 200), [(Kind::Livelock, 1)]);
}

#[test]
fn a_robot_that_stands_while_others_drive_is_found() {
    let mut judge = judge();
    let mut log = Vec::new();
    for order in 0..2 {
        log.push(OrderRecord { detail: 1, ..OrderRecord::new(order, OrderKind::Created) });
        log.push(OrderRecord::new(order, OrderKind::Stop).at_stop(0, 3, StopAction::None));
        log.push(OrderRecord::new(order, OrderKind::Assigned).of_robot(order as u32));
    }
    let header = OrderHeader { run_id: 7, tick: 0, sequence: 1, ..OrderHeader::default() };
    judge.take_orders(&header, 0, &log);
    for second in 0..140 {
        let row = match second {
            0..110 => Row { state: RobotState::Waiting, ..on(1, 5.0, 0.0) },
            _ => on(1, 5.0 + 0.1 * (second - 109) as f32, 0.1),
        };
        show(&mut judge, 10 * second, &[row, on(0, 0.05 * second as f32, 0.05)]);
    }
    let report = judge.finish();
    assert_eq!((report.count(Kind::Stuck), report.count(Kind::Standstill)), (1, 0));
    let stuck = report.found().find(|report| report.kind == Kind::Stuck).expect("a finding");
    let example = &stuck.examples[0];
    assert_eq!((&example.robots[..], example.edge), (&[0][..], Some(11)));
    let duration_secs = example.duration_secs.expect("a duration");
    assert!((109.0..=111.0).contains(&duration_secs), "it stood for {duration_secs} s");
}
