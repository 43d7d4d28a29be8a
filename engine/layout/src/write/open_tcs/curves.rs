//! The shapes that a plant model can draw, and the scale of its drawing.

use glam::DVec2;
use regatta_base::bezier::CubicBezier;

use crate::model::path::Path;
use crate::model::route_graph::RouteGraph;

/// The scales in millimetres per unit, the usual one first. Control points are whole units.
const SCALES: [u32; 6] = [50, 25, 10, 5, 2, 1];

/// The largest distance in metres of control points that counts as none.
const SAME_POINT: f64 = 1e-6;

/// The distance in metres between a curve of several cubics and the line with corners that is drawn
/// instead.
const TOLERANCE: f64 = 0.005;

/// The largest number of straight segments for one cubic.
const MAX_SEGMENTS: f64 = 64.0;

/// The shape of a path.
pub(super) struct Drawn {
    pub kind: &'static str,
    /// Inner control points in metres on the map of the file.
    pub points: Vec<DVec2>,
    /// Whether this isn't exactly the shape of the edge.
    pub is_approximate: bool,
}

impl Drawn {
    pub fn new(path: &Path) -> Self {
        let exact = |kind, points| Self { kind, points, is_approximate: false };
        let cubics: Vec<_> = path.cubics().map(|cubic| cubic.control_points).collect();
        if path.cubics().all(is_straight) {
            let kind = if cubics.len() == 1 { "DIRECT" } else { "POLYPATH" };
            return exact(kind, cubics.iter().skip(1).map(|points| points[0]).collect());
        }
        match cubics.as_slice() {
            [[_, a, b, _]] => exact("BEZIER", vec![*a, *b]),
            [[_, a, b, middle], [_, c, d, _]] => exact("BEZIER_3", vec![*a, *b, *middle, *c, *d]),
            _ => {
                let mut points: Vec<_> = path.cubics().flat_map(corners).collect();
                // The end is the destination point.
                points.pop();
                Self { kind: "POLYPATH", points, is_approximate: true }
            }
        }
    }
}

/// Returns whether a cubic is a straight segment with evenly spaced control points.
pub(super) fn is_straight(cubic: &CubicBezier) -> bool {
    let [p0, p1, p2, p3] = cubic.control_points;
    let straight = CubicBezier::straight(p0, p3).control_points;
    p1.distance(straight[1]) < SAME_POINT && p2.distance(straight[2]) < SAME_POINT
}

/// Returns the ends of straight segments along a cubic.
fn corners(cubic: &CubicBezier) -> impl Iterator<Item = DVec2> + use<> {
    let bend = cubic.second_derivative(0.0).length().max(cubic.second_derivative(1.0).length());
    // The distance of a chord of a parameter interval h is at most h² |p''| / 8.
    let segments = if is_straight(cubic) {
        1.0
    } else {
        (bend / 8.0 / TOLERANCE).sqrt().ceil().clamp(1.0, MAX_SEGMENTS)
    };
    let cubic = *cubic;
    (1..=segments as u32).map(move |index| cubic.position(f64::from(index) / segments))
}

/// The scale of the drawing in millimetres per unit.
#[derive(Clone, Copy)]
pub(super) struct Scale(u32);

impl Scale {
    /// Returns the coarsest scale that moves no control point by more than 0.5 mm, or else the
    /// finest.
    pub fn of(graph: &RouteGraph) -> Self {
        let points: Vec<DVec2> = graph
            .edges()
            .iter()
            .filter(|edge| !super::is_straight(&edge.path))
            .flat_map(|edge| Drawn::new(&edge.path).points)
            .map(|point| (point + graph.origin()) * 1000.0)
            .collect();
        let fits = |scale: &u32| {
            let scale = f64::from(*scale);
            points
                .iter()
                .all(|point| (*point - (*point / scale).round() * scale).abs().max_element() <= 0.5)
        };
        Self(SCALES.into_iter().find(fits).unwrap_or(1))
    }

    pub fn millimetres(self) -> f64 {
        f64::from(self.0)
    }

    /// Returns a point in whole units; y points down.
    pub fn units(self, metres: DVec2) -> [String; 2] {
        let units = (metres * 1000.0 / f64::from(self.0)).round();
        [units.x, -units.y].map(|number| (number as i64).to_string())
    }
}
