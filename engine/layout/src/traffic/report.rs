//! A certificate in plain English: one line for each thing, with what would mend it.

use std::cmp::Reverse;

use regatta_base::graph::{EdgeIndex, Gear, NodeIndex};

use super::parts::{CutOff, Part};
use super::room::{Certainty, Count};
use super::sections::{Section, SectionKind};
use super::slow::{SlowLeg, WALK};
use super::stations::{BlockingStation, Effect};
use super::{Certificate, InTheWay};
use crate::model::route_graph::RouteGraph;
use crate::model::value::{duration, plural, shorten};

/// The largest number of nodes or edges that a line names.
const MOST_NAMES: usize = 6;

/// The subject of a remark.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case")]
pub enum Topic {
    /// The largest number of robots.
    UnderWay,
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
}

impl Certificate {
    /// Returns all lines about the graph that the certificate was made of, by topic; the longest
    /// sections first.
    pub fn remarks(&self, graph: &RouteGraph) -> Vec<Remark> {
        let writer = Writer { graph, certificate: self };
        let mut remarks = vec![writer.under_way()];
        remarks.extend(self.parts.iter().map(|part| writer.part(part)));
        remarks.extend(self.sections.iter().map(|section| writer.section(section)));
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
                let topic = remarks[0].topic.name().replace('-', " ");
                sentences.push(format!("And {more} more on the topic '{topic}'."));
            }
        }
        sentences
    }
}

struct Writer<'a> {
    graph: &'a RouteGraph,
    certificate: &'a Certificate,
}

