//! The world as the judge needs it: curves by arc length, limits, and which edges leave which node.

use regatta_plugin::World;
use regatta_plugin::world::{CurveRecord, EdgeRecord, NodeRecord, Orientation, RobotTypeRecord};

/// The distance in metres between two samples of a curve with which the search for a fine enough
/// one begins.
const STEP_METRES: f64 = 0.4;
const FEWEST_STEPS: usize = 8;
/// From this number of samples on, a curve isn't sampled more finely: it has a cusp.
const MOST_STEPS: usize = 1 << 10;
/// What is between two samples may differ by this much from the curve, in metres and in radians.
const FINE: [f32; 2] = [2e-4, 2e-3];
/// The intervals of a curve's parameter over which its length is summed up.
const INTERVALS: usize = 64;

/// The world, prepared once per change.
#[derive(Debug, Default)]
pub(crate) struct Site {
    pub nodes: Vec<NodeRecord>,
    pub edges: Vec<Edge>,
    pub types: Vec<RobotTypeRecord>,
    /// The legs that leave node `n` are `leaving[first_leaving[n]..first_leaving[n + 1]]`: edge,
    /// and whether in reverse gear.
    first_leaving: Vec<usize>,
    leaving: Vec<(u32, bool)>,
    /// Metres per second on the fastest edge in either gear; infinite if there are no edges.
    pub fastest: f64,
}

/// An edge and its curves. Consecutive ones may meet at a corner, so that each has samples of its
/// own.
#[derive(Debug)]
pub(crate) struct Edge {
    pub record: EdgeRecord,
    parts: Vec<Part>,
}

/// A curve of an edge.
#[derive(Debug)]
struct Part {
    /// Metres from the edge's origin to its beginning.
    start: f32,
    /// Metres.
    length: f32,
    /// Position and unit tangent at its beginning and at its end.
    ends: [[f32; 4]; 2],
    /// The angle of the tangent at its beginning, in radians.
    tangent: f32,
    /// Position and unit tangent at evenly spaced arc lengths; empty for a straight line.
    samples: Vec<[f32; 4]>,
}

impl Site {
    pub fn new(world: &World<'_>) -> Self {
        let nodes = world.nodes().to_vec();
        let edges: Vec<_> =
            world.edges().iter().map(|edge| Edge::new(*edge, world.curves(edge))).collect();
        let mut legs: Vec<(u32, u32, bool)> = Vec::new();
        for (number, edge) in (0..).zip(&edges) {
            legs.push((edge.record.origin, number, false));
            if edge.record.velocity_backwards > 0.0 {
                legs.push((edge.record.destination, number, true));
            }
        }
        legs.sort_unstable();
        let first_leaving = (0..=nodes.len())
            .map(|node| legs.partition_point(|leg| (leg.0 as usize) < node))
            .collect();
        let fastest = edges
            .iter()
            .flat_map(|edge| [edge.record.velocity_forward, edge.record.velocity_backwards]);
        let fastest =
            if edges.is_empty() { f64::INFINITY } else { fastest.fold(0.0, f32::max).into() };
        let leaving = legs.into_iter().map(|(_, edge, reverse)| (edge, reverse)).collect();
        Self { nodes, edges, types: world.robot_types().to_vec(), first_leaving, leaving, fastest }
    }

    /// The legs that leave a node: edge, and whether it is driven in reverse gear.
    pub fn leaving(&self, node: u32) -> &[(u32, bool)] {
        let node = node as usize;
        match (self.first_leaving.get(node), self.first_leaving.get(node + 1)) {
            (Some(first), Some(end)) => &self.leaving[*first..*end],
            _ => &[],
        }
    }

    pub fn edge(&self, edge: u32) -> Option<&Edge> {
        self.edges.get(edge as usize)
    }

    /// Returns the type with an index; without it, the first one, or 0.9 m × 0.6 m without limits.
    pub fn robot_type(&self, index: usize) -> RobotTypeRecord {
        let found = self.types.get(index).or_else(|| self.types.first());
        found.copied().unwrap_or_else(|| RobotTypeRecord::new("unknown", 0.9, 0.6))
    }

    /// The position of the node with an id.
    pub fn node(&self, id: u32) -> Option<[f32; 2]> {
        self.nodes.iter().find(|node| node.id == id).map(|node| [node.x, node.y])
    }
}

impl Edge {
    pub fn new(record: EdgeRecord, curves: &[CurveRecord]) -> Self {
        let (mut parts, mut start) = (Vec::new(), 0.0);
        for curve in curves {
            let (samples, length) =
                if is_straight(curve) { straight_samples(curve) } else { curved_samples(curve) };
            let ([Some(first), Some(last)], true) =
                ([samples.first(), samples.last()], length > 0.0)
            else {
                continue;
            };
            let (ends, tangent) = ([*first, *last], first[3].atan2(first[2]));
            let samples = if samples.len() > 2 { samples } else { Vec::new() };
            parts.push(Part { start: start as f32, length: length as f32, ends, tangent, samples });
            start += length;
        }
        // Positions along the edge are measured in the length that the world says.
        let scale = (f64::from(record.length) / start) as f32;
        for part in &mut parts {
            (part.start, part.length) = (part.start * scale, part.length * scale);
        }
        Self { record, parts }
    }

