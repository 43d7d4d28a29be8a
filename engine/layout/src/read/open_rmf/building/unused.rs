//! Counts, by kind, the content of a building map that routes don't need, such as pictures and the
//! simulation of physics.

use std::collections::BTreeSet;

use super::super::model::Level;
use super::super::tree::Tree;
use super::{Ignored, ignore_unknown};

/// Keys of the file that are used.
const FILE_KEYS: [&str; 5] =
    ["levels", "lifts", "coordinate_system", "parameters", "reference_level_name"];

/// Keys of a level that are used, or whose values are checked separately.
const LEVEL_KEYS: [&str; 9] = [
    "vertices",
    "lanes",
    "walls",
    "doors",
    "floors",
    "measurements",
    "fiducials",
    "models",
    "elevation",
];

/// Keys of a lift that are used.
const LIFT_KEYS: [&str; 11] = [
    "x",
    "y",
    "yaw",
    "width",
    "depth",
    "lowest_floor",
    "highest_floor",
    "level_doors",
    "reference_floor_name",
    "initial_floor_name",
    "doors",
];

/// Keys of vertices that name dispensers and ingestors.
const PLACE_KEYS: [&str; 2] = ["pickup_dispenser", "dropoff_ingestor"];

/// Counts the unused keys of the file and of its lifts.
pub(super) fn of_file(root: &Tree<'_>, ignored: &mut Ignored) {
    ignore_unknown(root, &FILE_KEYS, "the file", ignored);
    if let Some(parameters) = root.get("parameters") {
        ignore_unknown(parameters, &["generate_crs"], "the file's `parameters`", ignored);
    }
    for (_, lift) in root.entries_of("lifts") {
        ignore_unknown(lift, &LIFT_KEYS, "a lift", ignored);
    }
}

/// Counts the unused content of the levels.
pub(super) fn of_levels(trees: &[(&str, &Tree<'_>)], levels: &[Level], ignored: &mut Ignored) {
    let vertices = levels.iter().flat_map(|level| &level.vertices);
    let places: BTreeSet<&str> = vertices
        .flat_map(|vertex| PLACE_KEYS.into_iter().filter_map(|key| vertex.properties.get(key)))
        .map(String::as_str)
        .collect();
    for ((_, tree), level) in trees.iter().zip(levels) {
        of_level(tree, ignored);
        of_models(tree, &places, ignored);
        of_vertices(tree, level, ignored);
    }
}

fn of_level(tree: &Tree<'_>, ignored: &mut Ignored) {
    ignore_unknown(tree, &LEVEL_KEYS, "a level", ignored);
    if let Some(elevation) = tree.get("elevation").filter(|elevation| !elevation.is_empty()) {
        ignored.add_named(
            elevation.at,
            "key `elevation` of a level, except to find the levels of lifts",
        );
    }
    let tuples: [(&str, &str, &[&str]); 3] = [
        ("walls", "a wall", &[]),
        ("doors", "a door", &["name", "type", "motion_degrees"]),
        ("measurements", "a measurement", &["distance"]),
    ];
    for (key, owner, known) in tuples {
        for map in tree.items_of(key).iter().filter_map(|tuple| tuple.items().get(2)) {
            ignore_unknown(map, known, owner, ignored);
        }
    }
    for floor in tree.items_of("floors") {
        ignore_unknown(floor, &["vertices"], "a floor", ignored);
    }
}

/// Counts models that aren't stations, and unused keys of stations.
fn of_models(tree: &Tree<'_>, places: &BTreeSet<&str>, ignored: &mut Ignored) {
    for model in tree.items_of("models") {
        let name = model.text_of("name");
        if name.is_some_and(|name| places.contains(name.as_str())) {
            ignore_unknown(model, &["name", "x", "y"], "a dispenser or an ingestor", ignored);
        } else {
            ignored.add(model.at, "model that is neither a dispenser nor an ingestor");
        }
    }
}

/// Counts heights, and the names and properties of vertices without a node.
fn of_vertices(tree: &Tree<'_>, level: &Level, ignored: &mut Ignored) {
    let ends: BTreeSet<usize> = level.lanes.iter().flat_map(|lane| lane.ends).collect();
    for (index, (tuple, vertex)) in
        tree.items_of("vertices").iter().zip(&level.vertices).enumerate()
    {
        if tuple.items().get(2).and_then(Tree::number).is_some_and(|height| height != 0.0) {
            ignored.add(tuple.at, "third coordinate of a vertex");
        }
        if !ends.contains(&index) && !vertex.name.is_empty() {
            ignored.add(tuple.at, "name of a vertex without a lane");
        }
        for key in vertex.properties.keys().filter(|_| !ends.contains(&index)) {
            ignored.add_key(tuple.at, key, "a vertex without a lane");
        }
    }
}
