//! The levels of a building apart from each other on a drawing: side by side, as in the viewer.

use std::borrow::Cow;
use std::collections::BTreeSet;

use glam::{DVec2, Vec2};
use regatta_base::parts::columns;

use super::facilities::{Cabin, Door};
use super::info::BoundingBox;
use super::route_graph::{Edge, Node, RouteGraph};
use super::tags::{BackgroundLine, Station};

/// The distance between levels: a part of the longer side of all levels, but at least so many
/// metres.
const GAP: f64 = 0.04;
const LEAST_GAP: f64 = 1.0;
/// The distance of a level from its frame, as a part of the distance between levels.
const FRAME: f64 = 0.25;
/// The shape of the picture that the levels are to fill.
const PICTURE: Vec2 = Vec2::new(1.6, 1.0);
/// The name of the part of a picture with the nodes that are on no level.
const NO_LEVEL: &str = "no level";

/// A route graph for a drawing. The levels of a building are moved apart; all other graphs stay as
/// they are. Places above each other are at the same place of each level.
///
/// An edge between levels, such as the ride of a lift, is on the level of its origin.
#[derive(Clone, Debug)]
pub struct Apart<'g> {
    /// The graph, whose indices are those of the original.
    pub graph: Cow<'g, RouteGraph>,
    /// The levels, from the upper left on; none if the graph has fewer than two.
    pub levels: Vec<DrawnLevel>,
    /// The cabins of lifts, on each level that they serve.
    pub cabins: Vec<DrawnCabin>,
}

/// A level of a building on a drawing.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnLevel {
    /// The name.
    pub name: String,
    /// The south-western corner of its frame in metres.
    pub low: DVec2,
    /// The north-eastern corner of its frame in metres.
    pub high: DVec2,
}

/// A cabin of a lift on a level of a drawing.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnCabin {
    /// The name of the lift.
    pub name: String,
    /// The middle in metres: that of the footprint or, if it isn't known, a node in the cabin.
    pub centre: DVec2,
    /// The footprint; `None` if the file doesn't give it.
    pub footprint: Option<Cabin>,
}

impl<'g> Apart<'g> {
    /// Moves the levels of a graph apart.
    pub fn new(graph: &'g RouteGraph) -> Self {
        let places = Places::new(graph);
        let levels = places.frames();
        let cabins = places.cabins();
        let graph =
            if levels.is_empty() { Cow::Borrowed(graph) } else { Cow::Owned(places.moved()) };
        Self { graph, levels, cabins }
    }

    /// Returns the smallest rectangle with all that is drawn.
    pub fn bounds(&self) -> BoundingBox {
        let frames = self.levels.iter().flat_map(|level| [level.low, level.high]);
        bounds(&self.graph).with(frames)
    }
}

/// The places of the levels of a graph.
struct Places<'g> {
    graph: &'g RouteGraph,
    /// The names in alphabetical order, and then `None` if nodes are on no level.
    names: Vec<Option<&'g str>>,
    /// The rectangle with all levels, where they are in the file.
    bounds: BoundingBox,
    columns: usize,
    /// The distance between levels in metres.
    gap: f64,
}

impl<'g> Places<'g> {
    fn new(graph: &'g RouteGraph) -> Self {
        let names = names(graph);
        let bounds = bounds(graph);
        let extent = bounds.size().max(DVec2::splat(0.1));
        let columns = columns(names.len() as u32, PICTURE, extent.as_vec2()) as usize;
        let rows = names.len().div_ceil(columns);
        let all = extent * DVec2::new(columns as f64, rows as f64);
        let gap = (all.max_element() * GAP).max(LEAST_GAP);
        Self { graph, names, bounds, columns, gap }
    }

    /// Whether there are levels to move.
    fn are_several(&self) -> bool {
        self.names.iter().flatten().count() > 1
    }

    /// Returns how far a level is moved.
    fn offset(&self, level: Option<&str>) -> DVec2 {
        if !self.are_several() {
            return DVec2::ZERO;
        }
        let place = self.names.iter().position(|name| *name == level).unwrap_or(0);
        let (column, row) = (place % self.columns, place / self.columns);
        (self.bounds.size() + self.gap) * DVec2::new(column as f64, -(row as f64))
    }

