//! The common model of navigation graphs and building maps: levels of vertices and lanes, in
//! metres.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use glam::DVec2;

use super::doors::DoorPlan;
use super::lifts::LiftPlan;
use super::{MAX_NAME, doors, lifts, zones};
use crate::model::finding::Report;
use crate::model::options::ReadOptions;
use crate::model::tags::{BackgroundLine, Orientation, Role, Tags};
use crate::model::value::shorten;
use crate::read::layout::{Layout, LayoutEdge, LayoutNode, LayoutStation};

/// Keys of vertices that are `false` by default. The value `false` is dropped.
const FLAGS: [&str; 4] =
    ["is_parking_spot", "is_holding_point", "is_charger", "is_passthrough_point"];

/// A building.
#[derive(Debug, Default)]
pub(super) struct Building {
    pub levels: Vec<Level>,
    /// The positions of dispensers and ingestors in metres, by name.
    pub places: BTreeMap<String, DVec2>,
    /// By name.
    pub doors: BTreeMap<String, DoorPlan>,
    /// By name.
    pub lifts: BTreeMap<String, LiftPlan>,
}

/// A level.
#[derive(Debug, Default)]
pub(super) struct Level {
    pub at: u32,
    pub name: String,
    /// In metres; 0 if the file gives none.
    pub elevation: f64,
    pub vertices: Vec<Vertex>,
    pub lanes: Vec<Lane>,
    /// Walls, doors and lifts, in metres.
    pub lines: Vec<Vec<DVec2>>,
}

/// A vertex. Its index in the level's list is that in the file.
#[derive(Debug, Default)]
pub(super) struct Vertex {
    pub at: u32,
    /// Metres; x to the east, y to the north.
    pub position: Option<DVec2>,
    pub name: String,
    /// By key, as text.
    pub properties: BTreeMap<String, String>,
    /// Whether the vertex becomes a node even without a lane.
    pub is_kept: bool,
}

/// A directed lane.
#[derive(Debug, Default)]
pub(super) struct Lane {
    pub at: u32,
    /// The index in the file's list, and whether this is its second direction.
    pub index: usize,
    pub is_reverse: bool,
    /// Indices of vertices, which exist.
    pub ends: [usize; 2],
    /// By key, as text.
    pub properties: BTreeMap<String, String>,
}

impl Building {
    /// Returns the layout of one level, or of all of them.
    pub fn into_layout(mut self, options: &ReadOptions, report: &mut Report<'_>) -> Layout {
        // Ids must not depend on the choice of the level.
        let ids = ids_of_vertices(&self.levels);
        let mut kept: Vec<(Level, Vec<String>)> =
            std::mem::take(&mut self.levels).into_iter().zip(ids).collect();
        if let Some(wanted) = &options.level {
            if !kept.iter().any(|(level, _)| level.name == *wanted) {
                let names: Vec<_> =
                    kept.iter().take(20).map(|(level, _)| shorten(&level.name)).collect();
                let message = format!(
                    "there is no level `{}`: use one of {}",
                    shorten(wanted),
                    names.join(", ")
                );
                report.file_error(0, message);
            }
            kept.retain(|(level, _)| level.name == *wanted);
        }
        let mut layout = Layout::default();
        let without_lanes = without_lanes(&kept);
        warn_of_levels(&kept, report);
        lifts::connect(&mut kept, &self.lifts, &mut layout, report);
        let elevations: BTreeMap<String, f64> =
            kept.iter().map(|(level, _)| (level.name.clone(), level.elevation)).collect();
        for (level, ids) in kept {
            level.add_to(&ids, &mut layout, report);
        }
        if let Some((at, message)) = without_lanes.filter(|_| !report.has_errors()) {
            report.file_error(at, message);
        }
        layout.stations = self.stations(&layout.nodes);
        doors::add(&self.doors, &mut layout);
        lifts::add(&self.lifts, &elevations, &mut layout);
        layout.zones = zones::zones(&layout);
        layout
    }

    /// Returns a station for each dispenser and each ingestor.
    fn stations(&self, nodes: &[LayoutNode]) -> Vec<LayoutStation> {
        let mut stations: BTreeMap<String, LayoutStation> = BTreeMap::new();
        for node in nodes {
            for (key, role) in [("pickup_dispenser", Role::Pick), ("dropoff_ingestor", Role::Drop)]
            {
                let Some(name) = node.tags.properties.get(key) else { continue };
                let station = stations.entry(name.to_string()).or_insert_with(|| LayoutStation {
                    at: node.at,
                    name: name.to_string(),
                    role,
                    position: self.places.get(&**name).copied(),
                    ..LayoutStation::default()
                });
                station.role = station.role.and(role);
                station.nodes.push(node.id.clone());
            }
        }
        stations.into_values().collect()
    }
}

