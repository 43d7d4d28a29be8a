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
    /// Sets the layout, of which only the main part is used.
    ///
    /// # Errors
    /// [`PlanError::NoWayBack`] if robots can't come back anywhere, or as
    /// [`keep_load`](Self::keep_load).
    pub(super) fn set_roads(&mut self, graph: &RouteGraph) -> Result<(), PlanError> {
        let Some(main) = MainPart::of(graph) else {
            return Err(PlanError::NoWayBack { file: self.file.clone() });
        };
        let labels = labels(graph).difference(&labels(&main.graph)).cloned().collect();
        self.left_out.extend(main.left_out.iter().map(ToString::to_string));
        self.graph = Arc::new(main.graph);
        self.keep_load(&labels)
    }

    /// Changes edges of the layout, by their ids.
    ///
    /// # Errors
    /// [`PlanError::Change`] if an edge can't be changed, or as for another layout.
    pub fn change(&mut self, ids: &[u32], change: EdgeChange) -> Result<(), PlanError> {
        let changes: Vec<_> = ids.iter().map(|id| (*id, change)).collect();
        match self.graph.with_changes(&changes) {
            Ok(graph) => self.set_roads(&graph),
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
    for key in ["from", "to", "among"] {
        if let Some(nodes) = load.rest.get_mut(key) {
            prune_list(key, nodes, left_out)?;
        }
    }
    let generators = load.generators.iter_mut().flatten();
    generators.into_iter().try_for_each(|generator| prune(generator, left_out))
}

/// Takes nodes out of a list. Other values name no nodes one by one.
fn prune_list(name: &str, nodes: &mut Value, left_out: &BTreeSet<String>) -> Result<(), PlanError> {
    let Value::Array(nodes) = nodes else { return Ok(()) };
    let was_empty = nodes.is_empty();
    nodes.retain(|node| !left_out.contains(&label(node)));
    if !nodes.is_empty() || was_empty {
        return Ok(());
    }
    Err(PlanError::setting(
        format!("load, {name}"),
        "all of its nodes are cut off from the other roads: connect them, or `regatta graph check \
         --traffic` shows more",
    ))
}

fn label(node: &Value) -> String {
    node.as_str().map_or_else(|| node.to_string(), str::to_owned)
}
