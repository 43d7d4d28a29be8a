//! Charts of x, y, heading and speed over time, one below the other, and a band of the robot's states.

use regatta_plugin::frame::RobotState;

use super::axis::{Scale, label, range};
use super::svg::{Area, Point, Svg};
use super::track::{Sample, Track};

/// The space between two charts, in pixels.
const GAP: f64 = 34.0;
/// The height of the band of states, in pixels.
const BAND: f64 = 12.0;
/// The space above the band of states, in pixels.
const BAND_GAP: f64 = 26.0;

/// A chart of one value over time.
struct Chart {
    name: &'static str,
    /// A colour that colour-blind readers can distinguish from the others (Okabe and Ito).
    colour: &'static str,
    value: fn(&Sample) -> f64,
    /// The smallest range of values to show.
    least: f64,
    /// Whether the value is an angle in degrees, which wraps around from 180 to -180.
    is_angle: bool,
}

const CHARTS: [Chart; 4] = [
    Chart { name: "x [m]", colour: "#0072b2", value: |sample| sample.x, least: 1.0, is_angle: false },
    Chart { name: "y [m]", colour: "#d55e00", value: |sample| sample.y, least: 1.0, is_angle: false },
    Chart {
        name: "θ [°]", colour: "#009e73", value: |sample| sample.theta.to_degrees(), least: 20.0, is_angle: true
    },
    Chart { name: "speed [m/s]", colour: "#aa5f8d", value: |sample| sample.speed, least: 0.2, is_angle: false },
];

const STATES: [(RobotState, &str, &str); 5] = [
    (RobotState::Idle, "idle", "#b8c2cc"),
    (RobotState::Driving, "driving", "#8fc9b5"),
    (RobotState::Waiting, "waiting", "#f0e442"),
    (RobotState::Held, "held", "#e69f00"),
    (RobotState::Faulted, "faulted", "#d55e00"),
];

pub(super) fn draw(svg: &mut Svg, area: Area, track: &Track) {
    let (start, end) = track.span();
    let times = Scale::new((start, end.max(start + 0.1)), (area.left, area.right));
    let room = area.height() - BAND - BAND_GAP - GAP * (CHARTS.len() - 1) as f64;
    let height = room / CHARTS.len() as f64;
    for (i, chart) in CHARTS.iter().enumerate() {
        let top = area.top + i as f64 * (height + GAP);
        chart.draw(svg, Area { top, bottom: top + height, ..area }, &times, track);
    }
    draw_states(svg, Area { top: area.bottom - BAND, ..area }, &times, track);
    let ticks = times.ticks(64.0);
    for tick in &ticks {
        svg.text((times.at(*tick), area.bottom + 18.0), "centre", &label(*tick, &ticks));
    }
    svg.text((area.right, area.bottom + 36.0), "name right", "time [s]");
}

impl Chart {
    fn draw(&self, svg: &mut Svg, area: Area, times: &Scale, track: &Track) {
        let values = || track.samples().map(self.value);
        let (low, high) = range(values(), self.least);
        // An angle that wraps around gets an axis of a full turn.
        let wraps = self.is_angle && high - low > 300.0;
        let bounds = if wraps { (-190.0, 190.0) } else { (low, high) };
        let scale = Scale::new(bounds, (area.bottom, area.top));
        let quarters = self.is_angle && bounds.1 - bounds.0 > 150.0;
        let ticks = if quarters { scale.multiples(90.0) } else { scale.ticks(26.0) };
        svg.rect(area, "panel");
        for tick in times.ticks(64.0) {
            svg.line((times.at(tick), area.top), (times.at(tick), area.bottom), "grid");
        }
        for tick in &ticks {
            let y = scale.at(*tick);
            svg.line((area.left, y), (area.right, y), "grid");
            svg.text((area.left - 8.0, y + 4.0), "right", &label(*tick, &ticks));
        }
        svg.rect(area, "frame");
        svg.text((area.left, area.top - 9.0), "name", self.name);
        let point = |sample: &Sample| (times.at(sample.time), scale.at((self.value)(sample)));
        let style = format!("stroke: {}", self.colour);
        for part in track.segments.iter().flat_map(|segment| self.unwrapped(segment)) {
            let points: Vec<Point> = part.iter().map(point).collect();
            svg.polyline(&points, "line", &style);
        }
    }

    /// Splits a segment where an angle wraps around.
    fn unwrapped<'s>(&self, segment: &'s [Sample]) -> impl Iterator<Item = &'s [Sample]> {
        let (value, is_angle) = (self.value, self.is_angle);
        segment.chunk_by(move |one, next| !is_angle || (value(next) - value(one)).abs() < 180.0)
    }
}

/// Draws a band of the states' colours, with a legend.
fn draw_states(svg: &mut Svg, area: Area, times: &Scale, track: &Track) {
    for segment in &track.segments {
        for part in segment.chunk_by(|one, next| one.state == next.state) {
            let [first, last] = [part[0], part[part.len() - 1]];
            if let Some((_, _, colour)) = STATES.iter().find(|(state, ..)| *state as u8 == first.state) {
                // At least two pixels wide, so that a short state is visible.
                let (left, right) = (times.at(first.time), times.at(last.time));
                svg.bar(Area { left, right: right.max(left + 2.0).min(area.right), ..area }, colour);
            }
        }
    }
    svg.text((area.left, area.top - 9.0), "name", "state");
    let seen = STATES.iter().filter(|(state, ..)| track.samples().any(|sample| sample.state == *state as u8));
    let mut left = area.left + 48.0;
    for (_, name, colour) in seen {
        svg.bar(Area { left, right: left + 10.0, top: area.top - 18.0, bottom: area.top - 8.0 }, colour);
        svg.text((left + 15.0, area.top - 9.0), "about", name);
        left += 28.0 + 7.5 * name.len() as f64;
    }
}
