//! Maps of Open-RMF's traffic editor: levels drawn on pictures of floor plans, on a plane in
//! metres, or on the globe.
//!
//! The positions and lanes equal those of the navigation graphs that Open-RMF's own generator makes
//! of the map.

mod features;
mod transform;
mod unused;

use std::collections::BTreeMap;

use glam::DVec2;

use super::model::{Building, Lane, Level, Vertex};
use super::tree::Tree;
use super::{Ignored, MAX_NAME, Reader, Source, SyntaxError, ignore_unknown, levels, plain, point};
use crate::model::finding::Report;
use crate::model::options::ReadOptions;
use crate::model::value::shorten;
use crate::read::layout::Layout;
use transform::{CoordinateSystem, Transforms};

/// Reads a building map.
pub(crate) fn read<'text>(
    source: Source<'text>,
    options: &ReadOptions,
    report: &mut Report<'text>,
) -> Result<Layout, SyntaxError> {
    read_tree(&Tree::parse(source.text)?, options, report)
}

/// Reads a building map that has been parsed.
pub(super) fn read_tree<'text>(
    root: &Tree<'text>,
    options: &ReadOptions,
    report: &mut Report<'text>,
) -> Result<Layout, SyntaxError> {
    let trees = levels(root, report)?;
    let system = CoordinateSystem::of(root, &trees, report)?;
    let transforms = Transforms::new(root, &trees, system, report);
    let mut ignored = Ignored::default();
    let mut building = Building::default();
    for (index, (name, tree)) in trees.iter().enumerate() {
        let points = Points { tree, transforms: &transforms, index };
        let mut level = points.level(name, &mut Reader { report, ignored: &mut ignored });
        building.doors.extend(features::add(&points, &mut level, report));
        building.places.extend(points.places());
        building.levels.push(level);
    }
    unused::of_file(root, &mut ignored);
    unused::of_levels(&trees, &building.levels, &mut ignored);
    features::add_lifts(root, &trees, &transforms, &mut building, report);
    warn_of_graphs(&building.levels, report);
    ignored.report(report);
    Ok(building.into_layout(options, report))
}

/// The points of a level.
struct Points<'a, 'text> {
    tree: &'a Tree<'text>,
    transforms: &'a Transforms,
    /// The index of the level.
    index: usize,
}

impl<'a, 'text> Points<'a, 'text> {
    fn level(&self, name: &str, reader: &mut Reader<'_, 'text>) -> Level {
        let elevation = self.tree.number_of("elevation").unwrap_or(0.0);
        let mut level =
            Level { at: self.tree.at, name: name.to_owned(), elevation, ..Level::default() };
        level.vertices =
            self.tree.items_of("vertices").iter().map(|tree| self.vertex(tree, reader)).collect();
        for (index, tree) in self.tree.items_of("lanes").iter().enumerate() {
            if let Some(ends) = reader.ends(tree, level.vertices.len(), "lane") {
                let properties = reader.properties(tree.items().get(2), "a lane");
                let lane = Lane { at: tree.at, index, is_reverse: false, ends, properties };
                level.lanes.extend(with_docks(lane, &level.vertices, reader.ignored));
            }
        }
        level
    }

    fn vertex(&self, tree: &Tree<'_>, reader: &mut Reader<'_, 'text>) -> Vertex {
        let items = tree.items();
        let point = point(items).map(|point| self.transforms.apply(self.index, point));
        if point.is_none() {
            let message =
                format!("a vertex is {}: expected [x, y, z, name, {{…}}]", tree.describe());
            reader.report.file_error(tree.at, message);
        }
        Vertex {
            at: tree.at,
            position: point,
            name: items.get(3).and_then(Tree::text).unwrap_or_default(),
            properties: reader.properties(items.get(4), "a vertex"),
            is_kept: false,
        }
    }

    /// Returns the positions of models, by name.
    fn places(&self) -> impl Iterator<Item = (String, DVec2)> {
        self.tree.items_of("models").iter().filter_map(|model| {
            let point = DVec2::new(model.number_of("x")?, model.number_of("y")?);
            let place = self.transforms.apply(self.index, point);
            Some((model.get("name")?.text()?, place)).filter(|_| place.is_finite())
        })
    }
}

/// Returns the directions of a lane, with the docks at its ends, as Open-RMF's generator does.
fn with_docks(mut lane: Lane, vertices: &[Vertex], ignored: &mut Ignored) -> Vec<Lane> {
    let orientation = lane.properties.remove("orientation");
    lane.properties.extend(orientation.map(|value| ("orientation_constraint".to_owned(), value)));
    let is_bidirectional =
        lane.properties.remove("bidirectional").is_some_and(|value| is_true(&value));
    for (end, key) in lane.ends.into_iter().zip(["undock_name", "dock_name"]) {
        match vertices.get(end).and_then(|vertex| vertex.properties.get("dock_name")) {
            Some(dock) if dock.len() > MAX_NAME => {
                ignored.add(lane.at, format!("dock with a name of more than {MAX_NAME} bytes"));
            }
            dock => lane.properties.extend(dock.map(|dock| (key.to_owned(), dock.clone()))),
        }
    }
    lane.directions(is_bidirectional)
}

fn is_true(text: &str) -> bool {
    text.eq_ignore_ascii_case("true") || text == "1"
}

/// Returns a parameter of the map.
fn parameter(root: &Tree<'_>, name: &str) -> Option<String> {
    root.get("parameters")?.get(name).and_then(plain)
}

/// Warns if the lanes belong to several graphs, that is, to several fleets.
fn warn_of_graphs(levels: &[Level], report: &mut Report<'_>) {
    let mut graphs: BTreeMap<&str, usize> = BTreeMap::new();
    let mut first = None;
    for lane in levels.iter().flat_map(|level| &level.lanes) {
        first.get_or_insert(lane.at);
        let graph = lane.properties.get("graph_idx").map_or("0", String::as_str);
        *graphs.entry(graph).or_default() += 1;
    }
    if graphs.len() < 2 {
        return;
    }
    let graphs: Vec<_> = graphs
        .iter()
        .take(10)
        .map(|(graph, lanes)| format!("{} ({lanes} lanes)", shorten(graph)))
        .collect();
    let message = format!(
        "its lanes belong to {} graphs of different fleets: {}; all are read, with the property \
         `graph_idx`",
        graphs.len(),
        graphs.join(", ")
    );
    report.file_warning(first.unwrap_or_default(), message);
}
