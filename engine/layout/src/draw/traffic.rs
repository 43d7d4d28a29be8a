//! The single tracks of a certificate, drawn under the edges.

use glam::DVec2;
use regatta_base::svg::Svg;

use super::{INK, LEGEND, MARGIN, Map};
use crate::traffic::{Certificate, SectionKind};

/// A kind of single track on a map.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Band {
    Section,
    DeadEnd,
}

impl Band {
    const ALL: [Self; 2] = [Self::Section, Self::DeadEnd];

    fn of(kind: SectionKind) -> Self {
        match kind {
            SectionKind::DeadEnd => Self::DeadEnd,
            SectionKind::Through | SectionKind::Whole => Self::Section,
        }
    }

    fn colour(self) -> &'static str {
        match self {
            Self::Section => "#f5c451",
            Self::DeadEnd => "#ec7f86",
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Section => "single track",
            Self::DeadEnd => "dead end",
        }
    }
}

impl Map<'_> {
    /// Writes wide bands along the edges of all sections.
    pub(super) fn write_sections(&self, svg: &mut Svg, certificate: &Certificate) {
        let width = (3.5 * self.node_radius()).clamp(3.0, 14.0);
        for band in Band::ALL {
            let group = svg.element("g").fill("none").stroke(band.colour(), width);
            group.set("stroke-linecap", "round").set("stroke-linejoin", "round").open();
            let sections = certificate.sections.iter();
            for section in sections.filter(|section| Band::of(section.kind()) == band) {
                let paths = section.edges.iter().map(|&edge| &self.graph.edge(edge).path);
                let curves = paths.map(|path| {
                    let cubics = path.cubics().map(|cubic| cubic.control_points);
                    cubics.map(|points| points.map(|point| self.pixel(point)))
                });
                svg.element("path").curves(curves);
            }
            svg.close();
        }
    }

    /// Writes the meaning of the bands in the middle of the legend.
    pub(super) fn write_section_legend(&self, svg: &mut Svg) {
        let top = self.size.y - LEGEND;
        for (row, band) in (0..).map(f64::from).zip(Band::ALL) {
            let left = DVec2::new(0.5 * self.size.x - MARGIN, top + 16.0 + 16.0 * row);
            svg.rect(left - DVec2::new(28.0, 4.0), DVec2::new(24.0, 8.0)).fill(band.colour());
            svg.text(left + DVec2::new(0.0, 4.0)).fill(INK).content(band.name());
        }
    }
}
