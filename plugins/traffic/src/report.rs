//! The figures of a run, as text, CSV and JSON.

use std::fmt::Write as _;
use std::path::Path;

use regatta_plugin::traffic::EdgeTraffic;
use regatta_plugin::{Error, Result, World};
use serde_json::json;

/// The number of edges in the summary.
const LISTED: usize = 10;

/// A figure of an edge.
type Figure = fn(&EdgeTraffic) -> f32;

/// The names of the figures in files, and their values.
pub const FIGURES: [(&str, Figure); 7] = [
    ("occupancy", |figures| figures.occupancy),
    ("entered_per_hour", |figures| figures.entered_per_hour),
    ("relative_speed", |figures| figures.relative_speed),
    ("waiting_secs", |figures| figures.waiting_secs),
    ("contact_secs", |figures| figures.contact_secs),
    ("released", |figures| figures.released),
    ("planned", |figures| figures.planned),
];

/// What a report says of an edge beside its figures.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Edge {
    /// The id of the edge in the route graph.
    pub id: u32,
    /// The ids of the nodes that it leads from and to.
    pub nodes: [u32; 2],
    /// Its name; empty if it has none.
    pub name: String,
}

/// Returns the edges of a world.
pub fn edges(world: &World<'_>) -> Vec<Edge> {
    let node = |index: u32| world.nodes().get(index as usize).map_or(u32::MAX, |node| node.id);
    let edge = |edge: &regatta_plugin::world::EdgeRecord| Edge {
        id: edge.id,
        nodes: [node(edge.origin), node(edge.destination)],
        name: world.text(edge.name).to_owned(),
    };
    world.edges().iter().map(edge).collect()
}

/// The figures of a run.
pub struct Report<'a> {
    /// Simulated seconds.
    pub secs: f64,
    /// The edges of the world.
    pub edges: &'a [Edge],
    /// By edge.
    pub figures: &'a [EdgeTraffic],
}

impl Report<'_> {
    /// The edges where robots waited the longest, as lines of text.
    pub fn summary(&self) -> String {
        let mut rows: Vec<(&Edge, &EdgeTraffic)> = self.edges.iter().zip(self.figures).collect();
        rows.sort_by(|a, b| b.1.waiting_secs.total_cmp(&a.1.waiting_secs));
        let waiting: f64 = self.figures.iter().map(|figures| f64::from(figures.waiting_secs)).sum();
        let mut text = format!("traffic in {:.0} s: robots waited for {waiting:.0} s\n", self.secs);
        for (edge, figures) in rows.into_iter().filter(|row| row.1.waiting_secs > 0.0).take(LISTED)
        {
            let EdgeTraffic {
                occupancy,
                entered_per_hour,
                relative_speed,
                waiting_secs,
                contact_secs,
                ..
            } = figures;
            let [from, to] = edge.nodes;
            let _ = writeln!(
                text,
                "edge {:>6} ({from} to {to}): waiting {waiting_secs:.0} s, {entered_per_hour:.0} robots/h, \
                 {occupancy:.2} at a time, {:.0} % of the speed limit, touching {contact_secs:.0} s",
                edge.id,
                100.0 * relative_speed
            );
        }
        text
    }

    /// All edges as CSV.
    pub fn csv(&self) -> String {
        let names = FIGURES.map(|(name, _)| name).join(",");
        let mut text = format!("edge,origin,destination,name,{names}\n");
        for (edge, figures) in self.edges.iter().zip(self.figures) {
            let ([from, to], name) = (edge.nodes, quoted(&edge.name));
            let values = FIGURES.map(|(_, figure)| figure(figures).to_string()).join(",");
            let _ = writeln!(text, "{},{from},{to},{name},{values}", edge.id);
        }
        text
    }

    /// All edges as JSON.
    pub fn json(&self) -> String {
        let edge = |(edge, figures): (&Edge, &EdgeTraffic)| {
            json!({
                "edge": edge.id, "origin": edge.nodes[0], "destination": edge.nodes[1], "name": edge.name,
                "occupancy": figures.occupancy, "entered_per_hour": figures.entered_per_hour,
                "relative_speed": figures.relative_speed, "waiting_secs": figures.waiting_secs,
                "contact_secs": figures.contact_secs, "released": figures.released, "planned": figures.planned,
            })
        };
        let edges: Vec<_> = self.edges.iter().zip(self.figures).map(edge).collect();
        format!("{:#}\n", json!({ "secs": self.secs, "edges": edges }))
    }
}

/// A field of CSV (RFC 4180).
fn quoted(text: &str) -> String {
    match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    }
}

/// Makes sure that a file can be written, before the run.
///
/// # Errors
/// If its folder doesn't exist or can't be written to.
pub fn check(path: &Path) -> Result {
    let written = std::fs::OpenOptions::new().append(true).create(true).open(path);
    written.map(drop).map_err(|error| failed(path, &error))
}

/// Writes a file.
///
/// # Errors
/// If it can't be written.
pub fn write(path: &Path, text: &str) -> Result {
    std::fs::write(path, text).map_err(|error| failed(path, &error))
}

/// The error of a file that can't be written.
pub fn failed(path: &Path, error: &std::io::Error) -> Error {
    Error::new(format_args!("can't write {} ({error}); choose another file", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_edges_come_first_and_names_may_be_anything() {
        let edges = [
            Edge { id: 5, nodes: [1, 2], name: "dock, \"north\"".to_owned() },
            Edge { id: 6, nodes: [2, 3], ..Edge::default() },
            Edge { id: 7, nodes: [3, 1], ..Edge::default() },
        ];
        let waiting = |secs: f32| EdgeTraffic {
            waiting_secs: secs,
            relative_speed: 0.5,
            ..EdgeTraffic::default()
        };
        let report = Report {
            secs: 60.0,
            edges: &edges,
            figures: &[waiting(3.0), waiting(0.0), waiting(9.0)],
        };
        let summary = report.summary();
        let lines: Vec<&str> = summary.lines().collect();
        assert_eq!(lines.len(), 3, "an edge where nobody waited isn't listed: {summary}");
        assert!(
            lines[0].contains("12 s") && lines[1].contains("edge      7 (3 to 1): waiting 9 s"),
            "{summary}"
        );
        let csv = report.csv();
        assert_eq!(csv.lines().nth(1), Some("5,1,2,\"dock, \"\"north\"\"\",0,0,0.5,3,0,0,0"));
        let json: serde_json::Value = serde_json::from_str(&report.json()).expect("JSON");
        assert_eq!((&json["secs"], &json["edges"][2]["waiting_secs"]), (&60.0.into(), &9.0.into()));
    }
}
