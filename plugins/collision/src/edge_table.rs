//! The edges of the route graph as polylines of chords, which predictions follow.

use glam::{DVec2, Vec2};
use regatta_base::bezier::{CubicBezier, Side};
use regatta_plugin::World;
use regatta_plugin::world::{CurveRecord, EdgeRecord, Orientation};

use crate::heading::heading;

/// The largest turn of an edge along one chord, in radians.
const MAX_TURN: f64 = 0.2;
/// The largest distance of an edge from a chord, in metres.
const MAX_DEVIATION: f64 = 0.02;
/// A turn along a chord from which on it counts as a cusp, in radians.
const MAX_SMOOTH_TURN: f64 = 1.0;
/// The number of curve samples that chords are built from. A chord may span a single step even if
/// that turns more, as a cusp has no smooth heading.
const STEPS: usize = 32;

/// A straight line between two points of an edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chord {
    /// Distance along the edge at which the chord ends, in metres; infinity for the last chord.
    pub end: f32,
    /// Displacement east and north per metre along the edge.
    pub step: Vec2,
    /// Heading of robots on the chord if they don't turn along it, as a unit vector: along the
    /// chord, or as the edge's orientation says.
    pub heading: Vec2,
    /// Heading of robots where the chord starts, as a unit vector.
    pub start_heading: Vec2,
    /// Turn of robots along the chord, in radians per metre. At a cusp, which has no smooth
    /// heading, it is 0.
    pub turn: f32,
}

/// All edges as chords. Before its origin and beyond its destination, an edge continues along its
/// tangent.
#[derive(Debug, Default)]
pub(crate) struct EdgeTable {
    chords: Vec<Chord>,
    /// Index of each edge's first chord, and the end of the last edge's chords.
    starts: Vec<usize>,
    /// Orientation of each edge; empty if all are tangential.
    orientations: Vec<Orientation>,
}

impl EdgeTable {
    pub(crate) fn new(world: &World<'_>) -> Self {
        let mut edge_table = Self { chords: Vec::new(), starts: vec![0], orientations: Vec::new() };
        for edge in world.edges() {
            edge_table
                .chords
                .extend(oriented(chords(edge, world.curves(edge)), edge.orientation()));
            edge_table.starts.push(edge_table.chords.len());
            edge_table.orientations.push(edge.orientation());
        }
        if edge_table.orientations.iter().all(|orientation| *orientation == Orientation::Tangential)
        {
            edge_table.orientations.clear();
        }
        edge_table
    }

    pub(crate) fn are_tangential(&self) -> bool {
        self.orientations.is_empty()
    }

    /// Returns the direction of travel in forward gear, as a unit vector, of a robot on an edge
    /// with this heading.
    pub(crate) fn direction(&self, edge: u32, s: f32, robot: Vec2) -> Vec2 {
        match self.orientations.get(edge as usize) {
            None | Some(Orientation::Tangential) => robot,
            Some(Orientation::Offset(angle)) => heading(-angle).rotate(robot),
            Some(Orientation::Fixed(_)) => self.chord_direction(edge, s).unwrap_or(robot),
        }
    }

    fn chord_direction(&self, edge: u32, s: f32) -> Option<Vec2> {
        let chords = self.chords(edge);
        let step = chords.iter().find(|chord| s < chord.end).or(chords.last())?.step;
        let length = step.x.hypot(step.y);
        (length > 0.0).then(|| step / length)
    }

    /// Returns the chords of an edge by its index; empty if there is no such edge, or it isn't a
    /// curve.
    pub(crate) fn chords(&self, edge: u32) -> &[Chord] {
        let index = edge as usize;
        match (self.starts.get(index), self.starts.get(index.wrapping_add(1))) {
            (Some(&start), Some(&end)) => &self.chords[start..end],
            _ => &[],
        }
    }

    /// Returns the distance along an edge at which its last chord ends, in metres; `None` if it has
    /// a single chord, or none.
    pub(crate) fn length(&self, edge: u32) -> Option<f32> {
        if let [.., last, _] = self.chords(edge) { Some(last.end) } else { None }
    }
}

/// A point of the curve at which a chord starts or ends.
#[derive(Clone, Copy)]
struct Knot {
    point: DVec2,
    tangent: DVec2,
}

