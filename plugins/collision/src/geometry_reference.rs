//! A slow reference implementation of the geometry for tests: footprints as polygons, compared side
//! by side.

use glam::Vec2;
use proptest::prelude::*;
use regatta_plugin::world::{CurveRecord, EdgeRecord, WorldData};

use crate::body::{Body, CIRCLE};
use crate::heading::heading;
use crate::prediction::Segment;

pub(crate) type Point = [f64; 2];

/// The horizon of the trajectories in tests, in seconds.
pub(crate) const HORIZON: f32 = 2.0;

/// A polygon, and the radius of the disc that is swept around it: a circle is a point with a
/// radius.
pub(crate) type RoundedPolygon = (Vec<Point>, f64);

/// Returns a world of edges with one curve each, given by its control points.
pub(crate) fn world(edges: impl IntoIterator<Item = (EdgeRecord, [[f32; 2]; 4])>) -> WorldData {
    let mut world = WorldData::default();
    for (edge, control_points) in edges {
        world.add_edge(edge, [CurveRecord { control_points }]);
    }
    world
}

pub(crate) fn bodies() -> impl Strategy<Value = Body> {
    let size = prop_oneof![0.0_f32..0.1, 0.1_f32..2.0, 5.0_f32..20.0];
    let position = prop_oneof![-3.0_f32..3.0, -15.0_f32..15.0];
    let axis = (0_u32..8).prop_map(|eighth| eighth as f32 * std::f32::consts::FRAC_PI_4);
    let theta = prop_oneof![-3.2_f32..3.2, axis];
    ([position.clone(), position], theta, size.clone(), prop_oneof![size, Just(CIRCLE)]).prop_map(
        |(position, theta, half_length, half_width)| {
            let heading = heading(theta);
            Body { position: position.into(), heading, half_length, half_width }
        },
    )
}

/// Returns the outline of a body at some position and heading.
pub(crate) fn outline(body: &Body, position: Point, heading: Vec2) -> RoundedPolygon {
    let (cos, sin, length, width) = (
        f64::from(heading.x),
        f64::from(heading.y),
        f64::from(body.half_length),
        f64::from(body.half_width),
    );
    if body.half_width == CIRCLE {
        return (vec![position], length);
    }
    let corners = [[length, width], [-length, width], [-length, -width], [length, -width]];
    (
        corners
            .map(|[x, y]| [position[0] + x * cos - y * sin, position[1] + x * sin + y * cos])
            .to_vec(),
        0.0,
    )
}

fn sides(polygon: &[Point]) -> impl Iterator<Item = (Point, Point)> {
    polygon.iter().zip(polygon.iter().cycle().skip(1)).map(|(from, to)| (*from, *to))
}

/// Returns the distance of a point from a side, in metres.
fn to_side(point: Point, (from, to): (Point, Point)) -> f64 {
    let ([x, y], [u, v]) =
        ([point[0] - from[0], point[1] - from[1]], [to[0] - from[0], to[1] - from[1]]);
    let part = ((x * u + y * v) / (u * u + v * v).max(1e-300)).clamp(0.0, 1.0);
    (x - part * u).hypot(y - part * v)
}

/// Returns the depth of a point inside a convex polygon that runs counter-clockwise; negative
/// outside.
fn depth(point: Point, polygon: &[Point]) -> f64 {
    let depths = sides(polygon).map(|(from, to)| {
        let length = (to[0] - from[0]).hypot(to[1] - from[1]);
        left_of((from, to), point) / length.max(1e-300)
    });
    depths.fold(f64::INFINITY, f64::min)
}

/// Whether two line segments cross.
fn cross(a: (Point, Point), b: (Point, Point)) -> bool {
    left_of(a, b.0) * left_of(a, b.1) < 0.0 && left_of(b, a.0) * left_of(b, a.1) < 0.0
}

/// Returns the distance of a point to the left of a line, times the length of the line.
fn left_of((from, to): (Point, Point), point: Point) -> f64 {
    (to[0] - from[0]) * (point[1] - from[1]) - (to[1] - from[1]) * (point[0] - from[0])
}

/// Returns the distance between two outlines, in metres: 0 if sides cross or one holds a corner of
/// the other.
pub(crate) fn distance((a, radius_a): &RoundedPolygon, (b, radius_b): &RoundedPolygon) -> f64 {
    if holds(a, b) || holds(b, a) || sides(a).any(|one| sides(b).any(|other| cross(one, other))) {
        return 0.0;
    }
    (nearest(a, b).min(nearest(b, a)) - radius_a - radius_b).max(0.0)
}

