//! Joins curves where their ends meet, and splits them where the end of another touches them.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec2;
use regatta_base::bezier::CubicBezier;

use super::expand::Curve;

/// Ends within this distance in metres are at the same place.
pub const TOLERANCE: f64 = 1e-3;

/// The length in metres up to which a curve whose ends are at one place is a dot. The halves of a
/// longer one have ends at two places, mostly.
const LONGEST_DOT: f64 = 4.0 * TOLERANCE;

/// The distance in metres within which ends that don't meet are reported.
pub const NEAR: f64 = 0.1;

/// The number of intervals of a cubic for the search of the point nearest to a node.
const INTERVALS: u32 = 16;

/// The largest number of comparisons of nodes with parts of curves. They take some seconds.
const MAX_COMPARISONS: u64 = 100_000_000;

/// Curves that are joined where their ends meet.
#[derive(Debug, Default)]
pub struct Network {
    /// The places, with the byte offset of the first curve that ends there.
    pub nodes: Vec<(DVec2, u32)>,
    pub links: Vec<Link>,
    /// Ends that nearly meet another curve, with the distance in metres.
    pub near_misses: Vec<(usize, f64)>,
    /// The curves that are left out because both ends are at one place.
    pub short: Vec<u32>,
    /// The lines that are left out, whole or in part, because another one lies there.
    pub repeated: Vec<Repeated>,
    /// Whether some nodes haven't been compared with all curves near them.
    pub is_partial: bool,
}

/// A line that repeats another one.
#[derive(Clone, Copy, Debug)]
pub struct Repeated {
    /// The byte offset of its entity.
    pub at: u32,
    /// Whether all of it does.
    pub is_whole: bool,
}

/// A curve between two places.
#[derive(Clone, Debug)]
pub struct Link {
    pub from: usize,
    pub to: usize,
    pub curve: Curve,
}

/// Joins curves.
pub fn join(curves: Vec<Curve>) -> Network {
    let mut network = Network::default();
    let mut places = Places::default();
    for curve in curves {
        network.add(curve, &mut places);
    }
    network.split_at_nodes();
    network.remove_repeated();
    network
}

/// Nodes by the square cell of [`TOLERANCE`] that they are in.
#[derive(Default)]
struct Places(BTreeMap<[i64; 2], Vec<usize>>);

fn cell(point: DVec2, size: f64) -> [i64; 2] {
    let [x, y] = (point / size).floor().to_array();
    [x as i64, y as i64]
}

/// Returns the cells between two corners.
fn cells(min: DVec2, max: DVec2, size: f64) -> impl Iterator<Item = [i64; 2]> {
    let (min, max) = (cell(min, size), cell(max, size));
    (min[1]..=max[1]).flat_map(move |y| (min[0]..=max[0]).map(move |x| [x, y]))
}

impl Network {
    fn add(&mut self, mut curve: Curve, places: &mut Places) {
        let (Some(first), Some(last)) = (curve.cubics.first(), curve.cubics.last()) else { return };
        let ends = [first.control_points[0], last.control_points[3]];
        let is_short =
            ends[0].distance(ends[1]) <= TOLERANCE && length(&curve.cubics) <= LONGEST_DOT;
        if is_short {
            self.short.push(curve.at);
            return;
        }
        let [from, to] = ends.map(|end| self.node(end, curve.at, places));
        if from == to {
            return self.add_closed(curve, places);
        }
        let [start, end] = [from, to].map(|node| self.nodes[node].0);
        move_ends(&mut curve.cubics, start, end);
        self.links.push(Link { from, to, curve });
    }

    /// Adds the halves of a curve that starts and ends at one node, as no edge does.
    fn add_closed(&mut self, curve: Curve, places: &mut Places) {
        let Curve { at, line, layer, cubics } = curve;
        if length(&cubics) <= LONGEST_DOT {
            self.short.push(at);
            return;
        }
        for cubics in bisected(cubics) {
            self.add(Curve { at, line, layer: layer.clone(), cubics }, places);
        }
    }

