//! The world as the judge needs it: curves by arc length, limits, and the legs that leave each
//! node.

use glam::{DVec2, Vec2};
use regatta_plugin::World;
use regatta_plugin::world::{
    CurveRecord, EdgeRecord, Level, Levels, NodeRecord, Orientation, RobotTypeRecord, Shape,
};

use crate::contacts::Body;
use crate::motion::Row;
use crate::zones::ZoneTable;

/// The distance between two samples of a curve, in metres, at which the search for a sufficient
/// resolution begins.
const STEP_METRES: f64 = 0.4;
const MIN_STEPS: usize = 8;
/// The largest number of samples of a curve. A curve that needs more has a cusp.
const MAX_STEPS: usize = 1 << 10;
/// The largest deviation from the curve between two samples, in metres.
const MAX_DEVIATION: f32 = 2e-4;
/// The largest deviation from the tangent between two samples, in radians.
const MAX_TURN: f32 = 2e-3;
/// The number of intervals of a curve's parameter over which its length is integrated.
const INTERVALS: usize = 64;

/// The world, prepared once per change.
#[derive(Debug)]
pub(crate) struct WorldModel {
    pub nodes: Vec<NodeRecord>,
    edges: Vec<Edge>,
    levels: Levels,
    pub zones: ZoneTable,
    /// At least one.
    pub robot_types: Vec<RobotType>,
    /// All legs, sorted by the node that they leave.
    legs: Vec<Leg>,
    /// The legs that leave node `n` are `legs[first_legs[n]..first_legs[n + 1]]`.
    first_legs: Vec<usize>,
    /// The highest speed limit of all edges in either gear, in metres per second; infinite without
    /// edges.
    pub max_speed: f64,
}

/// A robot type with its footprint.
#[derive(Debug)]
pub(crate) struct RobotType {
    pub record: RobotTypeRecord,
    /// The body of robot 0 of this type, at the origin.
    body: Body,
}

impl RobotType {
    fn new(record: RobotTypeRecord) -> Self {
        let is_circle = record.shape() == Shape::Circle;
        let width = if is_circle { record.length } else { record.width };
        let half = 0.5 * Vec2::new(record.length, width);
        Self { record, body: Body::new(0, Vec2::ZERO, 0.0, half, is_circle) }
    }

    /// Returns the body of a robot of this type on a level.
    pub fn body(&self, robot: u32, row: &Row, level: Level) -> Body {
        self.body.of(robot, row.position, row.theta, level)
    }
}

/// An edge that is driven in one gear, with the nodes at which it begins and ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leg {
    pub origin: u32,
    pub destination: u32,
    /// Length in metres.
    pub length: f64,
    pub is_reverse: bool,
}

/// An edge and its curves. Consecutive ones may meet at a corner, so that each has samples of its
/// own.
#[derive(Debug)]
pub(crate) struct Edge {
    pub record: EdgeRecord,
    parts: Vec<Part>,
}

/// A curve of an edge, in one cache line: it is looked up for each robot that drives in a frame.
#[derive(Debug)]
#[repr(align(64))]
struct Part {
    /// Distance of its start from the edge's origin, in metres.
    start: f32,
    /// Length in metres.
    length: f32,
    /// Its start and its end.
    ends: [Vec2; 2],
    /// The angle of the tangent at its start, in radians.
    tangent: f32,
    /// Samples at evenly spaced arc lengths; empty for a straight line.
    samples: Vec<Sample>,
}

/// A point of a curve, and the unit tangent there.
#[derive(Clone, Copy, Debug)]
struct Sample {
    position: Vec2,
    tangent: Vec2,
}

