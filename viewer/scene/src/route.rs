//! Routes of robots, reduced to the parts that are drawn and shown.

use bytemuck::{Pod, Zeroable};
use regatta_plugin::frame::RobotState;
use regatta_plugin::route::RouteResponse;
use regatta_plugin::world::EdgeRecord;
use regatta_plugin::{Frame, World};

use crate::curves::place_at;

/// The number of legs among which a robot's current one is searched: robots pass fewer of them
/// between two polls.
const NEXT_LEGS: usize = 8;

/// The part of an edge's curve that belongs to a route: an instance of routes.wgsl.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct RouteSegment {
    /// Index of the curve in the world.
    pub curve: u32,
    /// The curve parameters of the segment's start and end: 0 towards the edge's origin, 1 towards
    /// its destination.
    pub range: [f32; 2],
    /// 1 if the edge is released, 0 if it is only planned.
    pub released: u32,
}

/// The rest of a robot's route.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Remaining {
    /// The edges that the robot may drive now, its current one included.
    pub released: RouteLength,
    /// The edges that are only planned.
    pub planned: RouteLength,
}

/// The length of a part of a route.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RouteLength {
    /// The number of edges.
    pub edges: u32,
    /// Their length in metres. An answer lists only the first legs of a long route; the others are
    /// not included.
    pub metres: f32,
    /// Whether `metres` lacks some of the edges.
    pub is_partial: bool,
}

/// Returns the rest of a route from the robot's position in a frame: the segments to draw, and
/// their length. The rest is empty if the robot is idle or absent, or if frame and route belong to
/// different runs.
pub fn remaining_route(
    route: &RouteResponse,
    frame: &Frame<'_>,
    world: &World<'_>,
) -> (Vec<RouteSegment>, Remaining) {
    let row = route.robot as usize;
    let state = frame.state_of(row);
    let mut remaining = Remaining::default();
    if route.run_id != frame.run_id() || matches!(state, RobotState::Absent | RobotState::Idle) {
        return (Vec::new(), remaining);
    }
    // The robot has moved on since the route was answered.
    let s = frame.s()[row];
    let waits_at_node = state == RobotState::Waiting && route.released_metres == f32::INFINITY;
    let current = (!waits_at_node).then_some(frame.edge()[row]);
    let driven = match current {
        None => (route.released as usize).min(route.legs().len()),
        Some(edge) => route.legs().take(NEXT_LEGS).position(|leg| leg.edge == edge).unwrap_or(0),
    };
    let mut all = Vec::with_capacity(route.legs().len() - driven);
    for (index, leg) in route.legs().enumerate().skip(driven) {
        let Some(edge) = world.edges().get(leg.edge as usize) else { break };
        let entry = match (index == driven && current == Some(leg.edge), leg.reverse) {
            (true, false) => s.clamp(0.0, edge.length),
            (true, true) => (edge.length - s).clamp(0.0, edge.length),
            (false, _) => 0.0,
        };
        let limit = leg.released_metres.clamp(entry, edge.length.max(entry));
        let length = if leg.released { &mut remaining.released } else { &mut remaining.planned };
        length.edges += 1;
        remaining.released.metres += limit - entry;
        remaining.planned.metres += edge.length - limit;
        let parts = [([entry, limit], 1), ([limit, edge.length], 0)];
        for (range, released) in parts.into_iter().filter(|([from, to], _)| from < to) {
            all.extend(segments(world, edge, leg.reverse, range, released));
        }
    }
    let released = route.released.saturating_sub(driven as u32);
    let planned = route.legs.saturating_sub(route.released.max(driven as u32));
    for (length, edges) in [(&mut remaining.released, released), (&mut remaining.planned, planned)]
    {
        (length.is_partial, length.edges) = (length.edges < edges, edges);
    }
    (all, remaining)
}