    fn frames(&self) -> Vec<DrawnLevel> {
        if !self.are_several() {
            return Vec::new();
        }
        let BoundingBox { min_x, min_y, max_x, max_y } = self.bounds;
        let frame = FRAME * self.gap;
        let levels = self.names.iter().map(|name| {
            let offset = self.offset(*name);
            DrawnLevel {
                name: name.unwrap_or(NO_LEVEL).to_owned(),
                low: DVec2::new(min_x, min_y) + offset - frame,
                high: DVec2::new(max_x, max_y) + offset + frame,
            }
        });
        levels.collect()
    }

    fn cabins(&self) -> Vec<DrawnCabin> {
        let mut cabins = Vec::new();
        for lift in self.graph.lifts() {
            for level in &lift.levels {
                let offset = self.offset(Some(&*level.name));
                let footprint =
                    lift.cabin.map(|cabin| Cabin { centre: cabin.centre + offset, ..cabin });
                let node = self.graph.node(level.nodes[0]).position + offset;
                let centre = footprint.map_or(node, |cabin| cabin.centre);
                cabins.push(DrawnCabin { name: lift.name.to_string(), centre, footprint });
            }
        }
        cabins
    }

    fn moved(&self) -> RouteGraph {
        let nodes = self.graph.nodes().iter().map(|node| Node {
            position: node.position + self.offset(node.level()),
            ..node.clone()
        });
        let edges = self.graph.edges().iter().map(|edge| {
            let offset = self.offset(self.graph.drawn_level(edge));
            Edge { path: edge.path.map(|point| point + offset), ..edge.clone() }
        });
        let stations = self.graph.stations().iter().map(|station| self.station(station));
        let lines = self.graph.background().iter().flat_map(|line| self.lines(line));
        let doors = self.graph.doors().iter().map(|door| self.door(door));
        RouteGraph::from_valid_parts(nodes.collect(), edges.collect())
            .with_origin(self.graph.origin())
            .with_surroundings(stations.collect(), lines.collect())
            .with_zones(self.graph.zones().to_vec())
            .with_facilities(doors.collect(), self.graph.lifts().to_vec())
    }

    /// Moves a station with the first of its nodes.
    fn station(&self, station: &Station) -> Station {
        let first = station.nodes.first();
        let offset = self.offset(first.and_then(|node| self.graph.node(*node).level()));
        let position = station.position.map(|position| position + offset);
        Station { position, ..station.clone() }
    }

    /// Moves a line to its level; one without a level is on all levels.
    fn lines(&self, line: &BackgroundLine) -> Vec<BackgroundLine> {
        let names = self.names.iter().flatten().copied();
        let on = names.filter(|name| line.level.as_deref().is_none_or(|level| level == *name));
        let lines = on.map(|name| {
            let offset = self.offset(Some(name));
            let points = line.points.iter().map(|point| *point + offset).collect();
            BackgroundLine { points, level: Some(name.into()) }
        });
        lines.collect()
    }

    fn door(&self, door: &Door) -> Door {
        let offset = self.offset(self.graph.drawn_level(self.graph.edge(door.edges[0])));
        let line = door.line.map(|line| line.map(|end| end + offset));
        Door { line, ..door.clone() }
    }
}

/// Returns the names of the levels, as the viewer orders them, and `None` if nodes are on none.
fn names(graph: &RouteGraph) -> Vec<Option<&str>> {
    let of_nodes = graph.nodes().iter().map(Node::level);
    let of_edges = graph.edges().iter().map(|edge| graph.drawn_level(edge));
    let has_others = of_nodes.clone().any(|level| level.is_none());
    let names: BTreeSet<&str> = of_nodes.chain(of_edges).flatten().collect();
    names.into_iter().map(Some).chain(has_others.then_some(None)).collect()
}

