//! The edges of the route graph as straight chords, which is how predicted robots drive them.

use regatta_plugin::world::EdgeRecord;

use crate::body::Vector;

/// Most that an edge turns from one end of a chord to the other, in radians.
const MAX_TURN: f64 = 0.2;
/// Most that an edge strays from a chord, in metres.
const MAX_STRAY: f64 = 0.02;
/// Parts of an edge that chords are made of; one is good enough, as a cusp has no smooth heading.
const PARTS: usize = 32;

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
    // Arcs are a little longer than their chords. None are shorter, or robots would get ahead of their speed.
    let scale = (f64::from(edge.length) / total).max(1.0);
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

/// As few points of the curve as will do.
fn joints(points: &[Vector; 4]) -> Vec<Joint> {
    let ends = [joint(points, 0.0), joint(points, 1.0)];
    if is_straight_line(points) {
        return ends.to_vec();
    }
    let all: Vec<_> = (0..=PARTS).map(|part| joint(points, part as f64 / PARTS as f64)).collect();
    let mut joints = vec![all[0]];
    let mut start = 0;
    while start < PARTS {
        let mut turned = turn(all[start].tangent, all[start + 1].tangent);
        let mut end = start + 1;
        while end < PARTS {
            turned += turn(all[end].tangent, all[end + 1].tangent);
            if turned > MAX_TURN || strays(&all[start..=end + 1]) {
                break;
            }
            end += 1;
        }
        joints.push(all[end]);
        start = end;
    }
    joints
}

/// Whether the control points lie in a row.
fn is_straight_line(points: &[Vector; 4]) -> bool {
    let along = minus(points[3], points[0]);
    let place = |point: Vector| (dot(along, minus(point, points[0])), cross(along, minus(point, points[0])).abs());
    let [(first, aside), (second, aside_too)] = [place(points[1]), place(points[2])];
    let square = dot(along, along);
    aside.max(aside_too) <= 1e-6 * square && 0.0 <= first && first <= second && second <= square
}

/// Whether this part of a curve is too far from the straight line between its ends.
fn strays(part: &[Joint]) -> bool {
    let [first, .., last] = part else { return false };
    let along = minus(last.point, first.point);
    let most = MAX_STRAY * length(along);
    part.iter().any(|joint| cross(along, minus(joint.point, first.point)).abs() > most)
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
    cross(a, b).abs().atan2(dot(a, b))
}

fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1]]
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1]
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
