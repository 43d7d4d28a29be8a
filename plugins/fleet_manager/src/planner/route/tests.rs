//! Routes with landmarks or driving times cost the same as those without.

use proptest::prelude::*;
use regatta_plugin::world::{
    CurveRecord, EdgeRecord, NodeRecord, Orientation, RobotTypeRecord, WorldData,
};

use super::*;
use crate::model::worlds;

/// Nodes anywhere, edges between them with any speeds, a fast and a slow type of robot, one of
/// which turns on the spot.
fn world() -> impl Strategy<Value = WorldData> {
    let edge =
        (0_u32..25, 0_u32..25, 0.2_f32..2.0, prop_oneof![2 => Just(0.0_f32), 1 => 0.2_f32..0.6]);
    let nodes = proptest::collection::vec([0.0_f32..60.0, 0.0_f32..20.0], 25);
    (nodes, proptest::collection::vec(edge, 40..90)).prop_map(|(nodes, edges)| {
        let slow = RobotTypeRecord {
            max_speed: 0.8,
            max_rotation_speed: 0.0,
            ..RobotTypeRecord::new("", 0.2, 0.2)
        };
        let fast = RobotTypeRecord { max_speed: 1.5, ..RobotTypeRecord::new("", 0.2, 0.2) };
        let mut world = WorldData { robot_types: vec![fast, slow], ..WorldData::default() };
        world.nodes = (0..)
            .zip(&nodes)
            .map(|(id, &[x, y])| NodeRecord { id, x, y, ..NodeRecord::default() })
            .collect();
        for (origin, destination, speed, reverse_speed) in edges {
            if origin != destination {
                let record = EdgeRecord {
                    origin,
                    destination,
                    speed,
                    reverse_speed,
                    ..EdgeRecord::default()
                };
                let ends = [origin, destination].map(|node| nodes[node as usize]);
                // Headings don't matter to most corners: a fixed one makes none.
                let record = record.with_orientation(Orientation::Offset((origin % 3) as f32));
                world.add_edge(record, [CurveRecord::straight(ends[0], ends[1])]);
            }
        }
        world
    })
}

/// The time that a route takes, in seconds.
fn secs(roads: &Roads, class: &RobotClass, legs: &[Leg], delay: &[f32]) -> f32 {
    let driving = |leg: &Leg| {
        roads.edge(leg.edge()).length / roads.speed(class, *leg) + delay[leg.edge() as usize]
    };
    let joins = legs.windows(2).map(|pair| join_secs(roads, class.turns, pair[0], pair[1]));
    legs.iter().map(driving).sum::<f32>() + joins.sum::<f32>()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    /// With delays, closures, classes that are slower than the edges, and landmarks that know of a
    /// part of the delays.
    #[test]
    fn landmarks_change_no_cost(
        data in world(),
        delays in proptest::collection::vec((0.0_f32..6.0, 0.0_f32..=1.0, 0_u8..10), 90),
        searches in proptest::collection::vec((0_u32..25, 0_u32..25), 20),
    ) {
        let roads = Roads::new(&data.view(1, 1));
        let delay: Vec<f32> = delays.iter().map(|(delay, _, _)| *delay).collect();
        let known: Vec<f32> = delays.iter().map(|(delay, share, _)| delay * share).collect();
        let landmarks = Landmarks::new(&roads, &known);
        let mut router = Router::new(&roads);
        let cost = |leg: Leg| (delays[leg.edge() as usize].2 > 0).then(|| delay[leg.edge() as usize]);
        for class in roads.classes() {
            for &(start, goal) in searches.iter().filter(|(start, goal)| start != goal) {
                for reverse in [false, true] {
                    let bound = Bound::Distance;
                    let search = Search { last: None, start, goal, reverse, bound, slack: 0.0 };
                    let without = router.route(&roads, class, search, cost);
                    let search = Search { bound: Bound::Millis(roads.millis_to(goal)), ..search };
                    let times = router.route(&roads, class, search, cost);
                    let search = Search { bound: Bound::Landmarks(&landmarks), ..search };
                    let with = router.route(&roads, class, search, cost);
                    let slack = router.route(&roads, class, Search { slack: 0.2, ..search }, cost);
                    let found = [&with, &slack, &times].map(Option::is_some);
                    prop_assert_eq!(found, [without.is_some(); 3]);
                    let rounding = 1e-3 * without.as_ref().map_or(0, Vec::len) as f32;
                    let [without, with, slack, times] = [without, with, slack, times]
                        .map(|legs| secs(&roads, class, &legs.unwrap_or_default(), &delay));
                    prop_assert!(times < without + rounding + 1e-3, "{} s without, {} s with times", without, times);
                    prop_assert!((without - with).abs() < 1e-3, "{} s without, {} s with landmarks", without, with);
                    prop_assert!(slack < 1.2 * without + 1e-3, "{} s without, {} s with slack", without, slack);
                }
            }
        }
    }
}

#[test]
fn landmarks_that_know_the_delays_save_most_of_the_search() {
    let roads = Roads::new(&worlds::streets(24, 5.0, true).view(1, 1));
    let delay: Vec<f32> = (0..roads.edges().len()).map(|edge| (edge * 7 % 11) as f32).collect();
    let landmarks =
        [Landmarks::new(&roads, &vec![0.0; delay.len()]), Landmarks::new(&roads, &delay)];
    let mut router = Router::new(&roads);
    let looked_at = |bound: Bound<'_>| {
        let pairs = (0..200)
            .map(|pair| (pair * 37 % 576, pair * 101 % 576))
            .filter(|(start, goal)| start != goal);
        let search = |(start, goal)| {
            let search = Search { last: None, start, goal, reverse: false, bound, slack: 0.0 };
            router
                .route(&roads, &roads.classes()[0], search, |leg| Some(delay[leg.edge() as usize]));
            router.looked_at()
        };
        pairs.map(search).sum::<usize>()
    };
    let [none, empty, delayed] =
        [Bound::Distance, Bound::Landmarks(&landmarks[0]), Bound::Landmarks(&landmarks[1])]
            .map(looked_at);
    assert!(
        empty < none && 3 * delayed < none,
        "{none} legs without, {empty} of empty roads, {delayed} with delays"
    );
}
