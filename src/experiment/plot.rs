//! The plots of the reports, as SVG: rows of two charts.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::coord::ranged1d::{Ranged, ValueFormatter};
use plotters::prelude::*;
use regatta_study::page::COLOURS;

use crate::failure::Failure;

/// The size of a row of two charts in pixels.
const SIZE: (u32, u32) = (1100, 500);
/// The largest number of labels along x: those of a million robots are long.
const MAX_LABELS: usize = 8;
/// A series with at most this many points gets a dot at each.
const MAX_DOTS: usize = 20;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Canvas<'a, 'b, X, Y> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<X, Y>>;

/// A named line through points.
#[derive(Clone, Debug)]
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// Its points: x and y.
    pub points: Vec<(f64, f64)>,
}

/// The scale of the axes of a chart.
#[derive(Clone, Copy, Debug)]
pub enum Scale {
    /// Each axis has a linear scale of its own.
    Linear,
    /// Both axes have the same linear scale: a metre is as long along x as along y.
    Equal,
    /// Both axes are logarithmic. Only positive numbers have a place there.
    Logarithmic,
}

/// A chart: lines over common axes.
#[derive(Clone, Debug)]
pub struct Chart<'a> {
    /// Its title.
    pub caption: &'a str,
    /// The name of the x axis.
    pub x: &'a str,
    /// The name of the y axis.
    pub y: &'a str,
    /// The scale of both axes.
    pub scale: Scale,
    /// The lines.
    pub series: Vec<Series>,
}

/// Draws two charts side by side.
///
/// # Errors
/// If a chart can't be drawn.
pub fn side_by_side(left: &Chart<'_>, right: &Chart<'_>) -> Result<String, Failure> {
    grid(&[left, right])
}

/// Draws charts, two in a row.
///
/// # Errors
/// If a chart can't be drawn.
pub fn grid(charts: &[&Chart<'_>]) -> Result<String, Failure> {
    let mut svg = String::new();
    {
        let rows = charts.len().div_ceil(2).max(1);
        let size = (SIZE.0, SIZE.1 * rows as u32);
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        root.fill(&WHITE)?;
        for (area, chart) in root.split_evenly((rows, 2)).iter().zip(charts) {
            draw(area, chart)?;
        }
        root.present()?;
    }
    Ok(svg)
}

fn draw(area: &Area<'_>, chart: &Chart<'_>) -> Result<(), Failure> {
    let series = &chart.series;
    match chart.scale {
        Scale::Linear => {
            let (xs, ys) = (linear_range(xs(series)), linear_range(ys(series)));
            draw_series(builder(area, chart).build_cartesian_2d(xs, ys)?, chart, series)
        }
        Scale::Equal => {
            let (xs, ys) = equal_ranges(area, chart)?;
            draw_series(builder(area, chart).build_cartesian_2d(xs, ys)?, chart, series)
        }
        Scale::Logarithmic => {
            let (xs, ys) = (log_range(xs(series)).log_scale(), log_range(ys(series)).log_scale());
            let positive: Vec<_> = series.iter().map(with_positive_points).collect();
            draw_series(builder(area, chart).build_cartesian_2d(xs, ys)?, chart, &positive)
        }
    }
}

/// Returns ranges along which a metre has the same length.
fn equal_ranges(area: &Area<'_>, chart: &Chart<'_>) -> Result<(Range<f64>, Range<f64>), Failure> {
    let (mut x_range, mut y_range) =
        (linear_range(xs(&chart.series)), linear_range(ys(&chart.series)));
    let (width, height) = size_without_labels(area, chart)?;
    let metres_per_pixel = ((x_range.end - x_range.start) / f64::from(width))
        .max((y_range.end - y_range.start) / f64::from(height));
    for (range, pixels) in [(&mut x_range, width), (&mut y_range, height)] {
        let (middle, half) =
            ((range.start + range.end) / 2.0, metres_per_pixel * f64::from(pixels) / 2.0);
        *range = middle - half..middle + half;
    }
    Ok((x_range, y_range))
}

fn with_positive_points(line: &Series) -> Series {
    let points = line.points.iter().copied().filter(|(x, y)| *x > 0.0 && *y > 0.0);
    Series { name: line.name.clone(), points: points.collect() }
}

/// Returns the size in pixels that a chart has for its lines, by building one elsewhere: the ranges
/// make no difference to it.
fn size_without_labels(area: &Area<'_>, chart: &Chart<'_>) -> Result<(u32, u32), Failure> {
    let mut svg = String::new();
    let elsewhere = SVGBackend::with_string(&mut svg, area.dim_in_pixel()).into_drawing_area();
    let canvas = builder(&elsewhere, chart).build_cartesian_2d(0.0..1.0, 0.0..1.0)?;
    Ok(canvas.plotting_area().dim_in_pixel())
}

fn xs(series: &[Series]) -> impl Iterator<Item = f64> {
    series.iter().flat_map(|line| &line.points).map(|point| point.0)
}

fn ys(series: &[Series]) -> impl Iterator<Item = f64> {
    series.iter().flat_map(|line| &line.points).map(|point| point.1)
}

/// Returns the smallest and the largest number; `None` without any.
fn extent(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|value| value.is_finite()).fold(None, |extent, value| {
        let (low, high) = extent.unwrap_or((value, value));
        Some((low.min(value), high.max(value)))
    })
}

/// Returns a range with a margin around all numbers. It is never empty: dividing an empty axis
/// would not end.
fn linear_range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = extent(values).unwrap_or((0.0, 1.0));
    let margin = ((high - low) * 0.06).max(0.05);
    low - margin..high + margin
}