/// Returns the place and the error of levels without a lane, if they have vertices.
fn without_lanes(levels: &[(Level, Vec<String>)]) -> Option<(u32, String)> {
    let (first, _) = levels.iter().find(|(level, _)| !level.vertices.is_empty())?;
    if levels.iter().any(|(level, _)| !level.lanes.is_empty()) {
        return None;
    }
    let names: Vec<_> = levels.iter().take(20).map(|(level, _)| shorten(&level.name)).collect();
    let message = format!(
        "no lanes on its levels ({}), so that robots can't drive: draw lanes between the vertices \
         in the traffic editor",
        names.join(", ")
    );
    Some((first.at, message))
}

fn warn_of_levels(levels: &[(Level, Vec<String>)], report: &mut Report<'_>) {
    let used: Vec<_> = levels.iter().filter(|(level, _)| !level.lanes.is_empty()).collect();
    let [(first, _), _, ..] = used.as_slice() else { return };
    let names: Vec<_> = used.iter().take(20).map(|(level, _)| shorten(&level.name)).collect();
    let message = format!(
        "its {} levels ({}) lie over each other; robots on different levels never touch: \
         `--level NAME` picks one",
        used.len(),
        names.join(", ")
    );
    report.file_warning(first.at, message);
}

impl Level {
    fn add_to(self, ids: &[String], layout: &mut Layout, report: &mut Report<'_>) {
        let Self { name: level, vertices, lanes, lines, .. } = self;
        let mut has_lane: Vec<bool> = vertices.iter().map(|vertex| vertex.is_kept).collect();
        for lane in &lanes {
            for end in lane.ends {
                has_lane[end] = true;
            }
        }
        warn_of_unused(&vertices, &has_lane, report);
        for lane in lanes {
            layout.edges.extend(lane.into_edge(&level, ids, report));
        }
        let used = vertices.into_iter().zip(ids).zip(has_lane).filter(|(_, has_lane)| *has_lane);
        layout
            .nodes
            .extend(used.map(|((vertex, id), _)| vertex.into_node(&level, id.clone(), report)));
        let lines = lines.into_iter();
        layout.background.extend(
            lines.map(|points| BackgroundLine { points, level: Some(level.as_str().into()) }),
        );
    }
}

/// Warns of vertices that have a purpose, but that no robot can reach. Most vertices without lanes
/// are corners of walls.
fn warn_of_unused(vertices: &[Vertex], has_lane: &[bool], report: &mut Report<'_>) {
    let without_lane = vertices.iter().zip(has_lane).filter(|(_, has_lane)| !**has_lane);
    let mut unused = without_lane.map(|(vertex, _)| vertex).filter(|vertex| vertex.has_purpose());
    let Some(first) = unused.next() else { return };
    let others = match unused.count() {
        0 => String::new(),
        count => format!(" (and {count} more)"),
    };
    let message = format!("vertex `{}` has no lane{others}: not used", shorten(&first.name));
    report.file_warning(first.at, message);
}

impl Level {
    /// Whether a lane leads to a vertex in the cabin of a lift.
    pub fn has_stop_of(&self, lift: &str) -> bool {
        let mut ends = self.lanes.iter().flat_map(|lane| lane.ends);
        ends.any(|end| self.vertices.get(end).and_then(Vertex::lift) == Some(lift))
    }
}

impl Vertex {
    fn role(&self) -> Role {
        if self.is("is_charger") {
            Role::Charge
        } else {
            let roles = [
                (property(&self.properties, "pickup_dispenser").is_some(), Role::Pick),
                (property(&self.properties, "dropoff_ingestor").is_some(), Role::Drop),
                (self.is("is_parking_spot"), Role::Park),
            ];
            let named = roles.into_iter().filter(|(is_named, _)| *is_named);
            named.fold(Role::None, |role, (_, other)| role.and(other))
        }
    }

    fn is(&self, key: &str) -> bool {
        self.properties.get(key).is_some_and(|value| value.eq_ignore_ascii_case("true"))
    }

    /// Whether the vertex is more than a corner of a wall.
    fn has_purpose(&self) -> bool {
        !self.name.is_empty() || self.role() != Role::None
    }

    /// Returns the name of the lift in which the vertex is.
    pub fn lift(&self) -> Option<&str> {
        let lift = self.properties.get("lift").or(self.properties.get("lift_cabin"))?;
        (!lift.is_empty()).then_some(lift)
    }

    fn into_node(self, level: &str, id: String, report: &mut Report<'_>) -> LayoutNode {
        let position = self.position.filter(|position| position.is_finite());
        if position != self.position {
            let message = format!("vertex `{id}` has no position: give finite numbers");
            report.file_error(self.at, message);
        }
        let role = self.role();
        let zone = zone(&self.properties, self.lift().map(|lift| format!("lift {lift}")));
        let mut tags = Tags { level: Some(level.into()), zone, ..Tags::default() };
        if !self.name.is_empty() && self.name != id {
            tags.name = Some(self.name.into());
        }
        for (key, value) in &self.properties {
            if !(FLAGS.contains(&key.as_str()) && value == "false") {
                tags.set(key, value);
            }
        }
        LayoutNode { at: self.at, id, position, heading: None, role, tags }
    }
}

