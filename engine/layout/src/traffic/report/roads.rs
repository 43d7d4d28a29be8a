//! The lines about roads: parts, sections, slow legs, and how many robots fit.

use regatta_base::graph::{CRAWL, EdgeIndex, Gear};

use super::names::{Writer, robots};
use super::{Remark, Topic};
use crate::model::route_graph::RouteGraph;
use crate::model::value::{duration, plural};
use crate::traffic::main_part::{LeftOut, unlinked};
use crate::traffic::parts::{Cause, CutOff, Part};
use crate::traffic::room::Certainty;
use crate::traffic::sections::{Exchange, Section, SectionKind, Shape};
use crate::traffic::slow::{SlowLeg, WALK};

impl Writer<'_> {
    pub fn under_way(&self) -> Remark {
        let most = self.certificate.under_way;
        let bound = match most.at_nodes.certainty {
            _ if !self.certificate.zones.is_empty() => " (a bound: zones may allow fewer)",
            Certainty::Exact => "",
            Certainty::Bound => " (a bound)",
        };
        let message = match most.at_nodes.robots {
            0 => "no robot of the main part can be under way: no way leads from a node and back \
                  to it; add edges back, allow reverse gear, or raise speeds that are too slow"
                .to_owned(),
            robots => format!(
                "at most {} of the main part can be under way while they stop at nodes \
                 only{bound}: then one can drive on, and the others may have to wait; wherever \
                 they stop, no more than {} fit on its roads (a bound); more robots need more \
                 roads",
                plural(robots as usize, "robot"),
                most.anywhere
            ),
        };
        Remark { robots: Some(most.at_nodes), ..Remark::new(Topic::UnderWay, message) }
    }

    pub fn part(&self, part: &Part) -> Remark {
        let nodes = format!("{} ({})", plural(part.nodes.len(), "node"), self.nodes(&part.nodes));
        let stations = match part.stations.as_slice() {
            [] => String::new(),
            stations => format!(", with {},", self.stations(stations)),
        };
        let problem = match part.cut_off {
            CutOff::CannotBeLeft => {
                "without a way back to the main part: robots that drive there don't return"
            }
            CutOff::CannotBeReached => {
                "can't be reached from the main part: robots only come from there"
            }
            CutOff::Apart => {
                "without a way from or to the main part: no robot of the main part comes there"
            }
        };
        let remedy = match &part.cause {
            Cause::Missing => missing(part.cut_off).to_owned(),
            Cause::TooSlow(edges) => self.too_slow(edges),
        };
        Remark::new(Topic::Part, format!("{nodes}{stations} {problem}; {remedy}"))
            .about(&part.nodes)
    }

    fn too_slow(&self, edges: &[EdgeIndex]) -> String {
        let (edges, are_ways) = match edges {
            [] => ("edges near by".to_owned(), "are too slow to count as ways"),
            [_] => (self.edges(edges), "is too slow to count as a way"),
            _ => (self.edges(edges), "are too slow to count as ways"),
        };
        format!("{edges} {are_ways} (under {CRAWL} m/s): raise the speed")
    }

    pub fn section(&self, section: &Section) -> Remark {
        let Section { metres, at_nodes, in_line, .. } = section;
        let in_line = match section.shape {
            Shape::Path => format!(", {in_line} in line"),
            Shape::Tree | Shape::Ring => String::new(),
        };
        let holds = format!("it holds {} at its nodes{in_line}", robots(*at_nodes));
        let (topic, message) = match section.kind() {
            SectionKind::Through => (Topic::Section, self.through(section, &holds)),
            SectionKind::DeadEnd => (Topic::DeadEnd, self.dead_end(section, &holds)),
            SectionKind::Loop => (Topic::Section, self.with_ring(section, &holds)),
            SectionKind::Whole | SectionKind::Ring => {
                (Topic::Section, self.without_ends(section, &holds))
            }
        };
        let remark = Remark::new(topic, message).about(&section.nodes).on(&section.edges);
        Remark { robots: Some(*at_nodes), metres: Some(*metres), ..remark }
    }

    fn through(&self, section: &Section, holds: &str) -> String {
        let place = if section.shape == Shape::Path { "" } else { " on its tracks" };
        let ends = self.nodes(&section.ends);
        let track = match section.between_ends {
            Some(metres) if section.shape == Shape::Tree => {
                let branches = section.metres - metres;
                format!(
                    "single track of {metres:.1} m between {ends}, and {branches:.1} m beside it"
                )
            }
            _ => format!("single track of {} between {ends}", length(section)),
        };
        format!(
            "{track}: two robots can't pass each other{place}, {holds}; let robots in from one \
             side at a time, or add a passing place or a second track"
        )
    }

    fn dead_end(&self, section: &Section, holds: &str) -> String {
        let inside = match section.dead_ends.as_slice() {
            [] => section.nodes.as_slice(),
            ends => ends,
        };
        let order = match (section.shape, section.dead_ends.len()) {
            (Shape::Path, 1) => "and the last robot in is the first one out",
            _ => "and robots can't pass each other on its tracks",
        };
        format!(
            "dead end of {} from {} to {}: {holds}, {order}; let robots in one at a time, or lead \
             the road on",
            length(section),
            self.nodes(&section.ends),
            self.nodes(inside)
        )
    }

    fn with_ring(&self, section: &Section, holds: &str) -> String {
        format!(
            "single track of {} with a ring, from {}, by {}: two robots can't pass each other on \
             its tracks, {holds}; let robots drive the ring in one direction, or let them in one \
             at a time",
            length(section),
            self.nodes(&section.ends),
            self.nodes(&section.nodes)
        )
    }

    fn without_ends(&self, section: &Section, holds: &str) -> String {
        let can_pass = match (section.exchange, section.shape) {
            (Exchange::Never, _) => "no two robots can ever pass each other",
            (Exchange::Possible, Shape::Ring) => {
                "two robots can't pass each other on its tracks, they can exchange places only by \
                 driving round it"
            }
            (Exchange::Unknown, Shape::Ring) => {
                "two robots can't pass each other on its tracks, they can exchange places only by \
                 driving round it, if at all"
            }
            _ => "two robots can't pass each other on its tracks",
        };
        let remedy = match section.shape {
            Shape::Ring => "let robots drive it in one direction, add a passing place",
            Shape::Path | Shape::Tree => "add a passing place",
        };
        format!(
            "single track of {} without a passing place, {}: {can_pass}, {holds}; {remedy}, or a \
             second track",
            length(section),
            self.nodes(&section.nodes)
        )
    }

    /// The line about all sections in which no robot has room.
    pub fn without_room(&self, sections: &[&Section]) -> Remark {
        let lengths = sections.iter().map(|section| section.metres);
        let shortest = format!("{:.1}", lengths.clone().fold(f64::INFINITY, f64::min));
        let longest = format!("{:.1}", lengths.fold(0.0, f64::max));
        let metres = if shortest == longest { longest } else { format!("{shortest} to {longest}") };
        let message = format!(
            "{} of {metres} m hold no robot between their ends: two robots can't pass each other \
             there; let a robot in only if the node behind is free",
            plural(sections.len(), "single track"),
        );
        let edges: Vec<EdgeIndex> =
            sections.iter().flat_map(|section| &section.edges).copied().collect();
        Remark::new(Topic::Section, message).on(&edges)
    }

    pub fn slow(&self, slow: &SlowLeg) -> Remark {
        let gear = match slow.leg.gear {
            Gear::Forward => "",
            Gear::Reverse => " in reverse gear",
        };
        let limit = if slow.speed < CRAWL {
            format!("too slow to count as a way (under {CRAWL} m/s)")
        } else {
            format!("slower than a walk ({WALK} m/s)")
        };
        let message = format!(
            "edge {}{gear} is driven at {} m/s, {limit}: it takes {}; check the speed and its unit",
            self.edge(slow.leg.edge),
            slow.speed,
            duration(slow.seconds)
        );
        Remark::new(Topic::Slow, message).on(&[slow.leg.edge])
    }
}

/// The length of the tracks of a section, in words.
fn length(section: &Section) -> String {
    match section.shape {
        Shape::Path => format!("{:.1} m", section.metres),
        Shape::Tree | Shape::Ring => format!("{:.1} m in all", section.metres),
    }
}

/// Tells the stations without a node, if there are some.
pub fn unlinked_stations(graph: &RouteGraph) -> Option<Remark> {
    let stations = unlinked(graph);
    if stations.is_empty() {
        return None;
    }
    let left_out = LeftOut { cut_off: None, stations, other_nodes: Vec::new() };
    let message = format!("{left_out}: no robot comes there; link it to a node of the roads");
    Some(Remark::new(Topic::Part, message))
}

fn missing(cut_off: CutOff) -> &'static str {
    match cut_off {
        CutOff::CannotBeLeft => "add an edge back, or allow reverse gear",
        CutOff::CannotBeReached => "add an edge from the main part",
        CutOff::Apart => "join the roads, or remove these",
    }
}
