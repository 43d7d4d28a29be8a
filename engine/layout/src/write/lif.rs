//! Writes a graph as LIF 1.0.0 that is valid under the schema of the VDMA.

mod edges;
mod properties;

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec2;
use serde_json::{Map, Value, json};

use super::{Losses, is_straight};
use crate::model::format::Written;
use crate::model::route_graph::{Node, RouteGraph};
use crate::model::tags::{Role, Station};
use crate::read::lif::node::{role_of, roles};
use crate::read::lif::{Header, OWN_ID, OWN_VERSION};
use edges::Names;
use properties::{Kind, Properties};

/// An object of the file.
type Object = Map<String, Value>;

/// A layout of the file, which is a level.
#[derive(Debug, Default)]
struct Sheet {
    nodes: Vec<Object>,
    edges: Vec<Object>,
    stations: Vec<Object>,
}

/// The state of writing a graph.
struct Writer<'a> {
    graph: &'a RouteGraph,
    names: Names,
    losses: Losses,
    /// By level.
    sheets: BTreeMap<Option<&'a str>, Sheet>,
}

/// Writes a graph with the default [`Header`].
pub fn write(graph: &RouteGraph) -> Written {
    write_with(graph, &Header::default())
}

/// Writes a graph.
pub fn write_with(graph: &RouteGraph, header: &Header<'_>) -> Written {
    let names = Names::new(graph);
    let mut writer = Writer { graph, names, losses: Losses::default(), sheets: BTreeMap::new() };
    for (index, node) in graph.nodes().iter().enumerate() {
        writer.node(index, node);
    }
    writer.edges();
    for station in graph.stations() {
        writer.station(station);
    }
    writer.count_surroundings();
    let text = text(&writer.sheets, header);
    writer.losses.add_many(graph.zones().len(), "zones with a rule: LIF has none");
    writer.losses.add_many(graph.doors().len(), "doors: LIF has none");
    writer.losses.add_many(graph.lifts().len(), "lifts: only their edges are kept");
    Written { text, losses: writer.losses.into_lines() }
}

impl<'a> Writer<'a> {
    fn node(&mut self, index: usize, node: &'a Node) {
        let mut properties = Properties::new(node.tags.as_deref());
        let types = properties.vehicle_types();
        let mut shared = Object::new();
        if node.has_heading {
            shared.insert("theta".into(), node.theta.into());
        }
        if let Some(actions) = actions(node.role, &mut properties) {
            shared.insert("actions".into(), actions);
        }
        let mut object = Object::new();
        object.insert("nodeId".into(), self.names.nodes.ids[index].as_str().into());
        if let Some(name) = properties.name(self.names.nodes.are_names, node.name()) {
            object.insert("nodeName".into(), name.into());
        }
        properties.move_to(&mut object, "nodeDescription", Kind::Text);
        properties.move_to(&mut object, "mapId", Kind::Text);
        object.insert("nodePosition".into(), point(self.graph.origin() + node.position));
        object.insert("vehicleTypeNodeProperties".into(), for_each_type(&types, &shared));
        properties.count_losses("nodes", &mut self.losses);
        self.sheets.entry(level(node)).or_default().nodes.push(object);
    }

    fn station(&mut self, station: &'a Station) {
        let graph = self.graph;
        let Some(&first) = station.nodes.first() else {
            return self.losses.add("stations have no node: LIF has only stations with nodes");
        };
        let role = station
            .nodes
            .iter()
            .map(|node| graph.node(*node).role)
            .find(|role| *role != Role::None);
        if role.unwrap_or_default() != station.role {
            self.losses.add(
                "stations have another role than their nodes: LIF has only actions of nodes and \
                 edges",
            );
        }
        let mut properties = Properties::of(&station.properties);
        let ids = station.nodes.iter().map(|node| self.names.nodes.ids[node.0 as usize].as_str());
        let mut object = Object::new();
        object.insert("stationId".into(), station.name.as_str().into());
        object.insert("interactionNodeIds".into(), ids.collect());
        properties.move_to(&mut object, "stationName", Kind::Text);
        properties.move_to(&mut object, "stationDescription", Kind::Text);
        properties.move_to(&mut object, "stationHeight", Kind::NotNegative);
        if let Some(position) = station.position {
            let mut position = point(graph.origin() + position);
            if let Some(position) = position.as_object_mut() {
                properties.move_to(position, "theta", Kind::Number);
            }
            object.insert("stationPosition".into(), position);
        }
        properties.count_losses("stations", &mut self.losses);
        self.sheets.entry(level(graph.node(first))).or_default().stations.push(object);
    }

