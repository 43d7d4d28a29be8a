//! Navigation graphs of Open-RMF: YAML. The module [`building`] reads the maps of its traffic
//! editor, from which Open-RMF generates these graphs.
//!
//! Both are read into the same model ([`model`]): levels of vertices and of straight, directed
//! lanes.

pub(crate) mod building;
mod doors;
mod lifts;
mod model;
#[cfg(test)]
mod tests;
mod tree;
mod zones;

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec2;

use crate::model::facilities::Cabin;
use crate::model::finding::Report;
use crate::model::options::ReadOptions;
use crate::model::raw::RawDoorTimes;
use crate::model::value::shorten;
use crate::read::file::{Ignored, MAX_NAME, Source, SyntaxError};
use crate::read::layout::Layout;
use doors::DoorPlan;
use lifts::LiftPlan;
use model::{Building, Lane, Level, Vertex};
use tree::{Content, Tree};

/// Keys of the file that are used.
const FILE_KEYS: [&str; 3] = ["levels", "doors", "lifts"];

/// Reads a navigation graph.
pub(crate) fn read<'text>(
    source: Source<'text>,
    options: &ReadOptions,
    report: &mut Report<'text>,
) -> Result<Layout, SyntaxError> {
    let root = Tree::parse(source.text)?;
    if is_building(&root) {
        return building::read_tree(&root, options, report);
    }
    let mut ignored = Ignored::default();
    let mut building = Building::default();
    for (name, tree) in levels(&root, report)? {
        building.levels.push(Reader { report, ignored: &mut ignored }.level(name, tree));
    }
    ignore_unknown(&root, &FILE_KEYS, "the file", &mut ignored);
    let by_name: BTreeMap<String, usize> = building
        .levels
        .iter()
        .enumerate()
        .map(|(index, level)| (level.name.clone(), index))
        .collect();
    add_doors(&root, &by_name, &mut building, &mut ignored);
    add_lifts(&root, &mut building);
    ignored.report(report);
    Ok(building.into_layout(options, report))
}

/// Whether a file is a building map, whose vertices have a third coordinate. In old files without
/// `coordinate_system`, this is the only difference.
fn is_building(root: &Tree<'_>) -> bool {
    let levels = root.entries_of("levels");
    let first = levels.iter().find_map(|(_, level)| level.get("vertices")?.items().first());
    first.and_then(|vertex| vertex.items().get(2)).is_some_and(|third| third.number().is_some())
}

/// Returns the levels of a file.
fn levels<'a, 'text>(
    root: &'a Tree<'text>,
    report: &mut Report<'text>,
) -> Result<Vec<(&'a str, &'a Tree<'text>)>, SyntaxError> {
    let levels = root.get("levels").filter(|levels| !levels.entries().is_empty());
    let Some(levels) = levels else {
        return Err(SyntaxError::new(
            1,
            "it has no `levels`: a map of Open-RMF has a map of levels, with vertices and lanes",
        ));
    };
    let (short, long): (Vec<_>, Vec<_>) =
        levels.entries().iter().partition(|(name, _)| name.len() <= MAX_NAME);
    for (name, level) in long {
        let message = format!(
            "the name of the level `{}` is too long: at most {MAX_NAME} bytes",
            shorten(name)
        );
        report.file_error(level.at, message);
    }
    Ok(short.into_iter().map(|(name, level)| (name.as_str(), level)).collect())
}

