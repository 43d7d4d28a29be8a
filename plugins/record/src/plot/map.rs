//! Draws the driven path over the route graph.

use super::axis::{Scale, label, range};
use super::svg::{Area, Point, Svg};
use super::track::Track;

/// The margin around the path, as a fraction of its extent.
const MARGIN: f64 = 0.12;
/// The smallest extent that is shown, in metres.
const LEAST_EXTENT: f64 = 8.0;

pub(super) fn draw(svg: &mut Svg, area: Area, track: &Track) {
    let view = View::new(area, track);
    svg.text((area.left, area.top - 9.0), "name", "driven path [m]");
    svg.rect(area, "panel");
    view.grid(svg);
    svg.clipped(area, |svg| {
        let curves = track
            .curves
            .iter()
            .map(|curve| curve.control_points.map(|[x, y]| view.at(x.into(), y.into())));
        curves.filter(|curve| view.may_show(curve)).for_each(|curve| svg.curve(curve, "edge"));
        for segment in &track.segments {
            let points: Vec<_> = segment.iter().map(|sample| view.at(sample.x, sample.y)).collect();
            svg.polyline(&points, "path", "");
        }
    });
    svg.rect(area, "frame");
    draw_times(svg, &view, track);
    if let (Some(first), Some(last)) = (track.samples().next(), track.samples().next_back()) {
        svg.circle(view.at(first.x, first.y), 6.0, "start");
        svg.arrow(view.at(last.x, last.y), last.theta, "end");
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
        let (west, east) = range(track.samples().map(|sample| sample.x), LEAST_EXTENT);
        let (south, north) = range(track.samples().map(|sample| sample.y), LEAST_EXTENT);
        let metres_per_pixel =
            ((east - west) / area.width()).max((north - south) / area.height()) * (1.0 + MARGIN);
        let around = |(low, high): (f64, f64), pixels: f64| {
            let (middle, half) = (f64::midpoint(low, high), pixels * metres_per_pixel / 2.0);
            (middle - half, middle + half)
        };
        Self {
            area,
            x: Scale::new(around((west, east), area.width()), (area.left, area.right)),
            y: Scale::new(around((south, north), area.height()), (area.bottom, area.top)),
        }
    }

    fn at(&self, x: f64, y: f64) -> Point {
        (self.x.at(x), self.y.at(y))
    }

    /// Whether a curve may be visible: it isn't if all its control points are beyond the same side
    /// of the area.
    fn may_show(&self, curve: &[Point; 4]) -> bool {
        let Area { left, top, right, bottom } = self.area;
        let beside = curve.iter().all(|(x, _)| *x < left) || curve.iter().all(|(x, _)| *x > right);
        let above_or_below =
            curve.iter().all(|(_, y)| *y < top) || curve.iter().all(|(_, y)| *y > bottom);
        !beside && !above_or_below
    }

    fn grid(&self, svg: &mut Svg) {
        let Area { left, top, right, bottom } = self.area;
        // Both axes have the same step, so that the grid's cells are squares.
        let ticks = self.x.ticks(72.0);
        let step = ticks.get(1).map_or(1.0, |second| second - ticks[0]);
        for tick in &ticks {
            let x = self.x.at(*tick);
            svg.line((x, top), (x, bottom), "grid");
            svg.text((x, bottom + 18.0), "centre", &label(*tick, &ticks));
        }
        for tick in self.y.multiples(step) {
            let y = self.y.at(tick);
            svg.line((left, y), (right, y), "grid");
            svg.text((left - 8.0, y + 4.0), "right", &label(tick, &ticks));
        }
    }
}

/// Draws dots on the path at round times, with a label beside each dot where there is room.
fn draw_times(svg: &mut Svg, view: &View, track: &Track) {
    let (start, end) = track.span();
    let ticks = Scale::new((start, end.max(start + 0.1)), (0.0, 600.0)).ticks(50.0);
    let mut labelled: Vec<Point> = Vec::new();
    for tick in &ticks {
        let Some(sample) = track.samples().find(|sample| sample.time >= tick - 1e-6) else {
            continue;
        };
        let (x, y) = view.at(sample.x, sample.y);
        svg.circle((x, y), 3.5, "time");
        // The label goes to the right of the heading, or else to the left; it is left out if both
        // places are taken.
        let (sine, cosine) = sample.theta.sin_cos();
        let places =
            [1.0, -1.0].map(|side| (x + side * 22.0 * sine, y + side * 15.0 * cosine + 4.0));
        let is_free = |place: &&Point| {
            labelled.iter().all(|(x, y)| (x - place.0).abs() > 34.0 || (y - place.1).abs() > 14.0)
        };
        let Some(place) = places.iter().find(is_free) else { continue };
        let time = format!("{} s", label(*tick, &ticks));
        // The halo is drawn first; it keeps the text readable over lines.
        ["mark centre halo", "mark centre"].iter().for_each(|class| svg.text(*place, class, &time));
        labelled.push(*place);
    }
}

fn draw_legend(svg: &mut Svg, area: Area) {
    let y = area.top - 13.0;
    svg.circle((area.right - 120.0, y), 5.0, "start");
    svg.text((area.right - 110.0, y + 4.0), "about", "start");
    svg.arrow((area.right - 48.0, y), 0.0, "end");
    svg.text((area.right - 32.0, y + 4.0), "about", "end");
}
