//! Layouts in the VDMA's Layout Interchange Format (LIF), 1.0 and the draft of 2.0: JSON.
//!
//! Real files violate the specification: numbers are texts, keys are missing, curves don't start at
//! their nodes. Where the meaning is clear, they are read with a warning.

mod edge;
mod ids;
pub(crate) mod node;
mod object;
mod origin;
#[cfg(test)]
mod tests;
mod vehicle;

use std::collections::BTreeMap;

use serde_json::value::RawValue;

use crate::model::finding::Report;
use crate::model::options::ReadOptions;
use crate::model::tags::Role;
use crate::model::value::shorten;
use crate::read::file::{MAX_NAME, Source, SyntaxError};
use crate::read::layout::Layout;
use ids::Ids;
use object::{Context, Object, Raw};
use vehicle::Vehicles;

/// The number of names that a message lists.
const MAX_NAMES: usize = 20;

/// The id of a layout without a level, and the version of layouts, in files that we write.
pub(crate) const OWN_ID: &str = "layout";
pub(crate) const OWN_VERSION: &str = "1";

/// One of the layouts of a file.
struct Sheet<'text> {
    /// The byte offset in the file.
    at: u32,
    /// `layoutId`, `layoutName` and `layoutLevelId`.
    names: [Option<String>; 3],
    /// `originId` of LIF 2.
    origin: Option<String>,
    nodes: Vec<Raw<'text>>,
    edges: Vec<Raw<'text>>,
    stations: Vec<Raw<'text>>,
    /// Whether the layout is on the level to read.
    is_read: bool,
    /// The level of its nodes and edges.
    level: Option<Box<str>>,
}

/// The reader of the nodes, edges and stations of all sheets.
struct Reader<'a, 'r, 'text> {
    context: Context<'r, 'text>,
    vehicles: Vehicles<'a>,
    node_ids: Ids,
    edge_ids: Ids,
    station_ids: Ids,
}

/// Reads all layouts of a file, or those of one level.
///
/// # Errors
/// If the text isn't JSON, or not an object with `layouts`.
pub(crate) fn read<'text>(
    source: Source<'text>,
    options: &ReadOptions,
    report: &mut Report<'text>,
) -> Result<Layout, SyntaxError> {
    let mut fields: BTreeMap<String, &'text RawValue> = serde_json::from_str(source.text)?;
    let [layouts, origins] = ["layouts", "origins"].map(|key| {
        let list = fields.remove(key)?;
        serde_json::from_str::<Vec<Raw<'text>>>(list.get()).ok()
    });
    if layouts.is_none() && origins.is_none() {
        let message = "no list `layouts` or `origins`: a LIF file has `metaInformation`, and \
                       `layouts` or, from version 2 on, `origins` with `layouts`";
        return Err(SyntaxError::new(1, message));
    }
    let mut context = Context::new(source.text, report);
    if let Some(meta) = fields.remove("metaInformation") {
        check_version(meta, &mut context);
    }
    for (key, raw) in fields {
        context.ignored.add_key(context.at(raw), &key, "the file");
    }
    let mut sheets: Vec<Sheet<'text>> = layouts
        .into_iter()
        .flatten()
        .filter_map(|raw| Sheet::parse(raw, None, &mut context))
        .collect();
    sheets.extend(origin::sheets(origins.unwrap_or_default(), &mut context));
    select(&mut sheets, options.level.as_deref(), &mut context);
    ignore_names(&sheets, &mut context);
    Ok(read_sheets(&sheets, options, context))
}

/// The author and the time of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header<'a> {
    /// The name of the project.
    pub project: &'a str,
    /// The name of the company or person.
    pub creator: &'a str,
    /// The time in UTC, as in `2017-04-15T11:40:03.12Z`.
    pub timestamp: &'a str,
}

impl Default for Header<'_> {
    /// The time is constant, so that a graph always gives the same file.
    fn default() -> Self {
        Self { project: "Regatta", creator: "Regatta", timestamp: "1970-01-01T00:00:00.00Z" }
    }
}

fn check_version<'text>(meta: Raw<'text>, context: &mut Context<'_, 'text>) {
    let Some(mut meta) = Object::parse(meta, "`metaInformation`", context) else { return };
    let version = meta.take_text("lifVersion", context);
    if let Some(version) =
        version.filter(|version| !["0.", "1.", "2."].iter().any(|known| version.starts_with(known)))
    {
        let message = format!("the file is of LIF {}: it is read as LIF 2.0", shorten(&version));
        context.warning(meta.at, message);
    }
    let own = Header::default();
    for (key, value) in [
        ("projectIdentification", own.project),
        ("creator", own.creator),
        ("exportTimestamp", own.timestamp),
    ] {
        meta.drop_own(key, value);
    }
    meta.ignore_rest(context);
}

impl<'text> Sheet<'text> {
    fn parse(
        raw: Raw<'text>,
        origin: Option<&str>,
        context: &mut Context<'_, 'text>,
    ) -> Option<Self> {
        let mut layout = Object::parse(raw, "a layout", context)?;
        let names = ["layoutId", "layoutName", "layoutLevelId"].map(|key| {
            let name = layout.take_text(key, context)?;
            if name.len() > MAX_NAME {
                context.error(
                    layout.at,
                    format!("`{key}` of a layout is longer than {MAX_NAME} bytes: shorten it"),
                );
            }
            Some(name).filter(|name| name.len() <= MAX_NAME)
        });
        let [nodes, edges, stations] =
            ["nodes", "edges", "stations"].map(|key| layout.take_list(key, context));
        let at = layout.at;
        layout.drop_own("layoutVersion", OWN_VERSION);
        layout.ignore_rest(context);
        let level = names[2].as_deref().map(Into::into);
        let origin = origin.map(str::to_owned);
        Some(Self { at, names, origin, nodes, edges, stations, is_read: true, level })
    }

