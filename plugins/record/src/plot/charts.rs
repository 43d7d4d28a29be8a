//! Charts of x, y, heading and speed over time, one below the other, and a band of what the robot
//! does.

use glam::DVec2;
use regatta_base::svg::Svg;
use regatta_plugin::activity::{Activity, Ground};

use super::axis::{Scale, label, range};
use super::svg::{Area, polyline};
use super::{Sample, Track};

/// The space between two charts, in pixels.
const GAP: f64 = 34.0;
/// The height of the band of activities, in pixels.
const BAND: f64 = 12.0;
/// The space above the band of activities, in pixels.
const BAND_GAP: f64 = 26.0;

/// A chart of one value over time.
struct Chart {
    name: &'static str,
    /// A colour that colour-blind readers can distinguish from the others (Okabe and Ito).
    colour: &'static str,
    value: fn(&Sample) -> f64,
    /// The smallest range of values to show.
    least: f64,
    /// Whether the value is an angle in degrees, which wraps around from 180 to -180, but is drawn
    /// without a jump.
    is_angle: bool,
}

const CHARTS: [Chart; 4] = [
    Chart {
        name: "x [m]",
        colour: "#0072b2",
        value: |sample| sample.position.x,
        least: 1.0,
        is_angle: false,
    },
    Chart {
        name: "y [m]",
        colour: "#d55e00",
        value: |sample| sample.position.y,
        least: 1.0,
        is_angle: false,
    },
    Chart {
        name: "θ [°]",
        colour: "#009e73",
        value: |sample| sample.theta.to_degrees(),
        least: 20.0,
        is_angle: true,
    },
    Chart {
        name: "speed [m/s]",
        colour: "#aa5f8d",
        value: |sample| sample.speed,
        least: 0.2,
        is_angle: false,
    },
];

/// Returns the colour of an activity.
fn colour(activity: Activity) -> String {
    format!("#{:06x}", activity.colour(Ground::Light))
}

pub(super) fn draw(svg: &mut Svg, area: Area, track: &Track) {
    let (start, end) = track.span();
    let times = Scale::new((start, end.max(start + 0.1)), (area.left, area.right));
    let room = area.height() - BAND - BAND_GAP - GAP * (CHARTS.len() - 1) as f64;
    let height = room / CHARTS.len() as f64;
    for (i, chart) in CHARTS.iter().enumerate() {
        let top = area.top + i as f64 * (height + GAP);
        chart.draw(svg, Area { top, bottom: top + height, ..area }, &times, track);
    }
    draw_activities(svg, Area { top: area.bottom - BAND, ..area }, &times, track);
    let ticks = times.ticks(64.0);
    for tick in &ticks {
        svg.text(DVec2::new(times.at(*tick), area.bottom + 18.0))
            .class("centre")
            .content(label(*tick, &ticks));
    }
    svg.text(DVec2::new(area.right, area.bottom + 36.0)).class("name right").content("time [s]");
}

impl Chart {
    fn draw(&self, svg: &mut Svg, area: Area, times: &Scale, track: &Track) {
        let lines: Vec<_> = track.segments.iter().map(|segment| self.line(segment)).collect();
        let (low, high) = range(lines.iter().flatten().map(|(_, value)| *value), self.least);
        let scale = Scale::new((low, high), (area.bottom, area.top));
        let quarters = self.is_angle && high - low > 150.0;
        let ticks =
            if quarters { scale.multiples(quarter_turns(high - low)) } else { scale.ticks(26.0) };
        area.rect(svg).class("panel");
        for tick in times.ticks(64.0) {
            let x = times.at(tick);
            svg.line(DVec2::new(x, area.top), DVec2::new(x, area.bottom)).class("grid");
        }
        for tick in &ticks {
            let y = scale.at(*tick);
            svg.line(DVec2::new(area.left, y), DVec2::new(area.right, y)).class("grid");
            svg.text(DVec2::new(area.left - 8.0, y + 4.0))
                .class("right")
                .content(label(*tick, &ticks));
        }
        area.rect(svg).class("frame");
        svg.text(DVec2::new(area.left, area.top - 9.0)).class("name").content(self.name);
        let style = format!("stroke: {}", self.colour);
        for line in &lines {
            let points = line.iter().map(|(time, value)| (times.at(*time), scale.at(*value)));
            let points: Vec<_> = points.map(DVec2::from).collect();
            polyline(svg, &points, "line").set("style", &style);
        }
    }

    /// Returns times and values of a segment. An angle continues beyond half a turn instead of
    /// wrapping around.
    fn line(&self, segment: &[Sample]) -> Vec<(f64, f64)> {
        let mut line: Vec<(f64, f64)> = Vec::with_capacity(segment.len());
        for sample in segment {
            let value = (self.value)(sample);
            let turns = match line.last() {
                Some((_, last)) if self.is_angle => ((last - value) / 360.0).round(),
                _ => 0.0,
            };
            line.push((sample.time, value + 360.0 * turns));
        }
        line
    }
}

/// Returns the distance of ticks for a range of angles, in degrees: a quarter turn, doubled until
/// there are few ticks.
fn quarter_turns(range: f64) -> f64 {
    let mut step = 90.0;
    while range / step > 5.0 {
        step *= 2.0;
    }
    step
}

/// Draws a band of the colours of activities, with a legend.
fn draw_activities(svg: &mut Svg, area: Area, times: &Scale, track: &Track) {
    for segment in &track.segments {
        for part in segment.chunk_by(|one, next| one.activity == next.activity) {
            let (left, right) = (times.at(part[0].time), times.at(part[part.len() - 1].time));
            if let Some(activity) = part[0].activity {
                // At least two pixels wide, so that a short activity is visible.
                let right = right.max(left + 2.0).min(area.right);
                Area { left, right, ..area }.rect(svg).fill(colour(activity));
            }
        }
    }
    svg.text(DVec2::new(area.left, area.top - 9.0)).class("name").content("activity");
    let mut left = area.left + 60.0;
    for activity in Activity::ALL {
        if track.samples().any(|sample| sample.activity == Some(activity)) {
            let (right, top, bottom) = (left + 10.0, area.top - 18.0, area.top - 8.0);
            Area { left, right, top, bottom }.rect(svg).fill(colour(activity));
            let name = activity.name();
            svg.text(DVec2::new(left + 15.0, area.top - 9.0)).class("about").content(name);
            left += 28.0 + 7.5 * name.len() as f64;
        }
    }
}
