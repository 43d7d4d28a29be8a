//! Draws a route graph as a map: an SVG file with the exact Bézier curves.

mod facilities;
mod labels;
mod legend;
mod traffic;

use glam::DVec2;
use regatta_base::badge::Badge;
use regatta_base::graph::EdgeIndex;
use regatta_base::outline::LineKind;
use regatta_base::round;
use regatta_base::svg::Svg;

use crate::model::angle::unit;
use crate::model::apart::{Apart, DrawnCabin, DrawnLevel};
use crate::model::drawn::DrawnStation;
use crate::model::info::BoundingBox;
use crate::model::path::Path;
use crate::model::route_graph::{Edge, Node, RouteGraph};
use crate::model::tags::Role;
use crate::traffic::Certificate;

/// The longer side of the map in pixels, margins included.
const LONGER_SIDE: f64 = 1600.0;
/// The longer side of a map of several levels.
const LONGER_SIDE_OF_LEVELS: f64 = 2400.0;
/// The margin around the graph in pixels.
const MARGIN: f64 = 48.0;
/// The height of the legend below the map in pixels.
const LEGEND: f64 = 44.0;

/// The largest scale in pixels per metre.
const MAX_SCALE: f64 = 60.0;

/// The colours of the background, and of texts and nodes.
const PAPER: &str = "#fafbfc";
const INK: &str = "#30363d";

/// The colour of the frames of levels.
const FRAME: &str = "#c3cad2";

/// The colours of walls and of racks.
const WALL: &str = "#8b949e";
const RACK: &str = "#d3c4a6";

/// The colours of the edges, from slow to fast.
const SPEED_COLOURS: [&str; 5] = ["#7fb8ad", "#4f9bb0", "#3b78a8", "#2f5590", "#263a70"];

/// Returns the map of a graph as the text of an SVG file.
///
/// North is up. Edges are coloured by speed and have an arrow at λ = ½, and a second, orange one if
/// they allow reverse gear. Nodes show their headings; stations are badges with the sign of their
/// role, which the legend names, doors bars, cabins of lifts outlines. Labels are names: those of
/// nodes in grey, unless there are thousands; those of edges in the colour of the edge, if there
/// are few. What has no name has its id, smaller and fainter. Zones have their names in their middle. A label without room is left
/// out. The lines of the background are grey walls, and thinner brown racks. The levels of a
/// building are side by side, each in a frame with its name.
pub fn svg(graph: &RouteGraph) -> String {
    Map::new(&Apart::new(graph)).write(None)
}

/// As [`svg`], with a certificate of the graph. Bands under the edges are single tracks (dead ends
/// in red, all others in yellow), parts that are cut off (grey), and edges that are too slow to be
/// ways (blue). Circles are around stations that block a through road (orange), and around the
/// nodes of the smallest ring of three robots or more that may all wait, or of two (magenta). A
/// legend names those there.
pub fn svg_with_traffic(graph: &RouteGraph, certificate: &Certificate) -> String {
    Map::new(&Apart::new(graph)).write(Some(certificate))
}

struct Map<'g> {
    graph: &'g RouteGraph,
    levels: &'g [DrawnLevel],
    cabins: &'g [DrawnCabin],
    bounds: BoundingBox,
    /// Pixels per metre.
    scale: f64,
    /// The size of the picture in pixels.
    size: DVec2,
    /// The lowest and the highest speed in metres per second.
    speeds: (f64, f64),
    /// The median length of an edge in pixels, by which strokes and symbols are scaled.
    detail: f64,
    stations: Vec<DrawnStation<'g>>,
}

