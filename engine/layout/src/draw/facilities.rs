//! Doors and lifts on a map: a bar across the edges of a door, and the outline of a cabin.

use glam::DVec2;
use regatta_base::svg::Svg;

use super::Map;

/// The colour of doors and cabins, and of their names.
pub(super) const FACILITY: &str = "#9c5a1a";

/// Half the side in pixels of the outline of a cabin whose size isn't known.
const UNKNOWN_CABIN: f64 = 9.0;

impl Map<'_> {
    pub(super) fn write_facilities(&self, svg: &mut Svg) {
        for [start, end] in self.doors() {
            svg.line(start, end).stroke(FACILITY, 3.0);
        }
        for cabin in self.cabins {
            let outline = match cabin.footprint {
                Some(footprint) => footprint.outline().map(|corner| self.pixel(corner)),
                None => square(self.pixel(cabin.centre)),
            };
            let path = svg.element("path").fill(FACILITY).stroke(FACILITY, 2.0);
            path.set("fill-opacity", 0.15).polylines([outline]);
        }
    }

    /// Returns the ends of the bars of doors.
    pub(super) fn doors(&self) -> impl Iterator<Item = [DVec2; 2]> {
        let doors = self.graph.doors().iter();
        doors.map(|door| door.drawn_line(self.graph).map(|point| self.pixel(point)))
    }

    /// Returns the places of the names of doors and lifts, with the names.
    pub(super) fn facility_names(&self) -> impl Iterator<Item = (DVec2, &str)> {
        let doors = self.graph.doors().iter().map(|door| {
            let [start, end] = door.drawn_line(self.graph);
            (self.pixel((start + end) / 2.0), &*door.name)
        });
        let cabins = self.cabins.iter();
        doors.chain(cabins.map(|cabin| (self.pixel(cabin.centre), &*cabin.name)))
    }
}

fn square(centre: DVec2) -> [DVec2; 5] {
    let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (1.0, 1.0)];
    corners.map(|(x, y)| centre + DVec2::new(x, y) * UNKNOWN_CABIN)
}
