//! The edges of the route graph as straight chords, which is how predicted robots drive them.

use regatta_plugin::world::EdgeRecord;

use crate::body::Vector;

/// Most that an edge turns from one end of a chord to the other, in radians.
const MAX_TURN: f64 = 0.2;
/// Most that an edge strays from a chord, in metres.
const MAX_STRAY: f64 = 0.01;
/// Halvings after which a chord is good enough: a cusp has no smooth heading.
const MAX_HALVINGS: u32 = 6;

/// A straight part of an edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chord {
    /// Metres along the edge where it ends; infinity for the last.
    pub end: f32,
    /// How far a robot gets, east and north, in one metre along the edge.
    pub step: [f32; 2],
    /// Unit vector along it.
    pub heading: [f32; 2],
    /// Unit tangent of the edge where it starts.
    pub tangent: [f32; 2],
}

/// All edges. Before its origin and beyond its destination, an edge goes on along the tangent.
#[derive(Debug, Default)]
pub(crate) struct Paths {
    chords: Vec<Chord>,
    /// Where each edge's chords start, and where the last one's end.
    starts: Vec<usize>,
}

impl Paths {
    pub(crate) fn new(edges: &[EdgeRecord]) -> Self {
        let mut paths = Self { chords: Vec::new(), starts: vec![0] };
        for edge in edges {
            paths.chords.extend(chords(edge));
            paths.starts.push(paths.chords.len());
        }
        paths
    }

    /// The chords of an edge, by its index: at least one, or none if there is no such edge or it is no curve.
    pub(crate) fn of(&self, edge: u32) -> &[Chord] {
        let index = edge as usize;
        match (self.starts.get(index), self.starts.get(index.wrapping_add(1))) {
            (Some(&start), Some(&end)) => &self.chords[start..end],
            _ => &[],
        }
    }
}

/// A point of the curve, where a chord starts or ends.
#[derive(Clone, Copy)]
struct Joint {
    point: Vector,
    tangent: Vector,
}

fn chords(edge: &EdgeRecord) -> Vec<Chord> {
    let points = edge.control_points.map(|point| point.map(f64::from));
    let sane = points.iter().flatten().all(|metres| metres.is_finite()) && edge.length > 0.0 && edge.length.is_finite();
    let joints = if sane { joints(&points) } else { Vec::new() };
    let total: f64 = joints.windows(2).map(|pair| length(minus(pair[1].point, pair[0].point))).sum();
    let (Some(first), Some(last)) = (joints.first(), joints.last()) else { return Vec::new() };
    if total <= 0.0 {
        return Vec::new();
    }
    // Arc lengths are a little more than chords.
    let scale = f64::from(edge.length) / total;
    let mut end = 0.0;
    let mut chords = vec![straight_on(first.tangent, 0.0)];
    for pair in joints.windows(2) {
        let along = minus(pair[1].point, pair[0].point);
        let chord = length(along);
        if chord > 0.0 {
            end += chord * scale;
            let (step, heading) = (along.map(|part| part / (chord * scale)), along.map(|part| part / chord));
            chords.push(Chord {
                end: end as f32,
                step: narrow(step),
                heading: narrow(heading),
                tangent: narrow(pair[0].tangent),
            });
        }
    }
    chords.push(straight_on(last.tangent, f32::INFINITY));
    if is_straight(&chords) { vec![Chord { end: f32::INFINITY, ..chords[1] }] } else { chords }
}

fn straight_on(tangent: Vector, end: f32) -> Chord {
    let tangent = narrow(tangent);
    Chord { end, step: tangent, heading: tangent, tangent }
}

fn is_straight(chords: &[Chord]) -> bool {
    let [before, only, after] = chords else { return false };
    let turns = |a: &Chord, b: &Chord| (a.heading[0] - b.heading[0]).abs().max((a.heading[1] - b.heading[1]).abs());
    turns(before, only).max(turns(only, after)) < 1e-5
}

fn joints(points: &[Vector; 4]) -> Vec<Joint> {
    let mut joints = vec![joint(points, 0.0)];
    split(points, (0.0, 1.0), 0, &mut joints);
    joints
}

/// Adds the joints after `from` up to `to`.
fn split(points: &[Vector; 4], (from, to): (f64, f64), halvings: u32, joints: &mut Vec<Joint>) {
    let middle = 0.5 * (from + to);
    let [start, centre, end] = [from, middle, to].map(|at| joint(points, at));
    let along = minus(end.point, start.point);
    let strays = cross(along, minus(centre.point, start.point)).abs() > MAX_STRAY * length(along);
    let turns = turn(start.tangent, centre.tangent) + turn(centre.tangent, end.tangent) > MAX_TURN;
    if halvings < MAX_HALVINGS && (strays || turns) {
        split(points, (from, middle), halvings + 1, joints);
        split(points, (middle, to), halvings + 1, joints);
    } else {
        joints.push(end);
    }
}

fn joint(points: &[Vector; 4], at: f64) -> Joint {
    let mix = |a: Vector, b: Vector| [a[0] + at * (b[0] - a[0]), a[1] + at * (b[1] - a[1])];
    let [p0, p1, p2, p3] = *points;
    let [a, b, c] = [mix(p0, p1), mix(p1, p2), mix(p2, p3)];
    let (d, e) = (mix(a, b), mix(b, c));
    // Where a handle has no length, the next points show the way.
    let ways = [minus(e, d), minus(c, a), minus(p3, p0)];
    let shortest = 1e-9 * length(minus(p3, p0)).max(length(minus(p2, p1)));
    let way = ways.into_iter().find(|way| length(*way) > shortest).unwrap_or([1.0, 0.0]);
    Joint { point: mix(d, e), tangent: way.map(|part| part / length(way)) }
}

/// Radians between two unit vectors.
fn turn(a: Vector, b: Vector) -> f64 {
    cross(a, b).abs().atan2(a[0] * b[0] + a[1] * b[1])
}

fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1]]
}

fn cross(a: Vector, b: Vector) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn length(vector: Vector) -> f64 {
    (vector[0] * vector[0] + vector[1] * vector[1]).sqrt()
}

fn narrow(vector: Vector) -> [f32; 2] {
    vector.map(|part| part as f32)
}
