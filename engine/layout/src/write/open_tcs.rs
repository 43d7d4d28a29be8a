//! The writer of plant models of openTCS, version 7, as its schema `model-7.0.0.xsd` requires.

mod paths;
#[cfg(test)]
mod tests;

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::io;

use glam::DVec2;
use quick_xml::writer::Writer;

use self::paths::{Scale, path_ends};
use super::Losses;
use crate::model::format::Written;
use crate::model::route_graph::RouteGraph;
use crate::model::tags::{Role, Station, Tags};
use crate::model::zones::ZoneRule;
use crate::read::open_tcs::{LENGTH, OWN};

type Xml = Writer<Vec<u8>>;

/// Writes a plant model.
///
/// Ids, names, levels, zones and roles that openTCS doesn't have are written as properties with the
/// prefix `regatta:`. Our reader reads them back.
pub fn write(graph: &RouteGraph) -> Written {
    let mut writer = ModelWriter::new(graph);
    let text = writer.model().expect("writing to a Vec never fails");
    let text = String::from_utf8(text).expect("all parts are UTF-8");
    writer.losses.add_many(graph.background().len(), "background lines: this format has none");
    let renamed = graph.zones().iter().filter(|zone| block_type(zone.rule).is_some());
    let renamed = renamed.filter(|zone| !writer.blocks.contains_key(&*zone.name)).count();
    let message = "zones get a number: points, paths or stations have their names";
    writer.losses.add_many(renamed, message);
    let several = graph.zones().iter().filter(|zone| block_type(zone.rule).is_none()).count();
    writer.losses.add_many(several, "zones for several robots: this format has none");
    writer.losses.add_many(graph.doors().len(), "doors: this format has none");
    writer.losses.add_many(graph.lifts().len(), "lifts: only their edges are kept");
    Written { text: text + "\n", losses: writer.losses.into_lines() }
}

struct ModelWriter<'graph> {
    graph: &'graph RouteGraph,
    /// By node.
    points: Vec<String>,
    /// By edge.
    paths: Vec<String>,
    /// By station.
    locations: Vec<String>,
    blocks: BTreeMap<String, Block>,
    scale: Scale,
    losses: Losses,
}

/// A block: a zone for one vehicle, or for one direction.
struct Block {
    kind: &'static str,
    members: Vec<String>,
}

impl<'graph> ModelWriter<'graph> {
    fn new(graph: &'graph RouteGraph) -> Self {
        // All objects of a model share one namespace.
        let mut taken = Taken::default();
        let mut points = Vec::with_capacity(graph.nodes().len());
        for node in graph.nodes() {
            let name = node.name().map_or_else(|| format!("Point-{:04}", node.id), str::to_owned);
            points.push(taken.unique(name));
        }
        let mut paths = Vec::with_capacity(graph.edges().len());
        for edge in graph.edges() {
            let [from, to] = [edge.origin, edge.destination].map(|node| &points[node.0 as usize]);
            let name = edge.name().map_or_else(|| format!("{from} --- {to}"), str::to_owned);
            paths.push(taken.unique(name));
        }
        let mut locations = Vec::with_capacity(graph.stations().len());
        for station in graph.stations() {
            locations.push(taken.unique(station.name.clone()));
        }
        let blocks = blocks(graph, &points, &paths, &mut taken);
        let scale = Scale::of(graph);
        Self { graph, points, paths, locations, blocks, scale, losses: Losses::default() }
    }

    fn model(&mut self) -> io::Result<Vec<u8>> {
        let mut xml = Writer::new_with_indent(Vec::new(), b' ', 4);
        xml.get_mut()
            .extend_from_slice(b"<?xml version=\"1.0\" encoding=\"UTF-8\" standalone=\"yes\"?>\n");
        let model = xml
            .create_element("model")
            .with_attributes([("version", "7.0.0"), ("name", "Regatta")]);
        model.write_inner_content(|xml| {
            self.write_points(xml)?;
            self.write_paths(xml)?;
            self.write_location_types(xml)?;
            self.write_locations(xml)?;
            self.write_blocks(xml)?;
            self.write_layout(xml)
        })?;
        Ok(xml.into_inner())
    }