/// Returns the smallest rectangle with the graph and what is around it.
fn bounds(graph: &RouteGraph) -> BoundingBox {
    let stations = graph.stations().iter().filter_map(|station| station.position);
    let lines = graph.background().iter().flat_map(|line| &line.points).copied();
    let doors = graph.doors().iter().flat_map(|door| door.drawn_line(graph));
    let cabins = graph.lifts().iter().filter_map(|lift| lift.cabin);
    let cabins = cabins.flat_map(|cabin| cabin.outline());
    BoundingBox::of(graph).with(lines.chain(stations).chain(doors).chain(cabins))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::options::ReadOptions;
    use crate::parse;

    fn graph(text: &str) -> RouteGraph {
        parse(text, "g.yaml", &ReadOptions::default()).expect("a graph").0
    }

    #[test]
    fn levels_lie_apart_and_all_that_is_on_them_moves_with_them() {
        let original = graph(include_str!("../../../../graphs/two-levels.yaml"));
        let apart = Apart::new(&original);
        let [ground, upper] = &*apart.levels else { panic!("{:?}", apart.levels) };
        assert_eq!((&*ground.name, &*upper.name), ("ground", "upper"));
        assert!(ground.low.cmpgt(upper.high).any() || upper.low.cmpgt(ground.high).any());
        let is_in = |point: DVec2, level: &DrawnLevel| {
            point.cmpge(level.low).all() && point.cmple(level.high).all()
        };
        let level_of = |name: Option<&str>| if name == Some("upper") { upper } else { ground };
        for node in apart.graph.nodes() {
            assert!(is_in(node.position, level_of(node.level())), "{node:?}");
        }
        for edge in apart.graph.edges() {
            let level = level_of(apart.graph.drawn_level(edge));
            assert!(edge.path.control_points().all(|point| is_in(point, level)), "{edge:?}");
        }
        for door in apart.graph.doors() {
            let level = level_of(apart.graph.drawn_level(apart.graph.edge(door.edges[0])));
            assert!(door.drawn_line(&apart.graph).iter().all(|end| is_in(*end, level)), "{door:?}");
        }
        let [below, above] = &*apart.cabins else { panic!("{:?}", apart.cabins) };
        assert!(is_in(below.centre, ground) && is_in(above.centre, upper));
        assert_eq!(apart.cabins.len(), 2, "a cabin on each level");
    }

    #[test]
    fn a_graph_of_one_level_stays_as_it_is() {
        for level in ["", ", Level: L1"] {
            let text = format!(
                "Vertices:\n- {{Id: 1, X: 1, Y: 1, Theta: 0{level}}}\n\
                 - {{Id: 2, X: 5, Y: 1, Theta: 0}}\nEdges:\n- {{Id: 1, Origin_ID: 1, \
                 Destination_ID: 2, CurveType: Linear, VelocityForward: 1}}\n"
            );
            let original = graph(&text);
            let apart = Apart::new(&original);
            assert!(matches!(apart.graph, Cow::Borrowed(_)) && apart.levels.is_empty());
        }
    }

    #[test]
    fn nodes_on_no_level_and_ramps_have_their_places_too() {
        let text = "Vertices:\n- {Id: 1, X: 0, Y: 0, Theta: 0, Level: L1}\n\
            - {Id: 2, X: 5, Y: 0, Theta: 0, Level: L2}\n- {Id: 3, X: 9, Y: 0, Theta: 0}\n\
            Edges:\n- {Id: 1, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, \
            VelocityForward: 1}\n\
            - {Id: 2, Origin_ID: 2, Destination_ID: 3, CurveType: Linear, VelocityForward: 1}\n\
            Background:\n- {Line: [[0, 1], [5, 1]]}\n- {Line: [[0, 2], [5, 2]], Level: L2}\n";
        let original = graph(text);
        let apart = Apart::new(&original);
        let names: Vec<_> = apart.levels.iter().map(|level| &*level.name).collect();
        assert_eq!(names, ["L1", "L2", NO_LEVEL]);
        let [ramp, other] = apart.graph.edges() else { panic!("two edges") };
        assert_eq!(
            ramp.path.start(),
            apart.graph.nodes()[0].position,
            "on the level of its origin"
        );
        assert_eq!(other.path.start(), apart.graph.nodes()[1].position);
        let levels: Vec<_> =
            apart.graph.background().iter().map(|line| line.level.as_deref()).collect();
        assert_eq!(levels, [Some("L1"), Some("L2"), Some("L2")]);
        let corners = apart.bounds();
        assert!(apart.levels.iter().all(|level| level.low.x >= corners.min_x));
    }
}