    /// Returns the node at a point, which is added if there is none within the tolerance.
    fn node(&mut self, point: DVec2, at: u32, places: &mut Places) -> usize {
        let near = cells(point - TOLERANCE, point + TOLERANCE, TOLERANCE)
            .filter_map(|cell| places.0.get(&cell));
        let found =
            near.flatten().copied().find(|&node| self.nodes[node].0.distance(point) <= TOLERANCE);
        found.unwrap_or_else(|| {
            self.nodes.push((point, at));
            places.0.entry(cell(point, TOLERANCE)).or_default().push(self.nodes.len() - 1);
            self.nodes.len() - 1
        })
    }

    /// Splits links at nodes on them, and finds ends that nearly meet another link.
    fn split_at_nodes(&mut self) {
        let mut index = NodeIndex::new(&self.nodes);
        let mut degree = vec![0u32; self.nodes.len()];
        for link in &self.links {
            degree[link.from] += 1;
            degree[link.to] += 1;
        }
        let mut misses: BTreeMap<usize, f64> = BTreeMap::new();
        let mut on_link = vec![false; self.nodes.len()];
        for link in std::mem::take(&mut self.links) {
            let mut splits = Vec::new();
            for (node, place) in index.near(&link, &self.nodes) {
                if place.distance <= TOLERANCE {
                    on_link[node] = true;
                    splits.push((place.cubic, place.parameter, node));
                } else if degree[node] == 1 {
                    let least = misses.entry(node).or_insert(f64::INFINITY);
                    *least = least.min(place.distance);
                }
            }
            self.split(link, splits);
        }
        self.is_partial = index.comparisons > MAX_COMPARISONS;
        self.near_misses = misses.into_iter().filter(|&(node, _)| !on_link[node]).collect();
        self.near_misses.sort_by_key(|&(node, _)| node);
    }

    /// Adds the parts of a link between nodes at its cubics' parameters.
    fn split(&mut self, link: Link, mut splits: Vec<(usize, f64, usize)>) {
        splits.sort_by(|a, b| {
            (a.0, a.1).partial_cmp(&(b.0, b.1)).unwrap_or(std::cmp::Ordering::Equal)
        });
        let Link { mut from, to, curve } = link;
        let (part_of, cubics) = (Curve { cubics: Vec::new(), ..curve.clone() }, curve.cubics);
        let mut splits = splits.into_iter().peekable();
        // The cubics since the last split.
        let mut part = Vec::new();
        for (index, mut rest) in cubics.into_iter().enumerate() {
            let mut cut_at = 0.0;
            while let Some((_, parameter, node)) = splits.next_if(|(cubic, ..)| *cubic == index) {
                let share = (parameter - cut_at) / (1.0 - cut_at);
                if node == from || !(0.0..=1.0).contains(&share) {
                    continue;
                }
                let (before, after) = halves(&rest, share);
                part.push(before);
                self.push(from, node, std::mem::take(&mut part), &part_of);
                (from, rest, cut_at) = (node, after, parameter);
            }
            part.push(rest);
        }
        self.push(from, to, part, &part_of);
    }

    fn push(&mut self, from: usize, to: usize, mut cubics: Vec<CubicBezier>, part_of: &Curve) {
        move_ends(&mut cubics, self.nodes[from].0, self.nodes[to].0);
        self.links.push(Link { from, to, curve: Curve { cubics, ..part_of.clone() } });
    }

    /// Removes straight links between nodes that another straight link connects. The links of a
    /// line follow each other.
    fn remove_repeated(&mut self) {
        let (mut seen, mut are_new) = (BTreeSet::new(), Vec::with_capacity(self.links.len()));
        for links in self.links.chunk_by(|a, b| a.curve.line == b.curve.line) {
            let first = are_new.len();
            for link in links {
                let pair = (link.from.min(link.to), link.from.max(link.to));
                are_new.push(!is_straight(&link.curve.cubics) || seen.insert(pair));
            }
            if are_new[first..].contains(&false) {
                let is_whole = !are_new[first..].contains(&true);
                self.repeated.push(Repeated { at: links[0].curve.at, is_whole });
            }
        }
        let mut are_new = are_new.into_iter();
        self.links.retain(|_| are_new.next().unwrap_or(true));
    }
}

