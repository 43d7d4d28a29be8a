//! The drawing of a plant model. Only the drawing has the shapes of paths.

use std::collections::BTreeMap;

use glam::DVec2;
use regatta_base::bezier::CubicBezier;

use super::element::Element;
use crate::model::finding::Report;
use crate::model::value::shorten;
use crate::read::file::Ignored;
use crate::read::layout::Shape;

/// The millimetres of a unit, for drawings without a scale.
const DEFAULT_SCALE: f64 = 50.0;

/// The places of points and the shapes of paths in the drawing.
#[derive(Debug, Default)]
pub(super) struct Drawing {
    /// Millimetres of a unit.
    scale: DVec2,
    /// The drawn places of points in metres. Version 7 draws them at their positions.
    places: BTreeMap<String, DVec2>,
    /// The connections by path, in the versions 0.0.2 and 0.0.3.
    connections: BTreeMap<String, Connection>,
    /// The byte offset of the first path whose points are drawn elsewhere, and the number of such
    /// paths.
    transformed: Option<(u32, usize)>,
}

/// The way a path is drawn.
#[derive(Clone, Debug, Default)]
struct Connection {
    kind: String,
    /// Inner control points in metres.
    points: Vec<DVec2>,
}

impl Drawing {
    /// Takes the visual layout out of a model.
    pub fn read(model: &mut Element<'_>, ignored: &mut Ignored) -> Self {
        let mut drawing = Self { scale: DVec2::splat(DEFAULT_SCALE), ..Self::default() };
        for mut layout in model.take_children("visualLayout") {
            let [x, y] = ["scaleX", "scaleY"]
                .map(|name| layout.take_number(&[name]).filter(|scale| *scale > 0.0));
            drawing.scale = DVec2::new(x.unwrap_or(DEFAULT_SCALE), y.unwrap_or(DEFAULT_SCALE));
            for element in layout.take_children("modelLayoutElement") {
                drawing.model_element(element);
            }
            layout.take(&["name"]);
            layout.ignore_rest("the visual layout", ignored);
        }
        drawing
    }

    /// Reads the drawing of a point or a path, which is a separate element in the versions 0.0.2
    /// and 0.0.3.
    fn model_element(&mut self, mut element: Element<'_>) {
        let name = element.take_text("visualizedObjectName");
        let properties: BTreeMap<_, _> = element
            .take_children("property")
            .into_iter()
            .map(|mut property| (property.take_text("name"), property.take_text("value")))
            .collect();
        let [x, y, points, kind] = ["POSITION_X", "POSITION_Y", "CONTROL_POINTS", "CONN_TYPE"]
            .map(|key| properties.get(key).map_or("", |value| value.trim()));
        if let (Ok(x), Ok(y)) = (x.parse::<f64>(), y.parse::<f64>()) {
            self.places.insert(name.clone(), DVec2::new(x, y) / 1000.0);
        }
        let points = points.split(';').filter_map(|pair| {
            let (x, y) = pair.split_once(',')?;
            Some(self.metres(DVec2::new(x.trim().parse().ok()?, y.trim().parse().ok()?)))
        });
        let connection = Connection { kind: kind.to_owned(), points: points.collect() };
        if !connection.kind.is_empty() {
            self.connections.insert(name, connection);
        }
    }

    /// Reads the drawn position of a point.
    pub fn place(&mut self, point: &str, mut layout: Element<'_>, ignored: &mut Ignored) {
        if let Some(position) = layout.take_position() {
            self.places.insert(point.to_owned(), position);
        }
        layout.ignore_rest("the layout of a point", ignored);
    }

    /// Returns the shape of a path between two points with names and positions.
    pub fn shape(
        &mut self,
        path: &str,
        element: &mut Element<'_>,
        ends: [(&str, Option<DVec2>); 2],
        ignored: &mut Ignored,
    ) -> Shape {
        let at = element.at;
        let connection = self.connection(path, element, ignored);
        let [(_, Some(from)), (_, Some(to))] = ends else { return Shape::Straight };
        let cubics = match connection.kind.to_ascii_uppercase().as_str() {
            "POLYPATH" => corners,
            "BEZIER" | "BEZIER_3" => curve,
            "DIRECT" | "" => return Shape::Straight,
            kind @ ("ELBOW" | "SLANTED") => {
                ignored.add(
                    at,
                    format!(
                        "corners of {kind} paths, which the file doesn't place (they are straight \
                         here)"
                    ),
                );
                return Shape::Straight;
            }
            other => {
                ignored.add(
                    at,
                    format!("connection type `{}` of a path (it is straight here)", shorten(other)),
                );
                return Shape::Straight;
            }
        };
        let points = connection.points;
        let used = if connection.kind.eq_ignore_ascii_case("POLYPATH") {
            points.len()
        } else {
            used_points(points.len())
        };
        if used < points.len() {
            ignored.add(at, format!("control points after the first {used} of a BEZIER path"));
        }
        let Some(points) = self.on_map(at, ends, [from, to], points) else {
            ignored.add(
                at,
                "shape of a path between points that are drawn at the same place (it is straight \
                 here)",
            );
            return Shape::Straight;
        };
        let points = points.get(..used).unwrap_or_default();
        if points.is_empty() { Shape::Straight } else { Shape::Cubics(cubics(from, points, to)) }
    }

