//! The choice of a planner for some roads and robots.

use super::{Candidate, Fallback, Planner, PlannerKind, Plans, Rate, two_way_share};
use crate::model::{Model, drive, worlds};
use crate::roads::Roads;
use crate::traffic::Traffic;
use regatta_plugin::world::{Orientation, WorldData};

/// The name of the planner that is chosen for some robots without a rehearsal.
fn chosen(world: &WorldData, robots: usize) -> String {
    let roads = Roads::new(&world.view(1, 1));
    let (planner, _) = PlannerKind::Auto.planner(&roads, robots, None);
    format!("{planner:?}")
}

#[test]
fn single_tracks_get_committed_ways_unless_robots_are_many() {
    let track = worlds::single_track(7);
    assert!(chosen(&track, 6).contains("planner: Committed"));
    assert!(chosen(&track, 65).contains("planner: Lanes"));
}

#[test]
fn a_single_track_elsewhere_does_not_count() {
    let points = [[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [0.0, 9.0], [50.0, 0.0], [59.0, 0.0]];
    let edges = [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 4]];
    let world = worlds::straight(&points, &edges, [0.9, 0.6], Orientation::Tangential);
    assert!(!chosen(&world, 1).contains("Committed"), "the ring is driven one way");
}

/// A planner that plans nothing.
#[derive(Debug)]
struct Nothing;

impl Planner for Nothing {
    fn plan(&mut self, _traffic: &Traffic<'_>, _plans: &mut Plans) {}
}

#[test]
fn another_planner_takes_over_where_all_robots_stand() {
    let maker = |_: &Roads| -> Box<dyn Planner> {
        let kinds = [PlannerKind::Lanes, PlannerKind::Committed];
        Box::new(Fallback::new(Box::new(Nothing), kinds.map(Candidate::from).to_vec()))
    };
    let model = drive("fallback", &worlds::single_track(7), (3, 1), 900, maker);
    assert!(model.total() > 20, "{}", model.total());
    assert_eq!(model.counts().last(), Some(&("takeovers", 1)));
}

/// Drives robots on a single track, where they jam under `lanes`; committed ways carried so many
/// stops per second in a rehearsal.
fn jammed_under_lanes<const PER_HOUR: u32>() -> Model {
    let maker = |roads: &Roads| -> Box<dyn Planner> {
        let rate = Rate::Rehearsed(f64::from(PER_HOUR) / 3600.0);
        let candidates =
            vec![PlannerKind::Lanes.into(), Candidate { kind: PlannerKind::Committed, rate }];
        Box::new(Fallback::new(PlannerKind::Lanes.plain(roads), candidates))
    };
    drive("jammed", &worlds::single_track(7), (6, 1), 1800, maker)
}

#[test]
fn a_planner_that_carries_clearly_more_takes_over() {
    let (weak, strong) = (jammed_under_lanes::<10>(), jammed_under_lanes::<900>());
    assert_eq!(weak.counts().last(), Some(&("takeovers", 0)));
    assert_eq!(strong.counts().last(), Some(&("takeovers", 1)));
    assert!(strong.total() > weak.total(), "{} {}", strong.total(), weak.total());
}

#[test]
fn one_way_streets_get_lanes_unless_robots_crowd_short_blocks() {
    let (long, short) = (worlds::streets(6, 8.0, true), worlds::streets(6, 3.0, true));
    assert!(two_way_share(&Roads::new(&long.view(1, 1))) < 0.01);
    assert!(chosen(&long, 20).contains("planner: Lanes"));
    assert!(chosen(&short, 3).contains("planner: Lanes"));
    assert!(chosen(&short, 20).contains("planner: Pibt"));
    let triangle = worlds::straight(
        &[[0.0, 0.0], [1.0, 0.0], [0.5, 0.9]],
        &[[0, 1], [1, 2], [2, 0]],
        [0.9, 0.6],
        Orientation::Tangential,
    );
    assert!(chosen(&triangle, 1).contains("planner: Lanes"), "a lone robot is no crowd");
}