impl WorldModel {
    pub fn new(world: &World<'_>) -> Self {
        let nodes = world.nodes().to_vec();
        let edges: Vec<_> =
            world.edges().iter().map(|edge| Edge::new(*edge, world.curves(edge))).collect();
        let mut legs: Vec<Leg> = edges.iter().flat_map(Edge::legs).flatten().collect();
        legs.sort_by_key(|leg| leg.origin);
        let first_legs = (0..=nodes.len())
            .map(|node| legs.partition_point(|leg| (leg.origin as usize) < node))
            .collect();
        let speeds = edges.iter().flat_map(|edge| [edge.record.speed, edge.record.reverse_speed]);
        let max_speed =
            if edges.is_empty() { f64::INFINITY } else { speeds.fold(0.0, f32::max).into() };
        let mut robot_types: Vec<_> =
            world.robot_types().iter().map(|record| RobotType::new(*record)).collect();
        if robot_types.is_empty() {
            robot_types.push(RobotType::new(RobotTypeRecord::new("unknown", 0.9, 0.6)));
        }
        let (levels, zones) = (Levels::new(world), ZoneTable::new(world));
        Self { nodes, edges, levels, zones, robot_types, legs, first_legs, max_speed }
    }

    /// Returns the legs that leave a node.
    pub fn leaving(&self, node: u32) -> &[Leg] {
        let node = node as usize;
        match (self.first_legs.get(node), self.first_legs.get(node + 1)) {
            (Some(first), Some(end)) => &self.legs[*first..*end],
            _ => &[],
        }
    }

    pub fn edge(&self, edge: u32) -> Option<&Edge> {
        self.edges.get(edge as usize)
    }

    /// Returns the level of a robot.
    pub fn level(&self, row: &Row) -> Level {
        self.levels.of_robot(row.edge, row.s)
    }

    /// Returns the id of an edge.
    pub fn edge_id(&self, edge: u32) -> Option<u32> {
        self.edge(edge).map(|edge| edge.record.id)
    }

    /// Returns the type with an index; without it, the first one. Without types, robots are of
    /// 0.9 m × 0.6 m without limits.
    pub fn robot_type(&self, index: usize) -> &RobotType {
        self.robot_types.get(index).unwrap_or(&self.robot_types[0])
    }

    /// Returns the distance of a robot from a node, by its index, in metres; infinite if there is
    /// none.
    pub fn distance_to_node(&self, node: u32, row: &Row) -> f64 {
        let node = self.nodes.get(node as usize);
        node.map_or(f64::INFINITY, |node| row.distance_to(Vec2::new(node.x, node.y)))
    }

    /// Returns the position of the node with an id.
    pub fn node_position(&self, id: u32) -> Option<Vec2> {
        self.nodes.iter().find(|node| node.id == id).map(|node| Vec2::new(node.x, node.y))
    }
}

impl Edge {
    fn new(record: EdgeRecord, curves: &[CurveRecord]) -> Self {
        let (mut parts, mut start) = (Vec::new(), 0.0);
        for curve in curves {
            let (samples, length) =
                if is_straight(curve) { straight_samples(curve) } else { curved_samples(curve) };
            let (Some(&first), Some(&last)) = (samples.first(), samples.last()) else { continue };
            // Also false for NaN.
            if length > 0.0 {
                let tangent = first.tangent.y.atan2(first.tangent.x);
                let samples = if samples.len() > 2 { samples } else { Vec::new() };
                let ends = [first.position, last.position];
                let (from, metres) = (start as f32, length as f32);
                parts.push(Part { start: from, length: metres, ends, tangent, samples });
                start += length;
            }
        }
        // Positions along the edge are measured in the length that the world states.
        let scale = (f64::from(record.length) / start) as f32;
        for part in &mut parts {
            (part.start, part.length) = (part.start * scale, part.length * scale);
        }
        Self { record, parts }
    }

    /// Returns the edge's leg in forward gear, and that in reverse gear if it is allowed.
    pub fn legs(&self) -> [Option<Leg>; 2] {
        let EdgeRecord { origin, destination, length, reverse_speed, .. } = self.record;
        let forward = Leg { origin, destination, length: length.into(), is_reverse: false };
        let reverse = Leg { origin: destination, destination: origin, is_reverse: true, ..forward };
        [Some(forward), (reverse_speed > 0.0).then_some(reverse)]
    }