    fn write_points(&mut self, xml: &mut Xml) -> io::Result<()> {
        let graph = self.graph;
        let mut outgoing: Vec<Vec<usize>> = vec![Vec::new(); graph.nodes().len()];
        for (index, edge) in graph.edges().iter().enumerate() {
            outgoing[path_ends(edge).origin.0 as usize].push(index);
        }
        for (index, node) in graph.nodes().iter().enumerate() {
            let position = millimetres(graph.origin() + node.position);
            self.losses.add_if(position.is_rounded, "nodes are moved to whole millimetres");
            let kind = if node.role == Role::Park { "PARK_POSITION" } else { "HALT_POSITION" };
            let mut properties = own_properties(node.id, node.tags.as_deref());
            if ![Role::None, Role::Park].contains(&node.role) {
                self.losses.add(
                    "nodes have a role other than park: it is kept as property `regatta:role`",
                );
                properties.push((format!("{OWN}role").into(), node.role.name().into()));
            }
            self.count_tags(node.tags.as_deref());
            let angle = if node.has_heading {
                node.theta.to_degrees().to_string()
            } else {
                "NaN".to_owned()
            };
            let attributes = [
                ("name", self.points[index].as_str()),
                ("positionX", &position.x),
                ("positionY", &position.y),
                ("positionZ", "0"),
                ("vehicleOrientationAngle", &angle),
                ("type", kind),
            ];
            element(xml, "point", &attributes, |xml| {
                let size = [("length", "1000"), ("width", "1000"), ("height", "1000")];
                let offset = [("referenceOffsetX", "0"), ("referenceOffsetY", "0")];
                empty(xml, "maxVehicleBoundingBox", &[size.as_slice(), &offset].concat())?;
                for &path in &outgoing[index] {
                    empty(xml, "outgoingPath", &[("name", &self.paths[path])])?;
                }
                write_properties(xml, &properties)?;
                empty(
                    xml,
                    "pointLayout",
                    &[("labelOffsetX", "-10"), ("labelOffsetY", "-20"), ("layerId", "0")],
                )
            })?;
        }
        Ok(())
    }

    fn write_location_types(&self, xml: &mut Xml) -> io::Result<()> {
        let types: BTreeMap<_, _> = self
            .graph
            .stations()
            .iter()
            .map(|station| (type_name(station), (station.role, operations(station))))
            .collect();
        for (name, (role, operations)) in types {
            element(xml, "locationType", &[("name", name)], |xml| {
                for operation in operations {
                    empty(xml, "allowedOperation", &[("name", operation)])?;
                }
                empty(xml, "locationTypeLayout", &[("locationRepresentation", symbol(role))])
            })?;
        }
        Ok(())
    }

    fn write_locations(&mut self, xml: &mut Xml) -> io::Result<()> {
        for (index, station) in self.graph.stations().iter().enumerate() {
            let at = self.station_position(station);
            let position = millimetres(self.graph.origin() + at);
            self.losses.add_if(position.is_rounded, "stations are moved to whole millimetres");
            let attributes = [
                ("name", self.locations[index].as_str()),
                ("positionX", &position.x),
                ("positionY", &position.y),
                ("positionZ", "0"),
                (
                    "locked",
                    if station.properties.contains_key("locked") { "true" } else { "false" },
                ),
                ("type", type_name(station)),
            ];
            let mut properties = given(&station.properties, &["type", "operations", "locked"]);
            if self.locations[index] != station.name {
                properties.push((format!("{OWN}name").into(), station.name.as_str().into()));
            }
            let linked: BTreeSet<_> =
                station.nodes.iter().map(|node| &self.points[node.0 as usize]).collect();
            element(xml, "location", &attributes, |xml| {
                for point in linked {
                    empty(xml, "link", &[("point", point)])?;
                }
                write_properties(xml, &properties)?;
                let labels = [("labelOffsetX", "-10"), ("labelOffsetY", "-20")];
                let symbol = [("locationRepresentation", "DEFAULT"), ("layerId", "0")];
                empty(xml, "locationLayout", &[labels, symbol].concat())
            })?;
        }
        Ok(())
    }