    /// Returns the position and the angle of the tangent at a distance from the origin, in metres.
    /// `None` if the world has no curve for the edge.
    pub fn at(&self, s: f32) -> Option<([f32; 2], f32)> {
        let part = match &self.parts[..] {
            [part] => part,
            parts => parts.get(parts.partition_point(|part| part.start <= s).saturating_sub(1))?,
        };
        Some(part.at((s - part.start) / part.length))
    }

    /// Returns the heading of a robot where the tangent has this angle.
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
    fn at(&self, fraction: f32) -> ([f32; 2], f32) {
        let fraction = if fraction.is_finite() { fraction.clamp(0.0, 1.0) } else { 0.0 };
        let Some(last) = self.samples.len().checked_sub(1) else {
            let [[ax, ay, ..], [bx, by, ..]] = self.ends;
            return ([ax + fraction * (bx - ax), ay + fraction * (by - ay)], self.tangent);
        };
        let place = fraction * last as f32;
        let index = (place as usize).min(last - 1);
        let (samples, distance) =
            ([self.samples[index], self.samples[index + 1]], self.length / last as f32);
        let [x, y, tx, ty] = between(samples, distance, place - index as f32);
        ([x, y], ty.atan2(tx))
    }
}

/// Returns position and tangent between two samples that are so far apart, by Hermite's cubic.
fn between(
    [[ax, ay, atx, aty], [bx, by, btx, bty]]: [[f32; 4]; 2],
    distance: f32,
    t: f32,
) -> [f32; 4] {
    let (t2, t3) = (t * t, t * t * t);
    let (h01, h10, h11) =
        (3.0 * t2 - 2.0 * t3, (t3 - 2.0 * t2 + t) * distance, (t3 - t2) * distance);
    let x = ax + h01 * (bx - ax) + h10 * atx + h11 * btx;
    let y = ay + h01 * (by - ay) + h10 * aty + h11 * bty;
    [x, y, atx + t * (btx - atx), aty + t * (bty - aty)]
}

fn points(curve: &CurveRecord) -> [[f64; 2]; 4] {
    curve.control_points.map(|point| point.map(f64::from))
}