impl<'g> Map<'g> {
    fn new(apart: &'g Apart<'g>) -> Self {
        let Apart { graph, levels, cabins } = apart;
        let bounds = apart.bounds();
        let extent = bounds.size().max(DVec2::splat(0.1));
        let longer_side = if levels.is_empty() { LONGER_SIDE } else { LONGER_SIDE_OF_LEVELS };
        let scale = ((longer_side - 2.0 * MARGIN) / extent.max_element()).min(MAX_SCALE);
        // At least as wide as the legend.
        let size =
            (extent * scale + 2.0 * MARGIN).max(DVec2::new(560.0, 0.0)) + DVec2::new(0.0, LEGEND);
        // The rides of lifts have the speeds of cabins.
        let driven = (0..).map(EdgeIndex).zip(graph.edges());
        let driven = driven.filter(|(index, _)| !graph.is_ride(*index));
        let speeds = driven.map(|(_, edge)| edge.speed);
        let speeds = (speeds.clone().fold(f64::INFINITY, f64::min), speeds.fold(0.0, f64::max));
        let mut lengths: Vec<f64> =
            graph.edges().iter().map(|edge| approximate_length(&edge.path) * scale).collect();
        lengths.sort_by(f64::total_cmp);
        let (detail, stations) = (lengths[lengths.len() / 2], graph.drawn_stations());
        Self { graph, levels, cabins, bounds, scale, size, speeds, detail, stations }
    }

    fn pixel(&self, point: DVec2) -> DVec2 {
        DVec2::new(point.x - self.bounds.min_x, self.bounds.max_y - point.y) * self.scale + MARGIN
    }

    fn write(&self, certificate: Option<&Certificate>) -> String {
        let mut svg = Svg::new(0);
        let keys = self.keys(certificate);
        svg.document(self.size + DVec2::new(0.0, self.height_of(&keys)), "")
            .set("font-family", "Helvetica, Arial, sans-serif")
            .set("font-size", 11)
            .open();
        svg.decimals = 1;
        svg.background(PAPER);
        self.write_grid(&mut svg);
        self.write_frames(&mut svg);
        self.write_background(&mut svg);
        self.write_facilities(&mut svg);
        if let Some(certificate) = certificate {
            self.write_bands(&mut svg, certificate);
        }
        for (class, colour) in SPEED_COLOURS.into_iter().enumerate() {
            self.write_edges(&mut svg, class, colour);
        }
        self.write_reverse_arrows(&mut svg);
        self.write_nodes(&mut svg);
        self.write_stations(&mut svg);
        if let Some(certificate) = certificate {
            self.write_marks(&mut svg, certificate);
        }
        self.write_labels(&mut svg);
        self.write_legend(&mut svg);
        self.write_keys(&mut svg, &keys);
        svg.finish()
    }

    /// Writes faint grid lines at round coordinates.
    fn write_grid(&self, svg: &mut Svg) {
        let step = round::down(80.0 / self.scale);
        let (bottom, right) = (self.size.y - LEGEND, self.size.x);
        let mut lines = Vec::new();
        let west = self.bounds.min_x - MARGIN / self.scale;
        let mut x = (west / step).ceil() * step;
        while self.pixel(DVec2::new(x, 0.0)).x < right {
            let at = self.pixel(DVec2::new(x, 0.0)).x;
            lines.push([DVec2::new(at, 0.0), DVec2::new(at, bottom)]);
            x += step;
        }
        let north = self.bounds.max_y + MARGIN / self.scale;
        let mut y = (north / step).floor() * step;
        while self.pixel(DVec2::new(0.0, y)).y < bottom {
            let at = self.pixel(DVec2::new(0.0, y)).y;
            lines.push([DVec2::new(0.0, at), DVec2::new(right, at)]);
            y -= step;
        }
        svg.element("path").fill("none").stroke("#e8ebef", 1).polylines(lines);
    }

    /// Writes a frame around each level, whose name is among the labels.
    fn write_frames(&self, svg: &mut Svg) {
        for level in self.levels {
            let [low, high] = [level.low, level.high].map(|corner| self.pixel(corner));
            let size = (high - low).abs();
            svg.rect(low.min(high), size).fill("none").stroke(FRAME, 1);
        }
    }

