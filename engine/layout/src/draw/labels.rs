//! The labels of a map. A label covers no other label and no symbol.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec2;
use regatta_base::graph::NodeIndex;
use regatta_base::svg::Svg;

use super::facilities::FACILITY;
use super::{INK, LEGEND, Map, PAPER, SPEED_COLOURS, approximate_length};
use crate::model::drawn::DrawnStation;
use crate::model::route_graph::{Edge, Node};

/// Edges are labelled in graphs of at most this many edges.
const MAX_LABELLED_EDGES: usize = 150;

/// Nodes are labelled in graphs of at most this many nodes. Stations have the same limit.
const MAX_LABELLED_NODES: usize = 2000;

/// The largest number of characters of a label.
const LONGEST_LABEL: usize = 28;

/// The mean width of a character relative to the size of the font, and the height of a line.
/// Viewers have fonts of their own: these are the sizes of a wide one.
const GLYPH: DVec2 = DVec2::new(0.62, 1.15);
/// The mean width of a capital letter.
const CAPITAL: f64 = 0.72;

/// The distance of labels from the border of the picture, in pixels.
const BORDER: f64 = 6.0;

/// The size of the font of the names of stations.
const STATION_FONT: f64 = 11.0;

/// The size of the font of the names of levels, and their distance from the frame, in pixels.
const LEVEL_FONT: f64 = 15.0;
const LEVEL_GAP: f64 = 3.0;
/// The direction from a frame's corner to the name above it.
const UP_RIGHT: DVec2 = DVec2::new(1.0, -1.0);

/// The smallest size of the font of nodes and edges.
const SMALLEST_FONT: f64 = 7.0;

/// The colours of the names of nodes, and of all ids.
const NODE: &str = "#57606a";
const ID: &str = "#9aa4af";

/// The colour of the names of zones.
const ZONE: &str = "#57606a";

/// The distance of labels from the bar of a door, in pixels.
const DOOR: f64 = 2.5;

/// The distance of the name of a door or a lift from its middle, in pixels.
const FACILITY_GAP: f64 = 5.0;

/// The side of a cell of the grid in which labels are searched for, in pixels.
const CELL: f64 = 40.0;

/// A text on the map.
#[derive(Clone, Debug, PartialEq)]
struct Label {
    text: String,
    font: f64,
    colour: &'static str,
    /// The centre in pixels.
    centre: DVec2,
}

impl Label {
    fn new(text: &str, font: f64, colour: &'static str) -> Self {
        Self { text: elide(text), font, colour, centre: DVec2::ZERO }
    }

    /// Returns half the estimated width and height. Chinese, Japanese and Korean characters are as
    /// wide as high.
    fn half_size(&self) -> DVec2 {
        let mut width = 0.0;
        for letter in self.text.chars() {
            width += match letter {
                wide if wide >= '\u{1100}' => 1.0,
                capital if capital.is_uppercase() => CAPITAL,
                _ => GLYPH.x,
            };
        }
        DVec2::new(width, GLYPH.y) * self.font / 2.0
    }

    fn area(&self) -> Area {
        Area::around(self.centre, self.half_size())
    }

    /// Returns the centres beside, above and below a symbol of this radius. The second six are
    /// farther away, for a symbol inside of another one.
    fn centres_around(&self, symbol: DVec2, radius: f64) -> impl Iterator<Item = DVec2> + use<> {
        const SIDES: [(f64, f64); 6] =
            [(1.0, -1.0), (1.0, 1.0), (-1.0, -1.0), (-1.0, 1.0), (0.0, -1.0), (0.0, 1.0)];
        let reach = self.half_size() + radius;
        [1.0, 8.0].into_iter().flat_map(move |gap| {
            SIDES.map(|(right, down)| symbol + (reach + gap) * DVec2::new(right, down))
        })
    }

    /// Returns the centre to the right of a point of a curve; `right` is a unit vector.
    fn centre_right_of(&self, point: DVec2, right: DVec2) -> DVec2 {
        let (half, gap) = (self.half_size(), 0.4 * self.font);
        point + right * (right.abs().dot(half) + gap)
    }
}

/// A rectangle with sides along the axes, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Area {
    min: DVec2,
    max: DVec2,
}

impl Area {
    fn around(centre: DVec2, half_size: DVec2) -> Self {
        Self { min: centre - half_size, max: centre + half_size }
    }

    fn overlaps(&self, other: &Self) -> bool {
        self.min.cmplt(other.max).all() && other.min.cmplt(self.max).all()
    }

    fn contains(&self, other: &Self) -> bool {
        self.min.cmple(other.min).all() && other.max.cmple(self.max).all()
    }

