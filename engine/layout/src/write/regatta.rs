//! The writer of our own format: YAML in flow style, one line per item.

use std::collections::BTreeMap;
use std::fmt::{self, Write};

use glam::DVec2;
use regatta_base::bezier::CubicBezier;
use regatta_base::graph::{Ends, NodeIndex, Rotation};

use super::Losses;
use crate::model::facilities::{Cabin, Door, DoorTimes, Lift};
use crate::model::format::Written;
use crate::model::path::Path;
use crate::model::route_graph::{Edge, Node, RouteGraph};
use crate::model::tags::{BackgroundLine, Orientation, Role, Station, Tags};
use crate::model::zones::{Zone, ZoneRule};

/// The largest depth of brackets in a text that is written without escapes. The reader limits the
/// depth of brackets, and also counts those in texts.
const MAX_PLAIN_DEPTH: usize = 20;

/// Writes a graph. Reading the text gives the same graph: every number is read back as the same
/// `f64`. If the origin of the graph isn't (0, 0), control points may differ by the rounding error
/// of the file's coordinates, which is below 1 µm for maps within 4000 km.
pub fn write(graph: &RouteGraph) -> Written {
    let mut writer = Writer { text: String::new(), graph, losses: Losses::default() };
    writer.write().expect("writing to a String never fails");
    Written { text: writer.text, losses: writer.losses.into_lines() }
}

struct Writer<'graph> {
    text: String,
    graph: &'graph RouteGraph,
    losses: Losses,
}

