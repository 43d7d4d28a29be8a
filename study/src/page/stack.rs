//! Stacked bars over the number of robots, as SVG.

use plotters::prelude::*;

use super::chart::{DrawResult, label};
use super::hint::{Hint, add_hints, value};

/// The size in pixels.
const SIZE: (u32, u32) = (900, 420);
const FONT: (&str, i32) = ("sans-serif", 16);
/// The height of a line of the legend, and the x and the width of a name there.
const LEGEND_LINE: i32 = 22;
const FIRST_NAME: i32 = 82;
const NAME_WIDTH: i32 = 200;
const NAMES_IN_LINE: i32 = 4;

/// A bar at a number of robots.
pub(super) struct Bar {
    /// The number of robots.
    pub robots: u32,
    /// The parts, from below.
    pub parts: Vec<Part>,
}

/// A part of a bar.
pub(super) struct Part {
    /// The name.
    pub name: &'static str,
    /// The colour, which is the same in all pictures of a page.
    pub colour: RGBColor,
    /// The value.
    pub value: f64,
}

/// Returns the bars as SVG, with the unit of their values.
pub(super) fn stack(bars: &[Bar], unit: &str) -> String {
    let mut svg = String::new();
    // Drawing into a text fails only if the chart has no room, which its size is made for.
    let hints = draw(bars, unit, &mut svg).unwrap_or_default();
    add_hints(&mut svg, &hints);
    svg
}

fn draw(bars: &[Bar], unit: &str, svg: &mut String) -> DrawResult {
    let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let legend = bars.first().map_or(&[][..], |bar| &bar.parts);
    let lines = (legend.len() as i32 + NAMES_IN_LINE - 1) / NAMES_IN_LINE;
    let (above, root) = root.split_vertically(lines * LEGEND_LINE + 8);
    for (part, index) in legend.iter().zip(0..) {
        let x = FIRST_NAME + index % NAMES_IN_LINE * NAME_WIDTH;
        let y = 4 + index / NAMES_IN_LINE * LEGEND_LINE;
        above.draw(&Rectangle::new([(x, y + 6), (x + 14, y + 20)], part.colour.filled()))?;
        above.draw(&Text::new(part.name, (x + 20, y + 4), FONT))?;
    }
    let totals = bars.iter().map(|bar| bar.parts.iter().map(|part| part.value).sum::<f64>());
    let highest = totals.fold(0.0, f64::max).max(1e-9);
    let mut area = ChartBuilder::on(&root)
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(84)
        .build_cartesian_2d(0.0..bars.len().max(1) as f64, 0.0..highest * 1.04)?;
    area.configure_mesh()
        .x_desc("robots")
        .x_labels(0)
        .y_desc(unit)
        .y_label_formatter(&|y| label(*y))
        .label_style(FONT)
        .axis_desc_style(FONT)
        .light_line_style(WHITE)
        .bold_line_style(RGBColor(225, 230, 236))
        .disable_x_mesh()
        .draw()?;
    let mut hints = Vec::new();
    for (bar, at) in bars.iter().zip(0..) {
        let (mut below, x) = (0.0, f64::from(at));
        for part in &bar.parts {
            let corners = [(x + 0.15, below), (x + 0.85, below + part.value)];
            area.draw_series([Rectangle::new(corners, part.colour.filled())])?;
            let [(left, bottom), (right, top)] = corners.map(|corner| area.backend_coord(&corner));
            hints.push(Hint {
                corner: (left, top),
                size: (right - left, bottom - top),
                text: format!("{} robots: {}, {} {unit}", bar.robots, part.name, value(part.value)),
            });
            below += part.value;
        }
        let (left, bottom) = area.backend_coord(&(x + 0.5, 0.0));
        let style = FONT.into_text_style(&root).pos(plotters::style::text_anchor::Pos::new(
            plotters::style::text_anchor::HPos::Center,
            plotters::style::text_anchor::VPos::Top,
        ));
        let corner = root.get_base_pixel();
        let place = (left - corner.0, bottom - corner.1 + 6);
        root.draw_text(&bar.robots.to_string(), &style, place)?;
    }
    root.present()?;
    Ok(hints)
}

#[cfg(test)]
mod tests {
    use super::super::chart::COLOURS;
    use super::*;

    #[test]
    fn each_part_of_each_bar_is_drawn_and_named() {
        let part = |name, at: usize, value| Part { name, colour: COLOURS[at], value };
        let parts = || vec![part("fetching", 0, 30.0), part("handling", 1, 10.0)];
        let bar = |robots| Bar { robots, parts: parts() };
        let svg = stack(&[bar(17), bar(42)], "seconds");
        let filled = |colour: &str| svg.matches(&format!("fill=\"{colour}\"")).count();
        // Two bars and the legend.
        assert_eq!((filled("#0072B2"), filled("#D55E00")), (3, 3), "{svg}");
        for text in ["\n17\n", "\n42\n", "\nfetching\n", "\nhandling\n", "\nseconds\n"] {
            assert!(svg.contains(text), "{text}: {svg}");
        }
        assert!(svg.contains("<title>42 robots: handling, 10.0 seconds</title>"), "{svg}");
        assert!(stack(&[], "seconds").trim_end().ends_with("</svg>"));
    }
}
