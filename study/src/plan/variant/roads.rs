//! The roads of a variant: the main part of its layout. What is cut off from it can't take part,
//! and is left out of the layout and of the load.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use regatta_layout::traffic::{CutOff, MainPart};
use regatta_layout::{EdgeChange, NodeIndex, Role, RouteGraph};
use serde_json::Value;

use super::Variant;
use super::prune::{Lost, prune};
use crate::plan::PlanError;
use crate::plan::scenario::Load;

/// The keys of a load with stops.
pub(super) const STOPS: [&str; 3] = ["from", "to", "among"];

impl Variant {
    /// Sets the roads: the main part of the whole layout, which is that with the most stops that
    /// the load names.
    ///
    /// # Errors
    /// [`PlanError::NoWayBack`] if robots can't come back anywhere, [`PlanError::NoStation`] if no
    /// station of a role that the load names is left, or as [`keep_load`](Self::keep_load).
    pub(in crate::plan) fn set_roads(&mut self) -> Result<(), PlanError> {
        let mut named = self.setup.load.as_ref().map(named_labels).unwrap_or_default();
        named.extend(self.day.iter().flat_map(|day| day.stops.iter().cloned()));
        let wanted = nodes_of(&self.whole, &named);
        let Some(main) = MainPart::around(&self.whole, &wanted) else {
            return Err(PlanError::NoWayBack { file: self.file.clone() });
        };
        let labels: BTreeSet<String> =
            labels(&self.whole).difference(&labels(&main.graph)).cloned().collect();
        self.left_out_stops = possible_stops(&self.whole, &wanted)
            .filter(|node| main.cut_off.contains_key(node))
            .map(|node| self.whole.node(node).id)
            .collect();
        self.left_out = main.left_out.iter().map(ToString::to_string).collect();
        self.left_out.extend_from_slice(&self.unread);
        self.graph = Arc::new(main.graph);
        self.keep_day(&labels, &main.cut_off)?;
        self.keep_load(&labels)?;
        self.check_roles()
    }

    /// Changes edges of the layout, by their ids.
    ///
    /// # Errors
    /// [`PlanError::Change`] if an edge can't be changed, or as for another layout.
    pub fn change(&mut self, ids: &[u32], change: EdgeChange) -> Result<(), PlanError> {
        let changes: Vec<_> = ids.iter().map(|id| (*id, change)).collect();
        match self.whole.with_changes(&changes) {
            Ok(graph) => self.set_whole(graph),
            Err(error) => Err(PlanError::Change { file: self.file.clone(), error }),
        }
    }

    /// The whole layout, with what is cut off.
    pub fn whole(&self) -> &RouteGraph {
        &self.whole
    }

    /// Replaces the whole layout by one with the same stations, or more of them.
    ///
    /// # Errors
    /// As for another layout.
    pub fn set_whole(&mut self, graph: RouteGraph) -> Result<(), PlanError> {
        self.whole = Arc::new(graph);
        self.set_roads()?;
        // Other stations may be cut off now.
        if self.is_load_made_up {
            self.make_load_up();
        }
        Ok(())
    }

    /// Checks that no stop of the day is left out, by their names and ids.
    fn keep_day(
        &self,
        left_out: &BTreeSet<String>,
        cut_off: &BTreeMap<NodeIndex, CutOff>,
    ) -> Result<(), PlanError> {
        let Some(day) = &self.day else { return Ok(()) };
        let mut stops = Vec::new();
        for stop in day.stops.intersection(left_out) {
            let nodes = nodes_of(&self.whole, &BTreeSet::from([stop.clone()]));
            let found = nodes.iter().find_map(|node| cut_off.get(node));
            // No node serves a station without one.
            stops.push((stop.clone(), found.copied().unwrap_or(CutOff::Apart)));
        }
        match stops.is_empty() {
            true => Ok(()),
            false => Err(PlanError::CutOffStops {
                day: day.file.clone(),
                stops,
                file: self.file.clone(),
            }),
        }
    }

    /// Checks that a load that was given still has nodes of the roles that it names as stops.
    ///
    /// # Errors
    /// [`PlanError::NoStation`] for the first role without a node.
    fn check_roles(&self) -> Result<(), PlanError> {
        let Some(load) = self.setup.load.as_ref().filter(|_| !self.is_load_made_up) else {
            return Ok(());
        };
        let (named, groups) = (named_labels(load), group_names(load));
        let [whole, kept] = [&self.whole, &self.graph].map(|graph| graph.purposes());
        for role in [Role::Pick, Role::Drop, Role::Park, Role::Charge] {
            let name = role.name();
            let is_lost = has_role(&whole, role) && !has_role(&kept, role);
            if is_lost && named.contains(name) && !groups.contains(name) {
                return Err(PlanError::NoStation { file: self.file.clone(), role: name });
            }
        }
        Ok(())
    }