    /// Counts the losses of the graph as a whole.
    fn count_surroundings(&mut self) {
        let (nodes, edges) = (self.graph.nodes(), self.graph.edges());
        let background = self.graph.background().len();
        self.losses.add_many(background, "lines of the background: LIF has none");
        if self.sheets.len() > 1 {
            self.losses.add_many(
                nodes.iter().filter(|node| level(node).is_none()).count(),
                "nodes have no level, although others have one: in a layout of their own",
            );
        }
        if self.names.nodes.are_names
            && !nodes.iter().map(|node| node.id).eq(1..=nodes.len() as u32)
        {
            self.losses.add_many(nodes.len(), "numbers of nodes: their names are their ids");
        }
        if self.names.edges.are_names
            && !edges.iter().map(|edge| edge.id).eq(1..=edges.len() as u32)
        {
            self.losses.add_many(edges.len(), "numbers of edges: their names are their ids");
        }
    }
}

fn level(node: &Node) -> Option<&str> {
    node.tags.as_ref()?.level.as_deref()
}

fn point(position: DVec2) -> Value {
    json!({"x": position.x, "y": position.y})
}

/// Returns the actions of a property if they match the role; otherwise an action of the role.
fn actions(role: Role, properties: &mut Properties<'_>) -> Option<Value> {
    let names: &[&str] = match role {
        Role::None => &[],
        Role::Pick => &["pick"],
        Role::Drop => &["drop"],
        Role::Park => &["park"],
        Role::Charge => &["startCharging"],
        Role::Transfer => &["pick", "drop"],
    };
    let kept = properties.get("actions").unwrap_or_default();
    if (role == Role::None || role_of(&roles(kept)) == role)
        && let Some(actions) = properties.actions()
    {
        return Some(actions);
    }
    let actions = names.iter().map(|name| json!({"actionType": name, "blockingType": "HARD"}));
    (!names.is_empty()).then(|| actions.collect())
}

/// Repeats properties for each vehicle type.
fn for_each_type(types: &[&str], shared: &Object) -> Value {
    let mut list = Vec::with_capacity(types.len());
    for &id in types {
        let mut object = shared.clone();
        object.insert("vehicleTypeId".into(), id.into());
        list.push(Value::Object(object));
    }
    list.into()
}

/// Returns the text of the file, with a line for each node, edge and station.
fn text(sheets: &BTreeMap<Option<&str>, Sheet>, header: &Header<'_>) -> String {
    let meta = json!({
        "projectIdentification": header.project,
        "creator": header.creator,
        "exportTimestamp": header.timestamp,
        "lifVersion": "1.0.0",
    });
    let levels: BTreeSet<&str> = sheets.keys().copied().flatten().collect();
    let layouts: Vec<String> =
        sheets.iter().map(|(level, sheet)| layout(*level, sheet, &levels)).collect();
    format!("{{\"metaInformation\": {meta},\n\"layouts\": [{}]}}\n", layouts.join(",\n"))
}

fn layout(level: Option<&str>, sheet: &Sheet, levels: &BTreeSet<&str>) -> String {
    let mut id = level.unwrap_or(OWN_ID).to_owned();
    while level.is_none() && levels.contains(id.as_str()) {
        id.push('_');
    }
    let id = Value::from(id);
    let level = level
        .map(|level| format!(", \"layoutLevelId\": {}", Value::from(level)))
        .unwrap_or_default();
    let lists = [("nodes", &sheet.nodes), ("edges", &sheet.edges), ("stations", &sheet.stations)];
    let lists = lists.map(|(key, objects)| format!(",\n\"{key}\": [{}]", lines(objects))).concat();
    format!("{{\"layoutId\": {id}, \"layoutVersion\": \"{OWN_VERSION}\"{level}{lists}}}")
}

fn lines(objects: &[Object]) -> String {
    let mut text = String::new();
    for (index, object) in objects.iter().enumerate() {
        text.push_str(if index == 0 { "\n" } else { ",\n" });
        text.push_str(&json!(object).to_string());
    }
    text
}
