use std::time::{Duration, Instant};

use regatta_plugin::column::{GOAL, WAITS_FOR};
use regatta_plugin::frame::RobotState;
use regatta_plugin::route::RouteResponse;
use regatta_plugin::world::{CurveRecord, EdgeRecord, NodeRecord, WorldData};
use regatta_plugin::{FleetName, ProducerPorts, RouteServer};
use regatta_scene::plans::{GoalMark, WaitArrow, Waiting};
use regatta_scene::route::RouteSegment;

use super::*;
use crate::worker::Inbox;

/// Two edges of ten metres in a row, and their nodes.
fn world() -> WorldData {
    let node = |id, x| NodeRecord { id, x, ..NodeRecord::default() };
    let mut world = WorldData {
        nodes: vec![node(10, 0.0), node(11, 10.0), node(12, 20.0)],
        ..WorldData::default()
    };
    for i in 0..2 {
        let line = CurveRecord::straight([i as f32 * 10.0, 0.0], [i as f32 * 10.0 + 10.0, 0.0]);
        world.add_edge(
            EdgeRecord { length: 10.0, origin: i, destination: i + 1, ..EdgeRecord::default() },
            [line],
        );
    }
    world
}

/// Publishes a frame of three robots, with the columns of a fleet manager: the first two wait for
/// each other.
fn publish(producer: &mut ProducerPorts, tick: u64) {
    producer.publish_column(GOAL.name(), tick, &[12.0, 12.0, f32::NAN]).expect("a column");
    producer.publish_column(WAITS_FOR.name(), tick, &[1.0, 0.0, f32::NAN]).expect("a column");
    let mut frame = producer.loan(3).expect("a frame");
    frame.header_mut().tick = tick;
    let columns = frame.columns_mut();
    columns.edge[..3].copy_from_slice(&[0, 1, 1]);
    columns.s[..3].copy_from_slice(&[4.0, 5.0, 10.0]);
    columns.state[..3].copy_from_slice(
        &[RobotState::Driving, RobotState::Driving, RobotState::Idle].map(|state| state as u8),
    );
    frame.send().expect("sent");
    producer.update();
}

/// Returns the first complete report of what is watched of a fleet, and the robots whose routes
/// were asked for.
fn watched(
    test: &str,
    watch: PlanQuery,
    is_complete: impl Fn(&PlanReport) -> bool,
) -> (PlanReport, Vec<u32>) {
    let fleet: FleetName =
        format!("unit-viewer-{test}-{}", std::process::id()).parse().expect("a name");
    let mut producer = ProducerPorts::create(&fleet, 3).expect("a producer");
    let mut routes = RouteServer::open_on(producer.participant()).expect("routes");
    producer.publish_world(&world()).expect("a world");
    let run = producer.run_id();
    let inbox = Inbox::open(&fleet, watch).expect("a thread").expect("something to watch");
    let (deadline, mut asked) = (Instant::now() + Duration::from_secs(60), Vec::new());
    let report = (1..).find_map(|tick| {
        assert!(Instant::now() < deadline, "no report after {} requests", asked.len());
        publish(&mut producer, tick);
        let answer = |robot, legs: &[u32]| {
            RouteResponse::unknown(run, tick, robot).with_legs(
                1,
                legs.len(),
                legs.iter().map(|edge| (*edge, false)),
            )
        };
        let answered = routes.answer(8, |request| {
            asked.push(request.robot);
            if request.robot == 0 { answer(0, &[0, 1]) } else { answer(1, &[1]) }
        });
        answered.expect("answered");
        std::thread::sleep(Duration::from_millis(2));
        let found = inbox.newest().expect("readable")?;
        (found.facts.waiting.is_some() && found.facts.has_goals && is_complete(&found))
            .then_some(found)
    });
    (report.expect("a report"), asked)
}

#[test]
fn routes_goals_and_waits_of_a_fleet_are_collected() {
    let watch = PlanQuery { plans: true, waits: true, ..PlanQuery::default() };
    let (report, asked) = watched("plans", watch, |found| found.lines.len() == 3);
    // The rest of edge 0 for the first robot, and of edge 1 for the second one; all of edge 1
    // is the first one's horizon.
    let lines: Vec<_> = report.lines.iter().map(|line| (line.curve, line.released)).collect();
    assert_eq!(lines, [(1, 0), (0, 1), (1, 1)]);
    assert_eq!(report.goals, [GoalMark { node: 2, selected: 0 }]);
    assert_eq!(report.facts.waiting, Some(Waiting { robots: 2, in_rings: 2 }));
    let known = report.facts.routes.expect("routes are watched");
    assert_eq!((known.known, known.under_way), (2, 2));
    assert!(!report.facts.lacks_routes() && !report.facts.is_filtered);
    assert!(asked.iter().all(|robot| *robot < 2), "an idle robot has no route");
}

#[test]
fn of_a_filter_only_robots_that_match_and_selected_ones_are_watched() {
    let mut matching = RobotSet::new(3);
    matching.insert(1);
    let watch =
        PlanQuery { plans: true, waits: true, matching: Some(matching), selected: Vec::new() };
    let (report, asked) = watched("matching-plans", watch.clone(), |found| !found.lines.is_empty());
    let line = |line: &RouteSegment| (line.curve, line.released);
    let arrow = |from, to| WaitArrow { from, to, in_ring: 1 };
    assert_eq!(report.lines.iter().map(line).collect::<Vec<_>>(), [(1, 1)]);
    assert_eq!(report.arrows, [arrow(1, 0)]);
    assert_eq!(report.goals, [GoalMark { node: 2, selected: 0 }]);
    assert!(asked.iter().all(|robot| *robot == 1), "{asked:?}");
    let (counts, known) = (report.facts.waiting, report.facts.routes.expect("routes are watched"));
    assert_eq!(
        (counts, known.known, known.under_way, report.facts.is_filtered),
        (Some(Waiting { robots: 1, in_rings: 1 }), 1, 1, true)
    );

    let watch = PlanQuery { selected: vec![0], ..watch };
    let (report, _) = watched("selected-plans", watch, |found| found.lines.len() == 3);
    assert_eq!(report.arrows, [arrow(0, 1), arrow(1, 0)]);
    assert_eq!(report.goals, [GoalMark { node: 2, selected: 1 }]);
    let (counts, known) = (report.facts.waiting, report.facts.routes.expect("routes are watched"));
    assert_eq!(
        (counts, known.known, known.under_way),
        (Some(Waiting { robots: 1, in_rings: 1 }), 1, 1),
        "the selected robot is not counted"
    );
}

#[test]
fn robots_that_begin_to_match_are_no_other_wish() {
    let watch = |robots| PlanQuery {
        plans: true,
        matching: Some(RobotSet::new(robots)),
        ..PlanQuery::default()
    };
    assert!(!watch(3).is_urgent(&watch(64)));
    assert!(
        watch(3).is_urgent(&PlanQuery { plans: true, ..PlanQuery::default() }),
        "another filter"
    );
    assert!(watch(3).is_urgent(&PlanQuery { selected: vec![1], ..watch(3) }));
}

#[test]
fn nothing_is_watched_without_a_wish() {
    let fleet: FleetName =
        format!("unit-viewer-no-plans-{}", std::process::id()).parse().expect("a name");
    assert!(Inbox::open(&fleet, PlanQuery::default()).expect("no thread").is_none());
}