    /// Takes nodes that are left out, by their names and ids, out of the groups of the load.
    ///
    /// # Errors
    /// [`PlanError::CutOff`] if nothing is left of a group, or of all generators.
    fn keep_load(&mut self, left_out: &BTreeSet<String>) -> Result<(), PlanError> {
        let Some(load) = &mut self.setup.load else { return Ok(()) };
        match prune(load, left_out) {
            Ok(generators) => self.left_out.extend(generators),
            Err(Lost(part)) => return Err(PlanError::CutOff { file: self.file.clone(), part }),
        }
        Ok(())
    }
}

/// Returns the nodes where orders may have stops: those that a load names, those with a role, and
/// those of stations.
fn possible_stops(
    graph: &RouteGraph,
    named: &[NodeIndex],
) -> impl Iterator<Item = NodeIndex> + use<> {
    let with_role = (0..).map(NodeIndex).zip(graph.nodes());
    let with_role = with_role.filter(|(_, node)| node.role != Role::None).map(|(index, _)| index);
    let of_stations = graph.stations().iter().flat_map(|station| station.nodes.iter().copied());
    let stops: BTreeSet<NodeIndex> =
        with_role.chain(of_stations).chain(named.iter().copied()).collect();
    stops.into_iter()
}

/// Returns the labels by which a load names nodes: their names and ids, and the names of stations.
fn labels(graph: &RouteGraph) -> BTreeSet<String> {
    let ids = graph.nodes().iter().map(|node| node.id.to_string());
    let names = graph.nodes().iter().filter_map(|node| node.name().map(str::to_owned));
    let others = graph.nodes().iter().flat_map(|node| node.other_names());
    let stations = graph.stations().iter().flat_map(|station| station.names());
    ids.chain(names).chain(others).chain(stations.map(str::to_owned)).collect()
}

/// Returns the nodes with some labels: ids, names of nodes or names of stations.
fn nodes_of(graph: &RouteGraph, labels: &BTreeSet<String>) -> Vec<NodeIndex> {
    let mut nodes = BTreeSet::new();
    for (node, index) in graph.nodes().iter().zip((0..).map(NodeIndex)) {
        let is_named = node.name().is_some_and(|name| labels.contains(name))
            || node.other_names().iter().any(|name| labels.contains(name));
        if is_named || labels.contains(&node.id.to_string()) {
            nodes.insert(index);
        }
    }
    for station in graph.stations() {
        if station.names().any(|name| labels.contains(name)) {
            nodes.extend(&station.nodes);
        }
    }
    nodes.into_iter().collect()
}

/// Returns the labels of nodes that a load names one by one, with some other words among them.
fn named_labels(load: &Load) -> BTreeSet<String> {
    let mut labels = BTreeSet::new();
    if let Some(Value::Object(groups)) = load.rest.get("groups") {
        for nodes in groups.values() {
            add_labels(nodes, &mut labels);
        }
    }
    for storage in storages(load) {
        if let Some(nodes) = storage.get("at") {
            add_labels(nodes, &mut labels);
        }
    }
    for load in std::iter::once(load).chain(load.generators.iter().flatten()) {
        for nodes in STOPS.iter().filter_map(|key| load.rest.get(*key)) {
            add_labels(nodes, &mut labels);
        }
    }
    labels
}

/// The entries of the storages of a load.
fn storages(load: &Load) -> impl Iterator<Item = &Value> {
    load.rest.get("storages").and_then(Value::as_array).into_iter().flatten()
}

fn add_labels(nodes: &Value, labels: &mut BTreeSet<String>) {
    match nodes {
        Value::Array(nodes) => labels.extend(nodes.iter().map(label)),
        node => {
            labels.insert(label(node));
        }
    }
}

/// Whether any node has a role. Loads are picked up and dropped where robots transfer them.
fn has_role(purposes: &[Role], role: Role) -> bool {
    purposes.iter().any(|purpose| match role {
        Role::Pick => purpose.is_pick(),
        Role::Drop => purpose.is_drop(),
        _ => *purpose == role,
    })
}

/// Returns the names of the groups of nodes of a load.
pub(super) fn group_names(load: &Load) -> BTreeSet<String> {
    match load.rest.get("groups") {
        Some(Value::Object(groups)) => groups.keys().cloned().collect(),
        _ => BTreeSet::new(),
    }
}

/// Returns a label of a node, as a text.
pub(super) fn label(node: &Value) -> String {
    node.as_str().map_or_else(|| node.to_string(), str::to_owned)
}
