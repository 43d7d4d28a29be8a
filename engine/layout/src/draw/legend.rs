//! The legend below a map: the scale, the counts and the colours of the speeds, and then rows of
//! keys: the signs of stations, and the matters of a certificate.

use std::collections::BTreeSet;

use glam::DVec2;
use regatta_base::round;
use regatta_base::svg::Svg;

use super::traffic::Matter;
use super::{INK, LEGEND, MARGIN, Map, SPEED_COLOURS};
use crate::model::tags::Role;
use crate::traffic::Certificate;

/// The height of a row of keys, the width of a key, and the radius of its badge, in pixels.
const ROW: f64 = 20.0;
const KEY: f64 = 200.0;
const BADGE: f64 = 7.0;

/// A symbol with its meaning.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Key {
    /// Stations of a role.
    Station(Role),
    /// A matter of a certificate.
    Matter(Matter),
}

impl Map<'_> {
    /// Returns the keys of what is drawn: the roles of stations first.
    pub(super) fn keys(&self, certificate: Option<&Certificate>) -> Vec<Key> {
        let roles = [Role::Pick, Role::Drop, Role::Transfer, Role::Park, Role::Charge];
        let drawn: BTreeSet<Role> = self.stations.iter().map(|station| station.role).collect();
        let roles = roles.into_iter().filter(|role| drawn.contains(role)).map(Key::Station);
        let matters = certificate.map_or_else(Vec::new, |certificate| self.found(certificate));
        roles.chain(matters.into_iter().map(Key::Matter)).collect()
    }

    /// The height of some keys in pixels: none if there are none.
    pub(super) fn height_of(&self, keys: &[Key]) -> f64 {
        match keys.len().div_ceil(self.keys_per_row()) {
            0 => 0.0,
            rows => ROW * rows as f64 + 8.0,
        }
    }

    /// Writes keys below the rest of the legend.
    pub(super) fn write_keys(&self, svg: &mut Svg, keys: &[Key]) {
        let per_row = self.keys_per_row();
        for (place, key) in keys.iter().enumerate() {
            let (row, column) = ((place / per_row) as f64, (place % per_row) as f64);
            let left = DVec2::new(MARGIN + KEY * column, self.size.y + ROW * row + 8.0);
            let name = match key {
                Key::Station(role) => {
                    let centre = left + DVec2::new(12.0, 0.0);
                    self.badge(BADGE).draw(svg, centre, role.sign(), role.name());
                    role.name()
                }
                Key::Matter(matter) => {
                    matter.write_symbol(svg, left);
                    matter.name()
                }
            };
            svg.text(left + DVec2::new(30.0, 4.0)).fill(INK).content(name);
        }
    }

    fn keys_per_row(&self) -> usize {
        (((self.size.x - MARGIN) / KEY).floor() as usize).max(1)
    }

    /// Writes the scale bar, the counts and the colours of the speeds.
    pub(super) fn write_legend(&self, svg: &mut Svg) {
        let (top, bar) = (self.size.y - LEGEND, round::down(120.0 / self.scale));
        let (line, end) = (top + 16.0, MARGIN + bar * self.scale);
        svg.line(DVec2::new(0.0, top), DVec2::new(self.size.x, top)).stroke("#d5dae0", 1);
        let ticks = [MARGIN, end].map(|x| [DVec2::new(x, line - 4.0), DVec2::new(x, line + 4.0)]);
        let scale = [[DVec2::new(MARGIN, line), DVec2::new(end, line)], ticks[0], ticks[1]];
        svg.element("path").fill("none").stroke(INK, 1.5).polylines(scale);
        svg.element("g").fill(INK).open();
        svg.text(DVec2::new(MARGIN, line + 18.0)).content(format_args!("{bar} m"));
        let (nodes, edges) = (self.graph.nodes().len(), self.graph.edges().len());
        let middle = DVec2::new(end.max(MARGIN + 60.0) + 24.0, line + 4.0);
        svg.text(middle).content(format_args!("{edges} edges, {nodes} nodes"));
        self.write_speeds(svg, DVec2::new(self.size.x - MARGIN, line));
        svg.close();
    }

    /// Writes the colours of the speeds, to the left of a point.
    fn write_speeds(&self, svg: &mut Svg, DVec2 { x: right, y }: DVec2) {
        let (slowest, fastest) = self.speeds;
        let fast = svg.text(DVec2::new(right, y + 4.0)).set("text-anchor", "end");
        fast.content(format_args!("{fastest} m/s"));
        if fastest > slowest {
            let left = right - 150.0;
            let slow = svg.text(DVec2::new(left, y + 4.0)).set("text-anchor", "end");
            slow.content(format_args!("{slowest} m/s"));
            for (class, colour) in (0..).map(f64::from).zip(SPEED_COLOURS) {
                let corner = DVec2::new(left + 8.0 + class * 18.0, y - 2.0);
                svg.rect(corner, DVec2::new(18.0, 4.0)).fill(colour);
            }
        }
    }
}
