//! Plant models of openTCS: XML, of the versions 0.0.2 to 7.
//!
//! Points are nodes, paths are edges, and locations are stations. Positions are in millimetres. The
//! drawing gives the shape of a path. See `docs/formats/opentcs.md`.

mod blocks;
mod drawing;
mod element;
mod lengths;
mod locations;
#[cfg(test)]
pub(crate) mod tests;

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;

use glam::DVec2;

use self::blocks::Blocks;
use self::drawing::Drawing;
use self::element::Element;
use self::lengths::OtherLengths;
pub(crate) use self::lengths::{LENGTH, millimetres_of};
use crate::model::finding::Report;
use crate::model::options::ReadOptions;
use crate::model::tags::{Orientation, Role, Tags};
use crate::model::value::shorten;
use crate::read::file::{Ignored, Source, SyntaxError};
use crate::read::layout::{Layout, LayoutEdge, LayoutNode};

/// The prefix of the names of properties that our writer adds.
pub(crate) const OWN: &str = "regatta:";

/// The largest number of paths that a warning names.
const MAX_EXAMPLES: usize = 5;

type Properties = BTreeMap<Box<str>, Box<str>>;

/// Reads a plant model.
///
/// # Errors
/// If the text isn't XML with the root element `model`, or has no points or no paths that can be
/// driven.
pub(crate) fn read<'text>(
    source: Source<'text>,
    options: &ReadOptions,
    report: &mut Report<'text>,
) -> Result<Layout, SyntaxError> {
    let mut ignored = Ignored::default();
    let mut model = element::parse(source.text, &mut ignored)?;
    let line = report.line(model.at) as usize;
    if model.name != "model" {
        return Err(SyntaxError::new(
            line,
            format!("the outermost element is `{}`, not `model`", shorten(model.name)),
        ));
    }
    if options.level.is_some() {
        report.file_warning(0, "plant models of openTCS have no levels: all of it is read");
    }
    let mut reader = Reader {
        ignored,
        report,
        drawing: Drawing::default(),
        left_out: BTreeMap::new(),
        locked: Vec::new(),
        other_lengths: OtherLengths::default(),
        inherited: 0,
    };
    reader.version(&mut model);
    reader.drawing = Drawing::read(&mut model, &mut reader.ignored);
    let layout = reader.layout(&mut model);
    reader.ignored.report(report);
    match (layout.nodes.is_empty(), layout.edges.is_empty()) {
        (true, _) => Err(SyntaxError::new(
            line,
            "the plant model has no points: draw some with paths between them",
        )),
        (_, true) => Err(SyntaxError::new(
            line,
            "the plant model has no path that can be driven: add paths, unlock them or raise \
             maxVelocity",
        )),
        _ => Ok(layout),
    }
}

struct Reader<'r, 'text> {
    ignored: Ignored,
    report: &'r mut Report<'text>,
    drawing: Drawing,
    /// The paths that are left out, with their byte offsets, by reason.
    left_out: BTreeMap<&'static str, Vec<(u32, String)>>,
    /// The byte offsets and names of the locked locations.
    locked: Vec<(u32, String)>,
    other_lengths: OtherLengths,
    /// The number of bytes that locations have inherited from their types.
    inherited: usize,
}

/// The id and the name that our writer stores as properties.
#[derive(Default)]
struct Own {
    id: Option<u32>,
    name: Option<Box<str>>,
}

impl Reader<'_, '_> {
    fn version(&mut self, model: &mut Element<'_>) {
        let version = model.take_text("version");
        let is_known = ["0.0.2", "0.0.3", "0.0.4", "0.0.5", "6.", "7."]
            .iter()
            .any(|known| version.starts_with(known));
        if !is_known {
            let message = format!(
                "plant model version `{}` isn't one of 0.0.2 to 0.0.5, 6 and 7: it is read like \
                 version 7",
                shorten(&version)
            );
            self.report.file_warning(model.at, message);
        }
    }

