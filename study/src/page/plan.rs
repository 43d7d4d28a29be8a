//! The plan of a layout, or of a part of it, in a picture.

use glam::DVec2;
use regatta_base::svg::Svg;
use regatta_layout::{Edge, RouteGraph};

/// The longer side of the plan in pixels.
const LONGER_SIDE: f64 = 1100.0;
/// The colour of doors and of cabins of lifts, that of `regatta graph draw`.
const FACILITY: &str = "#9c5a1a";
/// The empty border in pixels.
pub(super) const MARGIN: f64 = 24.0;

/// The place of a layout in a picture.
pub(super) struct Plan {
    /// The north-western corner of the plan in metres.
    corner: DVec2,
    /// Pixels per metre.
    scale: f64,
    /// The size in pixels.
    pub size: DVec2,
}

impl Plan {
    /// Returns the plan of all roads. The picture has at least a width in pixels.
    pub fn of_roads(graph: &RouteGraph, least_width: f64) -> Self {
        let points = graph.edges().iter().flat_map(|edge| edge.path.control_points());
        let (low, high) = bounds(points);
        let mut plan = Self::of_rectangle(low, high);
        plan.size.x = plan.size.x.max(least_width);
        plan
    }

    /// Returns the plan of a part of the layout: a rectangle round some points, which has at least
    /// a width and a height in metres.
    pub fn of_part(points: impl IntoIterator<Item = DVec2>, least: DVec2) -> Self {
        let (low, high) = bounds(points);
        let (centre, half) = ((low + high) / 2.0, (high - low).max(least) / 2.0);
        Self::of_rectangle(centre - half, centre + half)
    }

    fn of_rectangle(low: DVec2, high: DVec2) -> Self {
        let extent = (high - low).max(DVec2::splat(0.1));
        let scale = (LONGER_SIDE - 2.0 * MARGIN) / extent.max_element();
        Self { corner: DVec2::new(low.x, high.y), scale, size: extent * scale + 2.0 * MARGIN }
    }

    /// Returns the place of a point, given in metres east and north.
    pub fn pixel(&self, point: DVec2) -> DVec2 {
        (point - self.corner) * DVec2::new(1.0, -1.0) * self.scale + MARGIN
    }

    /// Whether a pixel is on the plan.
    pub fn contains(&self, pixel: DVec2) -> bool {
        pixel.cmpge(DVec2::ZERO).all() && pixel.cmple(self.size).all()
    }

    /// Returns the control points of an edge's curves.
    pub fn curves(&self, edge: &Edge) -> impl Iterator<Item = [DVec2; 4]> {
        let cubics = edge.path.cubics().map(|cubic| cubic.control_points);
        cubics.map(|points| points.map(|point| self.pixel(point)))
    }

    /// Draws doors as bars, and the outlines of cabins where they are known, each with its name as
    /// a tooltip.
    pub fn draw_facilities(&self, svg: &mut Svg, graph: &RouteGraph) {
        let doors = graph.doors().iter();
        let doors = doors.map(|door| (&*door.name, door.drawn_line(graph).to_vec()));
        let lifts = graph.lifts().iter();
        let lifts = lifts.filter_map(|lift| Some((&*lift.name, lift.cabin?.outline().to_vec())));
        for (name, line) in doors.chain(lifts) {
            let path = svg.element("path").fill("none").stroke(FACILITY, 3);
            path.polylines([line.into_iter().map(|point| self.pixel(point))]).open();
            svg.element("title").content(name);
            svg.close();
        }
    }
}

/// Returns the south-western and the north-eastern corner of the rectangle round some points.
fn bounds(points: impl IntoIterator<Item = DVec2>) -> (DVec2, DVec2) {
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for point in points {
        (low, high) = (low.min(point), high.max(point));
    }
    (low, high)
}