    /// Returns the position in metres from the origin. A station without a position has that of its
    /// first node.
    fn station_position(&mut self, station: &Station) -> DVec2 {
        if let Some(position) = station.position {
            return position;
        }
        self.losses.add("stations have no position: drawn at the first node");
        station.nodes.first().map(|&node| self.graph.node(node).position).unwrap_or_default()
    }

    fn write_blocks(&self, xml: &mut Xml) -> io::Result<()> {
        for (name, block) in &self.blocks {
            element(xml, "block", &[("name", name), ("type", block.kind)], |xml| {
                for member in &block.members {
                    empty(xml, "member", &[("name", member)])?;
                }
                empty(xml, "blockLayout", &[("color", "#FF0000")])
            })?;
        }
        Ok(())
    }

    fn write_layout(&self, xml: &mut Xml) -> io::Result<()> {
        let scale = format!("{:?}", self.scale.millimetres());
        let attributes = [("name", "VLayout-01"), ("scaleX", &scale), ("scaleY", &scale)];
        element(xml, "visualLayout", &attributes, |xml| {
            let layer = [
                ("id", "0"),
                ("ordinal", "0"),
                ("visible", "true"),
                ("name", "Default layer"),
                ("groupId", "0"),
            ];
            empty(xml, "layer", &layer)?;
            empty(
                xml,
                "layerGroup",
                &[("id", "0"), ("name", "Default layer group"), ("visible", "true")],
            )
        })
    }

    fn count_tags(&mut self, tags: Option<&Tags>) {
        let Some(tags) = tags else { return };
        let has_zone = tags.zone.as_deref().is_some_and(|name| !self.blocks.contains_key(name));
        self.losses.add_if(tags.level.is_some(), "levels are kept as properties `regatta:level`");
        self.losses.add_if(has_zone, "zones are kept as properties `regatta:zone`");
    }
}

type Property<'text> = (Cow<'text, str>, Cow<'text, str>);

/// Returns the `regatta:` properties, then those of the tags.
fn own_properties(id: u32, tags: Option<&Tags>) -> Vec<Property<'_>> {
    let mut properties: Vec<Property<'_>> =
        vec![(format!("{OWN}id").into(), id.to_string().into())];
    let Some(tags) = tags else { return properties };
    for (key, value) in [("level", &tags.level), ("name", &tags.name), ("zone", &tags.zone)] {
        properties.extend(
            value.iter().map(|value| (format!("{OWN}{key}").into(), value.as_ref().into())),
        );
    }
    // The reader derives the length from the path.
    properties.extend(given(&tags.properties, &[LENGTH]));
    properties
}

/// Returns the properties without those that the writer derives from other parts of the model.
fn given<'text>(
    properties: &'text BTreeMap<Box<str>, Box<str>>,
    derived: &[&str],
) -> Vec<Property<'text>> {
    properties
        .iter()
        .filter(|(key, _)| !derived.contains(&&***key))
        .map(|(key, value)| (key.as_ref().into(), value.as_ref().into()))
        .collect()
}

fn write_properties(xml: &mut Xml, properties: &[Property<'_>]) -> io::Result<()> {
    for (key, value) in properties {
        empty(xml, "property", &[("name", key), ("value", value)])?;
    }
    Ok(())
}

/// Returns the zones that openTCS knows as blocks.
fn blocks(
    graph: &RouteGraph,
    points: &[String],
    paths: &[String],
    taken: &mut Taken,
) -> BTreeMap<String, Block> {
    let mut blocks = BTreeMap::new();
    for zone in graph.zones() {
        let Some(kind) = block_type(zone.rule) else { continue };
        let nodes = zone.listed_nodes(graph);
        let nodes = nodes.iter().map(|node| &points[node.0 as usize]);
        let edges = zone.edges.iter().map(|edge| &paths[edge.0 as usize]);
        let members = nodes.chain(edges).cloned().collect();
        blocks.insert(taken.unique(zone.name.to_string()), Block { kind, members });
    }
    blocks
}

/// Returns the type of the block that has a rule; `None` if there is none.
fn block_type(rule: ZoneRule) -> Option<&'static str> {
    match rule {
        ZoneRule::EXCLUSIVE => Some("SINGLE_VEHICLE_ONLY"),
        ZoneRule::SameDirection => Some("SAME_DIRECTION_ONLY"),
        ZoneRule::Capacity(_) => None,
    }
}