    /// Returns the position and the angle of the tangent at a distance from the origin, in metres.
    /// `None` if the world has no curve for the edge.
    pub fn at(&self, s: f32) -> Option<(Vec2, f32)> {
        let part = match &self.parts[..] {
            [part] => part,
            parts => parts.get(parts.partition_point(|part| part.start <= s).saturating_sub(1))?,
        };
        Some(part.at((s - part.start) / part.length))
    }

    /// Returns the heading of a robot at a point whose tangent has this angle.
    pub fn heading(&self, tangent: f32) -> f32 {
        match self.record.orientation() {
            Orientation::Tangential => tangent,
            Orientation::Offset(offset) => tangent + offset,
            Orientation::Fixed(heading) => heading,
        }
    }
}

impl Part {
    /// Returns the position and the angle of the tangent at a fraction of the length.
    fn at(&self, fraction: f32) -> (Vec2, f32) {
        let fraction = if fraction.is_finite() { fraction.clamp(0.0, 1.0) } else { 0.0 };
        let Some(last) = self.samples.len().checked_sub(1) else {
            let [from, to] = self.ends;
            return (from + fraction * (to - from), self.tangent);
        };
        let place = fraction * last as f32;
        let index = (place as usize).min(last - 1);
        let (from, to) = (&self.samples[index], &self.samples[index + 1]);
        let found = between(from, to, self.length / last as f32, place - index as f32);
        (found.position, found.tangent.y.atan2(found.tangent.x))
    }
}

/// Interpolates two samples that are `distance` metres apart, by Hermite's cubic.
fn between(a: &Sample, b: &Sample, distance: f32, t: f32) -> Sample {
    let (t2, t3) = (t * t, t * t * t);
    let (h01, h10, h11) =
        (3.0 * t2 - 2.0 * t3, (t3 - 2.0 * t2 + t) * distance, (t3 - t2) * distance);
    Sample {
        position: a.position + h01 * (b.position - a.position) + h10 * a.tangent + h11 * b.tangent,
        tangent: a.tangent + t * (b.tangent - a.tangent),
    }
}

fn points(curve: &CurveRecord) -> [DVec2; 4] {
    curve.control_points.map(|point| Vec2::from(point).as_dvec2())
}

/// Whether a curve leads from its first to its last point straight and without turning back.
fn is_straight(curve: &CurveRecord) -> bool {
    let [a, b, c, d] = points(curve);
    let whole = d - a;
    let square = whole.length_squared();
    let [b_along, c_along] = [b, c].map(|point| (point - a).dot(whole) / square);
    let aside = [b, c].map(|point| (point - a).perp_dot(whole).abs() / square.sqrt());
    let in_order = -1e-6 <= b_along && b_along <= c_along && c_along <= 1.0 + 1e-6;
    square > 0.0 && in_order && aside.iter().all(|metres| *metres < 1e-5)
}

/// Returns both ends of a straight line, and its length.
fn straight_samples(curve: &CurveRecord) -> (Vec<Sample>, f64) {
    let [a, _, _, d] = points(curve);
    let length = (d.x - a.x).hypot(d.y - a.y);
    let tangent = ((d - a) / length).as_vec2();
    (
        vec![Sample { position: a.as_vec2(), tangent }, Sample { position: d.as_vec2(), tangent }],
        length,
    )
}

/// Returns samples at evenly spaced arc lengths, and the length.
fn curved_samples(curve: &CurveRecord) -> (Vec<Sample>, f64) {
    let table = ArcLengths::new(points(curve));
    let length = table.length();
    let mut steps =
        ((length / STEP_METRES).ceil() as usize).clamp(MIN_STEPS, MAX_STEPS).next_multiple_of(2);
    loop {
        let samples: Vec<_> =
            (0..=steps).map(|step| table.sample(length * step as f64 / steps as f64)).collect();
        if steps >= MAX_STEPS || is_fine(&samples, (length / steps as f64) as f32) {
            return (samples, length);
        }
        steps *= 2;
    }
}

