//! Writers of layouts: they turn a [`RouteGraph`] into a text, and list the parts of the graph that
//! the format can't express.

pub mod lif;
pub(crate) mod nav2;
mod open_tcs;
pub(crate) mod regatta;

use std::borrow::Cow;
use std::collections::BTreeMap;

use regatta_base::bezier::CubicBezier;

use crate::model::format::{Format, Written};
use crate::model::route_graph::RouteGraph;

/// The largest number of straight segments for one cubic.
const MAX_SEGMENTS: f64 = 64.0;

/// The parts of a graph that a format can't express, with their numbers by description.
#[derive(Debug, Default)]
struct Losses(BTreeMap<Cow<'static, str>, usize>);

impl Losses {
    /// Counts one more loss. `message` begins with a plural, because it follows the number.
    fn add(&mut self, message: impl Into<Cow<'static, str>>) {
        self.add_many(1, message);
    }

    fn add_if(&mut self, is_lost: bool, message: &'static str) {
        self.add_many(usize::from(is_lost), message);
    }

    fn add_many(&mut self, count: usize, message: impl Into<Cow<'static, str>>) {
        if count > 0 {
            *self.0.entry(message.into()).or_default() += count;
        }
    }

    /// Returns one line for each kind of loss.
    fn into_lines(self) -> Vec<String> {
        let lines = self.0.into_iter().map(|(message, count)| match count {
            1 => format!("1 {}", singular(&message)),
            count => format!("{count} {message}"),
        });
        lines.collect()
    }
}

/// Returns a message about one thing, given one about several: its noun ends in `s`, and is its
/// first or second word; a verb may follow.
fn singular(message: &str) -> String {
    let mut words: Vec<&str> = message.split(' ').collect();
    let is_plural = |word: &&str| word.trim_end_matches(':').ends_with('s');
    let Some(noun) = words.iter().take(2).position(is_plural) else { return message.to_owned() };
    let without_s = words[noun].replacen("s:", ":", 1);
    words[noun] = without_s.strip_suffix('s').unwrap_or(&without_s);
    if let Some(verb) = words.get_mut(noun + 1) {
        *verb = singular_verb(verb);
    }
    words.join(" ")
}

fn singular_verb(verb: &str) -> &str {
    match verb {
        "have" => "has",
        "are" => "is",
        "prescribe" => "prescribes",
        "allow" => "allows",
        other => other,
    }
}

/// Returns the number of straight segments that approximate a cubic within a tolerance in metres.
fn segments(cubic: &CubicBezier, tolerance: f64) -> u32 {
    let bend = cubic.second_derivative(0.0).length().max(cubic.second_derivative(1.0).length());
    // The distance of a chord of a parameter interval h is at most h² |p''| / 8.
    (bend / (8.0 * tolerance)).sqrt().ceil().clamp(1.0, MAX_SEGMENTS) as u32
}

/// Whether a cubic is a straight segment with evenly spaced control points, within a tolerance in
/// metres.
fn is_straight(cubic: &CubicBezier, tolerance: f64) -> bool {
    let [start, .., end] = cubic.control_points;
    let even = CubicBezier::straight(start, end).control_points;
    cubic.control_points.iter().zip(even).all(|(point, even)| point.distance(even) <= tolerance)
}

/// The formats that have a writer.
pub const WRITTEN_FORMATS: [Format; 4] =
    [Format::Regatta, Format::Lif, Format::Nav2, Format::OpenTcs];

/// Writes a graph in a format; `None` if there is no writer for it.
///
/// ```
/// use regatta_layout::{Format, ReadOptions, parse, write};
///
/// let text = "id,x,y\nA,0,0\nB,10,0\n\nfrom,to,speed\nA,B,1\n";
/// let (graph, _) = parse(text, "road.csv", &ReadOptions::default())?;
/// let written = write(&graph, Format::Lif).expect("LIF has a writer");
/// let (again, _) = parse(&written.text, "road.json", &ReadOptions::default())?;
/// assert_eq!(again.edges()[0].path, graph.edges()[0].path);
/// assert!(write(&graph, Format::Dxf).is_none());
/// # Ok::<(), regatta_layout::GraphError>(())
/// ```
pub fn write(graph: &RouteGraph, format: Format) -> Option<Written> {
    match format {
        Format::Regatta => Some(regatta::write(graph)),
        Format::Lif => Some(lif::write(graph)),
        Format::Nav2 => Some(nav2::write(graph)),
        Format::OpenTcs => Some(open_tcs::write(graph)),
        Format::OpenRmf
        | Format::OpenRmfBuilding
        | Format::MovingAi
        | Format::Dxf
        | Format::Csv
        | Format::RosMap => None,
    }
}
