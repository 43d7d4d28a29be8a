//! The roads of a variant: the main part of its layout. What is cut off from it can't take part,
//! and is left out of the layout and of the load.

use std::collections::BTreeSet;
use std::sync::Arc;

use regatta_layout::traffic::MainPart;
use regatta_layout::{EdgeChange, RouteGraph};
use serde_json::Value;

use super::Variant;
use crate::plan::PlanError;
use crate::plan::scenario::Load;

impl Variant {
    /// Sets the roads: the main part of the whole layout.
    ///
    /// # Errors
    /// [`PlanError::NoWayBack`] if robots can't come back anywhere, or as
    /// [`keep_load`](Self::keep_load).
    pub(super) fn set_roads(&mut self) -> Result<(), PlanError> {
        let Some(main) = MainPart::of(&self.whole) else {
            return Err(PlanError::NoWayBack { file: self.file.clone() });
        };
        let labels = labels(&self.whole).difference(&labels(&main.graph)).cloned().collect();
        self.left_out = main.left_out.iter().map(ToString::to_string).collect();
        self.graph = Arc::new(main.graph);
        self.keep_load(&labels)
    }

    /// Changes edges of the layout, by their ids.
    ///
    /// # Errors
    /// [`PlanError::Change`] if an edge can't be changed, or as for another layout.
    pub fn change(&mut self, ids: &[u32], change: EdgeChange) -> Result<(), PlanError> {
        let changes: Vec<_> = ids.iter().map(|id| (*id, change)).collect();
        match self.whole.with_changes(&changes) {
            Ok(graph) => {
                self.whole = Arc::new(graph);
                self.set_roads()
            }
            Err(error) => Err(PlanError::Change { file: self.file.clone(), error }),
        }
    }

    /// Takes nodes that are left out, by their names and ids, out of the groups of the load.
    ///
    /// # Errors
    /// [`PlanError::Setting`] if nothing is left of a group.
    fn keep_load(&mut self, left_out: &BTreeSet<String>) -> Result<(), PlanError> {
        match &mut self.setup.load {
            Some(load) => prune(load, left_out),
            None => Ok(()),
        }
    }
}

/// Returns the labels by which a load names nodes: their names and ids.
fn labels(graph: &RouteGraph) -> BTreeSet<String> {
    let ids = graph.nodes().iter().map(|node| node.id.to_string());
    let names = graph.nodes().iter().filter_map(|node| node.name().map(str::to_owned));
    ids.chain(names).collect()
}

fn prune(load: &mut Load, left_out: &BTreeSet<String>) -> Result<(), PlanError> {
    if let Some(Value::Object(groups)) = load.rest.get_mut("groups") {
        for (name, nodes) in groups {
            prune_list(&format!("group {name}"), nodes, left_out)?;
        }
    }
    let groups: BTreeSet<String> = match load.rest.get("groups") {
        Some(Value::Object(groups)) => groups.keys().cloned().collect(),
        _ => BTreeSet::new(),
    };
    prune_stops(load, &groups, left_out)?;
    for generator in load.generators.iter_mut().flatten() {
        prune_stops(generator, &groups, left_out)?;
    }
    Ok(())
}

/// Takes nodes out of the stops of a generator. `groups` are the names of groups of nodes.
fn prune_stops(
    load: &mut Load,
    groups: &BTreeSet<String>,
    left_out: &BTreeSet<String>,
) -> Result<(), PlanError> {
    for key in ["from", "to", "among"] {
        let Some(nodes) = load.rest.get_mut(key) else { continue };
        prune_list(key, nodes, left_out)?;
        let name = label(nodes);
        if !nodes.is_array() && left_out.contains(&name) && !groups.contains(&name) {
            return Err(cut_off(&format!("{key}: {name}")));
        }
    }
    Ok(())
}

/// Takes nodes out of a list. Other values name no nodes one by one.
fn prune_list(name: &str, nodes: &mut Value, left_out: &BTreeSet<String>) -> Result<(), PlanError> {
    let Value::Array(nodes) = nodes else { return Ok(()) };
    let was_empty = nodes.is_empty();
    nodes.retain(|node| !left_out.contains(&label(node)));
    if !nodes.is_empty() || was_empty {
        return Ok(());
    }
    Err(cut_off(name))
}

fn cut_off(name: &str) -> PlanError {
    PlanError::setting(
        format!("load, {name}"),
        "all of its nodes are cut off from the other roads: connect them, or `regatta graph check \
         --traffic` shows more",
    )
}

fn label(node: &Value) -> String {
    node.as_str().map_or_else(|| node.to_string(), str::to_owned)
}
