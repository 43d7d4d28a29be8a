//! Drawings: DXF in ASCII.
//!
//! Lines and curves of the chosen layers become edges in both directions, joined where their ends
//! meet. Lines of the other layers become the background.

mod curve;
mod expand;
mod join;
mod scan;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};

use dxf::Drawing;
use glam::DVec2;
use regatta_base::bezier::CubicBezier;

use crate::model::finding::{Report, Subject};
use crate::model::options::ReadOptions;
use crate::read::file::{Ignored, Source, SyntaxError};
use crate::read::layout::{Layout, LayoutEdge, LayoutNode, Shape};
use expand::{Curve, Expander};
use join::{Link, Network, Repeated, join};
use scan::Scan;

/// The largest number of near misses that are listed.
const MAX_NEAR_MISSES: usize = 100;

/// The layer of construction points, which isn't plotted.
const DEFPOINTS: &str = "DEFPOINTS";

/// The lengths in metres of the units that $INSUNITS numbers, from 1.
const UNITS: [f64; 16] = [
    0.0254, 0.3048, 1609.344, 1e-3, 1e-2, 1.0, 1e3, 25.4e-9, 25.4e-6, 0.9144, 1e-10, 1e-9, 1e-6,
    0.1, 10.0, 100.0,
];

/// Reads a drawing.
///
/// # Errors
/// If the text isn't DXF in ASCII.
pub(crate) fn read<'text>(
    source: Source<'text>,
    options: &ReadOptions,
    report: &mut Report<'text>,
) -> Result<Layout, SyntaxError> {
    if source.text.starts_with("AutoCAD Binary DXF") || source.text.starts_with("AutoCAD DXB") {
        return Err(SyntaxError::new(1, "this is a binary drawing: save it as DXF in ASCII"));
    }
    let mut ignored = Ignored::default();
    let scan = scan::scan(source.text, &mut ignored, report)?;
    let drawing = Drawing::load(&mut scan.text.as_bytes())
        .map_err(|error| SyntaxError::new(1, format!("the drawing can't be read: {error}")))?;
    reject_lost(&scan, &drawing, report);
    let unit = unit(options, &scan, report);
    let curves = curves(&drawing, &scan, unit, &mut ignored, report);
    let (edges, others) = Layers::new(&curves, &scan, options, report).divide(curves, &mut ignored);
    let network = join(edges);
    report_network(&network, report, &mut ignored);
    ignored.report(report);
    Ok(layout(network, &others))
}

/// Returns the start of a text for a message.
fn shorten(text: &str) -> String {
    text.trim().chars().take(40).collect::<String>().escape_debug().to_string()
}

/// Reports entities that are lost: after an error, the crate `dxf` continues as if a section had
/// ended.
fn reject_lost(scan: &Scan, drawing: &Drawing, report: &mut Report<'_>) {
    let read = drawing.entities().count();
    let blocks: Vec<usize> = drawing.blocks().map(|block| block.entities.len()).collect();
    if read != scan.offsets.len() || blocks != scan.block_sizes {
        let at = scan.offsets.get(read).copied().unwrap_or_default();
        let expected = scan.offsets.len() + scan.block_sizes.iter().sum::<usize>();
        let message = format!(
            "only {} of {expected} entities can be read",
            read + blocks.iter().sum::<usize>()
        );
        report.file_error(at, message);
    }
}

/// Returns the metres of a unit.
fn unit(options: &ReadOptions, scan: &Scan, report: &mut Report<'_>) -> f64 {
    if let Some(unit) = options.units {
        return unit.metres();
    }
    let index = scan.units.and_then(|units| usize::try_from(units).ok()?.checked_sub(1));
    index.and_then(|index| UNITS.get(index).copied()).unwrap_or_else(|| {
        let message = "the drawing doesn't give its unit of length: metres are assumed; give \
                       another with `--units`, such as `--units mm`";
        report.file_warning(0, message);
        1.0
    })
}

fn curves(
    drawing: &Drawing,
    scan: &Scan,
    unit: f64,
    ignored: &mut Ignored,
    report: &mut Report<'_>,
) -> Vec<Curve> {
    let mut expander = Expander::new(drawing.blocks(), ignored);
    let offsets = scan.offsets.iter().copied().chain(std::iter::repeat(0));
    for (entity, at) in drawing.entities().zip(offsets) {
        expander.add(entity, at, unit);
    }
    if expander.is_full() {
        let message = "the drawing has too many entities when its blocks are expanded: remove \
                       what isn't a route";
        report.file_error(0, message);
        return Vec::new();
    }
    expander.curves
}

/// The layers whose lines become edges. Names are in upper case, as they are case-insensitive.
struct Layers {
    edges: BTreeSet<String>,
    background: BTreeSet<String>,
}

