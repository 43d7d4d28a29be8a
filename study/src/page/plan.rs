//! The plan of a layout, or of a part of it, in a picture.

use std::collections::BTreeSet;

use glam::DVec2;
use regatta_base::svg::Svg;
use regatta_layout::{Edge, NodeIndex, Role, RouteGraph};

/// The longer side of the plan in pixels.
const LONGER_SIDE: f64 = 1100.0;
/// The colour of doors and of cabins of lifts, that of `regatta graph draw`.
const FACILITY: &str = "#9c5a1a";
/// The colour of walls.
const WALL: &str = "#aeb6be";
/// The colour of stations and their names.
const STATION_COLOUR: &str = "#5a6875";
/// Half the side of a station's square, and the size of the letters of its name, in pixels.
const STATION: f64 = 3.0;
const LETTER: f64 = 10.0;
/// Half of the side of the square that a mark takes, in pixels.
const MARK: f64 = 12.0;
/// The largest number of names.
const MOST_NAMES: usize = 200;
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
    /// Returns the plan of all roads with what is round them. The picture has at least a width in
    /// pixels.
    pub fn of_roads(graph: &RouteGraph, least_width: f64) -> Self {
        let roads = graph.edges().iter().flat_map(|edge| edge.path.control_points());
        let background = graph.background().iter().flat_map(|line| line.points.iter().copied());
        let stations = graph.stations().iter().filter_map(|station| station.position);
        let (low, high) = bounds(roads.chain(background).chain(stations));
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

    /// Draws walls, and the outlines of floors and racks.
    pub fn draw_background(&self, svg: &mut Svg, graph: &RouteGraph) {
        if graph.background().is_empty() {
            return;
        }
        let lines = graph.background().iter();
        let lines = lines.map(|line| line.points.iter().map(|point| self.pixel(*point)));
        svg.element("path").fill("none").stroke(WALL, 1.2).polylines(lines);
    }

    /// Draws stations as squares, each with its name as a tooltip, and round it as far as there is
    /// room beside the marks at some pixels. Then the names of zones in their middle have room.
    pub fn draw_stations(&self, svg: &mut Svg, graph: &RouteGraph, marks: &[DVec2]) {
        let mut taken: Vec<_> = marks.iter().map(|at| [at - MARK, at + MARK]).collect();
        for (name, place) in stations(graph) {
            let at = self.pixel(place);
            if !self.contains(at) {
                continue;
            }
            let square = svg.rect(at - STATION, DVec2::splat(2.0 * STATION)).fill(STATION_COLOUR);
            square.open();
            svg.element("title").content(name);
            svg.close();
            self.write_name(svg, &mut taken, name, at);
        }
        for (name, place) in graph.zone_places() {
            self.write_name(svg, &mut taken, name, self.pixel(place));
        }
    }

    /// Writes a name to the right of a place, to the left, above or below it, where there is
    /// room.
    fn write_name(&self, svg: &mut Svg, taken: &mut Vec<[DVec2; 2]>, name: &str, at: DVec2) {
        let size = DVec2::new(0.6 * name.chars().count() as f64, 1.2) * LETTER;
        let beside = 2.0 * STATION;
        let corners = [
            at + DVec2::new(beside, -0.65 * LETTER),
            at + DVec2::new(-beside - size.x, -0.65 * LETTER),
            at + DVec2::new(-0.5 * size.x, -beside - size.y),
            at + DVec2::new(-0.5 * size.x, beside),
            // At the border of the plan.
            at + DVec2::new(-STATION, beside),
            at + DVec2::new(STATION - size.x, beside),
        ];
        let corner =
            corners.into_iter().find(|corner| self.is_free(taken, [*corner, corner + size]));
        if let Some(corner) = corner.filter(|_| taken.len() < MOST_NAMES) {
            taken.push([corner, corner + size]);
            let text = svg.text(corner + DVec2::new(0.0, LETTER));
            text.number("font-size", LETTER).fill(STATION_COLOUR).content(name);
        }
    }

    /// Whether a rectangle lies on the plan, and none of others touches it.
    fn is_free(&self, taken: &[[DVec2; 2]], [low, high]: [DVec2; 2]) -> bool {
        let mut others = taken.iter();
        let is_alone = others.all(|[other_low, other_high]| {
            low.cmpgt(*other_high).any() || high.cmplt(*other_low).any()
        });
        is_alone && self.contains(low) && self.contains(high)
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

/// Returns the names and places of the stations, and of the nodes with a role and a name that serve
/// none of them.
fn stations(graph: &RouteGraph) -> impl Iterator<Item = (&str, DVec2)> {
    let stations = graph.stations().iter();
    let served: BTreeSet<_> = stations.clone().flat_map(|station| &station.nodes).collect();
    let named = stations.filter_map(|station| {
        let first = station.nodes.first().map(|node| graph.node(*node).position);
        Some((&*station.name, station.position.or(first)?))
    });
    let nodes = (0..).map(NodeIndex).zip(graph.nodes());
    let nodes = nodes.filter(move |(index, _)| !served.contains(index));
    let nodes = nodes.filter(|(_, node)| node.role != Role::None);
    named.chain(nodes.filter_map(|(_, node)| Some((node.name()?, node.position))))
}

/// Returns the south-western and the north-eastern corner of the rectangle round some points.
fn bounds(points: impl IntoIterator<Item = DVec2>) -> (DVec2, DVec2) {
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for point in points {
        (low, high) = (low.min(point), high.max(point));
    }
    (low, high)
}
