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

/// The identity of an edge in a report.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Edge {
    /// The id of the edge in the route graph.
    pub id: u32,
    /// The id of the node at which it starts.
    pub origin: u32,
    /// The id of the node at which it ends.
    pub destination: u32,
    /// Its name; empty if it has none.
    pub name: String,
}

/// Returns the edges of a world.
pub fn edges(world: &World<'_>) -> Vec<Edge> {
    world
        .edges()
        .iter()
        .map(|edge| Edge {
            id: edge.id,
            origin: node_id(world, edge.origin),
            destination: node_id(world, edge.destination),
            name: world.text(edge.name).to_owned(),
        })
        .collect()
}

fn node_id(world: &World<'_>, index: u32) -> u32 {
    world.nodes().get(index as usize).map_or(u32::MAX, |node| node.id)
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
    /// Describes the edges at which robots waited the longest, as lines of text.
    pub fn summary(&self) -> String {
        let mut rows: Vec<(&Edge, &EdgeTraffic)> = self.edges.iter().zip(self.figures).collect();
        rows.sort_by(|a, b| b.1.waiting_secs.total_cmp(&a.1.waiting_secs));
        let waiting: f64 = self.figures.iter().map(|figures| f64::from(figures.waiting_secs)).sum();
        let mut text = format!("traffic in {:.0} s: robots waited for {waiting:.0} s\n", self.secs);
        for (edge, figures) in rows.into_iter().filter(|row| row.1.waiting_secs > 0.0).take(LISTED)
        {
            let Edge { id, origin, destination, .. } = edge;
            let _ = writeln!(
                text,
                "edge {id:>6} ({origin} to {destination}): waiting {:.0} s, {:.0} robots/h, \
                 {:.2} at a time, {:.0} % of the speed limit, touching {:.0} s",
                figures.waiting_secs,
                figures.entered_per_hour,
                figures.occupancy,
                100.0 * figures.relative_speed,
                figures.contact_secs
            );
        }
        text
    }

    /// Writes all edges as CSV.
    pub fn csv(&self) -> String {
        let names = FIGURES.map(|(name, _)| name).join(",");
        let mut text = format!("edge,origin,destination,name,{names}\n");
        for (edge, figures) in self.edges.iter().zip(self.figures) {
            let (Edge { id, origin, destination, .. }, name) = (edge, quoted(&edge.name));
            let values = FIGURES.map(|(_, figure)| figure(figures).to_string()).join(",");
            let _ = writeln!(text, "{id},{origin},{destination},{name},{values}");
        }
        text
    }

    /// Writes all edges as JSON.
    pub fn json(&self) -> String {
        let mut edges = Vec::new();
        for (edge, figures) in self.edges.iter().zip(self.figures) {
            let Edge { id, origin, destination, name } = edge;
            let mut row = json!({
                "edge": id, "origin": origin, "destination": destination, "name": name,
            });
            for (name, figure) in FIGURES {
                row[name] = figure(figures).into();
            }
            edges.push(row);
        }
        format!("{:#}\n", json!({ "secs": self.secs, "edges": edges }))
    }
}

/// Returns a text as a field of CSV (RFC 4180).
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

/// Checks before the run that a file can be written.
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

/// Returns the error of a file that can't be written.
pub fn failed(path: &Path, error: &std::io::Error) -> Error {
    Error::new(format_args!("can't write {} ({error}); choose another file", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_edges_come_first_and_names_may_be_anything() {
        let edges = [
            Edge { id: 5, origin: 1, destination: 2, name: "dock, \"north\"".to_owned() },
            Edge { id: 6, origin: 2, destination: 3, ..Edge::default() },
            Edge { id: 7, origin: 3, destination: 1, ..Edge::default() },
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