/// Whether a polygon holds a corner of another one.
fn holds(corners: &[Point], polygon: &[Point]) -> bool {
    polygon.len() > 2 && corners.iter().any(|point| depth(*point, polygon) >= 0.0)
}

/// Returns the least distance of the corners of an outline from the sides of another one.
fn nearest(corners: &[Point], outline: &[Point]) -> f64 {
    corners
        .iter()
        .flat_map(|point| sides(outline).map(|side| to_side(*point, side)))
        .fold(f64::INFINITY, f64::min)
}

pub(crate) fn position(body: &Body) -> Point {
    body.position.as_dvec2().into()
}

/// Returns each segment with the time at which it starts, in seconds from now.
pub(crate) fn timed(segments: &[Segment]) -> impl Iterator<Item = (f64, &Segment)> {
    let starts =
        std::iter::once(0.0).chain(segments.iter().map(|segment| f64::from(segment.until)));
    starts.zip(segments)
}

/// Returns the outline of a body some seconds after a segment has started.
pub(crate) fn outline_at(body: &Body, segment: &Segment, elapsed: f64) -> RoundedPolygon {
    let position = [0, 1].map(|axis| {
        f64::from(segment.position[axis]) + f64::from(segment.velocity[axis]) * elapsed
    });
    outline(body, position, segment.heading_after(elapsed as f32))
}

/// Returns the centroid of the intersection of two convex polygons that run counter-clockwise, and
/// twice its area as a part of the square of its perimeter. The first is cut along each side of the
/// second.
pub(crate) fn intersection_centroid(a: &[Point], b: &[Point]) -> Option<(Point, f64)> {
    let mut polygon = a.to_vec();
    for (from, to) in sides(b) {
        let mut cut = Vec::new();
        for (start, end) in sides(&polygon) {
            let [here, there] = [start, end].map(|point| left_of((from, to), point));
            if here >= 0.0 {
                cut.push(start);
            }
            if here * there < 0.0 {
                let part = here / (here - there);
                cut.push([
                    start[0] + part * (end[0] - start[0]),
                    start[1] + part * (end[1] - start[1]),
                ]);
            }
        }
        polygon = cut;
    }
    let origin = *polygon.first()?;
    let (mut area, mut moment) = (0.0, [0.0; 2]);
    for (p, q) in sides(&polygon) {
        let [p, q] = [p, q].map(|point| [point[0] - origin[0], point[1] - origin[1]]);
        let cross = p[0] * q[1] - p[1] * q[0];
        area += 0.5 * cross;
        moment = [0, 1].map(|axis| moment[axis] + (p[axis] + q[axis]) * cross / 6.0);
    }
    let perimeter: f64 = sides(&polygon).map(|(p, q)| (p[0] - q[0]).hypot(p[1] - q[1])).sum();
    let centroid = [0, 1].map(|axis| origin[axis] + moment[axis] / area);
    (area > 0.0).then(|| (centroid, 2.0 * area / (perimeter * perimeter)))
}

fn bezier(points: &[[f32; 2]; 4], at: f64) -> Point {
    let weight =
        [(1.0 - at).powi(3), 3.0 * at * (1.0 - at).powi(2), 3.0 * at * at * (1.0 - at), at.powi(3)];
    [0, 1].map(|axis| {
        points.iter().zip(weight).map(|(point, weight)| f64::from(point[axis]) * weight).sum()
    })
}

/// Returns points of a curve with their distances along it.
pub(crate) fn polyline(points: &[[f32; 2]; 4]) -> Vec<(f64, Point)> {
    let mut polyline: Vec<(f64, Point)> = vec![(0.0, bezier(points, 0.0))];
    for step in 1..=4000 {
        let (next, (s, last)) =
            (bezier(points, f64::from(step) / 4000.0), polyline[polyline.len() - 1]);
        polyline.push((s + (next[0] - last[0]).hypot(next[1] - last[1]), next));
    }
    polyline
}

/// Returns the point and the heading at the distance `s` along a curve; beyond the ends along the
/// tangent.
pub(crate) fn on_polyline(polyline: &[(f64, Point)], s: f64) -> (Point, f64) {
    let next = polyline.partition_point(|(along, _)| *along < s).clamp(1, polyline.len() - 1);
    let ((from_s, from), (to_s, to)) = (polyline[next - 1], polyline[next]);
    let part = (s - from_s) / (to_s - from_s);
    let position = [from[0] + part * (to[0] - from[0]), from[1] + part * (to[1] - from[1])];
    (position, (to[1] - from[1]).atan2(to[0] - from[0]))
}
