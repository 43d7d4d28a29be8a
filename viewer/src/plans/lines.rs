//! The routes of many robots as few segments: an edge that is on several routes is drawn once.

use regatta_plugin::route::RouteResponse;
use regatta_plugin::{Frame, World};
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

#[cfg(test)]
mod tests {
    use regatta_plugin::frame::{
        ColumnsMut, FrameHeader, Line, RobotState, frame_lines, stride_lines,
    };
    use regatta_plugin::world::{CurveRecord, EdgeRecord, WorldData};

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
}