    /// Writes the lines of the background: racks, and over them walls.
    fn write_background(&self, svg: &mut Svg) {
        if self.graph.background().is_empty() {
            return;
        }
        let kinds = self.graph.background_kinds();
        for (kind, colour, width) in [(LineKind::Rack, RACK, 1.0), (LineKind::Wall, WALL, 2.0)] {
            let lines = self.graph.background().iter().zip(&kinds);
            let lines = lines.filter(|(_, of_line)| **of_line == kind);
            let lines = lines.map(|(line, _)| line.points.iter().map(|&point| self.pixel(point)));
            svg.element("path").fill("none").stroke(colour, width).polylines(lines);
        }
    }

    /// Writes stations as badges, with lines to those of their nodes that are elsewhere.
    fn write_stations(&self, svg: &mut Svg) {
        let badge = self.badge(self.station_size());
        for DrawnStation { name, role, place, nodes } in &self.stations {
            let at = self.pixel(*place);
            for node in *nodes {
                let line = svg.line(at, self.pixel(self.graph.node(*node).position));
                line.stroke(INK, 1).set("stroke-dasharray", "3 3");
            }
            badge.draw(svg, at, role.sign(), name);
        }
    }

    fn badge(&self, radius: f64) -> Badge<'static> {
        Badge { radius, paper: PAPER, ink: INK, is_y_up: false }
    }

    /// Returns the radius of a station's badge.
    fn station_size(&self) -> f64 {
        (self.detail * 0.16).clamp(3.0, 10.0)
    }

    fn node_radius(&self) -> f64 {
        (self.detail * 0.07).clamp(0.8, 4.5)
    }

    /// Returns the radius of a node's circle with half the stroke, or of its badge.
    fn reach(&self, node: &Node) -> f64 {
        if node.role == Role::None { self.node_radius() * 1.2 } else { self.station_size() + 1.0 }
    }

    fn stroke(&self) -> f64 {
        (self.detail * 0.04).clamp(0.7, 2.0)
    }

    fn arrow(&self) -> f64 {
        (self.detail * 0.16).clamp(3.0, 9.0)
    }

    fn speed_class(&self, edge: &Edge) -> usize {
        let (slowest, fastest) = self.speeds;
        let fraction = (edge.speed - slowest) / (fastest - slowest).max(f64::MIN_POSITIVE);
        let middle_if_all_equal = if fastest > slowest { fraction } else { 0.5 };
        (middle_if_all_equal * (SPEED_COLOURS.len() - 1) as f64).round() as usize
    }

    /// Writes the curves and arrows of one speed class. Classes are written in ascending order, so
    /// that faster edges are drawn on top.
    fn write_edges(&self, svg: &mut Svg, class: usize, colour: &str) {
        let edges = self.graph.edges().iter().filter(|edge| self.speed_class(edge) == class);
        let edges: Vec<&Edge> = edges.collect();
        if edges.is_empty() {
            return;
        }
        let group = svg.element("g").fill("none").stroke(colour, self.stroke());
        group.set("stroke-linecap", "round").open();
        for edge in &edges {
            let cubics = edge.path.cubics().map(|cubic| cubic.control_points);
            let curves = cubics.map(|points| points.map(|point| self.pixel(point)));
            svg.element("path").curves([curves]);
        }
        svg.close();
        let arrows = edges.iter().filter(|edge| self.has_room(edge, 2.2));
        let arrows = arrows.map(|edge| self.arrow_corners(&edge.path, 0.5, 1.0));
        svg.element("path").fill(colour).polygons(arrows);
    }

    fn write_reverse_arrows(&self, svg: &mut Svg) {
        let reversible = self.graph.edges().iter().filter(|edge| edge.reverse_speed.is_some());
        let with_room = reversible.filter(|edge| self.has_room(edge, 4.5));
        let arrows = with_room.map(|edge| self.arrow_corners(&edge.path, 0.28, -0.7));
        svg.element("path").fill("#e07b39").polygons(arrows);
    }

    fn has_room(&self, edge: &Edge, arrows: f64) -> bool {
        approximate_length(&edge.path) * self.scale > arrows * self.arrow()
    }

    /// Returns a triangle on the curve, `size` times as long as a normal arrow; it points backwards
    /// if `size` is negative.
    fn arrow_corners(&self, path: &Path, fraction: f64, size: f64) -> [DVec2; 3] {
        let (position, tangent) = path.at(fraction);
        let along = tangent * DVec2::new(1.0, -1.0) * self.arrow() * size;
        let centre = self.pixel(position);
        let (tip, back, side) = (centre + along * 0.5, centre - along * 0.5, along.perp() * 0.36);
        [tip, back + side, back - side]
    }

    fn write_nodes(&self, svg: &mut Svg) {
        let radius = self.node_radius();
        let pointers = self.graph.nodes().iter().map(|node| {
            let (from, pointer) = (self.pixel(node.position), unit(node.theta) * 2.4 * radius);
            [from, from + pointer * DVec2::new(1.0, -1.0)]
        });
        let path = svg.element("path").stroke(INK, radius * 0.55).set("stroke-linecap", "round");
        path.polylines(pointers);
        svg.element("g").fill("#ffffff").stroke(INK, radius * 0.4).open();
        for node in self.graph.nodes() {
            svg.circle(self.pixel(node.position), radius);
        }
        svg.close();
    }
}