/// Returns the value of a property unless it is empty.
fn property<'a>(properties: &'a BTreeMap<String, String>, key: &str) -> Option<&'a str> {
    properties.get(key).map(String::as_str).filter(|value| !value.is_empty())
}

/// Returns the mutex group. Without one, `other` is the zone, which only one robot can use at a
/// time.
fn zone(properties: &BTreeMap<String, String>, other: Option<String>) -> Option<Box<str>> {
    let mutex =
        properties.get("mutex").or(properties.get("in_mutex")).filter(|mutex| !mutex.is_empty());
    mutex.cloned().or(other).map(String::into_boxed_str)
}

impl Lane {
    /// Whether robots drive it backwards.
    pub fn is_backward(&self) -> bool {
        self.properties.get("orientation_constraint").is_some_and(|value| value == "backward")
    }

    /// Whether it leads through a door.
    pub fn passes(&self, door: &str) -> bool {
        self.properties.get("door_name").is_some_and(|name| name == door)
    }

    fn into_edge(self, level: &str, ids: &[String], report: &mut Report<'_>) -> Option<LayoutEdge> {
        let [origin, destination] = self.ends.map(|end| ids.get(end));
        let reverse = if self.is_reverse { "/reverse" } else { "" };
        let id = format!("{level}/{}{reverse}", self.index);
        let (origin, destination) = (origin?.clone(), destination?.clone());
        if origin == destination {
            report.file_warning(
                self.at,
                format!("lane `{id}` starts and ends at vertex `{origin}`: not used"),
            );
            return None;
        }
        let door = property(&self.properties, "door_name").map(|name| format!("door {name}"));
        let zone = zone(&self.properties, door);
        let mut tags = Tags { level: Some(level.into()), zone, ..Tags::default() };
        for (key, value) in self.properties.iter().filter(|(key, _)| *key != "speed_limit") {
            tags.set(key, value);
        }
        Some(LayoutEdge {
            speed: self.speed(report),
            orientation: self.orientation(&id, report),
            at: self.at,
            id,
            origin,
            destination,
            tags,
            ..LayoutEdge::default()
        })
    }

    /// Returns the speed limit; 0 means none.
    fn speed(&self, report: &mut Report<'_>) -> Option<f64> {
        let text = property(&self.properties, "speed_limit")?;
        match text.parse::<f64>() {
            Ok(speed) if speed >= 0.0 && speed.is_finite() => (speed > 0.0).then_some(speed),
            _ => {
                let message = format!(
                    "`speed_limit` is `{}`: no limit is used; give metres per second",
                    shorten(text)
                );
                report.assumption(self.at, message);
                None
            }
        }
    }

    fn orientation(&self, id: &str, report: &mut Report<'_>) -> Orientation {
        match self.properties.get("orientation_constraint").map(String::as_str) {
            Some("backward") => Orientation::Offset(PI),
            None | Some("" | "forward") => Orientation::Tangential,
            Some(other) => {
                let message = format!(
                    "lane `{id}` has the orientation `{}`: read as forward; use forward or \
                     backward",
                    shorten(other)
                );
                report.assumption(self.at, message);
                Orientation::Tangential
            }
        }
    }
}

/// Returns the ids of the vertices of each level: the name if it is unique, `LEVEL/NAME` if it is
/// unique on its level, and `LEVEL/INDEX` otherwise, or if the name is long.
fn ids_of_vertices(levels: &[Level]) -> Vec<Vec<String>> {
    let names = count(
        levels.iter().flat_map(|level| level.vertices.iter().map(|vertex| vertex.name.clone())),
    );
    let on_levels = count(levels.iter().flat_map(|level| {
        level.vertices.iter().map(|vertex| format!("{}/{}", level.name, vertex.name))
    }));
    let mut ids = Vec::new();
    for level in levels {
        let mut ids_of_level = Vec::new();
        for (index, Vertex { name, .. }) in level.vertices.iter().enumerate() {
            let on_level = format!("{}/{name}", level.name);
            // Each lane copies the ids of its ends.
            let is_short = !name.is_empty() && name.len() <= MAX_NAME;
            // A name may look like the id of another vertex.
            let is_id = names[name] == 1 && !on_levels.contains_key(name);
            ids_of_level.push(if is_short && is_id && !looks_like_index(name) {
                name.clone()
            } else if is_short && on_levels[&on_level] == 1 && !looks_like_index(&on_level) {
                on_level
            } else {
                format!("{}/{index}", level.name)
            });
        }
        ids.push(ids_of_level);
    }
    ids
}

fn count(names: impl Iterator<Item = String>) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for name in names {
        *counts.entry(name).or_default() += 1;
    }
    counts
}

/// Whether a name looks like `LEVEL/INDEX`.
fn looks_like_index(name: &str) -> bool {
    name.rsplit_once('/').is_some_and(|(_, index)| {
        !index.is_empty() && index.bytes().all(|byte| byte.is_ascii_digit())
    })
}
