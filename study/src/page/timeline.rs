//! Lines over the time of a day, with the band between the least and the largest value over the
//! seeds, as SVG.

use plotters::prelude::*;

use super::chart::{COLOURS, DrawResult, label};
use super::hint::{Hint, add_hints, value};
use crate::answer::Spread;

/// The size in pixels.
const SIZE: (u32, u32) = (900, 360);
const FONT: (&str, i32) = ("sans-serif", 16);
/// The height of the legend, and the x and the width of a name there.
const LEGEND: i32 = 26;
const FIRST_NAME: i32 = 82;
const NAME_WIDTH: i32 = 200;
/// The opacity of a band.
const BAND: f64 = 0.2;
/// The most labels of the axis of time.
const MOST_LABELS: usize = 13;

/// A plot over the time of a day.
pub(super) struct Timeline<'a> {
    /// The label of the axis of time.
    pub x: &'a str,
    /// The label of the axis of values.
    pub y: &'a str,
    /// Hours at the beginning.
    pub begin_hours: f64,
    /// The length of a period, in hours.
    pub period_hours: f64,
    /// The lines.
    pub lines: Vec<Line>,
}

/// A line: a value for each period.
pub(super) struct Line {
    /// The name.
    pub name: &'static str,
    /// The values.
    pub values: Vec<Spread>,
}

/// Returns the plot as SVG.
pub(super) fn timeline(timeline: &Timeline<'_>) -> String {
    let mut svg = String::new();
    // Drawing into a text fails only if the plot has no room, which its size is made for.
    let hints = draw(timeline, &mut svg).unwrap_or_default();
    add_hints(&mut svg, &hints);
    svg
}

fn draw(plot: &Timeline<'_>, svg: &mut String) -> DrawResult {
    let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let (above, root) = root.split_vertically(LEGEND);
    for ((line, index), colour) in plot.lines.iter().zip(0..).zip(COLOURS.iter().cycle()) {
        let x = FIRST_NAME + index * NAME_WIDTH;
        above.draw(&PathElement::new([(x, 17), (x + 18, 17)], colour.stroke_width(2)))?;
        above.draw(&Text::new(line.name, (x + 24, 8), FONT))?;
    }
    let periods = plot.lines.iter().map(|line| line.values.len()).max().unwrap_or(0).max(1);
    let end_hours = plot.begin_hours + periods as f64 * plot.period_hours;
    let values = plot.lines.iter().flat_map(|line| &line.values);
    let highest = values.map(|value| value.most).fold(0.0, f64::max).max(1.0);
    let mut area = ChartBuilder::on(&root)
        .margin(12)
        .margin_right(28)
        .x_label_area_size(44)
        .y_label_area_size(70)
        .build_cartesian_2d(plot.begin_hours..end_hours, 0.0..highest * 1.06)?;
    area.configure_mesh()
        .x_desc(plot.x)
        .x_labels(MOST_LABELS)
        .y_desc(plot.y)
        .label_style(FONT)
        .axis_desc_style(FONT)
        .light_line_style(WHITE)
        .bold_line_style(RGBColor(225, 230, 236))
        .x_label_formatter(&|hours| clock(*hours))
        .y_label_formatter(&|y| label(*y))
        .draw()?;
    for (line, colour) in plot.lines.iter().zip(COLOURS.iter().cycle()) {
        let mut band = steps(plot, line, |value| value.most);
        band.extend(steps(plot, line, |value| value.least).into_iter().rev());
        area.draw_series([Polygon::new(band, colour.mix(BAND))])?;
        let mean = steps(plot, line, |value| value.interval.mean);
        area.draw_series(LineSeries::new(mean, colour.stroke_width(2)))?;
    }
    let mut hints = Vec::new();
    for period in 0..periods {
        let [from, to] =
            [period, period + 1].map(|index| plot.begin_hours + index as f64 * plot.period_hours);
        let (left, top) = area.backend_coord(&(from, highest));
        let (right, bottom) = area.backend_coord(&(to, 0.0));
        let text = format!("{} to {}: {}", clock(from), clock(to), in_words(plot, period));
        hints.push(Hint { corner: (left, top), size: (right - left, bottom - top), text });
    }
    root.present()?;
    Ok(hints)
}

/// The values of a period.
fn in_words(plot: &Timeline<'_>, period: usize) -> String {
    let mut texts = Vec::new();
    for line in &plot.lines {
        texts.extend(line.values.get(period).map(|spread| {
            let [mean, least, most] = [spread.interval.mean, spread.least, spread.most].map(value);
            format!("{} {mean} ({least} to {most})", line.name)
        }));
    }
    texts.join(", ")
}

/// Returns the corners of a line that keeps its value for each period.
fn steps(plot: &Timeline<'_>, line: &Line, value: fn(&Spread) -> f64) -> Vec<(f64, f64)> {
    let mut corners = Vec::new();
    for (spread, index) in line.values.iter().zip(0..) {
        let from = plot.begin_hours + f64::from(index) * plot.period_hours;
        corners.extend([from, from + plot.period_hours].map(|hours| (hours, value(spread))));
    }
    corners
}

/// Returns hours as a time of day.
pub(super) fn clock(hours: f64) -> String {
    let minutes = (hours * 60.0).round() as u64;
    format!("{:02}:{:02}", minutes / 60 % 24, minutes % 60)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::Interval;

    #[test]
    fn lines_bands_and_names_are_drawn() {
        let value = |mean: f64| Spread {
            interval: Interval { mean, half_width: None, values: 1 },
            least: mean - 1.0,
            most: mean + 1.0,
        };
        let line = |name| Line { name, values: [3.0, 9.0, 2.0].map(value).to_vec() };
        let lines = vec![line("released"), line("carried")];
        let plot =
            Timeline { x: "time of day", y: "orders", begin_hours: 22.0, period_hours: 1.0, lines };
        let svg = timeline(&plot);
        assert_eq!(
            (svg.matches("<polygon").count(), svg.matches("opacity=\"0.2\"").count()),
            (2, 2)
        );
        let hint = "<title>23:00 to 00:00: released 9.00 (8.00 to 10.0), carried";
        assert!(svg.contains(hint), "{svg}");
        for text in ["\nreleased\n", "\ncarried\n", "\ntime of day\n", "\n23:00\n", "\n00:00\n"] {
            assert!(svg.contains(text), "{text}: {svg}");
        }
    }
}
