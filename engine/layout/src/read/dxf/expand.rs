//! The entities of a drawing as curves in metres, blocks expanded.

use std::collections::BTreeMap;

use dxf::entities::{Arc, Ellipse, Entity, EntityType, Insert, LwPolyline, Polyline, Spline};
use dxf::{Block, Point, Vector};
use glam::{DAffine2, DMat2, DVec2};
use regatta_base::bezier::CubicBezier;

use super::curve::{EllipticArc, spline_to_cubics, turn};
use crate::read::file::Ignored;

/// The largest depth of blocks in blocks.
const MAX_DEPTH: usize = 16;

/// The largest number of entities after the expansion of blocks.
const MAX_STEPS: usize = 1_000_000;

/// The largest number of cubics of all curves.
const MAX_CUBICS: usize = 1_000_000;

/// The largest coordinate in metres. Coordinates of a graph are smaller, but its origin may be
/// moved.
const MAX_COORDINATE: f64 = 1e7;

/// A curve of a drawing in metres: cubics end to end, at least one.
#[derive(Clone, Debug)]
pub struct Curve {
    /// The byte offset of the entity, or of the outermost block that it is in.
    pub at: u32,
    /// The number of the line as it was drawn: a polyline has one number, with several curves.
    pub line: usize,
    pub layer: String,
    pub cubics: Vec<CubicBezier>,
}

/// Expands entities.
pub struct Expander<'a> {
    blocks: BTreeMap<&'a str, &'a Block>,
    ignored: &'a mut Ignored,
    pub curves: Vec<Curve>,
    cubics: usize,
    steps: usize,
}

/// The place of an entity.
#[derive(Clone, Copy)]
struct Place<'a> {
    at: u32,
    /// The layer of the block reference, which entities on layer 0 are on.
    layer: Option<&'a str>,
    /// From the drawing's units or the block's to metres.
    to_metres: DAffine2,
    depth: usize,
}

impl<'a> Expander<'a> {
    pub fn new(blocks: impl Iterator<Item = &'a Block>, ignored: &'a mut Ignored) -> Self {
        let blocks = blocks.map(|block| (block.name.as_str(), block)).collect();
        Self { blocks, ignored, curves: Vec::new(), cubics: 0, steps: 0 }
    }

    /// Returns whether there were more entities than can be expanded.
    pub fn is_full(&self) -> bool {
        self.steps > MAX_STEPS || self.cubics > MAX_CUBICS
    }

    /// Adds the curves of an entity outside blocks, at a byte offset, whose unit is `unit` metres.
    pub fn add(&mut self, entity: &'a Entity, at: u32, unit: f64) {
        let to_metres = DAffine2::from_scale(DVec2::splat(unit));
        self.entity(entity, Place { at, layer: None, to_metres, depth: 0 });
    }

    fn entity(&mut self, entity: &'a Entity, place: Place<'a>) {
        self.steps += 1;
        // Entities in blocks may be read many times.
        if place.depth > 0 {
            self.steps += size(&entity.specific);
        }
        if self.is_full() {
            return;
        }
        if entity.common.is_in_paper_space || !entity.common.is_visible {
            self.ignored.add(place.at, "entity in paper space or invisible");
            return;
        }
        let own = layer(entity);
        let layer = place.layer.filter(|_| own == "0").unwrap_or(own);
        let scale = scale(&place.to_metres);
        let curves = match &entity.specific {
            EntityType::Insert(insert) => {
                return self.insert(insert, Place { layer: Some(layer), ..place });
            }
            EntityType::Line(line) => {
                vec![vec![CubicBezier::straight(point(&line.p1), point(&line.p2))]]
            }
            EntityType::Arc(arc) => {
                self.plane(&arc.normal, place, || vec![circular_arc(arc).cubics(scale)])
            }
            EntityType::Circle(circle) => self.plane(&circle.normal, place, || {
                closed(
                    EllipticArc::circular(
                        point(&circle.center),
                        circle.radius,
                        0.0,
                        turn(0.0, 0.0),
                    ),
                    scale,
                )
            }),
            EntityType::Ellipse(ellipse) => self.ellipse(ellipse, place, scale),
            EntityType::LwPolyline(line) => {
                self.plane(&line.extrusion_direction, place, || lightweight_polyline(line, scale))
            }
            EntityType::Polyline(line) => self.polyline(line, place, scale),
            EntityType::Spline(spline) => self.spline(spline, place),
            _ => Vec::new(),
        };
        for cubics in curves {
            self.push(cubics, layer, place);
        }
    }

