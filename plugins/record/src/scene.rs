//! The fleet and its route graph as general tools show them: Foxglove's messages.

use prost::Message;
use prost_types::Timestamp;
use regatta_plugin::frame::RobotState;
use regatta_plugin::world::EdgeRecord;
use regatta_plugin::{Frame, World};

use crate::schema::FRAME_ID;
use crate::schema::foxglove::{
    Color, LinePrimitive, Point3, Pose, PosesInFrame, Quaternion, SceneEntity, SceneUpdate, Vector3, line_primitive,
};

/// Straight pieces that a curved edge is drawn with.
const PIECES: usize = 12;
/// Width of an edge on the screen, in pixels.
const EDGE_PIXELS: f64 = 1.5;
const EDGE_COLOUR: Color = Color { r: 0.45, g: 0.55, b: 0.65, a: 1.0 };

/// Poses of all robots that are there, in order of their ids.
pub(crate) fn poses(frame: &Frame<'_>, log_time: u64) -> Vec<u8> {
    let columns = frame.columns();
    let places = columns.x.iter().zip(columns.y).zip(columns.theta).zip(columns.state);
    let poses = places
        .filter(|(_, state)| RobotState::from_number(**state) != RobotState::Absent)
        .map(|(((x, y), theta), _)| pose(f64::from(*x), f64::from(*y), f64::from(*theta)))
        .collect();
    PosesInFrame { timestamp: Some(timestamp(log_time)), frame_id: FRAME_ID.to_owned(), poses }.encode_to_vec()
}

fn pose(x: f64, y: f64, theta: f64) -> Pose {
    let (sine, cosine) = (theta / 2.0).sin_cos();
    Pose {
        position: Some(Vector3 { x, y, z: 0.0 }),
        orientation: Some(Quaternion { x: 0.0, y: 0.0, z: sine, w: cosine }),
    }
}

/// The route graph as lines. Replaces the one before.
pub(crate) fn graph(world: &World<'_>, log_time: u64) -> Vec<u8> {
    let points = world.edges().iter().flat_map(lines).collect();
    let line = LinePrimitive {
        r#type: line_primitive::Type::LineList as i32,
        pose: Some(pose(0.0, 0.0, 0.0)),
        thickness: EDGE_PIXELS,
        scale_invariant: true,
        points,
        color: Some(EDGE_COLOUR),
        ..LinePrimitive::default()
    };
    let entity = SceneEntity {
        timestamp: Some(timestamp(log_time)),
        frame_id: FRAME_ID.to_owned(),
        id: "graph".to_owned(),
        lines: vec![line],
        ..SceneEntity::default()
    };
    SceneUpdate { entities: vec![entity], ..SceneUpdate::default() }.encode_to_vec()
}

/// An edge as pairs of points.
fn lines(edge: &EdgeRecord) -> impl Iterator<Item = Point3> {
    let points = polyline(&edge.control_points, PIECES);
    let pairs: Vec<_> = points.windows(2).flat_map(|pair| [pair[0], pair[1]]).collect();
    pairs.into_iter().map(|[x, y]| Point3 { x, y, z: 0.0 })
}

/// Points on a cubic Bézier curve: its two ends if it is straight, else `pieces + 1` of them.
pub(crate) fn polyline(control_points: &[[f32; 2]; 4], pieces: usize) -> Vec<[f64; 2]> {
    let [p0, p1, p2, p3] = control_points.map(|point| point.map(f64::from));
    let [dx, dy] = [p3[0] - p0[0], p3[1] - p0[1]];
    let chord = dx.hypot(dy);
    let off_chord = |p: [f64; 2]| (dx * (p[1] - p0[1]) - dy * (p[0] - p0[0])).abs() / chord.max(1e-9);
    if chord > 0.0 && off_chord(p1).max(off_chord(p2)) < 1e-3 {
        return vec![p0, p3];
    }
    let at = |piece: usize| {
        let t = piece as f64 / pieces as f64;
        let u = 1.0 - t;
        let weights = [u * u * u, 3.0 * u * u * t, 3.0 * u * t * t, t * t * t];
        [0, 1].map(|axis| weights[0] * p0[axis] + weights[1] * p1[axis] + weights[2] * p2[axis] + weights[3] * p3[axis])
    };
    (0..=pieces).map(at).collect()
}

fn timestamp(nanos: u64) -> Timestamp {
    Timestamp { seconds: (nanos / 1_000_000_000) as i64, nanos: (nanos % 1_000_000_000) as i32 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_begin_and_end_at_their_ends() {
        let curve = [[0.0, 0.0], [2.0, 0.0], [4.0, 1.0], [4.0, 4.0]];
        let points = polyline(&curve, 12);
        assert_eq!((points.len(), points[0], points[12]), (13, [0.0, 0.0], [4.0, 4.0]));
        let straight = [[1.0, 1.0], [2.0, 2.0], [3.0, 3.0], [4.0, 4.0]];
        assert_eq!(polyline(&straight, 12), [[1.0, 1.0], [4.0, 4.0]]);
    }
}