impl Writer<'_> {
    fn node(&self, node: NodeIndex) -> String {
        let node = self.graph.node(node);
        node.name().map_or_else(|| node.id.to_string(), |name| format!("`{}`", shorten(name)))
    }

    fn nodes(&self, nodes: &[NodeIndex]) -> String {
        listed(nodes.len(), nodes.iter().map(|&node| self.node(node)))
    }

    fn edge(&self, edge: EdgeIndex) -> String {
        let edge = self.graph.edge(edge);
        edge.name().map_or_else(|| edge.id.to_string(), |name| format!("`{}`", shorten(name)))
    }

    fn under_way(&self) -> Remark {
        let most = self.certificate.under_way;
        let exact = match most.at_nodes.certainty {
            Certainty::Exact => "",
            Certainty::Bound => " (a bound)",
        };
        let message = format!(
            "at most {} of the main part can be under way while they stop at nodes only{exact}; \
             wherever they stop, no more than {} fit on its roads (a bound); more robots need more \
             roads",
            plural(most.at_nodes.robots as usize, "robot"),
            most.anywhere
        );
        Remark { robots: Some(most.at_nodes), ..Remark::new(Topic::UnderWay, message) }
    }

    fn part(&self, part: &Part) -> Remark {
        let nodes = format!("{} ({})", plural(part.nodes.len(), "node"), self.nodes(&part.nodes));
        let problem = match part.cut_off {
            CutOff::CannotBeLeft => {
                "can't be left: robots of the main part that drive there don't come back; add an \
                 edge back, or allow reverse gear"
            }
            CutOff::CannotBeReached => {
                "can't be reached: robots only start there; add an edge from the main part"
            }
            CutOff::Apart => {
                "can't be reached and can't be left: no robot of the main part comes there; join \
                 the roads, or remove these"
            }
        };
        let stations = match part.stations.as_slice() {
            [] => String::new(),
            stations => format!(", with the stations {}", self.stations(stations)),
        };
        Remark::new(Topic::Part, format!("{nodes}{stations} {problem}")).about(&part.nodes)
    }

    fn stations(&self, nodes: &[NodeIndex]) -> String {
        listed(nodes.len(), nodes.iter().map(|&node| self.station_at(node)))
    }

    /// The names of the stations at a node; that of the node if they have none.
    fn station_at(&self, node: NodeIndex) -> String {
        match self.certificate.station_names.get(&node.0).map(Vec::as_slice) {
            None | Some([]) => self.node(node),
            Some(names) => {
                let quoted = names.iter().map(|name| format!("`{}`", shorten(name)));
                format!("{} (node {})", listed(names.len(), quoted), self.node(node))
            }
        }
    }

    fn section(&self, section: &Section) -> Remark {
        let Section { metres, at_nodes, in_line, .. } = section;
        let holds =
            format!("it holds {} at its nodes, {in_line} in line", counted(*at_nodes, "robot"));
        let (topic, message) = match section.kind() {
            SectionKind::Through => (
                Topic::Section,
                format!(
                    "single track of {metres:.1} m between {}: two robots can't pass each other, \
                     {holds}; let robots in from one side at a time, or add a passing place or a \
                     second track",
                    self.nodes(&section.ends)
                ),
            ),
            SectionKind::DeadEnd => (Topic::DeadEnd, self.dead_end(section, &holds)),
            SectionKind::Whole => (
                Topic::Section,
                format!(
                    "single track of {metres:.1} m without a passing place, {}: no two robots can \
                     ever pass each other, {holds}; add a passing place, or a second track",
                    self.nodes(&section.nodes)
                ),
            ),
        };
        let remark = Remark::new(topic, message).about(&section.nodes);
        let edges = section.edges.clone();
        Remark { edges, robots: Some(*at_nodes), metres: Some(*metres), ..remark }
    }

    fn dead_end(&self, section: &Section, holds: &str) -> String {
        let inside = match section.dead_ends.as_slice() {
            [] => section.nodes.as_slice(),
            ends => ends,
        };
        format!(
            "dead end of {:.1} m from {} to {}: {holds}, and who drives in last comes out first; \
             let robots in one at a time, or lead the road on",
            section.metres,
            self.nodes(&section.ends),
            self.nodes(inside)
        )
    }

    fn rings(&self) -> Vec<Remark> {
        let rings = &self.certificate.rings;
        let mut remarks = Vec::new();
        if let Some((a, b)) = rings.pair {
            let message = format!(
                "2 robots may wait for each other at {}, such as {} and {}: unless they can pass \
                 between nodes, one has to back off; let robots in from one side at a time",
                pairs_of_nodes(rings.pairs),
                self.node(a),
                self.node(b)
            );
            let robots = Some(Count { robots: 2, certainty: Certainty::Exact });
            remarks.push(Remark { robots, ..Remark::new(Topic::Ring, message).about(&[a, b]) });
        }
        remarks.extend(rings.smallest.iter().map(|ring| self.ring(ring)));
        if rings.certainty == Certainty::Bound {
            let message = "the search for rings was stopped: smaller ones may exist, and it isn't \
                           known that there are none";
            remarks.push(Remark::new(Topic::Ring, message.to_owned()));
        }
        remarks.extend(self.safe());
        remarks
    }

    /// The number of robots that is proved safe, if it is more than one.
    fn safe(&self) -> Option<Remark> {
        let robots = match self.certificate.safe_robots() {
            None => "any number of robots".to_owned(),
            Some(0 | 1) => return None,
            Some(robots) => format!("up to {robots} robots"),
        };
        let message = format!(
            "{robots} at nodes never all wait for each other, wherever they stand and go: nothing \
             to mend"
        );
        Some(Remark::new(Topic::Ring, message))
    }

    fn ring(&self, ring: &[NodeIndex]) -> Remark {
        let message = format!(
            "{} robots at {} close a ring: each waits for the next one; keep one of these nodes \
             free, or add a way out",
            ring.len(),
            self.nodes(ring)
        );
        let robots = Some(Count { robots: ring.len() as u32, certainty: Certainty::Exact });
        Remark { robots, ..Remark::new(Topic::Ring, message).about(ring) }
    }

    fn station(&self, station: &BlockingStation) -> Remark {
        let name = self.station_at(station.node);
        let effect = match station.effect {
            Effect::CutsOff(from, to) => format!(
                "no way leads from {} to {} meanwhile; move it to a bay beside the road, or add a \
                 way round",
                self.node(from),
                self.node(to)
            ),
            Effect::Detour => "others have to take another way; move it to a bay beside the road, \
                               or keep that way free"
                .to_owned(),
            Effect::Unknown => "it isn't known whether another way exists, as the search was \
                                stopped; move it to a bay beside the road"
                .to_owned(),
        };
        let message = format!("a robot at the station {name} blocks a through road: {effect}");
        Remark::new(Topic::Station, message).about(&[station.node])
    }

    fn in_the_way(&self, found: &InTheWay) -> Remark {
        let edges = listed(found.edges.len(), found.edges.iter().map(|&edge| self.edge(edge)));
        let message = format!(
            "a robot at node {} touches robots on {} {edges}, which {} there: stop elsewhere, or \
             move the roads apart",
            self.node(found.node),
            if found.edges.len() == 1 { "edge" } else { "edges" },
            if found.edges.len() == 1 { "doesn't end" } else { "don't end" },
        );
        let remark = Remark::new(Topic::InTheWay, message).about(&[found.node]);
        Remark { edges: found.edges.clone(), ..remark }
    }

    fn slow(&self, slow: &SlowLeg) -> Remark {
        let gear = match slow.leg.gear {
            Gear::Forward => "",
            Gear::Reverse => " in reverse gear",
        };
        let message = format!(
            "edge {}{gear} is driven at {} m/s, slower than a walk ({WALK} m/s): it takes {}; \
             check the speed and its unit",
            self.edge(slow.leg.edge),
            slow.speed,
            duration(slow.seconds)
        );
        Remark { edges: vec![slow.leg.edge], ..Remark::new(Topic::Slow, message) }
    }
}

/// Joins the first names of a list.
fn listed(count: usize, names: impl Iterator<Item = String>) -> String {
    let names: Vec<String> = names.take(MOST_NAMES).collect();
    let more = match count.saturating_sub(MOST_NAMES) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    names.join(", ") + &more
}

fn counted(count: Count, noun: &str) -> String {
    let number = plural(count.robots as usize, noun);
    match count.certainty {
        Certainty::Exact => number,
        Certainty::Bound => format!("at most {number}"),
    }
}

fn pairs_of_nodes(count: usize) -> String {
    if count == 1 { "1 pair of nodes".to_owned() } else { format!("{count} pairs of nodes") }
}