/// Returns the chords of an edge whose robots have the heading of the tangent.
fn chords(edge: &EdgeRecord, curves: &[CurveRecord]) -> Vec<Chord> {
    let is_finite = curves
        .iter()
        .flat_map(|curve| curve.control_points.as_flattened())
        .all(|metres| metres.is_finite());
    if !(edge.length > 0.0 && edge.length.is_finite() && is_finite) {
        return Vec::new();
    }
    // The end of a curve and the start of the next one are two knots, with a tangent each. Curves
    // without a length have no tangent, and are left out.
    let cubics = curves.iter().map(|curve| CubicBezier {
        control_points: curve.control_points.map(|point| Vec2::from(point).as_dvec2()),
    });
    let knots = cubics.map(|cubic| knots(&cubic));
    let knots: Vec<_> = knots.filter(|knots| polyline_length(knots) > 0.0).flatten().collect();
    let total = polyline_length(&knots);
    let (Some(first), Some(last)) = (knots.first(), knots.last()) else { return Vec::new() };
    // Arcs are slightly longer than their chords. None may be shorter, or robots would exceed their
    // speed.
    let scale = (f64::from(edge.length) / total).max(1.0);
    let mut end = 0.0;
    let mut chords = vec![straight_on(first.tangent, 0.0)];
    for pair in knots.windows(2) {
        let along = pair[1].point - pair[0].point;
        let chord = along.length();
        if chord > 0.0 {
            end += chord * scale;
            chords.push(Chord {
                end: end as f32,
                step: (along / (chord * scale)).as_vec2(),
                heading: (along / chord).as_vec2(),
                start_heading: pair[0].tangent.as_vec2(),
                turn: turn_per_metre(pair, chord * scale),
            });
        }
    }
    chords.push(straight_on(last.tangent, f32::INFINITY));
    if is_straight(&chords) {
        vec![Chord { end: f32::INFINITY, turn: 0.0, ..chords[1] }]
    } else {
        chords
    }
}

fn straight_on(tangent: DVec2, end: f32) -> Chord {
    let tangent = tangent.as_vec2();
    Chord { end, step: tangent, heading: tangent, start_heading: tangent, turn: 0.0 }
}

/// Returns the chords with the headings of an orientation.
fn oriented(mut chords: Vec<Chord>, orientation: Orientation) -> Vec<Chord> {
    for chord in &mut chords {
        match orientation {
            Orientation::Tangential => {}
            Orientation::Offset(angle) => {
                let turn = heading(angle);
                chord.heading = turn.rotate(chord.heading);
                chord.start_heading = turn.rotate(chord.start_heading);
            }
            Orientation::Fixed(angle) => {
                (chord.heading, chord.start_heading, chord.turn) =
                    (heading(angle), heading(angle), 0.0);
            }
        }
    }
    chords
}

fn polyline_length(knots: &[Knot]) -> f64 {
    knots.windows(2).map(|pair| pair[0].point.distance(pair[1].point)).sum()
}

/// Returns the turn between two knots that are so many metres apart, in radians per metre.
fn turn_per_metre(knots: &[Knot], metres: f64) -> f32 {
    let (from, to) = (knots[0].tangent, knots[1].tangent);
    let turn = from.perp_dot(to).atan2(from.dot(to));
    if turn.abs() > MAX_SMOOTH_TURN { 0.0 } else { (turn / metres) as f32 }
}

fn is_straight(chords: &[Chord]) -> bool {
    let [before, only, after] = chords else { return false };
    [before, after].iter().all(|chord| (chord.heading - only.heading).abs().max_element() < 1e-5)
}

/// Returns few points of a curve, such that the chords between them stay within [`MAX_TURN`] and
/// [`MAX_DEVIATION`].
fn knots(curve: &CubicBezier) -> Vec<Knot> {
    let ends = [knot(curve, 0.0), knot(curve, 1.0)];
    if is_straight_line(&curve.control_points) {
        return ends.to_vec();
    }
    let all: Vec<_> = (0..=STEPS).map(|step| knot(curve, step as f64 / STEPS as f64)).collect();
    let mut knots = vec![all[0]];
    let mut start = 0;
    while start < STEPS {
        let mut turned = turn(all[start].tangent, all[start + 1].tangent);
        let mut end = start + 1;
        while end < STEPS {
            turned += turn(all[end].tangent, all[end + 1].tangent);
            if turned > MAX_TURN || deviates(&all[start..=end + 1]) {
                break;
            }
            end += 1;
        }
        knots.push(all[end]);
        start = end;
    }
    knots
}

/// Whether the control points lie on a straight line, in order.
fn is_straight_line(points: &[DVec2; 4]) -> bool {
    let along = points[3] - points[0];
    let [first, second] = [points[1] - points[0], points[2] - points[0]];
    let (square, aside) =
        (along.length_squared(), [first, second].map(|to| along.perp_dot(to).abs()));
    let [first, second] = [along.dot(first), along.dot(second)];
    aside.iter().all(|aside| *aside <= 1e-6 * square)
        && 0.0 <= first
        && first <= second
        && second <= square
}