    fn cells(&self) -> impl Iterator<Item = (i32, i32)> + use<> {
        let [from, to] = [self.min, self.max].map(|corner| (corner / CELL).floor().as_ivec2());
        (from.x..=to.x).flat_map(move |x| (from.y..=to.y).map(move |y| (x, y)))
    }
}

/// The areas of a picture that are taken, by the cells of a grid.
struct Taken {
    picture: Area,
    cells: BTreeMap<(i32, i32), Vec<Area>>,
}

impl Taken {
    fn add(&mut self, area: Area) {
        for cell in area.cells() {
            self.cells.entry(cell).or_default().push(area);
        }
    }

    fn is_free(&self, area: &Area) -> bool {
        let mut near = area.cells().filter_map(|cell| self.cells.get(&cell)).flatten();
        self.picture.contains(area) && !near.any(|taken| taken.overlaps(area))
    }

    /// Moves a label to the first free centre; returns `None` if no centre is free.
    fn place(&mut self, label: Label, centres: impl IntoIterator<Item = DVec2>) -> Option<Label> {
        let mut there = centres.into_iter().map(|centre| Label { centre, ..label.clone() });
        let placed = there.find(|label| self.is_free(&label.area()))?;
        self.add(placed.area());
        Some(placed)
    }
}

impl Map<'_> {
    /// Writes the labels: first all halos, then all texts, so that no halo covers a text. Halos are
    /// separate texts because not every SVG renderer supports `paint-order`.
    pub(super) fn write_labels(&self, svg: &mut Svg) {
        let labels = self.labels();
        let group = svg.element("g").set("text-anchor", "middle");
        group.set("dominant-baseline", "central").open();
        svg.element("g").fill(PAPER).stroke(PAPER, 3).set("stroke-linejoin", "round").open();
        for label in &labels {
            svg.text(label.centre).number("font-size", label.font).content(&label.text);
        }
        svg.close();
        for label in &labels {
            let text = svg.text(label.centre).number("font-size", label.font);
            text.fill(label.colour).content(&label.text);
        }
        svg.close();
    }

    /// Returns the labels that have room. Levels come first, then doors and lifts, then stations,
    /// nodes, zones, edges.
    fn labels(&self) -> Vec<Label> {
        let (nodes, edges) = (self.graph.nodes(), self.graph.edges());
        let mut taken = self.symbols();
        let mut labels = self.place_levels(&mut taken);
        let facilities = self.facility_names().take(MAX_LABELLED_NODES);
        let facilities = facilities.filter_map(|(place, name)| {
            let label = Label::new(name, STATION_FONT, FACILITY);
            let centres = label.centres_around(place, FACILITY_GAP);
            taken.place(label, centres)
        });
        labels.extend(facilities);
        if self.stations.len() <= MAX_LABELLED_NODES {
            labels.extend(self.place_stations(&mut taken));
        }
        if nodes.len() <= MAX_LABELLED_NODES {
            labels.extend(self.place_nodes(&mut taken));
        }
        labels.extend(self.place_zones(&mut taken));
        if edges.len() <= MAX_LABELLED_EDGES {
            labels.extend(edges.iter().filter_map(|edge| self.place_edge(edge, &mut taken)));
        }
        labels
    }

    /// Returns the areas of nodes, stations and doors.
    fn symbols(&self) -> Taken {
        let max = self.size - DVec2::new(0.0, LEGEND) - BORDER;
        let picture = Area { min: DVec2::splat(BORDER), max };
        let mut taken = Taken { picture, cells: BTreeMap::new() };
        for node in self.graph.nodes() {
            taken.add(Area::around(self.pixel(node.position), DVec2::splat(self.reach(node))));
        }
        for station in &self.stations {
            let at = self.pixel(station.place);
            taken.add(Area::around(at, DVec2::splat(self.station_size())));
        }
        for [start, end] in self.doors() {
            taken.add(Area { min: start.min(end) - DOOR, max: start.max(end) + DOOR });
        }
        taken
    }

    /// Returns the size of the font of the labels of nodes and edges.
    fn font(&self) -> f64 {
        (self.detail * 0.14).clamp(SMALLEST_FONT, 13.0)
    }

    /// Returns the label of what has no name: its id, smaller and fainter than names.
    fn id_label(&self, id: u32) -> Label {
        Label::new(&id.to_string(), (self.font() * 0.8).max(SMALLEST_FONT), ID)
    }

    fn place_node(&self, node: &Node, taken: &mut Taken) -> Option<Label> {
        let name = node.name().map(|name| Label::new(name, self.font(), NODE));
        let label = name.unwrap_or_else(|| self.id_label(node.id));
        let centres = label.centres_around(self.pixel(node.position), self.reach(node));
        taken.place(label, centres)
    }

    fn place_stations(&self, taken: &mut Taken) -> Vec<Label> {
        let mut labels = Vec::new();
        for DrawnStation { name, place, .. } in &self.stations {
            let label = Label::new(name, STATION_FONT, INK);
            let centres = label.centres_around(self.pixel(*place), self.station_size() + 1.0);
            labels.extend(taken.place(label, centres));
        }
        labels
    }

    /// Places the labels of the nodes that are no stations.
    fn place_nodes(&self, taken: &mut Taken) -> Vec<Label> {
        let stations: BTreeSet<NodeIndex> = self.graph.station_nodes().collect();
        let nodes = (0..).map(NodeIndex).zip(self.graph.nodes());
        let nodes = nodes.filter(|(index, _)| !stations.contains(index));
        nodes.filter_map(|(_, node)| self.place_node(node, taken)).collect()
    }

    /// Places the names of levels in the upper left corners of their frames.
    fn place_levels(&self, taken: &mut Taken) -> Vec<Label> {
        let mut labels = Vec::new();
        for level in self.levels {
            let label = Label::new(&level.name, LEVEL_FONT, INK);
            let corner = self.pixel(DVec2::new(level.low.x, level.high.y));
            let centre = corner + DVec2::new(LEVEL_GAP, -LEVEL_GAP) + label.half_size() * UP_RIGHT;
            labels.extend(taken.place(label, [centre]));
        }
        labels
    }

    fn place_zones(&self, taken: &mut Taken) -> Vec<Label> {
        let zones = self.graph.zone_places();
        let labels = zones.into_iter().take(MAX_LABELLED_NODES).filter_map(|(name, place)| {
            let label = Label::new(name, STATION_FONT, ZONE);
            let centres = label.centres_around(self.pixel(place), 0.0);
            taken.place(label, centres)
        });
        labels.collect()
    }

    fn place_edge(&self, edge: &Edge, taken: &mut Taken) -> Option<Label> {
        let length = approximate_length(&edge.path) * self.scale;
        let colour = SPEED_COLOURS[self.speed_class(edge)];
        let name = edge.name().map(|name| Label::new(name, self.font(), colour));
        let mut labels = name.into_iter().chain([self.id_label(edge.id)]);
        // A label that is longer than its edge would seem to belong to other edges.
        let label = labels.find(|label| 2.0 * label.half_size().x <= length)?;
        let mut centres = Vec::new();
        for fraction in [1.0 / 2.0, 1.0 / 3.0, 2.0 / 3.0] {
            let (position, tangent) = edge.path.at(fraction);
            let right = (tangent * DVec2::new(1.0, -1.0)).perp();
            for side in [right, -right] {
                centres.push(label.centre_right_of(self.pixel(position), side));
            }
        }
        taken.place(label, centres)
    }
}