    /// Adds a curve in the units of its place.
    fn push(&mut self, mut cubics: Vec<CubicBezier>, layer: &str, place: Place<'_>) {
        self.cubics += cubics.len();
        for cubic in &mut cubics {
            cubic.control_points =
                cubic.control_points.map(|point| place.to_metres.transform_point2(point));
        }
        let mut points = cubics.iter().flat_map(|cubic| cubic.control_points);
        if !points.all(|point| point.is_finite() && point.abs().max_element() <= MAX_COORDINATE) {
            self.ignored.add(place.at, "entity further than 10,000 km from (0, 0)");
        } else if !cubics.is_empty() {
            // Each entity begins with a step of its own.
            let (at, line, layer) = (place.at, self.steps, layer.to_owned());
            self.curves.push(Curve { at, line, layer, cubics });
        }
    }

    /// Returns the curves of an entity in the plane of its normal, seen from above. With a normal
    /// downwards, the plane is seen from below.
    fn plane(
        &mut self,
        normal: &Vector,
        place: Place<'_>,
        curves: impl FnOnce() -> Vec<Vec<CubicBezier>>,
    ) -> Vec<Vec<CubicBezier>> {
        let Some(mirror) = mirror(normal) else {
            self.ignored.add(place.at, "entity in a plane that isn't horizontal");
            return Vec::new();
        };
        let mut curves = curves();
        for cubic in curves.iter_mut().flatten() {
            cubic.control_points = cubic.control_points.map(|point| mirror * point);
        }
        curves
    }

    fn ellipse(
        &mut self,
        ellipse: &Ellipse,
        place: Place<'_>,
        scale: f64,
    ) -> Vec<Vec<CubicBezier>> {
        // The axis is in the drawing's own coordinates, whatever the normal.
        let Some(mirror) = mirror(&ellipse.normal) else {
            self.ignored.add(place.at, "entity in a plane that isn't horizontal");
            return Vec::new();
        };
        let major = DVec2::new(ellipse.major_axis.x, ellipse.major_axis.y);
        let minor = major.perp() * ellipse.minor_axis_ratio * mirror.x_axis.x;
        let from = ellipse.start_parameter;
        let to = from + turn(from, ellipse.end_parameter);
        let arc = EllipticArc { centre: point(&ellipse.center), major, minor, from, to };
        if to - from >= turn(0.0, 0.0) { closed(arc, scale) } else { vec![arc.cubics(scale)] }
    }

    fn polyline(&mut self, line: &Polyline, place: Place<'_>, scale: f64) -> Vec<Vec<CubicBezier>> {
        // 16: a mesh, 64: faces.
        if line.flags & (16 | 64) != 0 {
            self.ignored.add(place.at, "entity POLYLINE that is a mesh");
            return Vec::new();
        }
        // 16: a control point of a smoothed polyline, whose other vertices are on the curve.
        let vertices = line.vertices().filter(|vertex| vertex.flags & 16 == 0);
        let vertices: Vec<_> =
            vertices.map(|vertex| (point(&vertex.location), vertex.bulge)).collect();
        self.plane(&line.normal, place, || segments(&vertices, line.flags & 1 != 0, scale))
    }

    fn spline(&mut self, spline: &Spline, place: Place<'_>) -> Vec<Vec<CubicBezier>> {
        let points: Vec<DVec2> = spline.control_points.iter().map(point).collect();
        let degree = usize::try_from(spline.degree_of_curve).unwrap_or_default();
        let cubics = spline_to_cubics(degree, &spline.knot_values, &points, &spline.weight_values);
        let Some(cubics) = cubics.filter(|cubics| !cubics.is_empty()) else {
            let kind = if points.is_empty() {
                "entity SPLINE with fit points only".to_owned()
            } else {
                format!(
                    "entity SPLINE of degree {degree}, or with knots, points or weights that make \
                     no curve"
                )
            };
            self.ignored.add(place.at, kind);
            return Vec::new();
        };
        vec![cubics]
    }

    fn insert(&mut self, insert: &'a Insert, place: Place<'a>) {
        let Some(&block) = self.blocks.get(insert.name.as_str()) else {
            let kind = format!(
                "entity INSERT of the block `{}`, which isn't defined",
                super::shorten(&insert.name)
            );
            self.ignored.add(place.at, kind);
            return;
        };
        let Some(mirror) = mirror(&insert.extrusion_direction) else {
            self.ignored.add(place.at, "entity in a plane that isn't horizontal");
            return;
        };
        if place.depth >= MAX_DEPTH {
            self.ignored.add(place.at, format!("entity INSERT more than {MAX_DEPTH} blocks deep"));
            return;
        }
        for offset in array(insert) {
            let to_metres =
                place.to_metres * DAffine2::from_mat2(mirror) * placement(insert, block, offset);
            for entity in &block.entities {
                self.entity(entity, Place { to_metres, depth: place.depth + 1, ..place });
                if self.is_full() {
                    return;
                }
            }
            self.steps += 1;
            if self.is_full() {
                return;
            }
        }
    }
}

