//! The lists to draw: the routes of many robots as few segments, marks at the nodes to which a
//! fleet manager has sent robots, and arrows to the robots that robots wait for.

use regatta_plugin::route::RouteResponse;
use regatta_plugin::{Frame, World};
use regatta_scene::plans::{GoalMark, WaitArrow};
use regatta_scene::route::{RouteSegment, remaining_route};

/// Returns the segments of routes from the robots' positions in a frame on. A whole curve on
/// several routes gives one segment: a base rather than a horizon. Bases come last, so that they
/// are drawn over horizons.
pub fn lines<'a>(
    routes: impl Iterator<Item = &'a RouteResponse>,
    frame: &Frame<'_>,
    world: &World<'_>,
) -> Vec<RouteSegment> {
    // For each curve: 0 if it isn't completely on a route, 1 if it is horizon, 2 if a robot may
    // drive it now.
    let mut whole = vec![0_u8; world.all_curves().len()];
    let mut all = Vec::new();
    for segment in routes.flat_map(|route| remaining_route(route, frame, world).0) {
        match whole.get_mut(segment.curve as usize) {
            Some(known) if is_whole(segment.range) => {
                *known = (*known).max(1 + segment.released as u8)
            }
            _ => all.push(segment),
        }
    }
    let range = [0.0, 1.0];
    all.extend((0..).zip(whole).filter(|(_, known)| *known > 0).map(|(curve, known)| {
        let released = (known - 1).into();
        RouteSegment { curve, range, released }
    }));
    all.sort_by_key(|segment| segment.released);
    all
}

fn is_whole(range: [f32; 2]) -> bool {
    range == [0.0, 1.0] || range == [1.0, 0.0]
}

/// The indices of a route graph's nodes by their ids.
#[derive(Clone, Debug, Default)]
pub struct Places(Vec<(u32, u32)>);

impl Places {
    /// Collects the nodes of a world.
    pub fn new(world: &World<'_>) -> Self {
        let mut places: Vec<_> = world.nodes().iter().map(|node| node.id).zip(0..).collect();
        places.sort_by_key(|(id, _)| *id);
        Self(places)
    }

    fn index(&self, id: f32) -> Option<usize> {
        // The conversion would turn NaN and negative numbers into 0.
        (id >= 0.0).then(|| self.0.binary_search_by_key(&(id as u32), |(id, _)| *id).ok())?
    }
}

/// Returns a mark for each node that is a goal: of a selected robot, or of one that `is_watched`.
/// `goals` holds the id of the node that each robot was sent to, or NaN. Marks of selected robots
/// come last, so that they are drawn over the others.
pub fn goal_marks(
    goals: &[f32],
    is_watched: impl Fn(u32) -> bool,
    selected: &[u32],
    places: &Places,
) -> Vec<GoalMark> {
    let mut is_marked = vec![0_u8; places.0.len()];
    let watched = (0..).zip(goals).filter(|(robot, _)| is_watched(*robot));
    let chosen = selected.iter().filter_map(|robot| goals.get(*robot as usize));
    for (mark, goal) in watched.map(|(_, goal)| (1, goal)).chain(chosen.map(|goal| (2, goal))) {
        if let Some(index) = places.index(*goal) {
            is_marked[index] = mark;
        }
    }
    let mut all = Vec::new();
    for (mark, selected) in [(1, 0), (2, 1)] {
        let marked = places.0.iter().zip(&is_marked).filter(|(_, marked)| **marked == mark);
        all.extend(marked.map(|((_, node), _)| GoalMark { node: *node, selected }));
    }
    all
}

/// The entry of a robot that doesn't wait for another.
const NOBODY: u32 = u32::MAX;

/// Returns an arrow for each robot that waits. `waits_for` holds the id of the robot that each
/// robot waits for, or NaN; an id that no robot has counts as NaN. Arrows of rings come last, so
/// that they are drawn over the others.
pub fn arrows(waits_for: &[f32]) -> Vec<WaitArrow> {
    let next: Vec<u32> =
        (0..).zip(waits_for).map(|(robot, value)| target(*value, robot, waits_for.len())).collect();
    let mut all = Vec::new();
    for ((from, to), in_ring) in (0..).zip(&next).zip(on_rings(&next)) {
        if *to != NOBODY {
            all.push(WaitArrow { from, to: *to, in_ring: in_ring.into() });
        }
    }
    all.sort_by_key(|arrow| arrow.in_ring);
    all
}

fn target(value: f32, robot: u32, robots: usize) -> u32 {
    // NaN and negative numbers fail the first comparison.
    let is_robot = value >= 0.0 && value < robots as f32 && value as u32 != robot;
    if is_robot { value as u32 } else { NOBODY }
}

/// Returns for each element of a list whether following the list from it leads back to it. `next`
/// holds the index of the element after each one; an index beyond the end ends a chain. Takes time
/// in proportion to the elements.
pub fn on_rings(next: &[u32]) -> Vec<bool> {
    let mut is_on = vec![false; next.len()];
    // The walk that came by each element first; 0 for none.
    let mut walks = vec![0_u32; next.len()];
    for (walk, start) in (1..).zip(0..next.len()) {
        let mut at = start;
        while walks.get(at) == Some(&0) {
            walks[at] = walk;
            at = next[at] as usize;
        }
        // A walk that ends where it has been itself has found a ring; the rings of other walks are
        // known.
        while walks.get(at) == Some(&walk) && !is_on[at] {
            is_on[at] = true;
            at = next[at] as usize;
        }
    }
    is_on
}