/// Estimates the length of a path. The length of a cubic is the mean of its chord and its control
/// polygon, which is accurate enough to choose sizes.
fn approximate_length(path: &Path) -> f64 {
    let cubics = path.cubics().map(|cubic| cubic.control_points);
    let lengths = cubics.map(|[p0, p1, p2, p3]| {
        (p0.distance(p3) + p0.distance(p1) + p1.distance(p2) + p2.distance(p3)) / 2.0
    });
    lengths.sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::Warehouse;
    use crate::model::options::ReadOptions;
    use crate::parse;
    use crate::traffic::RobotType;

    #[test]
    fn a_map_shows_every_edge_and_node() {
        let text = Warehouse { aisles: 2, rows: 1, bays: 2 }.generate().unwrap();
        let (graph, _) = parse(&text, "g", &ReadOptions::default()).unwrap();
        let map = svg(&graph);
        assert_eq!(map.matches("<circle").count(), graph.nodes().len());
        assert_eq!(map.matches("<path d=\"M").count(), graph.edges().len());
        assert!(!map.contains("NaN") && !map.contains("inf"));
        assert_eq!(map.matches("<g").count(), map.matches("</g>").count());
    }

    #[test]
    fn names_stations_and_roles_are_drawn() {
        let text = "Vertices:\n- {Id: 1, X: 1, Y: 1, Theta: 0, Name: a<b, Role: charge}\n- {Id: 2, X: 5, Y: 1, Theta: 0}\n\
            Edges:\n- {Id: 1, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, VelocityForward: 1}\n\
            Stations:\n- {Name: Dock, Role: drop, Nodes: [2], X: 5, Y: 2}\n";
        let map = svg(&parse(text, "g", &ReadOptions::default()).unwrap().0);
        assert!(map.contains(">a&lt;b</text>") && map.contains(">Dock</text>"), "{map}");
        let titles = ["<title>a&lt;b</title>", "<title>Dock</title>"];
        assert!(titles.iter().all(|title| map.contains(title)), "{map}");
        let in_legend = [">charge</text>", ">drop</text>"];
        assert!(in_legend.iter().all(|name| map.contains(name)), "{map}");
    }

    #[test]
    fn zones_are_named_whether_they_have_a_rule_or_not() {
        let text = "Vertices:\n- {Id: 1, X: 1, Y: 1, Theta: 0, Zone: hall}\n\
            - {Id: 2, X: 5, Y: 1, Theta: 0, Zone: gate}\n\
            Edges:\n- {Id: 1, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, \
            VelocityForward: 1}\n\
            Zones:\n- {Name: gate, Capacity: 1, Nodes: [2]}\n";
        let (graph, _) = parse(text, "g", &ReadOptions::default()).unwrap();
        let places = [("gate", DVec2::new(5.0, 1.0)), ("hall", DVec2::new(1.0, 1.0))];
        assert_eq!(graph.zone_places(), places);
        let map = svg(&graph);
        assert!(map.contains(">gate</text>") && map.contains(">hall</text>"), "{map}");
    }

    #[test]
    fn doors_and_lifts_are_drawn_and_named() {
        let text = include_str!("../../../graphs/two-levels.yaml");
        let map = svg(&parse(text, "g", &ReadOptions::default()).unwrap().0);
        assert_eq!(map.matches(facilities::FACILITY).count(), 2 + 4 + 4, "and four names");
        assert!(map.contains(">hall</text>") && map.contains(">lift</text>"));
        for level in ["ground", "upper"] {
            assert_eq!(map.matches(&format!(">{level}</text>")).count(), 2, "with its halo: {map}");
        }
    }

    #[test]
    fn dead_ends_and_sections_have_bands_of_their_own() {
        let text = "id,x,y\nA,0,0\nB,9,0\nC,9,9\nD,20,0\nE,40,0\nF,49,0\nG,49,9\n\n\
            from,to,speed\nA,B,1\nB,C,1\nC,A,1\nB,D,1\nD,B,1\nD,E,1\nE,D,1\nE,F,1\nF,G,1\nG,E,1\n";
        let (graph, _) = parse(text, "g", &ReadOptions::default()).unwrap();
        let (map, plain) = (
            svg_with_traffic(&graph, &Certificate::new(&graph, &RobotType::default())),
            svg(&graph),
        );
        assert!(map.contains(">single track</text>") && !plain.contains("single track"));
        let bands = map.matches("<path d=\"M").count() - plain.matches("<path d=\"M").count();
        assert_eq!(bands, 1, "one section and no dead end");
        assert_eq!(map.matches("<g").count(), map.matches("</g>").count());
    }

    #[test]
    fn all_that_a_certificate_finds_is_drawn_and_named() {
        let text = "id,x,y,role\nA,0,0,\nB,9,0,\nC,9,9,\nD,20,0,pick\nE,31,0,\nT,20,9,\n\n\
            from,to,speed\nA,B,1\nB,C,1\nC,A,1\nB,D,1\nD,B,1\nD,E,1\nE,D,1\n\
            B,T,1\nT,B,0.001\n";
        let (graph, _) = parse(text, "g.csv", &ReadOptions::default()).unwrap();
        let map = svg_with_traffic(&graph, &Certificate::new(&graph, &RobotType::default()));
        for name in [
            "cut off from the main part",
            "too slow to count as a way",
            "station in the way",
            "robots that may all wait",
        ] {
            assert!(map.contains(&format!(">{name}</text>")), "{name}: {map}");
        }
        // Around the station, the three robots of the ring, and in the legend.
        assert_eq!(map.matches("stroke=\"#d9480f\"").count(), 2);
        assert_eq!(map.matches("<circle").count() - svg(&graph).matches("<circle").count(), 7);
    }

    #[test]
    fn a_single_short_edge_makes_a_map() {
        let text = "Vertices:\n- {Id: 1, X: 1, Y: 1, Theta: 0}\n- {Id: 2, X: 1.002, Y: 1, Theta: 0}\n\
            Edges:\n- {Id: 1, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, VelocityForward: 1}\n";
        let map = svg(&parse(text, "g", &ReadOptions::default()).unwrap().0);
        assert!(!map.contains("NaN") && !map.contains("inf"));
    }
}
