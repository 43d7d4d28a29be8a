//! The curves of edges: points on them, and places along them.

use glam::Vec2;
use regatta_plugin::World;
use regatta_plugin::world::{CurveRecord, EdgeRecord};

/// The number of chords that approximate a curve to measure its length.
const CHORDS: u32 = 32;

/// Returns the point of a curve at a parameter from 0 to 1, by de Casteljau's algorithm.
pub fn curve_point(curve: &CurveRecord, parameter: f32) -> Vec2 {
    let [a, b, c, d] = curve.control_points.map(Vec2::from);
    let points = [a.lerp(b, parameter), b.lerp(c, parameter), c.lerp(d, parameter)];
    points[0].lerp(points[1], parameter).lerp(points[1].lerp(points[2], parameter), parameter)
}

/// Returns the length of a curve in metres, a little less than exact.
pub fn curve_length(curve: &CurveRecord) -> f32 {
    chords(curve).map(|chord| chord.length).sum()
}

/// Returns the place on an edge's curves that is `s` metres from its origin, given the edge's
/// length in metres: the number of the curve and the curve's parameter.
pub fn place_at(curves: &[CurveRecord], length: f32, s: f32) -> (usize, f32) {
    // The chords together are a little shorter than the curves, so `s` is scaled to their length.
    let total: f32 = curves.iter().flat_map(chords).map(|chord| chord.length).sum();
    let mut rest = s / length.max(1e-6) * total;
    for (number, curve) in curves.iter().enumerate() {
        for chord in chords(curve) {
            if rest < chord.length {
                let [from, to] = chord.ends;
                return (number, from + (to - from) * (rest / chord.length).max(0.0));
            }
            rest -= chord.length;
        }
    }
    (curves.len().saturating_sub(1), 1.0)
}

/// Returns the middle of an edge's curves: the number of the curve and its parameter. Of a single
/// curve, that is the parameter 0.5, whatever the lengths of both parts.
pub fn middle(curves: &[CurveRecord]) -> (usize, f32) {
    if let [_] = curves { (0, 0.5) } else { place_at(curves, 1.0, 0.5) }
}

/// Returns the point in the middle of an edge; `None` if it has no curves.
pub fn midpoint(world: &World<'_>, edge: &EdgeRecord) -> Option<Vec2> {
    let curves = world.curves(edge);
    let (number, parameter) = middle(curves);
    curves.get(number).map(|curve| curve_point(curve, parameter))
}

/// A chord of a curve: the parameters of its ends, and its length in metres.
struct Chord {
    ends: [f32; 2],
    length: f32,
}

fn chords(curve: &CurveRecord) -> impl Iterator<Item = Chord> + '_ {
    (0..CHORDS).map(|chord| {
        let ends = [chord, chord + 1].map(|number| number as f32 / CHORDS as f32);
        let [from, to] = ends.map(|parameter| curve_point(curve, parameter));
        Chord { ends, length: from.distance(to) }
    })
}

#[cfg(test)]
mod tests {
    use regatta_plugin::world::WorldData;

    use super::*;

    #[test]
    fn places_are_found_on_all_curves() {
        let line = CurveRecord::straight;
        let curves = [line([0.0, 0.0], [2.0, 0.0]), line([2.0, 0.0], [2.0, 6.0])];
        for (s, number, parameter) in
            [(-1.0, 0, 0.0), (1.0, 0, 0.5), (2.0, 1, 0.0), (5.0, 1, 0.5), (9.0, 1, 1.0)]
        {
            let (found, at) = place_at(&curves, 8.0, s);
            assert!(
                found == number && (at - parameter).abs() < 1e-4,
                "{s} m: curve {found} at {at}"
            );
        }
        assert_eq!(place_at(&[], 8.0, 1.0), (0, 1.0));
        assert!((curve_length(&curves[1]) - 6.0).abs() < 1e-4);
    }

    #[test]
    fn the_middle_of_an_edge_is_half_way_along_its_curves() {
        let line = CurveRecord::straight;
        let mut world = WorldData::default();
        world.add_edge(
            EdgeRecord::default(),
            [line([0.0, 0.0], [2.0, 0.0]), line([2.0, 0.0], [2.0, 6.0])],
        );
        world.add_edge(EdgeRecord::default(), []);
        let world = world.view(1, 1);
        let found = midpoint(&world, &world.edges()[0]).expect("curves");
        assert!(found.distance(Vec2::new(2.0, 2.0)) < 1e-3, "{found}");
        assert_eq!(midpoint(&world, &world.edges()[1]), None);
    }
}