/// Returns at most [`LONGEST_LABEL`] characters of a text. Names often differ only at their ends,
/// so it leaves out the middle.
fn elide(text: &str) -> String {
    let letters: Vec<char> = text.chars().filter(|letter| !letter.is_control()).collect();
    if letters.len() <= LONGEST_LABEL {
        return letters.into_iter().collect();
    }
    let (start, end) = (LONGEST_LABEL / 2, letters.len() - (LONGEST_LABEL - 1) / 2);
    letters[..start].iter().chain(&['…']).chain(&letters[end..]).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use regatta_base::bezier::CubicBezier;

    use super::*;
    use crate::model::apart::Apart;
    use crate::model::route_graph::RouteGraph;
    use crate::model::tags::{Role, Station, Tags};

    fn tags(name: &str) -> Option<Box<Tags>> {
        Some(Box::new(Tags { name: Some(name.into()), ..Tags::default() }))
    }

    /// Makes a graph of nodes with names at some points, with edges from each to the next, and a
    /// station at every third.
    fn graph(points: &[(f64, f64)], names: &[String]) -> RouteGraph {
        let mut nodes = Vec::new();
        let mut edges = Vec::new();
        let mut stations = Vec::new();
        for (index, (&(x, y), name)) in (0..).zip(points.iter().zip(names.iter().cycle())) {
            let position = DVec2::new(x, y);
            let role = if index % 5 == 0 { Role::Charge } else { Role::None };
            nodes.push(Node { tags: tags(name), role, ..Node::new(index, position, 0.0) });
            let Some(before) = index.checked_sub(1) else { continue };
            let curve = CubicBezier::straight(nodes[before as usize].position, position + 0.01);
            let edge = Edge::new(index, NodeIndex(before), NodeIndex(index), curve, 1.0);
            edges.push(Edge { tags: tags(name).filter(|_| index % 2 == 0), ..edge });
            if index % 3 == 0 {
                let (nodes, position) =
                    (vec![NodeIndex(index)], (index % 2 == 0).then_some(position + 0.3));
                let properties = BTreeMap::new();
                stations.push(Station {
                    name: format!("Dock {index}"),
                    role: Role::Drop,
                    nodes,
                    position,
                    properties,
                });
            }
        }
        RouteGraph::from_valid_parts(nodes, edges).with_surroundings(stations, Vec::new())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(if cfg!(miri) { 2 } else { 64 }))]

        #[test]
        fn labels_overlap_neither_each_other_nor_nodes(
            points in prop::collection::vec((0.0..30.0, 0.0..20.0), 2..150),
            names in prop::collection::vec("[A-Za-z0-9 -]{1,30}", 1..9),
        ) {
            let graph = graph(&points, &names);
            let apart = Apart::new(&graph);
            let map = Map::new(&apart);
            let labels = map.labels();
            prop_assert!(!labels.is_empty());
            for (index, label) in labels.iter().enumerate() {
                let area = label.area();
                prop_assert!(!labels[..index].iter().any(|other| other.area().overlaps(&area)), "{label:?}");
                for node in graph.nodes() {
                    let centre = map.pixel(node.position);
                    let distance = centre.distance(centre.clamp(area.min, area.max));
                    prop_assert!(distance >= map.reach(node) - 1e-9, "{label:?} covers {node:?}");
                }
            }
            prop_assert_eq!(labels, map.labels());
        }
    }

    #[test]
    fn nodes_at_one_spot_have_labels_around_it() {
        let graph = graph(&[(1.0, 1.0), (1.0, 1.0), (1.0, 1.0), (9.0, 9.0)], &["a".to_owned()]);
        let names =
            Map::new(&Apart::new(&graph)).labels().iter().filter(|label| label.text == "a").count();
        assert!(names >= 4, "{names}");
    }

    #[test]
    fn ids_are_smaller_and_fainter_than_names() {
        // Every second edge has no name.
        let graph = graph(&[(0.0, 0.0), (9.0, 0.0), (9.0, 9.0), (0.0, 9.0)], &["hall".into()]);
        let labels = Map::new(&Apart::new(&graph)).labels();
        let (ids, names): (Vec<_>, Vec<_>) =
            labels.iter().partition(|label| label.text.parse::<u32>().is_ok());
        assert!(!ids.is_empty() && names.len() > ids.len(), "{labels:?}");
        assert!(names.iter().all(|name| name.colour != ID));
        let smallest = names.iter().map(|name| name.font).fold(f64::INFINITY, f64::min);
        assert!(ids.iter().all(|id| id.colour == ID && id.font < smallest), "{labels:?}");
    }

    #[test]
    fn many_edges_leave_the_names_of_nodes() {
        let points: Vec<_> = (0..200)
            .map(|index| (f64::from(index % 20) * 5.0, f64::from(index / 20) * 5.0))
            .collect();
        let graph = graph(&points, &["n".to_owned()]);
        let labels = Map::new(&Apart::new(&graph)).labels();
        assert_eq!(labels.iter().filter(|label| label.text == "n").count(), points.len());
    }

    #[test]
    fn long_names_keep_both_ends() {
        assert_eq!(elide("Point-0045 --- Point-0046"), "Point-0045 --- Point-0046");
        assert_eq!(elide("Crossing-0045 to Crossing-0046"), "Crossing-0045 …Crossing-0046");
        assert_eq!(elide("a\nb"), "ab");
        assert_eq!(elide(&"é".repeat(LONGEST_LABEL)), "é".repeat(LONGEST_LABEL));
        assert_eq!(elide(&"é".repeat(99)).chars().count(), LONGEST_LABEL);
    }

    #[test]
    fn labels_lie_neither_on_the_border_of_a_picture_nor_over_doors() {
        let text = include_str!("../../../../graphs/two-levels.yaml");
        let graph = crate::parse(text, "g", &crate::ReadOptions::default()).expect("a plant").0;
        let apart = Apart::new(&graph);
        let map = Map::new(&apart);
        for label in map.labels() {
            let Area { min, max } = label.area();
            assert!(min.min_element() >= BORDER && max.cmple(map.size - BORDER).all(), "{label:?}");
            let bar =
                |ends: [DVec2; 2]| Area { min: ends[0].min(ends[1]), max: ends[0].max(ends[1]) };
            assert!(map.doors().all(|ends| !bar(ends).overlaps(&label.area())), "{label:?}");
        }
    }
}
