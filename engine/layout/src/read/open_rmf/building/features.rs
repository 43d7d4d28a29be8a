//! Walls, floors, doors and lifts of a building map.

use std::collections::BTreeMap;

use glam::DVec2;

use super::super::doors::{self, DoorPlan};
use super::super::lifts::LiftPlan;
use super::super::model::{Building, Level};
use super::super::tree::Tree;
use super::super::{MAX_NAME, plain, point};
use super::{Points, Transforms};
use crate::model::facilities::Cabin;
use crate::model::finding::Report;
use crate::model::raw::RawDoorTimes;
use crate::model::value::shorten;

/// The largest number of comparisons of lanes with doors, or of vertices with lifts.
const MAX_COMPARISONS: usize = 100_000_000;

/// The largest number of shafts that are drawn: one for each lift on each level.
const MAX_SHAFTS: usize = 1_000_000;

/// The distance in metres between the cabin of a lift and its shaft, as in Open-RMF.
const SHAFT_GAP: f64 = 0.05;

/// The number of a lift's double sliding doors in the file.
const DOUBLE_SLIDING: f64 = 2.0;

/// Heights from level to level that differ by less than this, in metres, count as equal.
const EQUAL_HEIGHTS: f64 = 0.01;

/// Adds the walls and floors of a level, and sets the doors that its lanes pass. Returns the doors
/// by name.
pub(super) fn add(
    points: &Points<'_, '_>,
    level: &mut Level,
    report: &mut Report<'_>,
) -> BTreeMap<String, DoorPlan> {
    let tree = points.tree;
    add_doors(points, level, report);
    let walls = tree.items_of("walls").iter();
    let doors = tree.items_of("doors").iter().filter(|door| !is_on_lane(door, level));
    let floors = tree.items_of("floors");
    let lines: Vec<Option<Vec<DVec2>>> = walls
        .chain(doors)
        .map(|wall| line(wall.items().get(..2)?.iter(), level))
        .chain(floors.iter().map(|floor| outline(floor, level)))
        .collect();
    let total = lines.len();
    let lines: Vec<Vec<DVec2>> = lines.into_iter().flatten().collect();
    if lines.len() < total {
        let message = format!(
            "{} walls, doors or floors of level `{}` name vertices that don't exist: not used",
            total - lines.len(),
            level.name
        );
        report.file_warning(level.at, message);
    }
    level.lines =
        lines.into_iter().filter(|line| line.iter().all(|point| point.is_finite())).collect();
    let doors = tree.items_of("doors").iter();
    doors.filter_map(|door| door_plan(door, level)).collect()
}

/// Whether a lane leads through a door: one that opens, unlike those of the background.
fn is_on_lane(door: &Tree<'_>, level: &Level) -> bool {
    let name = door.items().get(2).and_then(|map| map.get("name")).and_then(plain);
    name.is_some_and(|name| level.lanes.iter().any(|lane| lane.passes(&name)))
}

/// Returns a door with its place in metres, and with the times that Open-RMF simulates.
fn door_plan(tree: &Tree<'_>, level: &Level) -> Option<(String, DoorPlan)> {
    let [start, end, map, ..] = tree.items() else { return None };
    let name = map.get("name").and_then(plain).filter(|name| !name.is_empty())?;
    let [from, to] = [level.vertices.get(start.index()?)?, level.vertices.get(end.index()?)?];
    let line = [from.position?, to.position?];
    let times = door_times(map, line[0].distance(line[1]));
    (name.len() <= MAX_NAME).then_some((name, DoorPlan { at: tree.at, line, times }))
}

/// Returns the times of a door by its type and its width in metres.
fn door_times(map: &Tree<'_>, width: f64) -> RawDoorTimes {
    let kind = map.get("type").and_then(plain).unwrap_or_default();
    let degrees = map.get("motion_degrees").and_then(plain).and_then(|text| text.parse().ok());
    let leaf = if kind.starts_with("double") { width / 2.0 } else { width };
    match kind.as_str() {
        "sliding" | "double_sliding" | "telescope" | "double_telescope" => {
            doors::times(doors::SLIDING_DOOR, leaf)
        }
        "hinged" | "double_hinged" => {
            let angle: f64 = degrees.unwrap_or(90.0);
            doors::times(doors::HINGED_DOOR, angle.to_radians().abs())
        }
        _ => RawDoorTimes::default(),
    }
}

/// Returns the line through vertices that are given by their indices.
fn line<'a>(corners: impl Iterator<Item = &'a Tree<'a>>, level: &Level) -> Option<Vec<DVec2>> {
    corners.map(|corner| level.vertices.get(corner.index()?)?.position).collect()
}