impl Writer<'_> {
    fn write(&mut self) -> fmt::Result {
        let graph = self.graph;
        let (edges, nodes) = (graph.edges().len(), graph.nodes().len());
        writeln!(self.text, "# {edges} edges, {nodes} nodes; metres, radians, metres per second.")?;
        writeln!(self.text, "Edges:")?;
        for edge in graph.edges() {
            self.edge(edge)?;
        }
        writeln!(self.text, "\nVertices:")?;
        for node in graph.nodes() {
            self.node(node)?;
        }
        if !graph.stations().is_empty() {
            writeln!(self.text, "\nStations:")?;
        }
        for station in graph.stations() {
            self.station(station)?;
        }
        // The zone of a lift's robots comes with the lift.
        let lifts: Vec<String> = graph.lifts().iter().map(Lift::zone_name).collect();
        let zones = || graph.zones().iter().filter(|zone| !lifts.iter().any(|l| **l == *zone.name));
        if zones().next().is_some() {
            writeln!(self.text, "\nZones:")?;
        }
        for zone in zones() {
            self.zone(zone)?;
        }
        if !graph.doors().is_empty() {
            writeln!(self.text, "\nDoors:")?;
        }
        for door in graph.doors() {
            self.door(door)?;
        }
        if !graph.lifts().is_empty() {
            writeln!(self.text, "\nLifts:")?;
        }
        for lift in graph.lifts() {
            self.lift(lift)?;
        }
        if !graph.background().is_empty() {
            writeln!(self.text, "\nBackground:")?;
        }
        for line in graph.background() {
            self.background_line(line)?;
        }
        Ok(())
    }

    fn background_line(&mut self, line: &BackgroundLine) -> fmt::Result {
        write!(self.text, "- {{Line: ")?;
        self.points(line.points.iter().copied())?;
        if let Some(level) = &line.level {
            write!(self.text, ", Level: ")?;
            self.quoted(level)?;
        }
        writeln!(self.text, "}}")
    }

    /// Writes a list of points, in the coordinates of the file.
    fn points(&mut self, points: impl Iterator<Item = DVec2>) -> fmt::Result {
        self.text.push('[');
        for (index, point) in points.enumerate() {
            let separator = if index == 0 { "" } else { ", " };
            let DVec2 { x, y } = self.graph.origin() + point;
            write!(self.text, "{separator}[{x:?}, {y:?}]")?;
        }
        self.text.push(']');
        Ok(())
    }

    fn door(&mut self, door: &Door) -> fmt::Result {
        write!(self.text, "- {{Name: ")?;
        self.quoted(&door.name)?;
        let edges = door.edges.iter().map(|&edge| self.graph.edge(edge).id.to_string());
        let edges: Vec<String> = edges.collect();
        write!(self.text, ", Edges: [{}]", edges.join(", "))?;
        if let Some(line) = door.line {
            write!(self.text, ", Line: ")?;
            self.points(line.into_iter())?;
        }
        self.door_times(door.times)?;
        writeln!(self.text, "}}")
    }

    fn door_times(&mut self, times: DoorTimes) -> fmt::Result {
        let DoorTimes { opening_secs, closing_secs } = times;
        write!(self.text, ", OpeningSeconds: {opening_secs:?}, ClosingSeconds: {closing_secs:?}")
    }

    fn lift(&mut self, lift: &Lift) -> fmt::Result {
        write!(self.text, "- {{Name: ")?;
        self.quoted(&lift.name)?;
        let nodes = lift.levels.iter().flat_map(|level| &level.nodes);
        let nodes: Vec<String> = nodes.map(|&node| self.id(node).to_string()).collect();
        write!(self.text, ", Nodes: [{}]", nodes.join(", "))?;
        if let Some(Cabin { centre, size, yaw }) = lift.cabin {
            let DVec2 { x, y } = self.graph.origin() + centre;
            write!(self.text, ", X: {x:?}, Y: {y:?}, Theta: {yaw:?}")?;
            write!(self.text, ", Width: {:?}, Depth: {:?}", size.x, size.y)?;
        }
        self.door_times(lift.door_times)?;
        let Lift { level_secs, capacity, .. } = lift;
        write!(self.text, ", SecondsPerLevel: {level_secs:?}, Capacity: {capacity}, Home: ")?;
        self.quoted(&lift.levels[lift.home].name)?;
        writeln!(self.text, "}}")
    }

    fn edge(&mut self, edge: &Edge) -> fmt::Result {
        let Edge { id, speed, reverse_speed, .. } = edge;
        let (origin, destination) = (self.id(edge.origin), self.id(edge.destination));
        write!(self.text, "- {{Id: {id}, Origin_ID: {origin}, Destination_ID: {destination}, ")?;
        if is_linear(self.graph, edge) {
            write!(self.text, "CurveType: Linear")?;
        } else {
            self.control_points(&edge.path)?;
        }
        write!(self.text, ", VelocityForward: {speed:?}")?;
        if let Some(speed) = reverse_speed {
            write!(self.text, ", VelocityBackwards: {speed:?}")?;
        }
        match edge.orientation {
            Orientation::Tangential => {}
            Orientation::Offset(angle) => write!(self.text, ", HeadingOffset: {angle:?}")?,
            Orientation::Fixed(angle) => write!(self.text, ", Heading: {angle:?}")?,
        }
        let Ends { origin, destination } = edge.rotation;
        for (key, rotation) in
            [("RotationAtOrigin", origin), ("RotationAtDestination", destination)]
        {
            if rotation != Rotation::Shorter {
                write!(self.text, ", {key}: {}", rotation.name())?;
            }
        }
        self.tags(edge.tags.as_deref())?;
        writeln!(self.text, "}}")
    }

    /// Writes the control points of a path. The end of each cubic is the start of the next, and is
    /// written once.
    fn control_points(&mut self, path: &Path) -> fmt::Result {
        let inner = path.cubics().flat_map(|cubic| cubic.control_points.into_iter().skip(1));
        write!(self.text, "CurveType: Bezier, ControlPoints: ")?;
        self.points(std::iter::once(path.start()).chain(inner))
    }

    fn node(&mut self, node: &Node) -> fmt::Result {
        let DVec2 { x, y } = self.graph.origin() + node.position;
        write!(self.text, "- {{Id: {}, X: {x:?}, Y: {y:?}, Theta: {:?}", node.id, node.theta)?;
        self.role(node.role)?;
        self.tags(node.tags.as_deref())?;
        writeln!(self.text, "}}")
    }

    fn station(&mut self, station: &Station) -> fmt::Result {
        write!(self.text, "- {{Name: ")?;
        self.quoted(&station.name)?;
        self.role(station.role)?;
        let ids: Vec<String> =
            station.nodes.iter().map(|&node| self.id(node).to_string()).collect();
        write!(self.text, ", Nodes: [{}]", ids.join(", "))?;
        if let Some(position) = station.position {
            let DVec2 { x, y } = self.graph.origin() + position;
            write!(self.text, ", X: {x:?}, Y: {y:?}")?;
        }
        self.properties(&station.properties)?;
        writeln!(self.text, "}}")
    }

    fn zone(&mut self, zone: &Zone) -> fmt::Result {
        write!(self.text, "- {{Name: ")?;
        self.quoted(&zone.name)?;
        match zone.rule {
            ZoneRule::Capacity(robots) => write!(self.text, ", Capacity: {robots}")?,
            ZoneRule::SameDirection => write!(self.text, ", Rule: same_direction")?,
        }
        let nodes = zone.listed_nodes(self.graph);
        let nodes: Vec<String> = nodes.iter().map(|&node| self.id(node).to_string()).collect();
        let edges = zone.edges.iter().map(|&edge| self.graph.edge(edge).id.to_string());
        let edges: Vec<String> = edges.collect();
        for (key, ids) in [("Nodes", nodes), ("Edges", edges)] {
            if !ids.is_empty() {
                write!(self.text, ", {key}: [{}]", ids.join(", "))?;
            }
        }
        writeln!(self.text, "}}")
    }

    fn role(&mut self, role: Role) -> fmt::Result {
        if role == Role::None { Ok(()) } else { write!(self.text, ", Role: {}", role.name()) }
    }

    fn tags(&mut self, tags: Option<&Tags>) -> fmt::Result {
        let Some(tags) = tags else { return Ok(()) };
        for (key, value) in [("Name", &tags.name), ("Level", &tags.level), ("Zone", &tags.zone)] {
            let Some(value) = value else { continue };
            write!(self.text, ", {key}: ")?;
            self.quoted(value)?;
        }
        self.properties(&tags.properties)
    }

    fn properties(&mut self, properties: &BTreeMap<Box<str>, Box<str>>) -> fmt::Result {
        if properties.is_empty() {
            return Ok(());
        }
        write!(self.text, ", Properties: {{")?;
        for (index, (key, value)) in properties.iter().enumerate() {
            write!(self.text, "{}{}: ", if index == 0 { "" } else { ", " }, Quoted(key))?;
            self.quoted(value)?;
        }
        write!(self.text, "}}")
    }

    fn quoted(&mut self, text: &str) -> fmt::Result {
        let is_changed = text.trim() != text;
        self.losses.add_if(is_changed, "texts have white space at an end, which isn't kept");
        write!(self.text, "{}", Quoted(text))
    }

    fn id(&self, node: NodeIndex) -> u32 {
        self.graph.node(node).id
    }
}