/// Whether every other sample is close to the interpolation of its neighbours.
fn is_fine(samples: &[Sample], distance: f32) -> bool {
    samples.windows(3).step_by(2).all(|part| {
        let found = between(&part[0], &part[2], 2.0 * distance, 0.5);
        let exact = part[1];
        // The middle of two opposite tangents has no direction.
        let is_turned = found.tangent.perp_dot(exact.tangent).abs()
            <= MAX_TURN * found.tangent.dot(exact.tangent);
        (found.position - exact.position).abs().max_element() <= MAX_DEVIATION && is_turned
    })
}

/// The arc lengths of a curve, by quadrature.
struct ArcLengths {
    points: [DVec2; 4],
    /// Arc length at the ends of the intervals.
    lengths: Vec<f64>,
}

impl ArcLengths {
    fn new(points: [DVec2; 4]) -> Self {
        let mut table = Self { points, lengths: vec![0.0] };
        let mut length = 0.0;
        for interval in 0..INTERVALS {
            let (from, to) =
                (interval as f64 / INTERVALS as f64, (interval + 1) as f64 / INTERVALS as f64);
            length += table.length_between(from, to);
            table.lengths.push(length);
        }
        table
    }

    fn length(&self) -> f64 {
        self.lengths[INTERVALS]
    }

    fn derivative(&self, t: f64) -> DVec2 {
        let u = 1.0 - t;
        let [a, b, c, d] = self.points;
        3.0 * (u * u * (b - a) + 2.0 * u * t * (c - b) + t * t * (d - c))
    }

    fn position(&self, t: f64) -> DVec2 {
        let u = 1.0 - t;
        let [a, b, c, d] = self.points;
        u * u * u * a + 3.0 * u * u * t * b + 3.0 * u * t * t * c + t * t * t * d
    }

    fn speed(&self, t: f64) -> f64 {
        let DVec2 { x, y } = self.derivative(t);
        x.hypot(y)
    }

    /// Integrates by the Gauss-Legendre rule of three points.
    fn length_between(&self, from: f64, to: f64) -> f64 {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let outer = half * 0.6_f64.sqrt();
        let [low, high] = [self.speed(middle - outer), self.speed(middle + outer)];
        half / 9.0 * (5.0 * low + 8.0 * self.speed(middle) + 5.0 * high)
    }

    /// Returns the sample at an arc length.
    fn sample(&self, s: f64) -> Sample {
        let interval = self.lengths.partition_point(|length| *length <= s).clamp(1, INTERVALS) - 1;
        let (low, high) = (self.lengths[interval], self.lengths[interval + 1]);
        let from = interval as f64 / INTERVALS as f64;
        let part = if high > low { ((s - low) / (high - low)).clamp(0.0, 1.0) } else { 0.0 };
        let mut t = from + part / INTERVALS as f64;
        for _ in 0..3 {
            let speed = self.speed(t);
            if speed < 1e-9 {
                break;
            }
            t = (t - (low + self.length_between(from, t) - s) / speed).clamp(0.0, 1.0);
        }
        Sample { position: self.position(t).as_vec2(), tangent: self.direction(t).as_vec2() }
    }

