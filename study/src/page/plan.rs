//! The plan of a layout, or of a part of it, in a picture.

use glam::DVec2;
use regatta_base::badge::Badge;
use regatta_base::outline::LineKind;
use regatta_base::svg::Svg;
use regatta_layout::model::info::BoundingBox;
use regatta_layout::{Apart, DrawnLevel, Edge, RouteGraph};

/// The longer side of the plan in pixels.
const LONGER_SIDE: f64 = 1100.0;
/// The colour of doors and of cabins of lifts, that of `regatta graph draw`.
const FACILITY: &str = "#9c5a1a";
/// The colours of walls and of racks, those of `regatta graph draw`.
const WALL: &str = "#8b949e";
const RACK: &str = "#d3c4a6";
/// The colour of the frames of levels, and the size of the letters of their names, in pixels.
const FRAME: &str = "#c3cad2";
const LEVEL_LETTER: f64 = 12.0;
/// The colour of stations and their names.
const STATION_COLOUR: &str = "#5a6875";
/// The radius of a station's badge in metres, and the least and the greatest one in pixels.
const BADGE: f64 = 0.4;
const BADGE_PIXELS: [f64; 2] = [3.5, 8.0];
/// The size of the letters of names, in pixels.
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
    pub fn of_roads(apart: &Apart<'_>, least_width: f64) -> Self {
        let BoundingBox { min_x, min_y, max_x, max_y } = apart.bounds();
        let mut plan = Self::of_rectangle(DVec2::new(min_x, min_y), DVec2::new(max_x, max_y));
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

    /// Draws racks, and over them walls and the outlines of floors.
    pub fn draw_background(&self, svg: &mut Svg, graph: &RouteGraph) {
        if graph.background().is_empty() {
            return;
        }
        let kinds = graph.background_kinds();
        for (kind, colour, width) in [(LineKind::Rack, RACK, 0.8), (LineKind::Wall, WALL, 1.6)] {
            let lines = graph.background().iter().zip(&kinds);
            let lines = lines.filter(|(_, of_line)| **of_line == kind);
            let lines = lines.map(|(line, _)| line.points.iter().map(|point| self.pixel(*point)));
            svg.element("path").fill("none").stroke(colour, width).polylines(lines);
        }
    }

    /// Draws a frame round each level of a building, with its name above.
    pub fn draw_levels(&self, svg: &mut Svg, levels: &[DrawnLevel]) {
        for DrawnLevel { name, low, high } in levels {
            let corner = self.pixel(DVec2::new(low.x, high.y));
            let size = (*high - *low) * self.scale;
            svg.rect(corner, size).fill("none").stroke(FRAME, 1);
            let text = svg.text(corner + DVec2::new(2.0, -4.0));
            text.number("font-size", LEVEL_LETTER).fill(STATION_COLOUR).content(name);
        }
    }

    /// Draws stations as badges, each with its name as a tooltip, and beside it as far as there is
    /// room beside the marks at some pixels. Then the names of zones in their middle have room.
    pub fn draw_stations(&self, svg: &mut Svg, graph: &RouteGraph, marks: &[DVec2]) {
        let mut taken: Vec<_> = marks.iter().map(|at| [at - MARK, at + MARK]).collect();
        let badge = Badge {
            radius: self.badge_radius(),
            paper: "#fff",
            ink: STATION_COLOUR,
            is_y_up: false,
        };
        for station in graph.drawn_stations() {
            let at = self.pixel(station.place);
            if self.contains(at) {
                badge.draw(svg, at, station.role.sign(), &station.name);
                self.write_name(svg, &mut taken, &station.name, at);
            }
        }
        for (name, place) in graph.zone_places() {
            self.write_name(svg, &mut taken, name, self.pixel(place));
        }
    }

    /// The radius of a station's badge in pixels.
    fn badge_radius(&self) -> f64 {
        (BADGE * self.scale).clamp(BADGE_PIXELS[0], BADGE_PIXELS[1])
    }

    /// Writes a name to the right of a place, to the left, above or below it, where there is
    /// room.
    fn write_name(&self, svg: &mut Svg, taken: &mut Vec<[DVec2; 2]>, name: &str, at: DVec2) {
        let size = DVec2::new(0.6 * name.chars().count() as f64, 1.2) * LETTER;
        let radius = self.badge_radius();
        let beside = radius + 3.0;
        let corners = [
            at + DVec2::new(beside, -0.65 * LETTER),
            at + DVec2::new(-beside - size.x, -0.65 * LETTER),
            at + DVec2::new(-0.5 * size.x, -beside - size.y),
            at + DVec2::new(-0.5 * size.x, beside),
            // At the border of the plan.
            at + DVec2::new(-radius, beside),
            at + DVec2::new(radius - size.x, beside),
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
    pub fn draw_facilities(&self, svg: &mut Svg, apart: &Apart<'_>) {
        let doors = apart.graph.doors().iter();
        let doors = doors.map(|door| (&*door.name, door.drawn_line(&apart.graph).to_vec()));
        let cabins = apart.cabins.iter();
        let cabins =
            cabins.filter_map(|cabin| Some((&*cabin.name, cabin.footprint?.outline().to_vec())));
        for (name, line) in doors.chain(cabins) {
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