/// Whether a curve drives from its first to its last point straight and without turning back.
fn is_straight(curve: &CurveRecord) -> bool {
    let [a, b, c, d] = points(curve);
    let (dx, dy) = (d[0] - a[0], d[1] - a[1]);
    let square = dx * dx + dy * dy;
    let along = |p: [f64; 2]| ((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / square;
    let beside = |p: [f64; 2]| ((p[0] - a[0]) * dy - (p[1] - a[1]) * dx).abs() / square.sqrt();
    let in_order = -1e-6 <= along(b) && along(b) <= along(c) && along(c) <= 1.0 + 1e-6;
    square > 0.0 && in_order && beside(b) < 1e-5 && beside(c) < 1e-5
}

/// Returns both ends of a straight line, with tangents, and its length.
fn straight_samples(curve: &CurveRecord) -> (Vec<[f32; 4]>, f64) {
    let [a, _, _, d] = points(curve);
    let (dx, dy) = (d[0] - a[0], d[1] - a[1]);
    let length = dx.hypot(dy);
    (
        [a, d].map(|[x, y]| [x, y, dx / length, dy / length].map(|value| value as f32)).to_vec(),
        length,
    )
}

/// Returns samples at evenly spaced arc lengths, and the length.
fn curved_samples(curve: &CurveRecord) -> (Vec<[f32; 4]>, f64) {
    let table = Table::new(points(curve));
    let length = table.length();
    let mut steps = ((length / STEP_METRES).ceil() as usize)
        .clamp(FEWEST_STEPS, MOST_STEPS)
        .next_multiple_of(2);
    loop {
        let samples: Vec<_> =
            (0..=steps).map(|step| table.sample(length * step as f64 / steps as f64)).collect();
        if steps >= MOST_STEPS || is_fine(&samples, (length / steps as f64) as f32) {
            return (samples, length);
        }
        steps *= 2;
    }
}

/// Whether every other sample is where it would be without it.
fn is_fine(samples: &[[f32; 4]], distance: f32) -> bool {
    samples.windows(3).step_by(2).all(|part| {
        let [x, y, tx, ty] = between([part[0], part[2]], 2.0 * distance, 0.5);
        let [mx, my, mtx, mty] = part[1];
        // The middle of two opposite tangents has no direction.
        let is_turned = (tx * mty - ty * mtx).abs() <= FINE[1] * (tx * mtx + ty * mty);
        (x - mx).abs().max((y - my).abs()) <= FINE[0] && is_turned
    })
}

/// The arc length of one curve, by quadrature.
struct Table {
    points: [[f64; 2]; 4],
    /// Arc length at the ends of the intervals.
    lengths: Vec<f64>,
}

impl Table {
    fn new(points: [[f64; 2]; 4]) -> Self {
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

    fn derivative(&self, t: f64) -> [f64; 2] {
        let u = 1.0 - t;
        let [a, b, c, d] = self.points;
        [0, 1].map(|i| {
            3.0 * (u * u * (b[i] - a[i]) + 2.0 * u * t * (c[i] - b[i]) + t * t * (d[i] - c[i]))
        })
    }

    fn position(&self, t: f64) -> [f64; 2] {
        let u = 1.0 - t;
        let [a, b, c, d] = self.points;
        [0, 1].map(|i| {
            u * u * u * a[i] + 3.0 * u * u * t * b[i] + 3.0 * u * t * t * c[i] + t * t * t * d[i]
        })
    }

    /// Gauss and Legendre's rule of three points.
    fn length_between(&self, from: f64, to: f64) -> f64 {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let speed = |offset: f64| {
            let [x, y] = self.derivative(middle + half * offset);
            x.hypot(y)
        };
        let outer = 0.6_f64.sqrt();
        half / 9.0 * (5.0 * speed(-outer) + 8.0 * speed(0.0) + 5.0 * speed(outer))
    }

    /// Returns position and unit tangent at an arc length.
    fn sample(&self, s: f64) -> [f32; 4] {
        let interval = self.lengths.partition_point(|length| *length <= s).clamp(1, INTERVALS) - 1;
        let (low, high) = (self.lengths[interval], self.lengths[interval + 1]);
        let from = interval as f64 / INTERVALS as f64;
        let part = if high > low { ((s - low) / (high - low)).clamp(0.0, 1.0) } else { 0.0 };
        let mut t = from + part / INTERVALS as f64;
        for _ in 0..3 {
            let [x, y] = self.derivative(t);
            let speed = x.hypot(y);
            if speed < 1e-9 {
                break;
            }
            t = (t - (low + self.length_between(from, t) - s) / speed).clamp(0.0, 1.0);
        }
        let [x, y] = self.position(t);
        let [dx, dy] = self.direction(t);
        [x, y, dx, dy].map(|value| value as f32)
    }

    /// The unit tangent; where the curve stands still (a handle of length 0), that just beside it.
    fn direction(&self, t: f64) -> [f64; 2] {
        for nudge in [0.0, 1e-4, 1e-2] {
            let [x, y] = self.derivative(if t < 0.5 { t + nudge } else { t - nudge });
            let speed = x.hypot(y);
            if speed > 1e-7 {
                return [x / speed, y / speed];
            }
        }
        [1.0, 0.0]
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
            let ([x, y], tangent) = edge.at(2.0 * angle as f32).expect("a curve");
            let off = (f64::from(x) - 2.0 * angle.cos()).hypot(f64::from(y) - 2.0 * angle.sin());
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
        assert_eq!(edge.at(2.0).map(|(position, _)| position), Some([1.0, 3.0]));
        assert!(edge.parts[0].samples.is_empty());
        assert!(Edge::new(record, &[]).at(1.0).is_none());
    }

    /// A curve that turns back in its middle, and one that is much curved at its beginning.
    #[test]
    fn sharp_bends_are_sampled_finely() {
        let cusp = [[0.0, 0.0], [4.0, 2.0], [0.0, 2.0], [4.0, 0.0]];
        let hook = [[0.0, 0.0], [0.0, 0.01], [0.02, 0.02], [5.0, 3.0]];
        for control_points in [cusp, hook] {
            let table = Table::new(control_points.map(|point: [f32; 2]| point.map(f64::from)));
            let record = EdgeRecord { length: table.length() as f32, ..EdgeRecord::default() };
            let edge = Edge::new(record, &[CurveRecord { control_points }]);
            for step in 0..=5000 {
                let s = table.length() * f64::from(step) / 5000.0;
                let ([x, y], _) = edge.at(s as f32).expect("a curve");
                let [tx, ty, ..] = table.sample(s);
                assert!(
                    (x - tx).hypot(y - ty) < 2e-3,
                    "{control_points:?} at {s}: ({x}, {y}), not ({tx}, {ty})"
                );
            }
        }
    }

    /// Two curves of an edge may meet at any angle.
    #[test]
    fn a_corner_within_an_edge_is_sharp() {
        let east = CurveRecord::straight([0.0, 0.0], [5.0, 0.0]);
        let north =
            CurveRecord { control_points: [[5.0, 0.0], [5.0, 1.2], [5.6, 1.8], [6.8, 1.8]] };
        let length = 5.0 + Table::new(points(&north)).length() as f32;
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