/// Whether this part of a curve deviates too much from the chord between its ends.
fn deviates(part: &[Knot]) -> bool {
    let [first, .., last] = part else { return false };
    let along = last.point - first.point;
    let most = MAX_DEVIATION * along.length();
    part.iter().any(|knot| along.perp_dot(knot.point - first.point).abs() > most)
}

fn knot(curve: &CubicBezier, at: f64) -> Knot {
    Knot { point: curve.position(at), tangent: curve.tangent(at, Side::After) }
}

/// Returns the angle between two unit vectors, in radians.
fn turn(a: DVec2, b: DVec2) -> f64 {
    a.perp_dot(b).abs().atan2(a.dot(b))
}

#[cfg(test)]
mod tests {
    use regatta_plugin::world::WorldData;

    use super::*;
    use crate::geometry_reference::world;

    #[test]
    fn edges_that_are_no_curves_have_no_chords() {
        let (good, line) = (
            EdgeRecord { length: 3.0, ..EdgeRecord::default() },
            [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]],
        );
        let mut world = world([
            (EdgeRecord { length: f32::NAN, ..good }, line),
            (EdgeRecord { length: 0.0, ..good }, line),
            (good, [[0.0, f32::INFINITY]; 4]),
            (good, [[1.0, 1.0]; 4]),
            (good, line),
        ]);
        world.edges.push(EdgeRecord { first_curve: 4, curves: 9, ..good });
        let edge_table = EdgeTable::new(&world.view(1, 1));
        assert_eq!(
            [0, 1, 2, 3, 4, 5, 6, u32::MAX].map(|edge| edge_table.chords(edge).len()),
            [0, 0, 0, 0, 1, 0, 0, 0]
        );
    }

    /// An edge 4 m to the east and 3 m to the north: a straight line, a point, a straight line and
    /// a bend.
    fn corner(orientation: Orientation) -> EdgeTable {
        let mut world = WorldData::default();
        let edge =
            EdgeRecord { length: 7.4, ..EdgeRecord::default() }.with_orientation(orientation);
        let line = CurveRecord::straight;
        let bend = CurveRecord { control_points: [[4.0, 2.0], [4.0, 2.6], [4.2, 3.0], [5.0, 3.0]] };
        world.add_edge(
            edge,
            [
                line([0.0, 0.0], [4.0, 0.0]),
                line([4.0, 0.0], [4.0, 0.0]),
                line([4.0, 0.0], [4.0, 2.0]),
                bend,
            ],
        );
        EdgeTable::new(&world.view(1, 1))
    }

    #[test]
    fn an_edge_follows_all_its_curves() {
        let edge_table = corner(Orientation::Tangential);
        let chords = edge_table.chords(0);
        let (mut at, mut from) = (Vec2::ZERO, 0.0);
        for chord in &chords[1..chords.len() - 1] {
            at += chord.step * (chord.end - from);
            from = chord.end;
        }
        assert!((at - Vec2::new(5.0, 3.0)).abs().max_element() < 1e-4, "{at:?}");
        assert_eq!(
            (chords[1].heading, chords[2].heading),
            (Vec2::X, Vec2::Y),
            "the corner is not smoothed"
        );
        assert_eq!(chords[chords.len() - 1].heading, Vec2::X, "beyond the bend");
        assert_eq!(edge_table.length(0), Some(from));
    }

    #[test]
    fn robots_have_the_heading_of_the_orientation() {
        let near = |a: Vec2, b: Vec2| (a - b).abs().max_element() < 1e-6;
        let sideways = corner(Orientation::Offset(std::f32::consts::FRAC_PI_2));
        assert!(
            near(sideways.chords(0)[1].heading, Vec2::Y)
                && near(sideways.chords(0)[2].heading, Vec2::NEG_X)
        );
        assert!(near(sideways.chords(0)[1].step, Vec2::X), "{:?}", sideways.chords(0)[1]);
        assert!(near(sideways.direction(0, 1.0, Vec2::Y), Vec2::X));
        let fixed = corner(Orientation::Fixed(0.0));
        assert!(fixed.chords(0).iter().all(|chord| chord.heading == Vec2::X && chord.turn == 0.0));
        assert!(near(fixed.direction(0, 5.0, Vec2::X), Vec2::Y), "it drives north, sideways");
        assert_eq!(fixed.direction(7, 5.0, Vec2::X), Vec2::X, "no such edge");
    }
}