    fn layout(&mut self, model: &mut Element<'_>) -> Layout {
        let blocks = self.blocks(model);
        let (mut nodes, node_owns): (Vec<_>, Vec<_>) = model
            .take_children("point")
            .into_iter()
            .map(|element| self.node(element, &blocks))
            .unzip();
        let located = nodes.iter().filter_map(|node| Some((node.id.clone(), node.position?)));
        let positions = located.collect();
        let paths = model.take_children("path").into_iter();
        let (mut edges, edge_owns): (Vec<_>, Vec<_>) =
            paths.filter_map(|element| self.edge(element, &positions, &blocks)).unzip();
        self.report_left_out();
        self.other_lengths.report(self.report);
        let zones = blocks.zones(&nodes, &edges);
        self.drawing.report(self.report);
        let mut stations = self.stations(model, &blocks);
        self.vehicles(model);
        for property in model.take_children("property") {
            let name = property.get("name").unwrap_or_default();
            self.ignored
                .add_named(property.at, format!("property `{}` of the model", shorten(name)));
        }
        model.ignore_rest("the model", &mut self.ignored);
        if let Some(ids) = own_ids(&node_owns) {
            let by_name: BTreeMap<_, _> =
                nodes.iter().map(|node| node.id.clone()).zip(ids.iter().cloned()).collect();
            let ends = edges.iter_mut().flat_map(|edge| [&mut edge.origin, &mut edge.destination]);
            let linked = stations.iter_mut().flat_map(|station| &mut station.nodes);
            for name in ends.chain(linked) {
                *name = by_name.get(name).unwrap_or(name).clone();
            }
            for ((node, id), own) in nodes.iter_mut().zip(ids).zip(node_owns) {
                (node.id, node.tags.name) = (id, own.name);
            }
        }
        if let Some(ids) = own_ids(&edge_owns) {
            for ((edge, id), own) in edges.iter_mut().zip(ids).zip(edge_owns) {
                (edge.id, edge.tags.name) = (id, own.name);
            }
        }
        Layout { nodes, edges, stations, zones, ..Layout::default() }
    }

    fn node(&mut self, mut element: Element<'_>, blocks: &Blocks) -> (LayoutNode, Own) {
        let at = element.at;
        let id = element.take_text("name");
        let position = self.position(&mut element, &format!("point `{}`", shorten(&id)));
        // NaN allows any angle.
        let heading = element.take_number(&["vehicleOrientationAngle"]).map(f64::to_radians);
        let mut role = Role::None;
        let mut tags = self.tags(&mut element, "a point");
        match element.take(&["type"]).as_deref() {
            Some("HALT_POSITION") | None => {}
            Some("PARK_POSITION") => role = Role::Park,
            Some(other) => tags.set("type", other),
        }
        for layout in element.take_children("pointLayout") {
            self.drawing.place(&id, layout, &mut self.ignored);
        }
        // Paths name their source points themselves.
        element.take_children("outgoingPath");
        self.rest(element, "a point", &mut tags);
        blocks.tag(&id, &mut tags);
        if let Some(own) = take_own(&mut tags.properties, "role").and_then(|role| role.parse().ok())
        {
            role = own;
        }
        let own = own(&mut tags);
        (LayoutNode { at, id, position, heading, role, tags }, own)
    }

    /// Returns the position in metres; positions are in millimetres. Reports one that is missing.
    fn position(&mut self, element: &mut Element<'_>, what: &str) -> Option<DVec2> {
        let position = element.take_position();
        // Graphs have no heights.
        for name in ["positionZ", "zPosition"] {
            if element.get(name) == Some("0") {
                element.take(&[name]);
            }
        }
        if position.is_none() {
            let message = format!(
                "{what} has no positionX and positionY that are numbers: give them in millimetres"
            );
            self.report.file_error(element.at, message);
        }
        position
    }

    /// Takes a speed of a path, in millimetres per second. Reports one that isn't a number.
    fn speed(&mut self, element: &mut Element<'_>, name: &str, path: &str) -> Option<f64> {
        let text = element.get(name).map(shorten);
        let speed = element.take_number(&[name]);
        if let Some(text) = text.filter(|_| speed.is_none()) {
            let path = shorten(path);
            let message = format!("path `{path}`: its {name} is `{text}`: give a number, in mm/s");
            self.report.file_error(element.at, message);
        }
        speed
    }

    /// Returns the edge of a path, unless it is locked or can't be driven in either direction.
    fn edge(
        &mut self,
        mut element: Element<'_>,
        positions: &BTreeMap<String, DVec2>,
        blocks: &Blocks,
    ) -> Option<(LayoutEdge, Own)> {
        let at = element.at;
        let id = element.take_text("name");
        let [origin, destination] =
            ["sourcePoint", "destinationPoint"].map(|name| element.take_text(name));
        let [speed, reverse] =
            ["maxVelocity", "maxReverseVelocity"].map(|name| self.speed(&mut element, name, &id));
        let reason = match (element.take(&["locked"]).as_deref(), speed, reverse) {
            (Some("true" | "1"), ..) => Some("locked"),
            (_, Some(speed), reverse)
                if speed <= 0.0 && reverse.is_none_or(|reverse| reverse <= 0.0) =>
            {
                Some("driven in neither direction")
            }
            _ => None,
        };
        if let Some(reason) = reason {
            self.left_out.entry(reason).or_default().push((at, id));
            return None;
        }
        let ends = [&origin, &destination].map(|end| (end.as_str(), positions.get(end).copied()));
        let shape = self.drawing.shape(&id, &mut element, ends, &mut self.ignored);
        let positions = ends.map(|(_, position)| position);
        self.other_lengths.take(&id, &mut element, &shape, positions);
        let mut tags = self.tags(&mut element, "a path");
        self.rest(element, "a path", &mut tags);
        blocks.tag(&id, &mut tags);
        let own = own(&mut tags);
        let [speed, reverse_speed] =
            [speed, reverse].map(|speed| speed.map(|speed| speed / 1000.0));
        let edge = LayoutEdge {
            at,
            id,
            origin,
            destination,
            shape,
            speed,
            reverse_speed,
            tags,
            ..LayoutEdge::default()
        };
        Some((forward(edge), own))
    }