/// The names of the objects of a model.
#[derive(Default)]
struct Taken {
    names: BTreeSet<String>,
    /// By name: the next number that makes the name unique.
    numbers: BTreeMap<String, u64>,
}

impl Taken {
    /// Returns a unique name, and marks it as taken.
    fn unique(&mut self, name: String) -> String {
        if !name.is_empty() && self.names.insert(name.clone()) {
            return name;
        }
        let number = self.numbers.entry(name.clone()).or_insert(2);
        loop {
            let free = format!("{name} ({number})");
            *number += 1;
            if self.names.insert(free.clone()) {
                return free;
            }
        }
    }
}

/// A position in whole millimetres.
struct Position {
    x: String,
    y: String,
    is_rounded: bool,
}

fn millimetres(metres: DVec2) -> Position {
    let exact = metres * 1000.0;
    let whole = exact.round();
    let [x, y] = [whole.x, whole.y].map(|number| (number as i64).to_string());
    Position { x, y, is_rounded: exact.distance(whole) > 1e-3 }
}

/// Returns the name of the location type: that of the file, or else one by role.
fn type_name(station: &Station) -> &str {
    station.properties.get("type").map_or(
        match station.role {
            Role::None => "Station",
            Role::Pick => "Pick station",
            Role::Drop => "Drop station",
            Role::Park => "Park station",
            Role::Charge => "Charge station",
            Role::Transfer => "Transfer station",
        },
        AsRef::as_ref,
    )
}

fn operations(station: &Station) -> Vec<&str> {
    if let Some(operations) = station.properties.get("operations") {
        return operations.split(", ").collect();
    }
    match station.role {
        Role::None => vec!["NOP"],
        Role::Pick => vec!["Load cargo"],
        Role::Drop => vec!["Unload cargo"],
        Role::Park => vec!["Park"],
        Role::Charge => vec!["CHARGE"],
        Role::Transfer => vec!["Load cargo", "Unload cargo"],
    }
}

fn symbol(role: Role) -> &'static str {
    match role {
        Role::None | Role::Park => "NONE",
        Role::Pick | Role::Drop | Role::Transfer => "LOAD_TRANSFER_GENERIC",
        Role::Charge => "RECHARGE_GENERIC",
    }
}

fn empty(xml: &mut Xml, name: &str, attributes: &[(&str, &str)]) -> io::Result<()> {
    let texts = attributes.iter().map(|(name, value)| (*name, valid(value)));
    xml.create_element(name).with_attributes(texts).write_empty().map(|_| ())
}

fn element(
    xml: &mut Xml,
    name: &str,
    attributes: &[(&str, &str)],
    content: impl FnOnce(&mut Xml) -> io::Result<()>,
) -> io::Result<()> {
    let texts = attributes.iter().map(|(name, value)| (*name, valid(value)));
    xml.create_element(name).with_attributes(texts).write_inner_content(content).map(|_| ())
}

/// Replaces the characters that XML forbids.
fn valid(text: &str) -> Cow<'_, str> {
    if text.contains(is_invalid) {
        text.replace(is_invalid, "\u{fffd}").into()
    } else {
        text.into()
    }
}

fn is_invalid(letter: char) -> bool {
    matches!(
        letter,
        '\0'..='\u{8}' | '\u{b}' | '\u{c}' | '\u{e}'..='\u{1f}' | '\u{fffe}' | '\u{ffff}'
    )
}