/// Whether the reader would make the same edge of a `Linear` edge.
fn is_linear(graph: &RouteGraph, edge: &Edge) -> bool {
    let [from, to] = [edge.origin, edge.destination].map(|node| graph.node(node).position);
    edge.path.single().is_some_and(|cubic| *cubic == CubicBezier::straight(from, to))
}

/// A text that is displayed as a double-quoted YAML scalar.
struct Quoted<'text>(&'text str);

impl fmt::Display for Quoted<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let escapes_brackets = !has_shallow_brackets(self.0);
        f.write_char('"')?;
        for character in self.0.chars() {
            match character {
                '"' | '\\' => write!(f, "\\{character}")?,
                '[' | ']' | '{' | '}' if escapes_brackets => {
                    write!(f, "\\x{:02X}", u32::from(character))?
                }
                // YAML 1.1 reads the separators as line ends, and forbids the others.
                '\u{2028}' | '\u{2029}' | '\u{feff}' | '\u{fffe}' | '\u{ffff}' => {
                    write!(f, "\\u{:04X}", u32::from(character))?;
                }
                _ if character.is_control() => write!(f, "\\x{:02X}", u32::from(character))?,
                _ => f.write_char(character)?,
            }
        }
        f.write_char('"')
    }
}

/// Whether brackets are balanced and aren't deeply nested.
fn has_shallow_brackets(text: &str) -> bool {
    let mut depth = 0usize;
    for byte in text.bytes() {
        match byte {
            b'[' | b'{' => depth += 1,
            b']' | b'}' if depth == 0 => return false,
            b']' | b'}' => depth -= 1,
            _ => {}
        }
        if depth > MAX_PLAIN_DEPTH {
            return false;
        }
    }
    depth == 0
}

#[cfg(test)]
mod tests;