/// Returns a range around all positive numbers that includes a power of ten at both ends, and is
/// never empty.
fn log_range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = extent(values.filter(|value| *value > 0.0)).unwrap_or((1.0, 1.0));
    let (low, high) = (low.log10().floor(), high.log10().ceil());
    // A little more, so that rounding doesn't exclude the powers themselves.
    10f64.powf(low) * 0.95..10f64.powf(high.max(low + 1.0)) * 1.05
}

fn builder<'a, 'b>(area: &'a Area<'b>, chart: &Chart<'_>) -> ChartBuilder<'a, 'b, SVGBackend<'b>> {
    let mut builder = ChartBuilder::on(area);
    builder
        .caption(chart.caption, ("sans-serif", 20))
        .margin(14)
        .x_label_area_size(44)
        .y_label_area_size(64);
    builder
}

fn draw_series<'a, 'b: 'a, X, Y>(
    mut canvas: Canvas<'a, 'b, X, Y>,
    chart: &Chart<'_>,
    series: &[Series],
) -> Result<(), Failure>
where
    X: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    canvas
        .configure_mesh()
        .x_desc(chart.x)
        .y_desc(chart.y)
        .x_labels(MAX_LABELS)
        .x_label_formatter(&|value| plain(*value))
        .y_label_formatter(&|value| plain(*value))
        .light_line_style(WHITE)
        .label_style(("sans-serif", 13))
        .draw()?;
    for (number, (line, colour)) in series.iter().zip(COLOURS.iter().cycle()).enumerate() {
        // Lines that others cover are wider, so that they can be seen below those.
        let wider = (series.len() - 1 - number) as u32 / 2;
        canvas
            .draw_series(LineSeries::new(
                line.points.iter().copied(),
                colour.stroke_width(2 + wider),
            ))?
            .label(&line.name)
            .legend(|(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2)));
        let dots = line.points.iter().filter(|_| line.points.len() <= MAX_DOTS);
        canvas.draw_series(dots.map(|&point| Circle::new(point, 3 + wider, colour.filled())))?;
    }
    canvas
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.2))
        .label_font(("sans-serif", 13))
        .draw()?;
    Ok(())
}

/// Formats a number without an exponent: `1,000,000`, `0.5`, `0.001`.
fn plain(value: f64) -> String {
    if value.abs() < 1000.0 {
        let text = format!("{value:.4}");
        let text = text.trim_end_matches('0').trim_end_matches('.');
        return if text == "-0" { "0".to_owned() } else { text.to_owned() };
    }
    let digits = format!("{:.0}", value.abs());
    let mut text = String::from(if value < 0.0 { "-" } else { "" });
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(scale: Scale, series: Vec<Series>) -> Chart<'static> {
        Chart { caption: "Driven path", x: "x", y: "y", scale, series }
    }

    #[test]
    fn numbers_on_axes_are_plain() {
        for (value, text) in [
            (0.0, "0"),
            (0.1 + 0.2, "0.3"),
            (-5.0, "-5"),
            (0.001, "0.001"),
            (999.5, "999.5"),
            (1000.0, "1,000"),
            (-12_345.0, "-12,345"),
            (1e6, "1,000,000"),
        ] {
            assert_eq!(plain(value), text);
        }
    }

    #[test]
    fn every_series_has_a_colour_of_its_own_and_a_name_in_the_legend() {
        let line = |number: u32| Series {
            name: format!("series {number}"),
            points: vec![(1.0, f64::from(number)), (30.0, f64::from(2 * number))],
        };
        let series: Vec<_> = (1..=6).map(line).collect();
        let svg = side_by_side(
            &chart(Scale::Linear, series.clone()),
            &chart(Scale::Logarithmic, vec![line(7)]),
        )
        .expect("a plot");
        for (line, RGBColor(red, green, blue)) in series.iter().zip(COLOURS) {
            assert!(
                svg.contains(&line.name)
                    && svg.contains(&format!("#{red:02X}{green:02X}{blue:02X}")),
                "{svg}"
            );
        }
    }

    #[test]
    fn plots_of_nothing_and_of_impossible_numbers_end() {
        let nothing = Series { name: "none".into(), points: Vec::new() };
        let strange = [f64::NAN, f64::INFINITY, 0.0, -1.0]
            .map(|value| Series { name: "x".into(), points: vec![(value, value)] });
        let one_point = Series { name: "one".into(), points: vec![(2.0, 3.0)] };
        for scale in [Scale::Linear, Scale::Equal, Scale::Logarithmic] {
            for series in [vec![], vec![nothing.clone()], vec![one_point.clone()], strange.to_vec()]
            {
                let chart = chart(scale, series);
                side_by_side(&chart, &chart).expect("a plot");
            }
        }
    }

    #[test]
    fn a_metre_is_as_long_along_x_as_along_y() {
        let square = vec![(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)];
        let square = chart(Scale::Equal, vec![Series { name: "square".into(), points: square }]);
        let other = Chart { caption: "Heading", ..chart(Scale::Linear, vec![]) };
        let svg = side_by_side(&square, &other).expect("a plot");
        assert_eq!(svg.matches("Driven path").count(), 1, "each title is drawn once");
        let line = svg.split("<polyline").find(|part| part.contains("#0072B2")).expect("the path");
        let points = line
            .split("points=\"")
            .nth(1)
            .and_then(|rest| rest.split('"').next())
            .expect("its points");
        let points: Vec<Vec<i32>> = points
            .split_whitespace()
            .map(|point| point.split(',').map(|n| n.parse().expect("a pixel")).collect())
            .collect();
        let (right, up) = (points[1][0] - points[0][0], points[1][1] - points[2][1]);
        assert!((right - up).abs() <= 1 && right > 100, "{points:?}");
    }
}
