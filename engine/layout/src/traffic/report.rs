//! A certificate in plain English: one line for each thing, with what would mend it.

mod names;
mod roads;
mod waits;

use std::cmp::Reverse;

use regatta_base::graph::{EdgeIndex, NodeIndex};

use self::names::Writer;
use super::Certificate;
use super::room::Count;
use super::sections::Section;
use crate::model::route_graph::RouteGraph;

/// The fewest sections without room that are told in one line.
const FEWEST_TOGETHER: usize = 2;

/// The subject of a remark.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case")]
pub enum Topic {
    /// The largest number of robots.
    UnderWay,
    /// The zones.
    Zone,
    /// A part that can't be reached or left.
    Part,
    /// A single-track section.
    Section,
    /// A single-track section with one end.
    DeadEnd,
    /// Robots that all wait for the next one.
    Ring,
    /// A station on a through road.
    Station,
    /// A node where a robot is in the way on other roads.
    InTheWay,
    /// A leg that is slower than a walk.
    Slow,
}

/// A line of a certificate.
#[derive(Clone, Debug, PartialEq)]
pub struct Remark {
    /// Its subject.
    pub topic: Topic,
    /// A sentence without a full stop.
    pub message: String,
    /// The nodes that it is about.
    pub nodes: Vec<NodeIndex>,
    /// The edges that it is about.
    pub edges: Vec<EdgeIndex>,
    /// The number of robots that it gives, if it gives one.
    pub robots: Option<Count>,
    /// The length that it gives in metres, if it gives one.
    pub metres: Option<f64>,
}

impl Topic {
    /// The name, in lower case with hyphens.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

impl Remark {
    /// Returns the message as a whole sentence.
    fn sentence(&self) -> String {
        let mut letters = self.message.chars();
        let first: String = letters.next().into_iter().flat_map(char::to_uppercase).collect();
        format!("{first}{}.", letters.as_str())
    }

    fn new(topic: Topic, message: String) -> Self {
        let (nodes, edges) = (Vec::new(), Vec::new());
        Self { topic, message, nodes, edges, robots: None, metres: None }
    }

    fn about(self, nodes: &[NodeIndex]) -> Self {
        Self { nodes: nodes.to_vec(), ..self }
    }

    fn on(self, edges: &[EdgeIndex]) -> Self {
        Self { edges: edges.to_vec(), ..self }
    }
}

impl Certificate {
    /// Returns all lines about the graph that the certificate was made of, by topic; the longest
    /// sections first, and those without room in one line.
    pub fn remarks(&self, graph: &RouteGraph) -> Vec<Remark> {
        let writer = Writer::new(graph, self);
        let mut remarks = vec![writer.under_way()];
        remarks.extend(writer.zones());
        remarks.extend(self.parts.iter().map(|part| writer.part(part)));
        remarks.extend(roads::unlinked_stations(graph));
        let (without_room, sections): (Vec<&Section>, Vec<&Section>) =
            self.sections.iter().partition(|section| section.is_without_room());
        remarks.extend(sections.into_iter().map(|section| writer.section(section)));
        if without_room.len() < FEWEST_TOGETHER {
            remarks.extend(without_room.into_iter().map(|section| writer.section(section)));
        } else {
            remarks.push(writer.without_room(&without_room));
        }
        remarks.extend(writer.rings());
        remarks.extend(self.stations.iter().map(|station| writer.station(station)));
        remarks.extend(self.in_the_way.iter().map(|found| writer.in_the_way(found)));
        remarks.extend(self.slow.iter().map(|slow| writer.slow(slow)));
        remarks.sort_by_key(|remark| {
            (remark.topic, Reverse((1000.0 * remark.metres.unwrap_or(0.0)) as u64))
        });
        remarks
    }
}

impl Certificate {
    /// Returns at most `most` [remarks](Self::remarks) about each topic as sentences, and one about
    /// the number of the others.
    pub fn sentences(&self, graph: &RouteGraph, most: usize) -> Vec<String> {
        let remarks = self.remarks(graph);
        let mut sentences = Vec::new();
        for remarks in remarks.chunk_by(|a, b| a.topic == b.topic) {
            sentences.extend(remarks.iter().take(most).map(Remark::sentence));
            if let Some(more @ 1..) = remarks.len().checked_sub(most) {
                sentences.push(format!(
                    "And {more} more like this; `regatta graph check LAYOUT --traffic` lists them."
                ));
            }
        }
        sentences
    }
}
