//! The shapes of paths in a plant model, and the scale of its drawing.

use glam::DVec2;
use regatta_base::bezier::CubicBezier;

use crate::model::path::Path;
use crate::model::route_graph::RouteGraph;
use crate::write::segments;

/// The scales in millimetres per unit, the usual one first. Control points are whole units.
const SCALES: [u32; 6] = [50, 25, 10, 5, 2, 1];

/// The largest distance in metres of control points from those of a straight segment.
const SAME_POINT: f64 = 1e-6;

/// The largest distance in metres between a curve of several cubics and its polyline.
const TOLERANCE: f64 = 0.005;

/// The shape of a path.
pub(super) struct Drawn {
    pub kind: &'static str,
    /// Inner control points in metres on the map of the file.
    pub points: Vec<DVec2>,
    /// Whether the shape differs from that of the edge.
    pub is_approximate: bool,
}

impl Drawn {
    pub fn new(path: &Path) -> Self {
        let cubics: Vec<_> = path.cubics().map(|cubic| cubic.control_points).collect();
        let (kind, points, is_approximate) = match cubics.as_slice() {
            [_] if is_direct(path) => ("DIRECT", Vec::new(), false),
            all if path.cubics().all(is_straight) => {
                ("POLYPATH", all.iter().skip(1).map(|points| points[0]).collect(), false)
            }
            [[_, a, b, _]] => ("BEZIER", vec![*a, *b], false),
            [[_, a, b, middle], [_, c, d, _]] => ("BEZIER_3", vec![*a, *b, *middle, *c, *d], false),
            _ => {
                let mut points: Vec<_> = path.cubics().flat_map(corners).collect();
                // The destination point is the end.
                points.pop();
                ("POLYPATH", points, true)
            }
        };
        Self { kind, points, is_approximate }
    }
}

/// Whether a path is the straight segment between its ends.
fn is_direct(path: &Path) -> bool {
    path.single().is_some_and(is_straight)
}

fn is_straight(cubic: &CubicBezier) -> bool {
    crate::write::is_straight(cubic, SAME_POINT)
}

/// Returns the ends of straight segments along a cubic.
fn corners(cubic: &CubicBezier) -> impl Iterator<Item = DVec2> + use<> {
    let segments = if is_straight(cubic) { 1 } else { segments(cubic, TOLERANCE) };
    let cubic = *cubic;
    (1..=segments).map(move |index| cubic.position(f64::from(index) / f64::from(segments)))
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
            .filter(|edge| !is_direct(&edge.path))
            .flat_map(|edge| Drawn::new(&edge.path).points)
            .map(|point| (point + graph.origin()) * 1000.0)
            .collect();
        for scale in SCALES {
            let unit = f64::from(scale);
            let mut shifts = points.iter().map(|point| *point - (*point / unit).round() * unit);
            if shifts.all(|shift| shift.abs().max_element() <= 0.5) {
                return Self(scale);
            }
        }
        Self(1)
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
