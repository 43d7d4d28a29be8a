//! Charts over the number of robots, as SVG.

use std::ops::Range;

use plotters::prelude::*;

use super::hint::{Hint, add_hints, value};
use crate::statistics::Interval;
use crate::words::{self, Kind};

/// Colours that colour-blind people can distinguish (Okabe and Ito), without the yellow that is
/// hard to see on white.
pub const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];
/// The size of a chart in pixels.
const SIZE: (u32, u32) = (900, 420);
const FONT: (&str, i32) = ("sans-serif", 16);
/// The height of a line of the legend, and the width of one of its letters, about, in pixels.
const LEGEND_LINE: i32 = 22;
const LETTER: i32 = 9;
/// The x of the first name in a line of the legend, above the axis.
const FIRST_NAME: i32 = 82;

/// A chart over the number of robots.
pub struct Chart<'a> {
    /// The things that the x axis counts.
    pub x: &'a str,
    /// The label of the y axis.
    pub y: &'a str,
    /// The lines.
    pub series: Vec<Series>,
    /// The number of robots at the knee, which gets a line.
    pub knee: Option<f64>,
    /// The largest value that is possible, if there is one; the least is 0.
    pub most: Option<f64>,
}

/// A line with error bars.
pub struct Series {
    /// Its name.
    pub name: String,
    /// The points, by ascending robots.
    pub points: Vec<ChartPoint>,
}

/// A mean at a number of robots.
#[derive(Clone, Copy, Debug)]
pub struct ChartPoint {
    /// The number of robots.
    pub robots: f64,
    /// The mean.
    pub mean: f64,
    /// Half of the width of its interval; 0 for no error bar.
    pub half_width: f64,
    /// Whether it isn't a figure of traffic: it gets a cross, and no line leads to it.
    pub is_stalled: bool,
}

impl ChartPoint {
    /// Returns the ends of its error bar.
    fn ends(&self, most: Option<f64>) -> [f64; 2] {
        words::ends(self.mean, self.half_width, most)
    }
}

/// Returns the chart as SVG.
pub fn chart(chart: &Chart<'_>) -> String {
    let mut svg = String::new();
    // Drawing into a text fails only if the chart has no room, which its size is made for.
    let hints = draw(chart, &mut svg).unwrap_or_default();
    add_hints(&mut svg, &hints);
    svg
}

/// The most labels of the axis of robots.
const MOST_LABELS: usize = 11;

/// The hints of a plot, or the reason why it has no room.
pub(super) type DrawResult = Result<Vec<Hint>, Box<dyn std::error::Error>>;

fn draw(chart: &Chart<'_>, svg: &mut String) -> DrawResult {
    let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let names: Vec<&str> = chart.series.iter().map(|series| series.name.as_str()).collect();
    let places = legend(&names);
    // Above the chart, where it hides no line.
    let (above, root) =
        root.split_vertically(places.iter().map(|(_, y)| y + LEGEND_LINE).max().unwrap_or(0));
    for ((name, (x, y)), colour) in names.iter().zip(places).zip(COLOURS.iter().cycle()) {
        above.draw(&PathElement::new([(x, y + 13), (x + 18, y + 13)], colour.stroke_width(2)))?;
        above.draw(&Text::new(*name, (x + 24, y + 4), FONT))?;
    }
    let points: Vec<&ChartPoint> = chart.series.iter().flat_map(|line| &line.points).collect();
    let xs = range(points.iter().map(|point| point.robots));
    // No label between two numbers of robots.
    let x_labels = MOST_LABELS.min(xs.end as usize + 1);
    let ys = range(points.iter().map(|point| point.ends(chart.most)[1]));
    let mut area = ChartBuilder::on(&root)
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(70)
        .build_cartesian_2d(xs, ys.clone())?;
    area.configure_mesh()
        .x_desc(chart.x)
        .x_labels(x_labels)
        .y_desc(chart.y)
        .label_style(FONT)
        .axis_desc_style(FONT)
        .light_line_style(WHITE)
        .bold_line_style(RGBColor(225, 230, 236))
        .x_label_formatter(&|x| format!("{x:.0}"))
        .y_label_formatter(&|y| label(*y))
        .draw()?;
    if let Some(knee) = chart.knee {
        let style = RGBColor(90, 104, 117).stroke_width(1);
        area.draw_series(DashedLineSeries::new([(knee, ys.start), (knee, ys.end)], 5, 4, style))?;
    }
    let mut hints = Vec::new();
    for (series, colour) in chart.series.iter().zip(COLOURS.iter().cycle()) {
        let (stalled, moving): (Vec<&ChartPoint>, Vec<&ChartPoint>) =
            series.points.iter().partition(|point| point.is_stalled);
        let line = moving.iter().map(|point| (point.robots, point.mean));
        area.draw_series(LineSeries::new(line.clone(), colour.stroke_width(2)))?;
        area.draw_series(line.map(|point| Circle::new(point, 3, colour.filled())))?;
        let crosses = stalled.iter().map(|point| (point.robots, point.mean));
        area.draw_series(crosses.map(|point| Cross::new(point, 6, colour.stroke_width(2))))?;
        let bars = moving.iter().filter(|point| point.half_width > 0.0);
        area.draw_series(bars.map(|point| {
            let ends = point.ends(chart.most).map(|end| (point.robots, end));
            PathElement::new(ends, colour.stroke_width(2))
        }))?;
        hints.extend(series.points.iter().map(|point| {
            let pixel = area.backend_coord(&(point.robots, point.mean));
            Hint::of_point(pixel, in_words(chart, series, point))
        }));
    }
    root.present()?;
    Ok(hints)
}

