//! A plan of a fleet as SVG: edges as their exact curves, nodes, and the outlines of robots at
//! their true size, in millimetres at a scale, with a grid in metres, a scale bar and an arrow to
//! the north.

mod items;
mod plan;
#[cfg(test)]
mod tests;

use glam::Vec2;
use regatta_base::round;
use regatta_base::svg::Svg;
use regatta_interface::plan::{metres_text, round_step};
use regatta_plugin::Result;
use regatta_scene::camera::Bounds;
use regatta_scene::palette::Rgb;

pub use plan::Plan;

/// The maximum number of robots in a file.
const MAX_ROBOTS: usize = 200_000;
/// The longest side of a drawing whose scale isn't given, in millimetres: that of A3, less a
/// margin.
const LONGEST_MM: f32 = 380.0;
/// The margin around the drawing, and the height of the line below it, in millimetres.
const MARGIN: f32 = 10.0;
const FOOTER: f32 = 14.0;

/// Returns the default scale of a drawing, given its longest side in metres: 1, 2 or 5 times a
/// power of ten.
fn fitting_scale(metres: f32) -> f32 {
    round::up((metres * 1000.0 / LONGEST_MM).max(1.0) * 0.999) as f32
}

/// Returns the text of the file.
///
/// # Errors
/// If there are too many robots for a file that programs open.
pub fn draw(plan: &Plan<'_>) -> Result<String> {
    let robots = plan.frame.map_or(0, |frame| frame.len());
    if robots > MAX_ROBOTS {
        return Err(regatta_plugin::Error::new(format!(
            "{robots} robots are too many for an SVG; {MAX_ROBOTS} are possible"
        )));
    }
    let (low, size) = (plan.bounds.low, (plan.bounds.high - plan.bounds.low).max(Vec2::splat(0.1)));
    let scale = plan.scale.unwrap_or_else(|| fitting_scale(size.max_element()));
    // Millimetres of paper per metre.
    let per_metre = 1000.0 / scale;
    let paper = size * per_metre + Vec2::new(2.0 * MARGIN, 2.0 * MARGIN + FOOTER);
    let colours = plan.theme.colours();
    let mut svg = Svg::new(2);
    svg.document(paper, "mm").set("font-family", "sans-serif").open();
    svg.element("title").content(plan.title());
    svg.element("desc").content(format_args!(
        "Scale 1:{scale}; a unit is a millimetre of paper; the group 'plan' is in metres, x east \
         and y north"
    ));
    svg.background(hex(colours.floor));
    let top = MARGIN + size.y * per_metre;
    let (east, north) = (MARGIN - low.x * per_metre, top + low.y * per_metre);
    let down = -per_metre;
    let page_from_plan = format_args!("matrix({per_metre} 0 0 {down} {east:.4} {north:.4})");
    svg.element("g").set("id", "plan").set("transform", page_from_plan).open();
    svg.decimals = 4;
    draw_grid(&mut svg, plan, per_metre);
    items::draw_background(&mut svg, plan, per_metre);
    items::draw_edges(&mut svg, plan, per_metre);
    items::draw_closures(&mut svg, plan, per_metre);
    items::draw_facilities(&mut svg, plan, per_metre);
    items::draw_nodes(&mut svg, plan, per_metre);
    items::draw_stations(&mut svg, plan, per_metre);
    items::draw_names(&mut svg, plan, per_metre);
    items::draw_robots(&mut svg, plan, per_metre);
    svg.close();
    svg.decimals = 2;
    draw_footer(&mut svg, plan, paper, scale);
    Ok(svg.finish())
}

fn hex(colour: Rgb) -> String {
    format!("#{:06x}", colour.0)
}

/// Lines at round distances, some 15 mm apart on paper, with their coordinates.
fn draw_grid(svg: &mut Svg, plan: &Plan<'_>, per_metre: f32) {
    let Bounds { low, high } = plan.bounds;
    let colours = plan.theme.colours();
    let step = round_step(38.0 / per_metre);
    let (first, last) = ((low / step).ceil().as_ivec2(), (high / step).floor().as_ivec2());
    let xs = || (first.x..=last.x).map(|i| i as f32 * step);
    let ys = || (first.y..=last.y).map(|i| i as f32 * step);
    let stroke = hex(colours.grid);
    svg.element("g").set("id", "grid").stroke(stroke, 0.1 / per_metre).open();
    let columns = xs().map(|x| [Vec2::new(x, low.y), Vec2::new(x, high.y)]);
    let rows = ys().map(|y| [Vec2::new(low.x, y), Vec2::new(high.x, y)]);
    for [from, to] in columns.chain(rows) {
        svg.line(from, to);
    }
    svg.close();
    let group = svg.element("g").set("id", "coordinates").fill(hex(colours.node));
    group.number("font-size", 2.4 / per_metre).open();
    let below = xs().map(|x| (Vec2::new(x, low.y - 3.5 / per_metre), x, "middle"));
    let left = ys().map(|y| (Vec2::new(low.x - 1.0 / per_metre, y), y, "end"));
    for (Vec2 { x, y }, metres, anchor) in below.chain(left) {
        let upright = format_args!("translate({x:.3} {y:.3}) scale(1 -1)");
        let text = svg.element("text").set("transform", upright).set("text-anchor", anchor);
        text.content(metres_text(metres));
    }
    svg.close();
}

/// The line below the drawing: the title, the scale bar, and an arrow to the north.
fn draw_footer(svg: &mut Svg, plan: &Plan<'_>, paper: Vec2, scale: f32) {
    let colours = plan.theme.colours();
    let below = paper.y - 6.0;
    let metres = round_step(scale * 0.05);
    let bar = metres * 1000.0 / scale;
    let left = paper.x - MARGIN - bar - 16.0;
    let group = svg.element("g").set("id", "legend").fill(hex(colours.node));
    group.set("font-size", 3.2).open();
    svg.text(Vec2::new(MARGIN, below)).content(format_args!("{}   1:{scale}", plan.title()));
    for part in 0..4_u8 {
        let fill = if part % 2 == 0 { colours.node } else { colours.floor };
        let corner = Vec2::new(left + bar * f32::from(part) / 4.0, below - 1.6);
        let rect = svg.rect(corner, Vec2::new(bar / 4.0, 1.6));
        rect.fill(hex(fill)).stroke(hex(colours.node), 0.15);
    }
    let north = Vec2::new(paper.x - MARGIN - 3.0, below);
    let Vec2 { x, y } = north - Vec2::new(0.0, 8.0);
    svg.element("path").set("d", format_args!("M{x:.2} {y:.2}l2 7l-2 -1.6l-2 1.6z"));
    for (at, text) in [
        (Vec2::new(left, below - 2.6), "0"),
        (Vec2::new(left + bar, below - 2.6), &metres_text(metres)),
        (north + Vec2::new(0.0, 2.8), "N"),
    ] {
        svg.text(at).set("text-anchor", "middle").content(text);
    }
    svg.close();
}