    /// Returns the name that identifies the layout best.
    fn name(&self) -> Option<&str> {
        let [id, name, level] = &self.names;
        level.as_deref().or(name.as_deref()).or(id.as_deref())
    }
}

/// Chooses the layouts to read, and names levels that have no name.
fn select(sheets: &mut [Sheet<'_>], wanted: Option<&str>, context: &mut Context<'_, '_>) {
    let known: Vec<String> =
        sheets.iter().filter_map(Sheet::name).take(MAX_NAMES).map(shorten).collect();
    let known = known.join("`, `");
    if sheets.is_empty() {
        context.error(0, "`layouts` is empty: add a layout with nodes and edges");
    }
    if let Some(wanted) = wanted {
        for sheet in &mut *sheets {
            let mut names = sheet.names.iter().chain([&sheet.origin]).flatten();
            sheet.is_read = names.any(|name| name == wanted);
        }
        if !sheets.is_empty() && !sheets.iter().any(|sheet| sheet.is_read) {
            context.error(
                0,
                format!("no layout is named `{}`: the file has `{known}`", shorten(wanted)),
            );
        }
    } else if let [_, second, ..] = sheets {
        let (at, count) = (second.at, sheets.len());
        let message = format!(
            "the {count} layouts `{known}` lie in one plane: to read only one, name it with --level"
        );
        context.warning(at, message);
    }
    if sheets.len() > 1 {
        for sheet in sheets {
            sheet.level = sheet.name().map(Into::into);
        }
    }
}

/// Counts the names of layouts that aren't those of their levels.
fn ignore_names(sheets: &[Sheet<'_>], context: &mut Context<'_, '_>) {
    for sheet in sheets {
        for (key, name) in ["layoutId", "layoutName", "layoutLevelId"].into_iter().zip(&sheet.names)
        {
            let is_own = key == "layoutId" && name.as_deref() == Some(OWN_ID);
            if name.is_some() && name.as_deref() != sheet.level.as_deref() && !is_own {
                context.ignored.add_named(sheet.at, format!("key `{key}` of a layout"));
            }
        }
    }
}

fn read_sheets<'text>(
    sheets: &[Sheet<'text>],
    options: &ReadOptions,
    context: Context<'_, 'text>,
) -> Layout {
    let mut reader = Reader {
        context,
        vehicles: Vehicles::new(options.vehicle_type.as_deref()),
        node_ids: Ids::new(sheets, "nodeId", |sheet| &sheet.nodes),
        edge_ids: Ids::new(sheets, "edgeId", |sheet| &sheet.edges),
        station_ids: Ids::new(sheets, "stationId", |sheet| &sheet.stations),
    };
    // Angles beyond a full turn have a warning each.
    let mut layout = Layout { has_doubtful_angles: true, ..Layout::default() };
    let mut roles = Vec::new();
    for (index, sheet) in sheets.iter().enumerate().filter(|(_, sheet)| sheet.is_read) {
        layout.nodes.extend(sheet.nodes.iter().filter_map(|raw| reader.node(raw, sheet, index)));
        for (number, raw) in (1..).zip(&sheet.edges) {
            let Some((edge, role)) = reader.edge(raw, sheet, [index, number]) else { continue };
            roles.push((edge.destination.clone(), role));
            layout.edges.push(edge);
        }
    }
    set_roles(&mut layout, roles);
    for (index, sheet) in sheets.iter().enumerate().filter(|(_, sheet)| sheet.is_read) {
        let stations = reader.stations(&sheet.stations, index, &layout.nodes);
        layout.stations.extend(stations);
    }
    reader.finish(sheets);
    layout
}

/// Moves the roles of edges to the nodes at their ends, unless these have roles of their own.
fn set_roles(layout: &mut Layout, mut roles: Vec<(String, Role)>) {
    roles.retain(|(_, role)| *role != Role::None);
    if roles.is_empty() {
        return;
    }
    let mut roles_by_node = BTreeMap::new();
    for (node, role) in roles {
        roles_by_node.entry(node).or_insert(role);
    }
    for node in layout.nodes.iter_mut().filter(|node| node.role == Role::None) {
        node.role = roles_by_node.get(&node.id).copied().unwrap_or_default();
    }
}

impl Reader<'_, '_, '_> {
    /// Reports all notes.
    fn finish(mut self, sheets: &[Sheet<'_>]) {
        for (ids, kind) in
            [(&self.node_ids, "node"), (&self.edge_ids, "edge"), (&self.station_ids, "station")]
        {
            if let Some((id, count)) = ids.shared() {
                let at = sheets.get(1).map_or(0, |sheet| sheet.at);
                let message = format!(
                    "{count} ids of {kind}s, such as `{}`, occur in several layouts: those are \
                     different {kind}s, named LAYOUT/ID",
                    shorten(id)
                );
                self.context.warning(at, message);
            }
        }
        self.vehicles.report(&mut self.context);
        self.context.finish();
    }
}