/// Returns the closed outline of a floor.
fn outline(floor: &Tree<'_>, level: &Level) -> Option<Vec<DVec2>> {
    let corners = floor.get("vertices")?.items();
    line(corners.iter().chain(corners.first()), level).filter(|line| line.len() > 2)
}

/// Sets the doors of lanes that cross them. It uses the coordinates of the file and the last of
/// several doors, as Open-RMF's generator does.
fn add_doors(points: &Points<'_, '_>, level: &mut Level, report: &mut Report<'_>) {
    let vertices = points.tree.items_of("vertices");
    let doors = points.tree.items_of("doors").iter();
    let doors: Vec<_> = doors.filter_map(|tree| door(tree, vertices, report)).collect();
    if doors.len().saturating_mul(level.lanes.len()) > MAX_COMPARISONS {
        let message = format!(
            "level `{}` has too many lanes and doors: doors aren't assigned to lanes",
            level.name
        );
        report.file_warning(level.at, message);
        return;
    }
    for lane in &mut level.lanes {
        let Some(path) = segment(lane.ends, vertices) else { continue };
        if let Some((_, name)) = doors.iter().rev().find(|(door, _)| intersect(path, *door)) {
            lane.properties.insert("door_name".to_owned(), name.clone());
        }
    }
}

fn segment([start, end]: [usize; 2], vertices: &[Tree<'_>]) -> Option<[DVec2; 2]> {
    Some([point(vertices.get(start)?.items())?, point(vertices.get(end)?.items())?])
}

/// Returns the segment and the name of a door.
fn door(
    tree: &Tree<'_>,
    vertices: &[Tree<'_>],
    report: &mut Report<'_>,
) -> Option<([DVec2; 2], String)> {
    let [start, end, map, ..] = tree.items() else { return None };
    let name = map.get("name").and_then(plain).filter(|name| !name.is_empty())?;
    if name.len() > MAX_NAME {
        warn_of_long_name(tree, "door", &name, report);
        return None;
    }
    Some((segment([start.index()?, end.index()?], vertices)?, name))
}

fn warn_of_long_name(tree: &Tree<'_>, what: &str, name: &str, report: &mut Report<'_>) {
    let message = format!(
        "the name of the {what} `{}` is longer than {MAX_NAME} bytes: not used",
        shorten(name)
    );
    report.file_warning(tree.at, message);
}

/// Whether two segments cross, with the tolerance of Open-RMF's generator for parallel segments.
fn intersect([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> bool {
    let (first, second, between) = (a - b, c - d, a - c);
    let determinant = first.perp_dot(second);
    if determinant.abs() < 0.01 {
        return false;
    }
    let t = between.perp_dot(second) / determinant;
    let u = -first.perp_dot(between) / determinant;
    (0.0..=1.0).contains(&t) && (0.0..=1.0).contains(&u)
}

/// Sets the lifts of vertices in their shafts. Adds the outlines of lifts to the levels that they
/// serve.
pub(super) fn add_lifts(
    root: &Tree<'_>,
    trees: &[(&str, &Tree<'_>)],
    transforms: &Transforms,
    building: &mut Building,
    report: &mut Report<'_>,
) {
    let levels = &mut building.levels;
    let lifts = root.entries_of("lifts");
    let reference = named_level(root, "reference_level_name", trees).unwrap_or(0);
    let vertices: usize = levels.iter().map(|level| level.vertices.len()).sum();
    let shafts = lifts.len().saturating_mul(trees.len());
    if shafts > MAX_SHAFTS || lifts.len().saturating_mul(vertices) > MAX_COMPARISONS {
        report.file_warning(
            0,
            "it has too many lifts and vertices: vertices aren't assigned to lifts",
        );
        return;
    }
    for (name, lift) in lifts {
        let [lowest, highest] = ["lowest_floor", "highest_floor"]
            .map(|key| named_level(lift, key, trees).map(|level| elevation(level, trees)));
        let range = lowest.unwrap_or(f64::NEG_INFINITY)..=highest.unwrap_or(f64::INFINITY);
        let has_doors = lift.get("level_doors").is_some_and(|doors| !doors.entries().is_empty());
        let home = named_level(lift, "reference_floor_name", trees).unwrap_or(reference);
        let Some(shaft) = shaft(lift, home, transforms) else {
            let message =
                format!("lift `{}` has no x, y, width and depth: not used", shorten(name));
            report.file_warning(lift.at, message);
            continue;
        };
        if !has_doors {
            continue;
        }
        if name.len() > MAX_NAME {
            warn_of_long_name(lift, "lift", name, report);
            continue;
        }
        let mut served = Vec::new();
        for (index, level) in levels.iter_mut().enumerate() {
            let elevation = elevation(index, trees);
            if range.contains(&elevation) {
                shaft.add_to(level, name);
                served.extend(level.has_stop_of(name).then_some(elevation));
            }
        }
        served.sort_by(f64::total_cmp);
        tell_uneven_heights(lift, name, &served, report);
        building.lifts.insert(name.clone(), lift_plan(lift, &shaft, &served));
    }
}

/// Tells that levels at some ascending elevations, in metres, aren't equally far apart, if so: all
/// rides of a lift take the same time.
fn tell_uneven_heights(lift: &Tree<'_>, name: &str, served: &[f64], report: &mut Report<'_>) {
    let heights = || served.windows(2).map(|pair| pair[1] - pair[0]);
    let lowest = heights().fold(f64::INFINITY, f64::min);
    let highest = heights().fold(0.0, f64::max);
    if highest - lowest < EQUAL_HEIGHTS {
        return;
    }
    let secs = doors::CABIN.secs(mean_height(served));
    let message = format!(
        "lift `{}`: its levels are {lowest:.2} to {highest:.2} m apart, but each ride from a level \
         to the next takes {secs:.1} s, the time for the mean",
        shorten(name)
    );
    report.assumption(lift.at, message);
}

/// Returns the mean height in metres from a level to the next, of ascending elevations.
fn mean_height(served: &[f64]) -> f64 {
    match served {
        [lowest, .., highest] => (highest - lowest) / (served.len() - 1) as f64,
        _ => 0.0,
    }
}

/// Returns a lift that serves levels at some ascending elevations, in metres, with the times that
/// Open-RMF simulates.
fn lift_plan(lift: &Tree<'_>, shaft: &Shaft, served: &[f64]) -> LiftPlan {
    let door = lift.entries_of("doors").first().map(|(_, door)| door);
    let width = door.and_then(|door| door.number_of("width"));
    let is_double = door.and_then(|door| door.number_of("door_type")) == Some(DOUBLE_SLIDING);
    let leaf = width.map(|width| if is_double { width / 2.0 } else { width });
    let secs = doors::CABIN.secs(mean_height(served));
    LiftPlan {
        at: lift.at,
        cabin: Some(shaft.cabin()),
        door_times: leaf.map(|leaf| doors::times(doors::SLIDING_DOOR, leaf)).unwrap_or_default(),
        // Without elevations the time is unknown.
        level_secs: Some(secs).filter(|secs| *secs > 0.0 && secs.is_finite()),
        home: lift.text_of("initial_floor_name"),
    }
}

/// Returns the index of the level that a key of a map names.
fn named_level(map: &Tree<'_>, key: &str, trees: &[(&str, &Tree<'_>)]) -> Option<usize> {
    let name = map.text_of(key)?;
    trees.iter().position(|(level, _)| *level == name)
}

/// Returns the elevation of a level in metres; 0 if the file gives none.
fn elevation(index: usize, trees: &[(&str, &Tree<'_>)]) -> f64 {
    trees.get(index).and_then(|(_, level)| level.number_of("elevation")).unwrap_or(0.0)
}

/// The shaft of a lift.
struct Shaft {
    centre: DVec2,
    size: DVec2,
    yaw: f64,
}

fn shaft(lift: &Tree<'_>, level: usize, transforms: &Transforms) -> Option<Shaft> {
    let centre = transforms.apply(level, DVec2::new(lift.number_of("x")?, lift.number_of("y")?));
    let size = DVec2::new(lift.number_of("width")?, lift.number_of("depth")?) + 2.0 * SHAFT_GAP;
    let yaw = lift.number_of("yaw").unwrap_or_default();
    Some(Shaft { centre, size, yaw }).filter(|shaft| shaft.centre.is_finite())
}

impl Shaft {
    fn add_to(&self, level: &mut Level, name: &str) {
        let turn = DVec2::from_angle(-self.yaw);
        for vertex in &mut level.vertices {
            let Some(position) = vertex.position else { continue };
            let inside = turn.rotate(position - self.centre).abs();
            if inside.cmple(self.size / 2.0).all() {
                vertex.properties.entry("lift".to_owned()).or_insert_with(|| name.to_owned());
            }
        }
        level.lines.push(self.cabin().outline().into());
    }

    fn cabin(&self) -> Cabin {
        Cabin { centre: self.centre, size: self.size - 2.0 * SHAFT_GAP, yaw: self.yaw }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_cross_or_touch() {
        let segment = |x0: f64, y0: f64, x1: f64, y1: f64| [DVec2::new(x0, y0), DVec2::new(x1, y1)];
        let door = segment(5.0, -1.0, 5.0, 1.0);
        assert!(intersect(segment(0.0, 0.0, 9.0, 0.0), door));
        assert!(intersect(segment(0.0, 0.0, 5.0, 1.0), door));
        assert!(!intersect(segment(0.0, 0.0, 4.9, 0.0), door));
        assert!(!intersect(segment(5.0, -9.0, 5.0, 9.0), door));
    }
}
