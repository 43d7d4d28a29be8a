//! A certificate on a map: bands under the edges, and marks over them.

use std::collections::BTreeSet;

use glam::DVec2;
use regatta_base::graph::{CRAWL, EdgeIndex, NodeIndex};
use regatta_base::svg::Svg;

use super::Map;
use crate::traffic::{Certificate, SectionKind};

/// A matter of a certificate on a map, in the order in which they are drawn.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Matter {
    CutOff,
    Section,
    DeadEnd,
    TooSlow,
    BlockingStation,
    Ring,
}

/// The symbol of a matter.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Symbol {
    /// Along edges, and under nodes.
    Band,
    /// Around nodes.
    Circle,
}

impl Matter {
    const ALL: [Self; 6] = [
        Self::CutOff,
        Self::Section,
        Self::DeadEnd,
        Self::TooSlow,
        Self::BlockingStation,
        Self::Ring,
    ];

    fn of(kind: SectionKind) -> Self {
        match kind {
            SectionKind::DeadEnd => Self::DeadEnd,
            SectionKind::Through | SectionKind::Loop | SectionKind::Whole | SectionKind::Ring => {
                Self::Section
            }
        }
    }

    fn colour(self) -> &'static str {
        match self {
            Self::CutOff => "#c9cdd4",
            Self::Section => "#f5c451",
            Self::DeadEnd => "#ec7f86",
            Self::TooSlow => "#a9d3f5",
            Self::BlockingStation => "#d9480f",
            Self::Ring => "#b5179e",
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::CutOff => "cut off from the main part",
            Self::Section => "single track",
            Self::DeadEnd => "dead end",
            Self::TooSlow => "too slow to count as a way",
            Self::BlockingStation => "station in the way",
            Self::Ring => "robots that may all wait",
        }
    }

    /// Writes the symbol of the legend, to the right of a point.
    pub fn write_symbol(self, svg: &mut Svg, left: DVec2) {
        match self.symbol() {
            Symbol::Band => {
                let corner = left - DVec2::new(0.0, 4.0);
                svg.rect(corner, DVec2::new(24.0, 8.0)).fill(self.colour());
            }
            Symbol::Circle => {
                let circle = svg.circle(left + DVec2::new(12.0, 0.0), 5.0).fill("none");
                circle.stroke(self.colour(), 2.5);
            }
        }
    }

    fn symbol(self) -> Symbol {
        match self {
            Self::BlockingStation | Self::Ring => Symbol::Circle,
            _ => Symbol::Band,
        }
    }
}

impl Map<'_> {
    /// Writes wide bands along edges and under nodes.
    pub(super) fn write_bands(&self, svg: &mut Svg, certificate: &Certificate) {
        let width = (3.5 * self.node_radius()).clamp(3.0, 14.0);
        let found = self.found(certificate).into_iter();
        for matter in found.filter(|matter| matter.symbol() == Symbol::Band) {
            let group = svg.element("g").fill("none").stroke(matter.colour(), width);
            group.set("stroke-linecap", "round").set("stroke-linejoin", "round").open();
            let edges = self.edges(matter, certificate).into_iter();
            let curves = edges.map(|edge| {
                let cubics = self.graph.edge(edge).path.cubics().map(|cubic| cubic.control_points);
                cubics.map(|points| points.map(|point| self.pixel(point)))
            });
            svg.element("path").curves(curves);
            for node in nodes(matter, certificate) {
                svg.circle(self.at(node), 0.5 * width).fill(matter.colour());
            }
            svg.close();
        }
    }

    /// Writes circles around nodes, and the lines of the smallest ring.
    pub(super) fn write_marks(&self, svg: &mut Svg, certificate: &Certificate) {
        let ring = ring(certificate);
        if !ring.is_empty() {
            let corners = ring.iter().chain(ring.first()).map(|&node| self.at(node));
            let line = svg.element("path").fill("none").stroke(Matter::Ring.colour(), 2.0);
            line.set("stroke-dasharray", "6 4").polylines([corners]);
        }
        for (matter, more) in [(Matter::BlockingStation, 2.5), (Matter::Ring, 5.5)] {
            for node in nodes(matter, certificate) {
                let radius = self.reach(self.graph.node(node)) + more;
                let circle = svg.circle(self.at(node), radius);
                circle.fill("none").stroke(matter.colour(), 2.0);
            }
        }
    }

    /// The matters that a certificate has.
    pub(super) fn found(&self, certificate: &Certificate) -> Vec<Matter> {
        let mut found = Matter::ALL.to_vec();
        found.retain(|&matter| {
            !nodes(matter, certificate).is_empty() || !self.edges(matter, certificate).is_empty()
        });
        found
    }

    fn at(&self, node: NodeIndex) -> DVec2 {
        self.pixel(self.graph.node(node).position)
    }

    /// The edges that a matter is about.
    fn edges(&self, matter: Matter, certificate: &Certificate) -> Vec<EdgeIndex> {
        match matter {
            Matter::CutOff => self.edges_at(&nodes(matter, certificate)),
            Matter::Section | Matter::DeadEnd => {
                let sections = certificate.sections.iter();
                let sections = sections.filter(|section| Matter::of(section.kind()) == matter);
                sections.flat_map(|section| &section.edges).copied().collect()
            }
            Matter::TooSlow => {
                let slow = certificate.slow.iter().filter(|slow| slow.speed < CRAWL);
                slow.map(|slow| slow.leg.edge).collect()
            }
            Matter::BlockingStation | Matter::Ring => Vec::new(),
        }
    }

    /// The edges that start or end at some nodes.
    fn edges_at(&self, nodes: &[NodeIndex]) -> Vec<EdgeIndex> {
        let nodes: BTreeSet<NodeIndex> = nodes.iter().copied().collect();
        let edges = (0..).map(EdgeIndex).zip(self.graph.edges());
        let found = edges
            .filter(|(_, edge)| nodes.contains(&edge.origin) || nodes.contains(&edge.destination));
        found.map(|(index, _)| index).collect()
    }
}

/// The nodes that a matter is about.
fn nodes(matter: Matter, certificate: &Certificate) -> Vec<NodeIndex> {
    match matter {
        Matter::CutOff => certificate.parts.iter().flat_map(|part| &part.nodes).copied().collect(),
        Matter::BlockingStation => {
            certificate.stations.iter().map(|station| station.node).collect()
        }
        Matter::Ring => ring(certificate),
        Matter::Section | Matter::DeadEnd | Matter::TooSlow => Vec::new(),
    }
}

/// The nodes of the smallest ring of three robots or more; of two robots if there is none.
fn ring(certificate: &Certificate) -> Vec<NodeIndex> {
    let rings = &certificate.rings;
    match (rings.smallest.first(), rings.pair) {
        (Some(ring), _) => ring.clone(),
        (None, Some((a, b))) => vec![a, b],
        (None, None) => Vec::new(),
    }
}