/// Counts the unknown keys of a map, unless their values are empty.
fn ignore_unknown(map: &Tree<'_>, known: &[&str], owner: &str, ignored: &mut Ignored) {
    let is_unknown =
        |(key, value): &&(String, Tree<'_>)| !known.contains(&key.as_str()) && !value.is_empty();
    for (key, value) in map.entries().iter().filter(is_unknown) {
        ignored.add_key(value.key_at, key, owner);
    }
}

/// Adds the doors, and the lines of those without a lane to their levels.
fn add_doors(
    root: &Tree<'_>,
    by_name: &BTreeMap<String, usize>,
    building: &mut Building,
    ignored: &mut Ignored,
) {
    for (name, door) in root.entries_of("doors") {
        let map = door.text_of("map");
        let level = map.and_then(|map| by_name.get(&map));
        let level = level.and_then(|index| building.levels.get_mut(*index));
        let endpoints = door.items_of("endpoints");
        let line: Option<Vec<DVec2>> =
            endpoints.iter().map(|point| self::point(point.items())).collect();
        if let (Some(level), Some(line)) = (level, line.filter(|line| line.len() > 1)) {
            let line_of_door = [line[0], line[1]];
            if line_of_door.iter().all(|point| point.is_finite()) {
                let times = RawDoorTimes::default();
                let plan = DoorPlan { at: door.at, line: line_of_door, times };
                building.doors.insert(name.clone(), plan);
            }
            let has_lane = level.lanes.iter().any(|lane| lane.passes(name));
            level.lines.extend((!has_lane).then_some(line));
        } else {
            ignored.add(door.at, "door without two endpoints on a level");
        }
    }
}

/// Adds the lifts, and their outlines to each level that they serve.
fn add_lifts(root: &Tree<'_>, building: &mut Building) {
    for (name, lift) in root.entries_of("lifts") {
        let cabin = cabin(lift);
        building.lifts.insert(name.clone(), LiftPlan { at: lift.at, cabin, ..LiftPlan::default() });
    }
    for level in &mut building.levels {
        let served: BTreeSet<&str> = level.vertices.iter().filter_map(Vertex::lift).collect();
        let cabins = served.into_iter().filter_map(|lift| building.lifts.get(lift)?.cabin);
        level.lines.extend(cabins.map(|cabin| cabin.outline().into()));
    }
}

fn cabin(lift: &Tree<'_>) -> Option<Cabin> {
    let position = lift.get("position")?.items();
    let yaw = position.get(2).and_then(Tree::number).unwrap_or_default();
    let cabin = Cabin { centre: point(position)?, size: point(lift.get("dims")?.items())?, yaw };
    let is_finite = cabin.centre.is_finite() && cabin.size.is_finite() && yaw.is_finite();
    Some(cabin).filter(|cabin| is_finite && cabin.size.cmpgt(DVec2::ZERO).all())
}

/// Returns the point of a tuple that starts with two numbers.
fn point(tuple: &[Tree<'_>]) -> Option<DVec2> {
    match tuple {
        [x, y, ..] => Some(DVec2::new(x.number()?, y.number()?)),
        _ => None,
    }
}

/// The reader of vertices and lanes.
struct Reader<'a, 'text> {
    report: &'a mut Report<'text>,
    ignored: &'a mut Ignored,
}

impl Reader<'_, '_> {
    fn level(&mut self, name: &str, tree: &Tree<'_>) -> Level {
        let mut level = Level { at: tree.at, name: name.to_owned(), ..Level::default() };
        level.vertices =
            tree.items_of("vertices").iter().map(|vertex| self.vertex(vertex)).collect();
        for (index, lane) in tree.items_of("lanes").iter().enumerate() {
            level.lanes.extend(self.lane(index, lane, level.vertices.len()).into_iter().flatten());
        }
        ignore_unknown(tree, &["vertices", "lanes"], "a level", self.ignored);
        level
    }

    fn vertex(&mut self, tree: &Tree<'_>) -> Vertex {
        let items = tree.items();
        let position = point(items);
        if position.is_none() {
            let message = format!("a vertex is {}: expected [x, y, {{name: …}}]", tree.describe());
            self.report.file_error(tree.at, message);
        }
        let mut properties = self.properties(items.get(2), "a vertex");
        let name = properties.remove("name").unwrap_or_default();
        Vertex { at: tree.at, position, name, properties, is_kept: true }
    }

    /// Returns one lane, or two if it has both directions.
    fn lane(&mut self, index: usize, tree: &Tree<'_>, vertices: usize) -> Option<Vec<Lane>> {
        let ends = self.ends(tree, vertices, "lane")?;
        let mut properties = self.properties(tree.items().get(2), "a lane");
        let is_bidirectional =
            properties.remove("is_bidirectional").is_some_and(|value| value == "true");
        let lane = Lane { at: tree.at, index, is_reverse: false, ends, properties };
        Some(lane.directions(is_bidirectional))
    }

    /// Returns the two vertices of a lane, wall, door or measurement.
    fn ends(&mut self, tree: &Tree<'_>, vertices: usize, what: &str) -> Option<[usize; 2]> {
        let ends = match tree.items() {
            [start, end, ..] => start.index().zip(end.index()),
            _ => None,
        };
        match ends {
            None => {
                let message = format!(
                    "a {what} is {}: expected two indices of vertices and a map",
                    tree.describe()
                );
                self.report.file_error(tree.at, message);
                None
            }
            Some((start, end)) if start >= vertices || end >= vertices => {
                let message = format!(
                    "a {what} joins the vertices {start} and {end}, but its level has only \
                     {vertices}: correct the indices, which count from 0"
                );
                self.report.file_error(tree.at, message);
                None
            }
            Some((start, end)) => Some([start, end]),
        }
    }

    /// Returns the plain values of a map, or of `[type, value]` in it.
    fn properties(&mut self, map: Option<&Tree<'_>>, owner: &str) -> BTreeMap<String, String> {
        let mut properties = BTreeMap::new();
        for (key, value) in map.map(Tree::entries).unwrap_or_default() {
            match plain(value) {
                Some(text) => drop(properties.insert(key.clone(), text)),
                None if value.is_null() => {}
                None => self.ignored.add_key(value.at, key, owner),
            }
        }
        properties
    }
}

/// Returns the text of a plain value, or of a value with its type.
fn plain(value: &Tree<'_>) -> Option<String> {
    match &value.content {
        Content::List(typed) => match typed.as_slice() {
            [_, value] => value.text(),
            _ => None,
        },
        _ => value.text(),
    }
}

/// Exchanges the values of two properties.
fn exchange(properties: &mut BTreeMap<String, String>, one: &str, other: &str) {
    let (first, second) = (properties.remove(one), properties.remove(other));
    properties.extend(first.map(|value| (other.to_owned(), value)));
    properties.extend(second.map(|value| (one.to_owned(), value)));
}

impl Lane {
    /// Returns the lane, and the one in the opposite direction if it is bidirectional.
    fn directions(self, is_bidirectional: bool) -> Vec<Self> {
        let back = is_bidirectional.then(|| self.reversed());
        std::iter::once(self).chain(back).collect()
    }

    /// Returns the lane in the opposite direction.
    fn reversed(&self) -> Self {
        let [start, end] = self.ends;
        let mut properties = self.properties.clone();
        exchange(&mut properties, "dock_name", "undock_name");
        if let Some(orientation) = properties.get_mut("orientation_constraint") {
            match orientation.as_str() {
                "forward" => *orientation = "backward".to_owned(),
                "backward" => *orientation = "forward".to_owned(),
                _ => {}
            }
        }
        Self { at: self.at, index: self.index, is_reverse: true, ends: [end, start], properties }
    }
}