/// Returns whether cubics are a straight line.
pub fn is_straight(cubics: &[CubicBezier]) -> bool {
    let [CubicBezier { control_points: [start, after, before, end] }] = cubics else {
        return false;
    };
    let straight = CubicBezier::straight(*start, *end).control_points;
    straight[1].distance(*after) < 1e-9 && straight[2].distance(*before) < 1e-9
}

/// Moves the ends of a curve, and the handles there with them.
fn move_ends(cubics: &mut [CubicBezier], start: DVec2, end: DVec2) {
    if let [only] = cubics
        && is_straight(std::slice::from_ref(only))
    {
        *only = CubicBezier::straight(start, end);
        return;
    }
    if let Some(first) = cubics.first_mut() {
        let shift = start - first.control_points[0];
        first.control_points[0] = start;
        first.control_points[1] += shift;
    }
    if let Some(last) = cubics.last_mut() {
        let shift = end - last.control_points[3];
        last.control_points[3] = end;
        last.control_points[2] += shift;
    }
}

/// Returns about the length of a curve in metres.
fn length(cubics: &[CubicBezier]) -> f64 {
    cubics.iter().map(|cubic| cubic.polyline_length(4)).sum()
}

/// Divides a curve in two.
fn bisected(mut cubics: Vec<CubicBezier>) -> [Vec<CubicBezier>; 2] {
    if let [only] = cubics.as_slice() {
        let (before, after) = halves(only, 0.5);
        return [vec![before], vec![after]];
    }
    let after = cubics.split_off(cubics.len() / 2);
    [cubics, after]
}

/// Splits a cubic by de Casteljau's scheme.
fn halves(cubic: &CubicBezier, parameter: f64) -> (CubicBezier, CubicBezier) {
    let [a, b, c, d] = cubic.control_points;
    let (ab, bc, cd) = (a.lerp(b, parameter), b.lerp(c, parameter), c.lerp(d, parameter));
    let (abc, bcd) = (ab.lerp(bc, parameter), bc.lerp(cd, parameter));
    let middle = abc.lerp(bcd, parameter);
    (
        CubicBezier { control_points: [a, ab, abc, middle] },
        CubicBezier { control_points: [middle, bcd, cd, d] },
    )
}

/// The point of a curve that is nearest to a node.
#[derive(Clone, Copy, Debug)]
struct Nearest {
    cubic: usize,
    parameter: f64,
    distance: f64,
}

/// Nodes by square cells, with about one node in each.
struct NodeIndex {
    size: f64,
    nodes: BTreeMap<[i64; 2], Vec<usize>>,
    comparisons: u64,
}

impl NodeIndex {
    fn new(nodes: &[(DVec2, u32)]) -> Self {
        let extents =
            [0, 1].map(|axis| extent(nodes.iter().map(|(point, _)| point[axis]).collect()));
        let size = (extents[0].max(extents[1]) / (nodes.len() as f64).sqrt()).max(4.0 * TOLERANCE);
        let mut index = Self { size, nodes: BTreeMap::new(), comparisons: 0 };
        for (number, (point, _)) in nodes.iter().enumerate() {
            index.nodes.entry(cell(*point, size)).or_default().push(number);
        }
        index
    }

