//! The plots of the reports, as SVG.

use std::path::Path;

use plotters::coord::Shift;
use plotters::prelude::*;

use super::published::Pose;
use crate::failure::Failure;

/// Colours that colour-blind people can distinguish (Okabe and Ito).
const COLOURS: [RGBColor; 4] =
    [RGBColor(0, 114, 178), RGBColor(213, 94, 0), RGBColor(0, 158, 115), RGBColor(204, 121, 167)];

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// A named line through points.
pub struct Series {
    pub name: String,
    pub points: Vec<(f64, f64)>,
}

/// Draws a driven path and the heading along it, as the dissertation's figures of edge 34 do.
pub fn path(file: &Path, route: &[u32], poses: &[Pose]) -> Result<(), Failure> {
    let root = SVGBackend::new(file, (1100, 500)).into_drawing_area();
    root.fill(&WHITE)?;
    let (left, right) = root.split_horizontally(550);
    let start = (0.0, poses.first().map_or(0.0, |pose| pose[2]));
    let along = poses.windows(2).scan(start, |(distance, heading), pair| {
        *distance += (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
        // The difference is wrapped to half a turn, so that the line has no jump where the angle wraps.
        *heading += (pair[1][2] - *heading + 180.0).rem_euclid(360.0) - 180.0;
        Some((*distance, *heading))
    });
    let name = format!("route {route:?}");
    let line = Series { name: name.clone(), points: poses.iter().map(|pose| (pose[0], pose[1])).collect() };
    let heading = Series { name, points: along.collect() };
    chart(&left, "Driven path", ("x [m]", "y [m]"), &[line])?;
    chart(&right, "Heading along it", ("distance [m]", "θ [°]"), &[heading])?;
    root.present()?;
    Ok(())
}

/// Draws the durations over the fleet size on the left, and the cost of a tick over the fleet size on the right with both
/// axes logarithmic.
pub fn scaling(file: &Path, durations: &[Series], costs: &[Series]) -> Result<(), Failure> {
    let root = SVGBackend::new(file, (1100, 500)).into_drawing_area();
    root.fill(&WHITE)?;
    let (left, right) = root.split_horizontally(550);
    chart(&left, "Time for all robots to finish a route", ("robots", "time over that of one robot"), durations)?;
    chart(&right, "Cost of a tick", ("log10 robots", "log10 milliseconds"), costs)?;
    root.present()?;
    Ok(())
}

fn chart(area: &Area<'_>, caption: &str, axes: (&str, &str), series: &[Series]) -> Result<(), Failure> {
    let points = || series.iter().flat_map(|line| &line.points);
    let range = |values: &mut dyn Iterator<Item = f64>| {
        let (low, high) = values.fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(value), high.max(value)));
        let margin = ((high - low) * 0.06).max(0.05);
        low - margin..high + margin
    };
    let xs = range(&mut points().map(|point| point.0));
    let ys = range(&mut points().map(|point| point.1));
    let mut chart = ChartBuilder::on(area)
        .caption(caption, ("sans-serif", 20))
        .margin(14)
        .x_label_area_size(44)
        .y_label_area_size(60)
        .build_cartesian_2d(xs, ys)?;
    chart
        .configure_mesh()
        .x_desc(axes.0)
        .y_desc(axes.1)
        .light_line_style(WHITE)
        .label_style(("sans-serif", 13))
        .draw()?;
    for (line, colour) in series.iter().zip(COLOURS.iter().cycle()) {
        chart
            .draw_series(LineSeries::new(line.points.iter().copied(), colour.stroke_width(2)))?
            .label(&line.name)
            .legend(|(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2)));
        let few = line.points.len() <= 20;
        chart.draw_series(line.points.iter().filter(|_| few).map(|&point| Circle::new(point, 3, colour.filled())))?;
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.2))
        .label_font(("sans-serif", 13))
        .draw()?;
    Ok(())
}
