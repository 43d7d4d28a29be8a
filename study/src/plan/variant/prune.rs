//! Loads without the nodes that are cut off from the roads.

use std::collections::BTreeSet;

use serde_json::Value;

use super::roads::{STOPS, group_names, label};
use crate::plan::scenario::Load;

/// The part of a load of which all nodes are left out.
pub(super) struct Lost(pub(super) String);

/// Takes nodes out of a load. Returns the generators that have lost all of their stops, in words:
/// they are taken out, too.
pub(super) fn prune(load: &mut Load, left_out: &BTreeSet<String>) -> Result<Vec<String>, Lost> {
    if let Some(Value::Object(groups)) = load.rest.get_mut("groups") {
        for (name, nodes) in groups {
            prune_list(&format!("group {name}"), nodes, left_out)?;
        }
    }
    prune_storages(load, left_out)?;
    let groups = group_names(load);
    prune_stations(load, &groups, left_out);
    prune_stops(load, &groups, left_out)?;
    let Some(generators) = &mut load.generators else { return Ok(Vec::new()) };
    let (mut kept, mut lost, mut error) = (Vec::new(), Vec::new(), None);
    for (mut generator, number) in std::mem::take(generators).into_iter().zip(1..) {
        match prune_stops(&mut generator, &groups, left_out) {
            Ok(()) => kept.push(generator),
            Err(reason) => {
                lost.push(format!(
                    "generator {number} of the load, to whose stops robots can't drive and back"
                ));
                error = error.or(Some(reason));
            }
        }
    }
    *generators = kept;
    match error.filter(|_| generators.is_empty()) {
        Some(error) => Err(error),
        None => Ok(lost),
    }
}

/// Takes nodes out of the lists of storages.
fn prune_storages(load: &mut Load, left_out: &BTreeSet<String>) -> Result<(), Lost> {
    let Some(Value::Array(storages)) = load.rest.get_mut("storages") else { return Ok(()) };
    for (storage, number) in storages.iter_mut().zip(1..) {
        for key in ["at", "full"] {
            let Some(nodes) = storage.get_mut(key) else { continue };
            let lost = prune_list(&format!("storage {number}"), nodes, left_out);
            // No place may be full.
            if key == "at" {
                lost?;
            }
        }
    }
    Ok(())
}

/// Takes nodes out of the stops of a generator. `groups` are the names of groups of nodes.
fn prune_stops(
    load: &mut Load,
    groups: &BTreeSet<String>,
    left_out: &BTreeSet<String>,
) -> Result<(), Lost> {
    for key in STOPS {
        let Some(nodes) = load.rest.get_mut(key) else { continue };
        prune_nodes(key, nodes, groups, left_out)?;
    }
    for nodes in load.rest.get_mut("via").and_then(Value::as_array_mut).into_iter().flatten() {
        prune_nodes("via", nodes, groups, left_out)?;
    }
    if let Some(Value::Object(stations)) = load.dwell.as_mut().and_then(|dwell| dwell.get_mut("at"))
    {
        stations.retain(|name, _| !left_out.contains(name));
    }
    prune_flows(load, groups, left_out)
}

/// Takes flows out that have lost an end.
fn prune_flows(
    load: &mut Load,
    groups: &BTreeSet<String>,
    left_out: &BTreeSet<String>,
) -> Result<(), Lost> {
    let Some(Value::Array(flows)) = load.rest.get_mut("flows") else { return Ok(()) };
    let (mut kept, mut error) = (Vec::new(), None);
    for mut flow in std::mem::take(flows) {
        match prune_ends(&mut flow, groups, left_out) {
            Ok(()) => kept.push(flow),
            Err(reason) => error = error.or(Some(reason)),
        }
    }
    *flows = kept;
    error.filter(|_| flows.is_empty()).map_or(Ok(()), Err)
}

fn prune_ends(
    flow: &mut Value,
    groups: &BTreeSet<String>,
    left_out: &BTreeSet<String>,
) -> Result<(), Lost> {
    for key in ["from", "to"] {
        if let Some(nodes) = flow.get_mut(key) {
            prune_nodes(key, nodes, groups, left_out)?;
        }
    }
    Ok(())
}

/// Takes nodes out of the stations of a load, and stations without any.
fn prune_stations(load: &mut Load, groups: &BTreeSet<String>, left_out: &BTreeSet<String>) {
    let Some(Value::Array(stations)) = load.rest.get_mut("stations") else { return };
    stations.retain_mut(|station| {
        if let Some(queue) = station.get_mut("queue")
            && prune_list("queue", queue, left_out).is_err()
            && let Some(keys) = station.as_object_mut()
        {
            keys.remove("queue");
        }
        let at = station.get_mut("at");
        at.is_none_or(|nodes| prune_nodes("at", nodes, groups, left_out).is_ok())
    });
}

/// Takes nodes out of a list, or of a field that names one node or a group.
fn prune_nodes(
    key: &str,
    nodes: &mut Value,
    groups: &BTreeSet<String>,
    left_out: &BTreeSet<String>,
) -> Result<(), Lost> {
    prune_list(key, nodes, left_out)?;
    let name = label(nodes);
    if !nodes.is_array() && left_out.contains(&name) && !groups.contains(&name) {
        return Err(Lost(format!("{key}: {name}")));
    }
    Ok(())
}

/// Takes nodes out of a list. Other values name no nodes one by one.
fn prune_list(name: &str, nodes: &mut Value, left_out: &BTreeSet<String>) -> Result<(), Lost> {
    let Value::Array(nodes) = nodes else { return Ok(()) };
    let was_empty = nodes.is_empty();
    nodes.retain(|node| !left_out.contains(&label(node)));
    if !nodes.is_empty() || was_empty {
        return Ok(());
    }
    Err(Lost(name.to_owned()))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    /// Returns a load without the nodes `X` and `Y`.
    fn pruned(load: Value) -> Value {
        let mut load: Load = serde_json::from_value(load).expect("a load");
        let left_out = ["X", "Y"].into_iter().map(str::to_owned).collect();
        assert!(prune(&mut load, &left_out).is_ok_and(|lost| lost.is_empty()));
        serde_json::to_value(load).expect("JSON")
    }

    #[test]
    fn stations_flows_and_dwell_times_lose_nodes_that_are_cut_off() {
        let load = json!({
            "flows": [{"from": "A", "to": "X"}, {"from": "A", "to": ["B", "Y"], "share": 2}],
            "dwell": {"pick": 5, "at": {"X": 9, "B": 7}},
            "stations": [
                {"at": ["X", "A"], "operators": 1}, {"at": "Y", "operators": 2},
                {"at": "B", "queue": ["X", "Q"]}, {"at": "C", "queue": ["Y"]},
            ],
        });
        let expected = json!({
            "flows": [{"from": "A", "to": ["B"], "share": 2}],
            "dwell": {"pick": 5, "at": {"B": 7}},
            "stations": [
                {"at": ["A"], "operators": 1}, {"at": "B", "queue": ["Q"]}, {"at": "C"},
            ],
        });
        assert_eq!(pruned(load), expected);
    }

    #[test]
    fn a_generator_that_loses_a_stop_between_is_left_out() {
        let load = json!({"generators": [{"via": ["X"]}, {"via": ["B", "X"]}, {"via": ["B"]}]});
        let mut load: Load = serde_json::from_value(load).expect("a load");
        let lost = prune(&mut load, &BTreeSet::from(["X".to_owned()]));
        assert!(lost.is_ok_and(|lost| lost.len() == 2));
        assert_eq!(load.generators.map(|generators| generators.len()), Some(1));
    }
}
