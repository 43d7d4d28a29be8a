//! The zones of Open-RMF: mutex groups, and the cabins of lifts, which hold one robot.

use std::collections::BTreeMap;

use crate::model::tags::Tags;
use crate::model::zones::ZoneRule;
use crate::read::layout::{Layout, LayoutZone};

/// Returns the zones of all vertices and lanes that a mutex group or a lift names.
pub(super) fn zones(layout: &Layout) -> Vec<LayoutZone> {
    let mut zones = BTreeMap::new();
    for (index, node) in layout.nodes.iter().enumerate() {
        for name in names(&node.tags) {
            zone(&mut zones, name, node.at).nodes.push(index);
        }
    }
    for (index, edge) in layout.edges.iter().enumerate() {
        for name in names(&edge.tags) {
            zone(&mut zones, name, edge.at).edges.push(index);
        }
    }
    zones.into_values().collect()
}

/// Returns the names of the exclusive zones of a vertex or a lane.
fn names(tags: &Tags) -> impl Iterator<Item = String> {
    let mutex = property(tags, "mutex").or(property(tags, "in_mutex")).map(str::to_owned);
    let lift = property(tags, "lift").or(property(tags, "lift_cabin"));
    let lift = lift.map(|lift| format!("lift {lift}"));
    mutex.into_iter().chain(lift)
}

/// Returns the value of a property, unless it is empty.
fn property<'tags>(tags: &'tags Tags, key: &str) -> Option<&'tags str> {
    tags.properties.get(key).map(|value| &**value).filter(|value| !value.is_empty())
}

/// Returns the zone with a name, which is made if it is new.
fn zone(zones: &mut BTreeMap<String, LayoutZone>, name: String, at: u32) -> &mut LayoutZone {
    zones.entry(name).or_insert_with_key(|name| LayoutZone {
        at,
        name: name.clone(),
        rule: ZoneRule::EXCLUSIVE,
        nodes: Vec::new(),
        edges: Vec::new(),
    })
}