/// Returns the segments of a part of a leg, in the order in which they are driven. The part is
/// given in metres from the start of the leg.
fn segments(
    world: &World<'_>,
    edge: &EdgeRecord,
    reverse: bool,
    range: [f32; 2],
    released: u32,
) -> impl Iterator<Item = RouteSegment> + use<> {
    let (curves, first_curve) = (world.curves(edge), edge.first_curve);
    let [from, to] = range.map(|metres| match (metres <= 0.0, metres >= edge.length, reverse) {
        (true, _, false) | (_, true, true) => (0, 0.0),
        (true, _, true) | (_, true, false) => (curves.len().saturating_sub(1), 1.0),
        (_, _, false) => place_at(curves, edge.length, metres),
        (_, _, true) => place_at(curves, edge.length, edge.length - metres),
    });
    let count = if curves.is_empty() { 0 } else { from.0.abs_diff(to.0) + 1 };
    let [start, end] = if reverse { [1.0, 0.0] } else { [0.0, 1.0] };
    (0..count).map(move |passed| {
        let number = if reverse { from.0 - passed } else { from.0 + passed };
        let range = [
            if passed == 0 { from.1 } else { start },
            if passed + 1 == count { to.1 } else { end },
        ];
        RouteSegment { curve: first_curve + number as u32, range, released }
    })
}

#[cfg(test)]
mod tests {
    use regatta_plugin::frame::{ColumnsMut, FrameHeader, Line, frame_lines, stride_lines};
    use regatta_plugin::world::{CurveRecord, WorldData};

    use super::*;

    /// Returns four consecutive edges of ten metres each: a straight one, a bend, a straight one,
    /// and one of two straight curves of four and six metres.
    fn world() -> WorldData {
        let mut world = WorldData::default();
        for control_points in [
            [[0.0, 0.0], [1.0, 0.0], [9.0, 0.0], [10.0, 0.0]],
            [[10.0, 0.0], [14.0, 0.0], [16.37, 2.37], [16.37, 6.37]],
            [[16.37, 6.37], [16.37, 9.0], [16.37, 13.0], [16.37, 16.37]],
        ] {
            world.add_edge(
                EdgeRecord { length: 10.0, ..EdgeRecord::default() },
                [CurveRecord { control_points }],
            );
        }
        let line = CurveRecord::straight;
        let corner = [line([16.37, 16.37], [12.37, 16.37]), line([12.37, 16.37], [12.37, 22.37])];
        world.add_edge(EdgeRecord { length: 10.0, ..EdgeRecord::default() }, corner);
        world
    }

    fn remaining(
        edge: u32,
        s: f32,
        state: RobotState,
        route: &RouteResponse,
    ) -> (Vec<RouteSegment>, Remaining) {
        let header = FrameHeader {
            run_id: 5,
            robots: 1,
            stride_lines: stride_lines(1) as u32,
            ..FrameHeader::default()
        };
        let mut lines = vec![Line::default(); frame_lines(1)];
        let columns = ColumnsMut::split(&mut lines, 1);
        (columns.edge[0], columns.s[0], columns.state[0]) = (edge, s, state as u8);
        remaining_route(route, &Frame::new(&header, &lines).expect("a frame"), &world().view(5, 1))
    }

    fn route(released: usize, legs: &[(u32, bool)]) -> RouteResponse {
        RouteResponse::unknown(5, 1, 0).with_legs(released, legs.len(), legs.iter().copied())
    }

    #[test]
    fn a_route_begins_at_the_robots_current_position() {
        let route = route(2, &[(0, false), (1, false), (2, false)]);
        let (segments, left) = remaining(0, 2.5, RobotState::Driving, &route);
        assert_eq!(left.released, RouteLength { edges: 2, metres: 17.5, is_partial: false });
        assert_eq!(left.planned, RouteLength { edges: 1, metres: 10.0, is_partial: false });
        assert_eq!((segments.len(), segments[1].range, segments[1].released), (3, [0.0, 1.0], 1));
        // The curve parameter grows fast near the ends, where the control points are close.
        assert!((0.28..0.40).contains(&segments[0].range[0]), "{segments:?}");

        let (segments, left) = remaining(1, 5.0, RobotState::Driving, &route);
        assert_eq!((segments.len(), left.released.edges, left.released.metres), (2, 1, 5.0));
        assert!((segments[0].range[0] - 0.5).abs() < 1e-3, "the bend is symmetric");
        let (segments, left) = remaining(1, 10.0, RobotState::Waiting, &route);
        assert_eq!((segments.len(), left.released.edges, left.planned.edges), (1, 0, 1));
        assert_eq!(remaining(2, 10.0, RobotState::Idle, &route).0, [], "the robot has arrived");
    }