    /// Reports the paths that are left out, once for each reason.
    fn report_left_out(&mut self) {
        for (reason, paths) in std::mem::take(&mut self.left_out) {
            self.report_all("path", &paths, &format!("{reason}: left out"));
        }
    }

    /// Reports what is true of some elements of a kind, by their byte offsets and names, in one
    /// warning.
    fn report_all(&mut self, kind: &str, elements: &[(u32, String)], fact: &str) {
        let Some((at, _)) = elements.first() else { return };
        let names = elements.iter().take(MAX_EXAMPLES);
        let names: Vec<String> = names.map(|(_, id)| format!("`{}`", shorten(id))).collect();
        let [plural, is] = if elements.len() == 1 { ["", "is"] } else { ["s", "are"] };
        let more = match elements.len().saturating_sub(MAX_EXAMPLES) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let names = names.join(", ");
        self.report.file_warning(*at, format!("{kind}{plural} {names}{more} {is} {fact}"));
    }

    /// Returns the name-independent tags of a point or a path.
    fn tags(&mut self, element: &mut Element<'_>, what: &str) -> Tags {
        Tags { properties: self.properties(element, what), ..Tags::default() }
    }

    fn properties(&mut self, element: &mut Element<'_>, what: &str) -> Properties {
        let mut properties = Properties::new();
        for mut property in element.take_children("property") {
            if let Some((name, value)) = property.take(&["name"]).zip(property.take(&["value"])) {
                properties.insert(name, value);
            }
            property.ignore_rest(&format!("a property of {what}"), &mut self.ignored);
        }
        properties
    }

    /// Keeps the remaining attributes, and counts the remaining elements.
    fn rest(&mut self, mut element: Element<'_>, what: &str, tags: &mut Tags) {
        for (name, value) in element.attributes.drain(..) {
            tags.properties.entry(name.into()).or_insert(value);
        }
        element.ignore_rest(what, &mut self.ignored);
    }

    fn vehicles(&mut self, model: &mut Element<'_>) {
        for mut vehicle in model.take_children("vehicle") {
            self.ignored.add_named(vehicle.at, "element `vehicle` of the model");
            for (name, _) in self.properties(&mut vehicle, "a vehicle") {
                self.ignored
                    .add_named(vehicle.at, format!("property `{}` of a vehicle", shorten(&name)));
            }
        }
    }
}

/// Reverses an edge that may be driven in reverse only. Robots then drive it forwards, tail first.
fn forward(edge: LayoutEdge) -> LayoutEdge {
    let reverse_speed = edge.reverse_speed.filter(|speed| *speed > 0.0);
    if edge.speed.is_none_or(|speed| speed > 0.0) {
        return LayoutEdge { reverse_speed, ..edge };
    }
    LayoutEdge {
        origin: edge.destination,
        destination: edge.origin,
        shape: edge.shape.reversed(),
        speed: reverse_speed,
        reverse_speed: None,
        orientation: Orientation::Offset(PI),
        ..edge
    }
}

fn take_own(properties: &mut Properties, key: &str) -> Option<Box<str>> {
    properties.remove(&*format!("{OWN}{key}"))
}

fn own(tags: &mut Tags) -> Own {
    let id = take_own(&mut tags.properties, "id").and_then(|id| id.parse().ok());
    Own { id, name: take_own(&mut tags.properties, "name") }
}

/// Returns the ids that our writer has given; `None` if an object has none, such as one that was
/// added in openTCS.
fn own_ids(owns: &[Own]) -> Option<Vec<String>> {
    let ids: Vec<u32> = owns.iter().map(|own| own.id).collect::<Option<_>>()?;
    let unique = ids.iter().collect::<BTreeSet<_>>().len() == ids.len();
    unique.then(|| ids.iter().map(u32::to_string).collect())
}