/// Returns the layer of an entity, which the scan writes as the name of its colour.
fn layer(entity: &Entity) -> &str {
    match entity.common.color_name.as_str() {
        "" => "0",
        name => name,
    }
}

/// Returns the number of points of an entity. Each point takes as long as an entity.
fn size(entity: &EntityType) -> usize {
    match entity {
        EntityType::LwPolyline(line) => line.vertices.len(),
        EntityType::Polyline(line) => line.vertices().count(),
        EntityType::Spline(spline) => spline.control_points.len(),
        _ => 0,
    }
}

/// Returns the transformation from a block to the drawing, for one item of an array of blocks.
fn placement(insert: &Insert, block: &Block, offset: DVec2) -> DAffine2 {
    let rotation = DAffine2::from_angle(insert.rotation.to_radians());
    DAffine2::from_translation(point(&insert.location))
        * rotation
        * DAffine2::from_translation(offset)
        * DAffine2::from_scale(DVec2::new(insert.x_scale_factor, insert.y_scale_factor))
        * DAffine2::from_translation(-point(&block.base_point))
}

/// Returns the offsets of an array of blocks.
fn array(insert: &Insert) -> impl Iterator<Item = DVec2> {
    let (columns, rows) = (insert.column_count.max(1), insert.row_count.max(1));
    let spacing = DVec2::new(insert.column_spacing, insert.row_spacing);
    let cells = (0..rows).flat_map(move |row| (0..columns).map(move |column| (column, row)));
    cells.map(move |(column, row)| spacing * DVec2::new(f64::from(column), f64::from(row)))
}

fn point(point: &Point) -> DVec2 {
    DVec2::new(point.x, point.y)
}

/// Returns the largest length of a unit in metres.
fn scale(to_metres: &DAffine2) -> f64 {
    to_metres.matrix2.x_axis.length().max(to_metres.matrix2.y_axis.length())
        * std::f64::consts::SQRT_2
}

/// Returns the transformation from a plane with a normal upwards or downwards; `None` for other
/// planes.
fn mirror(normal: &Vector) -> Option<DMat2> {
    let tilted = normal.x.hypot(normal.y) > 1e-6 * normal.z.abs();
    (!tilted && normal.z != 0.0).then(|| DMat2::from_diagonal(DVec2::new(normal.z.signum(), 1.0)))
}

fn circular_arc(arc: &Arc) -> EllipticArc {
    let from = arc.start_angle.to_radians();
    let to = from + turn(from, arc.end_angle.to_radians());
    EllipticArc::circular(point(&arc.center), arc.radius, from, to)
}

/// Returns the quarters of a closed curve.
fn closed(arc: EllipticArc, scale: f64) -> Vec<Vec<CubicBezier>> {
    arc.quarters().map(|quarter| quarter.cubics(scale)).collect()
}

fn lightweight_polyline(line: &LwPolyline, scale: f64) -> Vec<Vec<CubicBezier>> {
    let vertices: Vec<_> =
        line.vertices.iter().map(|vertex| (DVec2::new(vertex.x, vertex.y), vertex.bulge)).collect();
    segments(&vertices, line.flags & 1 != 0, scale)
}

/// Returns the segments between vertices with bulges: each is an edge.
fn segments(vertices: &[(DVec2, f64)], is_closed: bool, scale: f64) -> Vec<Vec<CubicBezier>> {
    let next = vertices.iter().skip(1).chain(vertices.first().filter(|_| is_closed));
    let segments = vertices.iter().zip(next).filter(|((start, _), (end, _))| start != end);
    segments.map(|(&(start, bulge), &(end, _))| segment(start, end, bulge, scale)).collect()
}

fn segment(start: DVec2, end: DVec2, bulge: f64, scale: f64) -> Vec<CubicBezier> {
    if bulge.abs() < 1e-9 {
        return vec![CubicBezier::straight(start, end)];
    }
    let mut cubics = EllipticArc::bulged(start, end, bulge).cubics(scale);
    // The ends are set because rounding errors of the centre would leave gaps.
    if let Some(first) = cubics.first_mut() {
        first.control_points[0] = start;
    }
    if let Some(last) = cubics.last_mut() {
        last.control_points[3] = end;
    }
    cubics
}