    fn connection(
        &mut self,
        path: &str,
        element: &mut Element<'_>,
        ignored: &mut Ignored,
    ) -> Connection {
        let Some(mut layout) = element.take_children("pathLayout").into_iter().next() else {
            return self.connections.remove(path).unwrap_or_default();
        };
        let points = layout.take_children("controlPoint").into_iter().filter_map(|mut point| {
            let metres = point.take_number(&["x"]).zip(point.take_number(&["y"]));
            if metres.is_none() {
                ignored.add(point.at, "control point without two numbers");
            }
            metres.map(|(x, y)| self.metres(DVec2::new(x, y)))
        });
        let points = points.collect();
        let kind = layout.take_text("connectionType");
        layout.ignore_rest("the layout of a path", ignored);
        Connection { kind, points }
    }

    /// Returns the control points of a path on the map of the model. If its ends are drawn
    /// elsewhere, the path is turned, scaled and moved with them. Returns `None` if both ends are
    /// drawn at the same place.
    fn on_map(
        &mut self,
        at: u32,
        ends: [(&str, Option<DVec2>); 2],
        [from, to]: [DVec2; 2],
        points: Vec<DVec2>,
    ) -> Option<Vec<DVec2>> {
        let [drawn_from, drawn_to] = [(ends[0].0, from), (ends[1].0, to)]
            .map(|(name, position)| self.places.get(name).copied().unwrap_or(position));
        let tolerance = self.scale / 1000.0 + 1e-9;
        let agrees =
            |drawn: DVec2, position: DVec2| (drawn - position).abs().cmple(tolerance).all();
        if agrees(drawn_from, from) && agrees(drawn_to, to) {
            return Some(points);
        }
        let (drawn, model) = (drawn_to - drawn_from, to - from);
        if drawn.length() < 1e-6 {
            return None;
        }
        self.transformed.get_or_insert((at, 0)).1 += 1;
        // The quotient of the two as complex numbers.
        let turn = DVec2::new(drawn.dot(model), drawn.perp_dot(model)) / drawn.length_squared();
        Some(points.into_iter().map(|point| from + turn.rotate(point - drawn_from)).collect())
    }

    /// Returns a point of the drawing, whose y points down, in metres.
    fn metres(&self, point: DVec2) -> DVec2 {
        DVec2::new(point.x, -point.y) * self.scale / 1000.0
    }

    /// Warns of paths whose points are drawn elsewhere.
    pub fn report(&self, report: &mut Report<'_>) {
        let Some((at, count)) = self.transformed else { return };
        let message = format!(
            "{count} curved paths are drawn between other places than those of their points: \
             their shapes are moved, turned and scaled with the points"
        );
        report.file_warning(at, message);
    }
}

/// Returns the straight segments between points.
fn corners(from: DVec2, points: &[DVec2], to: DVec2) -> Vec<CubicBezier> {
    let starts = std::iter::once(&from).chain(points);
    let ends = points.iter().chain(std::iter::once(&to));
    starts.zip(ends).map(|(&start, &end)| CubicBezier::straight(start, end)).collect()
}

/// Returns the number of control points that openTCS uses of those given.
fn used_points(given: usize) -> usize {
    match given {
        0 | 1 => given,
        2..=4 => 2,
        _ => 5,
    }
}

/// Returns one cubic for 1 or 2 inner points, or two cubics for 5.
fn curve(from: DVec2, points: &[DVec2], to: DVec2) -> Vec<CubicBezier> {
    match *points {
        [a, b, middle, c, d] => {
            vec![
                CubicBezier { control_points: [from, a, b, middle] },
                CubicBezier { control_points: [middle, c, d, to] },
            ]
        }
        [a, b, ..] => vec![CubicBezier { control_points: [from, a, b, to] }],
        // The same curve as openTCS draws.
        [a] => vec![CubicBezier { control_points: [from, a, a, to] }],
        [] => vec![CubicBezier::straight(from, to)],
    }
}
