//! The paths of a plant model: their ends, speeds, lengths and shapes, and the scale of its drawing.

use std::f64::consts::PI;
use std::io;

use glam::DVec2;
use regatta_base::bezier::CubicBezier;
use regatta_base::graph::{Ends, NodeIndex};

use super::{ModelWriter, Xml, element, empty, own_properties, write_properties};
use crate::model::path::Path;
use crate::model::route_graph::{Edge, RouteGraph};
use crate::model::tags::Orientation;
use crate::read::open_tcs::{LENGTH, millimetres_of};
use crate::write::segments;

/// The largest difference in radians at which a heading offset counts as π: files have four
/// decimals.
const SAME_ANGLE: f64 = 1e-4;

/// The scales in millimetres per unit, the usual one first. Control points are whole units.
const SCALES: [u32; 6] = [50, 25, 10, 5, 2, 1];

/// The largest distance in metres of control points from those of a straight segment.
const SAME_POINT: f64 = 1e-6;

/// The largest distance in metres between a curve of several cubics and its polyline.
const TOLERANCE: f64 = 0.005;

impl ModelWriter<'_> {
    pub(super) fn write_paths(&mut self, xml: &mut Xml) -> io::Result<()> {
        let graph = self.graph;
        for (index, edge) in graph.edges().iter().enumerate() {
            let ends = path_ends(edge);
            let is_turned = is_tail_first(edge.orientation);
            let is_tangential = edge.orientation == Orientation::Tangential;
            self.losses.add_if(
                !is_turned && !is_tangential,
                "edges have a heading other than along the edge",
            );
            self.losses.add_if(
                edge.rotation != Ends::default(),
                "edges prescribe how robots turn at their ends: this format doesn't",
            );
            self.count_tags(edge.tags.as_deref());
            let (forward, reverse) = speeds(edge);
            for speed in [forward, reverse] {
                let is_rounded = (speed * 1000.0 - whole(speed)).abs() > 1e-6;
                self.losses.add_if(is_rounded, "speeds are rounded to whole mm/s");
            }
            let path = if is_turned { edge.path.reversed() } else { edge.path.clone() };
            let drawn = Drawn::new(&path.map(|point| point + graph.origin()));
            self.losses.add_if(
                drawn.is_approximate,
                "curves have several cubics: drawn as lines with corners",
            );
            let (length, is_kept) = length(edge, &path);
            self.losses.add_if(
                !is_kept,
                "paths have a property `opentcs:length` that isn't in whole millimetres: not \
                 written",
            );
            let attributes = [
                ("name", self.paths[index].as_str()),
                ("sourcePoint", &self.points[ends.origin.0 as usize]),
                ("destinationPoint", &self.points[ends.destination.0 as usize]),
                ("length", &length),
                ("maxVelocity", &whole(forward).to_string()),
                ("maxReverseVelocity", &whole(reverse).to_string()),
                ("locked", "false"),
            ];
            element(xml, "path", &attributes, |xml| {
                write_properties(xml, &own_properties(edge.id, edge.tags.as_deref()))?;
                self.write_path_layout(xml, &drawn)
            })?;
        }
        Ok(())
    }

    fn write_path_layout(&self, xml: &mut Xml, drawn: &Drawn) -> io::Result<()> {
        let attributes = [("connectionType", drawn.kind), ("layerId", "0")];
        if drawn.points.is_empty() {
            return empty(xml, "pathLayout", &attributes);
        }
        element(xml, "pathLayout", &attributes, |xml| {
            for &point in &drawn.points {
                let [x, y] = self.scale.units(point);
                empty(xml, "controlPoint", &[("x", &x), ("y", &y)])?;
            }
            Ok(())
        })
    }
}

/// Returns whether robots drive along an edge backwards.
fn is_tail_first(orientation: Orientation) -> bool {
    matches!(orientation, Orientation::Offset(angle) if (angle.abs() - PI).abs() < SAME_ANGLE)
}

/// Returns the ends of the path of an edge. Robots face from source to destination.
pub(super) fn path_ends(edge: &Edge) -> Ends<NodeIndex> {
    let (from, to) = (edge.origin, edge.destination);
    if is_tail_first(edge.orientation) {
        Ends { origin: to, destination: from }
    } else {
        Ends { origin: from, destination: to }
    }
}

/// Returns the speeds from source to destination and back, 0 if not allowed.
fn speeds(edge: &Edge) -> (f64, f64) {
    let speeds = (edge.speed, edge.reverse_speed.unwrap_or_default());
    if is_tail_first(edge.orientation) { (speeds.1, speeds.0) } else { speeds }
}

/// Returns the length of a path in whole millimetres, and whether it is exact. It is the length in
/// its file, if that is valid in openTCS, or else the length of its curve.
fn length(edge: &Edge, path: &Path) -> (String, bool) {
    let given = edge.tags.as_ref().and_then(|tags| tags.properties.get(LENGTH));
    match given.map(|given| given.trim().parse::<u32>()) {
        Some(Ok(given)) if given > 0 => (given.to_string(), true),
        given => (millimetres_of(path.length()).to_string(), given.is_none()),
    }
}

/// Returns whole millimetres per second. It is at least 1 if the speed isn't 0, because 0 forbids
/// the direction.
fn whole(speed: f64) -> f64 {
    let whole = (speed * 1000.0).round();
    if speed > 0.0 { whole.max(1.0) } else { 0.0 }
}

/// The shape of a path.
struct Drawn {
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