impl Layers {
    fn new(curves: &[Curve], scan: &Scan, options: &ReadOptions, report: &mut Report<'_>) -> Self {
        let names: BTreeMap<String, &str> =
            curves.iter().map(|curve| (curve.layer.to_uppercase(), curve.layer.as_str())).collect();
        let (mut visible, mut list) = (BTreeSet::new(), Vec::new());
        for (upper, name) in &names {
            let is_hidden = scan.hidden_layers.contains(upper) || upper == DEFPOINTS;
            list.push(format!("`{}`{}", shorten(name), if is_hidden { " (hidden)" } else { "" }));
            if !is_hidden {
                visible.insert(upper.clone());
            }
        }
        let list = list.join(", ");
        if curves.is_empty() {
            report.file_error(0, "the drawing has no lines or curves that can be routes");
        }
        if options.layers.is_empty() {
            if visible.len() > 1 {
                let message = format!(
                    "all lines of the visible layers become edges; layers with lines are {list}: \
                     choose with `--layer NAME`"
                );
                report.file_warning(0, message);
            }
            return Self { edges: visible, background: BTreeSet::new() };
        }
        for layer in
            options.layers.iter().filter(|layer| !names.contains_key(&layer.to_uppercase()))
        {
            let exists = if scan.layers.contains_key(&layer.to_uppercase()) {
                "has no lines"
            } else {
                "doesn't exist"
            };
            let message =
                format!("layer `{}` {exists}: layers with lines are {list}", shorten(layer));
            report.file_error(0, message);
        }
        let edges: BTreeSet<String> =
            options.layers.iter().map(|layer| layer.to_uppercase()).collect();
        let background = visible.difference(&edges).cloned().collect();
        Self { edges, background }
    }

    /// Divides curves into those that are edges and those of the background.
    fn divide(&self, curves: Vec<Curve>, ignored: &mut Ignored) -> (Vec<Curve>, Vec<Curve>) {
        let (mut edges, mut background) = (Vec::new(), Vec::new());
        for curve in curves {
            let layer = curve.layer.to_uppercase();
            if self.edges.contains(&layer) {
                edges.push(curve);
            } else if self.background.contains(&layer) {
                background.push(curve);
            } else {
                ignored
                    .add(curve.at, format!("line on the hidden layer `{}`", shorten(&curve.layer)));
            }
        }
        (edges, background)
    }
}

fn report_network(network: &Network, report: &mut Report<'_>, ignored: &mut Ignored) {
    for &at in &network.short {
        ignored.add(at, "line shorter than 1 mm, or whose ends are joined to one node");
    }
    for Repeated { at, is_whole } in &network.repeated {
        let what = match is_whole {
            true => "line that is drawn a second time",
            false => "part of a line that is drawn a second time",
        };
        ignored.add(*at, what);
    }
    for &(node, distance) in network.near_misses.iter().take(MAX_NEAR_MISSES) {
        let (DVec2 { x, y }, at) = network.nodes[node];
        let millimetres = distance * 1000.0;
        let message = format!(
            "the line that ends at ({x:.3}, {y:.3}) m misses another by {millimetres:.0} mm: join \
             them, if they should be connected"
        );
        report.warning(at, Subject::Node(u32::try_from(node + 1).ok()), message);
    }
    if network.is_partial {
        let message = "too many lines are close together: not all ends that touch another line \
                       are connected with it";
        report.file_warning(0, message);
    }
    if network.near_misses.len() > MAX_NEAR_MISSES {
        let message = format!(
            "{} further ends of lines miss another",
            network.near_misses.len() - MAX_NEAR_MISSES
        );
        report.file_warning(0, message);
    }
}

/// Makes two edges of each line, as lines of a drawing have no direction.
fn layout(network: Network, background: &[Curve]) -> Layout {
    let nodes = (1..).zip(&network.nodes).map(|(id, &(position, at)): (usize, _)| LayoutNode {
        at,
        id: id.to_string(),
        position: Some(position),
        ..LayoutNode::default()
    });
    let nodes = nodes.collect();
    let links = network.links.into_iter().enumerate();
    let edges = links.flat_map(|(index, link)| {
        let back = reversed(&link);
        [edge(2 * index + 1, link), edge(2 * index + 2, back)]
    });
    let background = background.iter().map(|curve| polyline(&curve.cubics).into()).collect();
    Layout { nodes, edges: edges.collect(), background, ..Layout::default() }
}

fn reversed(link: &Link) -> Link {
    let curve = link.curve.clone();
    let cubics = curve.cubics.iter().rev().map(CubicBezier::reversed).collect();
    Link { from: link.to, to: link.from, curve: Curve { cubics, ..curve } }
}

fn edge(id: usize, link: Link) -> LayoutEdge {
    let Curve { at, layer, cubics, .. } = link.curve;
    let mut edge = LayoutEdge {
        at,
        id: id.to_string(),
        origin: (link.from + 1).to_string(),
        destination: (link.to + 1).to_string(),
        shape: if join::is_straight(&cubics) { Shape::Straight } else { Shape::Cubics(cubics) },
        ..LayoutEdge::default()
    };
    // Layer 0 is the default layer.
    if layer != "0" {
        edge.tags.set("layer", &layer);
    }
    edge
}

/// Returns points of a curve to draw lines between.
fn polyline(cubics: &[CubicBezier]) -> Vec<DVec2> {
    let mut points: Vec<DVec2> =
        cubics.first().map(|cubic| cubic.control_points[0]).into_iter().collect();
    for cubic in cubics {
        let count = if join::is_straight(std::slice::from_ref(cubic)) { 1 } else { 12 };
        points.extend((1..=count).map(|index| cubic.position(f64::from(index) / f64::from(count))));
    }
    points
}