    /// Returns the unit tangent. A curve that stands still (a handle of length 0) has that of a
    /// point nearby.
    fn direction(&self, t: f64) -> DVec2 {
        for nudge in [0.0, 1e-4, 1e-2] {
            let derivative = self.derivative(if t < 0.5 { t + nudge } else { t - nudge });
            let speed = derivative.x.hypot(derivative.y);
            if speed > 1e-7 {
                return derivative / speed;
            }
        }
        DVec2::X
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quarter of a circle of radius 2 about the origin, in two curves.
    #[test]
    fn a_circle_is_followed_by_arc_length() {
        let arc = |from: f64, to: f64| {
            let handle = 2.0 * 4.0 / 3.0 * ((to - from) / 4.0).tan();
            let at = |angle: f64| [2.0 * angle.cos(), 2.0 * angle.sin()];
            let ([ax, ay], [dx, dy]) = (at(from), at(to));
            let b = [ax - handle * from.sin(), ay + handle * from.cos()];
            let c = [dx + handle * to.sin(), dy - handle * to.cos()];
            CurveRecord { control_points: [[ax, ay], b, c, [dx, dy]].map(|p| p.map(|v| v as f32)) }
        };
        let quarter = std::f64::consts::FRAC_PI_2;
        let record = EdgeRecord { length: 2.0 * quarter as f32, ..EdgeRecord::default() };
        let edge = Edge::new(record, &[arc(0.0, 0.3), arc(0.3, quarter)]);
        for step in 0..=200 {
            let angle = quarter * f64::from(step) / 200.0;
            let (point, tangent) = edge.at(2.0 * angle as f32).expect("a curve");
            let off = point.as_dvec2().distance(2.0 * DVec2::from_angle(angle));
            assert!(off < 1.5e-3, "{off} at {angle}");
            assert!((f64::from(tangent) - angle - quarter).abs() < 2e-3, "{tangent} at {angle}");
        }
    }

    #[test]
    fn a_line_is_straight_however_its_handles_are_spaced() {
        let curve =
            CurveRecord { control_points: [[1.0, 1.0], [1.0, 1.0], [1.0, 1.0], [1.0, 9.0]] };
        let record = EdgeRecord { length: 8.0, ..EdgeRecord::default() };
        let edge = Edge::new(record, &[curve]);
        assert_eq!(edge.at(2.0).map(|(position, _)| position), Some(Vec2::new(1.0, 3.0)));
        assert!(edge.parts[0].samples.is_empty());
        assert!(Edge::new(record, &[]).at(1.0).is_none());
    }

    /// A curve that turns back in its middle, and one that is much curved at its beginning.
    #[test]
    fn sharp_bends_are_sampled_finely() {
        let cusp = [[0.0, 0.0], [4.0, 2.0], [0.0, 2.0], [4.0, 0.0]];
        let hook = [[0.0, 0.0], [0.0, 0.01], [0.02, 0.02], [5.0, 3.0]];
        for control_points in [cusp, hook] {
            let curve = CurveRecord { control_points };
            let table = ArcLengths::new(points(&curve));
            let record = EdgeRecord { length: table.length() as f32, ..EdgeRecord::default() };
            let edge = Edge::new(record, &[curve]);
            for step in 0..=5000 {
                let s = table.length() * f64::from(step) / 5000.0;
                let (found, exact) =
                    (edge.at(s as f32).expect("a curve").0, table.sample(s).position);
                let off = found.distance(exact);
                assert!(off < 2e-3, "{control_points:?} at {s}: {found}, not {exact}");
            }
        }
    }

    /// Two curves of an edge may meet at any angle.
    #[test]
    fn a_corner_within_an_edge_is_sharp() {
        let east = CurveRecord::straight([0.0, 0.0], [5.0, 0.0]);
        let north =
            CurveRecord { control_points: [[5.0, 0.0], [5.0, 1.2], [5.6, 1.8], [6.8, 1.8]] };
        let length = 5.0 + ArcLengths::new(points(&north)).length() as f32;
        let edge = Edge::new(EdgeRecord { length, ..EdgeRecord::default() }, &[east, north]);
        let (position, tangent) = edge.at(4.999).expect("a curve");
        assert!(
            (position[0] - 4.999).abs() < 1e-5 && position[1] == 0.0 && tangent == 0.0,
            "{position:?} {tangent}"
        );
        let (position, tangent) = edge.at(5.001).expect("a curve");
        assert!(
            (position[1] - 0.001).abs() < 1e-5 && (tangent - 1.570).abs() < 2e-3,
            "{position:?} {tangent}"
        );
        let (position, _) = edge.at(length).expect("a curve");
        assert!(
            (position[0] - 6.8).abs() < 1e-5 && (position[1] - 1.8).abs() < 1e-5,
            "{position:?}"
        );
    }
}
