//! Draws the driven path over the route graph.

use glam::{DVec2, Vec2};
use regatta_base::svg::Svg;

use super::Track;
use super::axis::{Scale, label, range};
use super::svg::{Area, arrow, polyline};

/// The margin around the path, as a fraction of its extent.
const MARGIN: f64 = 0.12;
/// The smallest extent that is shown, in metres.
const LEAST_EXTENT: f64 = 8.0;

pub(super) fn draw(svg: &mut Svg, area: Area, track: &Track) {
    let view = View::new(area, track);
    svg.text(DVec2::new(area.left, area.top - 9.0)).class("name").content("driven path [m]");
    area.rect(svg).class("panel");
    view.grid(svg);
    svg.element("clipPath").set("id", "map").open();
    area.rect(svg);
    svg.close();
    svg.element("g").set("clip-path", "url(#map)").open();
    for record in &track.curves {
        let points = record.control_points.map(|point| view.at(Vec2::from(point).as_dvec2()));
        if view.may_show(&points) {
            svg.element("path").curves([[points]]).class("edge");
        }
    }
    for segment in &track.segments {
        let points: Vec<_> = segment.iter().map(|sample| view.at(sample.position)).collect();
        polyline(svg, &points, "path");
    }
    svg.close();
    area.rect(svg).class("frame");
    draw_times(svg, &view, track);
    if let (Some(first), Some(last)) = (track.samples().next(), track.samples().next_back()) {
        svg.circle(view.at(first.position), 6.0).class("start");
        arrow(svg, view.at(last.position), last.theta, "end");
    }
    draw_legend(svg, area);
}

/// The visible part of the map. Both axes have the same scale.
struct View {
    area: Area,
    x: Scale,
    y: Scale,
}

impl View {
    fn new(area: Area, track: &Track) -> Self {
        let (west, east) = range(track.samples().map(|sample| sample.position.x), LEAST_EXTENT);
        let (south, north) = range(track.samples().map(|sample| sample.position.y), LEAST_EXTENT);
        let metres_per_pixel =
            ((east - west) / area.width()).max((north - south) / area.height()) * (1.0 + MARGIN);
        let size = DVec2::new(area.width(), area.height()) * metres_per_pixel;
        let middle = DVec2::new(f64::midpoint(west, east), f64::midpoint(south, north));
        let (low, high) = (middle - size / 2.0, middle + size / 2.0);
        Self {
            area,
            x: Scale::new((low.x, high.x), (area.left, area.right)),
            y: Scale::new((low.y, high.y), (area.bottom, area.top)),
        }
    }

    /// Returns a position in pixels.
    fn at(&self, position: DVec2) -> DVec2 {
        DVec2::new(self.x.at(position.x), self.y.at(position.y))
    }

    /// Whether a curve may be visible: it isn't if all its control points are beyond the same side
    /// of the area.
    fn may_show(&self, curve: &[DVec2; 4]) -> bool {
        let Area { left, top, right, bottom } = self.area;
        let [a, b, c, d] = *curve;
        let (low, high) = (a.min(b).min(c.min(d)), a.max(b).max(c.max(d)));
        high.x >= left && low.x <= right && high.y >= top && low.y <= bottom
    }

    fn grid(&self, svg: &mut Svg) {
        let Area { left, top, right, bottom } = self.area;
        // Both axes have the same step, so that the grid's cells are squares.
        let ticks = self.x.ticks(72.0);
        let step = ticks.get(1).map_or(1.0, |second| second - ticks[0]);
        for tick in &ticks {
            let x = self.x.at(*tick);
            svg.line(DVec2::new(x, top), DVec2::new(x, bottom)).class("grid");
            svg.text(DVec2::new(x, bottom + 18.0)).class("centre").content(label(*tick, &ticks));
        }
        for tick in self.y.multiples(step) {
            let y = self.y.at(tick);
            svg.line(DVec2::new(left, y), DVec2::new(right, y)).class("grid");
            svg.text(DVec2::new(left - 8.0, y + 4.0)).class("right").content(label(tick, &ticks));
        }
    }
}

/// Draws dots on the path at round times, with a label beside each dot where there is room.
fn draw_times(svg: &mut Svg, view: &View, track: &Track) {
    let (start, end) = track.span();
    let ticks = Scale::new((start, end.max(start + 0.1)), (0.0, 600.0)).ticks(50.0);
    let mut labelled: Vec<DVec2> = Vec::new();
    for tick in &ticks {
        let Some(sample) = track.samples().find(|sample| sample.time >= tick - 1e-6) else {
            continue;
        };
        let point = view.at(sample.position);
        svg.circle(point, 3.5).class("time");
        // The label goes to the right of the heading, or else to the left; it is left out if both
        // places are taken.
        let (sine, cosine) = sample.theta.sin_cos();
        let offset = DVec2::new(22.0 * sine, 15.0 * cosine);
        let places = [offset, -offset].map(|offset| point + offset + DVec2::new(0.0, 4.0));
        let Some(place) = places.into_iter().find(|place| is_free(*place, &labelled)) else {
            continue;
        };
        let time = format!("{} s", label(*tick, &ticks));
        // The halo is drawn first; it keeps the text readable over lines.
        svg.text(place).class("mark centre halo").content(&time);
        svg.text(place).class("mark centre").content(&time);
        labelled.push(place);
    }
}

/// Whether a label has room at a place.
fn is_free(place: DVec2, labelled: &[DVec2]) -> bool {
    let mut distances = labelled.iter().map(|other| (place - other).abs());
    distances.all(|distance| distance.x > 34.0 || distance.y > 14.0)
}

fn draw_legend(svg: &mut Svg, area: Area) {
    let y = area.top - 13.0;
    svg.circle(DVec2::new(area.right - 120.0, y), 5.0).class("start");
    svg.text(DVec2::new(area.right - 110.0, y + 4.0)).class("about").content("start");
    arrow(svg, DVec2::new(area.right - 48.0, y), 0.0, "end");
    svg.text(DVec2::new(area.right - 32.0, y + 4.0)).class("about").content("end");
}