/// The text of a point under the pointer.
fn in_words(chart: &Chart<'_>, series: &Series, point: &ChartPoint) -> String {
    let ChartPoint { robots, mean, half_width, .. } = *point;
    let name =
        if series.name.is_empty() { String::new() } else { format!("{}, ", series.name.trim()) };
    let spread = Some(half_width).filter(|half_width| *half_width > 0.0);
    // Shares are parts of the largest value.
    let (kind, scale) = chart.most.map_or((Kind::Bounded, 1.0), |most| (Kind::Share, most));
    let interval =
        Interval { mean: mean / scale, half_width: spread.map(|half| half / scale), values: 1 };
    let text = words::in_words(&interval, kind, "", |part| value(part * scale));
    format!("{robots} {}: {name}{text} {}", chart.x, chart.y)
}

/// Returns the places of names in the legend, line by line; none if there is nothing to tell apart.
fn legend(names: &[&str]) -> Vec<(i32, i32)> {
    if names.iter().all(|name| name.is_empty()) {
        return Vec::new();
    }
    let (mut x, mut y) = (FIRST_NAME, 4);
    let mut places = Vec::new();
    for name in names {
        let width = 24 + LETTER * name.chars().count() as i32 + 20;
        if x > FIRST_NAME && x + width > SIZE.0 as i32 {
            (x, y) = (FIRST_NAME, y + LEGEND_LINE);
        }
        places.push((x, y));
        x += width;
    }
    places
}

/// Returns a range from 0 to a little above the largest value.
fn range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let largest = values.fold(0.0, f64::max);
    0.0..if largest > 0.0 { largest * 1.06 } else { 1.0 }
}

/// Returns the label of a tick of an axis: with two digits at least, as ticks have round steps.
pub(super) fn label(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let decimals = (1.0 - value.abs().log10().floor()).max(0.0) as usize;
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_tell_ticks_apart() {
        let labels = [0.0, 0.005, 0.045, 0.2, 2.5, 12.0, 1500.0].map(label);
        assert_eq!(labels, ["0", "0.0050", "0.045", "0.20", "2.5", "12", "1500"]);
    }

    #[test]
    fn a_chart_has_its_lines_bars_and_names() {
        let points = [(1.0, 10.0, 1.0), (2.0, 19.0, 0.0), (4.0, 30.0, 2.0), (8.0, 3.0, 9.0)]
            .map(|(robots, mean, half_width)| {
                let is_stalled = robots > 4.0;
                ChartPoint { robots, mean, half_width, is_stalled }
            })
            .to_vec();
        let one = Series { name: "a".to_owned(), points };
        let whole =
            Chart { x: "robots", y: "orders", series: vec![one], knee: Some(2.0), most: None };
        let svg = chart(&whole);
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"), "{svg}");
        assert_eq!(svg.matches("<circle").count(), 3);
        assert!(svg.contains("robots") && svg.contains("orders"), "{svg}");
        let hint = "<title>2 robots: a, 19.0 orders</title>";
        assert!(svg.contains(hint) && svg.contains(": a, 30.0 ± 2.00 orders"), "{svg}");
        assert!(svg.contains("\na\n"), "its name is in the legend: {svg}");
        let places = legend(&["a long name of a series of figures"; 4]);
        assert!(
            places.windows(2).all(|pair| pair[0] != pair[1])
                && places.iter().all(|(x, _)| *x < 700),
            "{places:?}"
        );
        let empty = chart(&Chart { series: Vec::new(), ..whole });
        assert!(empty.trim_end().ends_with("</svg>"));
    }
}