#[cfg(test)]
mod tests {
    use regatta_plugin::frame::{
        ColumnsMut, FrameHeader, Line, RobotState, frame_lines, stride_lines,
    };
    use regatta_plugin::world::{CurveRecord, EdgeRecord, NodeRecord, WorldData};

    use super::*;

    #[test]
    fn an_edge_of_several_routes_is_drawn_once_and_solid_if_it_is_in_a_base() {
        let mut world = WorldData::default();
        for i in 0..4 {
            let line = CurveRecord::straight([i as f32 * 10.0, 0.0], [i as f32 * 10.0 + 10.0, 0.0]);
            world.add_edge(EdgeRecord { length: 10.0, ..EdgeRecord::default() }, [line]);
        }
        let header = FrameHeader {
            run_id: 5,
            robots: 2,
            stride_lines: stride_lines(2) as u32,
            ..FrameHeader::default()
        };
        let mut lines_of_frame = vec![Line::default(); frame_lines(2)];
        let columns = ColumnsMut::split(&mut lines_of_frame, 2);
        (columns.s[0], columns.s[1], columns.edge[0], columns.edge[1]) = (4.0, 5.0, 0, 1);
        columns.state.fill(RobotState::Driving as u8);
        let frame = Frame::new(&header, &lines_of_frame).expect("a frame");
        let route = |robot, released, legs: [u32; 3]| {
            RouteResponse::unknown(5, 1, robot).with_legs(
                released,
                3,
                legs.map(|edge| (edge, false)).into_iter(),
            )
        };
        // The first robot may drive edge 0 and plans 1 and 2; the second one may drive 1 and 2, and
        // plans 3.
        let routes = [route(0, 1, [0, 1, 2]), route(1, 2, [1, 2, 3])];
        let all = lines(routes.iter(), &frame, &world.view(5, 1));
        let found: Vec<_> =
            all.iter().map(|line| (line.curve, line.released, is_whole(line.range))).collect();
        assert_eq!(found, [(1, 0, true), (3, 0, true), (0, 1, false), (1, 1, false), (2, 1, true)]);
    }

    #[test]
    fn each_goal_is_marked_once_and_those_of_selected_robots_last() {
        let node = |id, x| NodeRecord { id, x, ..NodeRecord::default() };
        let world = WorldData {
            nodes: vec![node(30, 3.0), node(10, 1.0), node(20, 2.0)],
            ..WorldData::default()
        };
        let places = Places::new(&world.view(1, 1));
        let mark = |node, selected| GoalMark { node, selected };
        let goals = [20.0, 10.0, f32::NAN, 20.0, 99.0, -1.0, 30.0];
        assert_eq!(
            goal_marks(&goals, |_| true, &[1, 77], &places),
            [mark(2, 0), mark(0, 0), mark(1, 1)]
        );
        assert_eq!(goal_marks(&goals, |robot| robot == 6, &[1], &places), [mark(0, 0), mark(1, 1)]);
        assert_eq!(goal_marks(&goals, |_| false, &[0, 2, 5], &places), [mark(2, 1)]);
        assert_eq!(goal_marks(&goals, |_| false, &[], &places), []);
        assert_eq!(goal_marks(&[0.0], |_| true, &[], &Places::default()), []);
    }

    /// Follows the list from each element for as many steps as there are elements.
    fn on_rings_by_walking(next: &[u32]) -> Vec<bool> {
        let leads_back = |start: usize| {
            let mut at = start;
            (0..next.len()).any(|_| {
                at = next.get(at).map_or(usize::MAX, |next| *next as usize);
                at == start
            })
        };
        (0..next.len()).map(leads_back).collect()
    }

    #[test]
    fn rings_are_found_and_those_who_wait_for_a_ring_are_not_in_it() {
        // 0 → 1 → 2 → 0 is a ring; 3 → 4 → 0 waits for it; 5 ⇄ 6 is a second ring; 7 → 8, which
        // waits for nobody.
        let next = [1, 2, 0, 4, 0, 6, 5, 8, NOBODY];
        let wanted = [true, true, true, false, false, true, true, false, false];
        assert_eq!(on_rings(&next), wanted);
        assert!(on_rings(&[]).is_empty());
    }

    #[test]
    fn rings_of_any_list_are_those_found_by_walking() {
        let mut seed = 1_u64;
        let mut random = move |below: u64| {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) % below
        };
        for robots in 1..40_u64 {
            for _ in 0..20 {
                let next: Vec<u32> = (0..robots)
                    .map(|_| if random(4) == 0 { NOBODY } else { random(robots) as u32 })
                    .collect();
                assert_eq!(on_rings(&next), on_rings_by_walking(&next), "{next:?}");
            }
        }
    }

    #[test]
    fn values_that_are_no_other_robot_have_no_arrow() {
        let nan = f32::NAN;
        let arrow = |from, to, in_ring| WaitArrow { from, to, in_ring };
        assert_eq!(arrows(&[nan, -1.0, 2.0, 99.0, f32::INFINITY]), []);
        assert_eq!(arrows(&[1.0, 2.0, 1.0, nan]), [arrow(0, 1, 0), arrow(1, 2, 1), arrow(2, 1, 1)]);
    }
}