    #[test]
    fn the_base_may_end_within_an_edge() {
        let route = route(2, &[(0, false), (1, false), (2, false)]).up_to(5.0);
        let (segments, left) = remaining(0, 2.5, RobotState::Driving, &route);
        assert_eq!([left.released.metres, left.planned.metres], [12.5, 15.0]);
        assert_eq!([left.released.edges, left.planned.edges], [2, 1]);
        assert_eq!(
            segments.iter().map(|segment| (segment.curve, segment.released)).collect::<Vec<_>>(),
            [(0, 1), (1, 1), (1, 0), (2, 0)]
        );
        assert_eq!(segments[1].range[1], segments[2].range[0]);
        let (segments, left) = remaining(1, 5.0, RobotState::Waiting, &route);
        assert_eq!((segments.len(), left.released.metres, left.planned.metres), (2, 0.0, 15.0));
    }

    #[test]
    fn a_reversing_robot_drives_towards_the_edges_origin() {
        let (segments, left) =
            remaining(2, 4.0, RobotState::Driving, &route(2, &[(2, true), (1, true)]));
        assert_eq!((left.released.edges, left.released.metres), (2, 14.0));
        assert_eq!((segments[0].range[1], segments[1].range), (0.0, [1.0, 0.0]));
    }

    #[test]
    fn every_curve_of_an_edge_has_a_segment() {
        let curves = |segments: Vec<RouteSegment>| -> Vec<(u32, [f32; 2])> {
            let rounded = |range: [f32; 2]| range.map(|end| (end * 1000.0).round() / 1000.0);
            segments.into_iter().map(|segment| (segment.curve, rounded(segment.range))).collect()
        };
        let (segments, left) =
            remaining(2, 10.0, RobotState::Driving, &route(2, &[(2, false), (3, false)]));
        assert_eq!(left.released.metres, 10.0);
        assert_eq!(
            curves(segments),
            [(3, [0.0, 1.0]), (4, [0.0, 1.0])],
            "nothing is left of the first leg"
        );
        let (segments, _) =
            remaining(0, 0.0, RobotState::Driving, &route(2, &[(0, false), (3, true)]));
        assert_eq!(curves(segments)[1..], [(4, [1.0, 0.0]), (3, [1.0, 0.0])]);
        let (segments, left) = remaining(3, 7.0, RobotState::Driving, &route(1, &[(3, false)]));
        assert_eq!((curves(segments), left.released.metres), (vec![(4, [0.5, 1.0])], 3.0));
        let (segments, left) = remaining(3, 7.0, RobotState::Driving, &route(1, &[(3, true)]));
        assert_eq!(
            (curves(segments), left.released.metres),
            (vec![(4, [0.5, 0.0]), (3, [1.0, 0.0])], 7.0)
        );
    }

    #[test]
    fn unlisted_legs_are_counted_and_unknown_runs_edges_and_robots_are_ignored() {
        let legs = [(0, false)].repeat(300);
        let (segments, left) = remaining(1, 0.0, RobotState::Driving, &route(290, &legs));
        assert_eq!(segments.len(), 256);
        assert_eq!(left.released, RouteLength { edges: 290, metres: 2560.0, is_partial: true });
        assert_eq!(left.planned, RouteLength { edges: 10, metres: 0.0, is_partial: true });
        let (segments, left) =
            remaining(0, 0.0, RobotState::Driving, &route(2, &[(0, false), (77, false)]));
        assert_eq!((segments.len(), left.released.edges, left.released.is_partial), (1, 2, true));
        let other = RouteResponse { run_id: 6, ..route(1, &[(0, false)]) };
        assert_eq!(remaining(0, 0.0, RobotState::Driving, &other).0, []);
        let unknown = RouteResponse { robot: 9, ..route(1, &[(0, false)]) };
        assert_eq!(remaining(0, 0.0, RobotState::Driving, &unknown).0, []);
    }
}
