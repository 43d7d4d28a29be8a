//! The ids of vertices: their names, if these are unique.

use std::collections::BTreeMap;

use super::MAX_NAME;
use super::model::{Level, Vertex};

/// Returns the ids of the vertices of each level: the name if it is unique, `LEVEL/NAME` if it is
/// unique on its level, and `LEVEL/INDEX` otherwise, or if the name is long.
pub(super) fn of_vertices(levels: &[Level]) -> Vec<Vec<String>> {
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
