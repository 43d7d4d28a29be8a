//! The ids of vertices: their names where these are unique.

use std::collections::BTreeMap;

use super::MAX_NAME;
use super::model::Level;

/// Returns the ids of the vertices of each level: the name, `LEVEL/NAME` if other levels have it
/// too, else `LEVEL/INDEX`, as where the name is long.
pub(super) fn of_vertices(levels: &[Level]) -> Vec<Vec<String>> {
    let names = count(
        levels.iter().flat_map(|level| level.vertices.iter().map(|vertex| vertex.name.clone())),
    );
    let on_levels = count(levels.iter().flat_map(|level| {
        level.vertices.iter().map(|vertex| format!("{}/{}", level.name, vertex.name))
    }));
    let is_single = |counts: &BTreeMap<String, usize>, name: &str| counts.get(name) == Some(&1);
    // Each lane has a copy of the ids of its ends.
    let is_short = |name: &str| !name.is_empty() && name.len() <= MAX_NAME;
    let id = |level: &Level, index: usize, name: &str| {
        let on_level = format!("{}/{name}", level.name);
        // A name may look like the id of another vertex.
        if is_single(&names, name)
            && !looks_like_index(name)
            && !on_levels.contains_key(name)
            && is_short(name)
        {
            name.to_owned()
        } else if is_single(&on_levels, &on_level) && !looks_like_index(&on_level) && is_short(name)
        {
            on_level
        } else {
            format!("{}/{index}", level.name)
        }
    };
    let ids = |level: &Level| {
        level
            .vertices
            .iter()
            .enumerate()
            .map(|(index, vertex)| id(level, index, &vertex.name))
            .collect()
    };
    levels.iter().map(ids).collect()
}

fn count(names: impl Iterator<Item = String>) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for name in names {
        *counts.entry(name).or_default() += 1;
    }
    counts
}

/// Whether a name may be `LEVEL/INDEX`.
fn looks_like_index(name: &str) -> bool {
    name.rsplit_once('/').is_some_and(|(_, index)| {
        !index.is_empty() && index.bytes().all(|byte| byte.is_ascii_digit())
    })
}