    /// Returns the nodes near a link besides its ends, ascending, with the nearest point of the
    /// link.
    fn near(&mut self, link: &Link, nodes: &[(DVec2, u32)]) -> Vec<(usize, Nearest)> {
        let reach = NEAR.min(self.size / 2.0);
        let mut found: BTreeMap<usize, Nearest> = BTreeMap::new();
        for (cubic, content) in link.curve.cubics.iter().enumerate() {
            let (count, bend) = chords(content, self.size, nodes.len());
            for chord in 0..count {
                let [from, to] =
                    [chord, chord + 1].map(|index| f64::from(index) / f64::from(count));
                let (start, end) = (content.position(from), content.position(to));
                let margin = reach + bend;
                let candidates =
                    self.candidates(start.min(end) - margin, start.max(end) + margin, nodes.len());
                // Chords without candidates also take time.
                self.comparisons += 1 + candidates.len() as u64;
                if self.comparisons > MAX_COMPARISONS {
                    return found.into_iter().collect();
                }
                for node in
                    candidates.into_iter().filter(|&node| node != link.from && node != link.to)
                {
                    let point = nodes[node].0;
                    if distance_to_chord(point, start, end).1 > margin {
                        continue;
                    }
                    let (parameter, distance) = nearest(content, point, from, to);
                    let known = found.get(&node).is_none_or(|known| distance < known.distance);
                    if known && distance <= reach {
                        found.insert(node, Nearest { cubic, parameter, distance });
                    }
                }
            }
        }
        found.into_iter().collect()
    }

    /// Returns the nodes in the cells between two corners. If there are more cells than nodes, it
    /// returns all `count` nodes, as along a line that is much longer than the rest of the drawing.
    fn candidates(&self, min: DVec2, max: DVec2, count: usize) -> Vec<usize> {
        let sides = (max / self.size).floor() - (min / self.size).floor() + 1.0;
        if sides.x * sides.y > count as f64 {
            return (0..count).collect();
        }
        cells(min, max, self.size)
            .filter_map(|cell| self.nodes.get(&cell))
            .flatten()
            .copied()
            .collect()
    }
}

/// Returns the extent of coordinates without outliers, which would make the cells large.
fn extent(mut coordinates: Vec<f64>) -> f64 {
    coordinates.sort_unstable_by(f64::total_cmp);
    let outermost = coordinates.len() / 50;
    let last = coordinates.len().saturating_sub(1 + outermost);
    coordinates.get(last).zip(coordinates.get(outermost)).map_or(0.0, |(last, first)| last - first)
}

/// Returns the number of equal intervals of a cubic whose chords are at most about as long as
/// `length`, and the largest distance of the curve from its chords. The number of chords is limited
/// by that of nodes, because each chord is compared with some nodes.
fn chords(cubic: &CubicBezier, length: f64, nodes: usize) -> (u32, f64) {
    let is_straight = is_straight(std::slice::from_ref(cubic));
    let least = if is_straight { 1.0 } else { f64::from(INTERVALS) };
    let [a, b, c, d] = cubic.control_points;
    let polygon = a.distance(b) + b.distance(c) + c.distance(d);
    // A cubic is at most three times as fast as a straight segment of the length of its control
    // polygon.
    let count = (3.0 * polygon / length).ceil().clamp(least, (nodes as f64).clamp(64.0, 1e4));
    // |p''| is at most six times that length, and the distance |p''| / 8 for the whole curve.
    (count as u32, if is_straight { 0.0 } else { 0.75 * polygon / (count * count) })
}

/// Returns the fraction of a chord at which it is nearest to a point, and the distance there.
fn distance_to_chord(point: DVec2, start: DVec2, end: DVec2) -> (f64, f64) {
    let chord = end - start;
    let fraction = ((point - start).dot(chord) / chord.length_squared().max(f64::MIN_POSITIVE))
        .clamp(0.0, 1.0);
    (fraction, point.distance(start + chord * fraction))
}

/// Returns the parameter in an interval where a cubic is nearest to a point, and the distance
/// there.
fn nearest(cubic: &CubicBezier, point: DVec2, from: f64, to: f64) -> (f64, f64) {
    let (fraction, _) = distance_to_chord(point, cubic.position(from), cubic.position(to));
    let mut parameter = from + (to - from) * fraction;
    for _ in 0..4 {
        parameter = cubic.nearer(parameter, point).clamp(from, to);
    }
    (parameter, cubic.position(parameter).distance(point))
}
